//! What a job becomes on the host before a ray is cast.

use super::options::MeshOptions;
use crate::meshing::parts::parts;
use crate::meshing::report::InputReport;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::finding::Finding;
use hexcast_core::base::memory::Memory;
use hexcast_core::grid::domain::{BoundingBox, Domain};
use hexcast_core::grid::frame::check_limits;
use hexcast_core::grid::lines::{Body, Lines, check_n_cells, graded, lines};
use hexcast_core::grid::rays::Rays;
use hexcast_core::grid::window::CellWindow;
use hexcast_core::input::geometry::{Geometry, joined_names};
use hexcast_core::input::job::{AxisChoice, GradedJob, HaloEdge, Job, LinksJob, PartJob, ZarrJob};
use hexcast_core::input::sources::{Source, geometries, unit};
use hexcast_core::set;
use hexcast_derived::mesh::Named;
use hexcast_files::shards::Shards;

/// Most geometries that links and surfaces of cells have numbers for: 0 to 32,767.
const MAX_NUMBERED: usize = 1 << 15;

/// A job with its files, ready to be cast.
#[derive(Debug)]
#[non_exhaustive]
pub struct Prepared {
    /// The geometries, in meshing order.
    pub geometries: Vec<Geometry>,
    /// One name a flag, with what its cells are made of.
    pub names: Vec<Named>,
    /// The unit of all lengths, if the job or its files say it.
    pub unit: Option<String>,
    /// The box.
    pub domain: Domain,
    /// The mesh lines of the whole box.
    pub whole: Lines,
    /// Findings about ends of geometries that have no line of their own, files in other units, and flags that nothing has.
    pub notices: Vec<Finding>,
    /// Those that are meshed, as cells of the whole box: the first, and the end, exclusive; None for all. With the halo, as far as that
    /// is within the box.
    pub window: Option<[[u32; 3]; 2]>,
    /// The window or part without its halo; None for all cells.
    pub asked: Option<[[u32; 3]; 2]>,
    /// Cells of the halo on both sides of every axis.
    pub halo: u32,
    /// What it has beyond the box.
    pub halo_edge: HaloEdge,
    /// The mesh lines of the cells that are meshed.
    pub lines: Lines,
    /// The rays through these.
    pub rays: Rays,
}

/// A job on its way: what all stages look at.
pub(super) struct Task<'a> {
    pub(super) job: &'a Job,
    pub(super) options: &'a MeshOptions,
    pub(super) prepared: &'a Prepared,
    pub(super) inputs: &'a [InputReport],
    pub(super) memory: &'a Memory,
    pub(super) control: &'a Control,
    /// Whether what the job asks for beside the cells shall be measured.
    pub(super) is_measured: bool,
}

/// Makes geometries, domain, lines and rays of a job.
///
/// # Errors
/// Those of [`Job::validate`], [`geometries`], [`Domain::new`], [`lines`], [`graded`]; [`check_n_cells`], and the limits of
/// [`Frame::new`](hexcast_core::grid::frame::Frame::new); `too-many-geometries` for links and fractions; `job-conflict` where geometries of one flag have
/// different materials; `job-value` where the window ends beyond the box; those of [`parts`].
pub fn prepare(job: &Job, sources: Vec<Source>) -> Result<Prepared> {
    job.validate()?;
    let (unit, unlike) = unit(job, &sources);
    let geometries = geometries(job, sources)?;
    check_n_geometries(job, geometries.len())?;
    let names = names(job, &geometries)?;
    let boxes: Vec<BoundingBox> = geometries.iter().filter_map(Geometry::bounding_box).collect();
    // lists that are no lines make no domain
    let listed = job.lines.as_ref().map(|lists| Lines::from_lists([&lists.x, &lists.y, &lists.z].map(Vec::clone)));
    let listed = listed.transpose()?;
    let domain = Domain::new(job, &boxes)?;
    let (whole, mut notices) = match (listed, &job.graded) {
        (Some(listed), _) => (listed, Vec::new()),
        (None, Some(job)) => lines_around(&geometries, job, &domain)?,
        _ => (lines(job, &domain)?, Vec::new()),
    };
    notices.extend(unlike);
    notices.extend(about_fluid(job, &geometries));
    check_limits(&geometries, &whole)?;
    let asked = match job.part {
        Some(part) => {
            let step = part_step(job.zarr.as_ref(), &whole)?;
            let parts = parts(&geometries, &whole, &Rays::new(axis(job, &whole, None), whole.dims()), part.of, step)?;
            parts.get((part.index as usize).wrapping_sub(1)).copied()
        }
        None => window(job, &whole)?,
    };
    let (halo, halo_edge) = (job.halo.unwrap_or(0), job.halo_edge.unwrap_or_default());
    let grown = |[first, end]: [[u32; 3]; 2]| {
        let end = [0, 1, 2].map(|axis| end[axis].saturating_add(halo).min(whole.dims()[axis]));
        [first.map(|cell| cell.saturating_sub(halo)), end]
    };
    let window = asked.map(grown);
    let lines = window.map_or_else(|| whole.clone(), |cells| whole.window(cells));
    check_n_cells(job, &lines)?;
    let rays = Rays::new(axis(job, &lines, Some(&whole)), lines.dims());
    Ok(Prepared { geometries, names, unit, domain, whole, notices, window, asked, halo, halo_edge, lines, rays })
}

