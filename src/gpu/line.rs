//! The line on the GPU: bands of ray rows, from facets to columns.
//!
//! A band is as many ray rows as fit the buffers and take about [`BAND_SECONDS`], on a page's GPU [`FRAME_SECONDS`]. What a
//! band needs is known only when it has run: a band that found more pairs or crossings than its buffers hold is thrown away and run again with
//! larger buffers, or, at the limit of the device, in halves. Neither changes the result.

use std::collections::VecDeque;

use web_time::Instant;

use super::device::{AdapterKind, Gpu};
use super::passes::Profile;
use super::session::{Launched, Session};
use crate::columns::{Band, Columns};
use crate::control::Control;
use crate::error::Result;
use crate::estimate::bands::{BANDS_IN_FLIGHT, FIRST_BAND, MOST_BAND, whole_bins};
use crate::frame::Frame;
use crate::map::Rule;
use crate::rays::Rays;

/// Time that a band aims at: long enough to hide its overhead, which on a software driver is some ten milliseconds; short
/// enough that no driver gives up on it, and that Cancel does not wait.
const BAND_SECONDS: f64 = 0.25;
/// The same where a browser draws its pages with the same GPU: a frame at 60 a second.
const FRAME_SECONDS: f64 = 0.016;

/// What is meshed: the input of the lattice, intersection and mapping.
#[derive(Debug, Clone, Copy)]
pub struct Cast<'a> {
    /// Snapped facets.
    pub frame: &'a Frame,
    /// The rays through the box.
    pub rays: &'a Rays,
    /// What is inside.
    pub rule: Rule,
}

/// How a mesh is run; no choice changes the result.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Options {
    /// Fixes the number of ray rows of a band; otherwise it follows from the limits and the speed of the device.
    pub rows_per_band: Option<u32>,
    /// Most ray rows of a band, if not what the device allows.
    pub most_rows: Option<u32>,
    /// Waits for every kernel and measures it.
    pub profile: bool,
}

/// What a mesh has used of the device.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Usage {
    /// Most bytes of buffers held at once.
    pub peak_bytes: u64,
    /// Bands that were finished.
    pub n_bands: u32,
    /// Seconds in each kernel, if asked for.
    pub profile: Option<Profile>,
}

impl Gpu {
    /// Meshes the box.
    ///
    /// # Errors
    /// `cancelled`; `too-many-facets`, `too-many-cells`, `too-many-crossings` at the limits of the device; `device-failed`,
    /// `device-lost`.
    pub async fn columns(&self, cast: &Cast<'_>, control: &Control) -> Result<Columns> {
        let mut bands = Vec::new();
        self.continue_columns(cast, &Options::default(), control, &mut bands).await?;
        Ok(Columns::new(*cast.rays, bands))
    }

    /// Meshes the rays after those of `bands` and appends theirs; on an error `bands` holds all that was finished.
    ///
    /// # Errors
    /// Those of [`Gpu::columns`].
    pub async fn continue_columns(
        &self,
        cast: &Cast<'_>,
        options: &Options,
        control: &Control,
        bands: &mut Vec<Band>,
    ) -> Result<Usage> {
        let n_rays: u64 = bands.iter().map(|band| band.ends.len() as u64).sum();
        let first_row = (n_rays / u64::from(cast.rays.counts[0])) as u32;
        let take = &mut |band| {
            bands.push(band);
            Ok(())
        };
        self.hand_out_bands(cast, options, control, first_row, take).await
    }

    /// Meshes the rays from a row on and hands out band after band, in order, while the device works on the next.
    ///
    /// # Errors
    /// Those of [`Gpu::columns`], and those of `take`.
    pub async fn hand_out_bands(
        &self,
        cast: &Cast<'_>,
        options: &Options,
        control: &Control,
        first_row: u32,
        take: &mut impl FnMut(Band) -> Result<()>,
    ) -> Result<Usage> {
        let [n_i, n_j] = cast.rays.counts;
        let most_rows = u32::try_from(MOST_BAND / u64::from(n_i)).unwrap_or(u32::MAX);
        let mut most_rows = most_rows.min(options.most_rows.unwrap_or(u32::MAX)).max(1);
        let mut rows = options.rows_per_band.unwrap_or(rows_of(FIRST_BAND / u64::from(n_i)).min(most_rows));
        let mut next = first_row;
        let mut idle = vec![Session::new(self, *cast, rows.min(n_j))?];
        idle[0].usage.profile = options.profile.then(Profile::new);
        let in_flight_most = if options.profile { 1 } else { BANDS_IN_FLIGHT };
        let mut in_flight: VecDeque<(Session, Launched)> = VecDeque::new();
        let mut usage = Usage::default();
        let mut lap = Instant::now();
        loop {
            control.check()?;
            while next < n_j && in_flight.len() < in_flight_most {
                let range = next..next.saturating_add(rows).min(n_j);
                let Some(mut session) = idle.pop().or_else(|| in_flight.front().map(|(first, _)| first.sibling()))
                else {
                    break;
                };
                let launched = session.launch(range.clone())?;
                in_flight.push_back((session, launched));
                next = range.end;
            }
            usage.peak_bytes =
                usage.peak_bytes.max(in_flight.iter().map(|(session, _)| session.usage.peak_bytes).sum());
            let Some((mut session, launched)) = in_flight.pop_front() else { break };
            let range = launched.rows.clone();
            match session.complete(launched).await {
                Err(error) => return Err(self.cause(error, control).await),
                Ok(Some(band)) => take(band)?,
                Ok(None) => {
                    // the bands behind it stand on their own, but columns are appended in order: start again from here
                    in_flight.clear();
                    idle.clear();
                    rows = session.make_room(&range)?;
                    if rows < range.end - range.start {
                        // at the limit of the device: no later band is to try again
                        most_rows = rows;
                    }
                    next = range.start;
                    idle.push(session);
                    continue;
                }
            }
            control.pause().await;
            control.advance(u64::from(range.end) * u64::from(n_i), cast.rays.n_rays());
            if options.rows_per_band.is_none() && range.end - range.start == rows {
                let speed_up = (self.band_seconds() / lap.elapsed().as_secs_f64().max(1e-4)).clamp(0.5, 2.0);
                rows = rows_of((f64::from(rows) * speed_up) as u64).min(most_rows);
            }
            lap = Instant::now();
            usage.n_bands += 1;
            usage.profile = session.usage.profile.clone();
            idle.push(session);
        }
        idle.into_iter().for_each(Session::end);
        Ok(usage)
    }

    fn band_seconds(&self) -> f64 {
        let draws_pages = cfg!(target_arch = "wasm32") && self.facts.kind != AdapterKind::Software;
        if draws_pages { FRAME_SECONDS } else { BAND_SECONDS }
    }
}

/// Whole bins of so many ray rows or fewer.
fn rows_of(rows: u64) -> u32 {
    whole_bins(rows.min(1 << 30)) as u32
}
