//! One mesh on one device: its buffers, its commands, and the way home of its results.

use std::ops::Range;

use wgpu::{Buffer, BufferDescriptor, BufferUsages, CommandEncoder};

use super::buffers::{Buffers, Capacity, check_facets};
use super::device::Gpu;
use super::layout::{BIN, Params, corners, flag_words};
use super::line::{Cast, Usage};
use super::passes::Passes;
use crate::columns::Band;
use crate::error::{Error, Result};

/// The device, what is meshed, and the buffers for one band of it.
pub(crate) struct Session<'a> {
    pub(crate) gpu: &'a Gpu,
    pub(crate) cast: Cast<'a>,
    pub(crate) buffers: Buffers,
    pub(crate) usage: Usage,
    staging: Option<Buffer>,
}

/// What a band needs; more than its buffers hold if it has to run again.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Totals {
    pub(crate) n_pairs: u64,
    pub(crate) n_events: u64,
    pub(crate) n_runs: u64,
    pub(crate) n_odd: u64,
}

impl<'a> Session<'a> {
    /// Uploads the facets and allocates buffers for bands of `rows` ray rows.
    pub(crate) fn new(gpu: &'a Gpu, cast: Cast<'a>, rows: u32) -> Result<Session<'a>> {
        let Cast { frame, rays, .. } = cast;
        let limits = gpu.device.limits();
        let n_facets = frame.facets.len() as u64;
        check_facets(n_facets, &limits)?;
        let n_rays = u64::from(rows) * u64::from(rays.counts[0]);
        let n_bins = u64::from(rows.div_ceil(BIN)) * u64::from(rays.counts[0].div_ceil(BIN));
        let limit = Capacity::limit(&limits);
        let capacity = Capacity {
            n_rays: n_rays.min(limit.n_rays),
            n_bins: n_bins.min(limit.n_bins),
            n_pairs: (16 * n_bins + 3 * n_facets).min(limit.n_pairs),
            n_events: (6 * n_rays).min(limit.n_events),
        };
        let buffers = Buffers::new(&gpu.device, n_facets, capacity);
        let usage = Usage { peak_bytes: buffers.n_bytes, ..Usage::default() };
        let session = Session { gpu, cast, buffers, usage, staging: None };
        session.upload();
        Ok(session)
    }

    fn upload(&self) {
        let queue = &self.gpu.queue;
        queue.write_buffer(&self.buffers.corners, 0, bytemuck::cast_slice(&corners(self.cast.frame, self.cast.rays)));
        let flags = flag_words(&self.cast.frame.ranks.flag_of_rank);
        queue.write_buffer(&self.buffers.flag_of_rank, 0, bytemuck::cast_slice(&flags));
    }

    /// The parameters of a band, written to the device; makes the buffers larger if its rays do not fit.
    pub(crate) fn begin(&mut self, rows: &Range<u32>) -> Result<Params> {
        let n_rays = u64::from(rows.end - rows.start) * u64::from(self.cast.rays.counts[0]);
        let n_bins =
            u64::from((rows.end - rows.start).div_ceil(BIN)) * u64::from(self.cast.rays.counts[0].div_ceil(BIN));
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
        let (pairs, events) = (capacity.n_pairs as u32, capacity.n_events as u32);
        let params = Params::new(&self.cast, rows, pairs, events);
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
        self.buffers = Buffers::new(&self.gpu.device, self.cast.frame.facets.len() as u64, capacity);
        self.usage.peak_bytes = self.usage.peak_bytes.max(self.buffers.n_bytes);
        self.upload();
        Ok(())
    }

    /// Runs a band; None if it did not fit, after enlarging the buffers as far as the device allows.
    pub(crate) async fn band(&mut self, rows: Range<u32>) -> Result<Option<Band>> {
        let params = self.begin(&rows)?;
        self.usage.n_bands += 1;
        let gpu = self.gpu;
        let encoder = gpu.device.create_command_encoder(&Default::default());
        let profile = self.usage.profile.as_mut();
        let mut passes = Passes { gpu, buffers: &self.buffers, params: &params, encoder, profile };
        passes.lattice();
        passes.intersect();
        passes.map();
        let encoder = passes.encoder;
        let totals = self.totals(encoder, &params).await?;
        if !self.buffers.capacity.holds(totals.n_pairs, totals.n_events) {
            return Ok(None);
        }
        Ok(Some(self.finish_band(&params, &totals).await?))
    }

    /// Brings the runs of a band home.
    pub(crate) async fn finish_band(&mut self, params: &Params, totals: &Totals) -> Result<Band> {
        let n_rays = u64::from(params.n_rays());
        let encoder = self.gpu.device.create_command_encoder(&Default::default());
        // the scan put the end of ray r at r + 1
        let (ends, runs) = (self.buffers.run_offsets.clone(), self.buffers.runs.clone());
        let [ends, runs] = self.read(encoder, [(&ends, 4, 4 * n_rays), (&runs, 0, 4 * totals.n_runs)]).await?;
        Ok(Band {
            first_ray: u64::from(params.first_row) * u64::from(params.n_i),
            ends,
            runs,
            odd_rays: totals.n_odd,
            n_crossings: totals.n_events,
        })
    }

    pub(crate) async fn totals(&mut self, encoder: CommandEncoder, params: &Params) -> Result<Totals> {
        let (n_bins, n_rays) = (u64::from(params.n_bins), u64::from(params.n_rays()));
        let b = &self.buffers;
        let (bins, rays, runs, odd) =
            (b.bin_offsets.clone(), b.ray_offsets.clone(), b.run_offsets.clone(), b.n_odd.clone());
        let parts = [(&bins, 4 * n_bins, 4), (&rays, 4 * n_rays, 4), (&runs, 4 * n_rays, 4), (&odd, 0, 4)];
        let [n_pairs, n_events, n_runs, n_odd] = self.read(encoder, parts).await?.map(|words| u64::from(words[0]));
        Ok(Totals { n_pairs, n_events, n_runs, n_odd })
    }

    /// Finishes the commands, then brings parts of buffers home: (buffer, first byte, bytes), as words.
    pub(crate) async fn read<const N: usize>(
        &mut self,
        mut encoder: CommandEncoder,
        parts: [(&Buffer, u64, u64); N],
    ) -> Result<[Vec<u32>; N]> {
        let total: u64 = parts.iter().map(|part| part.2).sum();
        let staging = self.staging(total);
        let mut at = 0;
        for (buffer, offset, size) in parts {
            encoder.copy_buffer_to_buffer(buffer, offset, &staging, at, size);
            at += size;
        }
        self.gpu.queue.submit([encoder.finish()]);
        let mapped = self.map(&staging, total.max(4)).await;
        self.gpu.check()?;
        mapped?;
        let view = staging.get_mapped_range(0..total.max(4)).map_err(|error| failed(&error))?;
        let mut rest = &view[..];
        let words = parts.map(|(_, _, size)| {
            let (part, after) = rest.split_at(size as usize);
            rest = after;
            bytemuck::pod_collect_to_vec(part)
        });
        drop(view);
        staging.unmap();
        self.staging = Some(staging);
        Ok(words)
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

    async fn map(&self, staging: &Buffer, size: u64) -> Result<()> {
        let (sender, receiver) = futures_channel::oneshot::channel();
        staging.map_async(wgpu::MapMode::Read, 0..size, move |result| {
            // the receiver is gone only if the mesh was dropped
            let _ = sender.send(result);
        });
        // natively this blocks until the work is done; in a browser it does nothing and the await waits
        self.gpu.device.poll(wgpu::PollType::wait_indefinitely()).map_err(|error| failed(&error))?;
        match receiver.await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(error)) => Err(failed(&error)),
            Err(error) => Err(failed(&error)),
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

fn failed(error: &dyn std::fmt::Display) -> Error {
    Error::new("device-failed", format!("the GPU's result could not be read: {error}"), "use the CPU backend")
}
