//! The shortest path between two open cells, exactly, without looking at every cell.
//!
//! Passage, two cells -> [`Steps`]: the fewest steps from cell to cell over faces.
//!
//! # Theory
//! A* whose states are *entries*: an open run R, the cell e at which the path enters it, the steps d up to there. Within R
//! every cell x costs d + |x - e|. To go on to a run N beside R, whose cells opposite to R are lo..=hi, the search crosses at
//! one cell only: c, the cell of lo..=hi that is nearest to e.
//!
//! *That is enough.* Let a path cross at another cell c' of lo..=hi and come to the cell y of N. c is nearest to e in an
//! interval, so it lies between e and c': |e - c'| = |e - c| + |c - c'|. Crossing at c and walking to y in N costs
//! |e - c| + 1 + |c - y| <= |e - c| + 1 + |c - c'| + |c' - y| = |e - c'| + 1 + |c' - y|. All cells between c and y are open, since
//! N is an interval. Crossing by crossing, from the first on, every path becomes one that crosses at nearest cells only and is
//! not longer.
//!
//! *An entry (e', d') of a run makes another (e, d) of it needless* if d' + |e - e'| <= d: what follows the other costs no more
//! from e'. Most runs keep one entry.
//!
//! The estimate of the rest is the distance of e from the goal as if all cells were open. A step changes it by 1 at most, so
//! the first entry of the goal's run that comes out of the queue is on a shortest path.
//!
//! Source: Hart, Nilsson & Raphael (1968), *A formal basis for the heuristic determination of minimum cost paths*; states on
//! intervals as in Harabor & Grastien (2013), *An optimal any-angle pathfinding algorithm*.
//! Cost: O(entries x runs beside one) time; 32 bytes an entry, 4 an open run.

use std::collections::BTreeMap;

use super::passage::{Passage, Place};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};

/// A path over faces of cells.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Steps {
    /// The cells at which the path begins, turns and ends; neighbours in the list differ on one axis.
    pub(super) corners: Vec<Place>,
    /// Number of steps.
    pub(super) n: u64,
}

const NONE: u32 = u32::MAX;
/// Entries between two looks at whether the caller has cancelled.
const ENTRIES_A_CHECK: usize = 1 << 16;

/// The cell at which a path comes to an open run.
#[derive(Clone, Copy)]
struct Entry {
    cost: u64,
    ray: u32,
    run: u32,
    cell: u32,
    /// The entry that this one comes from.
    from: u32,
    /// The next entry of the same run.
    next: u32,
}

struct Search<'a> {
    passage: &'a Passage,
    to: Place,
    entries: Vec<Entry>,
    max_entries: usize,
    /// The entry of each run that was found last.
    last_of_run: Vec<u32>,
    /// Entries by the least length of a path over them.
    queue: BTreeMap<u64, Vec<u32>>,
}

/// Finds a shortest path; none where there is no path. At most `max_bytes` of memory are taken.
///
/// # Errors
/// `memory`; `cancelled`.
pub(super) fn shortest(
    passage: &Passage,
    from: Place,
    to: Place,
    max_bytes: u64,
    control: &Control,
) -> Result<Option<Steps>> {
    let (Some(first), Some(goal)) = (passage.run_at(from), passage.run_at(to)) else { return Ok(None) };
    let max_entries = (max_bytes / size_of::<Entry>() as u64).min(u64::from(NONE)) as usize;
    let last_of_run = vec![NONE; passage.runs.len()];
    let mut search = Search { passage, to, entries: Vec::new(), max_entries, last_of_run, queue: BTreeMap::new() };
    let ray = passage.ray([from[0], from[1]]);
    search.enter(Entry { cost: 0, ray, run: first as u32, cell: from[2], from: NONE, next: NONE })?;
    let mut n_taken = 0;
    while let Some(index) = search.take() {
        n_taken += 1;
        if n_taken % ENTRIES_A_CHECK == 0 {
            control.check()?;
        }
        let entry = search.entries[index as usize];
        if entry.run as usize == goal {
            return Ok(Some(search.steps(entry)));
        }
        if !search.is_needless(&entry, index) {
            search.go_on(entry, index)?;
        }
    }
    Ok(None)
}

