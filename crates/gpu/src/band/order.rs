//! The runs of a band in the order of the rays, made where they stay: the kernel `order` counts and writes them. The host sees numbers, a
//! sample of rays, and what it cast itself.
//!
//! What `runs.rs` checks on the host the kernel checks here: every place before it is used, and order and range of all runs. The numbers of
//! crossings, runs and places must agree with those of `lattice` and `map`, and the CPU casts one ray in 256 again.

use super::{Outcome, Worker, begin, window, wrong};
use crate::buffers::{Array, DeepBuffers, Part, Sums};
use crate::check::sample;
use crate::kernels::Kernel;
use crate::layout::Params;
use crate::passes::square;
use crate::resident::{Resident, Unordered};
use crate::runs::{DEEP, DeepRows, LEFT};
use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::columns::Band;
use hexcast_core::stages::cast::sizes::BIN;
use hexcast_core::stages::cpu;
use hexcast_core::stages::cpu::Window;

/// Most runs of a deep ray; `MAX_DEEP_RUNS` in `shaders/order.wgsl`.
const MAX_DEEP_RUNS: u32 = 8192;
/// Words of the offsets of a chunk of a sample.
const OFFSETS: u64 = BIN as u64 + 1;

/// `Sources` in `shaders/order.wgsl`, where each is explained.
#[repr(C)]
#[derive(Debug, Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
struct Sources {
    flags: [u32; 64],
    n_codes: u32,
    n_places: u32,
    n_deep: u32,
    n_events: u32,
    base: u32,
    writes: u32,
    padding: [u32; 2],
}

/// The buffers of the kernel that are not those of the band.
struct Ordering {
    params: Array<Params>,
    sources: Array<Sources>,
    deep: DeepBuffers,
    offsets: Array<u32>,
    found: Array<u32>,
    no_chunks: Array<[u32; 2]>,
    no_runs: Array<[u32; 4]>,
}

