//! What solvers of Maxwell's equations have fields on: the points of a staggered grid, cast as six boxes in the frame of the mesh, on its backend; edges and faces outside metal; and
//! the points that distances are those of.

use super::backend::Backend;
use super::cut::Cut;
use super::meshed::Meshed;
use super::prepare::{Prepared, Task};
use super::surfaces::{Uncut, is_flat};
use crate::meshing::report::MAX_BOXES;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::columns::Columns;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::rays::Rays;
use hexcast_core::input::geometry::{Fill, Geometry};
use hexcast_core::input::job::{ConformalJob, Points};
use hexcast_core::open_surfaces::doubt::Doubt;
use hexcast_core::open_surfaces::overlay::split;
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::inside::Kind;
use hexcast_derived::cut_cells::CutBy;
use hexcast_derived::cut_cells::conformal::{Conformal, Metal, REACH, conformal};
use hexcast_derived::distance::{self, Distance};
use hexcast_derived::staggered::{COMPONENTS, Conductors, Staggered, check_dims};

/// The geometries of a job as they count where fields are: those with an inside, and sheets.
pub(super) struct Bodies {
    /// The facets of those with an inside, with codes (rank + 1) for flags, so that ranks are known where sheets meet insides.
    pub(super) frame: Frame,
    /// All geometries, of which nothing but the inside counts; sheets have no facets left.
    insides: Vec<Geometry>,
    /// The facets of sheets.
    sheets: Frame,
    pub(super) flags: Vec<u8>,
}

impl Bodies {
    /// How the insides of each rank are decided.
    pub(super) fn kinds(&self, prepared: &Prepared) -> Vec<Kind> {
        let ranks = &self.frame.ranks;
        let mut kinds = vec![Kind::Cast; ranks.flag_of_rank.len()];
        for (position, &index) in ranks.geometry_at.iter().enumerate() {
            if prepared.geometries[index].invert {
                kinds[usize::from(ranks.rank_at[position])] = Kind::Inverted;
            }
        }
        kinds
    }
}

impl Uncut {
    /// Whether all facets at each position face the same side.
    pub(super) fn are_oriented(&self) -> Vec<bool> {
        self.closed.iter().map(|closed| closed.nonzero).collect()
    }

    /// Those of which `counts` says so.
    pub(super) fn bodies(&self, prepared: &Prepared, counts: impl Fn(&Geometry) -> bool) -> Bodies {
        let mut frame = self.frame.clone();
        let flags = std::mem::take(&mut frame.ranks.flag_of_rank);
        frame.ranks.flag_of_rank = (1..=flags.len() as u8).collect();
        let geometry_at = |position: usize| &prepared.geometries[frame.ranks.geometry_at[position]];
        // inverted, a plane holds all points
        let is_flat = |position: usize| is_flat(&frame, position) && !geometry_at(position).invert;
        let is_flat: Vec<bool> = (0..prepared.geometries.len()).map(is_flat).collect();
        let sheets = frame.with_some(|position| geometry_at(position).fill != Fill::Centre || is_flat[position]);
        let is_gone =
            |position: usize| geometry_at(position).shell || is_flat[position] || !counts(geometry_at(position));
        let is_gone: Vec<bool> = (0..prepared.geometries.len()).map(is_gone).collect();
        let frame = frame.with_some(|position| !is_gone[position]);
        let mut insides: Vec<Geometry> = prepared.geometries.to_vec();
        for (position, &index) in frame.ranks.geometry_at.iter().enumerate() {
            (insides[index].fill, insides[index].shell) = (Fill::Centre, is_gone[position]);
        }
        Bodies { frame, insides, sheets, flags }
    }

    /// The flags of the staggered grid of a job.
    ///
    /// # Errors
    /// Those of [`Uncut::staggered_near`]; `memory` where columns would take more than there is.
    pub(super) async fn staggered(
        &self,
        task: &Task<'_>,
        (cut, meshed): (&Cut, &Meshed),
        max_bytes: u64,
        backend: &mut Backend<'_>,
    ) -> Result<Option<Staggered>> {
        let &Task { job, prepared, .. } = task;
        if !job.staggered {
            return Ok(None);
        }
        check_dims(self.frame.dims, "staggered")?;
        let (window, dims) = (prepared.cell_window(), self.frame.dims);
        // a face beside the window may have an edge in it
        let near = window.with_neighbours(dims);
        let control = &backend.control.without_progress();
        let mut backend = backend.with_control(control);
        let bodies = self.bodies(prepared, |_| true);
        let (mut staggered, left) = self.staggered_near(task, (&bodies, near), max_bytes, &mut backend).await?;
        if !job.conductors.is_empty() {
            let cells = match near == prepared.cast_cells() {
                true => meshed.columns.clone(),
                false => cut.whole(task).columns((near, prepared.rays.axis), left, &mut backend).await?,
            };
            staggered = staggered.with_conductors(&Conductors::new(cells, &job.conductors, &bodies.flags));
        }
        if near == [window.first, window.end] {
            return Ok(Some(staggered));
        }
        // of each component that of the neighbours and its own are held at once
        staggered.within([window.first, window.end], near[0], (left, control)).map(Some)
    }

