//! The deep rows of a band: their crossings counted, written, sorted and swept by the kernels that are exact, with facets in batches where
//! they are too many.

use std::ops::Range;

use super::{Outcome, Worker, begin, finish};
use crate::buffers::DeepBuffers;
use crate::layout::{BandFacets, Params};
use crate::resident::Unordered;
use crate::runs::{DEEP, DeepRows, LEFT, Raw};
use hexcast_core::base::error::Result;
use hexcast_core::stages::cast::sizes::{BIN, Capacity, deep_bytes};

/// The crossings of rows of rays on the device.
struct Written {
    /// The first crossing of each row, then the end.
    offsets: Vec<u32>,
    n_events: u64,
    /// None where there are no crossings, or too many for the device.
    buffers: Option<DeepBuffers>,
}

impl Worker<'_> {
    /// Waits for a band of which all rows are deep, and checks it.
    pub(super) async fn complete_deep(&mut self, params: &Params, facets: &BandFacets) -> Result<Outcome> {
        let n_chunks = params.n_chunks();
        let deep = self.deep_rows(Params { all_deep: 1, ..*params }, facets, n_chunks).await?;
        let is_least = params.end_row - params.first_row <= BIN;
        if !is_least && deep.events.is_empty() && deep.buffers.is_none() && deep.rows.first() == Some(&LEFT) {
            return Ok(Outcome::TooMany);
        }
        if let Some(resident) = self.context.resident {
            let params = Params { all_deep: 1, ..*params };
            return self
                .order(resident, &params, Unordered { deep, n_places: 0, n_unused: 0, n_lost: 0, n_hits: None })
                .await;
        }
        let chunks: Vec<[u32; 2]> = (0..n_chunks as u32).map(|index| [index, DEEP]).collect();
        let raw = Raw { chunks: &chunks, places: &[], n_lost: 0, n_unused: 0, n_hits: None, deep: &deep };
        Ok(finish(&self.cast, params, &raw))
    }

    /// Casts and maps `n_rows` deep rows: against facets that are on the device, or all in batches. What is too much for the device is
    /// marked as left.
    pub(super) async fn deep_rows(&mut self, params: Params, facets: &BandFacets, n_rows: u64) -> Result<DeepRows> {
        let Written { offsets, n_events, buffers } = self.write_crossings(params, facets, n_rows).await?;
        let mut deep = DeepRows { offsets, rows: vec![0; 16 * n_rows as usize], ..DeepRows::default() };
        if let (Some(of_band), Some(buffers)) = (&self.buffers, &buffers) {
            let n_events = if self.context.resident.is_some() { 0 } else { n_events };
            let mut passes = begin(self.context, self.profile.as_mut());
            passes.map_deep(of_band, buffers, n_rows);
            let parts = [buffers.deep_rows.first(16 * n_rows), buffers.events.first(n_events)];
            [deep.rows, deep.events] = self.staging.read(self.context.opened, passes.encoder, parts).await?;
        } else if n_events > 0 {
            deep.rows.iter_mut().step_by(16).for_each(|first| *first = LEFT);
        }
        deep.buffers = buffers.filter(|_| self.context.resident.is_some());
        Ok(deep)
    }

    /// The first crossing of each of `n_rows` deep rows, then the end; and the crossings, in no order within a row, then the facet of
    /// each if the parameters say so. None where they are too many for the device.
    pub(crate) async fn crossings(
        &mut self,
        params: Params,
        facets: &BandFacets,
        n_rows: u64,
    ) -> Result<(Vec<u32>, Option<Vec<u32>>)> {
        let Written { offsets, n_events, buffers } = self.write_crossings(params, facets, n_rows).await?;
        let Some(buffers) = buffers else { return Ok((offsets, (n_events == 0).then(Vec::new))) };
        let parts = [buffers.events.first((1 + u64::from(params.with_facets)) * n_events)];
        let [events] = self.staging.read(self.context.opened, self.context.opened.encoder(), parts).await?;
        Ok((offsets, Some(events)))
    }

    async fn write_crossings(&mut self, mut params: Params, facets: &BandFacets, n_rows: u64) -> Result<Written> {
        let opened = self.context.opened;
        let least = Capacity { n_facets: 1, n_centres: self.centres.len() as u64, ..Capacity::default() };
        let has_room = deep_bytes(n_rows, 0) <= self.deep_bytes && self.has_room_for(least);
        if facets.len() == 0 || !has_room {
            let n_events = if facets.len() == 0 { 0 } else { u64::MAX };
            return Ok(Written { offsets: vec![0; n_rows as usize + 1], n_events, buffers: None });
        }
        let batches = if params.all_deep == 0 {
            vec![]
        } else {
            let most = self.forced.facets_of_batch.unwrap_or(usize::MAX).min(self.limit.n_facets as usize);
            facets.batches(most, 1 << 28)
        };
        let largest = batches.iter().map(|batch| batch.len() as u64).max().unwrap_or(0);
        self.make_room(Capacity { n_facets: largest, ..least });
        if let Some(of_band) = &self.buffers {
            of_band.centres.write(&opened.queue, &self.centres);
        }
        self.free_for(deep_bytes(n_rows, 0));
        let mut buffers = DeepBuffers::new(opened, n_rows);
        // an emptied buffer begins as zeros
        self.cast_deep(&mut params, facets, &batches, &buffers).await?;
        let mut passes = begin(self.context, self.profile.as_mut());
        passes.scan_deep(&buffers, n_rows);
        let parts = [buffers.event_offsets.first(n_rows + 1)];
        let [offsets] = self.staging.read(opened, passes.encoder, parts).await?;
        let n_events = if offsets.is_sorted() { offsets[n_rows as usize].into() } else { u64::MAX };
        // two words a crossing
        let most = self.limit.n_counters / 2;
        if n_events == 0 || n_events > most || deep_bytes(n_rows, n_events) > self.deep_bytes {
            return Ok(Written { offsets, n_events, buffers: None });
        }
        self.free_for(deep_bytes(n_rows, n_events));
        buffers = buffers.with_events(opened, n_events);
        params.event_capacity = n_events as u32;
        self.cast_deep(&mut params, facets, &batches, &buffers).await?;
        Ok(Written { offsets, n_events, buffers: Some(buffers) })
    }

    /// Submits `intersect_deep` for each batch of facets, or for those that are on the device.
    async fn cast_deep(
        &mut self,
        params: &mut Params,
        facets: &BandFacets,
        batches: &[Range<usize>],
        deep: &DeepBuffers,
    ) -> Result<()> {
        if batches.is_empty() {
            self.submit_cast(params, deep);
        }
        for (index, batch) in batches.iter().enumerate() {
            if index > 0 {
                // or else the facets of all batches would be on their way at once
                let opened = self.context.opened;
                self.staging.read(opened, opened.encoder(), []).await?;
            }
            self.send(params, facets, batch.clone());
            self.submit_cast(params, deep);
        }
        Ok(())
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
