//! Arguments that decide a mesh, and the job that they make, alone or together with a job file.

use std::path::{Path, PathBuf};

use clap::builder::{PossibleValuesParser, TypedValueParser};
use hexcast::job::{
    AxisChoice, BackendChoice, BackgroundJob, ByteSize, Fill, GeometryJob, GradedJob, HaloEdge, Job, Open, Padding,
    PartJob, PerAxis, Rule, RunJob, ZarrJob,
};
use hexcast::{Error, Result};
use serde::de::DeserializeOwned;

use crate::files::{ledger, standard_streams};
pub(crate) use crate::options::numbers::{at_least_one, number};
use crate::options::{
    job_files::{read_job, read_lines},
    numbers::{list, per_axis},
    spelling::input_name,
};

/// What to mesh and how finely.
#[derive(clap::Args)]
pub(crate) struct JobArguments {
    /// STL, OBJ, OFF, PLY, 3MF or GLB files, also packed by gzip, or - for standard input. They get the flags 1, 2, ... in order, unless set as in
    /// coil.stl:flag=7,priority=2,name=copper (keys: flag, priority, open, fill, shell, invert, max_size, min_cells, metal, name, solid, split,
    /// same_flag, scale, rotate, about, translate, and eps_r, mu_r, sigma, pec, density, E, nu of the material)
    #[arg(value_name = "FILE", required_unless_present = "job", conflicts_with = "job", value_parser = input_name())]
    files: Vec<String>,
    /// Take all options from a job file, TOML or JSON, or - for standard input. File names in it are relative to its folder; options given
    /// here override its keys. `hexcast job example` prints one
    #[arg(long, value_name = "JOB.toml|JOB.json")]
    pub(crate) job: Option<PathBuf>,

