//! Kept crossings: those of each geometry, so that only what changes is snapped and cast again.
//!
//! Geometries, lines, rays -> [`Kept`]; other geometries in the same box -> the runs of the rays that they touch otherwise.
//!
//! # Theory
//! In one frame the crossings of a geometry depend on its own facets alone, and the runs of a ray on its crossings, and on the ranks of these.
//! So a ray keeps its runs unless a geometry that changes crosses it, before or after. A geometry that is moved crosses most of its rays
//! at other cells; one that gets another flag or priority, at the same.
//! All this holds for geometries whose rays decide, and which have nothing but cells: they are closed, have the cells inside of them, and are
//! not flat. For others there is no `Kept`.
//!
//! Cost: 4 bytes a crossing, and 4 bytes for each ray of the box of each geometry. To change some: their facets, snapped and cast, and the
//! crossings of the rays that they touch.

use std::ops::Range;
use std::sync::Arc;

use crate::base::control::Control;
use crate::base::error::Result;
use crate::base::memory::{Held, Memory};
use crate::base::parallel::*;
use crate::cells::columns::{Band, SomeRuns};
use crate::grid::closed::Closed;
use crate::grid::frame::{Ends, Frame, Ranks, too_many_ranks};
use crate::grid::lines::Lines;
use crate::grid::rays::Rays;
use crate::input::geometry::{Geometry, Placing, SharedFacets};
use crate::input::job::Rule;
use crate::stages::cast::Cast;
use crate::stages::cpu::{Window, over_windows};
use crate::stages::crossings::Crossings;
use crate::stages::map::{Mapping, map};
use crate::stages::snapping::{SnappedAlone, snapped_alone};

/// Bytes of a facet that rays may hit, and of what casting it takes.
const FACET_BYTES: u64 = 80;
/// What errors of memory call it all.
const KEPT: &str = "the crossings that are kept";

/// The crossings of each geometry of a mesh.
#[derive(Debug)]
pub struct Kept {
    /// Without facets.
    frame: Frame,
    lines: Lines,
    rays: Rays,
    rule: Rule,
    /// In the order of the job.
    bodies: Vec<Arc<Body>>,
    room: Held,
}

/// A geometry, and where rays cross it.
#[derive(Debug, Clone)]
struct Body {
    facets: SharedFacets,
    placing: Placing,
    flag: u8,
    priority: i32,
    closed: Closed,
    ends: Ends,
    crossed: Arc<Crossed>,
}

/// Crossings of a geometry.
#[derive(Debug, Default)]
struct Crossed {
    /// The rays through its box.
    window: Window,
    /// First entry of `events` of each of these rays, then the end.
    offsets: Vec<u32>,
    /// Of rank 0, sorted within a ray.
    events: Vec<u32>,
}

impl Kept {
    /// Casts geometries one by one; None where rays do not decide one of them, or it has more than cells.
    ///
    /// # Errors
    /// Those of [`Frame::new`]; `memory`; `cancelled`.
    pub async fn new(
        geometries: &[Geometry],
        lines: &Lines,
        (rays, rule): (&Rays, Rule),
        memory: &Memory,
        control: &Control,
    ) -> Result<Option<Kept>> {
        let frame = Frame::without_facets(geometries, lines)?;
        let room = Held::of(memory);
        let mut kept = Kept { frame, lines: lines.clone(), rays: *rays, rule, bodies: Vec::new(), room };
        for geometry in geometries {
            let Some(body) = kept.body(geometry, None, control).await? else { return Ok(None) };
            kept.room.grow(body.crossed.n_bytes(), KEPT)?;
            kept.bodies.push(body);
        }
        Ok(Some(kept))
    }

    /// Number of all crossings.
    pub fn n_crossings(&self) -> u64 {
        self.bodies.iter().map(|body| body.crossed.events.len() as u64).sum()
    }

    /// Takes other geometries in place of those that it has, in the same frame, and returns the runs of the rays that these cross otherwise.
    /// None where rays do not decide one of them, or it has more than cells; then, and after an error, it keeps what it has.
    ///
    /// # Errors
    /// Those of [`Kept::new`].
    pub async fn recast(&mut self, geometries: &[Geometry], control: &Control) -> Result<Option<SomeRuns>> {
        let mut bodies = Vec::with_capacity(geometries.len());
        for (index, geometry) in geometries.iter().enumerate() {
            let before = self.bodies.get(index);
            let Some(body) = self.body(geometry, before, control).await? else { return Ok(None) };
            bodies.push(body);
        }
        let ranks = ranks(&bodies, geometries)?;
        control.check()?;
        let runs = self.runs(&Touched::new(&self.bodies, &bodies), &bodies, &ranks);
        self.room.set(bodies.iter().map(|body| body.crossed.n_bytes()).sum(), KEPT)?;
        self.bodies = bodies;
        Ok(Some(runs))
    }