    /// The flags of a staggered grid of some cells of the box, and the bytes that are left.
    ///
    /// # Errors
    /// Those of [`split`] and [`crate::meshing::pipeline::Engine::columns`].
    async fn staggered_near(
        &self,
        task: &Task<'_>,
        (bodies, near): (&Bodies, [[u32; 3]; 2]),
        max_bytes: u64,
        backend: &mut Backend<'_>,
    ) -> Result<(Staggered, u64)> {
        // this frame, its copy, the two made of that, and one that is cast
        let frames = 5 * 38 * self.frame.facets.len() as u64;
        let (mut codes, mut n_bytes) = (Vec::with_capacity(COMPONENTS.len()), frames);
        for (_, is_moved) in COMPONENTS {
            let left = max_bytes.saturating_sub(n_bytes);
            let columns = self.points(task, (bodies, near, is_moved), left, backend).await?;
            n_bytes += columns.n_bytes();
            codes.push(columns);
        }
        let left = max_bytes.saturating_sub(n_bytes);
        let staggered = Staggered::new(codes, &bodies.flags, (&bodies.sheets, near), (left, backend.control))?;
        Ok((staggered, left))
    }

    /// Edges and faces outside metal.
    ///
    /// # Errors
    /// `no-metal`, `job-value` where the flags that are metal are none of the job's; those of [`Uncut::staggered_near`] and [`conformal`].
    pub(super) async fn conformal(
        &self,
        task: &Task<'_>,
        max_bytes: u64,
        backend: &mut Backend<'_>,
    ) -> Result<Option<Conformal>> {
        let &Task { job, prepared, .. } = task;
        let Some(asked) = &job.conformal else { return Ok(None) };
        check_dims(self.frame.dims, "conformal")?;
        let is_metal = metal(asked, prepared)?;
        let (window, dims) = (prepared.cell_window(), self.frame.dims);
        let near = window.with_near(REACH, dims);
        let control = &backend.control.without_progress();
        let mut backend = backend.with_control(control);
        let mut bodies = self.bodies(prepared, |_| true);
        let (mut sheets, mut left) = (Vec::new(), max_bytes);
        if !bodies.sheets.facets.is_empty() {
            sheets = self.staggered_near(task, (&bodies, near), left, &mut backend).await?.0.sheets;
            left = left.saturating_sub(size_of_val(&sheets[..]) as u64);
        }
        // this frame, the two made of it, one that is cast, or that in a mirror and the facets by planes
        left = left.saturating_sub(5 * 38 * self.frame.facets.len() as u64);
        let codes = self.points(task, (&bodies, near, [false; 3]), left, &mut backend).await?;
        left = left.saturating_sub(codes.n_bytes());
        let (kinds, is_oriented) = (bodies.kinds(prepared), self.are_oriented());
        bodies.frame.ranks.flag_of_rank = bodies.flags;
        let (frame, lines) = (&bodies.frame, &prepared.whole);
        let by = CutBy { frame, lines, rule: job.rule, kinds: &kinds, is_oriented: &is_oriented };
        let metal = Metal { is_metal: &is_metal, sheets: &sheets, stable: asked.stable };
        conformal(by, ([window.first, window.end], near), metal, codes, (left, control)).await.map(Some)
    }

