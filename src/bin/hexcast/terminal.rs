//! Standard output.

use std::io::Write;

use hexcast::{Error, Result};

/// Prints to standard output; a reader that has closed the pipe, as in `| head`, is not a failure.
pub(crate) fn print(text: &str) -> Result<()> {
    match std::io::stdout().write_all(text.as_bytes()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => Err(Error::io("printing", error)),
        _ => Ok(()),
    }
}
