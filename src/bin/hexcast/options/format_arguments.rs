//! How outputs are written: their arguments, and which format or exporter a name asks for.

use std::path::Path;

use hexcast::estimate::{block_cache_bytes, slab_bytes};
use hexcast::export::{ExportOptions, Exporter, PatchNames};
use hexcast::job::{Job, Level, RunJob};
use hexcast::mesh::Mesh;
use hexcast::write::{AxisOrder, Compress, Format, Options};
use hexcast::{Error, Result};
use serde::Deserialize;

use crate::files::standard_streams::is_standard;
use crate::options::arguments::{choice, number};

/// How files are written.
#[derive(clap::Args)]
#[command(next_help_heading = "Output")]
pub(crate) struct FormatArguments {
    /// zlib level of .npz, .vti, .vtr, .nrrd, .xdmf, .in, .hxc and .zarr, 1 (fast) to 9 (small), or none [default: 6]
    #[arg(long, value_name = "LEVEL", value_parser = compression, num_args = 0..=1,
          default_missing_value = "6")]
    compress: Option<Compress>,
    /// Format of standard output (-o -), such as vti; nothing else is printed there
    #[arg(long, value_name = "FORMAT")]
    format: Option<String>,
    /// Write .raw and .npy with eight cells per byte; for meshes with a single flag
    #[arg(long)]
    pub(crate) bits: bool,
    /// Also compute the SHA-256 of all flags, one byte per cell, for the report and the sidecar of a .raw: some seconds for 10^9 cells
    #[arg(long, value_parser = choice::<Hash>(&["sha256"]))]
    pub(crate) hash: Option<Hash>,
    /// Order of the axes in .raw, .npy and .npz: zyx has x fastest, xyz has x slowest [default: zyx]
    #[arg(long, value_name = "ORDER", value_parser = choice::<AxisOrder>(&["zyx", "xyz"]))]
    axis_order: Option<AxisOrder>,
    /// Write other numbers for flags in .raw, .npy and .npz, such as 1=0,0=1; flags that are not named stay as they are
    #[arg(long, value_name = "FLAG=BYTE,...", value_parser = map)]
    map: Option<Map>,
    /// Flags whose cells are exported for a solver; 0 is allowed [default: all but 0]
    #[arg(long, value_name = "FLAG,...", value_delimiter = ',', value_parser = number::<u8>)]
    export_flags: Option<Vec<u8>>,
    /// By what the patches of OpenFOAM, surfaces of .inp and tags of faces in .msh and .xdmf are named: by the side of the box, else the neighbour's flag; by the neighbour, all sides of the box
    /// being one; or by the solid of the file, or else the geometry, whose facet made the face [default: side]
    #[arg(long, value_name = "BY", value_parser = choice::<PatchNames>(&["side", "neighbour", "solid"]))]
    pub(crate) patches: Option<PatchNames>,
    /// Solids whose patches have the type patch in OpenFOAM, such as inlet,outlet; those of other solids are walls
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', requires = "patches")]
    open_patches: Option<Vec<String>>,
    /// Cut the cells of one flag at its surface, as polyhedra with flat faces: OpenFOAM; .eb always does, and then so do both
    #[arg(long)]
    cut: bool,
    /// Export text instead of binary numbers: OpenFOAM, .msh
    #[arg(long)]
    ascii: bool,
}

/// A hash that is made only if it is asked for.
#[derive(Clone, Copy, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Hash {
    Sha256,
}

/// zlib level where the caller does not say: files a quarter as large as at 1, in twice the time, and little larger than at 9.
pub(crate) const DEFAULT_COMPRESS: Compress = Compress::Zlib(6);

impl FormatArguments {
    /// Says which flags a map makes the same as others that keep their number: it may have been meant, or one was forgotten.
    pub(crate) fn merged(&self, mesh: &Mesh) -> Option<String> {
        let Map(map) = self.map?;
        let cells = mesh.columns().cells_per_flag();
        let keeps = |byte: u8| map[usize::from(byte)] == byte && cells[usize::from(byte)] > 0;
        let pairs = (0..=u8::MAX).zip(map).filter(|(flag, byte)| flag != byte && keeps(*byte));
        let pairs = pairs.filter(|(flag, _)| cells[usize::from(*flag)] > 0);
        let said: Vec<String> = pairs.map(|(flag, byte)| format!("flag {flag} as {byte}")).collect();
        let last = "which another flag keeps: the file does not tell them apart";
        (!said.is_empty()).then(|| format!("--map writes {}, {last}", said.join(", ")))
    }

    /// The writer's options for a format: those arguments that apply to it, and its share of the memory allowed.
    pub(crate) fn options(&self, format: Format, max_bytes: u64) -> Options {
        let (compress, bits) = match format {
            Format::Raw | Format::Npy => (Compress::None, self.bits),
            _ => (self.compression(), false),
        };
        let mut options = self.zarr_options(max_bytes).with_compress(compress).with_bits(bits);
        if has_own_bytes(format) {
            options = options.with_axis_order(self.axis_order.unwrap_or_default());
            options.map = self.map.map(|map| map.0);
        }
        options
    }

