//! Progress on a terminal: one bar a phase, gone when the phase is over. Silent where standard error is not a terminal.

use std::io::IsTerminal;

use indicatif::{ProgressBar, ProgressStyle};

/// Whether and how to show progress.
#[derive(Clone, Copy)]
pub(crate) struct Progress {
    is_shown: bool,
}

impl Progress {
    /// Shows progress on a terminal, unless it should be quiet.
    pub(crate) fn new(is_quiet: bool) -> Progress {
        Progress { is_shown: !is_quiet && std::io::stderr().is_terminal() }
    }

    /// A phase that counts bytes; without a total it only spins.
    pub(crate) fn bytes(self, phase: &'static str, total: Option<u64>) -> ProgressBar {
        match total {
            Some(total) => self.bar(
                phase,
                total,
                "{msg:6} [{bar:32}] {binary_bytes} of {binary_total_bytes}, {binary_bytes_per_sec}, {eta} left",
            ),
            None => {
                let bar = self.bar(phase, 0, "{msg:6} {spinner} {binary_bytes}, {binary_bytes_per_sec}");
                bar.unset_length();
                bar
            }
        }
    }

    /// A phase that counts rays.
    pub(crate) fn rays(self, phase: &'static str) -> ProgressBar {
        self.bar(phase, 0, "{msg:6} [{bar:32}] {human_pos} of {human_len} rays, {per_sec}, {eta} left")
    }

    fn bar(self, phase: &'static str, total: u64, template: &str) -> ProgressBar {
        if !self.is_shown {
            return ProgressBar::hidden();
        }
        let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
        ProgressBar::new(total).with_style(style.progress_chars("=> ")).with_message(phase)
    }
}
