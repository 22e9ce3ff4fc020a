//! Rooms: which open cells are connected.
//!
//! Passage -> [`Rooms`], a number for every open run. Two cells are neighbours if they share a face, so two open runs are if
//! they lie on neighbouring rays and their intervals overlap. A room is a set of cells that neighbours connect.
//!
//! Union-find: every core unites the runs of some rows of rays, then one core unites the rows at which the blocks meet. The
//! lower number always becomes the root, so the number of a room is that of its first run, however the rows were divided.
//! Source: Galler & Fischer (1964), *An improved equivalence algorithm*; path halving by van Leeuwen & van der Weide (1977).
//! Cost: 4 bytes an open run; about a pass over the runs.

use std::ops::Range;

use super::passage::{Passage, Place};
use hexcast_core::base::parallel::*;

/// The room of every open run.
#[derive(Debug)]
pub(crate) struct Rooms {
    /// The first open run of the same room; length: the number of runs.
    room_of_run: Vec<u32>,
}

/// A part of the roots: those of the runs from `first` on.
struct Roots<'a> {
    first: u32,
    of_run: &'a mut [u32],
}

impl Rooms {
    /// Finds the rooms of a passage.
    pub(crate) fn new(passage: &Passage) -> Rooms {
        let mut room_of_run: Vec<u32> = (0..passage.runs.len() as u32).collect();
        let blocks = passage.blocks();
        divided(passage, &blocks, &mut room_of_run).into_par_iter().for_each(|(rows, mut roots)| {
            for row in rows.clone() {
                unite_row(passage, row, row > rows.start, &mut roots);
            }
        });
        let mut roots = Roots { first: 0, of_run: &mut room_of_run };
        for rows in blocks.iter().skip(1) {
            unite_rows(passage, rows.start, &mut roots);
        }
        // a root never follows what it is the root of
        for run in 0..room_of_run.len() {
            room_of_run[run] = room_of_run[room_of_run[run] as usize];
        }
        Rooms { room_of_run }
    }

    /// The room of an open run.
    pub(crate) fn of(&self, run: usize) -> u32 {
        self.room_of_run[run]
    }

    /// The room of a cell; none where the cell is not open.
    pub(crate) fn at(&self, passage: &Passage, place: Place) -> Option<u32> {
        passage.run_at(place).map(|run| self.of(run))
    }

    /// Number of cells of a room.
    pub(crate) fn n_cells(&self, passage: &Passage, room: u32) -> u64 {
        let runs = passage.runs.iter().zip(&self.room_of_run).filter(|(_, of)| **of == room);
        runs.map(|(run, _)| u64::from(run.end - run.start)).sum()
    }
}

/// The roots of the runs of each block of rows.
fn divided<'a>(passage: &Passage, blocks: &[Range<u32>], mut rest: &'a mut [u32]) -> Vec<(Range<u32>, Roots<'a>)> {
    let mut parts = Vec::with_capacity(blocks.len());
    let mut first = 0;
    for rows in blocks {
        let end = passage.runs_of(passage.ray([passage.counts[0] - 1, rows.end - 1])).end;
        let (of_run, after) = rest.split_at_mut(end - first);
        parts.push((rows.clone(), Roots { first: first as u32, of_run }));
        (rest, first) = (after, end);
    }
    parts
}

/// Unites the runs of a row of rays with each other and, if asked to, with the row before.
fn unite_row(passage: &Passage, row: u32, with_row_before: bool, roots: &mut Roots) {
    for column in 1..passage.counts[0] {
        unite_rays(passage, [passage.ray([column - 1, row]), passage.ray([column, row])], roots);
    }
    if with_row_before {
        unite_rows(passage, row, roots);
    }
}

/// Unites the runs of a row of rays with those of the row before.
fn unite_rows(passage: &Passage, row: u32, roots: &mut Roots) {
    for column in 0..passage.counts[0] {
        unite_rays(passage, [passage.ray([column, row - 1]), passage.ray([column, row])], roots);
    }
}

/// Unites the runs of two rays that overlap.
fn unite_rays(passage: &Passage, rays: [u32; 2], roots: &mut Roots) {
    let [mut one, mut other] = rays.map(|ray| passage.runs_of(ray));
    while !one.is_empty() && !other.is_empty() {
        let [first, second] = [passage.runs[one.start], passage.runs[other.start]];
        if first.start < second.end && second.start < first.end {
            roots.unite(one.start as u32, other.start as u32);
        }
        if first.end <= second.end { one.start += 1 } else { other.start += 1 }
    }
}

impl Roots<'_> {
    fn unite(&mut self, one: u32, other: u32) {
        let [one, other] = [self.root(one), self.root(other)];
        self.of_run[(one.max(other) - self.first) as usize] = one.min(other);
    }

    fn root(&mut self, mut run: u32) -> u32 {
        loop {
            let above = self.of_run[(run - self.first) as usize];
            if above == run {
                return run;
            }
            // path halving
            let next = self.of_run[(above - self.first) as usize];
            self.of_run[(run - self.first) as usize] = next;
            run = next;
        }
    }
}