    /// A frame with the facets of some geometries, and the ends of all, in the order of positions.
    ///
    /// # Errors
    /// Those of [`Kept::new`].
    pub async fn frame_of(
        &self,
        geometries: &[Geometry],
        is_wanted: impl Fn(usize) -> bool,
        control: &Control,
    ) -> Result<(Frame, Vec<Ends>)> {
        let mut frame = Frame { ranks: ranks(&self.bodies, geometries)?, ..self.frame.clone() };
        let ends = frame.ranks.geometry_at.iter().map(|&index| self.bodies[index].ends).collect();
        for (position, index) in frame.ranks.geometry_at.clone().into_iter().enumerate() {
            if is_wanted(index) {
                let alone = snapped_alone(&self.frame, (&geometries[index], &self.lines), &self.rays, control).await?;
                frame.facets.extend(alone.facets);
                frame.position_of_facet.resize(frame.facets.len(), position as u16);
            }
        }
        Ok((frame, ends))
    }

    /// Snaps and casts a geometry, unless that was done before; None where rays do not decide it, or it has more than cells.
    async fn body(
        &self,
        geometry: &Geometry,
        before: Option<&Arc<Body>>,
        control: &Control,
    ) -> Result<Option<Arc<Body>>> {
        if !geometry.is_plain() {
            return Ok(None);
        }
        let (flag, priority) = (geometry.flag, geometry.priority);
        if let Some(before) = before.filter(|before| before.has_facets_of(geometry)) {
            let is_same = (before.flag, before.priority) == (flag, priority);
            let other = || Arc::new(Body { flag, priority, ..Body::clone(before) });
            return Ok(Some(if is_same { before.clone() } else { other() }));
        }
        let Kept { frame, lines, rays, rule, room, .. } = self;
        room.memory().check(FACET_BYTES * geometry.facets.len() as u64, KEPT)?;
        let SnappedAlone { facets, closed, ends } = snapped_alone(frame, (geometry, lines), rays, control).await?;
        let is_flat = ends.is_some_and(|[low, high]| (0..3).any(|axis| low[axis] == high[axis]));
        if !closed.by(*rule) || is_flat {
            return Ok(None);
        }
        let alone = frame.with_facets(facets);
        let crossed = Arc::new(Crossed::new(&Cast { frame: &alone, rays, rule: *rule }, ends));
        let (facets, placing) = (geometry.facets.clone(), geometry.world_from_file);
        Ok(Some(Arc::new(Body { facets, placing, flag, priority, closed, ends, crossed })))
    }

    /// Runs of the rays that are touched.
    fn runs(&self, touched: &Touched, bodies: &[Arc<Body>], ranks: &Ranks) -> SomeRuns {
        let mut rank_of = vec![0; bodies.len()];
        for (&index, &rank) in ranks.geometry_at.iter().zip(&ranks.rank_at) {
            rank_of[index] = rank;
        }
        let mapping = Mapping { rule: self.rule, flag_of_rank: &ranks.flag_of_rank, depth: self.rays.depth };
        let [across, down] = touched.window.clone();
        let of_row = |row: u32| {
            let here = bodies.iter().zip(&rank_of).filter(|(body, _)| body.crossed.meets([&across, &(row..row + 1)]));
            let here: Vec<(&Crossed, u32)> = here.map(|(body, &rank)| (&*body.crossed, u32::from(rank) << 1)).collect();
            let (mut rays, mut crossings) = (Vec::new(), Crossings { offsets: vec![0], ..Crossings::default() });
            for ray in across.clone().filter(|&ray| touched.has([ray, row])) {
                for (crossed, rank) in &here {
                    crossings.events.extend(crossed.of_ray([ray, row]).iter().map(|event| event | rank));
                }
                crossings.offsets.push(crossings.events.len() as u32);
                rays.push(u64::from(ray) + u64::from(row) * u64::from(self.rays.counts[0]));
            }
            (rays, map(&crossings, &mapping))
        };
        let rows: Vec<(Vec<u64>, Band)> = on_all_cores(|| down.into_par_iter().map(of_row).collect());
        let mut some = SomeRuns::default();
        for (rays, band) in rows {
            let start = some.runs.len() as u32;
            some.rays.extend(rays);
            some.ends.extend(band.ends.iter().map(|end| start + end));
            some.runs.extend(band.runs);
        }
        some
    }
}

/// The ranks of geometries, in the order of the job.
fn ranks(bodies: &[Arc<Body>], geometries: &[Geometry]) -> Result<Ranks> {
    let mut ranks = Ranks::new(geometries);
    let at: Vec<&Body> = ranks.geometry_at.iter().map(|&index| &*bodies[index]).collect();
    let ends: Vec<Ends> = at.iter().map(|body| body.ends).collect();
    let shared = ranks.share(geometries, &ends, |position| at[position].closed.nonzero);
    shared.map_err(|_| too_many_ranks(geometries.len()))?;
    Ok(ranks)
}

