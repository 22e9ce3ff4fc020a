//! The line on the GPU: bands of ray rows, from facets to columns.
//!
//! A band is as many ray rows as fit the buffers and take about [`TARGET_SECONDS`] a submit. What a band needs is known only
//! when it has run: a band that found more pairs or crossings than its buffers hold is thrown away and run again with
//! larger buffers, or, at the limit of the device, in halves. Neither changes the result.

use std::ops::Range;

use web_time::Instant;
use wgpu::{Buffer, BufferDescriptor, BufferUsages, CommandEncoder};

use super::buffers::{Buffers, Capacity, check_facets};
use super::device::Gpu;
use super::layout::{BIN, Params, corners, flag_words};
use super::passes::{Passes, Profile};
use crate::columns::{Band, Columns};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::map::Rule;
use crate::rays::Rays;

/// Time that a submit aims at: long enough to hide its overhead, short enough that no driver gives up on it.
const TARGET_SECONDS: f64 = 0.08;
/// Rays of the first band, before anything is known about the device's speed.
const FIRST_RAYS: u64 = 1 << 18;
/// Most rays of a band.
const MAX_RAYS: u64 = 1 << 22;

/// What a mesh has used of the device.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Usage {
    /// Most bytes of buffers held at once.
    pub peak_bytes: u64,
    /// Bands that were run, those run again included.
    pub n_bands: u32,
    /// Seconds in each kernel; set it to an empty map to measure.
    pub profile: Option<Profile>,
}

/// One mesh on one device.
pub(crate) struct Session<'a> {
    pub(crate) gpu: &'a Gpu,
    pub(crate) frame: &'a Frame,
    pub(crate) rays: &'a Rays,
    pub(crate) rule: Rule,
    pub(crate) buffers: Buffers,
    staging: Option<Buffer>,
    pub(crate) usage: Usage,
}

/// What a band needs at least; more than its buffers hold if it has to run again.
#[derive(Debug, Clone, Copy)]
struct Totals {
    n_pairs: u64,
    n_events: u64,
    n_runs: u64,
    n_odd: u64,
}

impl Gpu {
    /// Meshes the box in bands whose size follows from the limits and the speed of the device.
    ///
    /// # Errors
    /// `cancelled`; `too-many-facets`, `too-many-crossings` at the limits of the device; `device-failed`, `device-lost`.
    pub async fn columns(&self, frame: &Frame, rays: &Rays, rule: Rule, control: &Control) -> Result<Columns> {
        let mut bands = Vec::new();
        self.continue_columns(frame, rays, rule, control, None, &mut bands).await?;
        Ok(Columns::new(*rays, bands))
    }

    /// Meshes the rays after those of `bands` and appends theirs; on an error `bands` holds all that was finished.
    ///
    /// `rows_per_band` fixes the number of ray rows of a band (for tests; the result does not depend on it).
    ///
    /// # Errors
    /// Those of [`Gpu::columns`].
    pub async fn continue_columns(
        &self,
        frame: &Frame,
        rays: &Rays,
        rule: Rule,
        control: &Control,
        rows_per_band: Option<u32>,
        bands: &mut Vec<Band>,
    ) -> Result<Usage> {
        let most_rows = u32::try_from(MAX_RAYS / u64::from(rays.counts[0])).unwrap_or(u32::MAX).max(1);
        let mut rows = rows_per_band.unwrap_or(whole_bins(FIRST_RAYS / u64::from(rays.counts[0])).min(most_rows));
        let mut next: u32 = bands.iter().map(|band| (band.ends.len() as u64 / u64::from(rays.counts[0])) as u32).sum();
        let mut session = Session::new(self, frame, rays, rule, rows.min(rays.counts[1]))?;
        while next < rays.counts[1] {
            control.check()?;
            let range = next..next.saturating_add(rows).min(rays.counts[1]);
            let start = Instant::now();
            match session.band(range.clone()).await? {
                Some(band) => bands.push(band),
                None => {
                    rows = session.make_room(&range)?;
                    continue;
                }
            }
            next = range.end;
            control.advance(u64::from(next) * u64::from(rays.counts[0]), rays.n_rays());
            if rows_per_band.is_none() {
                let fitting =
                    f64::from(rows) * (TARGET_SECONDS / start.elapsed().as_secs_f64().max(1e-4)).clamp(0.5, 2.0);
                rows = whole_bins(fitting as u64).min(most_rows);
            }
        }
        Ok(session.usage)
    }
}

