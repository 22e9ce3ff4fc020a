//! Arguments that decide a mesh, and the job that they make, alone or together with a job file.

use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};
pub(crate) use hexcast::job::arguments::{at_least_one, list, number, per_axis};
use hexcast::job::{BackendChoice, ByteSize, GeometryJob, GradedJob, Job, Levels, Padding, PerAxis, RunJob, ZarrJob};
use hexcast::{Error, Result};
use serde::de::DeserializeOwned;

use crate::files::{ledger, standard_streams};
use crate::options::{
    given::Given,
    job_files::{read_job, read_lines},
    spelling::input_name,
};

/// What to mesh and how finely.
#[derive(clap::Args)]
pub(crate) struct JobArguments {
    /// STL, OBJ, OFF, PLY, 3MF or GLB files, also packed by gzip, STEP or IGES files, or - for standard input. They get the flags 1, 2, ... in order, unless set as in
    /// coil.stl:flag=7,priority=2,name=copper (keys: flag, priority, open, fill, shell, invert, max_size, min_cells, metal, name, solid, split,
    /// same_flag, scale, rotate, about, translate, and eps_r, mu_r, sigma, pec, density, E, nu of the material)
    #[arg(value_name = "FILE", required_unless_present = "job", conflicts_with = "job", value_parser = input_name())]
    files: Vec<String>,
    /// Take all options from a job file, TOML or JSON, or - for standard input. File names in it are relative to its folder; options given
    /// here override its keys. `hexcast job example` prints one
    #[arg(long, value_name = "JOB.toml|JOB.json")]
    pub(crate) job: Option<PathBuf>,
    #[command(flatten)]
    keys: Given<Job>,
    #[command(flatten)]
    inner: InnerArguments,

    /// Part of the name of the GPU to use, see `hexcast adapters`
    #[arg(long, value_name = "NAME", help_heading = "Method")]
    pub(crate) adapter: Option<String>,
    /// Number of threads [default: one per core, and at most one for every 8 MB of --max-memory, but two]
    #[arg(long, value_name = "N", value_parser = threads, help_heading = "Method")]
    threads: Option<u16>,
    /// Most GPU memory to use, at least 1MiB; with less, the mesh is made in smaller bands. If the GPU uses the host's
    /// memory, it counts against --max-memory, too [default: what the GPU has]
    #[arg(long, value_name = "SIZE", help_heading = "Memory")]
    pub(crate) max_device_memory: Option<ByteSize>,
}

/// Options that are a part of a key of the job.
#[derive(clap::Args)]
#[command(next_help_heading = "Cells and domain")]
struct InnerArguments {
    /// Take the lines of each axis from a file: JSON, {"x": [0, 0.5, 2], "y": [...], "z": [...]}; cells may differ in size
    #[arg(long, value_name = "FILE", group = "way", conflicts_with_all = ["domain", "padding"])]
    lines: Option<PathBuf>,
    /// Generate lines: cells of at most this size, on all axes or each, smaller where geometries are, with a line on every end of every
    /// geometry's box
    #[arg(long, value_name = "S|SX,SY,SZ", group = "way", value_parser = per_axis::<f64>)]
    graded: Option<PerAxis<f64>>,
    /// Smallest cell of --graded [default: a thousandth of the largest]
    #[arg(long, value_name = "S", value_parser = number::<f64>)]
    min_size: Option<f64>,
    /// Largest ratio of neighbouring cells of --graded [default: 1.3]
    #[arg(long, value_name = "RATIO", value_parser = number::<f64>)]
    growth: Option<f64>,
    /// Cells that --graded adds at both ends of each axis, as large as the last cell there, for absorbing layers
    #[arg(long, value_name = "N|NX,NY,NZ", value_parser = per_axis::<u32>)]
    absorbing: Option<PerAxis<u32>>,
    /// Cells added on both sides of each axis, also to --domain
    #[arg(long, value_name = "N|NX,NY,NZ", group = "padding", value_parser = per_axis::<u32>)]
    padding_cells: Option<PerAxis<u32>>,
    /// Length added on both sides of each axis, also to --domain
    #[arg(long, value_name = "L|LX,LY,LZ", group = "padding", value_parser = per_axis::<f64>)]
    padding_length: Option<PerAxis<f64>>,
    /// Cells of a chunk of a Zarr store; each chunk is compressed by itself [default: about 256 KiB]
    #[arg(long, value_name = "NX,NY,NZ", value_parser = list::<u32, 3>, help_heading = "Output")]
    zarr_chunks: Option<[u32; 3]>,
    /// Cells of a shard of a Zarr store, or its largest size in bytes. Each shard is a file; making one takes twice its size in memory
    /// [default: 4 MiB to 64 MiB, by the size of the mesh]
    #[arg(long, value_name = "NX,NY,NZ|SIZE", value_parser = shards, help_heading = "Output")]
    zarr_shards: Option<Shards>,
    /// Also write coarser levels to a Zarr store, each of cells twice as large, until no axis has more than 64: what viewers such as neuroglancer show first
    #[arg(long, value_enum, value_name = "RULE", help_heading = "Output")]
    zarr_levels: Option<Levels>,
    /// Leave out the files of the shards of a Zarr store that have no flag
    #[arg(long, help_heading = "Output")]
    zarr_sparse: bool,
}

