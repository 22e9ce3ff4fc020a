//! One mesh on one device: its buffers, its commands, and the way home of its results.

use std::borrow::Cow;
use std::ops::Range;

use wgpu::{Buffer, BufferDescriptor, BufferUsages, CommandEncoder};

use super::buffers::{Buffers, Capacity, Facets, PairBuffers, check_facets};
use super::device::Gpu;
use super::gather::gather;
use super::layout::{BIN, FACET_WORDS, Params, corners, flag_words};
use super::line::{Cast, Usage};
use super::passes::Passes;
use super::spares::Spare;
use crate::columns::Band;
use crate::error::{Error, Result};
use crate::estimate::bands::{first_pairs, first_words};
use crate::rays::Rays;

/// The device, what is meshed, and the buffers for one band of it.
pub(crate) struct Session<'a> {
    pub(crate) gpu: &'a Gpu,
    pub(crate) cast: Cast<'a>,
    pub(crate) buffers: Buffers,
    pub(crate) usage: Usage,
    staging: Option<Buffer>,
}

/// A band on the device.
pub(crate) struct Launched {
    /// Its ray rows.
    pub(crate) rows: Range<u32>,
    params: Params,
    totals: Pending<2>,
}

/// Parts of buffers on their way home.
pub(crate) struct Pending<const N: usize> {
    staging: Buffer,
    submission: wgpu::SubmissionIndex,
    mapped: futures_channel::oneshot::Receiver<std::result::Result<(), wgpu::BufferAsyncError>>,
    sizes: [u64; N],
}

/// What a band needs; more than its buffers hold if it has to run again.
#[derive(Debug, Clone, Copy)]
struct Totals {
    n_pairs: u64,
    /// Words of `runs` in use.
    n_words: u64,
    n_odd: u64,
    /// Rows of rays for `columns_deep`.
    n_deep: u64,
    /// Crossings that begin no run.
    n_lost: u64,
}

