//! Rays cast and mapped in one go, eight at a time: what `map` makes of `crossings`, several times faster.
//!
//! A bin row of a lattice, [`Mapping`] -> [`Band`]. The first eight crossings of each ray go to slots: the first slots of all rays
//! stand one after another, then the second ones, so that a network sorts the slots of eight neighbouring rays at once, with the
//! processor's instructions for eight numbers. The further crossings of rays that have more go to a list. Under `parity` a single
//! geometry needs 15 bits a crossing, its cell, where rays are not longer; else a crossing is a word, as in `crossings`.
//!
//! Cost: O(rows of facets + crossings) time; 16 or 32 bytes a ray and 4 a run, which are used again for the next rows.

use std::ops::Range;

use crate::base::network::{self, SLOTS};
use crate::base::sort::by_number;
use crate::cells::columns::{Band, run};
use crate::grid::frame::Frame;
use crate::grid::rays::Rays;
use crate::stages::crossings::rows::{Height, Rows};
use crate::stages::crossings::{event, hits};
use crate::stages::facet::Projected;
use crate::stages::lattice::Lattice;
use crate::stages::map::{Mapping, Rule, Sweep};

/// Rays whose slots are sorted at once.
const LANES: usize = 8;
/// The bits of a crossing below its cell, and those of its rank.
const CELL_BITS: u32 = 9;
const RANK: i32 = 0x1fe;
/// The same slot of such rays.
type Lane<K> = [K; LANES];

/// A crossing as a number that sorts by cell. Those of empty slots are greater than any.
trait Key: Copy + Ord + Default {
    /// Of a cell, and of rank and direction as [`event`] packs them.
    fn new(cell: u32, tag: u32) -> Self;
    /// What stands in the empty slot of this index; no two are equal.
    fn empty(slot: usize) -> Self;
    /// What [`Mapper`] gets: the cell, or the crossing.
    fn word(self) -> u32;
}

/// A cell.
impl Key for i16 {
    #[inline(always)]
    fn new(cell: u32, _: u32) -> i16 {
        cell as i16
    }

    #[inline(always)]
    fn empty(slot: usize) -> i16 {
        i16::MAX - slot as i16
    }

    #[inline(always)]
    fn word(self) -> u32 {
        self as u32
    }
}

/// The longest rays whose cells, and the end, are smaller than all empty slots.
const MAX_DEPTH_OF_CELLS: u32 = (i16::MAX as usize - SLOTS) as u32;

/// A cell, a rank, and a direction.
impl Key for i32 {
    #[inline(always)]
    fn new(cell: u32, tag: u32) -> i32 {
        (cell << CELL_BITS | tag) as i32
    }

    #[inline(always)]
    fn empty(slot: usize) -> i32 {
        i32::MAX - slot as i32
    }

    #[inline(always)]
    fn word(self) -> u32 {
        self as u32
    }
}

/// Bytes of a ray, where rays of so many cells are cast at so many geometries: its slots, how many are in use, and where its runs end.
pub fn bytes_of_ray(rule: Rule, n_geometries: usize, depth: u32) -> u64 {
    let key = if has_cells_alone(rule, n_geometries, depth) { size_of::<i16>() } else { size_of::<i32>() };
    (SLOTS * key + size_of::<u8>() + size_of::<u32>()) as u64
}

/// Whether the cell of a crossing says all.
fn has_cells_alone(rule: Rule, n_ranks: usize, depth: u32) -> bool {
    rule == Rule::Parity && n_ranks == 1 && depth <= MAX_DEPTH_OF_CELLS
}

/// Memory that a core uses for strip after strip.
#[derive(Default)]
pub(crate) struct Scratch {
    cells: Slots<i16>,
    events: Slots<i32>,
    runs: Vec<u32>,
}

