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
//! Cost: O(c log c) time for c crossings of a ray; 4 bytes a run. `slots` maps many rays faster.

use crate::cells::columns::{Band, run};
pub use crate::input::job::Rule;
use crate::stages::crossings::Crossings;

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
    let mut band = Band {
        first_ray: crossings.first_ray,
        ends: Vec::with_capacity(crossings.offsets.len() - 1),
        runs: vec![0; crossings.events.len()],
        odd_rays: 0,
        n_crossings: crossings.events.len() as u64,
    };
    let (mut sweep, mut end) = (Sweep::new(mapping), 0);
    crossings.for_each_ray(|_, events| {
        let (n_runs, is_odd) = sweep.ray(events, &mut band.runs[end..]);
        end += n_runs;
        band.odd_rays += u64::from(is_odd);
        band.ends.push(end as u32);
    });
    band.runs.truncate(end);
    band.runs.shrink_to_fit();
    band
}

/// Ranks that a word has a bit of.
const FEW_RANKS: usize = 64;

/// Maps ray after ray by counters: any rule and any geometries.
pub(crate) struct Sweep<'a> {
    mapping: Mapping<'a>,
    /// The counter of each rank, if there are few; 0 between rays.
    counters: [i32; FEW_RANKS],
    /// The flag where no geometry is inside, and of each rank, if there are few.
    flags: [u8; FEW_RANKS + 1],
    events: Vec<u32>,
    changes: Vec<u32>,
}

impl<'a> Sweep<'a> {
    pub(crate) fn new(mapping: &Mapping<'a>) -> Sweep<'a> {
        let mut flags = [0; FEW_RANKS + 1];
        for (flag, of_rank) in flags[1..].iter_mut().zip(mapping.flag_of_rank) {
            *flag = *of_rank;
        }
        Sweep { mapping: *mapping, counters: [0; FEW_RANKS], flags, events: Vec::new(), changes: Vec::new() }
    }

    pub(crate) fn rule(&self) -> Rule {
        self.mapping.rule
    }

    pub(crate) fn depth(&self) -> u32 {
        self.mapping.depth
    }

    /// The flag of each rank, if there are few.
    #[inline(always)]
    pub(crate) fn flags(&self) -> Option<&[u8; FEW_RANKS]> {
        (self.mapping.flag_of_rank.len() <= FEW_RANKS).then(|| self.flags[1..].try_into().expect("a flag less"))
    }

    /// Writes the runs of a ray, at most one a crossing, given its crossings in order; returns how many there are, and whether a counter
    /// stays open.
    #[inline(always)]
    pub(crate) fn ray(&mut self, events: &[u32], runs: &mut [u32]) -> (usize, bool) {
        if self.mapping.flag_of_rank.len() <= FEW_RANKS {
            let closed = match self.mapping.rule {
                Rule::Parity => self.of_few(events, runs, |_, inside, rank, _| inside ^ 1 << rank),
                Rule::Nonzero => self.of_few(events, runs, |counters, inside, rank, step| {
                    counters[rank] += step;
                    inside & !(1 << rank) | u64::from(counters[rank] != 0) << rank
                }),
            };
            if let Some(n_runs) = closed {
                return (n_runs, false);
            }
            self.counters = [0; FEW_RANKS];
        }
        self.of_any(events, runs)
    }

    /// Of few ranks: one pass, with the set of those that are inside, which a crossing changes. None if one stays inside.
    #[inline(always)]
    fn of_few(
        &mut self,
        events: &[u32],
        runs: &mut [u32],
        crossed: impl Fn(&mut [i32; FEW_RANKS], u64, usize, i32) -> u64,
    ) -> Option<usize> {
        let (mut inside, mut flag, mut n_runs) = (0u64, 0, 0);
        for (at, &event) in events.iter().enumerate() {
            let (cell, rank) = (event >> 9, (event >> 1) as usize % FEW_RANKS);
            inside = crossed(&mut self.counters, inside, rank, 1 - 2 * (event & 1) as i32);
            let ends_cell = events.get(at + 1).is_none_or(|next| next >> 9 != cell);
            let winner = self.flags[FEW_RANKS - inside.leading_zeros() as usize];
            if ends_cell && winner != flag && cell < self.mapping.depth {
                runs[n_runs] = run(cell, winner);
                n_runs += 1;
                flag = winner;
            }
        }
        (inside == 0).then_some(n_runs)
    }

    /// Of any number of ranks, and where surfaces are open.
    fn of_any(&mut self, events: &[u32], runs: &mut [u32]) -> (usize, bool) {
        self.events.clear();
        self.events.extend(events.iter().copied().map(by_rank));
        self.changes.clear();
        let is_odd = insides(&mut self.events, self.mapping.rule, &mut self.changes);
        (sweep(&mut self.changes, &self.mapping, runs), is_odd)
    }
}

/// A crossing as `rank << 24 | cell << 1 | direction`: sorted by rank, then by cell.
#[inline(always)]
fn by_rank(event: u32) -> u32 {
    event << 23 & 0xff00_0000 | event >> 9 << 1 | event & 1
}

/// Finds where each geometry begins and ends along a ray, as `cell << 8 | rank`; true if a counter stays open.
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

/// Sweeps the beginnings and ends of all geometries along a ray and writes a run wherever the winning flag changes; returns how many.
fn sweep(changes: &mut [u32], mapping: &Mapping, runs: &mut [u32]) -> usize {
    if mapping.flag_of_rank.len() > 1 {
        changes.sort_unstable();
    }
    let mut inside = [0u32; 8];
    let (mut flag, mut n_runs) = (0, 0);
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
            runs[n_runs] = run(cell, winner);
            n_runs += 1;
            flag = winner;
        }
    }
    n_runs
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
