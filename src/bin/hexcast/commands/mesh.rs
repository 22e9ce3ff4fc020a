//! `hexcast mesh`: files in, mesh files and a report out.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use hexcast::control::{CancelToken, Control};
use hexcast::export::{Exporter, PatchNames};
use hexcast::job::{Job, Names, RunJob};
use hexcast::mesh::Mesh;
use hexcast::pipeline::{self, Engine, MeshOptions, Prepared, SpillTarget};
use hexcast::report::{CallerFacts, Report};
use hexcast::sources::Source;
use hexcast::{Error, Result};

use crate::commands::picture_outputs::PictureArguments;
use crate::files::{
    measured::MeasuredArguments,
    output::{Meshed, Written},
    outputs::{FormatArguments, Outputs, Targets},
    reading,
    spill::SpillArguments,
};
use crate::options::{
    arguments::JobArguments,
    format_arguments::exporter_of,
    job_options::{as_text, dump},
};
use crate::screen::{memory, progress::Progress, summary, terminal};

/// Mesh surfaces: give each cell of a box the flag of the geometry that its centre is in
#[derive(clap::Args)]
pub(crate) struct Arguments {
    #[command(flatten)]
    job: JobArguments,
    /// Output; its ending chooses the format, see --help. - is standard output, with --format. May be given several times. Without it only
    /// the report is made
    #[arg(id = "outputs", short, long = "output", value_name = "OUT", help_heading = "Output")]
    outputs: Vec<PathBuf>,
    #[command(flatten)]
    formats: FormatArguments,
    #[command(flatten)]
    measured: MeasuredArguments,
    #[command(flatten)]
    pictures: PictureArguments,
    #[command(flatten)]
    spill: SpillArguments,
    /// Write the report to a file, as JSON; - is standard output
    #[arg(long, value_name = "FILE", help_heading = "Report")]
    report: Option<PathBuf>,
    /// Print the report to standard output as JSON, and nothing else there
    #[arg(long, help_heading = "Report")]
    json: bool,
    /// Write a job file that does the same as all arguments together, and mesh nothing. Its name chooses TOML or JSON; - is standard output
    #[arg(long, value_name = "FILE", help_heading = "Report")]
    dump_job: Option<PathBuf>,
    /// Write a mask of the doubtful cells to a file, .vti, .vtr, .npy, .npz, .raw or .hxc: 1 where the winding number or a vote decided, as the
    /// rays could not
    #[arg(long, value_name = "FILE", help_heading = "Measured")]
    doubt: Option<PathBuf>,
    /// Expand all flags in memory, and include that in the total time: for comparisons with other meshers
    #[arg(long, help_heading = "Output")]
    flags_in_memory: bool,
    /// End with exit code 8 if there are warnings about the mesh or its input files; the outputs are written all the same. That `auto` found
    /// no GPU to use is not counted: the cells are the same
    #[arg(long, help_heading = "Report")]
    strict: bool,
    /// Print nothing but warnings and errors
    #[arg(short, long, conflicts_with = "verbose", help_heading = "Report")]
    quiet: bool,
    /// Print more: geometries, end points, all stages
    #[arg(short, long, help_heading = "Report")]
    verbose: bool,
}

/// Exit code of a run with warnings that was asked to be strict.
const STRICT: u8 = 8;

impl Arguments {
    /// The options that are no part of the job, as keys of a job file.
    fn run_job(&self) -> Result<RunJob> {
        let mut run = self.job.run_job();
        let outputs = self.outputs.iter().map(|path| as_text(path)).collect::<Result<Vec<String>>>()?;
        run.output = (!outputs.is_empty()).then_some(Names::Many(outputs));
        run.report = self.report.as_deref().map(as_text).transpose()?;
        run.doubt = self.doubt.as_deref().map(as_text).transpose()?;
        self.formats.put(&mut run);
        self.measured.put(&mut run)?;
        self.pictures.put(&mut run);
        self.spill.put(&mut run)?;
        (run.flags_in_memory, run.strict, run.json) = (self.flags_in_memory, self.strict, self.json);
        (run.quiet, run.verbose) = (self.quiet, self.verbose);
        Ok(run)
    }

    /// Asks in a job for what the outputs need beside cells.
    fn ask(&self, job: &mut Job) -> Result<()> {
        self.measured.ask(job)?;
        let mut exporters = self.outputs.iter().filter_map(|output| exporter_of(output));
        self.formats.ask(exporters.any(Exporter::is_boundary), job)
    }
}

