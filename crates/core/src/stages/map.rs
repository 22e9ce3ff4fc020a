//! Mapping: the crossings of a ray, sorted and swept once, become its runs.
//!
//! Crossings, a rule -> [`Band`] of columns. For each geometry a counter runs along the ray: `parity` counts crossings
//! modulo 2, `nonzero` adds 1 where the ray enters and subtracts 1 where it leaves. Cells with a non-zero counter are
//! inside. Where several geometries claim a cell the highest rank wins. A run starts wherever the winning flag changes.
//! A crossing names the first cell above it, so cell i is inside iff `low < i <= high` in centres (Eq. 20).
//!
//! Degenerate cases: crossings of one geometry in the same cell act together, so their order cannot matter. A counter that
//! does not return to zero means that the surface is open there: the ray is counted as odd, and cells are inside the
//! geometry only up to the last cell where its counter was zero.
//!
//! Source: the paper, section 2.4 and Eq. 20; the counters are ours. Twin: `shaders/map.wgsl`.
//! Cost: O(c log c) time for c crossings of a ray; 4 bytes a run. A single geometry under `parity` needs no
//! counters: `map/alternate.rs`.

use crate::cells::columns::{Band, run};
pub use crate::input::job::Rule;
use crate::stages::crossings::Crossings;

mod alternate;

/// What the mapping needs besides the crossings.
#[derive(Debug, Clone, Copy)]
pub struct Mapping<'a> {
    /// What is inside.
    pub rule: Rule,
    /// Property flag of each rank; a higher rank wins.
    pub flag_of_rank: &'a [u8],
    /// Number of cells of a ray.
    pub depth: u32,
}

/// Maps the crossings of consecutive rays to runs.
pub fn map(crossings: &Crossings, mapping: &Mapping) -> Band {
    let n_rays = crossings.offsets.len() - 1;
    let mut band = Band {
        first_ray: crossings.first_ray,
        ends: Vec::with_capacity(n_rays),
        runs: Vec::with_capacity(crossings.events.len()),
        odd_rays: 0,
        n_crossings: crossings.events.len() as u64,
    };
    match mapping {
        &Mapping { rule: Rule::Parity, flag_of_rank: &[flag], depth } => {
            alternate::alternate(crossings, flag, depth, &mut band);
        }
        _ => count(crossings, mapping, &mut band),
    }
    band.runs.shrink_to_fit();
    band
}

/// Maps by counters: any rule and any geometries.
fn count(crossings: &Crossings, mapping: &Mapping, band: &mut Band) {
    let mut events = Vec::new();
    let mut changes = Vec::new();
    for ray in crossings.offsets.windows(2) {
        events.clear();
        events.extend(crossings.events[ray[0] as usize..ray[1] as usize].iter().copied().map(by_rank));
        if !events.is_empty() {
            changes.clear();
            band.odd_rays += u64::from(insides(&mut events, mapping.rule, &mut changes));
            sweep(&mut changes, mapping, &mut band.runs);
        }
        band.ends.push(band.runs.len() as u32);
    }
}

/// A crossing as `rank << 24 | cell << 1 | direction`: sorted by rank, then by cell.
#[inline(always)]
fn by_rank(event: u32) -> u32 {
    event << 23 & 0xff00_0000 | event >> 9 << 1 | event & 1
}

/// Finds where each geometry begins and ends along a ray, as `cell << 8 | rank`; true if a counter stays open.
#[inline(always)]
fn insides(events: &mut [u32], rule: Rule, changes: &mut Vec<u32>) -> bool {
    events.sort_unstable();
    let mut odd = false;
    let mut at = 0;
    while at < events.len() {
        let rank = events[at] >> 24;
        let start = changes.len();
        let mut counter = 0i32;
        while at < events.len() && events[at] >> 24 == rank {
            let rank_and_cell = events[at] >> 1;
            let was_inside = counter != 0;
            while at < events.len() && events[at] >> 1 == rank_and_cell {
                counter = match rule {
                    Rule::Parity => counter ^ 1,
                    Rule::Nonzero => counter + 1 - 2 * (events[at] & 1) as i32,
                };
                at += 1;
            }
            if was_inside != (counter != 0) {
                changes.push(rank_and_cell << 9 >> 1 | rank);
            }
        }
        if counter != 0 {
            odd = true;
            // the interval that never ends was the last to begin
            changes.pop();
        }
        debug_assert!((changes.len() - start).is_multiple_of(2));
    }
    odd
}

/// Sweeps the beginnings and ends of all geometries along a ray and appends a run wherever the winning flag changes.
#[inline(always)]
fn sweep(changes: &mut [u32], mapping: &Mapping, runs: &mut Vec<u32>) {
    if mapping.flag_of_rank.len() > 1 {
        changes.sort_unstable();
    }
    let mut inside = [0u32; 8];
    let mut flag = 0;
    let mut at = 0;
    while at < changes.len() {
        let cell = changes[at] >> 8;
        if cell >= mapping.depth {
            break;
        }
        while at < changes.len() && changes[at] >> 8 == cell {
            let rank = changes[at] & 0xff;
            inside[(rank / 32) as usize] ^= 1 << (rank % 32);
            at += 1;
        }
        let winner = highest_rank(&inside).map_or(0, |rank| mapping.flag_of_rank[rank]);
        if winner != flag {
            runs.push(run(cell, winner));
            flag = winner;
        }
    }
}

