//! What a job becomes on the host before a ray is cast.

use crate::domain::{BoundingBox, Domain};
use crate::error::{Error, Result};
use crate::frame::check_limits;
use crate::geometry::Geometry;
use crate::job::{AxisChoice, Job};
use crate::lines::{Lines, check_n_cells, lines};
use crate::parts::parts;
use crate::rays::Rays;
use crate::sources::{Source, geometries};

/// A job with its files, ready to be cast.
#[derive(Debug)]
pub struct Prepared {
    /// The geometries, in meshing order.
    pub geometries: Vec<Geometry>,
    /// The box.
    pub domain: Domain,
    /// The mesh lines of the whole box.
    pub whole: Lines,
    /// Those that are meshed, as cells of the whole box: the first, and the end, exclusive; None for all.
    pub window: Option<[[u32; 3]; 2]>,
    /// The mesh lines of the cells that are meshed.
    pub lines: Lines,
    /// The rays through these.
    pub rays: Rays,
}

/// Makes geometries, domain, lines and rays of a job.
///
/// # Errors
/// Those of [`Job::validate`], [`geometries`], [`Domain::new`], [`lines`], [`check_n_cells`], and the limits of
/// [`crate::frame::Frame::new`]; `job-value` where the window ends beyond the box; those of [`parts`].
pub fn prepare(job: &Job, sources: Vec<Source>) -> Result<Prepared> {
    job.validate()?;
    let geometries = geometries(job, sources)?;
    let boxes: Vec<BoundingBox> = geometries.iter().filter_map(Geometry::bounding_box).collect();
    let domain = Domain::new(job, &boxes)?;
    let whole = lines(job, &domain)?;
    check_limits(&geometries, &whole)?;
    let rays = |lines: &Lines| Rays::new(axis(job, lines), lines.dims);
    let window = match job.part {
        Some(part) => {
            let parts = parts(&geometries, &whole, &rays(&whole), part.of)?;
            parts.get((part.index as usize).wrapping_sub(1)).copied()
        }
        None => window(job, &whole)?,
    };
    let lines = window.map_or(whole, |cells| whole.window(cells));
    check_n_cells(job, &lines)?;
    Ok(Prepared { geometries, domain, whole, window, lines, rays: rays(&lines) })
}

/// The axis of the rays through cells.
fn axis(job: &Job, lines: &Lines) -> usize {
    match job.axis {
        AxisChoice::Auto => Rays::longest_axis(lines.dims),
        AxisChoice::X => 0,
        AxisChoice::Y => 1,
        AxisChoice::Z => 2,
    }
}

/// The cells of the window of a job.
fn window(job: &Job, whole: &Lines) -> Result<Option<[[u32; 3]; 2]>> {
    let Some([i0, j0, k0, i1, j1, k1]) = job.window else { return Ok(None) };
    let end = [i1, j1, k1];
    if (0..3).any(|axis| end[axis] > whole.dims[axis]) {
        let [nx, ny, nz] = whole.dims;
        let message = format!("window ends at cell {i1}, {j1}, {k1}: the box has {nx} x {ny} x {nz}");
        return Err(Error::new(
            "job-value",
            message,
            "end within the box; `hexcast estimate` says how many cells it has",
        ));
    }
    Ok(Some([[i0, j0, k0], end]))
}
