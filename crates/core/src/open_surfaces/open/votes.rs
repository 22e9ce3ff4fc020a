//! Votes: the cells of an open geometry, from the rays of three axes, and where these are in doubt from the winding number.
//!
//! Facets, caps, rays -> [`Votes`], then row after row of rays the runs of the geometry. a is the axis of the rays, b and c are
//! the axes across. A row of rays is a plane of cells along a and b; its cells are looked at 64 along b at a time. Rays along b
//! lie in the plane, those along a start in it, those along c go through it: of these a bit each is kept from plane to plane.
//!
//! Cost: some 5 ns a crossing and 3 ns for 64 cells.

use std::ops::Range;

use super::OpenPart;
use super::caps::Shift;
use crate::base::sort::sort_by_key;
use crate::cells::columns::{Band, CellRun, run};
use crate::grid::frame::{Frame, moved};
use crate::grid::rays::Rays;
use crate::input::geometry::Open;
use crate::input::job::Rule;
use crate::stages::axis_crossings::{
    AxisCasts, AxisCrossings, EXITS, Words, grouped, of_planes, place_of, row_of, take_row,
};
use crate::stages::inside::is_inside;

/// Everything that decides the cells of an open geometry.
pub(crate) struct Votes {
    rays: Rays,
    rule: Rule,
    policy: Open,
    /// Where each ray along a, b and c goes in or out.
    turns: [Words; 3],
    /// Planes, ascending, and how many crossings of the rays along a in each are neither.
    uncounted: Vec<(u32, u64)>,
    /// Crossings along a of the surface and of what closes it.
    closed: Words,
    /// Cells, a row of the plane at a time, whose winding number the caps move: plane, row, places, by how much.
    shifts: Vec<(u32, u32, Range<u32>, i32)>,
    /// Odd bits of the rays along c: a bit a place, `n_words` words a row.
    odd_c: Vec<u64>,
    /// Rays of x, y and z that do not leave what they enter.
    pub(crate) odd_rays: [u64; 3],
    n_words: usize,
}

/// What rays along c know between two planes: whether they are inside.
#[derive(Clone)]
pub(crate) struct Through {
    /// The next plane.
    pub(crate) plane: u32,
    inside: Vec<u64>,
}

/// The rows of one geometry.
pub(crate) struct Rows {
    /// Its columns, with the flag 1.
    pub(crate) band: Band,
    /// Its doubtful cells, ascending.
    pub(crate) doubt: Vec<CellRun>,
}

impl Votes {
    /// The rays that decide a part.
    pub(crate) fn casts(part: &OpenPart, frame: &Frame, rays: &Rays, rule: Rule) -> Vec<AxisCasts> {
        let is_counted = rule == Rule::Nonzero;
        let mut axes: Vec<(usize, bool)> = axes(rays).map(|axis| (axis, is_counted)).into();
        if part.policy != Open::Winding {
            return vec![AxisCasts { frame: frame.with_facets(part.facets.clone()), axes }];
        }
        if is_counted {
            axes.push((rays.axis, false));
        }
        let by = part.first.1.map(|place| -place);
        let caps = part.caps.iter().map(|cap| moved(cap, by));
        let closing = part.patches.iter().copied().chain(caps).collect();
        vec![
            AxisCasts { frame: frame.with_facets(part.facets.clone()), axes },
            AxisCasts { frame: frame.with_facets(closing), axes: vec![(rays.axis, false)] },
        ]
    }

    /// Decides a part by what [`Votes::casts`] asked for, and by [`OpenPart::shifts`].
    pub(crate) fn new(
        part: &OpenPart,
        crossings: Vec<AxisCrossings>,
        shifts: &[Shift],
        rays: &Rays,
        rule: Rule,
    ) -> Votes {
        let mut crossings = crossings.into_iter();
        let mut odd_rays = [0; 3];
        let mut uncounted = Vec::new();
        let turns = axes(rays).map(|axis| {
            let mut found = crossings.next().unwrap_or_default();
            odd_rays[axis] = found.n_odd;
            uncounted.append(&mut found.uncounted);
            found.words
        });
        let mut closed = Vec::new();
        if part.policy == Open::Winding {
            // under `parity` all crossings along a are there already
            let again = if rule == Rule::Nonzero { crossings.next() } else { None };
            let surface = again.as_ref().map_or(&turns[0], |again| &again.words);
            let closing = crossings.next().unwrap_or_default();
            closed = grouped(&[surface, &closing.words]);
        }
        let n_words = (rays.counts[0] as usize).div_ceil(64);
        let mut votes = Votes {
            rays: *rays,
            rule,
            policy: part.policy,
            turns,
            uncounted,
            closed,
            shifts: rows_of_shifts(shifts, axes(rays)),
            odd_c: Vec::new(),
            odd_rays,
            n_words,
        };
        let mut through = votes.start();
        votes.go_through(&mut through, u32::MAX);
        votes.odd_c = through.inside;
        votes
    }

    /// Bytes of the crossings.
    pub(crate) fn n_bytes(&self) -> u64 {
        let words: usize = self.turns.iter().map(Vec::capacity).sum::<usize>() + self.closed.capacity();
        8 * words as u64
    }

