//! Output files and folders: checked before the long work starts, written to a temporary file beside the target, and put in place at
//! the end, so that no half file is ever seen under the target's name.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use hexcast::control::Control;
use hexcast::estimate::{block_cache_bytes, slab_bytes};
use hexcast::job::ZarrJob;
use hexcast::mesh::Mesh;
use hexcast::write::zarr::Place;
use hexcast::write::{Compress, Format, Options, exact_size, sidecar_json, write};
use hexcast::{Error, Result};
use indicatif::ProgressBar;
use serde::Deserialize;

use super::arguments::choice;
use super::disk::{Planned, check_room};
use super::output_file::{OutputFile, PendingFile, with_ending};
use super::progress::Progress;
use super::zarr_folder::is_zarr;
use super::zarr_output::ZarrOutput;

/// How files are written.
#[derive(clap::Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct FormatArguments {
    /// zlib level of .npz, .vti, .vtr, .hxc and .zarr, 1 (fast) to 9 (small), or none [default: 6]
    #[arg(long, value_name = "LEVEL", value_parser = compression, num_args = 0..=1, require_equals = true,
          default_missing_value = "6")]
    compress: Option<Compress>,
    /// Write .raw and .npy with eight cells a byte; for meshes with a single flag
    #[arg(long)]
    pub(crate) bits: bool,
    /// Also make the SHA-256 of all flags, one byte a cell, for the report and the sidecar of a .raw: some seconds for 10^9 cells
    #[arg(long, value_parser = choice::<Hash>(&["sha256"]))]
    pub(crate) hash: Option<Hash>,
}

/// A hash that is made only if it is asked for.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Hash {
    Sha256,
}

/// zlib level where the caller does not say: files a quarter as large as at 1, in twice the time, and little larger than at 9.
const DEFAULT_COMPRESS: Compress = Compress::Zlib(6);

impl FormatArguments {
    /// The writer's options for a format: those arguments that apply to it, and its share of the memory allowed.
    fn options(&self, format: Format, max_bytes: u64) -> Options {
        let (compress, bits) = match format {
            Format::Raw | Format::Npy => (Compress::None, self.bits),
            _ => (self.compression(), false),
        };
        self.zarr_options(max_bytes).with_compress(compress).with_bits(bits)
    }

    /// The compression of formats that have it.
    pub(crate) fn compression(&self) -> Compress {
        self.compress.unwrap_or(DEFAULT_COMPRESS)
    }

    /// The options for a Zarr folder.
    fn zarr_options(&self, max_bytes: u64) -> Options {
        let compress = self.compression();
        let slab_bytes = slab_bytes(max_bytes) as usize;
        let block_cache_bytes = block_cache_bytes(max_bytes) as usize;
        Options::default()
            .with_compress(compress)
            .with_sha256(self.hash.is_some())
            .with_slab_bytes(slab_bytes)
            .with_block_cache_bytes(block_cache_bytes)
    }

    /// Refuses an argument that applies to none of the formats.
    fn check(&self, formats: &[Format], has_zarr: bool) -> Result<()> {
        let has = |one: Format, other: Format| formats.contains(&one) || formats.contains(&other);
        let compresses = |format: &Format| !matches!(format, Format::Raw | Format::Npy);
        if matches!(self.compress, Some(Compress::Zlib(_))) && !has_zarr && !formats.iter().any(compresses) {
            let message = "--compress is given, but no output can be compressed";
            return Err(Error::new(
                "job-conflict",
                message,
                "add an output that ends in .npz, .vti, .vtr, .hxc or .zarr",
            ));
        }
        if self.bits && !has(Format::Raw, Format::Npy) {
            let message = "--bits is given, but no output can be bit-packed";
            return Err(Error::new("job-conflict", message, "add an output that ends in .raw or .npy"));
        }
        Ok(())
    }
}

/// The format of the name of one file.
fn format_of(path: &Path) -> Result<Format> {
    let format = Format::of_name(&path.to_string_lossy())?;
    if format == Format::Zarr {
        let message = format!("{} is a folder of many files, and a mask of doubtful cells is one", path.display());
        return Err(Error::new("job-value", message, "use .raw, .npy, .vti or .hxc"));
    }
    Ok(format)
}