/// Rounds a number of rows down to whole bins, at least one.
fn whole_bins(rows: u64) -> u32 {
    let rows = rows.min(1 << 30) as u32;
    (rows / BIN * BIN).max(BIN)
}

impl<'a> Session<'a> {
    /// Uploads the facets and allocates buffers for bands of `rows` ray rows.
    pub(crate) fn new(gpu: &'a Gpu, frame: &'a Frame, rays: &'a Rays, rule: Rule, rows: u32) -> Result<Session<'a>> {
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
        let usage = Usage {
            peak_bytes: buffers.n_bytes,
            n_bands: 0,
            profile: std::env::var("PROF").ok().map(|_| Profile::new()),
        };
        let session = Session { gpu, frame, rays, rule, buffers, staging: None, usage };
        session.upload();
        Ok(session)
    }

    fn upload(&self) {
        let queue = &self.gpu.queue;
        queue.write_buffer(&self.buffers.corners, 0, bytemuck::cast_slice(&corners(self.frame, self.rays)));
        let flags = flag_words(&self.frame.ranks.flag_of_rank);
        queue.write_buffer(&self.buffers.flag_of_rank, 0, bytemuck::cast_slice(&flags));
    }

    /// The parameters of a band, written to the device; makes the buffers larger if its rays do not fit.
    pub(crate) fn begin(&mut self, rows: &Range<u32>) -> Result<Params> {
        let n_rays = u64::from(rows.end - rows.start) * u64::from(self.rays.counts[0]);
        let n_bins = u64::from((rows.end - rows.start).div_ceil(BIN)) * u64::from(self.rays.counts[0].div_ceil(BIN));
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
        let params = Params::new(self.frame, self.rays, self.rule, rows, pairs, events);
        self.gpu.queue.write_buffer(&self.buffers.params, 0, bytemuck::bytes_of(&params));
        Ok(params)
    }

    fn allocate(&mut self, wanted: Capacity) -> Result<()> {
        let limit = Capacity::limit(&self.gpu.device.limits());
        if wanted.n_rays > limit.n_rays || wanted.n_bins > limit.n_bins {
            let message = format!("a row of {} rays does not fit the GPU's buffers", self.rays.counts[0]);
            return Err(Error::new("too-many-cells", message, "use the CPU backend"));
        }
        let capacity = Capacity {
            n_pairs: wanted.n_pairs.min(limit.n_pairs),
            n_events: wanted.n_events.min(limit.n_events),
            ..wanted
        };
        self.buffers = Buffers::new(&self.gpu.device, self.frame.facets.len() as u64, capacity);
        self.usage.peak_bytes = self.usage.peak_bytes.max(self.buffers.n_bytes);
        self.upload();
        Ok(())
    }

    /// Runs a band; None if it did not fit, after enlarging the buffers as far as the device allows.
    async fn band(&mut self, rows: Range<u32>) -> Result<Option<Band>> {
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
        let n_rays = u64::from(params.n_rays());
        let encoder = gpu.device.create_command_encoder(&Default::default());
        // the scan put the end of ray r at r + 1
        let parts =
            [(&self.buffers.run_offsets.clone(), 4, 4 * n_rays), (&self.buffers.runs.clone(), 0, 4 * totals.n_runs)];
        let [ends, runs] = self.read(encoder, parts).await?;
        Ok(Some(Band {
            first_ray: u64::from(rows.start) * u64::from(self.rays.counts[0]),
            ends,
            runs,
            odd_rays: totals.n_odd,
            n_crossings: totals.n_events,
        }))
    }

    async fn totals(&mut self, encoder: CommandEncoder, params: &Params) -> Result<Totals> {
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
    fn make_room(&mut self, rows: &Range<u32>) -> Result<u32> {
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
