//! Writing files so that none is ever half there: to a temporary file beside the target, renamed at the end.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use hexcast::control::Control;
use hexcast::error::{Error, Result};
use hexcast::mesh::Mesh;
use hexcast::write::{self, Compress, Format, Options, Written};
use tempfile::NamedTempFile;

use crate::args::WriteArgs;

/// A file to be written, checked before the work starts.
pub(crate) struct Output {
    pub(crate) path: PathBuf,
    pub(crate) format: Format,
    options: Options,
}

impl Output {
    /// Checks the format of a file's name, the options, and that its folder takes files.
    pub(crate) fn new(path: &Path, arguments: &WriteArgs, inputs: &[&Path]) -> Result<Output> {
        let format = Format::of_name(&path.to_string_lossy())?;
        let level = match (arguments.compress, format) {
            (Some(level), Format::Vti | Format::Columns) => level,
            (None, Format::Vti) => 1,
            // one --compress for several outputs: it is for those that can
            _ => 0,
        };
        let compress = if level == 0 { Compress::None } else { Compress::Zlib(level) };
        let bits = arguments.bits && matches!(format, Format::Raw | Format::Npy);
        for input in inputs {
            if let (Ok(input), Ok(output)) = (input.canonicalize(), path.canonicalize())
                && input == output
            {
                let message = format!("{} is an input and an output", path.display());
                return Err(Error::new("job-conflict", message, "write to another file"));
            }
        }
        drop(temporary(path)?);
        Ok(Output { path: path.to_path_buf(), format, options: Options { compress, bits, ..Options::default() } })
    }

    /// Writes the mesh, and the description of a raw file beside it.
    pub(crate) fn write(&self, mesh: &Mesh, control: &Control) -> Result<Written> {
        let mut file = temporary(&self.path)?;
        let mut buffered = BufWriter::with_capacity(1 << 20, file.as_file_mut());
        let written = write::write(mesh, self.format, &self.options, &mut buffered, control)?;
        buffered.flush().map_err(|error| failed(&self.path, error))?;
        drop(buffered);
        if self.format == Format::Raw {
            let sidecar = write::sidecar::sidecar_json(mesh, &self.options, &written);
            write_text(&sidecar_path(&self.path), &sidecar)?;
        }
        keep(file, &self.path)?;
        Ok(written)
    }

    /// Whether its bytes are one flag a cell, so that their hash is that of the flags.
    pub(crate) fn is_plain_raw(&self) -> bool {
        self.format == Format::Raw && !self.options.bits
    }
}

/// `mesh.raw` -> `mesh.raw.json`.
pub(crate) fn sidecar_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".json");
    name.into()
}

/// Writes a small text file.
pub(crate) fn write_text(path: &Path, text: &str) -> Result<()> {
    let mut file = temporary(path)?;
    file.write_all(text.as_bytes()).and_then(|()| file.write_all(b"\n")).map_err(|error| failed(path, error))?;
    keep(file, path)
}

fn temporary(path: &Path) -> Result<NamedTempFile> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut builder = tempfile::Builder::new();
    builder.prefix(".hexcast-");
    #[cfg(unix)]
    {
        // the permissions of any other new file, not those of a secret
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder).map_err(|error| failed(path, error))
}

fn keep(file: NamedTempFile, path: &Path) -> Result<()> {
    file.persist(path).map(drop).map_err(|error| failed(path, error.error))
}

fn failed(path: &Path, error: std::io::Error) -> Error {
    Error::io(format!("writing {}", path.display()), error)
}