/// Cells of a shard, or their most.
#[derive(Clone, Copy)]
enum Shards {
    Cells([u32; 3]),
    Bytes(ByteSize),
}

/// Memory for each thread: it keeps some of what it has freed, 1.6 MB as measured.
const BYTES_OF_THREAD: u64 = 8_000_000;

/// Threads where nobody asks for a number: what rayon starts.
fn threads_by_default() -> usize {
    let asked = std::env::var("RAYON_NUM_THREADS").ok().and_then(|text| text.parse().ok()).filter(|&n| n > 0);
    asked.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from))
}

fn threads(text: &str) -> std::result::Result<u16, String> {
    let threads = at_least_one::<u16>(text)?;
    if threads <= 1024 { Ok(threads) } else { Err(format!("{threads} is too large: 1 to 1024 is needed")) }
}

fn shards(text: &str) -> std::result::Result<Shards, String> {
    if text.contains(',') { list(text).map(Shards::Cells) } else { text.parse().map(Shards::Bytes) }
}

impl JobArguments {
    /// Whether a job or files are given.
    pub(crate) fn has_job(&self) -> bool {
        self.job.is_some() || !self.files.is_empty()
    }

    /// The job of the arguments, validated; file names are relative to the current folder. Where nobody limits the memory, this machine does.
    pub(crate) fn job(&self) -> Result<Job> {
        let mut job = self.job_as_given()?;
        job.max_memory = job.max_memory.or_else(default_max_memory);
        Ok(job)
    }

    /// The options that are no part of the job.
    pub(crate) fn run_job(&self) -> RunJob {
        let mut run = RunJob::default();
        (run.adapter, run.threads) = (self.adapter.clone(), self.threads);
        run.max_device_memory = self.max_device_memory;
        run
    }

    /// The same, whatever memory this machine has.
    pub(crate) fn job_as_given(&self) -> Result<Job> {
        let mut job = match &self.job {
            Some(path) => read_job(path)?,
            None => Job::new(self.files.iter().map(|file| geometry_of(file)).collect::<Result<_>>()?),
        };
        job = self.keys.over(job)?;
        self.inner.put(&mut job)?;
        // how lines are generated around a geometry belongs to what chose the cells before
        if self.job.is_some() && self.chooses_cells() && job.graded.is_none() {
            job.geometries.iter_mut().for_each(GeometryJob::clear_sizing);
        }
        job.max_cells = job.max_cells.or(Some(DEFAULT_MAX_CELLS));
        let names = job.geometries.iter().map(|geometry| Path::new(&geometry.file));
        let inputs = names.chain(self.job.as_deref());
        standard_streams::check_once(inputs.clone())?;
        // those that others open, too, and before any output is opened
        inputs.chain(self.inner.lines.as_deref()).try_for_each(ledger::reads)?;
        if self.adapter.is_some() && job.backend == BackendChoice::Cpu {
            let message = "--adapter is given with the backend cpu, which uses no GPU";
            return Err(Error::new("job-conflict", message, "leave out --adapter, or use --backend gpu"));
        }
        job.validate()?;
        Ok(job)
    }