    /// The compression of formats that have it.
    pub(crate) fn compression(&self) -> Compress {
        self.compress.unwrap_or(DEFAULT_COMPRESS)
    }

    /// The options for a Zarr folder.
    pub(crate) fn zarr_options(&self, max_bytes: u64) -> Options {
        let compress = self.compression();
        let slab_bytes = slab_bytes(max_bytes) as usize;
        let block_cache_bytes = block_cache_bytes(max_bytes) as usize;
        Options::default()
            .with_compress(compress)
            .with_sha256(self.hash.is_some())
            .with_slab_bytes(slab_bytes)
            .with_block_cache_bytes(block_cache_bytes)
    }

    /// The options for an exporter.
    pub(crate) fn export_options(&self, max_bytes: u64) -> ExportOptions {
        let options = ExportOptions::default()
            .with_ascii(self.ascii)
            .with_patches(self.patches.unwrap_or_default())
            .with_open_patches(self.open_patches.clone().unwrap_or_default())
            .with_compress(self.compression())
            .with_slab_bytes(slab_bytes(max_bytes) as usize);
        self.export_flags.iter().fold(options, |options, flags| options.with_flags(flags.clone()))
    }

    /// Asks in a job for the cells of the one flag that is exported to be cut at its surface, where that is an option, and for embedded boundaries.
    ///
    /// # Errors
    /// `job-conflict` where several flags are exported, or the job names another.
    pub(crate) fn ask(&self, has_boundary: bool, job: &mut Job) -> Result<()> {
        if !self.cut && !has_boundary && job.cut_cells.is_none() {
            return Ok(());
        }
        let asked = job.cut_cells.get_or_insert_default();
        asked.boundary |= has_boundary;
        match (self.export_flags.as_deref(), asked.fluid) {
            (None, _) => {}
            (Some(&[flag]), fluid) if fluid.is_none_or(|fluid| fluid == flag) => asked.fluid = Some(flag),
            (Some(flags), Some(fluid)) => {
                let message = format!(
                    "flags {flags:?} are to be exported, and the job has cells of flag {fluid} cut (cut_cells.fluid)"
                );
                return Err(Error::new("job-conflict", message, "name the same with --export-flags"));
            }
            (Some(flags), None) => {
                let message =
                    format!("{} flags are to be exported, and cells are cut at the surface of one", flags.len());
                return Err(Error::new("job-conflict", message, "name one flag with --export-flags"));
            }
        }
        job.validate()
    }

    /// Puts the options into a job file.
    pub(crate) fn put(&self, run: &mut RunJob) {
        run.format = self.format.clone();
        run.compress = self.compress.map(Level::from);
        run.bits = self.bits;
        run.hash = self.hash.map(|Hash::Sha256| "sha256".into());
        run.axis_order = self.axis_order.map(|order| if order == AxisOrder::Xyz { "xyz".into() } else { "zyx".into() });
        run.map = self.map.map(Map::text);
        run.export_flags = self.export_flags.clone();
        run.patches = self.patches.map(|by| {
            let word = match by {
                PatchNames::Solid => "solid",
                PatchNames::Neighbour => "neighbour",
                _ => "side",
            };
            word.into()
        });
        run.open_patches = self.open_patches.clone();
        run.ascii = self.ascii;
    }

    /// The format of the name of one file, or that given for standard output.
    pub(crate) fn format_of(&self, path: &Path) -> Result<Format> {
        let name = match self.format.as_ref().filter(|_| is_standard(path)) {
            Some(format) => format!("flags.{}", format.trim_start_matches('.')),
            None if is_standard(path) => {
                let message = "- is given as an output without a format";
                return Err(Error::new("output-name", message, "add --format, such as --format vti"));
            }
            None => path.to_string_lossy().into_owned(),
        };
        let format = Format::of_name(&name).map_err(|error| {
            let given = self.format.as_ref().filter(|_| is_standard(path));
            let problem =
                given.map_or(error.to_string(), |format| format!("--format {format}: there is no such format"));
            let formats = Format::ALL.map(|format| format!(".{}", format.extension()));
            let exporters = Exporter::ENDINGS.map(|(ending, _)| ending.to_string());
            let known = [&formats[..], &exporters].concat().join(", ");
            Error::new(error.code(), problem, format!("use {known}"))
        })?;
        if format == Format::Zarr {
            let message = format!("{} would be a folder of many files, and one file is needed", path.display());
            return Err(Error::new("job-value", message, "use .raw, .npy, .vti or .hxc"));
        }
        Ok(format)
    }

    /// Refuses the format of standard output where that is no output.
    pub(crate) fn check_standard(&self, uses_standard_output: bool) -> Result<()> {
        if self.format.is_some() && !uses_standard_output {
            let message =
                "--format is given without -o -: it is the format of standard output; files have theirs in their names";
            return Err(Error::new("job-conflict", message, "leave out --format"));
        }
        Ok(())
    }