pub(crate) fn run(arguments: &Arguments, token: &CancelToken) -> Result<ExitCode> {
    if let Some(path) = &arguments.dump_job {
        let mut job = arguments.job.job_as_given()?;
        arguments.ask(&mut job)?;
        dump(&job, arguments.run_job()?, path)?;
        return Ok(ExitCode::SUCCESS);
    }
    let mut job = arguments.job.job()?;
    arguments.ask(&mut job)?;
    let (doubt, report) = (arguments.doubt.as_deref(), arguments.report.as_deref());
    let (zarr, is_part) = (job.zarr.unwrap_or_default(), job.part.is_some());
    let has_archive = arguments.measured.has_archive();
    let targets = Targets { meshes: &arguments.outputs, doubt, report, zarr, is_part, has_archive };
    if targets.has_zarr() {
        job.zarr = Some(zarr);
        if job.part.is_some() && job.halo.is_some() {
            let message = "halo and part are given with a Zarr store: a store has every cell once";
            return Err(Error::new("job-conflict", message, "leave out halo, or write another format"));
        }
    }
    if targets.uses_standard_output() && arguments.json {
        let message = "--json is given with an output that is -: both are standard output";
        return Err(Error::new("job-conflict", message, "use --report FILE for one of them"));
    }
    let max_bytes = job.max_memory.map_or(u64::MAX, |size| size.0);
    let mut outputs = Outputs::open(&targets, &arguments.formats, max_bytes)?;
    outputs.measured = arguments.measured.open(&arguments.formats, (zarr, max_bytes))?;
    outputs.pictures = arguments.pictures.open(max_bytes)?;
    if arguments.formats.bits {
        check_single_flag(&job)?;
    }
    arguments.job.set_threads(job.max_memory)?;
    let file = arguments.spill.open(&arguments.outputs)?;
    // on one of the threads: loops on all cores begin at once there, and from outside each would wake one first
    let meshed = rayon::scope(|_| mesh_and_write(arguments, &job, outputs, file.target.clone(), token));
    match &meshed {
        Ok(_) => file.remove(),
        Err(error) => file.keep_after(error),
    }
    let meshed = meshed.map_err(|error| arguments.spill.at_file(error, &arguments.outputs));
    Ok(if meshed? && arguments.strict { ExitCode::from(STRICT) } else { ExitCode::SUCCESS })
}

/// Does the work, and returns whether there are warnings.
fn mesh_and_write(
    arguments: &Arguments,
    job: &Job,
    mut outputs: Outputs,
    spill: SpillTarget,
    token: &CancelToken,
) -> Result<bool> {
    let progress = Progress::new(arguments.quiet);
    let (mut engine, sources, read) = open_and_read(arguments, job, token, progress)?;
    let bar = progress.rays("mesh");
    let moved = bar.clone();
    let mut control = Control::with_progress(move |now| {
        moved.set_length(now.n_rays);
        moved.set_position(now.rays_done);
    });
    control = control.on_holes(move |work| progress.about_holes(work));
    control.cancel = token.clone();
    control.memory = memory::limit(u64::MAX);
    let solids = sources.iter().flat_map(|source| &source.contents.solids);
    let facet_bytes = solids.map(|solid| solid.facets.n_bytes()).sum();
    let program_bytes = memory::program_bytes_now(engine.adapter().is_some(), facet_bytes);
    let spills = !matches!(spill, SpillTarget::None);
    let options = MeshOptions::default()
        .with_spill(spill)
        .with_flags_in_memory(arguments.flags_in_memory)
        .with_doubt_mask(arguments.doubt.is_some())
        .with_walls(arguments.formats.patches == Some(PatchNames::Solid))
        .with_lone_report(arguments.report.is_none() && !arguments.json)
        .with_program_bytes(program_bytes)
        .with_max_device_bytes(arguments.job.max_device_memory.map(|size| size.0));
    let check = |prepared: &Prepared| outputs.check(job, prepared, (spills, program_bytes));
    let meshed = pollster::block_on(pipeline::mesh_if(job, sources, (&options, &check), &mut engine, &control));
    bar.finish_and_clear();
    let (mesh, facts) = meshed?;
    // there is no next mesh
    engine.clear_pool_over(0);

    let flags = arguments.flags_in_memory.then(|| timed(|| expand_all(&mesh))).transpose()?;
    // a `.raw` is hashed as it is written
    let hashes_first = arguments.formats.hash.is_some() && !outputs.will_hash;
    let hashed =
        hashes_first.then(|| timed(|| mesh.flags_sha256_in_slabs(outputs.slab_bytes, &control))).transpose()?;
    let (mesh, control) = (&mesh, &control);
    let held_bytes = program_bytes + mesh.columns().n_bytes();
    let meshed = Meshed { mesh, facts: Some(&facts), held_bytes, control, progress };
    let writes = !outputs.cells.is_empty();
    let written = writes.then(|| timed(|| outputs.write_cells(&meshed))).transpose()?;
    let (sha256, hash) = hashed.unzip();
    let caller = CallerFacts::default()
        .with_read(read)
        .with_flags(flags.map(|(_, seconds)| seconds))
        .with_hash(hash)
        .with_write(written.map(|(_, seconds)| seconds))
        .with_flags_sha256(sha256.or(outputs.written.flags_sha256.take()))
        .with_host_bytes(memory::peak_bytes());
    let report = Report::new(facts, caller);
    let text = format!("{}\n", report.to_json());
    let meshed = Meshed { mesh, facts: Some(&report.mesh), held_bytes, control, progress };
    outputs.finish(&meshed, &text)?;
    // after all else is in its place: a picture that fails leaves it there, with all that is to be said of it
    let drawn = outputs.draw(&meshed);
    let Outputs { written: Written { files, mut warnings, .. }, has_standard_output, .. } = outputs;
    warnings.extend(arguments.formats.merged(mesh));

    let n_warnings = warn(&report, &warnings, arguments.strict);
    if arguments.json {
        terminal::print_exact(&text)?;
    } else if !arguments.quiet && !has_standard_output {
        let shown = summary::Shown { ends: job.max_cell_size.is_some(), verbose: arguments.verbose };
        terminal::print(&summary::of_mesh(&report, engine.is_software(), &files, shown))?;
    }
    drawn.map(|()| n_warnings > 0)
}