impl Worker<'_> {
    /// Puts the runs of a band in order, checks them, and leaves them on the device.
    pub(super) async fn order(&mut self, resident: &Resident, params: &Params, of: Unordered) -> Result<Outcome> {
        let opened = self.context.opened;
        let n_rays = u64::from(params.n_rays());
        let Unordered { mut deep, n_places, n_unused, n_lost, n_hits } = of;
        let left = self.left_rows(params, &deep).await?;
        let bands = cpu::windows(&self.cast, &left.iter().map(|&(chunk, _)| window(params, chunk)).collect::<Vec<_>>());
        let n_deep_crossings = crossings_of_deep(&deep, &left, &bands);
        let (deep, n_events) = match self.patched(&mut deep, &left, &bands)? {
            Ok(patched) => patched,
            Err(fault) => return Ok(wrong(params, &fault)),
        };
        let n_deep = deep.deep_rows.buffer.size() / 64;
        let base = resident.kept().n_runs;
        let mut sources = Sources {
            flags: self.flags_of_codes(),
            n_codes: self.cast.frame.ranks.flag_of_rank.len() as u32 + 1,
            n_places: n_places as u32,
            n_deep: n_deep as u32,
            n_events: n_events as u32,
            base: base as u32,
            ..bytemuck::Zeroable::zeroed()
        };
        let ordering = Ordering {
            params: Array::uniform(opened, "params", 1),
            sources: Array::uniform(opened, "sources", 1),
            deep,
            offsets: Array::storage(opened, "offsets of the band", n_rays + 1),
            found: Array::storage(opened, "found in order", 4),
            no_chunks: Array::storage(opened, "no chunks", 1),
            no_runs: Array::storage(opened, "no runs", 1),
        };
        ordering.params.write(&opened.queue, &[*params]);
        let windows = sample(params);
        let (counted, offsets) = self.count(&ordering, &sources, params, &windows).await?;
        let [n_faults, n_raw, n_used, n_odd, end] = counted;
        if let Some(fault) = fault_of(n_faults, (u64::from(n_used) + u64::from(n_unused), n_places), "places of runs") {
            return Ok(wrong(params, &fault));
        }
        let n_crossings = u64::from(n_lost) + u64::from(n_raw) + n_deep_crossings;
        if let Some(n_hits) = n_hits.filter(|&n_hits| n_hits != n_crossings as u32) {
            let fault = format!("the rays have {n_crossings} crossings, where facets hit {n_hits} times");
            return Ok(wrong(params, &fault));
        }
        resident.check(u64::from(end))?;
        let Some(n_runs) =
            u64::from(end).checked_sub(base).filter(|_| are_possible(&offsets, &windows, [base as u32, end]))
        else {
            return Ok(wrong(
                params,
                &format!("the runs of a band go from {base} to {end}, and those of rays {offsets:?}"),
            ));
        };
        sources.writes = 1;
        let ordered: Array<u32> = Array::storage(opened, "ordered", n_runs);
        let runs = self.write(&ordering, (&sources, &ordered), (&windows, &offsets), (params, resident)).await?;
        let Some(runs) = runs else { return Ok(wrong(params, "runs in order are not where they were counted")) };
        let sampled = cpu::windows(&self.cast, &windows);
        let n_sampled: u64 = sampled.iter().map(|band| band.ends.len() as u64).sum();
        let n_differing = differing(&sampled, &offsets, &runs);
        if n_differing > 0 {
            let what = format!("{n_differing} of {n_sampled} rays of a sample have other cells than the CPU finds");
            return Ok(Outcome::Wrong(what, [n_sampled, n_differing]));
        }
        resident.take(ordered, n_runs);
        let mut kept = resident.kept();
        kept.n_crossings += n_crossings;
        kept.odd_rays += u64::from(n_odd) + bands.iter().map(|band| band.odd_rays).sum::<u64>();
        let n_left = bands.iter().map(|band| band.ends.len() as u64).sum();
        Ok(Outcome::Done(Band::default(), [n_sampled, left.len() as u64, n_left]))
    }

    /// Chunks that no kernel could decide, and their deep rows.
    async fn left_rows(&mut self, params: &Params, deep: &DeepRows) -> Result<Vec<(usize, u32)>> {
        let is_left = |row: u32| deep.rows.get(16 * row as usize) == Some(&LEFT);
        let n_rows = deep.rows.len() as u32 / 16;
        if params.all_deep == 1 {
            return Ok((0..n_rows).filter(|&row| is_left(row)).map(|row| (row as usize, row)).collect());
        }
        let Some(buffers) = self.buffers.as_ref().filter(|_| (0..n_rows).any(is_left)) else { return Ok(vec![]) };
        let opened = self.context.opened;
        let [chunks] = self.staging.read(opened, opened.encoder(), [buffers.chunks.first(params.n_chunks())]).await?;
        let chunks = chunks.chunks_exact(2).enumerate();
        let of_left = chunks.filter(|(_, chunk)| chunk[1] == DEEP && is_left(chunk[0]));
        Ok(of_left.map(|(index, chunk)| (index, chunk[0])).collect())
    }

    /// The deep rows on the device, with the runs of those that the CPU has cast, and the words of their events; or what is wrong with them.
    fn patched(
        &self,
        deep: &mut DeepRows,
        left: &[(usize, u32)],
        bands: &[Band],
    ) -> Result<std::result::Result<(DeepBuffers, u64), String>> {
        let opened = self.context.opened;
        let longest =
            bands.iter().flat_map(|band| (0..band.ends.len()).map(|ray| band.ray(ray).len())).max().unwrap_or(0);
        if longest as u64 > u64::from(MAX_DEEP_RUNS) {
            let message =
                format!("a ray has {longest} runs, and a kernel puts at most {MAX_DEEP_RUNS} of a ray in order");
            return Err(Error::new("too-many-crossings", message, "mesh it for the host, and upload the mesh"));
        }
        let n_runs: u64 = bands.iter().map(|band| band.runs.len() as u64).sum();
        let n_rows = deep.rows.len() as u64 / 16;
        // what the sort no longer needs takes them: runs are never more than crossings
        let (buffers, n_events) = match deep.buffers.take() {
            Some(buffers) => (buffers, u64::from(deep.offsets[n_rows as usize])),
            None => (DeepBuffers::new(opened, n_rows).with_events(opened, n_runs), n_runs),
        };
        if n_runs > n_events {
            return Ok(Err(format!("{n_events} crossings of deep rows, where the CPU finds {n_runs} runs")));
        }
        let mut at = n_events as u32;
        for (&(_, row), band) in left.iter().zip(bands) {
            let (mut words, mut codes) = ([at; 16], band.runs.clone());
            words[8..].fill(0);
            for ray in 0..band.ends.len() {
                words[ray] = at;
                words[8 + ray] = band.ray(ray).len() as u32;
                at += words[8 + ray];
            }
            codes.iter_mut().for_each(|run| *run = *run & !0xff | self.code_of(*run as u8));
            buffers.events.write_at(&opened.queue, u64::from(words[0]), &codes);
            buffers.deep_rows.write_at(&opened.queue, 16 * u64::from(row), &words);
        }
        Ok(Ok((buffers, 2 * n_events)))
    }

    /// A code of a flag: any of those whose geometries have it.
    fn code_of(&self, flag: u8) -> u32 {
        let position = self.cast.frame.ranks.flag_of_rank.iter().position(|&of_rank| of_rank == flag);
        if flag == 0 { 0 } else { position.map_or(0, |rank| rank as u32 + 1) }
    }

    /// The flags of all codes, a byte each.
    fn flags_of_codes(&self) -> [u32; 64] {
        let mut flags = [0; 64];
        for (rank, &flag) in self.cast.frame.ranks.flag_of_rank.iter().enumerate() {
            flags[(rank + 1) / 4] |= u32::from(flag) << (8 * ((rank + 1) % 4));
        }
        flags
    }

    fn record(
        &mut self,
        ordering: &Ordering,
        sources: &Sources,
        ordered: Part,
        params: &Params,
    ) -> wgpu::CommandEncoder {
        ordering.sources.write(&self.context.opened.queue, &[*sources]);
        let mut passes = begin(self.context, self.profile.as_mut());
        let (chunks, runs) = match self.buffers.as_ref().filter(|_| params.all_deep == 0) {
            Some(buffers) => (buffers.chunks.all(), buffers.runs.all()),
            None => (ordering.no_chunks.all(), ordering.no_runs.all()),
        };
        let Ordering { params: of_band, sources, deep, offsets, found, .. } = ordering;
        let events = deep.events.all();
        let bindings = [
            of_band.all(),
            sources.all(),
            deep.deep_rows.all(),
            offsets.all(),
            events,
            runs,
            chunks,
            ordered,
            found.all(),
        ];
        passes.dispatch(Kernel::Order, &bindings, square(u64::from(params.n_rays()).div_ceil(64)));
        passes.encoder
    }

    /// Counts the runs of each ray, and sums them. Faults, runs, places and odd rays that were found, and the end; and the offsets of the
    /// rays of some chunks.
    async fn count(
        &mut self,
        ordering: &Ordering,
        sources: &Sources,
        params: &Params,
        windows: &[Window],
    ) -> Result<([u32; 5], Vec<u32>)> {
        let opened = self.context.opened;
        let n = u64::from(params.n_rays()) + 1;
        let none: Array<u32> = Array::storage(opened, "none", 1);
        let encoder = self.record(ordering, sources, none.all(), params);
        let mut passes = begin(self.context, self.profile.as_mut());
        passes.encoder = encoder;
        let sums = Sums::new(opened, n);
        sums.begin_at(&opened.queue, sources.base);
        passes.scan(ordering.offsets.first(n), &sums, 0);
        let sampled: Array<u32> = Array::storage(opened, "offsets of a sample", OFFSETS * windows.len() as u64);
        for (index, window) in windows.iter().enumerate() {
            let first =
                u64::from(window[1].start - params.first_row) * u64::from(params.n_i) + u64::from(window[0].start);
            let to = 4 * OFFSETS * index as u64;
            let n_bytes = 4 * (window[0].len() as u64 + 1);
            passes.encoder.copy_buffer_to_buffer(&ordering.offsets.buffer, 4 * first, &sampled.buffer, to, n_bytes);
        }
        let parts =
            [ordering.found.first(4), ordering.offsets.part(n - 1, 1), sampled.first(OFFSETS * windows.len() as u64)];
        let [found, end, sampled] = self.staging.read(opened, passes.encoder, parts).await?;
        Ok(([found[0], found[1], found[2], found[3], end[0]], sampled))
    }

    /// Writes the runs, and the offsets to those of the mesh; the runs of the sample, one chunk after the other, or None if there were faults.
    async fn write(
        &mut self,
        ordering: &Ordering,
        (sources, ordered): (&Sources, &Array<u32>),
        (windows, offsets): (&[Window], &[u32]),
        (params, resident): (&Params, &Resident),
    ) -> Result<Option<Vec<u32>>> {
        let opened = self.context.opened;
        let mut encoder = self.record(ordering, sources, ordered.all(), params);
        let first = 4 * u64::from(params.first_row) * u64::from(params.n_i);
        let n_bytes = 4 * (u64::from(params.n_rays()) + 1);
        encoder.copy_buffer_to_buffer(&ordering.offsets.buffer, 0, &resident.offsets.buffer, first, n_bytes);
        let ranges = windows.iter().zip(offsets.chunks(OFFSETS as usize));
        let ranges: Vec<[u64; 2]> = ranges
            .map(|(window, ends)| [ends[0], ends[window[0].len()]].map(|end| u64::from(end - sources.base)))
            .collect();
        let n_sampled = ranges.iter().map(|[start, end]| end - start).sum();
        let sampled: Array<u32> = Array::storage(opened, "runs of a sample", n_sampled);
        let mut to = 0;
        for [start, end] in ranges {
            encoder.copy_buffer_to_buffer(&ordered.buffer, 4 * start, &sampled.buffer, to, 4 * (end - start));
            to += 4 * (end - start);
        }
        let parts = [ordering.found.first(1), sampled.first(n_sampled)];
        let [faults, runs] = self.staging.read(opened, encoder, parts).await?;
        Ok((faults == [0]).then_some(runs))
    }
}

