//! `hexcast estimate`: what a mesh would cost, and its lines, without making it.

use std::path::{Path, PathBuf};

use hexcast::Result;
use hexcast::control::CancelToken;
use hexcast::estimate::{Allowed, Device, Estimate};
use hexcast::finding::sentences;
use hexcast::gpu::adapter;
use hexcast::job::{BackendChoice, Job};
use hexcast::picture::lines_svg;
use hexcast::pipeline::prepare;
use indicatif::{BinaryBytes, HumanCount};

use crate::files::{output_file::PendingFile, reading::read_job_files};
use crate::options::arguments::JobArguments;
use crate::screen::{
    memory,
    progress::Progress,
    summary::{Table, sizes, three},
    terminal,
};

const EXAMPLES: &str = "\
Examples:
    hexcast estimate part.stl --cells 4096
    hexcast estimate --job antenna.toml --max-cell-size 0.1 --json
    hexcast estimate board.stl patch.stl:metal=true --graded 2 -o lines.svg";

/// Show what a mesh would cost in cells, memory and bytes on disk, and draw its lines, without making it
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    job: JobArguments,
    /// Draw the lines of each axis with the boxes of all geometries, .svg
    #[arg(short, long, value_name = "LINES.svg", value_parser = picture)]
    output: Option<PathBuf>,
    /// Print the estimate as JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &Arguments, token: &CancelToken) -> Result<()> {
    let job = arguments.job.job()?;
    arguments.job.set_threads(job.max_memory)?;
    let output = arguments.output.as_deref().map(PendingFile::open).transpose()?;
    let sources = read_job_files(&job, token, Progress::new(false))?;
    let prepared = prepare(&job, sources)?;
    if let Some(mut file) = output {
        file.put(lines_svg(&prepared.lines, &prepared.geometries)?)?;
        file.persist()?;
    }
    let estimate = Estimate::new(&prepared.geometries, &prepared.lines, &prepared.rays);
    let estimate = estimate.with_unit(prepared.unit.as_deref());
    let device = device(&job, arguments.job.adapter.as_deref())?;
    let program_bytes = memory::program_bytes(device != Device::None);
    if arguments.json {
        // a struct of numbers always has a JSON form
        let mut json = serde_json::to_value(&estimate).unwrap_or_default();
        json["program_bytes"] = program_bytes.into();
        json["device_shares_memory"] = (device == Device::Shared).into();
        json["warnings"] = sentences(&prepared.notices).into();
        json["findings"] = serde_json::to_value(&prepared.notices).unwrap_or_default();
        return terminal::print_exact(&format!("{json:#}\n"));
    }
    let max_bytes = job.max_memory.map_or(u64::MAX, |size| size.0);
    let max_device_bytes = arguments.job.max_device_memory.map_or(u64::MAX, |size| size.0);
    let needed = |can_spill| {
        let allowed = Allowed::new(max_bytes).with_program_bytes(program_bytes);
        let allowed = allowed.with_rays(job.rule, prepared.geometries.len(), prepared.rays.depth);
        estimate.needed_bytes(&allowed.with_device(device, max_device_bytes).with_spill(can_spill))
    };
    let verdict = match (needed(false), needed(true)) {
        (Ok(needed), _) => format!("enough; {} would do", BinaryBytes(needed)),
        (_, Ok(needed)) => {
            format!("too little without --spill or --resume; with one of them {} would do", BinaryBytes(needed))
        }
        (_, Err(error)) => format!("too little: {error}"),
    };
    let mut table = in_words(&estimate, job.unit.as_deref());
    let what = if device == Device::None { "for the program" } else { "for the program and the driver" };
    table.line("memory", format!("plus about {} {what}", BinaryBytes(program_bytes)));
    if device == Device::Shared {
        table.line("memory", "buffers of this GPU are in the same memory, and bands are as small as it demands");
    }
    table.line("memory", format!("{} allowed: {verdict}", BinaryBytes(max_bytes)));
    terminal::print(&files(table, &estimate))?;
    prepared.notices.iter().for_each(terminal::warn_of);
    Ok(())
}

/// The name of a drawing.
fn picture(text: &str) -> std::result::Result<PathBuf, String> {
    let path = Path::new(text);
    let is_svg = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("svg"));
    if is_svg { Ok(path.into()) } else { Err("lines are drawn as .svg".into()) }
}

/// The device that would mesh.
fn device(job: &Job, wanted: Option<&str>) -> Result<Device> {
    if job.backend == BackendChoice::Cpu {
        return Ok(Device::None);
    }
    match pollster::block_on(adapter(wanted)) {
        Ok(facts) if facts.kind.shares_memory() => Ok(Device::Shared),
        Ok(_) => Ok(Device::Own),
        Err(_) if job.backend == BackendChoice::Auto && wanted.is_none() => Ok(Device::None),
        Err(error) => Err(error),
    }
}

fn in_words(estimate: &Estimate, unit: Option<&str>) -> Table {
    let mut table = Table::default();
    let [nx, ny, nz] = estimate.dims;
    let unit = unit.map_or(String::new(), |unit| format!(" {unit}"));
    let cells = HumanCount(estimate.cells);
    table.line(
        "cells",
        format!("{nx} x {ny} x {nz} = {cells}, {}{unit}", sizes(estimate.spacing, estimate.grading.as_ref())),
    );
    table.line("origin", format!("{}{unit}", three(estimate.origin)));
    table.line("facets", HumanCount(estimate.facets));
    table.line("rays", format!("{} along {}", HumanCount(estimate.rays), estimate.ray_axis));
    table.line("crossings", format!("about {}", HumanCount(estimate.crossings)));
    let (columns, host) = (BinaryBytes(estimate.column_bytes), BinaryBytes(estimate.host_bytes));
    table.line("memory", format!("about {host}, of which columns {columns}"));
    table.line("memory", format!("on a GPU at most about {}", BinaryBytes(estimate.device_bytes)));
    table
}

fn files(mut table: Table, estimate: &Estimate) -> String {
    let files = &estimate.file_bytes;
    table.line("files", format!(".raw {}, with --bits {}", BinaryBytes(files.raw), BinaryBytes(files.raw_bits)));
    table.line("files", format!(".npy {}, with --bits {}", BinaryBytes(files.npy), BinaryBytes(files.npy_bits)));
    let (vti, plain) = (BinaryBytes(files.vti_zlib), BinaryBytes(files.vti));
    // of cells that differ in size no .vti is written
    let image = if estimate.grading.is_some() { ".vtr" } else { ".vti" };
    table.line("files", format!("{image} about {vti}, with --compress=none {plain}"));
    let (hxc, plain) = (BinaryBytes(files.hxc_zlib), BinaryBytes(files.hxc));
    table.line("files", format!(".hxc about {hxc}, with --compress=none about {plain}"));
    table.finish()
}