#[inline(always)]
fn highest_rank(inside: &[u32; 8]) -> Option<usize> {
    let word = (0..8).rev().find(|&word| inside[word] != 0)?;
    Some(word * 32 + 31 - inside[word].leading_zeros() as usize)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stages::crossings::event;

    const ENTER: bool = false;
    const EXIT: bool = true;

    fn map_ray(events: &[(u32, u8, bool)], rule: Rule, flags: &[u8]) -> (Vec<(u32, u8)>, u64) {
        let mut results = Vec::new();
        // the order of crossings must not matter: as given and reversed
        for reversed in [false, true] {
            let mut packed: Vec<u32> = events.iter().map(|&(cell, rank, exits)| event(cell, rank, exits)).collect();
            if reversed {
                packed.reverse();
            }
            let crossings = Crossings { offsets: vec![0, packed.len() as u32], events: packed, ..Crossings::default() };
            let band = map(&crossings, &Mapping { rule, flag_of_rank: flags, depth: 100 });
            results.push((band.runs.iter().map(|r| (r >> 8, (r & 0xff) as u8)).collect::<Vec<_>>(), band.odd_rays));
        }
        assert_eq!(results[0], results[1]);
        results.remove(0)
    }

    #[test]
    fn a_body_is_the_cells_between_its_crossings() {
        let (runs, odd) = map_ray(&[(3, 0, ENTER), (7, 0, EXIT)], Rule::Parity, &[5]);
        assert_eq!((runs, odd), (vec![(3, 5), (7, 0)], 0));
    }

    #[test]
    fn crossings_in_one_cell_cancel_and_touching_intervals_join() {
        let events = [(3, 0, ENTER), (3, 0, EXIT), (5, 0, ENTER), (8, 0, EXIT), (8, 0, ENTER), (9, 0, EXIT)];
        for rule in [Rule::Parity, Rule::Nonzero] {
            assert_eq!(map_ray(&events, rule, &[1]).0, vec![(5, 1), (9, 0)]);
        }
    }

    #[test]
    fn an_inner_shell_is_a_hole_for_parity_and_solid_for_nonzero() {
        let events = [(1, 0, ENTER), (3, 0, ENTER), (5, 0, EXIT), (9, 0, EXIT)];
        assert_eq!(map_ray(&events, Rule::Parity, &[1]).0, vec![(1, 1), (3, 0), (5, 1), (9, 0)]);
        assert_eq!(map_ray(&events, Rule::Nonzero, &[1]).0, vec![(1, 1), (9, 0)]);
    }

    #[test]
    fn the_higher_rank_wins_and_the_lower_returns_after_it() {
        let events = [(1, 0, ENTER), (9, 0, EXIT), (3, 1, ENTER), (5, 1, EXIT)];
        assert_eq!(map_ray(&events, Rule::Parity, &[1, 2]).0, vec![(1, 1), (3, 2), (5, 1), (9, 0)]);
        let events = [(1, 1, ENTER), (9, 1, EXIT), (3, 0, ENTER), (5, 0, EXIT)];
        assert_eq!(map_ray(&events, Rule::Parity, &[1, 2]).0, vec![(1, 2), (9, 0)]);
        let events = [(1, 254, ENTER), (9, 254, EXIT), (3, 31, ENTER), (12, 32, EXIT), (4, 31, EXIT), (2, 32, ENTER)];
        let flags: Vec<u8> = (1..=255).collect();
        assert_eq!(map_ray(&events, Rule::Parity, &flags).0, vec![(1, 255), (9, 33), (12, 0)]);
    }

    #[test]
    fn an_open_surface_counts_up_to_the_last_matched_pair() {
        let events = [(1, 0, ENTER), (3, 0, EXIT), (6, 0, ENTER)];
        for rule in [Rule::Parity, Rule::Nonzero] {
            assert_eq!(map_ray(&events, rule, &[1]), (vec![(1, 1), (3, 0)], 1));
        }
        // winding 1, 2, 1 and never back to 0
        let events = [(1, 0, ENTER), (3, 0, ENTER), (6, 0, EXIT)];
        assert_eq!(map_ray(&events, Rule::Nonzero, &[1]), (vec![], 1));
    }

    #[test]
    fn bodies_that_reach_past_the_domain_end_with_it() {
        let events = [(0, 0, ENTER), (0, 0, EXIT), (0, 0, ENTER), (100, 0, EXIT)];
        assert_eq!(map_ray(&events, Rule::Parity, &[1]), (vec![(0, 1)], 0));
        let beyond = [(100, 0, ENTER), (100, 0, EXIT)];
        assert_eq!(map_ray(&beyond, Rule::Parity, &[1]), (vec![], 0));
    }
}