fn compression(text: &str) -> std::result::Result<Compress, String> {
    match text.parse() {
        Ok(level @ 1..=9) => Ok(Compress::Zlib(level)),
        _ if text == "none" => Ok(Compress::None),
        _ => Err("1 to 9 or none is needed".into()),
    }
}

/// Where outputs go.
pub(crate) struct Targets<'a> {
    pub(crate) meshes: &'a [PathBuf],
    /// Of the mask of doubtful cells.
    pub(crate) doubt: Option<&'a Path>,
    pub(crate) report: Option<&'a Path>,
    /// Shapes of the shards of Zarr stores.
    pub(crate) zarr: ZarrJob,
    /// Whether only a part of a mesh is written, to a store that has others, too.
    pub(crate) is_part: bool,
    /// Whether what is measured is written beside it to a file that can be compressed.
    pub(crate) has_archive: bool,
}

impl Targets<'_> {
    /// Whether a name asks for a Zarr store.
    pub(crate) fn has_zarr(meshes: &[PathBuf]) -> bool {
        meshes.iter().any(|path| is_zarr(path))
    }
}

/// Files being written; none is left where this is dropped before [`Outputs::finish`].
pub(crate) struct Outputs {
    meshes: Vec<MeshFile>,
    stores: Vec<(ZarrOutput, Options)>,
    report: Option<PendingFile>,
    written: Vec<OutputFile>,
    /// Bytes of flags to expand at a time.
    pub(crate) slab_bytes: usize,
    /// SHA-256 of the flags, if a file that holds nothing else was written.
    pub(crate) flags_sha256: Option<String>,
}

struct MeshFile {
    format: Format,
    options: Options,
    file: PendingFile,
    /// Beside `.raw`.
    sidecar: Option<PendingFile>,
    /// Whether it holds the mask of doubtful cells in place of the flags.
    is_doubt: bool,
}

impl Outputs {
    /// Checks names and folders and opens a temporary file for each output and the report; `inputs` must not be among them.
    pub(crate) fn open(
        targets: &Targets,
        arguments: &FormatArguments,
        inputs: &[&Path],
        max_bytes: u64,
    ) -> Result<Outputs> {
        let (folder_paths, paths): (Vec<&PathBuf>, Vec<&PathBuf>) =
            targets.meshes.iter().partition(|path| is_zarr(path));
        let mut formats = paths.iter().map(|path| format_of(path)).collect::<Result<Vec<Format>>>()?;
        formats.extend(targets.doubt.map(format_of).transpose()?);
        arguments.check(&formats, !folder_paths.is_empty() || targets.has_archive)?;
        let mut taken: Vec<PathBuf> = inputs.iter().filter_map(|input| input.canonicalize().ok()).collect();
        let n_inputs = taken.len();
        let mut take = |path: &Path, place: PathBuf| match taken.iter().position(|other| *other == place) {
            Some(index) if index < n_inputs => Err(twice(path, "is an input too")),
            Some(_) => Err(twice(path, "is written twice")),
            None => {
                taken.push(place);
                Ok(())
            }
        };
        let mut stores = Vec::new();
        for path in folder_paths {
            let (place, store) = ZarrOutput::open(path, targets.is_part)?;
            take(path, place)?;
            stores.push((store, arguments.zarr_options(max_bytes).with_zarr(targets.zarr)));
        }
        let mut open = |path: &Path| -> Result<PendingFile> {
            let (place, file) = PendingFile::open(path)?;
            take(path, place)?;
            Ok(file)
        };
        let mut meshes = Vec::new();
        let n_flags = paths.len();
        let paths = paths.into_iter().map(PathBuf::as_path).chain(targets.doubt);
        for (index, (path, format)) in paths.zip(formats).enumerate() {
            let file = open(path)?;
            let sidecar = if format == Format::Raw { Some(open(&with_ending(path, ".json"))?) } else { None };
            let options = arguments.options(format, max_bytes);
            meshes.push(MeshFile { format, options, file, sidecar, is_doubt: index == n_flags });
        }
        let report = targets.report.map(open).transpose()?;
        let slab_bytes = slab_bytes(max_bytes) as usize;
        Ok(Outputs { meshes, stores, report, written: Vec::new(), slab_bytes, flags_sha256: None })
    }

