//! Single stages on the GPU, over the whole box in one band, each from the value before it, be it computed here or on the
//! CPU. This is how a wrong kernel is found; a mesh runs [`Gpu::columns`], which keeps everything on the device.

use super::buffers::{Capacity, CrossingBuffers};
use super::device::Gpu;
use super::layout::BIN;
use super::line::Cast;
use super::session::Session;
use crate::columns::Band;
use crate::crossings::Crossings;
use crate::error::Result;
use crate::lattice::Lattice;

impl Gpu {
    /// Builds the lattice with bins of 8 x 8 rays; facets are in no order within a bin.
    ///
    /// # Errors
    /// Those of [`Gpu::columns`].
    pub async fn lattice(&self, cast: &Cast<'_>) -> Result<Lattice> {
        let mut session = Session::new(self, *cast, cast.rays.counts[1])?;
        loop {
            let params = session.begin(&(0..cast.rays.counts[1]))?;
            let mut passes = session.passes(&params);
            passes.lattice();
            let encoder = passes.encoder;
            let n_offsets = 4 * (u64::from(params.n_bins) + 1);
            let [offsets] = session.read(encoder, [(&session.buffers.bin_offsets.clone(), 0, n_offsets)]).await?;
            let n_pairs = u64::from(offsets[offsets.len() - 1]);
            if n_pairs > session.buffers.capacity.n_pairs {
                session.allocate(Capacity { n_pairs, ..session.buffers.capacity })?;
                continue;
            }
            let encoder = self.device.create_command_encoder(&Default::default());
            let [pairs] = session.read(encoder, [(&session.buffers.pairs.clone(), 0, 8 * n_pairs)]).await?;
            let facets = pairs.chunks_exact(2).map(|pair| pair[0]).collect();
            let n_rows = cast.rays.counts[1].div_ceil(BIN);
            return Ok(Lattice { bin: [BIN; 2], n_across: params.n_across, rows: 0..n_rows, offsets, facets });
        }
    }

    /// Casts all rays against a lattice of the whole box with bins of 8 x 8 rays.
    ///
    /// # Errors
    /// Those of [`Gpu::columns`].
    pub async fn crossings(&self, cast: &Cast<'_>, lattice: &Lattice) -> Result<Crossings> {
        let mut session = Session::new(self, *cast, cast.rays.counts[1])?;
        let n_pairs = lattice.facets.len() as u64;
        session.allocate(Capacity { n_pairs: n_pairs.max(1), ..session.buffers.capacity })?;
        loop {
            let params = session.begin(&(0..cast.rays.counts[1]))?;
            session.upload_lattice(lattice);
            let between = CrossingBuffers::new(&self.device, session.buffers.capacity);
            let mut passes = session.passes(&params);
            passes.intersect(&between);
            let encoder = passes.encoder;
            let n_offsets = 4 * (u64::from(params.n_rays()) + 1);
            let [offsets] = session.read(encoder, [(&between.ray_offsets, 0, n_offsets)]).await?;
            let n_events = u64::from(offsets[offsets.len() - 1]);
            if n_events > session.buffers.capacity.n_events {
                session.allocate(Capacity { n_events, ..session.buffers.capacity })?;
                continue;
            }
            let encoder = self.device.create_command_encoder(&Default::default());
            let [events] = session.read(encoder, [(&between.events, 0, 4 * n_events)]).await?;
            return Ok(Crossings { first_ray: 0, offsets, events });
        }
    }

    /// Maps the crossings of all rays to runs.
    ///
    /// # Errors
    /// Those of [`Gpu::columns`].
    pub async fn map(&self, cast: &Cast<'_>, crossings: &Crossings) -> Result<Band> {
        let mut session = Session::new(self, *cast, cast.rays.counts[1])?;
        let n_events = crossings.events.len() as u64;
        session.allocate(Capacity { n_events: n_events.max(1), ..session.buffers.capacity })?;
        let params = session.begin(&(0..cast.rays.counts[1]))?;
        let between = CrossingBuffers::new(&self.device, session.buffers.capacity);
        self.queue.write_buffer(&between.ray_offsets, 0, bytemuck::cast_slice(&crossings.offsets));
        self.queue.write_buffer(&between.events, 0, bytemuck::cast_slice(&crossings.events));
        let mut passes = session.passes(&params);
        passes.map(&between);
        let encoder = passes.encoder;
        let n_rays = u64::from(params.n_rays());
        // the scan put the end of ray r at r + 1
        let counts = [(&between.run_offsets, 4, 4 * n_rays), (&between.n_odd, 0, 4)];
        let [ends, n_odd] = session.read(encoder, counts).await?;
        let n_runs = u64::from(ends.last().copied().unwrap_or(0));
        let encoder = self.device.create_command_encoder(&Default::default());
        let [runs] = session.read(encoder, [(&session.buffers.runs.clone(), 0, 4 * n_runs)]).await?;
        Ok(Band { first_ray: 0, ends, runs, odd_rays: u64::from(n_odd[0]), n_crossings: n_events })
    }
}

impl Session<'_> {
    fn upload_lattice(&self, lattice: &Lattice) {
        let bins = lattice.offsets.windows(2).enumerate();
        let pairs: Vec<[u32; 2]> = bins
            .flat_map(|(bin, ends)| {
                lattice.facets[ends[0] as usize..ends[1] as usize].iter().map(move |&f| [f, bin as u32])
            })
            .collect();
        let queue = &self.gpu.queue;
        queue.write_buffer(&self.buffers.bin_offsets, 0, bytemuck::cast_slice(&lattice.offsets));
        queue.write_buffer(&self.buffers.pairs, 0, bytemuck::cast_slice(&pairs));
    }
}