    /// Before the first plane.
    pub(crate) fn start(&self) -> Through {
        Through { plane: 0, inside: vec![0; self.n_words * self.rays.depth as usize] }
    }

    /// Goes on to a plane.
    pub(crate) fn go_through(&self, through: &mut Through, plane: u32) {
        for &word in of_planes(&self.turns[2], &(through.plane..plane)) {
            through.inside[self.n_words * row_of(word) as usize + place_of(word) as usize / 64] ^=
                1 << (place_of(word) % 64);
        }
        through.plane = plane;
    }

    /// The columns of the rays of some rows, from what is known before the first.
    pub(crate) fn rows(&self, mut through: Through, planes: Range<u32>) -> Rows {
        let n_b = self.rays.counts[0];
        let first_ray = u64::from(planes.start) * u64::from(n_b);
        let [start, end] = [planes.start, planes.end].map(|end| self.uncounted.partition_point(|of| of.0 < end));
        let uncounted = self.uncounted[start..end].iter().map(|(_, n)| n).sum::<u64>();
        let n_crossings = of_planes(&self.turns[0], &planes).len() as u64 + uncounted;
        let mut rows = Rows { band: Band { first_ray, n_crossings, ..Band::default() }, doubt: Vec::new() };
        let (mut changes, mut doubt) = (Vec::new(), Vec::new());
        for plane in planes {
            self.go_through(&mut through, plane + 1);
            changes.clear();
            doubt.clear();
            self.plane(plane, &through.inside, &mut changes, &mut doubt);
            rows.band.ends.extend(append(&changes, n_b, &mut rows.band.runs));
            append(&doubt, n_b, &mut rows.doubt);
        }
        rows
    }

    /// Notes (place, run) where a cell of a plane differs from the one before on its ray, and for its doubtful cells.
    fn plane(&self, plane: u32, inside_c: &[u64], changes: &mut Vec<(u32, u32)>, doubt: &mut Vec<(u32, CellRun)>) {
        let n = self.n_words;
        let [mut turns_a, mut turns_b] = [0, 1].map(|axis| of_planes(&self.turns[axis], &(plane..plane + 1)));
        let mut closed = of_planes(&self.closed, &(plane..plane + 1));
        let first_shift = self.shifts.partition_point(|shift| shift.0 < plane);
        let mut shifts = &self.shifts[first_shift..];
        let mut odd_a = vec![0u64; n];
        turns_a.iter().for_each(|&word| flip(&mut odd_a, place_of(word)));
        let (mut inside_a, mut inside_b, mut wound) = (vec![0u64; n], vec![0u64; n], vec![0u64; n]);
        let mut winding = vec![0i32; if closed.is_empty() { 0 } else { 64 * n }];
        let (mut before, mut moved) = (vec![0u64; n], vec![0u64; n]);
        let first_ray = u64::from(plane) * u64::from(self.rays.counts[0]);
        let mut doubtful_runs = DoubtfulRuns { first_ray, doubtful: vec![0; n], starts: vec![0; 64 * n], found: doubt };
        let past_end = match self.rays.counts[0] % 64 {
            0 => 0,
            used => u64::MAX << used,
        };
        for row in 0..self.rays.depth {
            take_row(&mut turns_a, row).iter().for_each(|&word| flip(&mut inside_a, place_of(word)));
            let along = take_row(&mut turns_b, row);
            let is_odd_b = along.len() % 2 == 1;
            inside_b.fill(0);
            if !along.is_empty() {
                let in_words = along.iter().filter(|&&word| place_of(word) < 64 * n as u32);
                in_words.for_each(|&word| flip(&mut inside_b, place_of(word)));
                fill_between(&mut inside_b);
            }
            for &word in take_row(&mut closed, row) {
                let place = place_of(word) as usize;
                winding[place] += if word & EXITS == 0 { 1 } else { -1 };
                set(&mut wound, place, self.is_inside(winding[place]));
            }
            let wound = self.moved(&wound, &winding, &mut shifts, (plane, row), &mut moved);
            let at = n * row as usize;
            for word in 0..n {
                let votes = [
                    Vote { inside: inside_a[word], odd: odd_a[word] },
                    Vote { inside: inside_b[word], odd: if is_odd_b { u64::MAX } else { 0 } },
                    Vote { inside: inside_c[at + word], odd: self.odd_c[at + word] },
                ];
                let (sure, answer) = unanimous(votes);
                let valid = if word + 1 == n { !past_end } else { u64::MAX };
                let doubtful = !sure & valid;
                doubtful_runs.note(word, row, doubtful);
                let otherwise = if self.policy == Open::Vote { majority(votes) } else { wound[word] };
                let now = (sure & answer | doubtful & otherwise) & valid;
                let mut differs = now ^ before[word];
                before[word] = now;
                while differs != 0 {
                    let bit = differs.trailing_zeros();
                    let flag = (now >> bit & 1) as u8;
                    changes.push((64 * word as u32 + bit, run(row, flag)));
                    differs &= differs - 1;
                }
            }
        }
        (0..n).for_each(|word| doubtful_runs.note(word, self.rays.depth, 0));
    }

