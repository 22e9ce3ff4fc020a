//! The widest way: the largest cube of cells that passes, and where it is tightest.
//!
//! Rooms of single cells, two cells that are connected -> [`Widest`]. A cube of w cells *passes* if it can move, a cell at
//! a time, from a place where it holds the first cell to one where it holds the second, and all its cells are open on the
//! way. If a cube passes, so do all smaller ones inside it. So the width is found by doubling and bisection: each trial
//! makes the passage of a cube at most twice as wide (see `passage`) and its rooms. The width does not depend on the ray
//! axis.
//!
//! The cube one cell wider stays in some rooms around the first cell. The *narrowest place* begins where the widest cube
//! sticks out of what the wider one sweeps in these rooms, for the last time on its way. It ends where any wider cube
//! holds it again, or at the second cell; its middle is reported. Where several ways are as wide, the place is on one of
//! them.
//!
//! Cost: a pass over the runs for every trial, of which [`MAX_WIDTH`] allows 11; one search.

use super::passage::{Passage, Place};
use super::rooms::Rooms;
use super::shortest::{Steps, shortest};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;

/// A cube of so many cells shows that nothing on the way is narrow; a power of two.
pub const MAX_WIDTH: u32 = 64;

/// The places of cubes of one width, and which of them are connected.
#[derive(Debug)]
pub(super) struct Cubes {
    pub(super) passage: Passage,
    pub(super) rooms: Rooms,
}

/// The way of the widest cube.
#[derive(Debug)]
pub(super) struct Widest {
    /// Edge of the cube.
    pub(super) width: u32,
    /// The places of the cube at which its way begins, turns and ends.
    pub(super) way: Vec<Place>,
    /// The place of the cube in the middle of the narrowest place.
    pub(super) narrowest: Place,
}

impl Cubes {
    pub(super) fn new(passage: Passage) -> Cubes {
        Cubes { rooms: Rooms::new(&passage), passage }
    }

    fn wider(&self, by: u32, control: &Control) -> Result<Cubes> {
        Ok(Cubes::new(self.passage.narrowed(by, control)?))
    }

    /// The open runs of the places in which a cube holds a cell, with the ray of each.
    fn runs_over(&self, cell: Place) -> impl Iterator<Item = ([u32; 2], usize)> {
        let [first, second, along] = cell.map(|at| at..at + self.passage.width);
        let rays = second.flat_map(move |j| first.clone().map(move |i| [i, j]));
        rays.flat_map(move |across| {
            let runs = self.passage.runs_in(self.passage.ray(across), along.clone());
            runs.map(move |run| (across, run))
        })
    }

    /// The rooms of the places in which a cube holds a cell, ascending.
    fn rooms_over(&self, cell: Place) -> Vec<u32> {
        let mut rooms: Vec<u32> = self.runs_over(cell).map(|(_, run)| self.rooms.of(run)).collect();
        rooms.sort_unstable();
        rooms.dedup();
        rooms
    }

    /// The rooms in which a cube passes from one cell to another.
    fn rooms_between(&self, ends: [Place; 2]) -> Vec<u32> {
        let [mut rooms, others] = ends.map(|cell| self.rooms_over(cell));
        rooms.retain(|room| others.binary_search(room).is_ok());
        rooms
    }

    /// The place in some rooms in which a cube holds a cell most nearly in its middle; of equal ones that of least rank.
    fn nearest(&self, cell: Place, rooms: &[u32], rank: &dyn Fn(Place) -> [u32; 3]) -> Option<Place> {
        let width = self.passage.width;
        let middle = cell.map(|at| at + (width - 1) / 2);
        let candidates = self.runs_over(cell).filter(|(_, run)| rooms.binary_search(&self.rooms.of(*run)).is_ok());
        let places = candidates.map(|([i, j], run)| {
            let run = self.passage.runs[run];
            let (start, end) = (run.start.max(cell[2]), run.end.min(cell[2] + width));
            [i, j, middle[2].clamp(start, end - 1)]
        });
        places.min_by_key(|place| {
            let off: u32 = (0..3).map(|axis| place[axis].abs_diff(middle[axis])).sum();
            (off, rank(*place))
        })
    }