impl<'a> Session<'a> {
    /// Allocates buffers for bands of `rows` ray rows.
    pub(crate) fn new(gpu: &'a Gpu, cast: Cast<'a>, rows: u32) -> Result<Session<'a>> {
        let limits = gpu.device.limits();
        let n_facets = cast.frame.facets.len() as u64;
        check_facets(n_facets, &limits)?;
        let (n_rays, n_bins) = rays_and_bins(cast.rays, rows);
        let limit = Capacity::limit(&limits);
        let capacity = Capacity {
            n_rays: n_rays.min(limit.n_rays),
            n_bins: n_bins.min(limit.n_bins),
            n_pairs: first_pairs(n_bins, n_facets).min(limit.n_pairs),
            n_events: first_words(n_rays).min(limit.n_events),
        };
        Ok(Session::with_capacity(gpu, cast, capacity))
    }

    /// A session of the same mesh with buffers of its own, so that two bands can be in flight.
    pub(crate) fn sibling(&self) -> Session<'a> {
        Session::with_capacity(self.gpu, self.cast, self.buffers.capacity)
    }

    fn with_capacity(gpu: &'a Gpu, cast: Cast<'a>, capacity: Capacity) -> Session<'a> {
        let n_facets = cast.frame.facets.len() as u64;
        let (buffers, staging) = match gpu.spares.take(n_facets, capacity) {
            Some(spare) => (spare.buffers, spare.staging),
            None => (Buffers::new(&gpu.device, Facets::new(&gpu.device, n_facets), capacity), None),
        };
        let flags = flag_words(&cast.frame.ranks.flag_of_rank);
        gpu.queue.write_buffer(&buffers.facets.flag_of_rank, 0, bytemuck::cast_slice(&flags));
        let usage = Usage { peak_bytes: buffers.n_bytes, ..Usage::default() };
        Session { gpu, cast, buffers, usage, staging }
    }

    /// Keeps the buffers for the next mesh.
    pub(crate) fn end(self) {
        self.gpu.spares.keep(Spare { buffers: self.buffers, staging: self.staging });
    }

    /// The parameters of a band, written to the device with the facets that its rays may hit; makes the buffers larger if its
    /// rays do not fit.
    pub(crate) fn begin(&mut self, rows: &Range<u32>) -> Result<Params> {
        let (n_rays, n_bins) = rays_and_bins(self.cast.rays, rows.end - rows.start);
        let capacity = self.buffers.capacity;
        if n_rays > capacity.n_rays || n_bins > capacity.n_bins {
            let grow = n_rays as f64 / capacity.n_rays as f64;
            let scaled = |n: u64| (n as f64 * grow) as u64;
            self.allocate(Capacity {
                n_rays,
                n_bins,
                n_pairs: scaled(capacity.n_pairs),
                n_events: scaled(capacity.n_events),
            })?;
        }
        let capacity = self.buffers.capacity;
        let corners = corners(self.cast.frame, self.cast.rays, rows);
        let n_facets = (corners.len() / FACET_WORDS) as u64;
        let counts = [n_facets, capacity.n_pairs, capacity.n_events].map(|count| count as u32);
        let params = Params::new(&self.cast, rows, counts);
        self.gpu.queue.write_buffer(&self.buffers.facets.corners, 0, bytemuck::cast_slice(&corners));
        self.gpu.queue.write_buffer(&self.buffers.params, 0, bytemuck::bytes_of(&params));
        Ok(params)
    }

    /// Replaces the buffers by some of the wanted capacity, as far as the device allows.
    pub(crate) fn allocate(&mut self, wanted: Capacity) -> Result<()> {
        let limit = Capacity::limit(&self.gpu.device.limits());
        if wanted.n_rays > limit.n_rays || wanted.n_bins > limit.n_bins {
            let message = format!("a row of {} rays does not fit the GPU's buffers", self.cast.rays.counts[0]);
            return Err(Error::new("too-many-cells", message, "use the CPU backend"));
        }
        let capacity = Capacity {
            n_pairs: wanted.n_pairs.min(limit.n_pairs),
            n_events: wanted.n_events.min(limit.n_events),
            ..wanted
        };
        self.buffers = Buffers::new(&self.gpu.device, self.buffers.facets.clone(), capacity);
        self.usage.peak_bytes = self.usage.peak_bytes.max(self.buffers.n_bytes);
        Ok(())
    }

    /// Sends the commands of a band to the device.
    pub(crate) fn launch(&mut self, rows: Range<u32>) -> Result<Launched> {
        let params = self.begin(&rows)?;
        self.usage.n_bands += 1;
        let mut passes = self.passes(&params);
        passes.lattice();
        passes.columns();
        let encoder = passes.encoder;
        let totals = self.submit_totals(encoder, &params);
        Ok(Launched { rows, params, totals })
    }

    /// Waits for a band; None if it did not fit the buffers.
    pub(crate) async fn complete(&mut self, launched: Launched) -> Result<Option<Band>> {
        let Launched { params, totals, .. } = launched;
        let mut totals = self.finish_totals(totals).await?;
        if totals.n_deep > 0 && totals.n_pairs <= self.buffers.capacity.n_pairs {
            let pairs = PairBuffers::new(&self.gpu.device, totals.n_pairs);
            self.usage.peak_bytes = self.usage.peak_bytes.max(self.buffers.n_bytes + pairs.n_bytes());
            let mut passes = self.passes(&params);
            passes.columns_deep(&pairs);
            let encoder = passes.encoder;
            let pending = self.submit_totals(encoder, &params);
            totals = self.finish_totals(pending).await?;
        }
        if !self.buffers.capacity.holds(totals.n_pairs, totals.n_words) {
            return Ok(None);
        }
        Ok(Some(self.finish_band(&params, &totals).await?))
    }

    /// Commands for a band with the given parameters.
    pub(crate) fn passes<'b>(&'b mut self, params: &'b Params) -> Passes<'b> {
        let encoder = self.gpu.device.create_command_encoder(&Default::default());
        Passes { gpu: self.gpu, buffers: &self.buffers, params, encoder, profile: self.usage.profile.as_mut() }
    }

    /// Brings the runs of a band home.
    async fn finish_band(&mut self, params: &Params, totals: &Totals) -> Result<Band> {
        let encoder = self.gpu.device.create_command_encoder(&Default::default());
        let (chunks, runs) = (self.buffers.chunks.clone(), self.buffers.runs.clone());
        let pending = self.submit(encoder, [(&chunks, 0, 8 * params.n_chunks()), (&runs, 0, 4 * totals.n_words)]);
        let in_order = |[chunks, runs]: [&[u8]; 2]| gather(params, &words_of(chunks), &words_of(runs));
        let (ends, runs) = self.finish_with(pending, in_order).await?;
        Ok(Band {
            first_ray: u64::from(params.first_row) * u64::from(params.n_i),
            odd_rays: totals.n_odd,
            n_crossings: runs.len() as u64 + totals.n_lost,
            ends,
            runs,
        })
    }

    fn submit_totals(&mut self, encoder: CommandEncoder, params: &Params) -> Pending<2> {
        let (bins, totals) = (self.buffers.bin_offsets.clone(), self.buffers.totals.clone());
        self.submit(encoder, [(&bins, 4 * u64::from(params.n_bins), 4), (&totals, 0, 16)])
    }

    async fn finish_totals(&mut self, pending: Pending<2>) -> Result<Totals> {
        let [bins, totals] = self.finish(pending).await?;
        let [n_places, n_odd, n_deep, n_lost] = [0, 1, 2, 3].map(|i| u64::from(totals[i]));
        Ok(Totals { n_pairs: u64::from(bins[0]), n_words: 4 * n_places, n_odd, n_deep, n_lost })
    }

    /// Finishes the commands, then brings parts of buffers home: (buffer, first byte, bytes), as words.
    pub(crate) async fn read<const N: usize>(
        &mut self,
        encoder: CommandEncoder,
        parts: [(&Buffer, u64, u64); N],
    ) -> Result<[Vec<u32>; N]> {
        let pending = self.submit(encoder, parts);
        self.finish(pending).await
    }

    /// Submits the commands with copies of parts of buffers behind them.
    fn submit<const N: usize>(&mut self, mut encoder: CommandEncoder, parts: [(&Buffer, u64, u64); N]) -> Pending<N> {
        let total: u64 = parts.iter().map(|part| part.2).sum();
        let staging = self.staging(total);
        let mut at = 0;
        for (buffer, offset, size) in parts {
            encoder.copy_buffer_to_buffer(buffer, offset, &staging, at, size);
            at += size;
        }
        let submission = self.gpu.queue.submit([encoder.finish()]);
        let (sender, mapped) = futures_channel::oneshot::channel();
        staging.map_async(wgpu::MapMode::Read, 0..total.max(4), move |result| {
            // the receiver is gone only if the mesh was dropped
            let _ = sender.send(result);
        });
        Pending { staging, submission, mapped, sizes: parts.map(|part| part.2) }
    }

    /// Waits for a submission and copies its parts out, as words.
    async fn finish<const N: usize>(&mut self, pending: Pending<N>) -> Result<[Vec<u32>; N]> {
        self.finish_with(pending, |parts| parts.map(bytemuck::pod_collect_to_vec)).await
    }

    /// Waits for a submission and hands out its parts where they lie.
    async fn finish_with<const N: usize, T>(
        &mut self,
        pending: Pending<N>,
        take: impl FnOnce([&[u8]; N]) -> T,
    ) -> Result<T> {
        let Pending { staging, submission, mapped, sizes } = pending;
        // natively this blocks until this submission is done; in a browser it does nothing and the await waits
        let wait = wgpu::PollType::Wait { submission_index: Some(submission), timeout: None };
        let polled = self.gpu.device.poll(wait);
        let mapped = mapped.await;
        self.gpu.check()?;
        polled.map_err(|error| failed(&error))?;
        mapped.map_err(|error| failed(&error))?.map_err(|error| failed(&error))?;
        let total: u64 = sizes.iter().sum();
        let view = staging.get_mapped_range(0..total.max(4)).map_err(|error| failed(&error))?;
        let mut rest = &view[..];
        let taken = take(sizes.map(|size| {
            let (part, after) = rest.split_at(size as usize);
            rest = after;
            part
        }));
        drop(view);
        staging.unmap();
        self.staging = Some(staging);
        Ok(taken)
    }

    /// The staging buffer, reused: a new one costs the driver far more than the copy.
    fn staging(&mut self, size: u64) -> Buffer {
        match self.staging.take() {
            Some(staging) if staging.size() >= size => staging,
            _ => self.gpu.device.create_buffer(&BufferDescriptor {
                label: Some("staging"),
                size: size.next_power_of_two().max(256),
                usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
        }
    }

    /// After a band that did not fit: enlarges the buffers, or returns a smaller number of rows if they are at the limit.
    pub(crate) fn make_room(&mut self, rows: &Range<u32>) -> Result<u32> {
        let n_rows = rows.end - rows.start;
        let capacity = self.buffers.capacity;
        let limit = Capacity::limit(&self.gpu.device.limits());
        if capacity.n_pairs < limit.n_pairs || capacity.n_events < limit.n_events {
            self.allocate(Capacity { n_pairs: 2 * capacity.n_pairs, n_events: 2 * capacity.n_events, ..capacity })?;
            return Ok(n_rows);
        }
        if n_rows == 1 {
            let message = format!("ray row {} has more crossings than the GPU's buffers hold", rows.start);
            return Err(Error::new("too-many-crossings", message, "use the CPU backend"));
        }
        Ok(n_rows.div_ceil(2))
    }
}

/// Number of rays and of bins of so many ray rows.
fn rays_and_bins(rays: &Rays, rows: u32) -> (u64, u64) {
    let n_i = rays.counts[0];
    (u64::from(rows) * u64::from(n_i), u64::from(rows.div_ceil(BIN)) * u64::from(n_i.div_ceil(BIN)))
}

/// The words of a mapped buffer, where they lie if they are aligned there.
fn words_of<T: bytemuck::Pod>(bytes: &[u8]) -> Cow<'_, [T]> {
    bytemuck::try_cast_slice(bytes).map_or_else(|_| bytemuck::pod_collect_to_vec(bytes).into(), Cow::Borrowed)
}

fn failed(error: &dyn std::fmt::Display) -> Error {
    Error::new("device-failed", format!("the GPU's result could not be read: {error}"), "use the CPU backend")
}
