//! `-`: standard input in place of a file, and standard output in place of an output.

#[cfg(unix)]
use std::fs::File;
use std::fs::Metadata;
use std::io::{self, ErrorKind, IsTerminal, Read, Write};
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use hexcast::{Error, Result};

/// The name of both.
pub(crate) const NAME: &str = "-";

/// Whether a name is that of standard input or output; `./-` is a file.
pub(crate) fn is_standard(name: &Path) -> bool {
    name.as_os_str() == NAME
}

/// Standard input, unless somebody would have to type it.
///
/// # Errors
/// `io` where it is a terminal.
pub(crate) fn input() -> Result<impl Read + Send> {
    check_input()?;
    let start = std::mem::take(&mut *START.lock().unwrap_or_else(PoisonError::into_inner));
    Ok(io::Cursor::new(start).chain(io::stdin()))
}

/// What [`first_bytes`] took from standard input.
static START: Mutex<Vec<u8>> = Mutex::new(Vec::new());

/// The first bytes of standard input, up to 8, which [`input`] begins with.
///
/// # Errors
/// `io` where it is a terminal, or cannot be read.
pub(crate) fn first_bytes() -> Result<Vec<u8>> {
    check_input()?;
    let mut start = START.lock().unwrap_or_else(PoisonError::into_inner);
    let missing = 8 - start.len() as u64;
    io::stdin().take(missing).read_to_end(&mut start).map_err(|error| Error::io("reading standard input", error))?;
    Ok(start.clone())
}

fn check_input() -> Result<()> {
    if io::stdin().is_terminal() {
        let message = "- is standard input, and that is a terminal";
        return Err(Error::new("io", message, "pipe a file to it (hexcast ... - < FILE), or name the file"));
    }
    Ok(())
}

/// The file that standard input is read from; None for what is none, or where the system does not say.
pub(crate) fn input_file() -> Option<Metadata> {
    metadata_of(io::stdin())
}

/// The file that standard output goes to.
pub(crate) fn output_file() -> Option<Metadata> {
    metadata_of(io::stdout())
}

#[cfg(unix)]
fn metadata_of(stream: impl std::os::fd::AsFd) -> Option<Metadata> {
    let file = File::from(stream.as_fd().try_clone_to_owned().ok()?);
    file.metadata().ok().filter(Metadata::is_file)
}

#[cfg(not(unix))]
fn metadata_of<T>(_: T) -> Option<Metadata> {
    None
}

/// Copies what was written to standard output; a reader that has closed the pipe has enough.
///
/// # Errors
/// `io` where it cannot be written.
pub(crate) fn print_all(mut from: impl Read) -> Result<()> {
    let mut output = io::stdout().lock();
    match io::copy(&mut from, &mut output).and_then(|_| output.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(Error::io("writing to standard output", error)),
        _ => Ok(()),
    }
}

/// Refuses binary files for a terminal.
///
/// # Errors
/// `io` where standard output is one.
pub(crate) fn check_output() -> Result<()> {
    if io::stdout().is_terminal() {
        let message = "- is standard output, and that is a terminal";
        return Err(Error::new("io", message, "pipe it to a program (| ...) or a file (> FILE), or name an output"));
    }
    Ok(())
}

/// Refuses standard input for more than one input.
///
/// # Errors
/// `job-conflict`.
pub(crate) fn check_once<'a>(names: impl Iterator<Item = &'a Path>) -> Result<()> {
    match names.filter(|name| is_standard(name)).count() {
        0 | 1 => Ok(()),
        n => {
            let message = format!("- is given {n} times, and standard input can be read once");
            Err(Error::new("job-conflict", message, "name files for the others"))
        }
    }
}