    /// The bits of a row of cells by the winding number, with what the caps move.
    fn moved<'a>(
        &self,
        wound: &'a [u64],
        winding: &[i32],
        shifts: &mut &[(u32, u32, Range<u32>, i32)],
        at: (u32, u32),
        moved: &'a mut [u64],
    ) -> &'a [u64] {
        let n = shifts.partition_point(|shift| (shift.0, shift.1) <= at);
        let (own, rest) = shifts.split_at(n);
        *shifts = rest;
        if own.is_empty() {
            return wound;
        }
        moved.copy_from_slice(wound);
        for (_, _, places, m) in own {
            for place in places.clone() {
                let n = winding.get(place as usize).copied().unwrap_or(0);
                set(moved, place as usize, self.is_inside(n + m));
            }
        }
        moved
    }

    fn is_inside(&self, winding: i32) -> bool {
        is_inside(self.rule, winding)
    }
}

/// a, b and c.
fn axes(rays: &Rays) -> [usize; 3] {
    [rays.axis, rays.across[0], rays.across[1]]
}

/// The doubtful cells of a plane, as runs along its rays.
struct DoubtfulRuns<'a> {
    first_ray: u64,
    /// Which cells of the last row are doubtful, and since which row.
    doubtful: Vec<u64>,
    starts: Vec<u32>,
    found: &'a mut Vec<(u32, CellRun)>,
}

impl DoubtfulRuns<'_> {
    /// Takes 64 cells of the next row.
    #[inline(always)]
    fn note(&mut self, word: usize, row: u32, doubtful: u64) {
        let mut differs = doubtful ^ self.doubtful[word];
        while differs != 0 {
            let bit = differs.trailing_zeros();
            let place = 64 * word + bit as usize;
            if doubtful >> bit & 1 == 1 {
                self.starts[place] = row;
            } else {
                let run = CellRun { ray: self.first_ray + place as u64, start: self.starts[place], end: row };
                self.found.push((place as u32, run));
            }
            differs &= differs - 1;
        }
        self.doubtful[word] = doubtful;
    }
}

/// Appends what was noted of the rays of a row, in any order of the rays, ray after ray; returns the end of each.
fn append<T: Copy>(notes: &[(u32, T)], n_b: u32, to: &mut Vec<T>) -> Vec<u32> {
    let Some(&(_, any)) = notes.first() else { return vec![to.len() as u32; n_b as usize] };
    let mut next = vec![0; n_b as usize + 1];
    for (place, _) in notes {
        next[*place as usize + 1] += 1;
    }
    next[0] = to.len() as u32;
    for place in 1..next.len() {
        next[place] += next[place - 1];
    }
    to.resize(to.len() + notes.len(), any);
    for &(place, note) in notes {
        let at = &mut next[place as usize];
        to[*at as usize] = note;
        *at += 1;
    }
    next.pop();
    next
}

/// Shifts of boxes as those of rows of planes, in order.
fn rows_of_shifts(shifts: &[Shift], [a, b, c]: [usize; 3]) -> Vec<(u32, u32, Range<u32>, i32)> {
    let mut rows = Vec::new();
    for shift in shifts {
        for plane in shift.low[c]..shift.high[c] {
            for row in shift.low[a]..shift.high[a] {
                rows.push((plane, row, shift.low[b]..shift.high[b], shift.m));
            }
        }
    }
    sort_by_key(&mut rows, |(plane, row, places, _)| (*plane, *row, places.start));
    rows
}

/// What the rays of one axis say of 64 cells.
#[derive(Clone, Copy)]
struct Vote {
    inside: u64,
    odd: u64,
}

/// Which cells have three even rays that agree, and what these say.
fn unanimous([a, b, c]: [Vote; 3]) -> (u64, u64) {
    let differ = (a.inside ^ b.inside) | (b.inside ^ c.inside);
    (!(differ | a.odd | b.odd | c.odd), a.inside)
}

/// Which cells are inside by most of their even rays.
fn majority(votes: [Vote; 3]) -> u64 {
    let [a, b, c] = votes.map(|vote| vote.inside & !vote.odd);
    let outside = votes.iter().fold(0, |any, vote| any | !vote.inside & !vote.odd);
    a & b | b & c | a & c | (a | b | c) & !outside
}

fn flip(bits: &mut [u64], place: u32) {
    bits[place as usize / 64] ^= 1 << (place % 64);
}

fn set(bits: &mut [u64], place: usize, to: bool) {
    let bit = 1 << (place % 64);
    if to { bits[place / 64] |= bit } else { bits[place / 64] &= !bit }
}

/// Sets every bit to the sum modulo 2 of the bits up to it.
fn fill_between(bits: &mut [u64]) {
    let mut carry = 0u64;
    for word in bits {
        for shift in [1, 2, 4, 8, 16, 32] {
            *word ^= *word << shift;
        }
        *word ^= carry;
        carry = 0u64.wrapping_sub(*word >> 63);
    }
}