/// Casts the rays of one bin row of a lattice, whose bins are as wide as the domain, and maps their crossings.
pub(crate) fn band(
    (frame, rays): (&Frame, &Rays),
    lattice: &Lattice,
    row: u32,
    mapping: &Mapping,
    scratch: &mut Scratch,
) -> Band {
    let first = row * lattice.bin[1];
    let rows = first..(first + lattice.bin[1]).min(rays.counts[1]);
    let facets = lattice.bin_facets(0, row);
    let Scratch { cells, events, runs } = scratch;
    match *mapping {
        Mapping { rule, flag_of_rank: &[flag], depth } if has_cells_alone(rule, 1, depth) => {
            cells.cast((frame, rays), facets, &rows);
            cells.map(&rows, runs, Alternating { flag, depth })
        }
        _ => {
            events.cast((frame, rays), facets, &rows);
            events.map(&rows, runs, Sweep::new(mapping))
        }
    }
}

/// The crossings of some rows of rays.
#[derive(Default)]
struct Slots<K> {
    /// Rays, and some more, so that a whole number of lanes holds them.
    stride: usize,
    /// The first slot of all rays, then the second, ...
    slots: Vec<K>,
    /// How many slots of each ray are in use.
    counts: Vec<u8>,
    /// Ray and crossing, of rays whose slots are all in use.
    further: Vec<(u32, K)>,
    /// First row of rays, and rays of a row.
    first: u32,
    n_across: u32,
    /// Rank and direction of the facet that is cast.
    tag: u32,
}

impl<K: Key> Rows for Slots<K> {
    #[inline(always)]
    fn row(&mut self, j: u32, across: Range<u32>, hits: impl Iterator<Item = (u32, Height)>) {
        let start = ((j - self.first) * self.n_across + across.start) as usize;
        let rays = start..start + across.len();
        let (tag, stride, slots) = (self.tag, self.stride, &mut self.slots[..]);
        for (((above, _), count), ray) in hits.zip(&mut self.counts[rays.clone()]).zip(rays) {
            let key = K::new(above, tag);
            let slot = usize::from(*count);
            if slot < SLOTS {
                slots[slot * stride + ray] = key;
                *count += 1;
            } else {
                self.further.push((ray as u32, key));
            }
        }
    }
}

impl<K: Key> Slots<K> {
    /// Begins with rows of rays that have no crossings.
    fn clear(&mut self, n_across: u32, rows: &Range<u32>) {
        let n_rays = rows.len() * n_across as usize;
        (self.first, self.n_across) = (rows.start, n_across);
        // the same slots of all rays do not fall on the same lines of the cache
        self.stride = n_rays.next_multiple_of(LANES) + 8 * LANES;
        self.slots.resize(self.slots.len().max(SLOTS * self.stride), K::default());
        self.counts.clear();
        self.counts.resize(self.stride, 0);
        self.further.clear();
    }

    /// Casts rows of rays at facets.
    fn cast(&mut self, (frame, rays): (&Frame, &Rays), facets: &[u32], rows: &Range<u32>) {
        self.clear(rays.counts[0], rows);
        let window = [0..rays.counts[0], rows.clone()];
        for &facet in facets {
            let Some(projected) = Projected::new(&frame.facets[facet as usize], frame, rays) else { continue };
            self.tag = event(0, frame.rank_of_facet(facet as usize), projected.exits);
            hits(&projected, (frame, rays), &window, self);
        }
    }

