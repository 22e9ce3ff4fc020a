//! The mapping of a single geometry under `parity`: its sorted crossings begin runs inside and outside in turn.
//!
//! Two crossings of the same cell cancel. Of an odd number the last begins nothing. The kernels have no twin of it: their sweep,
//! `shaders/shared/sweep.wgsl`, is for any rule.

use crate::cells::columns::{Band, run};
use crate::stages::crossings::Crossings;

/// Crossings of a ray that are sorted in registers.
const FEW: usize = 8;

/// Maps the crossings of consecutive rays and appends their runs to the band.
pub(super) fn alternate(crossings: &Crossings, flag: u8, depth: u32, band: &mut Band) {
    let mut many = Vec::new();
    for ray in crossings.offsets.windows(2) {
        let events = &crossings.events[ray[0] as usize..ray[1] as usize];
        let mut few = [u32::MAX; FEW];
        let cells = match events.len() {
            0..=FEW => {
                for index in 0..events.len() {
                    few[index] = events[index] >> 9;
                }
                if events.len() > 4 {
                    sort8(&mut few)
                } else {
                    sort4(&mut few)
                }
                &mut few[..events.len()]
            }
            _ => {
                many.clear();
                many.extend(events.iter().map(|event| event >> 9));
                many.sort_unstable();
                &mut many[..]
            }
        };
        let mut n = cells.len();
        if cells.windows(2).any(|two| two[0] == two[1]) {
            n = cancel_equal_pairs(cells);
        }
        band.odd_rays += n as u64 % 2;
        let (n, mut end) = (n - n % 2, 0);
        while end < n && cells[end] < depth {
            cells[end] = run(cells[end], if end % 2 == 0 { flag } else { 0 });
            end += 1;
        }
        band.runs.extend_from_slice(&cells[..end]);
        band.ends.push(band.runs.len() as u32);
    }
}

/// Takes pairs of equal cells out of sorted ones; returns how many are left, at the front.
#[inline(always)]
fn cancel_equal_pairs(cells: &mut [u32]) -> usize {
    let mut n = 0;
    for index in 0..cells.len() {
        let cell = cells[index];
        if n > 0 && cells[n - 1] == cell {
            n -= 1;
        } else {
            cells[n] = cell;
            n += 1;
        }
    }
    n
}

/// Sorts the first four with a network of five comparisons.
#[inline(always)]
fn sort4(v: &mut [u32; FEW]) {
    for [a, b] in [[0, 1], [2, 3], [0, 2], [1, 3], [1, 2]] {
        (v[a], v[b]) = (v[a].min(v[b]), v[a].max(v[b]));
    }
}

/// Sorts all eight with Batcher's odd-even merge network.
#[inline(always)]
fn sort8(v: &mut [u32; FEW]) {
    #[rustfmt::skip]
    let network = [
        [0, 1], [2, 3], [4, 5], [6, 7], [0, 2], [1, 3], [4, 6], [5, 7], [1, 2], [5, 6],
        [0, 4], [1, 5], [2, 6], [3, 7], [2, 4], [3, 5], [1, 2], [3, 4], [5, 6],
    ];
    for [a, b] in network {
        (v[a], v[b]) = (v[a].min(v[b]), v[a].max(v[b]));
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Mapping, Rule, count, map};
    use super::*;
    use crate::stages::crossings::event;

    #[test]
    fn networks_sort_every_pattern_of_zeros_and_ones() {
        for pattern in 0..256u32 {
            let bits: [u32; FEW] = std::array::from_fn(|place| pattern >> place & 1);
            let mut sorted = bits;
            sort8(&mut sorted);
            assert!(sorted.is_sorted() && sorted.iter().sum::<u32>() == pattern.count_ones(), "{bits:?}");
            let mut sorted = bits;
            sort4(&mut sorted);
            assert!(sorted[..4].is_sorted() && sorted[4..] == bits[4..], "{bits:?}");
        }
    }

    #[test]
    fn runs_are_those_of_the_counters() {
        // an LCG (Numerical Recipes), so that the cases are the same everywhere
        let mut state = 1u32;
        let mut below = |n: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % n
        };
        let mut crossings = Crossings { offsets: vec![0], ..Crossings::default() };
        for ray in 0..4000 {
            // few cells, so that many crossings meet in one; some lie past the end
            let n_cells = [3, 12, 40][ray % 3];
            for _ in 0..below(13) {
                crossings.events.push(event(below(n_cells + 1), 0, below(2) == 1));
            }
            crossings.offsets.push(crossings.events.len() as u32);
        }
        for depth in [3, 12, 40] {
            let mapping = Mapping { rule: Rule::Parity, flag_of_rank: &[7], depth };
            let mut expected = Band { n_crossings: crossings.events.len() as u64, ..Band::default() };
            count(&crossings, &mapping, &mut expected);
            assert_eq!(map(&crossings, &mapping), expected);
            assert!(expected.odd_rays > 1000 && expected.runs.len() > 1000);
        }
    }
}