/// Prints the warnings of the mesh and of outputs, and returns how many there are.
fn warn(report: &Report, warnings: &[String], is_strict: bool) -> usize {
    report.mesh.findings.iter().for_each(terminal::warn_of);
    warnings.iter().for_each(|warning| terminal::complain(&terminal::one_line(&format!("warning: {warning}"))));
    let n = report.mesh.findings.len() + warnings.len();
    if is_strict && n > 0 {
        let plural = if n == 1 { "" } else { "s" };
        let code = STRICT;
        terminal::complain(&format!("strict: {n} warning{plural}, and --strict is given: the exit code is {code}"));
    }
    n
}

/// Does something, and returns its result and the seconds that it took.
fn timed<T>(act: impl FnOnce() -> Result<T>) -> Result<(T, f64)> {
    let start = Instant::now();
    let result = act()?;
    Ok((result, start.elapsed().as_secs_f64()))
}

/// Opens the backend and reads the files, side by side; also returns the seconds that reading took.
fn open_and_read(
    arguments: &Arguments,
    job: &Job,
    token: &CancelToken,
    progress: Progress,
) -> Result<(Engine, Vec<Source>, f64)> {
    let adapter = arguments.job.adapter.as_deref();
    std::thread::scope(|scope| {
        let opening = scope.spawn(|| pollster::block_on(Engine::open(job.backend, adapter)));
        let start = Instant::now();
        let sources = reading::read_job_files(job, token, progress);
        let seconds = start.elapsed().as_secs_f64();
        let engine = opening.join().unwrap_or_else(|_| {
            let message = "the GPU driver crashed while it was opened";
            Err(Error::new("device-failed", message, "use --backend cpu, or update the GPU driver"))
        });
        // of two errors that of a file is the more useful one
        let sources = sources?;
        Ok((engine?, sources, seconds))
    })
}

/// Refuses before meshing what the writer of bit-packed files would refuse after it.
fn check_single_flag(job: &Job) -> Result<()> {
    // those without a flag get their number
    let flags = job.geometries.iter().zip(1..).map(|(geometry, number)| geometry.flag.map_or(number, u32::from));
    let flags: Vec<u32> = flags.collect();
    if flags.iter().any(|flag| *flag != flags[0]) {
        let message = format!("--bits is given with {} geometries of different flags", flags.len());
        return Err(Error::new("job-conflict", message, "give all the same flag, or leave out --bits"));
    }
    if job.close_gaps.is_some() && job.gap_flag.map(u32::from) != Some(flags[0]) {
        let message = "--bits is given, and closed gaps get a flag of their own";
        return Err(Error::new("job-conflict", message, format!("add --gap-flag {}, or leave out --bits", flags[0])));
    }
    Ok(())
}

/// Expands the flags of all cells in memory, only to take the time.
fn expand_all(mesh: &Mesh) -> Result<()> {
    let mut flags = memory::zeroed(mesh.n_cells())?;
    mesh.fill_box(&mesh.dims().map(|n| 0..n), &mut flags)?;
    std::hint::black_box(&flags);
    Ok(())
}