    /// Refuses cut cells of a mesh that was not made of surfaces.
    pub(crate) fn check_whole(&self) -> Result<()> {
        if self.cut {
            let message = "cells are to be cut, and column files do not hold where surfaces cross their lines";
            return Err(Error::new("job-conflict", message, "mesh the surfaces with --cut (hexcast mesh)"));
        }
        Ok(())
    }

    /// Refuses an argument that applies to none of the formats.
    pub(crate) fn check(&self, formats: &[Format], exporters: &[Exporter], has_zarr: bool) -> Result<()> {
        let has = |one: Format, other: Format| formats.contains(&one) || formats.contains(&other);
        let compresses = |format: &Format| !matches!(format, Format::Raw | Format::Npy);
        if matches!(self.compress, Some(Compress::Zlib(_)))
            && !has_zarr
            && !formats.iter().any(compresses)
            && !exporters.iter().any(|exporter| exporter.compresses())
        {
            let message = "--compress is given, but no output can be compressed";
            let hint = format!(
                "add an output that ends in .npz, .vti, .vtr, .hxc, .zarr or {}",
                endings(Exporter::compresses)
            );
            return Err(Error::new("job-conflict", message, hint));
        }
        if self.bits && !has(Format::Raw, Format::Npy) {
            let message = "--bits is given, but no output can be bit-packed";
            return Err(Error::new("job-conflict", message, "add an output that ends in .raw or .npy"));
        }
        if (self.axis_order.is_some() || self.map.is_some()) && !formats.iter().any(|format| has_own_bytes(*format)) {
            let message = "--axis-order or --map is given, but no output can have another order or other numbers";
            return Err(Error::new("job-conflict", message, "add an output that ends in .raw, .npy or .npz"));
        }
        if self.ascii && !exporters.iter().any(|exporter| exporter.has_ascii()) {
            let message = "--ascii is given, but no output can be text or binary";
            let hint = format!("add an output that ends in {}", endings(Exporter::has_ascii));
            return Err(Error::new("job-conflict", message, hint));
        }
        if self.cut && !exporters.iter().any(|exporter| exporter.cuts()) {
            let message = "--cut is given, but no output can have cut cells";
            let hint = format!("add an output that ends in {}", endings(Exporter::cuts));
            return Err(Error::new("job-conflict", message, hint));
        }
        if self.patches.is_some() && !exporters.iter().any(|exporter| exporter.has_patches()) {
            let message = "--patches is given, but no output has named patches or surfaces";
            let hint = format!("add an output that ends in {}", endings(Exporter::has_patches));
            return Err(Error::new("job-conflict", message, hint));
        }
        if self.export_flags.is_some() && !exporters.iter().any(|exporter| exporter.has_flags()) {
            let message = "--export-flags is given, but no output can leave out flags";
            let hint = format!("add an output that ends in {}", endings(Exporter::has_flags));
            return Err(Error::new("job-conflict", message, hint));
        }
        Ok(())
    }
}

/// The endings that ask for exporters of a kind.
fn endings(is_kind: fn(Exporter) -> bool) -> String {
    let endings = Exporter::ENDINGS.into_iter().filter(|(_, exporter)| is_kind(*exporter)).map(|(ending, _)| ending);
    endings.collect::<Vec<_>>().join(", ")
}

/// The exporter that a path asks for.
pub(crate) fn exporter_of(path: &Path) -> Option<Exporter> {
    Exporter::of_name(&path.to_string_lossy())
}

/// Formats whose cells can be in another order.
fn has_own_bytes(format: Format) -> bool {
    matches!(format, Format::Raw | Format::Npy | Format::Npz)
}

/// What is written for each flag.
#[derive(Clone, Copy)]
struct Map([u8; 256]);

impl Map {
    /// The map as it is given.
    fn text(self) -> String {
        let changed = (0..=u8::MAX).zip(self.0).filter(|(flag, byte)| flag != byte);
        changed.map(|(flag, byte)| format!("{flag}={byte}")).collect::<Vec<String>>().join(",")
    }
}

fn map(text: &str) -> std::result::Result<Map, String> {
    let mut map: [u8; 256] = std::array::from_fn(|flag| flag as u8);
    let mut seen = [false; 256];
    for pair in text.split(',') {
        let numbers = pair.split_once('=').map(|(flag, byte)| (flag.trim().parse::<u8>(), byte.trim().parse::<u8>()));
        let Some((Ok(flag), Ok(byte))) = numbers else {
            return Err(format!("\"{pair}\" is not FLAG=BYTE, two numbers of 0 to 255"));
        };
        if std::mem::replace(&mut seen[usize::from(flag)], true) {
            return Err(format!("flag {flag} is given twice"));
        }
        map[usize::from(flag)] = byte;
    }
    Ok(Map(map))
}

pub(crate) fn compression(text: &str) -> std::result::Result<Compress, String> {
    match text.parse() {
        Ok(level @ 1..=9) => Ok(Compress::Zlib(level)),
        _ if text == "none" => Ok(Compress::None),
        _ => {
            Err("1 to 9 or none is needed; without a level, --compress stands before another option or at the end"
                .into())
        }
    }
}
