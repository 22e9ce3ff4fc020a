//! A writer that shows the bytes written as progress.

use std::io::Write;

use indicatif::ProgressBar;

/// A writer that moves a progress bar.
pub(super) struct Counted<W> {
    pub(super) file: W,
    pub(super) bar: ProgressBar,
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