impl Body {
    /// Whether its facets are those of a geometry, at their place. Facets in another list are other ones.
    fn has_facets_of(&self, geometry: &Geometry) -> bool {
        self.placing == geometry.world_from_file && self.facets.is_same(&geometry.facets)
    }
}

impl Crossed {
    fn new(cast: &Cast, ends: Ends) -> Crossed {
        let Cast { frame, rays, .. } = *cast;
        let Some([low, high]) = ends else { return Crossed::default() };
        let window = rays.across.map(|axis| {
            let first = frame.n_below(axis, low[axis], false);
            first..frame.n_below(axis, high[axis], true).max(first)
        });
        let [across, down] = window.clone();
        if across.is_empty() || down.is_empty() {
            return Crossed::default();
        }
        // a few windows for each core
        let rows = down.len().div_ceil(4 * current_num_threads());
        let first_rows = down.clone().step_by(rows);
        let windows: Vec<Window> =
            first_rows.map(|first| [across.clone(), first..(first + rows as u32).min(down.end)]).collect();
        let of_window = |crossings: &Crossings| {
            let mut events = crossings.events.clone();
            for ray in crossings.offsets.windows(2) {
                events[ray[0] as usize..ray[1] as usize].sort_unstable();
            }
            (crossings.offsets.clone(), events)
        };
        let mut crossed = Crossed { window, offsets: vec![0], events: Vec::new() };
        for (offsets, events) in over_windows(cast, &windows, false, of_window) {
            let start = crossed.events.len() as u32;
            crossed.offsets.extend(offsets[1..].iter().map(|offset| start + offset));
            crossed.events.extend(events);
        }
        crossed
    }

    /// Crossings of a ray, of none beyond its window.
    fn of_ray(&self, [ray, row]: [u32; 2]) -> &[u32] {
        let [across, down] = &self.window;
        if !across.contains(&ray) || !down.contains(&row) {
            return &[];
        }
        let at = (row - down.start) as usize * across.len() + (ray - across.start) as usize;
        &self.events[self.offsets[at] as usize..self.offsets[at + 1] as usize]
    }

    /// Whether it has rays of a window.
    fn meets(&self, window: [&Range<u32>; 2]) -> bool {
        (0..2).all(|side| self.window[side].start < window[side].end && window[side].start < self.window[side].end)
    }

    fn n_bytes(&self) -> u64 {
        4 * (self.offsets.capacity() + self.events.capacity()) as u64
    }
}

/// Rays whose runs are made again, of a window.
struct Touched {
    window: Window,
    is_touched: Vec<bool>,
}

impl Touched {
    /// The rays with other crossings after than before, or of geometries that win over others.
    fn new(before: &[Arc<Body>], after: &[Arc<Body>]) -> Touched {
        let none = Crossed::default();
        let mut changed = Vec::new();
        for index in 0..before.len().max(after.len()) {
            let [old, new] = [before.get(index), after.get(index)];
            let [old_crossed, new_crossed] = [old, new].map(|body| body.map_or(&none, |body| &*body.crossed));
            let order = |body: &Arc<Body>| (body.flag, body.priority);
            let has_other_order = old.map(order) != new.map(order);
            if has_other_order || !std::ptr::eq(old_crossed, new_crossed) {
                changed.push((old_crossed, new_crossed, has_other_order));
            }
        }
        let windows = changed.iter().flat_map(|(old, new, _)| [&old.window, &new.window]);
        let window = windows.fold(Window::default(), |window, other| united(&window, other));
        let mut touched = Touched { is_touched: vec![false; window[0].len() * window[1].len()], window };
        for (old, new, has_other_order) in changed {
            let [across, down] = united(&old.window, &new.window);
            for row in down {
                for ray in across.clone() {
                    let [was, is] = [old, new].map(|of| of.of_ray([ray, row]));
                    if was != is || has_other_order && !is.is_empty() {
                        let place = touched.place([ray, row]);
                        touched.is_touched[place] = true;
                    }
                }
            }
        }
        touched
    }

    fn place(&self, [ray, row]: [u32; 2]) -> usize {
        let [across, down] = &self.window;
        (row - down.start) as usize * across.len() + (ray - across.start) as usize
    }

    fn has(&self, ray: [u32; 2]) -> bool {
        self.is_touched[self.place(ray)]
    }
}

/// The smallest window with the rays of two.
fn united(one: &Window, other: &Window) -> Window {
    if one.iter().any(Range::is_empty) {
        return other.clone();
    }
    if other.iter().any(Range::is_empty) {
        return one.clone();
    }
    [0, 1].map(|side| one[side].start.min(other[side].start)..one[side].end.max(other[side].end))
}
