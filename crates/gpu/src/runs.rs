//! Puts the runs that `map` and the deep kernels wrote, chunk by chunk in no order, into the order of the rays. It checks
//! everything that the device wrote: no index is used, and no run is passed on, before it is known to be possible.
//!
//! A chunk is one row of rays of one bin, at most [`BIN`] rays. Its runs are in segments, each linked to the one before (`map.wgsl`), or
//! it was a deep row (`map_deep.wgsl`), or the CPU has cast it. A run names the rank of the geometry that wins; flags are put in here.
//! Cost: each run is copied once, as it has to be anyway to come out of the device's memory.

use crate::buffers::DeepBuffers;
use crate::layout::Params;
use hexcast_core::base::parallel::bound::*;
use hexcast_core::cells::columns::Band;
use hexcast_core::set;
use hexcast_core::stages::cast::sizes::{BIN, MAX_LAYERS};

/// Marks a chunk of a deep row; `DEEP` in `shaders/shared/chunks.wgsl`.
pub const DEEP: u32 = u32::MAX;
/// Marks a deep row that is left to the CPU; `LEFT` in `shaders/map_deep.wgsl`.
pub const LEFT: u32 = u32::MAX;
/// Marks the place of a segment that has one before it; `LINKED` in `shaders/map.wgsl`.
pub const LINKED: u32 = 1 << 31;
/// Bits of a place, under those of the number of odd rays.
const PLACE_BITS: u32 = 27;
/// Words of a place.
const SLOT_WORDS: usize = 4;
/// Most runs of a ray in a segment.
const MOST_RUNS: usize = 2 * SLOT_WORDS;
/// Ray rows that one task puts in order: a row of bins, whose runs are near each other on the device.
const ROWS: usize = BIN as usize;

/// What a device returned of a band, unchecked.
pub(crate) struct Raw<'a> {
    /// Two words a chunk, `n_across` chunks a ray row.
    pub(crate) chunks: &'a [[u32; 2]],
    /// Places of four words that the segments lie in.
    pub(crate) places: &'a [u32],
    /// Crossings of rows that are not deep and begin no run.
    pub(crate) n_lost: u64,
    /// Places that were given to rows before they turned out to be deep.
    pub(crate) n_unused: usize,
    /// Rays that all facets hit, as the lattice has counted them, modulo 2^32.
    pub(crate) n_hits: Option<u32>,
    pub(crate) deep: &'a DeepRows,
}

/// A band to be put in order.
pub(crate) struct Returned<'a> {
    pub(crate) params: &'a Params,
    pub(crate) raw: &'a Raw<'a>,
    /// Chunks that the CPU has cast, in order.
    pub(crate) cast_again: &'a [(usize, Band)],
    /// Flag of each code of a run: rank + 1, or 0.
    pub(crate) flags: &'a [u8],
}

/// What the deep kernels returned.
#[derive(Debug, Default)]
pub(crate) struct DeepRows {
    /// First crossing of each row in `events`, then the end.
    pub(crate) offsets: Vec<u32>,
    /// Of each row the first run of each ray in `events`, then their numbers.
    pub(crate) rows: Vec<u32>,
    pub(crate) events: Vec<u32>,
    /// Where the events are, and the rows too, if they stay on the device.
    pub(crate) buffers: Option<DeepBuffers>,
}

/// What is wrong with what a device returned.
pub(crate) type Fault = String;

/// A part of a chunk's runs: the word of its next ray, and how many runs each ray has, 4 bits each.
#[derive(Clone, Copy)]
struct Segment {
    at: usize,
    counts: u32,
}

/// Where the runs of a chunk are.
enum Chunk<'a> {
    /// In segments, in order.
    Segments,
    Deep(&'a [u32]),
    Again(&'a Band),
}

/// What a task adds to.
#[derive(Default, Clone, Copy)]
struct Counts {
    /// Of each row of rays.
    n_runs: [usize; ROWS],
    n_places: usize,
    odd_rays: u64,
    n_crossings: u64,
}

/// A row of bins: its first chunk, what it holds, the ends of its rays, its runs, and how many come before these.
type Task<'a> = (usize, &'a Counts, &'a mut [u32], &'a mut [u32], usize);