/// Refuses more geometries than links and surfaces of cells have numbers for.
///
/// # Errors
/// `too-many-geometries`.
fn check_n_geometries(job: &Job, n: usize) -> Result<()> {
    if n <= MAX_NUMBERED || job.links.is_none() && job.fractions.is_none() {
        return Ok(());
    }
    let message = format!("there are {n} geometries: links and fractions work with at most {MAX_NUMBERED}");
    let hint = "join geometries of the same substance in one file, or leave links and fractions out";
    Err(Error::new("too-many-geometries", message, hint))
}

/// A finding about a flag of the fluid that no cell can have.
fn about_fluid(job: &Job, geometries: &[Geometry]) -> Option<Finding> {
    let LinksJob { fluid, .. } = job.links.as_ref()?;
    // closed gaps have a flag that may be chosen later
    let is_known = |flag: u8| flag == 0 || geometries.iter().any(|of| of.flag == flag) || job.close_gaps.is_some();
    let unknown = *fluid.iter().find(|&&flag| !is_known(flag))?;
    let sentence = format!("no geometry has flag {unknown}, which links.fluid (--fluid) names: no link begins there");
    Some(Finding::new("fluid-without-geometry", sentence).of_flag(unknown))
}

/// Lines that go around geometries, and findings about their ends.
fn lines_around(geometries: &[Geometry], job: &GradedJob, domain: &Domain) -> Result<(Lines, Vec<Finding>)> {
    let body = |(index, of): (usize, &'_ Geometry)| of.bounding_box().map(|bounds| (index, (bounds, of.sizing)));
    let (indices, boxes): (Vec<_>, Vec<_>) = geometries.iter().enumerate().filter_map(body).unzip();
    let named = indices.iter().map(|&index| geometries[index].name.as_str()).zip(boxes);
    let bodies: Vec<Body> = named.map(|(name, (bounds, sizing))| Body::new(name, bounds, sizing)).collect();
    let (lines, mut findings) = graded(job, domain, &bodies)?;
    findings.iter_mut().filter_map(|of| of.geometry.as_mut()).for_each(|of| of.index = indices[of.index]);
    Ok((lines, findings))
}

impl Prepared {
    /// The same with cells that are halved so often along each axis; of whole boxes alone.
    ///
    /// # Errors
    /// Those of [`Lines::halved`], [`check_n_cells`], and the limits of [`Frame::new`](hexcast_core::grid::frame::Frame::new).
    pub(super) fn halved(self, job: &Job, times: u32) -> Result<Prepared> {
        if times == 0 {
            return Ok(self);
        }
        let whole = self.whole.halved(times)?;
        check_limits(&self.geometries, &whole)?;
        check_n_cells(job, &whole)?;
        let rays = Rays::new(axis(job, &whole, None), whole.dims());
        Ok(Prepared { lines: whole.clone(), whole, rays, ..self })
    }

    /// The window or part without its halo, or all cells.
    pub(super) fn cells(&self) -> [[u32; 3]; 2] {
        self.asked.unwrap_or([[0; 3], self.whole.dims()])
    }

    /// The cells that are cast: with the halo, as far as that is within the box.
    pub(super) fn cast_cells(&self) -> [[u32; 3]; 2] {
        self.window.unwrap_or([[0; 3], self.whole.dims()])
    }

    /// These, with the halo of their mesh.
    pub(super) fn cell_window(&self) -> CellWindow {
        let [first, end] = self.cells();
        CellWindow { first, end, halo: self.halo }
    }
}

/// Where parts may be cut: at every cell, or along the borders of the shards of a store.
///
/// # Errors
/// Those of [`Shards::new`].
pub fn part_step(zarr: Option<&ZarrJob>, whole: &Lines) -> Result<[u32; 3]> {
    zarr.map_or(Ok([1; 3]), |zarr| Ok(Shards::new(whole.dims(), zarr)?.shard))
}

/// The axis of the rays through cells, of a part of the whole if that is given: rays that parts do not cut are counted once.
fn axis(job: &Job, lines: &Lines, whole: Option<&Lines>) -> usize {
    match job.axis {
        AxisChoice::Auto => match (job.part, whole) {
            (Some(part), Some(whole)) => axis_of_part(part, whole),
            _ => Rays::longest_axis(lines.dims()),
        },
        AxisChoice::X => 0,
        AxisChoice::Y => 1,
        AxisChoice::Z => 2,
    }
}

/// The axis of the whole, unless the parts are cut across it; then the longest that they are not cut across. The same for all parts, since
/// counts of rays along one axis add up.
fn axis_of_part(part: PartJob, whole: &Lines) -> usize {
    let uncut = [0, 1, 2].map(|axis| if part.of[axis] == 1 { whole.dims()[axis] } else { 0 });
    Rays::longest_axis(if uncut == [0; 3] { whole.dims() } else { uncut })
}

/// The cells of the window of a job.
fn window(job: &Job, whole: &Lines) -> Result<Option<[[u32; 3]; 2]>> {
    let Some([i0, j0, k0, i1, j1, k1]) = job.window else { return Ok(None) };
    let end = [i1, j1, k1];
    if (0..3).any(|axis| end[axis] > whole.dims()[axis]) {
        let [nx, ny, nz] = whole.dims();
        let message = format!("window ends at cell {i1}, {j1}, {k1}: the box has {nx} x {ny} x {nz}");
        return Err(Error::new(
            "job-value",
            message,
            "end within the box; `hexcast estimate` says how many cells it has",
        ));
    }
    Ok(Some([[i0, j0, k0], end]))
}

/// One name a flag: those of its geometries; flag 0 has one where the job names it.
///
/// # Errors
/// `job-conflict` where geometries of one flag have different materials.
fn names(job: &Job, geometries: &[Geometry]) -> Result<Vec<Named>> {
    let mut of_flags: Vec<Vec<&Geometry>> = Vec::new();
    for geometry in geometries {
        match of_flags.iter_mut().find(|others| others[0].flag == geometry.flag) {
            Some(others) if others[0].material != geometry.material => {
                let message = format!(
                    "\"{}\" and \"{}\" have flag {} and different materials",
                    others[0].name, geometry.name, geometry.flag
                );
                return Err(Error::new("job-conflict", message, "give them different flags, or the same material"));
            }
            Some(others) => others.push(geometry),
            None => of_flags.push(vec![geometry]),
        }
    }
    let named = |flag, name: String, material| set!(Named { material, ..Named::new(flag, name) });
    let of_flag = |of_flag: Vec<&Geometry>| {
        let name = joined_names(of_flag.iter().map(|geometry| &geometry.name[..]));
        named(of_flag[0].flag, name, of_flag[0].material)
    };
    let mut names: Vec<Named> = of_flags.into_iter().map(of_flag).collect();
    if let Some(background) = &job.background {
        let name = background.name.clone().unwrap_or_else(|| "background".into());
        names.push(named(0, name, background.material));
    }
    Ok(names)
}
