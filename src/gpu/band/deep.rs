//! The deep rows of a band: their crossings counted, written, sorted and swept by the kernels that are exact, with facets in batches where
//! they are too many.

use std::ops::Range;

use super::{Worker, begin};
use crate::cast::sizes::Capacity;
use crate::error::Result;
use crate::gpu::buffers::DeepBuffers;
use crate::gpu::layout::{BandFacets, Params};
use crate::gpu::runs::{DeepRows, LEFT};

/// The crossings of rows of rays on the device.
struct Written {
    buffers: DeepBuffers,
    n_events: u64,
}

impl Worker<'_> {
    /// Casts and maps `n_rows` deep rows: against facets that are on the device, or all in batches. What is too much for the device is
    /// marked as left.
    pub(super) async fn deep_rows(&mut self, params: Params, facets: &BandFacets, n_rows: u64) -> Result<DeepRows> {
        let (offsets, written) = self.write_crossings(params, facets, n_rows).await?;
        let mut deep = DeepRows { offsets, rows: vec![0; 16 * n_rows as usize], events: vec![] };
        match written {
            Some(Written { n_events: 0, .. }) => {}
            Some(Written { buffers, n_events }) => {
                let Some(of_band) = &self.buffers else { unreachable!("there is room") };
                let mut passes = begin(self.context, self.profile.as_mut());
                passes.map_deep(of_band, &buffers, n_rows);
                let encoder = passes.encoder;
                let parts = [buffers.deep_rows.first(16 * n_rows), buffers.events.first(n_events)];
                let pending = self.staging.submit(self.context.opened, encoder, parts);
                [deep.rows, deep.events] = self.staging.words(self.context.opened, pending).await?;
            }
            None => deep.rows.iter_mut().step_by(16).for_each(|first| *first = LEFT),
        }
        Ok(deep)
    }

    /// The first crossing of each of `n_rows` deep rows, then the end; and the crossings, in no order within a row, then the facet of
    /// each if the parameters say so. None where they are too many for the device.
    pub(in crate::gpu) async fn crossings(
        &mut self,
        params: Params,
        facets: &BandFacets,
        n_rows: u64,
    ) -> Result<(Vec<u32>, Option<Vec<u32>>)> {
        let (offsets, written) = self.write_crossings(params, facets, n_rows).await?;
        let Some(Written { buffers, n_events }) = written else { return Ok((offsets, None)) };
        if n_events == 0 {
            return Ok((offsets, Some(vec![])));
        }
        let encoder = self.context.opened.device.create_command_encoder(&Default::default());
        let parts = [buffers.events.first((1 + u64::from(params.with_facets)) * n_events)];
        let pending = self.staging.submit(self.context.opened, encoder, parts);
        let [events] = self.staging.words(self.context.opened, pending).await?;
        Ok((offsets, Some(events)))
    }

    async fn write_crossings(
        &mut self,
        mut params: Params,
        facets: &BandFacets,
        n_rows: u64,
    ) -> Result<(Vec<u32>, Option<Written>)> {
        let opened = self.context.opened;
        let batches = if params.all_deep == 0 {
            vec![]
        } else {
            let most = self.forced.facets_of_batch.unwrap_or(usize::MAX).min(self.limit.n_facets as usize);
            facets.batches(most, 1 << 28)
        };
        let largest = batches.iter().map(|batch| batch.len() as u64).max().unwrap_or(0);
        self.make_room(Capacity { n_facets: largest, ..Capacity::default() });
        let mut buffers = DeepBuffers::new(&opened.device, n_rows);
        // an emptied buffer begins as zeros
        self.cast_deep(&mut params, facets, &batches, &buffers);
        let mut passes = begin(self.context, self.profile.as_mut());
        passes.scan_deep(&buffers, n_rows);
        let encoder = passes.encoder;
        let pending = self.staging.submit(opened, encoder, [buffers.event_offsets.first(n_rows + 1)]);
        let [offsets] = self.staging.words(opened, pending).await?;
        let n_events = u64::from(offsets[n_rows as usize]);
        if 2 * n_events > self.limit.n_counters || !offsets.is_sorted() {
            return Ok((offsets, None));
        }
        if n_events > 0 {
            buffers = buffers.with_events(&opened.device, n_events);
            params.event_capacity = n_events as u32;
            self.cast_deep(&mut params, facets, &batches, &buffers);
        }
        let held = self.buffers.as_ref().map_or(0, |buffers| buffers.capacity.n_bytes());
        self.peak_bytes = self.peak_bytes.max(held + buffers.n_bytes());
        Ok((offsets, Some(Written { buffers, n_events })))
    }

    /// Submits `intersect_deep` for each batch of facets, or for those that are on the device.
    fn cast_deep(&mut self, params: &mut Params, facets: &BandFacets, batches: &[Range<usize>], deep: &DeepBuffers) {
        if batches.is_empty() {
            self.submit_cast(params, deep);
        }
        for batch in batches {
            self.send(params, facets, batch.clone());
            self.submit_cast(params, deep);
        }
    }

    fn submit_cast(&mut self, params: &Params, deep: &DeepBuffers) {
        let Some(buffers) = &self.buffers else { unreachable!("there is room") };
        let queue = &self.context.opened.queue;
        buffers.params.write(queue, &[*params]);
        let mut passes = begin(self.context, self.profile.as_mut());
        passes.intersect_deep(buffers, deep, params);
        queue.submit([passes.encoder.finish()]);
    }
}
