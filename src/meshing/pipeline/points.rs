//! The flags at any points: [`PointFlags`], the surfaces of a job that are asked for them.

use super::memory_budget::memory_of;
use super::options::MeshOptions;
use super::prepare::prepare;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::grid::frame::{Scale, nearest};
use hexcast_core::input::job::Job;
use hexcast_core::input::sources::Source;
use hexcast_core::open_surfaces::points::{PointBodies, within_reach};
use hexcast_core::stages::snapping::{self, Snapped};

/// The surfaces of a job, ready to say which flag any point has: that of the geometry that holds it, not that of its cell.
///
/// A point has the flag that a cell with its centre there would have: it is rounded to the grid that corners are rounded to, by at most
/// [`PointFlags::snap`] along each axis, and all that follows is exact. So a point at the centre of a cell has the flag of the cell, unless the job has
/// cells that geometry alone does not decide: `fill`, `shell` and `close_gaps` give none to points. A point on a surface counts as a little nearer to the
/// start of x, then of y, then of z. Where geometries overlap, the higher priority wins, and of equal ones the later.
///
/// Points beyond the box of the job are decided like all others: geometries may reach beyond it. Of a surface that is not closed the rays along
/// the three axes decide, and where they differ the generalised winding number, in f64.
///
/// The memory that it takes counts against `max_memory` of the job.
///
/// # Example
/// ```
/// use hexcast::points::PointFlags;
/// use hexcast::{Control, GeometryJob, Job, Source, pipeline::MeshOptions};
///
/// # let [o, x, y, z] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let source = Source::from_facets("body", vec![[o, y, x], [o, x, z], [o, z, y], [x, y, z]])?;
/// let mut job = Job::new(vec![GeometryJob::new("body")]);
/// job.cells = Some(20);
/// let points = PointFlags::new(&job, vec![source], &MeshOptions::default(), &Control::default())?;
/// assert_eq!(points.flags(&[[0.1, 0.1, 0.1], [0.4, 0.4, 0.4], [-9.0, 0.1, 0.1]], &Control::default())?, [1, 0, 0]);
/// # Ok::<(), hexcast::Error>(())
/// ```
pub struct PointFlags {
    bodies: PointBodies,
    scale: Scale,
    fraction_bits: u32,
    snap: [f64; 3],
}

impl PointFlags {
    /// Prepares a job: `sources[i]` is the file of `job.geometries[i]`. Its lines decide the grid that points are rounded to; windows and parts do
    /// not count. Of `options` the bytes of the program count.
    ///
    /// Cost: about that of the snap of a mesh, and 80 to 120 bytes a facet, four times that where a geometry is open.
    ///
    /// # Errors
    /// Those of [`prepare`] and [`Frame::new`](hexcast_core::grid::frame::Frame::new); `surface-open` where a geometry is open and must not be, or has
    /// `open = "parity"`, which whole rays of a mesh decide; `memory`; `cancelled`.
    pub fn new(job: &Job, sources: Vec<Source>, options: &MeshOptions, control: &Control) -> Result<PointFlags> {
        hexcast_core::base::control::at_once(PointFlags::with_rests(job, sources, options, &control.without_pauses()))
    }

    /// Like [`PointFlags::new`], with rests after some tens of milliseconds.
    ///
    /// # Errors
    /// Those of [`PointFlags::new`].
    pub async fn with_rests(
        job: &Job,
        sources: Vec<Source>,
        options: &MeshOptions,
        control: &Control,
    ) -> Result<PointFlags> {
        let prepared = prepare(job, sources)?;
        let memory = memory_of(job, options, &prepared, control)?;
        let (geometries, whole) = (&prepared.geometries[..], &prepared.whole);
        let (Snapped { frame, closed, .. }, room) =
            snapping::snapped(geometries, whole, (None, job.rule), &memory, control).await?;
        room.keep();
        let fraction_bits = frame.fraction_bits;
        let snap = whole.smallest().map(|size| frame.snap_in_cells() * size);
        let bodies = PointBodies::new(frame, &closed, job.rule, (whole, geometries), (&memory, control)).await?;
        Ok(PointFlags { bodies, scale: Scale::new(whole), fraction_bits, snap })
    }

    /// Most that a point, or a corner of a facet, is moved along x, y and z by rounding, in the unit of the files.
    pub fn snap(&self) -> [f64; 3] {
        self.snap
    }

    /// The flags at points x, y, z in the unit of the files: a flag a point, in their order; 0 for the background.
    ///
    /// On all cores. Points that lie near each other should follow each other, as nodes and centres of elements do: then the facets around them
    /// stay in the cache.
    ///
    /// # Errors
    /// `job-value` where a coordinate is not a number; `cancelled`.
    pub fn flags(&self, points: &[[f64; 3]], control: &Control) -> Result<Vec<u8>> {
        hexcast_core::base::control::at_once(self.flags_with_rests(points, &control.without_pauses()))
    }

    /// Like [`PointFlags::flags`], with rests after some tens of milliseconds.
    ///
    /// # Errors
    /// Those of [`PointFlags::flags`].
    pub async fn flags_with_rests(&self, points: &[[f64; 3]], control: &Control) -> Result<Vec<u8>> {
        let mut flags = Vec::with_capacity(points.len());
        for (first, some) in (0..).step_by(AT_ONCE).zip(points.chunks(AT_ONCE)) {
            if let Some(place) = some.iter().position(|point| point.iter().any(|number| number.is_nan())) {
                let message = format!("point {} is {:?}", first + place, some[place]);
                return Err(Error::new("job-value", message, "give numbers for x, y and z"));
            }
            let snapped: Vec<[i32; 3]> = some.iter().map(|point| self.snapped(point)).collect();
            flags.extend(self.bodies.flags(&snapped, control).await?);
        }
        Ok(flags)
    }

    fn snapped(&self, point: &[f64; 3]) -> [i32; 3] {
        let factor = f64::from(1u32 << self.fraction_bits);
        [0, 1, 2].map(|axis| nearest(within_reach(self.scale.units_from_world(axis, point[axis]) * factor)))
    }
}

/// Points that are rounded at a time, so that these take little memory.
const AT_ONCE: usize = 1 << 18;