impl Raw<'_> {
    /// Chunks that no kernel could decide.
    pub(crate) fn left(&self) -> Vec<usize> {
        let is_left = |&(_, &[index, counts]): &(usize, &[u32; 2])| {
            counts == DEEP && self.deep.rows.get(16 * index as usize).is_none_or(|&first| first == LEFT)
        };
        self.chunks.iter().enumerate().filter(is_left).map(|(chunk, _)| chunk).collect()
    }
}

impl<'a> Returned<'a> {
    /// The columns of the band.
    ///
    /// # Errors
    /// What cannot be as the device says.
    pub(crate) fn band(&self) -> Result<Band, Fault> {
        let (n_i, n_across) = (self.params.n_i as usize, self.params.n_across as usize);
        let per_task = ROWS * n_across;
        let count = |(task, chunks): (usize, &[[u32; 2]])| self.count(task * per_task, chunks);
        let counts: Vec<Result<Counts, Fault>> = self.raw.chunks.par_chunks(per_task).enumerate().map(count).collect();
        let counts = counts.into_iter().collect::<Result<Vec<Counts>, Fault>>()?;
        let n_places: usize = counts.iter().map(|task| task.n_places).sum();
        if SLOT_WORDS * (n_places + self.raw.n_unused) != self.raw.places.len() {
            let all = self.raw.places.len() / SLOT_WORDS;
            return Err(format!("{n_places} places of runs are used and {} are not, of {all}", self.raw.n_unused));
        }
        let n_crossings = self.raw.n_lost + counts.iter().map(|task| task.n_crossings).sum::<u64>();
        if let Some(n_hits) = self.raw.n_hits.filter(|&n_hits| n_hits != n_crossings as u32) {
            return Err(format!("the rays have {n_crossings} crossings, where facets hit {n_hits} times"));
        }
        let mut ends = vec![0; self.params.n_rays() as usize];
        let mut runs = vec![0; counts.iter().flat_map(|task| task.n_runs).sum()];
        let mut tasks = Vec::with_capacity(counts.len());
        let (mut rest, mut before) = (&mut runs[..], 0);
        for (task, (ends, counts)) in ends.chunks_mut(ROWS * n_i).zip(&counts).enumerate() {
            let n_runs = counts.n_runs.iter().sum();
            let (own, after) = rest.split_at_mut(n_runs);
            tasks.push((task * per_task, counts, ends, own, before));
            rest = after;
            before += n_runs;
        }
        let copied: Vec<Result<(), Fault>> = tasks.into_par_iter().map(|task| self.copy_task(task)).collect();
        copied.into_iter().collect::<Result<(), Fault>>()?;
        let mut band = set!(Band {
            first_ray: u64::from(self.params.first_row) * u64::from(self.params.n_i),
            odd_rays: counts.iter().map(|task| task.odd_rays).sum(),
            n_crossings,
            ends,
            runs,
            ..Band::default()
        });
        if has_twice(self.flags) {
            join_equal(&mut band);
        }
        Ok(band)
    }

    /// Counts what the chunks of a task hold, and checks where they say it is.
    fn count(&self, first_chunk: usize, chunks: &[[u32; 2]]) -> Result<Counts, Fault> {
        let mut sum = Counts::default();
        let mut segments = Vec::new();
        for index in first_chunk..first_chunk + chunks.len() {
            let (n_runs, n_crossings, odd_rays) = match self.chunk(index, &mut segments)? {
                Chunk::Segments => {
                    let n_runs: usize = segments.iter().map(|segment| sum_of_counts(segment.counts)).sum();
                    let links = segments.len().saturating_sub(1);
                    sum.n_places += segments.iter().map(|segment| n_places(segment.counts)).sum::<usize>() + links;
                    (n_runs, n_runs as u64, u64::from((self.raw.chunks[index][0] & !LINKED) >> PLACE_BITS))
                }
                Chunk::Deep(row) => {
                    let n_runs = row[8..].iter().map(|&n| n as usize).sum();
                    let row = self.raw.chunks[index][0] as usize;
                    (n_runs, u64::from(self.raw.deep.offsets[row + 1] - self.raw.deep.offsets[row]), 0)
                }
                Chunk::Again(band) => (band.runs.len(), band.n_crossings, band.odd_rays),
            };
            if odd_rays > BIN.into() {
                return Err(format!("chunk {index} has {odd_rays} odd rays of {BIN}"));
            }
            sum.n_runs[(index - first_chunk) / self.params.n_across as usize] += n_runs;
            sum.n_crossings += n_crossings;
            sum.odd_rays += odd_rays;
        }
        Ok(sum)
    }