    /// Cubic cells, N along the longest axis [default: 128]
    #[arg(long, value_name = "N", group = "way", value_parser = number::<u32>, help_heading = "Cells and domain")]
    cells: Option<u32>,
    /// Number of cells on each axis
    #[arg(long, value_name = "NX,NY,NZ", group = "way", value_parser = list::<u32, 3>, help_heading = "Cells and domain")]
    dims: Option<[u32; 3]>,
    /// Cell size, one for all axes or three
    #[arg(long, value_name = "S|SX,SY,SZ", group = "way", value_parser = per_axis::<f64>, help_heading = "Cells and domain")]
    cell_size: Option<PerAxis<f64>>,
    /// On each axis the largest size, at most S, that puts every end of every geometry's box on a mesh line
    #[arg(long, value_name = "S", group = "way", value_parser = number::<f64>, help_heading = "Cells and domain")]
    max_cell_size: Option<f64>,
    /// Largest distance, in cells, of an end point from its line with --max-cell-size: 0 to 0.5 [default: 0.05]
    #[arg(long, value_name = "CELLS", value_parser = number::<f64>, help_heading = "Cells and domain")]
    tolerance: Option<f64>,
    /// Take the lines of each axis from a file: JSON, {"x": [0, 0.5, 2], "y": [...], "z": [...]}; cells may differ in size
    #[arg(long, value_name = "FILE", group = "way", conflicts_with_all = ["domain", "padding"], help_heading = "Cells and domain")]
    lines: Option<PathBuf>,
    /// Generate lines: cells of at most this size, on all axes or each, smaller where geometries are, with a line on every end of every
    /// geometry's box
    #[arg(long, value_name = "S|SX,SY,SZ", group = "way", value_parser = per_axis::<f64>, help_heading = "Cells and domain")]
    graded: Option<PerAxis<f64>>,
    /// Smallest cell of --graded [default: a thousandth of the largest]
    #[arg(long, value_name = "S", value_parser = number::<f64>, help_heading = "Cells and domain")]
    min_size: Option<f64>,
    /// Largest ratio of neighbouring cells of --graded [default: 1.3]
    #[arg(long, value_name = "RATIO", value_parser = number::<f64>, help_heading = "Cells and domain")]
    growth: Option<f64>,
    /// Cells that --graded adds at both ends of each axis, as large as the last cell there, for absorbing layers
    #[arg(long, value_name = "N|NX,NY,NZ", value_parser = per_axis::<u32>, help_heading = "Cells and domain")]
    absorbing: Option<PerAxis<u32>>,
    /// Most cells, such as 2e12; a mesh of more is refused before it starts [default: 1e12]
    #[arg(long, value_name = "N", value_parser = at_least_one::<u64>, help_heading = "Cells and domain")]
    max_cells: Option<u64>,
    /// Two corners of the box [default: the box around all geometries]; padding comes on top
    #[arg(long, value_name = "X0,Y0,Z0,X1,Y1,Z1", value_parser = list::<f64, 6>, allow_hyphen_values = true,
          help_heading = "Cells and domain")]
    domain: Option<[f64; 6]>,
    /// Mesh only some cells of the box: the first on each axis, and the end, exclusive. They get the flags that they have in the whole mesh
    #[arg(long, value_name = "I0,J0,K0,I1,J1,K1", value_parser = list::<u32, 6>, help_heading = "Cells and domain")]
    window: Option<[u32; 6]>,
    /// Mesh only part K, from 1 to N, of N slabs across z that take about the same time, or of NX x NY x NZ boxes; `hexcast parts` lists them
    #[arg(long, value_name = "K/N|K/NXxNYxNZ", conflicts_with = "window", help_heading = "Cells and domain")]
    pub(crate) part: Option<PartJob>,
    /// Cells around --window or --part that are also meshed, on both sides of each axis
    #[arg(long, value_name = "N", value_parser = number::<u32>, help_heading = "Cells and domain")]
    halo: Option<u32>,
    /// Flags of halo cells beyond the box: background, or the flag of the nearest cell of the box [default: background]
    #[arg(long, value_parser = choice::<HaloEdge>(&["background", "clamp"]), help_heading = "Cells and domain")]
    halo_edge: Option<HaloEdge>,
    /// Cells of a chunk of a Zarr store; each chunk is compressed by itself [default: about 256 KiB]
    #[arg(long, value_name = "NX,NY,NZ", value_parser = list::<u32, 3>, help_heading = "Output")]
    zarr_chunks: Option<[u32; 3]>,
    /// Cells of a shard of a Zarr store, or its largest size in bytes. Each shard is a file; making one takes twice its size in memory
    /// [default: 4 MiB to 64 MiB, by the size of the mesh]
    #[arg(long, value_name = "NX,NY,NZ|SIZE", value_parser = shards, help_heading = "Output")]
    zarr_shards: Option<Shards>,
    /// Cells added on both sides of each axis, also to --domain
    #[arg(long, value_name = "N|NX,NY,NZ", group = "padding", value_parser = per_axis::<u32>,
          help_heading = "Cells and domain")]
    padding_cells: Option<PerAxis<u32>>,
    /// Length added on both sides of each axis, also to --domain
    #[arg(long, value_name = "L|LX,LY,LZ", group = "padding", value_parser = per_axis::<f64>,
          help_heading = "Cells and domain")]
    padding_length: Option<PerAxis<f64>>,

    /// What is inside: an odd number of crossings, or a winding number that is not zero [default: parity]
    #[arg(long, value_parser = choice::<Rule>(&["parity", "nonzero"]), help_heading = "Method")]
    rule: Option<Rule>,
    /// What decides cells where a surface is not closed: the winding number, a vote of the rays of three axes, nothing (an error), or
    /// the rays of one axis as they are [default: winding]
    #[arg(long, value_parser = choice::<Open>(&["winding", "vote", "error", "parity"]), help_heading = "Method")]
    open: Option<Open>,
    /// Which cells a geometry has: those whose centres lie inside; also every cell that the surface touches; or also the cells that
    /// separate the two sides of the surface [default: centre]
    #[arg(long, value_parser = choice::<Fill>(&["centre", "conservative", "separating"]), help_heading = "Method")]
    fill: Option<Fill>,
    /// Close openings narrower than K cells along x, y or z, at least 2, and no wider ones
    #[arg(long, value_name = "K", value_parser = number::<u32>, help_heading = "Method")]
    close_gaps: Option<u32>,
    /// Flag of the cells that --close-gaps adds [default: one more than the greatest]
    #[arg(long, value_name = "F", value_parser = at_least_one::<u8>, help_heading = "Method")]
    gap_flag: Option<u8>,
    /// Look for thin walls and for cells that two geometries claim; takes several times as long as a mesh on the CPU
    #[arg(long, help_heading = "Method")]
    certify: bool,
    /// Leave out the checks that are made of every mesh: whether parts of geometries have no cell, or another volume than their surface
    #[arg(long, help_heading = "Method")]
    quick: bool,
    /// Walls of fewer cells than this are thin, for --certify [default: 2]
    #[arg(long, value_name = "K", requires = "certify", value_parser = number::<u32>, help_heading = "Method")]
    thin_cells: Option<u32>,
    /// What meshes: the GPU or the CPU; auto takes the GPU if there is one [default: auto]
    #[arg(long, value_parser = choice::<BackendChoice>(&["auto", "gpu", "cpu"]), help_heading = "Method")]
    backend: Option<BackendChoice>,
    /// Part of the name of the GPU to use, see `hexcast adapters`
    #[arg(long, value_name = "NAME", help_heading = "Method")]
    pub(crate) adapter: Option<String>,
    /// Axis of the rays; the result does not depend on it [default: auto, the longest axis, or
    /// the first of those nearly as long]
    #[arg(long, value_parser = choice::<AxisChoice>(&["auto", "x", "y", "z"]), help_heading = "Method")]
    axis: Option<AxisChoice>,
    /// Number of threads [default: one per core]
    #[arg(long, value_name = "N", value_parser = threads, help_heading = "Method")]
    threads: Option<u16>,

    /// Most memory to use, such as 2GB or 512MiB; a mesh that needs more is refused before it starts, unless its columns
    /// may spill to disk [default: 3/4 of the available memory]
    #[arg(long, value_name = "SIZE", help_heading = "Memory")]
    max_memory: Option<ByteSize>,
    /// Most GPU memory to use, at least 1MiB; with less, the mesh is made in smaller bands. If the GPU uses the host's
    /// memory, it counts against --max-memory, too [default: what the GPU has]
    #[arg(long, value_name = "SIZE", help_heading = "Memory")]
    pub(crate) max_device_memory: Option<ByteSize>,

    /// Unit of the lengths in the files, such as mm; it is written to every output
    #[arg(long, value_name = "UNIT")]
    unit: Option<String>,
    /// Name and material of the background, flag 0, such as name=air,eps_r=1.0006, for outputs that contain it
    #[arg(long, value_name = "KEY=VALUE,...", help_heading = "Output")]
    background: Option<BackgroundJob>,
    /// Make every solid (part, node, item) of every file a geometry of its own
    #[arg(long)]
    split: bool,
    /// Give every geometry the cells outside of it instead of those inside, such as the fluid around a body
    #[arg(long)]
    invert: bool,
}