impl Search<'_> {
    /// Takes an entry of the shortest paths; of several the one found last, which is nearer to the goal.
    fn take(&mut self) -> Option<u32> {
        let mut least = self.queue.first_entry()?;
        let index = least.get_mut().pop();
        if least.get().is_empty() {
            least.remove();
        }
        index
    }

    /// Enters the runs beside that of an entry.
    fn go_on(&mut self, entry: Entry, index: u32) -> Result<()> {
        let passage = self.passage;
        let run = passage.runs[entry.run as usize];
        for ray in passage.beside(entry.ray) {
            for beside in passage.runs_in(ray, run.start..run.end) {
                let other = passage.runs[beside];
                let cell = entry.cell.clamp(run.start.max(other.start), run.end.min(other.end) - 1);
                let cost = entry.cost + u64::from(entry.cell.abs_diff(cell)) + 1;
                self.enter(Entry { cost, ray, run: beside as u32, cell, from: index, next: NONE })?;
            }
        }
        Ok(())
    }

    /// Queues an entry unless an earlier one makes it needless.
    fn enter(&mut self, entry: Entry) -> Result<()> {
        if self.is_needless(&entry, NONE) {
            return Ok(());
        }
        if self.entries.len() == self.max_entries {
            let message = format!("the search for the shortest path takes more than {} entries", self.max_entries);
            return Err(Error::new("memory", message, "allow more with --max-memory, or use larger cells"));
        }
        let index = self.entries.len() as u32;
        let last = &mut self.last_of_run[entry.run as usize];
        self.entries.push(Entry { next: *last, ..entry });
        *last = index;
        let place = self.place(entry.ray, entry.cell);
        let rest: u64 = (0..3).map(|axis| u64::from(place[axis].abs_diff(self.to[axis]))).sum();
        self.queue.entry(entry.cost + rest).or_default().push(index);
        Ok(())
    }

    /// Whether another entry of the same run reaches all its cells in no more steps; `own` is the entry itself.
    fn is_needless(&self, entry: &Entry, own: u32) -> bool {
        let mut index = self.last_of_run[entry.run as usize];
        while index != NONE {
            let other = &self.entries[index as usize];
            if index != own && other.cost + u64::from(other.cell.abs_diff(entry.cell)) <= entry.cost {
                return true;
            }
            index = other.next;
        }
        false
    }

    /// The path that ends with an entry of the goal's run.
    fn steps(&self, last: Entry) -> Steps {
        let n = last.cost + u64::from(last.cell.abs_diff(self.to[2]));
        let mut corners = vec![self.to];
        let mut entry = last;
        loop {
            push_corner(&mut corners, self.place(entry.ray, entry.cell));
            if entry.from == NONE {
                break;
            }
            let before = self.entries[entry.from as usize];
            // along the run before, then across to this one
            push_corner(&mut corners, self.place(before.ray, entry.cell));
            entry = before;
        }
        corners.reverse();
        Steps { corners, n }
    }

    fn place(&self, ray: u32, cell: u32) -> Place {
        let n = self.passage.counts[0];
        [ray % n, ray / n, cell]
    }
}

/// Adds a cell to a path; a straight piece has cells at its ends only.
fn push_corner(corners: &mut Vec<Place>, place: Place) {
    if corners.last() == Some(&place) {
        return;
    }
    let axis_of = |one: Place, other: Place| (0..3).find(|&axis| one[axis] != other[axis]);
    let goes_on = match corners.as_slice() {
        [.., before, last] => {
            let axis = axis_of(*before, *last);
            axis == axis_of(*last, place)
                && axis.is_some_and(|axis| (before[axis] < last[axis]) == (last[axis] < place[axis]))
        }
        _ => false,
    };
    if goes_on {
        corners.pop();
    }
    corners.push(place);
}
