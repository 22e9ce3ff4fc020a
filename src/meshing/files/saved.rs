//! Files of a mesh: their options, and how they get their names when all is written.
//!
//! Mesh, path, options -> files on disk, with the bytes of the library's writers and exporters, as of the command.

use std::collections::BTreeMap;
use std::fs::{File, Metadata, rename};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::input::job::ZarrJob;
use hexcast_derived::mesh::Mesh;
use hexcast_files::export::{ExportOptions, Exporter, Files, PatchNames, export};
use hexcast_files::write::{AxisOrder, Compress, Format, Options, sidecar_json, write, zarr};
use serde::Deserialize;
use tempfile::TempDir;

use super::WrittenFolder;
use super::place::{ExportPlace, check_kind, folder_of, id_of, refused, target_of};

/// zlib level where the caller does not say, as in the command.
const DEFAULT_LEVEL: u8 = 6;

/// How a file is written: the options of the command.
#[derive(Debug, Deserialize, Default)]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct FileOptions {
    /// A zlib level, 0 for none to 9; by default 6 where a format has compression.
    pub compress: Option<u8>,
    /// Eight cells a byte.
    pub bits: bool,
    /// The order of the axes in `.raw`, `.npy` and `.npz`.
    pub axis_order: Option<AxisOrder>,
    /// Numbers that these have in place of flags.
    pub map: BTreeMap<u8, u8>,
    /// Flags whose cells are exported; by default all but 0.
    pub export_flags: Option<Vec<u8>>,
    /// Text in place of numbers in binary.
    pub ascii: bool,
    /// By what patches and surfaces are named.
    pub patches: Option<PatchNames>,
    /// Solids whose patches a fluid flows through.
    pub open_patches: Vec<String>,
}

/// What writes a file.
#[derive(Clone, Copy)]
enum Writer {
    Format(Format),
    Exporter(Exporter),
}

impl Writer {
    fn of_path(path: &str) -> Result<Writer> {
        if let Some(exporter) = Exporter::of_name(path) {
            return Ok(Writer::Exporter(exporter));
        }
        Format::of_name(path).map(Writer::Format).map_err(|error| {
            let endings = Exporter::ENDINGS.map(|(ending, _)| ending).join(", ");
            let message = error.to_string();
            Error::new(error.code(), message, format!("{}, {endings}", error.hint()))
        })
    }

    fn compresses(self) -> bool {
        match self {
            Writer::Format(format) => !matches!(format, Format::Raw | Format::Npy),
            Writer::Exporter(exporter) => exporter.compresses(),
        }
    }
}

impl FileOptions {
    /// Reads them from JSON.
    ///
    /// # Errors
    /// `job-value` for another key, or a value of another type.
    pub fn of_json(json: &str) -> Result<FileOptions> {
        serde_json::from_str(json).map_err(|error| {
            let hint = "give compress, bits, axis_order, map, export_flags, ascii, patches or open_patches";
            Error::new("job-value", format!("the options of the file: {error}"), hint)
        })
    }

    /// Refuses options that the file would silently ignore.
    fn check(&self, writer: Writer, path: &str) -> Result<()> {
        let format = if let Writer::Format(format) = writer { Some(format) } else { None };
        let exporter = if let Writer::Exporter(exporter) = writer { Some(exporter) } else { None };
        let has_own_bytes = matches!(format, Some(Format::Raw | Format::Npy | Format::Npz));
        let has_patches = exporter.is_some_and(Exporter::has_patches);
        let options = [
            ("compress", self.compress.is_some_and(|level| level > 0), writer.compresses()),
            ("bits", self.bits, matches!(format, Some(Format::Raw | Format::Npy))),
            ("axis_order", self.axis_order.is_some(), has_own_bytes),
            ("map", !self.map.is_empty(), has_own_bytes),
            ("export_flags", self.export_flags.is_some(), exporter.is_some_and(Exporter::has_flags)),
            ("ascii", self.ascii, exporter.is_some_and(Exporter::has_ascii)),
            ("patches", self.patches.is_some(), has_patches),
            ("open_patches", !self.open_patches.is_empty(), has_patches && self.patches.is_some()),
        ];
        let Some((name, ..)) = options.iter().find(|(_, is_given, applies)| *is_given && !applies) else {
            return Ok(());
        };
        let message = format!("{path}: the option \"{name}\" does not apply to files of this ending");
        let message = if *name == "open_patches" { format!("{message}, or \"patches\" is missing") } else { message };
        Err(Error::new("job-conflict", message, "leave it out, or write another format"))
    }

