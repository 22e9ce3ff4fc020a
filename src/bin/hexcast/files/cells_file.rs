//! A file of cells as output: their flags, or the mask of the doubtful ones, in one of the formats of `hexcast::write`.

use std::path::Path;

use hexcast::Result;
use hexcast::mesh::Mesh;
use hexcast::shards::Shards;
use hexcast::write::{Format, Options, check, check_lines, exact_size, least_size, sidecar_json, write};

use crate::files::{
    disk::Planned,
    output::{Asked, Meshed, Output, Written},
    output_file::{PendingFile, with_ending},
};
use crate::screen::progress::Counted;

/// A file being written.
pub(crate) struct CellsFile {
    format: Format,
    options: Options,
    file: PendingFile,
    /// Beside `.raw`.
    sidecar: Option<PendingFile>,
    /// Whether it holds the mask of doubtful cells in place of the flags.
    is_doubt: bool,
}

impl CellsFile {
    /// Opens a temporary file for it.
    pub(crate) fn open(path: &Path, format: Format, options: Options, is_doubt: bool) -> Result<CellsFile> {
        check(format, &options).map_err(|error| error.at(path.display()))?;
        let file = PendingFile::open(path)?;
        let has_sidecar = format == Format::Raw && !file.is_standard();
        let sidecar = has_sidecar.then(|| PendingFile::open(&with_ending(path, ".json"))).transpose()?;
        Ok(CellsFile { format, options, file, sidecar, is_doubt })
    }

    /// Whether its bytes are the flags of the mesh, in their order, and nothing else.
    pub(crate) fn has_flags_alone(&self) -> bool {
        self.format == Format::Raw && !self.options.bits && !self.options.has_own_bytes() && !self.is_doubt
    }

    fn mesh<'a>(&self, meshed: &Meshed<'a>) -> &'a Mesh {
        let doubt = meshed.facts.and_then(|facts| facts.doubt.as_ref());
        doubt.filter(|_| self.is_doubt).unwrap_or(meshed.mesh)
    }

    fn of_bytes(&self, n_bytes: u64) -> Planned {
        Planned { path: self.file.path.clone(), folder: self.file.folder().into(), n_bytes }
    }
}

/// Refuses lines and shards that a format of cells cannot have.
pub(crate) fn check_cells(file: &PendingFile, asked: &Asked, (format, options): (Format, &Options)) -> Result<()> {
    check_lines(&asked.lines, format).map_err(|error| error.at(file.path.display()))?;
    if format == Format::ZarrZip { Shards::new(asked.lines.dims(), &options.zarr).map(|_| ()) } else { Ok(()) }
}

impl Output for CellsFile {
    fn check(&self, asked: &Asked) -> Result<Option<Planned>> {
        check_cells(&self.file, asked, (self.format, &self.options))?;
        Ok(least_size(&asked.lines, self.format, &self.options).map(|n_bytes| self.of_bytes(n_bytes)))
    }

    fn plan(&self, meshed: &Meshed) -> Result<Option<Planned>> {
        let n_bytes = exact_size(self.mesh(meshed), self.format, &self.options);
        Ok(n_bytes.map(|n_bytes| self.of_bytes(n_bytes)))
    }

    fn write(&mut self, meshed: &Meshed, written: &mut Written) -> Result<()> {
        let mesh = self.mesh(meshed);
        let bar = meshed.progress.bytes("write", exact_size(mesh, self.format, &self.options));
        let done = self.file.fill(|file| {
            let mut out = Counted { file, bar: bar.clone() };
            write(mesh, self.format, &self.options, &mut out, meshed.control)
        });
        bar.finish_and_clear();
        let done = done?;
        written.files.push(self.file.of_bytes(done.n_bytes));
        if let Some(sidecar) = &mut self.sidecar {
            let text = sidecar_json(mesh, &self.options, &done);
            sidecar.put(&text)?;
            written.files.push(sidecar.of_bytes(text.len() as u64));
        }
        let sha256 = done.sha256.filter(|_| self.has_flags_alone());
        written.flags_sha256 = written.flags_sha256.take().or(sha256);
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<()> {
        [Some(self.file), self.sidecar].into_iter().flatten().try_for_each(PendingFile::persist)
    }
}