/// Crossings of deep rows: those that the device counted, or the CPU, where it has cast them.
fn crossings_of_deep(deep: &DeepRows, left: &[(usize, u32)], bands: &[Band]) -> u64 {
    let counted = deep.offsets.last().map_or(0, |&n| u64::from(n));
    let of_row = |row: u32| deep.offsets.get(row as usize..row as usize + 2).map_or(0, |of| of[1].wrapping_sub(of[0]));
    let of_left: u64 = left.iter().map(|&(_, row)| u64::from(of_row(row))).sum();
    counted.saturating_sub(of_left) + bands.iter().map(|band| band.n_crossings).sum::<u64>()
}

/// What cannot be in the numbers of the kernel.
fn fault_of(n_faults: u32, (n, of): (u64, u64), what: &str) -> Option<String> {
    if n_faults > 0 {
        return Some(format!("{n_faults} rays have runs that are out of order, or out of range"));
    }
    (n != of).then(|| format!("{n} {what} are used or given up, of {of}"))
}

/// Whether the offsets of a sample ascend between the ends of a band.
fn are_possible(offsets: &[u32], windows: &[Window], [first, end]: [u32; 2]) -> bool {
    windows.iter().zip(offsets.chunks(OFFSETS as usize)).all(|(window, of)| {
        let of = &of[..=window[0].len()];
        of.is_sorted() && first <= of[0] && of[of.len() - 1] <= end
    })
}

/// Rays of a sample whose runs are others than those that the CPU found.
fn differing(sampled: &[Band], offsets: &[u32], runs: &[u32]) -> u64 {
    let (mut n, mut start) = (0, 0);
    for (band, of) in sampled.iter().zip(offsets.chunks(OFFSETS as usize)) {
        for ray in 0..band.ends.len() {
            let end = start + (of[ray + 1] - of[ray]) as usize;
            n += u64::from(band.ray(ray) != &runs[start..end]);
            start = end;
        }
    }
    n
}
