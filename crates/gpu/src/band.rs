//! A band on the device: its facets sent, its passes run, its runs read back, checked, and put in order.
//!
//! What a band needs is known only when it has run. One that found more tiles or runs than its buffers hold runs again in larger
//! ones. Rows that `map` leaves go through the deep kernels, and what these leave is cast by the CPU. Where one row of bins has more
//! facets or tiles than buffers can hold, all its rows are deep: the deep kernels take facets in batches.

use std::ops::Range;

use crate::buffers::{BufferPool, Buffers, Pooled};
use crate::check::{differing, sample, window};
use crate::device::Opened;
use crate::kernels::Kernels;
use crate::layout::{BandFacets, Params, centres};
use crate::pace::Instant;
use crate::passes::{Passes, Profile};
use crate::readback::{Pending, Staging, elements};
use crate::resident::{Resident, Unordered};
use crate::runs::{DeepRows, Raw, Returned};
use hexcast_core::base::error::Result;
use hexcast_core::cells::columns::Band;
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::cast::sizes::{
    BIN, BandSize, Capacity, MAX_BINS, MAX_LAYERS, MOST_CROSSINGS, deep_bytes, shares,
};
use hexcast_core::stages::cpu;

mod deep;
mod order;

/// What bands are run on.
#[derive(Clone, Copy)]
pub(crate) struct Context<'a> {
    pub(crate) opened: &'a Opened,
    pub(crate) kernels: &'a Kernels,
    pub(crate) pool: &'a BufferPool,
    /// Whether the driver computes on the processor.
    pub(crate) is_software: bool,
    /// Most bytes of buffers on the device.
    pub(crate) max_bytes: u64,
    /// Bands that share them.
    pub(crate) n_bands: u64,
    /// Where the runs go that stay on the device; None where the host reads them.
    pub(crate) resident: Option<&'a Resident>,
}

/// The buffers of a band, and what is known of the bands before.
pub(crate) struct Worker<'a> {
    pub(crate) context: Context<'a>,
    pub(crate) cast: Cast<'a>,
    forced: Forced,
    limit: Capacity,
    /// Where cells differ in size: see `layout::centres`.
    centres: Vec<i32>,
    /// Most bytes of its buffers, and of those for deep rows.
    band_bytes: u64,
    deep_bytes: u64,
    /// What bands before have needed.
    least: Capacity,
    least_layers: u32,
    pub(crate) buffers: Option<Buffers>,
    pub(crate) staging: Staging,
    /// Seconds that the host spent on the last band, in passes over all facets for the most part.
    pub(crate) host_seconds: f64,
    pub(crate) profile: Option<Profile>,
}

/// What tests ask for that no mesh would; none of it changes a result.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Forced {
    /// Sends all rows through the deep kernels.
    pub deep: bool,
    /// Most facets of a batch of the deep kernels.
    pub facets_of_batch: Option<usize>,
    /// Layers of a bin, if there are as many facets.
    pub layers: Option<u32>,
}

/// A band on the device.
pub(crate) struct Launched {
    /// Its ray rows.
    pub(crate) rows: Range<u32>,
    pub(crate) params: Params,
    pub(crate) facets: BandFacets,
    /// Whether all its rows are.
    is_deep: bool,
    totals: Option<Pending<3>>,
}

/// What became of a band.
pub(crate) enum Outcome {
    /// Its columns, none where the runs stay on the device; the rays that were cast again, the deep rows, and the rays that the CPU had to cast.
    Done(Band, [u64; 3]),
    /// It has to run again: the worker knows now what it needs.
    Again,
    /// It has to run again, with fewer rows.
    TooMany,
    /// The device was wrong: a sentence, the rays that were looked at, and those that were wrong.
    Wrong(String, [u64; 2]),
}

