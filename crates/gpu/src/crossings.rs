//! The crossings of all rays, one by one, for what needs more than runs: `intersect_deep` over every row, band after band.
//!
//! What the device returns is checked as in `runs.rs`: every index before it is used, and a sample of the rays against the CPU
//! definition. Where one row of bins has more crossings than a buffer holds the CPU casts it.

use std::ops::Range;

use crate::band::{Forced, Launched, Worker};
use crate::check::sample;
use crate::layout::{BandFacets, Params};
use crate::runs::Fault;
use crate::{Gpu, Options, Pace, Usage};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::base::parallel::*;
use hexcast_core::base::sort::by_number;
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::cast::sizes::BIN;
use hexcast_core::stages::cpu::{over_windows, window_of_rows};
use hexcast_core::stages::crossings::Crossings;

/// Ray rows that one task puts in order.
const ROWS: u32 = 16;

/// What became of the crossings of a band.
enum Outcome {
    /// They are right; rays that were cast again.
    Done(Vec<Crossings>, u64),
    TooMany,
    /// The device was wrong: a sentence, the rays that were looked at, and those that were wrong.
    Wrong(Fault, [u64; 2]),
}

impl Gpu {
    /// Casts some rows of rays and hands out their crossings, in order, some rows at a time; with their facets, if asked. Adds to
    /// `usage`.
    ///
    /// # Errors
    /// Those of [`Gpu::columns`].
    #[doc(hidden)]
    pub async fn crossings(
        &self,
        cast: &Cast<'_>,
        (options, with_facets): (&Options, bool),
        control: &Control,
        rows: Range<u32>,
        usage: &mut Usage,
        take: &mut impl FnMut(Vec<Crossings>),
    ) -> Result<()> {
        self.scoped(self.crossings_of_bands(cast, (options, with_facets), control, rows, (usage, take))).await
    }

    async fn crossings_of_bands(
        &self,
        cast: &Cast<'_>,
        (options, with_facets): (&Options, bool),
        control: &Control,
        rows: Range<u32>,
        (usage, take): (&mut Usage, &mut impl FnMut(Vec<Crossings>)),
    ) -> Result<()> {
        let mut pace = Pace::new(options.rows_per_band, options.most_rows, cast.rays.counts[0], self.band_seconds());
        let context = self.begin(options);
        let mut worker = Worker::new(context, *cast, Forced { deep: true, ..options.forced });
        let mut next = rows.start;
        while next < rows.end {
            control.check()?;
            let range = next..next.saturating_add(pace.rows).min(rows.end);
            let n_rows = range.end - range.start;
            let crossings = match worker.crossings_of_rows(range.clone(), with_facets).await {
                Err(error) => return Err(self.opened.cause(error, control).await),
                Ok(Outcome::Done(crossings, n_checked)) => {
                    usage.checked[0] += n_checked;
                    crossings
                }
                Ok(Outcome::TooMany) if n_rows > BIN => {
                    pace.limit(n_rows.div_ceil(2));
                    continue;
                }
                Ok(Outcome::TooMany) => {
                    usage.left += u64::from(n_rows) * u64::from(cast.rays.counts[0]);
                    over_windows(cast, &[window_of_rows(cast.rays, range.clone())], with_facets, Crossings::clone)
                }
                Ok(Outcome::Wrong(what, checked)) => return Err(self.wrong(usage, &what, checked)),
            };
            take(crossings);
            usage.peak_bytes = usage.peak_bytes.max(self.opened.held.peak());
            control.pause().await;
            pace.finished(n_rows, 0.0);
            usage.n_bands += 1;
            usage.rows_of_band = n_rows;
            next = range.end;
        }
        worker.end();
        Ok(())
    }
}

