//! `hexcast mesh`: read, mesh, write, report.

use std::path::Path;
use std::thread;
use std::time::Instant;

use hexcast::control::Control;
use hexcast::error::{Error, Result};
use hexcast::mesh::Mesh;
use hexcast::pipeline::{self, Engine};
use hexcast::report::Report;

use crate::args::MeshArgs;
use crate::outputs::{Output, write_text};
use crate::terminal::{self, bytes, grouped, phase, seconds, three};
use crate::{inputs, job_args};

/// Cells up to which the flags are hashed without being asked for: some seconds of work.
const HASHED_CELLS: u64 = 1 << 32;

pub(crate) fn run(arguments: &MeshArgs) -> Result<()> {
    if let Some(threads) = arguments.threads {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build_global();
        pool.map_err(|error| Error::io("starting threads", std::io::Error::other(error)))?;
    }
    let job = job_args::job(&arguments.job)?;
    let input_paths: Vec<&Path> = job.geometries.iter().map(|geometry| Path::new(&geometry.file)).collect();
    let new_output = |path: &std::path::PathBuf| Output::new(path, &arguments.write, &input_paths);
    let outputs: Vec<Output> = arguments.output.iter().map(new_output).collect::<Result<_>>()?;
    let bar = terminal::bar(arguments.quiet || arguments.json);
    let control = terminal::control(&bar)?;

    phase(&bar, "reading", false);
    // the device opens while the files are read
    let (choice, adapter) = (job.backend, arguments.adapter.clone());
    let opening = thread::spawn(move || pollster::block_on(Engine::open(choice, adapter.as_deref())));
    let start = Instant::now();
    let sources = inputs::sources(&job, &control);
    let read_seconds = start.elapsed().as_secs_f64();
    let engine = opening
        .join()
        .unwrap_or_else(|_| Err(Error::new("device-failed", "opening the GPU panicked", "use --backend cpu")));
    let (sources, mut engine) = (sources?, engine?);

    phase(&bar, "meshing", true);
    let (mesh, mut report) = pollster::block_on(pipeline::mesh(&job, sources, read_seconds, &mut engine, &control))?;
    let written = write(&outputs, &mesh, &mut report, &bar, &control)?;
    hash(arguments, &mesh, &mut report, &bar, &control)?;
    report.peak_bytes.host = peak_host_bytes();
    bar.finish_and_clear();

    if let Some(path) = &arguments.report {
        write_text(path, &report.to_json())?;
    }
    if arguments.json {
        println!("{}", report.to_json());
    } else if !arguments.quiet {
        show(&report, arguments.verbose, &written);
    }
    Ok(())
}

/// Writes all outputs; returns a line on each.
fn write(
    outputs: &[Output],
    mesh: &Mesh,
    report: &mut Report,
    bar: &indicatif::ProgressBar,
    control: &Control,
) -> Result<Vec<String>> {
    let mut lines = Vec::new();
    let start = Instant::now();
    for output in outputs {
        phase(bar, &format!("writing {}", output.path.display()), false);
        let written = output.write(mesh, control)?;
        lines.push(format!("{} ({})", output.path.display(), bytes(written.n_bytes as f64)));
        if output.is_plain_raw() {
            report.flags_sha256 = written.sha256;
        }
    }
    report.seconds.write = (!outputs.is_empty()).then(|| start.elapsed().as_secs_f64());
    Ok(lines)
}

fn hash(
    arguments: &MeshArgs,
    mesh: &Mesh,
    report: &mut Report,
    bar: &indicatif::ProgressBar,
    control: &Control,
) -> Result<()> {
    let wanted = match arguments.hash.as_str() {
        "always" => true,
        "never" => false,
        _ => mesh.n_cells() <= HASHED_CELLS,
    };
    if wanted && report.flags_sha256.is_none() {
        phase(bar, "hashing the flags", false);
        let start = Instant::now();
        report.flags_sha256 = Some(mesh.flags_sha256(control)?);
        report.seconds.hash = Some(start.elapsed().as_secs_f64());
    }
    Ok(())
}

/// Most memory that this process has held, where the system tells.
fn peak_host_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<u64>().ok().map(|kilobytes| kilobytes * 1024)
}

fn show(report: &Report, verbose: bool, written: &[String]) {
    let unit = report.unit.as_ref().map_or(String::new(), |unit| format!(" {unit}"));
    let line = |key: &str, value: String| println!("{key:>12}  {value}");
    match (&report.adapter, &report.driver) {
        (Some(adapter), Some(driver)) => line("GPU", format!("{adapter}, {driver}")),
        _ => line("CPU", "all stages on the processor".into()),
    }
    for input in &report.inputs {
        line("input", format!("{} ({}, {} facets)", input.file, input.format, grouped(input.facets)));
    }
    let far = [0, 1, 2].map(|axis| report.origin[axis] + f64::from(report.dims[axis]) * report.spacing[axis]);
    line("domain", format!("{} to {}{unit}", three(report.origin, ", "), three(far, ", ")));
    line("cells", format!("{} = {}", three(report.dims, " x "), grouped(report.cells)));
    line("cell size", format!("{}{unit}", three(report.spacing, " x ")));
    let rays = format!("{} along {}, {} crossings", grouped(report.rays), report.ray_axis, grouped(report.crossings));
    line("rays", rays);
    for flag in &report.flags {
        let cells = format!("{} cells", grouped(flag.cells));
        let volumes = format!("volume {:.6e} (surface: {:.6e})", flag.volume, flag.mesh_volume);
        line(&format!("flag {}", flag.flag), format!("{}: {cells}, {volumes}", flag.name));
    }
    show_residuals(report, verbose);
    let times = &report.seconds;
    let stages = [("read", times.read), ("snap", times.snap), ("columns", times.columns)];
    let stages: Vec<String> = stages.iter().map(|(name, s)| format!("{name} {}", seconds(*s))).collect();
    line(
        "time",
        format!("{} ({}; device opened in {})", seconds(times.total), stages.join(", "), seconds(times.device)),
    );
    line("speed", format!("{:.3e} cells/s", report.cells_per_second));
    let host = report.peak_bytes.host.map_or("unknown".into(), |n| bytes(n as f64));
    line("memory", format!("host {host}, device {}", bytes(report.peak_bytes.device as f64)));
    if let Some(hash) = &report.flags_sha256 {
        line("sha256", hash.clone());
    }
    written.iter().for_each(|file| line("wrote", file.clone()));
    let of_inputs =
        report.inputs.iter().flat_map(|input| input.warnings.iter().map(|w| format!("{}: {w}", input.file)));
    of_inputs.chain(report.warnings.iter().cloned()).for_each(|warning| eprintln!("warning: {warning}"));
}

/// Ends of bounding boxes that lie off the mesh lines; all of them where asked for.
fn show_residuals(report: &Report, verbose: bool) {
    for (axis, residuals) in ["x", "y", "z"].iter().zip(&report.end_points) {
        let worst = residuals.iter().map(|residual| residual.cells.abs()).fold(0.0, f64::max);
        if worst > 1e-6 || verbose {
            println!(
                "{:>12}  {} end points along {axis}, at most {worst:.4} cells off a mesh line",
                "lines",
                residuals.len()
            );
        }
        if verbose {
            residuals.iter().for_each(|r| println!("{:>12}  {axis} = {}: {:+.6} cells", "", r.end_point, r.cells));
        }
    }
}