impl<'a> Worker<'a> {
    pub(crate) fn new(context: Context<'a>, cast: Cast<'a>, forced: Forced) -> Worker<'a> {
        let limits = context.opened.device.limits();
        let binding_bytes = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let [band_bytes, deep_bytes] = shares(context.max_bytes, context.n_bands);
        let centres = centres(&cast);
        let limit = Capacity::limit(binding_bytes, band_bytes.saturating_sub(4 * centres.len() as u64));
        Worker {
            context,
            cast,
            forced,
            limit,
            centres,
            band_bytes,
            deep_bytes,
            least: Capacity::default(),
            least_layers: forced.layers.unwrap_or(1),
            buffers: None,
            staging: Staging::default(),
            host_seconds: 0.0,
            profile: None,
        }
    }

    /// A worker of the same mesh with buffers of its own, so that two bands can be on the device.
    pub(crate) fn sibling(&self) -> Worker<'a> {
        let (least, least_layers) = (self.least, self.least_layers);
        Worker { least, least_layers, ..Worker::new(self.context, self.cast, self.forced) }
    }

    /// Keeps the buffers for the next mesh.
    pub(crate) fn end(self) {
        if let Some(buffers) = self.buffers {
            self.context.pool.keep(Pooled { buffers, staging: self.staging.0 });
        }
    }

    /// Sends the commands of a band to the device; None where fewer rows, or fewer bands, would fit better.
    pub(crate) fn launch(&mut self, rows: Range<u32>) -> Result<Option<Launched>> {
        let start = Instant::now();
        let Some(mut launched) = self.prepare(rows)? else { return Ok(None) };
        self.host_seconds = start.elapsed().as_secs_f64();
        let Some(buffers) = self.buffers.as_ref().filter(|_| !launched.is_deep) else { return Ok(Some(launched)) };
        let mut passes = begin(self.context, self.profile.as_mut());
        passes.lattice(buffers, &launched.params);
        passes.intersect(buffers, &launched.params);
        passes.map(buffers, &launched.params);
        let encoder = passes.encoder;
        let n_tiles = buffers.bin_offsets.part(launched.params.n_counters(), 1);
        let parts = [n_tiles, buffers.found_totals.first(2), buffers.totals.first(4)];
        launched.totals = Some(self.staging.submit(self.context.opened, encoder, parts));
        Ok(Some(launched))
    }

    /// Chooses the facets of a band and sends them to the device; None where fewer rows, or fewer bands, would fit better.
    pub(crate) fn prepare(&mut self, rows: Range<u32>) -> Result<Option<Launched>> {
        let facets = BandFacets::new(&self.cast, &rows, self.least_layers);
        if self.context.is_software && facets.n_crossings > MOST_CROSSINGS && rows.end - rows.start > BIN {
            return Ok(None);
        }
        let mut params = Params { n_layers: facets.n_layers(), ..Params::new(&self.cast, &rows) };
        if self.cast.frame.is_graded() {
            // only the deep kernels know such cells
            let n_bytes = deep_bytes(params.n_chunks(), facets.n_crossings);
            let fits = n_bytes <= self.deep_bytes && facets.n_box_bins < 1 << 31;
            let is_least = rows.end - rows.start <= BIN;
            return Ok((fits || is_least).then_some(Launched { rows, params, facets, is_deep: true, totals: None }));
        }
        let first = Capacity::first(&BandSize {
            n_facets: facets.len() as u64,
            n_all_facets: self.cast.frame.facets.len() as u64,
            n_crossings: facets.n_crossings,
            n_tiles: facets.n_tiles,
            n_rays: params.n_rays().into(),
            n_bins: params.n_bins.into(),
            n_chunks: params.n_chunks(),
            n_layers: params.n_layers,
        });
        let wanted = first.max(self.least);
        let fits = self.limit.holds(Capacity { n_tiles: 0, n_places: 0, ..wanted })
            && self.limit.holds(self.least)
            && self.has_room_for(wanted.min(self.limit))
            && facets.n_box_bins < 1 << 31
            && params.n_bins <= MAX_BINS;
        if !fits {
            // fewer rows, or others, need less than bands before have
            self.least = Capacity::default();
        }
        if self.forced.deep || !fits {
            let can_share_less = self.context.n_bands > 1 && !self.forced.deep;
            if !fits && (rows.end - rows.start > BIN || can_share_less) {
                return Ok(None);
            }
            return Ok(Some(Launched { rows, params, facets, is_deep: true, totals: None }));
        }
        self.make_room(wanted.min(self.limit));
        let Some(buffers) = &self.buffers else { unreachable!("there is room") };
        params.tile_capacity = buffers.capacity.n_tiles as u32;
        params.place_capacity = buffers.capacity.n_places as u32;
        let ends: [[u32; 4]; MAX_LAYERS as usize / 4] = bytemuck::cast(facets.layer_ends());
        buffers.layer_ends.write(&self.context.opened.queue, &ends);
        self.send(&mut params, &facets, 0..facets.len());
        Ok(Some(Launched { rows, params, facets, is_deep: false, totals: None }))
    }

    /// Waits for a band, lets the CPU cast what no kernel could, and checks the rest.
    pub(crate) async fn complete(&mut self, launched: Launched) -> Result<Outcome> {
        let Launched { params, mut facets, totals, .. } = launched;
        let n_chunks = params.n_chunks();
        let Some(totals) = totals else { return self.complete_deep(&params, &facets).await };
        let [tiles, found, totals] = self.staging.words(self.context.opened, totals).await?;
        let (n_tiles, n_places, n_deep) = (u64::from(tiles[0]), u64::from(totals[0]), u64::from(totals[1]));
        if n_deep > n_chunks {
            return Ok(wrong(&params, &format!("{n_deep} rows of {n_chunks} are deep")));
        }
        if self.has_outgrown(Capacity { n_tiles, n_places, ..Capacity::default() })
            || n_deep > n_chunks / 16 && self.gets_more_layers(&mut facets)
        {
            return Ok(Outcome::Again);
        }
        let deep = if n_deep == 0 { DeepRows::default() } else { self.deep_rows(params, &facets, n_deep).await? };
        // in wasm only tests have runs stay, and the package goes without the code
        if let Some(resident) = self.context.resident {
            let (n_lost, n_unused, n_hits) = (totals[2], totals[3], Some(found[1]));
            return self.order(resident, &params, Unordered { deep, n_places, n_unused, n_lost, n_hits }).await;
        }
        let Some(buffers) = &self.buffers else { unreachable!("the band has run") };
        let parts = [buffers.chunks.first(n_chunks), buffers.runs.first(n_places)];
        let pending = self.staging.submit(self.context.opened, self.context.opened.encoder(), parts);
        let cast = self.cast;
        let finish = |[chunks, places]: [&[u8]; 2]| {
            let (chunks, places) = (elements(chunks), elements(places));
            let (n_lost, n_unused) = (totals[2].into(), totals[3] as usize);
            let raw = Raw { chunks: &chunks, places: &places, n_lost, n_unused, n_hits: Some(found[1]), deep: &deep };
            let start = Instant::now();
            (finish(&cast, &params, &raw), start.elapsed().as_secs_f64())
        };
        let (outcome, seconds) = self.staging.parts(self.context.opened, pending, finish).await?;
        self.host_seconds += seconds;
        Ok(outcome)
    }

    /// Whether a band of which many rows are too crowded can be parted into more layers; that counts for the bands after it, too.
    fn gets_more_layers(&mut self, facets: &mut BandFacets) -> bool {
        let n_layers = facets.n_layers();
        if n_layers >= MAX_LAYERS || self.forced.layers.is_some() {
            return false;
        }
        facets.part(&self.cast, 4 * n_layers);
        if facets.n_layers() > n_layers {
            self.least_layers = 4 * n_layers;
        }
        facets.n_layers() > n_layers
    }

    /// Writes some facets to the device, and the parameters with their numbers.
    fn send(&self, params: &mut Params, facets: &BandFacets, range: Range<usize>) {
        let Some(buffers) = &self.buffers else { unreachable!("there is room") };
        let (corners, item_offsets) = facets.pack(&self.cast, range.clone());
        params.n_facets = item_offsets.len() as u32 - 1;
        params.n_items = item_offsets[item_offsets.len() - 1];
        params.first_facet = range.start as u32;
        let queue = &self.context.opened.queue;
        buffers.corners.write(queue, bytemuck::cast_slice(&corners));
        buffers.item_offsets.write(queue, &item_offsets);
        buffers.params.write(queue, &[*params]);
    }

    /// Whether a band needs more than its buffers have; what that is counts for the bands after it, too.
    fn has_outgrown(&mut self, needs: Capacity) -> bool {
        let has = self.buffers.as_ref().map_or(Capacity::default(), |buffers| buffers.capacity);
        let grown = |needs: u64, has: u64| if needs > has { needs + needs / 8 } else { 0 };
        let least = Capacity {
            n_tiles: grown(needs.n_tiles, has.n_tiles),
            n_places: grown(needs.n_places, has.n_places),
            ..Capacity::default()
        };
        self.least = self.least.max(least);
        least != Capacity::default()
    }

    /// Whether a band may have buffers of a capacity.
    fn has_room_for(&self, capacity: Capacity) -> bool {
        capacity.n_bytes_at_most() <= self.band_bytes
    }

    /// Sees to it that there are buffers of a capacity.
    fn make_room(&mut self, wanted: Capacity) {
        let Context { opened, pool, .. } = self.context;
        let has = self.buffers.as_ref().map(|buffers| buffers.capacity);
        if has.is_some_and(|has| has.holds(wanted)) {
            return;
        }
        // what there was goes first
        self.buffers = None;
        let roomy = [wanted.max(has.unwrap_or_default()), wanted].map(|capacity| capacity.rounded().min(self.limit));
        let wanted = roomy.into_iter().find(|&capacity| self.has_room_for(capacity)).unwrap_or(wanted);
        let pooled = pool.take(wanted, self.band_bytes);
        self.free_for(if pooled.is_some() { 0 } else { wanted.n_bytes_at_most() });
        self.buffers = Some(match pooled {
            Some(pooled) => {
                self.staging = Staging(pooled.staging);
                pooled.buffers
            }
            None => Buffers::new(opened, wanted),
        });
    }

    /// Frees what waits for the next mesh where the device could not hold so many bytes more.
    fn free_for(&self, n_bytes: u64) {
        let Context { opened, pool, max_bytes, .. } = self.context;
        if opened.held.now().saturating_add(n_bytes) > max_bytes {
            pool.clear_over(0);
        }
        // the device frees what was dropped when it is asked how it is; what else it says is told elsewhere
        let _ = opened.device.poll(wgpu::PollType::Poll);
    }
}