    /// Finds the runs of a chunk; `segments` becomes its segments, if it has any.
    fn chunk(&self, index: usize, segments: &mut Vec<Segment>) -> Result<Chunk<'a>, Fault> {
        segments.clear();
        let [mut word, mut counts] = self.raw.chunks[index];
        if counts == DEEP {
            if let Ok(found) = self.cast_again.binary_search_by_key(&index, |(chunk, _)| *chunk) {
                return Ok(Chunk::Again(&self.cast_again[found].1));
            }
            return self.deep_row(word as usize).map(Chunk::Deep);
        }
        while counts != 0 {
            let is_linked = word & LINKED != 0;
            let place = (word & ((1 << PLACE_BITS) - 1)) as usize;
            let is_possible = !are_too_many(counts)
                && SLOT_WORDS * (place + n_places(counts) + usize::from(is_linked)) <= self.raw.places.len()
                && segments.len() <= MAX_LAYERS as usize;
            if !is_possible {
                let all = self.raw.places.len() / SLOT_WORDS;
                return Err(format!("chunk {index} has runs {counts:#x} from place {place} on, of {all}"));
            }
            segments.push(Segment { at: SLOT_WORDS * (place + usize::from(is_linked)), counts });
            if !is_linked {
                break;
            }
            [word, counts] = [self.raw.places[SLOT_WORDS * place], self.raw.places[SLOT_WORDS * place + 1]];
        }
        segments.reverse();
        Ok(Chunk::Segments)
    }

    fn deep_row(&self, row: usize) -> Result<&'a [u32], Fault> {
        let words = self.raw.deep.rows.get(16 * row..16 * row + 16);
        let (Some(words), Some(&[start, end])) =
            (words, self.raw.deep.offsets.get(row..row + 2).and_then(|o| o.first_chunk()))
        else {
            return Err(format!("deep row {row} of {}", self.raw.deep.rows.len() / 16));
        };
        let (firsts, counts) = words.split_at(8);
        let is_inside =
            |(&first, &count): (&u32, &u32)| start <= first && u64::from(first) + u64::from(count) <= end.into();
        if end as usize > self.raw.deep.events.len() || !firsts.iter().zip(counts).all(is_inside) {
            return Err(format!("deep row {row} has runs {words:?}, of its crossings {start}..{end}"));
        }
        Ok(words)
    }

    /// Copies the runs of the rays of a row of bins to `out`, and notes where each ray's end. Bin after bin, as they lie on the device, and
    /// row after row in `out`.
    fn copy_task(&self, (first_chunk, counts, ends, out, before): Task) -> Result<(), Fault> {
        let (n_i, n_across) = (self.params.n_i as usize, self.params.n_across as usize);
        let relabel = !self.flags.iter().enumerate().all(|(code, &flag)| code == usize::from(flag));
        let (mut end, mut segments) = (0, Vec::new());
        let mut rows = counts.n_runs.map(|n| {
            end += n;
            (end - n, end)
        });
        for column in 0..n_across {
            for (row, (at, row_end)) in rows.iter_mut().enumerate().take(ends.len() / n_i) {
                let index = first_chunk + row * n_across + column;
                let chunk = self.chunk(index, &mut segments)?;
                let ends = &mut ends[row * n_i..(row + 1) * n_i][column * BIN as usize..];
                let (start, out) = (*at, &mut out[..*row_end]);
                for (ray, end) in ends.iter_mut().take(BIN as usize).enumerate() {
                    let runs = match &chunk {
                        Chunk::Segments => &[],
                        Chunk::Deep(row) => &self.raw.deep.events[row[ray] as usize..][..row[8 + ray] as usize],
                        Chunk::Again(band) => band.ray(ray),
                    };
                    out[*at..*at + runs.len()].copy_from_slice(runs);
                    *at = copy_segments(self.raw.places, &mut segments, ray, out, *at + runs.len());
                    *end = (before + *at) as u32;
                }
                if matches!(chunk, Chunk::Again(_)) {
                    continue;
                }
                let runs = &mut out[start..*at];
                if !self.are_possible(runs, (before + start) as u32, &ends[..ends.len().min(BIN as usize)]) {
                    return Err(format!("chunk {index} has the runs {:x?}", &runs[..runs.len().min(64)]));
                }
                if relabel {
                    runs.iter_mut().for_each(|run| *run = *run & !0xff | u32::from(self.flags[(*run & 0xff) as usize]));
                }
            }
        }
        Ok(())
    }

    /// Whether runs of rays are in order, inside the rays, of geometries that there are, and differ from their neighbours. Without
    /// branches: wherever a run does not follow the one before, a ray has to begin.
    fn are_possible(&self, runs: &[u32], first: u32, ends: &[u32]) -> bool {
        let (n_codes, depth) = (self.flags.len() as u32, self.params.depth);
        let breaks = |before: u32, run: u32| u32::from((before >> 8 >= run >> 8) | ((before ^ run) & 0xff == 0));
        let mut is_possible = runs.iter().fold(true, |is, run| is & (run >> 8 < depth) & (run & 0xff < n_codes));
        let mut n_breaks: u32 = runs.windows(2).map(|pair| breaks(pair[0], pair[1])).sum();
        let mut start = first;
        for &end in ends {
            if end > start {
                let at = (start - first) as usize;
                is_possible &= runs[at] & 0xff != 0;
                n_breaks -= breaks(runs[at.max(1) - 1], runs[at]) * u32::from(at > 0);
            }
            start = end;
        }
        is_possible & (n_breaks == 0)
    }
}

