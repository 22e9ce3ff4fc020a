//! Progress on a terminal: one bar a phase, gone when the phase is over. Silent where standard error is not a terminal.

use std::io::IsTerminal;

use hexcast::control::HoleWork;
use std::io::Write;

use indicatif::{ProgressBar, ProgressStyle};

use crate::screen::terminal;

/// Seconds of a core to put a triangle of a hole into a cluster, and to look at a cell among many of them: measured, with room for slow machines.
const OF_TRIANGLE: f64 = 1e-5;
const OF_CELL: f64 = 1.5e-4;
/// Less is not worth a word.
const LEAST_SECONDS: f64 = 5.0;

/// Whether and how to show progress.
#[derive(Clone, Copy)]
pub(crate) struct Progress {
    is_quiet: bool,
    is_shown: bool,
}

impl Progress {
    /// Shows progress on a terminal, unless it should be quiet.
    pub(crate) fn new(is_quiet: bool) -> Progress {
        Progress { is_quiet, is_shown: !is_quiet && std::io::stderr().is_terminal() }
    }

    /// Says how long it may take to decide the cells of an open surface, where that is long.
    pub(crate) fn about_holes(self, work: HoleWork) {
        if let Some(sentence) = sentence_of_holes(work, rayon::current_num_threads()).filter(|_| !self.is_quiet) {
            terminal::complain(&sentence);
        }
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

fn sentence_of_holes(HoleWork { triangles, cells, .. }: HoleWork, n_threads: usize) -> Option<String> {
    // where triangles are few each cell needs few of them
    let of_cell = OF_CELL.min(1e-7 * triangles as f64);
    let seconds = (OF_TRIANGLE * triangles as f64 + of_cell * cells as f64) / n_threads as f64;
    (seconds >= LEAST_SECONDS).then(|| {
        format!(
            "note: {triangles} triangles close the holes of an open surface; to decide up to {cells} cells among them may take {seconds:.0} s"
        )
    })
}

/// A writer that moves a progress bar.
pub(crate) struct Counted<W> {
    pub(crate) file: W,
    pub(crate) bar: ProgressBar,
}

impl<W: Write> Write for Counted<W> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let n = self.file.write(bytes)?;
        self.bar.inc(n as u64);
        Ok(n)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_holes_are_worth_a_word() {
        assert_eq!(sentence_of_holes(HoleWork::new(10, 1 << 18), 2), None);
        let text = sentence_of_holes(HoleWork::new(700_000, 1 << 18), 2).expect("it is long");
        assert!(text.contains("700000 triangles") && text.contains("may take 23 s"), "{text}");
    }
}