    /// Whether one of these cubes, which are one cell wider than another, holds that at its place; in some rooms, or in any.
    fn hold(&self, place: Place, rooms: Option<&[u32]>) -> bool {
        (0..8).any(|corner| {
            let own = [0, 1, 2].map(|axis| place[axis] + (corner >> axis & 1));
            let room = self.rooms.at(&self.passage, own);
            room.is_some_and(|room| rooms.is_none_or(|rooms| rooms.binary_search(&room).is_ok()))
        })
    }
}

/// Finds the widest way between two cells that single cells connect; none where it is [`MAX_WIDTH`] wide or more. `rank`
/// orders places alike for all ray axes.
///
/// # Errors
/// `memory`; `cancelled`.
pub(super) fn widest(
    cells: &Cubes,
    ends: [Place; 2],
    rank: &dyn Fn(Place) -> [u32; 3],
    max_bytes: u64,
    control: &Control,
) -> Result<Option<Widest>> {
    let (mut wider_passing, mut stuck): (Option<Cubes>, Option<Cubes>) = (None, None);
    let stuck = loop {
        let passing = wider_passing.as_ref().unwrap_or(cells);
        let width = passing.passage.width;
        let wider = match stuck {
            Some(stuck) if stuck.passage.width == width + 1 => break stuck,
            Some(ref stuck) => width.midpoint(stuck.passage.width),
            None if width == MAX_WIDTH => return Ok(None),
            None => 2 * width,
        };
        let cubes = passing.wider(wider - width, control)?;
        if cubes.rooms_between(ends).is_empty() { stuck = Some(cubes) } else { wider_passing = Some(cubes) }
    };
    let passing = wider_passing.as_ref().unwrap_or(cells);
    let rooms = passing.rooms_between(ends);
    let Some(start) = passing.nearest(ends[0], &rooms, rank) else { return Ok(None) };
    let room: Vec<u32> = passing.rooms.at(&passing.passage, start).into_iter().collect();
    let Some(end) = passing.nearest(ends[1], &room, rank) else { return Ok(None) };
    let Some(way) = shortest(&passing.passage, start, end, max_bytes, control)? else { return Ok(None) };
    let narrowest = narrowest(&way, &stuck, &stuck.rooms_over(ends[0]));
    Ok(Some(Widest { width: passing.passage.width, way: way.corners, narrowest }))
}

/// The middle of the first stretch on which no wider cube holds the widest one, after it has left the rooms of the start.
fn narrowest(way: &Steps, wider: &Cubes, rooms_of_start: &[u32]) -> Place {
    let n_places = way.n as usize + 1;
    let n_after = walk(way.corners.iter().rev()).position(|place| wider.hold(place, Some(rooms_of_start)));
    let first = n_places - n_after.unwrap_or(n_places);
    let n_tight = walk(way.corners.iter()).skip(first).position(|place| wider.hold(place, None));
    // rooms may meet in a face of the cube, without a tight place between
    let n_tight = n_tight.unwrap_or(n_places - first).max(1);
    walk(way.corners.iter()).nth(first + (n_tight - 1) / 2).unwrap_or(way.corners[0])
}

/// All places of a path from its corners, in their order.
fn walk<'a>(corners: impl Iterator<Item = &'a Place>) -> impl Iterator<Item = Place> {
    let mut before: Option<Place> = None;
    corners.flat_map(move |&corner| {
        let from = before.replace(corner);
        let n = from.map_or(0, |from| (0..3).map(|axis| from[axis].abs_diff(corner[axis])).sum::<u32>());
        let toward = move |from: Place, step: u32| {
            [0, 1, 2].map(|axis| {
                let up = corner[axis] >= from[axis];
                let step = step.min(from[axis].abs_diff(corner[axis]));
                if up { from[axis] + step } else { from[axis] - step }
            })
        };
        let first = from.is_none().then_some(corner);
        first.into_iter().chain((1..=n).filter_map(move |step| from.map(|from| toward(from, step))))
    })
}