/// Copies the runs of a ray from all segments of its chunk, and steps these to the next ray; returns the end.
#[inline(always)]
fn copy_segments(places: &[u32], segments: &mut [Segment], ray: usize, out: &mut [u32], mut at: usize) -> usize {
    for segment in segments {
        let n = count_of(segment.counts, ray);
        // always as many, where there is room: far cheaper than as many as there are
        match (out.get_mut(at..at + MOST_RUNS), places.get(segment.at..segment.at + MOST_RUNS)) {
            (Some(out), Some(runs)) => out.copy_from_slice(runs),
            _ => out[at..at + n].copy_from_slice(&places[segment.at..segment.at + n]),
        }
        segment.at += n.next_multiple_of(SLOT_WORDS);
        at += n;
    }
    at
}

/// Whether a flag is that of several codes.
fn has_twice(flags: &[u8]) -> bool {
    let mut seen = [false; 256];
    flags.iter().any(|&flag| std::mem::replace(&mut seen[usize::from(flag)], true))
}

/// Joins neighbouring runs of a ray that have the same flag.
fn join_equal(band: &mut Band) {
    let (mut kept, mut start) = (0, 0);
    for end in &mut band.ends {
        let mut flag = 0;
        for at in start..*end as usize {
            let run = band.runs[at];
            if run & 0xff != flag {
                flag = run & 0xff;
                band.runs[kept] = run;
                kept += 1;
            }
        }
        start = *end as usize;
        *end = kept as u32;
    }
    band.runs.truncate(kept);
}

/// One of eight counts of 4 bits.
#[inline(always)]
fn count_of(counts: u32, ray: usize) -> usize {
    (counts >> (4 * ray)) as usize & 15
}

/// The sum of eight counts of 4 bits.
fn sum_of_counts(counts: u32) -> usize {
    let pairs = (counts & 0x0f0f_0f0f) + ((counts >> 4) & 0x0f0f_0f0f);
    (pairs.wrapping_mul(0x0101_0101) >> 24) as usize
}

/// Places of the runs of eight rays, each of which begins a new one and has at most [`MOST_RUNS`].
fn n_places(counts: u32) -> usize {
    sum_of_counts((counts + 0x3333_3333) >> 2 & 0x3333_3333)
}

/// Whether one of eight counts is more than [`MOST_RUNS`].
fn are_too_many(counts: u32) -> bool {
    counts & 0x8888_8888 & ((counts & 0x7777_7777) + 0x7777_7777) != 0
}

#[cfg(test)]
mod tests;