    /// Maps what was cast.
    fn map(&self, rows: &Range<u32>, runs: &mut Vec<u32>, mut mapper: impl Mapper<K>) -> Band {
        let n_rays = rows.len() * self.n_across as usize;
        let n_crossings = self.counts.iter().map(|&count| u64::from(count)).sum::<u64>() + self.further.len() as u64;
        let further = (!self.further.is_empty()).then(|| {
            let (mut offsets, mut keys) = (Vec::new(), Vec::new());
            by_number(self.further.iter().copied(), self.stride, &mut offsets, &mut keys);
            (offsets, keys)
        });
        // the lanes write all slots of a ray, of which the next ray overwrites those that are no runs
        runs.resize(runs.len().max(n_crossings as usize + SLOTS), 0);
        let mut band = Band {
            first_ray: u64::from(rows.start) * u64::from(self.n_across),
            ends: Vec::with_capacity(n_rays.next_multiple_of(LANES)),
            n_crossings,
            ..Band::default()
        };
        let (mut end, mut many) = (0, Vec::new());
        for first in (0..n_rays).step_by(LANES) {
            let counts: Lane<u8> = self.counts[first..first + LANES].try_into().expect("lanes");
            let most = counts.into_iter().max().unwrap_or(0);
            if most == 0 {
                band.ends.extend([end as u32; LANES]);
                continue;
            }
            let sorted = self.sorted(first, &counts, most);
            let found = mapper.lanes(&sorted, &counts);
            for lane in 0..LANES {
                let further = further.as_ref().map_or(&[][..], |(offsets, keys)| {
                    &keys[offsets[first + lane] as usize..offsets[first + lane + 1] as usize]
                });
                let (n_runs, is_odd) = if !further.is_empty() {
                    many.clear();
                    many.extend(sorted.iter().map(|slot| slot[lane].word()));
                    many.extend(further.iter().map(|key| key.word()));
                    many.sort_unstable();
                    mapper.ray(&mut many, &mut runs[end..])
                } else {
                    mapper.lane(&found, &sorted, lane, counts[lane], &mut runs[end..])
                };
                end += n_runs;
                band.odd_rays += u64::from(is_odd);
                band.ends.push(end as u32);
            }
        }
        band.ends.truncate(n_rays);
        band.runs = runs[..end].to_vec();
        band
    }

    /// The slots of rays, sorted; those that are not in use come last.
    #[inline(always)]
    fn sorted(&self, first: usize, counts: &Lane<u8>, most: u8) -> [Lane<K>; SLOTS] {
        network::sorted((&self.slots[first..], self.stride), counts, most, K::empty)
    }
}

/// What makes runs of the sorted crossings of rays.
trait Mapper<K> {
    /// What it finds in all lanes at once.
    type Found;

    fn lanes(&mut self, sorted: &[Lane<K>; SLOTS], counts: &Lane<u8>) -> Self::Found;

    /// Writes the runs of the ray of a lane, with space for one a slot; returns how many there are, and whether a surface is open there.
    fn lane(
        &mut self,
        found: &Self::Found,
        sorted: &[Lane<K>; SLOTS],
        lane: usize,
        count: u8,
        runs: &mut [u32],
    ) -> (usize, bool);

    /// The same of any ray, given its crossings in order.
    fn ray(&mut self, words: &mut [u32], runs: &mut [u32]) -> (usize, bool);
}