    fn compression(&self, writer: Writer) -> Compress {
        match self.compress.unwrap_or(DEFAULT_LEVEL) {
            level if level > 0 && writer.compresses() => Compress::Zlib(level),
            _ => Compress::None,
        }
    }

    fn options(&self, writer: Writer, zarr: ZarrJob) -> Options {
        let options = Options::default().with_compress(self.compression(writer)).with_bits(self.bits).with_zarr(zarr);
        let options = self.axis_order.into_iter().fold(options, Options::with_axis_order);
        if self.map.is_empty() {
            return options;
        }
        options.with_map(std::array::from_fn(|flag| self.map.get(&(flag as u8)).copied().unwrap_or(flag as u8)))
    }

    fn export_options(&self, writer: Writer) -> ExportOptions {
        let options = ExportOptions::default().with_ascii(self.ascii).with_compress(self.compression(writer));
        let options =
            options.with_patches(self.patches.unwrap_or_default()).with_open_patches(self.open_patches.clone());
        self.export_flags.iter().cloned().fold(options, ExportOptions::with_flags)
    }
}

/// Writes a mesh to a file, or to the files or the folder of a solver or of Zarr, in the format that the end of `path` names. What has the name is replaced when all is written, not
/// before; where it fails, nothing is left. `inputs` are the files that the mesh was made of, which are not written over. Returns what the files lack of the mesh, a sentence each.
///
/// # Errors
/// `output-name` for an unknown ending; `job-conflict` where an option does not apply to the format, and where an input would be written over; those of
/// [`write()`] and [`export()`]; `io`; `cancelled`.
pub fn save(
    mesh: &Mesh,
    path: &Path,
    options: &FileOptions,
    (zarr, inputs): (ZarrJob, &[PathBuf]),
    control: &Control,
) -> Result<Vec<String>> {
    let name = path.to_string_lossy();
    let writer = Writer::of_path(&name)?;
    options.check(writer, &name)?;
    if options.patches == Some(PatchNames::Solid) && mesh.walls().is_none() {
        let message = format!("{name}: patches are to have the names of solids, which this mesh does not know");
        return Err(Error::new("job-conflict", message, "mesh with the option \"walls\": true"));
    }
    let saved = Saved { mesh, inputs, path, control };
    match writer {
        Writer::Format(Format::Zarr) => saved.zarr(&options.options(writer, zarr)).map(|()| Vec::new()),
        Writer::Format(format) => saved.file(format, &options.options(writer, zarr)).map(|()| Vec::new()),
        Writer::Exporter(exporter) => saved.exported(exporter, &options.export_options(writer)),
    }
}

/// What is written, and where.
struct Saved<'a> {
    mesh: &'a Mesh,
    /// Files that the mesh was made of.
    inputs: &'a [PathBuf],
    path: &'a Path,
    control: &'a Control,
}

