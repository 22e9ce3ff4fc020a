//! Overlaps: cells that lie inside of two geometries, of which one wins.
//!
//! Cost: one cast of all rays on the host.

use std::collections::BTreeMap;

use crate::cast::Cast;
use crate::cpu::{Window, over_windows, window_of_rows};
use crate::crossings::Crossings;
use crate::job::Rule;
use crate::lines::Lines;
use crate::rays::Rays;

/// Rows of rays that are cast together.
const ROWS: u32 = 1 << 10;

/// Two geometries with common cells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlap {
    /// Index in the job of the one that wins, and of the other.
    pub geometries: [usize; 2],
    /// Cells inside of both.
    pub cells: u64,
    /// A place inside of both, in world coordinates: the middle of the longest stretch of a ray, the first of those.
    pub place: [f64; 3],
}

/// What a pair of geometries has in common.
#[derive(Default)]
struct Common {
    cells: u64,
    /// Number of cells of the longest stretch, its ray and its first cell.
    longest: (u32, u64, u32),
}

impl Common {
    fn add(&mut self, cells: u64, stretch: (u32, u64, u32)) {
        self.cells += cells;
        if stretch.0 > self.longest.0 {
            self.longest = stretch;
        }
    }
}

/// Finds all, in the order of their ranks.
pub(super) fn overlaps(cast: &Cast, lines: &Lines) -> Vec<Overlap> {
    let ranks = &cast.frame.ranks.geometry_of_rank;
    let mut common: BTreeMap<[u8; 2], Common> = BTreeMap::new();
    if ranks.len() < 2 {
        return Vec::new();
    }
    let n_rows = cast.rays.counts[1];
    for first in (0..n_rows).step_by(ROWS as usize) {
        let rows = first..n_rows.min(first.saturating_add(ROWS));
        let windows: Vec<Window> = rows.map(|row| window_of_rows(cast.rays, row..row + 1)).collect();
        let of_row = |crossings: &Crossings| common_cells(crossings, cast.rule, cast.rays.depth);
        for (pair, of_row) in over_windows(cast, &windows, false, of_row).into_iter().flatten() {
            common.entry(pair).or_default().add(of_row.cells, of_row.longest);
        }
    }
    let overlap = |([high, low], Common { cells, longest }): ([u8; 2], Common)| Overlap {
        geometries: [high, low].map(|rank| ranks[usize::from(rank)]),
        cells,
        place: middle(longest, cast.rays, lines),
    };
    common.into_iter().map(overlap).collect()
}

/// The middle of a stretch of a ray, in world coordinates.
fn middle((n, ray, first): (u32, u64, u32), rays: &Rays, lines: &Lines) -> [f64; 3] {
    let n_across = u64::from(rays.counts[0]);
    let mut place = [0.0; 3];
    place[rays.across[0]] = (ray % n_across) as f64 + 0.5;
    place[rays.across[1]] = (ray / n_across) as f64 + 0.5;
    place[rays.axis] = f64::from(first) + 0.5 * f64::from(n);
    [0, 1, 2].map(|axis| lines.at(axis, place[axis]))
}

/// What each pair of ranks, the higher first, has in common.
fn common_cells(crossings: &Crossings, rule: Rule, depth: u32) -> BTreeMap<[u8; 2], Common> {
    let mut common: BTreeMap<[u8; 2], Common> = BTreeMap::new();
    crossings.for_each_ray(|ray, events| {
        let mut counts: BTreeMap<u8, i32> = BTreeMap::new();
        let mut last = 0;
        for &event in events {
            let cell = (event >> 9).min(depth);
            let is_inside = |(_, n): &(&u8, &i32)| if rule == Rule::Parity { *n & 1 != 0 } else { **n != 0 };
            if cell > last {
                let inside: Vec<u8> = counts.iter().filter(is_inside).map(|(&rank, _)| rank).collect();
                for (index, &high) in inside.iter().enumerate() {
                    for &low in &inside[..index] {
                        let n = cell - last;
                        common.entry([high, low]).or_default().add(u64::from(n), (n, ray, last));
                    }
                }
                last = cell;
            }
            *counts.entry((event >> 1) as u8).or_insert(0) += 1 - 2 * (event & 1) as i32;
        }
    });
    common
}
