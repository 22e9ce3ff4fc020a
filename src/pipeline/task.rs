//! A task, a job and how it is done; and what a job becomes on the host before a ray is cast.

use std::sync::Arc;

use crate::columns::Store;
use crate::domain::{BoundingBox, Domain};
use crate::error::Result;
use crate::frame::check_limits;
use crate::geometry::Geometry;
use crate::job::{AxisChoice, Job};
use crate::lines::{Lines, lines};
use crate::rays::Rays;
use crate::sources::{Source, geometries};

/// Everything before the rays: what a job becomes on the host.
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
/// Those of [`Job::validate`], [`geometries`], [`Domain::new`], [`lines`], and the limits of [`crate::frame::Frame::new`].
pub fn prepare(job: &Job, sources: Vec<Source>) -> Result<Prepared> {
    job.validate()?;
    let geometries = geometries(job, sources)?;
    let boxes: Vec<BoundingBox> = geometries.iter().filter_map(Geometry::bounding_box).collect();
    let domain = Domain::new(job, &boxes)?;
    let lines = lines(job, &domain)?;
    check_limits(&geometries, &lines)?;
    let axis = match job.axis {
        AxisChoice::Auto => Rays::longest_axis(lines.dims),
        AxisChoice::X => 0,
        AxisChoice::Y => 1,
        AxisChoice::Z => 2,
    };
    Ok(Prepared { geometries, domain, lines, rays: Rays::new(axis, lines.dims) })
}

/// Most bytes that a mesh takes where neither the job nor the caller limits it: all that the system gives, or in wasm,
/// which can address 4 GiB, what leaves room for the page's other data.
pub const DEFAULT_MAX_BYTES: u64 = if cfg!(target_arch = "wasm32") { 3 << 30 } else { u64::MAX };

/// Where columns go besides memory.
#[derive(Clone, Default)]
pub enum Aside {
    /// Nowhere: what does not fit in memory is an error.
    #[default]
    Nowhere,
    /// To a store, when they outgrow the memory allowed.
    Spill(Arc<dyn Store>),
    /// To a store that outlives an interrupted run: columns that it holds of the same job are not made again.
    Keep(Arc<dyn Store>),
}

/// A job and how it is done.
pub struct Task<'a> {
    /// The job.
    pub job: &'a Job,
    /// Seconds that reading its files took.
    pub read_seconds: f64,
    /// Where columns go besides memory.
    pub aside: Aside,
    /// Whether the caller will hold all flags in memory, a byte a cell, which counts against the job's `max_memory`.
    pub flags_in_memory: bool,
    /// Bytes that the program and its GPU driver hold besides, which count against the job's `max_memory`; 0 where only
    /// what the mesh takes shall count.
    pub program_bytes: u64,
}
