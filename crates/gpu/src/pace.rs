//! The pace of a mesh: how many ray rows its bands get.

// the clock, which wasm's std does not have
#[cfg(not(target_arch = "wasm32"))]
pub(super) use std::time::Instant;
#[cfg(target_arch = "wasm32")]
pub(super) use web_time::Instant;

use hexcast_core::stages::cast::sizes::{BIN, FIRST_BAND, MOST_BAND, whole_bins};

/// How many ray rows a band gets, by the time that those before took.
pub(super) struct Pace {
    pub(super) rows: u32,
    most_rows: u32,
    is_fixed: bool,
    band_seconds: f64,
    last: Instant,
}

impl Pace {
    /// Takes rows that do not change, if given, and the most rows of a band.
    pub(super) fn new(fixed: Option<u32>, most_rows: Option<u32>, n_i: u32, band_seconds: f64) -> Pace {
        let n_i = u64::from(n_i);
        let all = u32::try_from(MOST_BAND / n_i).unwrap_or(u32::MAX);
        let most_rows = all.min(most_rows.unwrap_or(u32::MAX)).max(1);
        let rows = fixed.unwrap_or(rows_of(FIRST_BAND / n_i).min(most_rows));
        Pace { rows, most_rows, is_fixed: fixed.is_some(), band_seconds, last: Instant::now() }
    }

    /// Allows at most so many rows from now on.
    pub(super) fn limit(&mut self, rows: u32) {
        self.most_rows = if rows > BIN { rows_of(rows.into()) } else { rows };
        self.rows = self.rows.min(self.most_rows);
    }

    /// Notes that a band of so many rows is done, for which the host took some seconds: smaller bands would not take fewer of these, as
    /// it goes through all facets for each.
    pub(super) fn finished(&mut self, rows: u32, host_seconds: f64) {
        if !self.is_fixed && rows == self.rows {
            let seconds = self.last.elapsed().as_secs_f64() - host_seconds;
            let speed_up = (self.band_seconds / seconds.max(1e-4)).clamp(0.5, 2.0);
            self.rows = rows_of((f64::from(rows) * speed_up) as u64).min(self.most_rows);
        }
        self.last = Instant::now();
    }
}

/// Whole bins of so many ray rows or fewer.
fn rows_of(rows: u64) -> u32 {
    whole_bins(rows.min(1 << 30)) as u32
}