/// Cells of a shard, or their most.
#[derive(Clone, Copy)]
enum Shards {
    Cells([u32; 3]),
    Bytes(ByteSize),
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

    /// The shapes of the shards of Zarr stores: those of the job, and what the arguments change.
    fn zarr(&self, of_job: Option<ZarrJob>) -> Option<ZarrJob> {
        let mut zarr = of_job.unwrap_or_default();
        zarr.chunks = self.zarr_chunks.or(zarr.chunks);
        match self.zarr_shards {
            Some(Shards::Cells(cells)) => (zarr.shards, zarr.shard_bytes) = (Some(cells), None),
            Some(Shards::Bytes(bytes)) => (zarr.shards, zarr.shard_bytes) = (None, Some(bytes)),
            None => {}
        }
        let is_given = self.zarr_chunks.is_some() || self.zarr_shards.is_some();
        of_job.is_some().then_some(zarr).or(is_given.then_some(zarr))
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
        self.override_cells(&mut job)?;
        self.override_domain(&mut job);
        if self.window.is_some() || self.part.is_some() {
            (job.window, job.part) = (self.window, self.part);
        }
        job.halo = self.halo.or(job.halo);
        job.halo_edge = self.halo_edge.or(job.halo_edge);
        job.zarr = self.zarr(job.zarr);
        job.rule = self.rule.unwrap_or(job.rule);
        job.open = self.open.unwrap_or(job.open);
        job.fill = self.fill.unwrap_or(job.fill);
        job.close_gaps = self.close_gaps.or(job.close_gaps);
        job.gap_flag = self.gap_flag.or(job.gap_flag);
        job.certify |= self.certify;
        job.quick |= self.quick;
        job.thin_cells = self.thin_cells.or(job.thin_cells);
        job.backend = self.backend.unwrap_or(job.backend);
        job.axis = self.axis.unwrap_or(job.axis);
        job.max_memory = self.max_memory.or(job.max_memory);
        job.unit = self.unit.clone().or(job.unit);
        job.background = self.background.clone().or(job.background);
        job.split |= self.split;
        job.invert |= self.invert;
        let names = job.geometries.iter().map(|geometry| Path::new(&geometry.file));
        let inputs = names.chain(self.job.as_deref());
        standard_streams::check_once(inputs.clone())?;
        // those that others open, too, and before any output is opened
        inputs.chain(self.lines.as_deref()).try_for_each(ledger::reads)?;
        if self.adapter.is_some() && job.backend == BackendChoice::Cpu {
            let message = "--adapter is given with the backend cpu, which uses no GPU";
            return Err(Error::new("job-conflict", message, "leave out --adapter, or use --backend gpu"));
        }
        job.validate()?;
        Ok(job)
    }

