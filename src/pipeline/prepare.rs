//! What a job becomes on the host before a ray is cast.

use crate::domain::{BoundingBox, Domain};
use crate::error::Result;
use crate::frame::check_limits;
use crate::geometry::Geometry;
use crate::job::{AxisChoice, Job};
use crate::lines::{Lines, check_n_cells, lines};
use crate::rays::Rays;
use crate::sources::{Source, geometries};

/// A job with its files, ready to be cast.
#[derive(Debug)]
pub struct Prepared {
    /// The geometries, in meshing order.
    pub geometries: Vec<Geometry>,
    /// The box.
    pub domain: Domain,
    /// The mesh lines.
    pub lines: Lines,
    /// The rays.
    pub rays: Rays,
}

/// Makes geometries, domain, lines and rays of a job.
///
/// # Errors
/// Those of [`Job::validate`], [`geometries`], [`Domain::new`], [`lines`], [`check_n_cells`], and the limits of
/// [`crate::frame::Frame::new`].
pub fn prepare(job: &Job, sources: Vec<Source>) -> Result<Prepared> {
    job.validate()?;
    let geometries = geometries(job, sources)?;
    let boxes: Vec<BoundingBox> = geometries.iter().filter_map(Geometry::bounding_box).collect();
    let domain = Domain::new(job, &boxes)?;
    let lines = lines(job, &domain)?;
    check_limits(&geometries, &lines)?;
    check_n_cells(job, &lines)?;
    let axis = match job.axis {
        AxisChoice::Auto => Rays::longest_axis(lines.dims),
        AxisChoice::X => 0,
        AxisChoice::Y => 1,
        AxisChoice::Z => 2,
    };
    Ok(Prepared { geometries, domain, lines, rays: Rays::new(axis, lines.dims) })
}