/// Begins the commands of a band.
pub(crate) fn begin<'a>(context: Context<'a>, profile: Option<&'a mut Profile>) -> Passes<'a> {
    let Context { opened, kernels, is_software, .. } = context;
    Passes { opened, kernels, is_software, encoder: opened.encoder(), profile }
}

/// Puts what the device returned in order, casts what it left, and checks all.
fn finish(cast: &Cast, params: &Params, raw: &Raw) -> Outcome {
    let mut flags = vec![0];
    flags.extend(&cast.frame.ranks.flag_of_rank);
    let left = raw.left();
    let bands = cpu::windows(cast, &left.iter().map(|&chunk| window(params, chunk)).collect::<Vec<_>>());
    let cast_again: Vec<(usize, Band)> = left.into_iter().zip(bands).collect();
    let n_deep = raw.deep.rows.len() as u64 / 16;
    let n_left = cast_again.iter().map(|(_, band)| band.ends.len() as u64).sum();
    let band = match (Returned { params, raw, cast_again: &cast_again, flags: &flags }).band() {
        Ok(band) => band,
        Err(fault) => return wrong(params, &fault),
    };
    let sampled = cpu::windows(cast, &sample(params));
    let n_sampled = sampled.iter().map(|band| band.ends.len() as u64).sum();
    match differing(&band, &sampled) {
        0 => Outcome::Done(band, [n_sampled, n_deep, n_left]),
        n => {
            let what = format!("{n} of {n_sampled} rays of a sample have other cells than the CPU finds");
            Outcome::Wrong(what, [n_sampled, n])
        }
    }
}

fn wrong(params: &Params, fault: &str) -> Outcome {
    Outcome::Wrong(format!("it returned what cannot be: {fault}"), [u64::from(params.n_rays()); 2])
}