    /// Limits the threads to the number asked for, or to so many as the memory allowed is enough for.
    pub(crate) fn set_threads(&self, max_memory: Option<ByteSize>) -> Result<()> {
        let most = max_memory.map_or(u64::MAX, |size| (size.0 / BYTES_OF_THREAD).max(2));
        let wanted = self
            .threads
            .map(usize::from)
            .or_else(|| usize::try_from(most).ok().filter(|&most| most < threads_by_default()));
        let Some(threads) = wanted else { return Ok(()) };
        let outcome = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
        outcome.map_err(|error| Error::new("io", format!("starting {threads} threads: {error}"), "use fewer"))
    }

    /// Whether an option, and not only a job file, chooses the cells.
    pub(crate) fn chooses_cells(&self) -> bool {
        ["cells", "dims", "cell_size", "max_cell_size"].iter().any(|key| self.keys.has(key))
            || self.inner.lines.is_some()
            || self.inner.graded.is_some()
    }
}

impl InnerArguments {
    /// Puts them into a job.
    fn put(&self, job: &mut Job) -> Result<()> {
        if let Some(path) = &self.lines {
            job.lines = Some(read_lines(path)?);
        }
        job.graded = self.graded.map(GradedJob::new).or(job.graded);
        let padding = self.padding_cells.map(Padding::Cells).or(self.padding_length.map(Padding::Length));
        job.padding = padding.or(job.padding);
        job.zarr = self.zarr(job.zarr);
        let Some(graded) = &mut job.graded else {
            let given = [("--min-size", self.min_size.is_some()), ("--growth", self.growth.is_some())];
            let given = given.into_iter().chain([("--absorbing", self.absorbing.is_some())]).find(|(_, is)| *is);
            return given.map_or(Ok(()), |(option, _)| {
                let message = format!("{option} is given without --graded, the only option that uses it");
                Err(Error::new("job-conflict", message, "give --graded, or a job with graded"))
            });
        };
        graded.min_size = self.min_size.or(graded.min_size);
        graded.growth = self.growth.or(graded.growth);
        graded.absorbing = self.absorbing.or(graded.absorbing);
        Ok(())
    }

    /// The shapes of the shards of Zarr stores: those of the job, and what the arguments change.
    fn zarr(&self, of_job: Option<ZarrJob>) -> Option<ZarrJob> {
        let mut zarr = of_job.unwrap_or_default();
        zarr.chunks = self.zarr_chunks.or(zarr.chunks);
        match self.zarr_shards {
            Some(Shards::Cells(cells)) => (zarr.shards, zarr.shard_bytes) = (Some(cells), None),
            Some(Shards::Bytes(bytes)) => (zarr.shards, zarr.shard_bytes) = (None, Some(bytes)),
            None => {}
        }
        zarr.levels = self.zarr_levels.or(zarr.levels);
        zarr.sparse |= self.zarr_sparse;
        let of_shapes = self.zarr_chunks.is_some() || self.zarr_shards.is_some();
        let is_given = of_shapes || self.zarr_levels.is_some() || self.zarr_sparse;
        (of_job.is_some() || is_given).then_some(zarr)
    }
}

/// The geometry of an argument: a file of exactly this name, if there is one, else a file and settings.
fn geometry_of(argument: &str) -> Result<GeometryJob> {
    if Path::new(argument).is_file() {
        return Ok(GeometryJob::new(argument));
    }
    // settings behind a file whose own name looks like some
    let mut ends = argument.match_indices(':').map(|(at, _)| argument.split_at(at)).rev();
    match ends.find(|(file, _)| file.contains(':') && Path::new(file).is_file()) {
        Some((file, settings)) => {
            let mut geometry = GeometryJob::from_argument(&format!("file{settings}"))?;
            geometry.file = file.into();
            Ok(geometry)
        }
        None => GeometryJob::from_argument(argument),
    }
}

/// Most cells where nobody says: more are a typing error in a size more often than a wish.
const DEFAULT_MAX_CELLS: u64 = 1_000_000_000_000;

/// Three quarters of the memory that is available; None where the system does not say.
pub(crate) fn default_max_memory() -> Option<ByteSize> {
    hexcast::machine::available_bytes().map(|bytes| ByteSize(bytes / 4 * 3))
}

/// Reads one of the names of an enum, as its serde form spells them.
pub(crate) fn choice<T: DeserializeOwned + Clone + Send + Sync + 'static>(
    names: &'static [&'static str],
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(names).try_map(|name| serde_json::from_value::<T>(name.into()))
}