impl Saved<'_> {
    /// Writes one file, and the description of a `.raw` beside it.
    fn file(&self, format: Format, options: &Options) -> Result<()> {
        let target = target_of(self.path)?;
        let mut described = target.clone().into_os_string();
        described.push(".json");
        let described = PathBuf::from(described);
        let has_description = format == Format::Raw;
        for place in [Some(&target), has_description.then_some(&described)].into_iter().flatten() {
            self.check_file(place)?;
        }
        let folder = Temporary::beside(self.path, folder_of(&target))?;
        let mut out = BufWriter::with_capacity(1 << 20, folder.create("new").map_err(|error| self.failed(error))?);
        let written = write(self.mesh, format, options, &mut out, self.control);
        let written = written.map_err(|error| error.at(self.path.display()))?;
        drop(out);
        if has_description {
            let mut out = folder.create("new.json").map_err(|error| self.failed(error))?;
            let text = sidecar_json(self.mesh, options, &written);
            out.write_all(text.as_bytes()).map_err(|error| self.failed(error))?;
            rename(folder.path("new.json"), described).map_err(|error| self.failed(error))?;
        }
        rename(folder.path("new"), target).map_err(|error| self.failed(error))
    }

    /// Writes the files of an exporter, and returns what they lack.
    fn exported(&self, exporter: Exporter, options: &ExportOptions) -> Result<Vec<String>> {
        let place = ExportPlace::of(self.path, exporter)?;
        let targets: Vec<PathBuf> = place.files.iter().map(|name| place.folder.join(name)).collect();
        targets.iter().try_for_each(|target| self.check_file(target))?;
        let mut folder = Temporary::beside(self.path, &place.folder)?;
        let done = export(self.mesh, exporter, &place.name, options, &mut folder, self.control);
        let lacks = done.map_err(|error| error.at(self.path.display()))?;
        let put = |(name, target): (&String, &PathBuf)| {
            std::fs::create_dir_all(folder_of(target))?;
            rename(folder.path(name), target)
        };
        place.files.iter().zip(&targets).try_for_each(put).map_err(|error| self.failed(error))?;
        Ok(lacks)
    }

    /// Writes a folder of Zarr.
    fn zarr(&self, options: &Options) -> Result<()> {
        let target = target_of(self.path)?;
        if target.exists() && !target.join("zarr.json").is_file() {
            let message = format!("{} exists and is not a Zarr folder", self.path.display());
            return Err(Error::new("io", message, "name another"));
        }
        self.check_inputs(&target)?;
        let folder = Temporary::beside(self.path, folder_of(&target))?;
        let store = WrittenFolder::new(folder.path("new"));
        let done = zarr::write(self.mesh, options, &|key, value| store.put(key, value), self.control, |_| ());
        // somebody may remove files of the folder while it is filled
        done.and_then(|()| store.verify()).map_err(|error| error.at(self.path.display()))?;
        if target.exists() {
            rename(&target, folder.path("old")).map_err(|error| self.failed(error))?;
        }
        rename(folder.path("new"), target).map_err(|error| self.failed(error))
    }

    fn check_file(&self, target: &Path) -> Result<()> {
        if target.is_dir() {
            return Err(Error::new("io", format!("{} is a folder", target.display()), "name a file in it"));
        }
        check_kind(target)?;
        self.check_inputs(target)
    }

    /// Refuses to write over a surface of the mesh, by whatever name, or to replace a folder that has one.
    fn check_inputs(&self, target: &Path) -> Result<()> {
        let Ok(target) = target.canonicalize() else { return Ok(()) };
        let id = |path: &Path| path.metadata().ok().filter(Metadata::is_file).and_then(|of| id_of(&of));
        let own = id(&target);
        let is_it = |input: &&PathBuf| input.starts_with(&target) || own.is_some() && id(input) == own;
        let Some(input) = self.inputs.iter().find(is_it) else { return Ok(()) };
        let message =
            format!("{} would be written over {}, an input of the mesh", self.path.display(), input.display());
        Err(Error::new("job-conflict", message, "give the output another name"))
    }

    fn failed(&self, error: std::io::Error) -> Error {
        Error::io(format!("writing {}", self.path.display()), error)
    }
}

/// A folder beside an output, which is removed with what is left in it.
struct Temporary(TempDir);

impl Temporary {
    fn beside(path: &Path, folder: &Path) -> Result<Temporary> {
        let made = tempfile::Builder::new().prefix(".hexcast-").suffix(".part").tempdir_in(folder);
        made.map(Temporary).map_err(|error| refused(path, folder, &error))
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Makes a file, with the folders that it needs.
    fn create(&self, name: &str) -> std::io::Result<File> {
        let place = self.path(name);
        std::fs::create_dir_all(folder_of(&place))?;
        File::create(place)
    }
}

impl Files for Temporary {
    fn create(&mut self, name: &str) -> Result<Box<dyn Write + '_>> {
        let file = Temporary::create(self, name).map_err(|error| Error::io(format!("writing {name}"), error))?;
        Ok(Box::new(file))
    }

    fn place(&mut self, name: &str) -> Result<PathBuf> {
        let place = self.path(name);
        std::fs::create_dir_all(folder_of(&place)).map_err(|error| Error::io(format!("writing {name}"), error))?;
        Ok(place)
    }
}
