//! Overlaps: cells that lie inside of two geometries, of which one wins.
//!
//! An overlap along a ray belongs to the cell in which it begins, so the longest overlap of a box is the longest of its windows:
//! each window casts whole rays of the box, those through its cells.
//! Cost: one cast of all rays on the host.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::ops::Range;

use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::rays::Rays;
use hexcast_core::grid::totals::{Ruler, Total};
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::cpu::{Window, over_windows, rays_through};
use hexcast_core::stages::crossings::Crossings;
use hexcast_core::stages::inside::is_inside;

/// Rows of rays that are cast together.
const ROWS: u32 = 1 << 10;

/// Two geometries with common cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlap {
    /// Index in the job of the one that wins, and of the other.
    pub geometries: [usize; 2],
    /// Cells inside of both.
    pub cells: u64,
    /// Their volume.
    pub volume: f64,
    /// The same in the units of the box.
    pub total: Total,
    /// Cells of the longest stretch of a ray inside of both; 0 in a window in which none begins.
    pub longest: u32,
    /// A place inside of both, in world coordinates: the middle of the longest stretch, the first of those.
    pub place: [f64; 3],
}

/// Cells of a ray inside of two geometries.
#[derive(Clone, Copy)]
struct Stretch {
    /// Number of cells; 0 where they begin before those that are looked at.
    length: u32,
    ray: u64,
    /// The first cell, and the end, of those looked at.
    first: u32,
    end: u32,
}

/// What a pair of geometries has in common.
struct Common {
    cells: u64,
    volume: Total,
    longest: Stretch,
}

impl Common {
    /// Adds what comes after.
    fn add(&mut self, more: Common) {
        self.cells += more.cells;
        self.volume.add(more.volume);
        if more.longest.length > self.longest.length {
            self.longest = more.longest;
        }
    }
}

/// Finds those of some cells of the box, in the order of positions.
pub(super) fn overlaps(cast: &Cast, lines: &Lines, cells: [[u32; 3]; 2]) -> Vec<Overlap> {
    let geometry_at = &cast.frame.ranks.geometry_at;
    let mut common: BTreeMap<[u16; 2], Common> = BTreeMap::new();
    if geometry_at.len() < 2 {
        return Vec::new();
    }
    let [across, down] = rays_through(cast.rays, cells);
    let along = cells[0][cast.rays.axis]..cells[1][cast.rays.axis];
    let ruler = Ruler::new(lines, lines);
    let with_facets = !cast.frame.ranks.are_positions();
    for first in down.clone().step_by(ROWS as usize) {
        let rows = first..down.end.min(first.saturating_add(ROWS));
        let windows: Vec<Window> = rows.map(|row| [across.clone(), row..row + 1]).collect();
        let of_row = |crossings: &Crossings| common_cells(crossings, cast, &ruler, &along);
        for (pair, of_row) in over_windows(cast, &windows, with_facets, of_row).into_iter().flatten() {
            note(&mut common, pair, of_row);
        }
    }
    let overlap = |([high, low], Common { cells, volume, longest }): ([u16; 2], Common)| Overlap {
        geometries: [high, low].map(|position| geometry_at[usize::from(position)]),
        cells,
        volume: ruler.volume(volume, 1),
        total: volume,
        longest: longest.length,
        place: middle(longest, cast.rays, lines),
    };
    common.into_iter().map(overlap).collect()
}

/// Adds to what a pair has in common.
fn note(common: &mut BTreeMap<[u16; 2], Common>, pair: [u16; 2], more: Common) {
    match common.entry(pair) {
        Entry::Vacant(entry) => drop(entry.insert(more)),
        Entry::Occupied(mut entry) => entry.get_mut().add(more),
    }
}

/// The middle of a stretch of a ray, in world coordinates.
fn middle(Stretch { ray, first, end, .. }: Stretch, rays: &Rays, lines: &Lines) -> [f64; 3] {
    let n_across = u64::from(rays.counts[0]);
    let mut place = [0.0; 3];
    place[rays.across[0]] = (ray % n_across) as f64 + 0.5;
    place[rays.across[1]] = (ray / n_across) as f64 + 0.5;
    place[rays.axis] = f64::from(first) + 0.5 * f64::from(end - first);
    [0, 1, 2].map(|axis| lines.at(axis, place[axis]))
}

/// What each pair of geometries, by position, the higher first, has in common in some cells of the rays.
fn common_cells(crossings: &Crossings, cast: &Cast, ruler: &Ruler, along: &Range<u32>) -> BTreeMap<[u16; 2], Common> {
    let (rule, rays) = (cast.rule, cast.rays);
    let n_across = u64::from(rays.counts[0]);
    let mut common: BTreeMap<[u16; 2], Common> = BTreeMap::new();
    crossings.for_each_passage(cast.frame, |ray, passages| {
        let mut counts: BTreeMap<u16, i32> = BTreeMap::new();
        let mut last = 0;
        for passage in passages {
            let cell = passage.cell.min(rays.depth);
            let holds = |(_, n): &(&u16, &i32)| is_inside(rule, **n);
            if cell > last {
                let inside: Vec<u16> = counts.iter().filter(holds).map(|(&position, _)| position).collect();
                let longest = match along.contains(&last) {
                    true => Stretch { length: cell - last, ray, first: last, end: cell },
                    false => Stretch { length: 0, ray, first: along.start, end: cell.min(along.end) },
                };
                let [start, end] = [last.max(along.start), cell.min(along.end)];
                let n_here = end.saturating_sub(start);
                let volume = || {
                    let (mut low, mut high) = ([start; 3], [end; 3]);
                    for (side, cell) in [(0, ray % n_across), (1, ray / n_across)] {
                        (low[rays.across[side]], high[rays.across[side]]) = (cell as u32, cell as u32 + 1);
                    }
                    ruler.cells([low, high])
                };
                for (index, &high) in inside.iter().enumerate().filter(|_| n_here > 0) {
                    for &low in &inside[..index] {
                        note(&mut common, [high, low], Common { cells: n_here.into(), volume: volume(), longest });
                    }
                }
                last = cell;
            }
            *counts.entry(passage.position).or_insert(0) += passage.step;
        }
    });
    common
}