/// Any rule and any geometries.
impl Mapper<i32> for Sweep<'_> {
    type Found = Paired;

    #[inline(always)]
    fn lanes(&mut self, sorted: &[Lane<i32>; SLOTS], counts: &Lane<u8>) -> Paired {
        let differing = match self.rule() {
            Rule::Parity => RANK,
            Rule::Nonzero => RANK | 1,
        };
        let equal = differing & 1;
        let depth = (self.depth() << CELL_BITS) as i32;
        let (mut n_below, mut apart) = ([0i32; LANES], [0i32; LANES]);
        for slot in 0..SLOTS {
            for lane in 0..LANES {
                n_below[lane] += i32::from(sorted[slot][lane] < depth);
            }
        }
        for pair in sorted.chunks_exact(2) {
            for lane in 0..LANES {
                apart[lane] |= (pair[0][lane] ^ pair[1][lane]) & differing ^ equal;
            }
        }
        for slot in 1..SLOTS {
            for lane in 0..LANES {
                let meet = (sorted[slot][lane] ^ sorted[slot - 1][lane]) >> CELL_BITS == 0;
                apart[lane] |= i32::from(meet & (counts[lane] > slot as u8));
            }
        }
        let few = self.flags().is_some();
        let is_paired = std::array::from_fn(|lane| few && counts[lane].is_multiple_of(2) && apart[lane] == 0);
        Paired { n_runs: std::array::from_fn(|lane| (n_below[lane] as u8).min(counts[lane])), is_paired }
    }

    #[inline(always)]
    fn lane(
        &mut self,
        found: &Paired,
        sorted: &[Lane<i32>; SLOTS],
        lane: usize,
        count: u8,
        runs: &mut [u32],
    ) -> (usize, bool) {
        let events = sorted.map(|slot| slot[lane].word());
        match self.flags() {
            Some(flags) if found.is_paired[lane] => {
                let runs = &mut runs[..SLOTS];
                for slot in 0..SLOTS {
                    let rank = (events[slot] as i32 & RANK) as usize / 2;
                    runs[slot] =
                        run(events[slot] >> CELL_BITS, if slot % 2 == 0 { flags[rank % flags.len()] } else { 0 });
                }
                (found.n_runs[lane].into(), false)
            }
            _ => Sweep::ray(self, &events[..usize::from(count)], runs),
        }
    }

    fn ray(&mut self, events: &mut [u32], runs: &mut [u32]) -> (usize, bool) {
        Sweep::ray(self, events, runs)
    }
}

/// Rays that leave each geometry before they enter the next, in other cells, and how many runs they have.
struct Paired {
    n_runs: Lane<u8>,
    is_paired: Lane<bool>,
}

/// A single geometry under `parity`: its sorted crossings begin runs inside and outside in turn.
///
/// Two crossings of the same cell cancel. Of an odd number the last begins nothing. The kernels have no twin of it: their sweep,
/// `shaders/shared/sweep.wgsl`, is for any rule.
struct Alternating {
    flag: u8,
    depth: u32,
}

/// How many runs each lane has, and whether crossings meet in a cell and may cancel each other.
struct Alternated {
    n_runs: Lane<u8>,
    meet: Lane<bool>,
}

impl Mapper<i16> for Alternating {
    type Found = Alternated;

    #[inline(always)]
    fn lanes(&mut self, sorted: &[Lane<i16>; SLOTS], counts: &Lane<u8>) -> Alternated {
        let (mut n_below, mut meet) = ([0i16; LANES], [false; LANES]);
        for slot in sorted {
            for lane in 0..LANES {
                n_below[lane] += i16::from(slot[lane] < self.depth as i16);
            }
        }
        for slot in 1..SLOTS {
            for lane in 0..LANES {
                meet[lane] |= sorted[slot][lane] == sorted[slot - 1][lane];
            }
        }
        let n_runs = std::array::from_fn(|lane| (counts[lane] & !1).min(n_below[lane] as u8));
        Alternated { n_runs, meet }
    }

    #[inline(always)]
    fn lane(
        &mut self,
        found: &Alternated,
        sorted: &[Lane<i16>; SLOTS],
        lane: usize,
        count: u8,
        runs: &mut [u32],
    ) -> (usize, bool) {
        if found.meet[lane] {
            let mut cells = sorted.map(|slot| slot[lane].word());
            return self.ray(&mut cells[..usize::from(count)], runs);
        }
        let runs = &mut runs[..SLOTS];
        for slot in 0..SLOTS {
            runs[slot] = run(sorted[slot][lane].word(), if slot % 2 == 0 { self.flag } else { 0 });
        }
        (found.n_runs[lane].into(), count % 2 == 1)
    }

    fn ray(&mut self, cells: &mut [u32], runs: &mut [u32]) -> (usize, bool) {
        let n = cancel_equal_pairs(cells);
        let below = cells[..n - n % 2].iter().take_while(|&&cell| cell < self.depth);
        let mut n_runs = 0;
        for (slot, &cell) in below.enumerate() {
            runs[slot] = run(cell, if slot % 2 == 0 { self.flag } else { 0 });
            n_runs += 1;
        }
        (n_runs, n % 2 == 1)
    }
}

