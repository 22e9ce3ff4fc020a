//! Overlaps: cells that lie inside of two geometries, of which one wins.
//!
//! Cost: one cast of all rays on the host.

use std::collections::BTreeMap;

use crate::cast::Cast;
use crate::cpu::{Window, over_windows, window_of_rows};
use crate::crossings::Crossings;
use crate::job::Rule;

/// Rows of rays that are cast together.
const ROWS: u32 = 1 << 10;

/// Two geometries with common cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Overlap {
    /// Index in the job of the one that wins, and of the other.
    pub geometries: [usize; 2],
    /// Cells inside of both.
    pub cells: u64,
}

/// Finds all, in the order of their ranks.
pub(super) fn overlaps(cast: &Cast) -> Vec<Overlap> {
    let ranks = &cast.frame.ranks.geometry_of_rank;
    let mut cells: BTreeMap<[u8; 2], u64> = BTreeMap::new();
    if ranks.len() < 2 {
        return Vec::new();
    }
    let n_rows = cast.rays.counts[1];
    for first in (0..n_rows).step_by(ROWS as usize) {
        let rows = first..n_rows.min(first.saturating_add(ROWS));
        let windows: Vec<Window> = rows.map(|row| window_of_rows(cast.rays, row..row + 1)).collect();
        let of_row = |crossings: &Crossings| common_cells(crossings, cast.rule, cast.rays.depth);
        for (pair, n) in over_windows(cast, &windows, false, of_row).into_iter().flatten() {
            *cells.entry(pair).or_insert(0) += n;
        }
    }
    let overlap = |([high, low], cells): ([u8; 2], u64)| Overlap {
        geometries: [high, low].map(|rank| ranks[usize::from(rank)]),
        cells,
    };
    cells.into_iter().map(overlap).collect()
}

/// Cells of each pair of ranks, the higher first.
fn common_cells(crossings: &Crossings, rule: Rule, depth: u32) -> BTreeMap<[u8; 2], u64> {
    let mut cells = BTreeMap::new();
    crossings.for_each_ray(|_, events| {
        let mut counts: BTreeMap<u8, i32> = BTreeMap::new();
        let mut last = 0;
        for &event in events {
            let cell = (event >> 9).min(depth);
            let is_inside = |(_, n): &(&u8, &i32)| if rule == Rule::Parity { *n & 1 != 0 } else { **n != 0 };
            if cell > last {
                let inside: Vec<u8> = counts.iter().filter(is_inside).map(|(&rank, _)| rank).collect();
                for (index, &high) in inside.iter().enumerate() {
                    for &low in &inside[..index] {
                        *cells.entry([high, low]).or_insert(0) += u64::from(cell - last);
                    }
                }
                last = cell;
            }
            *counts.entry((event >> 1) as u8).or_insert(0) += 1 - 2 * (event & 1) as i32;
        }
    });
    cells
}