impl Worker<'_> {
    async fn crossings_of_rows(&mut self, rows: Range<u32>, with_facets: bool) -> Result<Outcome> {
        let Some(Launched { params, facets, .. }) = self.prepare(rows)? else { return Ok(Outcome::TooMany) };
        let params = Params { all_deep: 1, with_facets: with_facets.into(), ..params };
        let (offsets, Some(events)) = self.crossings(params, &facets, params.n_chunks()).await? else {
            return Ok(Outcome::TooMany);
        };
        let returned = Returned { params, facets: &facets, offsets: &offsets, events: &events };
        let tasks: Vec<u32> = (params.first_row..params.end_row).step_by(ROWS as usize).collect();
        let in_order: std::result::Result<Vec<Crossings>, Fault> =
            tasks.into_par_iter().map(|row| returned.rows(row)).collect::<Vec<_>>().into_iter().collect();
        Ok(match in_order {
            Ok(crossings) => checked(&self.cast, &params, crossings),
            Err(fault) => Outcome::Wrong(fault, [u64::from(params.n_rays()); 2]),
        })
    }
}

/// What a device returned, unchecked.
struct Returned<'a> {
    params: Params,
    facets: &'a BandFacets,
    offsets: &'a [u32],
    /// Crossings, then facets if wanted.
    events: &'a [u32],
}

impl Returned<'_> {
    /// The crossings of the rows of a task.
    fn rows(&self, first_row: u32) -> std::result::Result<Crossings, Fault> {
        let Params { n_i, n_across, depth, n_ranks, .. } = self.params;
        let end_row = (first_row + ROWS).min(self.params.end_row);
        let (events, facets) = self.events.split_at(self.offsets[self.offsets.len() - 1] as usize);
        let mut hits = Vec::new();
        for row in first_row..end_row {
            for column in 0..n_across {
                let chunk = ((row - self.params.first_row) * n_across + column) as usize;
                for place in self.offsets[chunk] as usize..self.offsets[chunk + 1] as usize {
                    let event = events[place] & ((1 << 27) - 1);
                    let (i, cell, rank) = (column * BIN + (events[place] >> 27), event >> 9, event >> 1 & 0xff);
                    let facet = facets.get(place).map_or(0, |&facet| self.facets.index(facet as usize));
                    if events[place] >> 27 >= BIN || i >= n_i || cell > depth || rank >= n_ranks || facet == u32::MAX {
                        return Err(format!(
                            "a crossing of ray {i} of {n_i}, at cell {cell} of {depth}, with geometry {rank} of {n_ranks}"
                        ));
                    }
                    hits.push(((row - first_row) * n_i + i, [event, facet]));
                }
            }
        }
        let (mut offsets, mut both) = (Vec::new(), Vec::new());
        by_number(hits.iter().copied(), ((end_row - first_row) * n_i) as usize, &mut offsets, &mut both);
        let facets = if facets.is_empty() { vec![] } else { both.iter().map(|both| both[1]).collect() };
        let first_ray = u64::from(first_row) * u64::from(n_i);
        Ok(Crossings { first_ray, offsets, events: both.iter().map(|both| both[0]).collect(), facets })
    }
}

/// Compares a sample of rays with what the CPU finds.
fn checked(cast: &Cast, params: &Params, crossings: Vec<Crossings>) -> Outcome {
    let with_facets = params.with_facets == 1;
    let n_of_task = u64::from(ROWS) * u64::from(params.n_i);
    let first_ray = u64::from(params.first_row) * u64::from(params.n_i);
    let differing = |own: &Crossings| {
        let rays = 0..own.offsets.len() - 1;
        let is_other = |&ray: &usize| {
            let at = own.first_ray + ray as u64 - first_ray;
            let of_band = &crossings[(at / n_of_task) as usize];
            of_band.of_ray((at % n_of_task) as usize) != own.of_ray(ray)
        };
        [rays.len() as u64, rays.filter(is_other).count() as u64]
    };
    let counts = over_windows(cast, &sample(params), with_facets, differing);
    let [n, n_differing] = [0, 1].map(|index| counts.iter().map(|count: &[u64; 2]| count[index]).sum());
    if n_differing == 0 {
        Outcome::Done(crossings, n)
    } else {
        let what = format!("{n_differing} of {n} rays of a sample have other crossings than the CPU finds");
        Outcome::Wrong(what, [n, n_differing])
    }
}