    /// Whether a `.raw` of one byte a cell will be written, whose hash is that of the flags.
    pub(crate) fn will_hash(&self) -> bool {
        self.meshes.iter().any(|mesh| mesh.format == Format::Raw && !mesh.options.bits && !mesh.is_doubt)
    }

    /// Formats of the files of the mesh.
    pub(crate) fn flags_files(&self) -> impl Iterator<Item = Format> {
        self.meshes.iter().filter(|mesh| !mesh.is_doubt).map(|mesh| mesh.format)
    }

    /// Number of meshes to write.
    pub(crate) fn n_meshes(&self) -> usize {
        self.meshes.len() + self.stores.len()
    }

    /// Writes the mesh, and the mask of its doubtful cells, to all their files, if the disks have room for those whose size is known.
    pub(crate) fn write(
        &mut self,
        mesh: &Mesh,
        place: &Place,
        doubt: Option<&Mesh>,
        control: &Control,
        progress: Progress,
    ) -> Result<()> {
        let of = |is_doubt: bool| doubt.filter(|_| is_doubt).unwrap_or(mesh);
        let planned = self.meshes.iter().filter_map(|output| {
            let mesh = of(output.is_doubt);
            let n_bytes = exact_size(mesh, output.format, &output.options)?;
            Some(Planned { path: output.file.path.clone(), folder: output.file.folder().into(), n_bytes })
        });
        check_room(&planned.collect::<Vec<_>>())?;
        for output in &mut self.meshes {
            let mesh = of(output.is_doubt);
            let bar = progress.bytes("write", exact_size(mesh, output.format, &output.options));
            let path = output.file.path.display().to_string();
            let mut writer = Counted { file: BufWriter::with_capacity(1 << 20, output.file.temporary.as_file()), bar };
            let written = write(mesh, output.format, &output.options, &mut writer, control);
            writer.bar.finish_and_clear();
            drop(writer);
            let written = written.map_err(|error| error.at(&path))?;
            let path = output.file.path.clone();
            self.written.push(OutputFile { path, n_bytes: written.n_bytes });
            if let Some(sidecar) = &mut output.sidecar {
                let text = sidecar_json(mesh, &output.options, &written);
                sidecar.put(&text)?;
                self.written.push(OutputFile { path: sidecar.path.clone(), n_bytes: text.len() as u64 });
            }
            self.flags_sha256 =
                self.flags_sha256.take().or(written.sha256.filter(|_| !output.options.bits && !output.is_doubt));
        }
        for (store, options) in &mut self.stores {
            self.written.push(store.write(mesh, place, options, control, progress)?);
        }
        Ok(())
    }

    /// Writes the report, if one was asked for, and puts all files in their places.
    pub(crate) fn finish(mut self, report: &str) -> Result<Vec<OutputFile>> {
        if let Some(file) = &mut self.report {
            file.put(report)?;
            self.written.push(OutputFile { path: file.path.clone(), n_bytes: report.len() as u64 });
        }
        let meshes = self.meshes.into_iter().flat_map(|mesh| [Some(mesh.file), mesh.sidecar]);
        for file in meshes.chain([self.report]).flatten() {
            file.persist()?;
        }
        self.stores.into_iter().try_for_each(|(store, _)| store.finish())?;
        Ok(self.written)
    }
}

fn twice(path: &Path, what: &str) -> Error {
    Error::new("job-conflict", format!("{} {what}", path.display()), "give the output another name")
}

/// A writer that moves a progress bar.
struct Counted<'a> {
    file: BufWriter<&'a File>,
    bar: ProgressBar,
}

impl Write for Counted<'_> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let n = self.file.write(bytes)?;
        self.bar.inc(n as u64);
        Ok(n)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.file.flush()
    }
}