    /// Limits the threads to the number asked for.
    pub(crate) fn set_threads(&self) -> Result<()> {
        let Some(threads) = self.threads else { return Ok(()) };
        let outcome = rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global();
        outcome.map_err(|error| Error::new("io", format!("starting {threads} threads: {error}"), "use fewer"))
    }

    /// Whether an option, and not only a job file, chooses the cells.
    pub(crate) fn chooses_cells(&self) -> bool {
        let is_listed = self.lines.is_some() || self.graded.is_some();
        let is_sized = self.cell_size.is_some() || self.max_cell_size.is_some();
        self.cells.is_some() || self.dims.is_some() || is_sized || is_listed
    }

    fn override_cells(&self, job: &mut Job) -> Result<()> {
        if self.chooses_cells() {
            job.lines = self.lines.as_deref().map(read_lines).transpose()?;
            job.graded = self.graded.map(GradedJob::new);
            if self.lines.is_some() {
                (job.domain, job.padding) = (None, None);
            }
            if self.job.is_some() && job.graded.is_none() {
                job.geometries.iter_mut().for_each(GeometryJob::clear_sizing);
            }
            (job.cells, job.dims) = (self.cells, self.dims);
            (job.cell_size, job.max_cell_size) = (self.cell_size, self.max_cell_size);
            // a tolerance belongs to the setting that was overridden
            job.tolerance = job.tolerance.filter(|_| self.max_cell_size.is_some());
        }
        job.tolerance = self.tolerance.or(job.tolerance);
        self.override_graded(job)?;
        job.max_cells = self.max_cells.or(job.max_cells).or(Some(DEFAULT_MAX_CELLS));
        Ok(())
    }

    fn override_graded(&self, job: &mut Job) -> Result<()> {
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

    fn override_domain(&self, job: &mut Job) {
        let cells = self.padding_cells.map(Padding::Cells);
        let padding = cells.or(self.padding_length.map(Padding::Length));
        // padding belongs to the box that was overridden
        if self.domain.is_some() {
            (job.domain, job.padding) = (self.domain, None);
        }
        job.padding = padding.or(job.padding);
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