    /// Signed distances.
    ///
    /// # Errors
    /// `job-value` where flags whose surfaces count are none of the job's; `memory`; those of [`crate::meshing::pipeline::Engine::columns`].
    pub(super) async fn distance(
        &self,
        task: &Task<'_>,
        max_bytes: u64,
        backend: &mut Backend<'_>,
    ) -> Result<Option<Distance>> {
        let &Task { job, prepared, .. } = task;
        let Some(asked) = &job.distance else { return Ok(None) };
        let of_nodes = asked.at == Points::Nodes;
        if of_nodes {
            check_dims(self.frame.dims, "distances at nodes")?;
        }
        check_flags(prepared, ("distance.flags (--distance-flags)", &asked.flags), "name flags of geometries")?;
        let counts = |geometry: &Geometry| asked.flags.is_empty() || asked.flags.contains(&geometry.flag);
        let window = prepared.cell_window();
        let window = [window.first, window.end];
        let control = &backend.control.without_progress();
        let mut backend = backend.with_control(control);
        let bodies = self.bodies(prepared, counts);
        // this frame, the two made of it, and one that is cast
        let left = max_bytes.saturating_sub(4 * 38 * self.frame.facets.len() as u64);
        let codes = self.points(task, (&bodies, window, [of_nodes; 3]), left, &mut backend).await?;
        let left = max_bytes.saturating_sub(codes.n_bytes());
        let points = distance::Asked { window, of_nodes, band: asked.band.cells() };
        let geometries = prepared.geometries.iter().filter(|geometry| counts(geometry));
        Distance::new(&prepared.whole, &points, geometries, (codes, &bodies.flags), left).map(Some)
    }

    /// The codes at the points of a component in some cells: at their centres, or along some axes on their lines.
    pub(super) async fn points(
        &self,
        task: &Task<'_>,
        (bodies, near, is_moved): (&Bodies, [[u32; 3]; 2], [bool; 3]),
        max_bytes: u64,
        backend: &mut Backend<'_>,
    ) -> Result<Columns> {
        let &Task { job, prepared, .. } = task;
        let (mut frame, cells) = (bodies.frame.clone().around_faces(is_moved), points_of(near, is_moved));
        let codes = frame.ranks.flag_of_rank.clone();
        let is_for_window = prepared.window.is_some();
        let mut parts;
        (frame, parts) =
            split(frame, &self.closed, (job.rule, is_for_window), (&prepared.whole, &bodies.insides), backend.control)
                .await?;
        if is_for_window {
            parts = parts.iter().map(|part| part.window(cells, &frame)).collect();
            frame = frame.window(cells);
        }
        let rays = Rays::new(prepared.rays.axis, frame.dims);
        let cast = Cast { frame: &frame, rays: &rays, rule: job.rule };
        let decided = (&codes[..], &prepared.whole, Doubt::new(rays, MAX_BOXES, None));
        backend.columns(&cast, parts, decided, max_bytes).await
    }
}

/// The points of a component around some cells.
fn points_of([first, end]: [[u32; 3]; 2], is_moved: [bool; 3]) -> [[u32; 3]; 2] {
    [first, [0, 1, 2].map(|axis| end[axis] + u32::from(is_moved[axis]))]
}

/// Which flags are metal.
///
/// # Errors
/// `no-metal` where none is; `job-value` where one is none of the job's.
pub(super) fn metal(asked: &ConformalJob, prepared: &Prepared) -> Result<[bool; 256]> {
    let conducts = prepared.names.iter().filter(|named| named.material.pec).map(|named| named.flag);
    let marked = prepared.geometries.iter().filter(|geometry| geometry.sizing.metal).map(|geometry| geometry.flag);
    let named: Vec<u8> = match asked.metal.is_empty() {
        true => conducts.chain(marked).collect(),
        false => asked.metal.clone(),
    };
    if named.is_empty() {
        let hint =
            "name the flags of metal, as in conformal.metal = [1] (--metal 1), or mark geometries (FILE:pec=true)";
        return Err(Error::new("no-metal", "conformal is asked for, and no flag is metal", hint));
    }
    let flags: Vec<u8> = named.iter().copied().filter(|flag| *flag != 0).collect();
    check_flags(prepared, ("conformal.metal (--metal)", &flags), "name flags of geometries, or 0 for the background")?;
    let mut is_metal = [false; 256];
    named.iter().for_each(|flag| is_metal[usize::from(*flag)] = true);
    Ok(is_metal)
}

/// Refuses flags that a key names and no geometry has.
fn check_flags(prepared: &Prepared, (key, flags): (&str, &[u8]), hint: &str) -> Result<()> {
    let is_known = |flag: &u8| prepared.geometries.iter().any(|geometry| geometry.flag == *flag);
    match flags.iter().find(|flag| !is_known(flag)) {
        Some(unknown) => {
            Err(Error::new("job-value", format!("no geometry has flag {unknown}, which {key} names"), hint))
        }
        None => Ok(()),
    }
}
