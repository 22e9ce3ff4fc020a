//! Times hexcast on a table of cases: the whole line, its passes, and the paper's gather beside our intersection.
//!
//! `cargo bench --bench table -- --help` says what can be chosen. One JSON object a line goes to stdout; `npm run bench` runs
//! the same program in turn with its peers and makes tables of it.

use std::error::Error;
use std::path::PathBuf;

use clap::Parser;
use hexcast::gpu::Gpu;
use hexcast::job::{AxisChoice, BackendChoice, Rule};
use hexcast::pipeline::Engine;
use hexcast_core::stages::cast::Cast;
use serde_json::json;

mod cases;
mod line;
mod machine;
mod moved;
mod naive_gather;
mod passes;
mod serial;
mod spheres;

use cases::Case;

/// Times hexcast, one JSON object a line.
#[derive(Parser)]
struct Arguments {
    /// Folder with more models; or the variable HEXCAST_MODELS
    #[arg(long)]
    models: Option<PathBuf>,
    /// Only cases with this in their name
    #[arg(long)]
    case: Option<String>,
    /// This STL file instead of the table
    #[arg(long)]
    file: Option<PathBuf>,
    /// Cells along the longest axis instead of the table's
    #[arg(long)]
    cells: Option<u32>,
    /// Along which axis the rays run
    #[arg(long, default_value = "auto", value_parser = ["auto", "x", "y", "z"])]
    axis: String,
    /// Runs besides a first one that counts for nothing
    #[arg(long, default_value_t = 5)]
    runs: u32,
    /// Who meshes: cpu, gpu
    #[arg(long, value_delimiter = ',', default_value = "cpu,gpu")]
    backends: Vec<String>,
    /// Also time every pass, and the paper's gather
    #[arg(long)]
    passes: bool,
    /// Also time the traditional algorithm on one core
    #[arg(long)]
    serial: bool,
    /// Write the flags of the last run, u8, x fastest
    #[arg(long)]
    flags: Option<PathBuf>,
    /// Write model 4 of the paper to this file and end
    #[arg(long)]
    spheres: Option<PathBuf>,
    /// Time a body that moves in a scene, and end
    #[arg(long)]
    moved: bool,
    /// Given by `cargo bench`
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    if let Some(path) = &arguments.spheres {
        cases::write_spheres(path)?;
        return Ok(());
    }
    if arguments.moved {
        return moved::measure(arguments.cells.unwrap_or(256), arguments.runs);
    }
    let scratch = tempfile::tempdir()?;
    for case in chosen(&arguments, scratch.path())? {
        for backend in &arguments.backends {
            let choice = match backend.as_str() {
                "cpu" => BackendChoice::Cpu,
                "gpu" => BackendChoice::Gpu,
                _ => return Err(format!("no backend is named {backend}: cpu or gpu").into()),
            };
            whole_line(&case, choice, &arguments)?;
        }
        if arguments.passes {
            every_pass(&case, arguments.runs)?;
        }
        if arguments.serial {
            let serial = serial::measure(&case)?;
            println!("{}", json!({ "case": case.name, "n": case.cells, "serial": serial }));
        }
    }
    Ok(())
}

/// The cases that the arguments leave.
fn chosen(arguments: &Arguments, scratch: &std::path::Path) -> Result<Vec<Case>, Box<dyn Error>> {
    let axis = match arguments.axis.as_str() {
        "x" => AxisChoice::X,
        "y" => AxisChoice::Y,
        "z" => AxisChoice::Z,
        _ => AxisChoice::Auto,
    };
    if let Some(file) = &arguments.file {
        let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        return Ok(vec![Case { name, file: file.clone(), cells: arguments.cells.unwrap_or(512), axis }]);
    }
    let models = arguments.models.clone().or_else(|| std::env::var_os("HEXCAST_MODELS").map(PathBuf::from));
    let mut cases = cases::cases(scratch, models.as_deref())?;
    cases.iter_mut().for_each(|case| case.axis = axis);
    cases.retain(|case| arguments.case.as_ref().is_none_or(|wanted| case.name.contains(wanted)));
    if let Some(cells) = arguments.cells {
        cases.iter_mut().for_each(|case| case.cells = cells);
        cases.dedup_by(|a, b| a.name == b.name);
    }
    Ok(cases)
}

/// Times the whole line and prints medians and every run.
fn whole_line(case: &Case, choice: BackendChoice, arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    let mut engine = pollster::block_on(Engine::open(choice, None))?;
    let first = line::run(case, &mut engine)?;
    let mut runs = Vec::new();
    for _ in 0..arguments.runs {
        runs.push(line::run(case, &mut engine)?.seconds);
    }
    if runs.is_empty() {
        runs.push(first.seconds);
    }
    let columns = &first.columns;
    let cells = columns.rays().n_rays() * u64::from(columns.rays().depth);
    let of = |part: fn(&line::Seconds) -> f64| line::median(runs.iter().map(part));
    let (to_columns, to_flags) = (of(line::Seconds::until_columns), of(line::Seconds::until_flags));
    println!(
        "{}",
        json!({
            "case": case.name, "n": case.cells, "backend": engine.backend(),
            "adapter": engine.adapter().map(|(name, driver)| format!("{name}, {driver}")),
            "dims": columns.dims(), "facets": first.n_facets, "cells": cells,
            "inside": cells - columns.cells_per_flag()[0],
            "crossings": columns.n_crossings(), "runs_of_cells": columns.n_runs(), "odd_rays": columns.odd_rays(),
            "to_columns_s": to_columns, "to_flags_s": to_flags,
            "to_flags_again_s": of(|s| s.until_columns() + s.flags_again),
            "to_flags_in_vec_s": of(|s| s.until_columns() + s.flags_in_vec),
            "to_bits_s": of(|s| s.until_columns() + s.bits), "bits_s": of(|s| s.bits),
            "cells_per_s": cells as f64 / to_flags, "crossings_per_s": columns.n_crossings() as f64 / of(|s| s.columns),
            "read_s": of(|s| s.read), "lines_s": of(|s| s.lines), "snap_s": of(|s| s.snap),
            "columns_s": of(|s| s.columns), "flags_s": of(|s| s.flags), "flags_again_s": of(|s| s.flags_again), "flags_in_vec_s": of(|s| s.flags_in_vec),
            "bytes_once_s": of(|s| s.bytes_once),
            "open_s": engine.seconds, "first": first.seconds, "runs": runs,
        })
    );
    if let Some(path) = &arguments.flags {
        std::fs::write(path, line::flags(columns)?)?;
    }
    Ok(())
}

/// Prints the seconds of every pass on both backends, and of the paper's gather.
fn every_pass(case: &Case, runs: u32) -> Result<(), Box<dyn Error>> {
    let (ready, _) = line::ready(case)?;
    let cast = Cast { frame: &ready.frame, rays: &ready.prepared.rays, rule: Rule::Parity };
    let gpu = pollster::block_on(Gpu::open(None))?;
    let cpu_passes = passes::least_disturbed(runs, || passes::of_cpu(&cast))?;
    let gpu_passes = passes::least_disturbed(runs, || passes::of_gpu(&gpu, &cast))?;
    println!(
        "{}",
        json!({
            "case": case.name, "n": case.cells,
            "cpu_passes": cpu_passes.passes, "deep_rows": gpu_passes.n_deep, "gpu_passes": gpu_passes.passes,
            "counts": passes::counts(&cast, gpu_passes.n_bands)?,
            "machine": machine::measure(),
            "naive_gather": naive_gather::compare(&gpu, &cast, runs)?,
        })
    );
    Ok(())
}