/// Takes pairs of equal cells out of sorted ones; returns how many are left, at the front.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stages::crossings::Crossings;
    use crate::stages::map::map;

    /// A number below n, from an LCG (Numerical Recipes), so that the cases are the same everywhere.
    fn below(state: &mut u32, n: u32) -> u32 {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*state >> 8) % n
    }

    /// The band of three rows of rays, given the crossings of each ray: cell, rank and direction.
    fn band_of<K: Key>(of_rays: &[Vec<[u32; 3]>], mapper: impl Mapper<K>) -> Band {
        let (rows, mut slots, mut runs) = (5..8, Slots::<K>::default(), Vec::new());
        let n_across = of_rays.len() / 3;
        // what an earlier strip left there
        slots.slots = vec![K::new(1, 0); 4 * of_rays.len()];
        slots.clear(n_across as u32, &rows);
        // one crossing of each ray after the other, as facets come
        for turn in 0..of_rays.iter().map(Vec::len).max().unwrap_or(0) {
            for (ray, crossings) in of_rays.iter().enumerate() {
                let Some(&[cell, rank, direction]) = crossings.get(turn) else { continue };
                slots.tag = event(0, rank as u8, direction == 1);
                let (i, j) = ((ray % n_across) as u32, 5 + (ray / n_across) as u32);
                slots.row(j, i..i + 1, std::iter::once((cell, Height::default())));
            }
        }
        slots.map(&rows, &mut runs, mapper)
    }

    #[test]
    fn bands_are_those_of_the_mapping() {
        let mut state = 1u32;
        for (case, n_ranks) in [1, 1, 1, 2, 7, 64, 65, 255].into_iter().enumerate() {
            let n_rays = 3 * [1, 5, 8, 401][case % 4];
            let mut of_rays = Vec::new();
            for ray in 0..n_rays {
                // few cells, so that many crossings meet in one; some lie past the end
                let n_cells = [3, 12, 40, 30_000][ray % 4];
                let mut crossings = Vec::new();
                for _ in 0..below(&mut state, [2, 5, 9, 25][ray / 4 % 4]) {
                    let rank = below(&mut state, n_ranks);
                    let mut cross = |direction| crossings.push([below(&mut state, n_cells + 1), rank, direction]);
                    cross(0);
                    if ray % 16 != 3 {
                        cross(1);
                    }
                }
                of_rays.push(crossings);
            }
            let mut crossings =
                Crossings { first_ray: 5 * (n_rays as u64 / 3), offsets: vec![0], ..Crossings::default() };
            for of_ray in &of_rays {
                crossings
                    .events
                    .extend(of_ray.iter().map(|&[cell, rank, direction]| event(cell, rank as u8, direction == 1)));
                crossings.offsets.push(crossings.events.len() as u32);
            }
            let flags: Vec<u8> = (0..n_ranks).map(|rank| (rank % 3 * 40 + 7) as u8).collect();
            for rule in [Rule::Parity, Rule::Nonzero] {
                for depth in [3, 12, 40, 30_000] {
                    let mapping = Mapping { rule, flag_of_rank: &flags, depth };
                    let expected = map(&crossings, &mapping);
                    assert_eq!(band_of::<i32>(&of_rays, Sweep::new(&mapping)), expected, "{n_ranks} {rule:?} {depth}");
                    if let (Rule::Parity, &[flag]) = (rule, &flags[..]) {
                        assert_eq!(band_of::<i16>(&of_rays, Alternating { flag, depth }), expected, "{depth}");
                    }
                    assert!(n_rays < 1000 || expected.odd_rays > 10 && expected.runs.len() > 500);
                }
            }
        }
    }
}
