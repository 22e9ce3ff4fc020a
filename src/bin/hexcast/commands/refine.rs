//! `hexcast refine`: cells that are fine where surfaces are.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use hexcast::control::{CancelToken, Control};
use hexcast::pipeline::Engine;
use hexcast::refine::{Refined, Refinement, refine};
use hexcast::write::{Compress, write_leaves};
use hexcast::{Error, Result};
use indicatif::HumanCount;
use serde_json::json;

use crate::files::{output_file::PendingFile, reading::read_finer_job_files};
use crate::options::arguments::{JobArguments, number};
use crate::options::format_arguments::{DEFAULT_COMPRESS, compression};
use crate::screen::{progress::Progress, terminal};

const EXAMPLES: &str = "\
Examples:
    hexcast refine part.stl --cells 64 --levels 3 -o leaves.npz
    hexcast refine case.stl coil.stl --levels 4 --level 1=2 --box 0,0,0,10,10,4=3 -o leaves.npz
    hexcast refine --job antenna.toml --levels 2 --json";

/// Halve cells along each axis, again and again, where surfaces are: an octree
///
/// Leaves that touch differ by one level at most. A leaf has the flag of the cell of the uniform mesh of its size.
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    job: JobArguments,
    /// How often cells are halved along each axis at surfaces: 0 to 16
    #[arg(long, value_name = "N", value_parser = number::<u8>)]
    levels: u8,
    /// Halve cells less often at the surfaces of a flag, such as 2=1; 0 for not at all. May be given several times
    #[arg(long, value_name = "FLAG=N", value_parser = level_of_flag)]
    level: Vec<(u8, u8)>,
    /// Halve cells so often at least in a box, such as 0,0,0,10,10,4=2, wherever surfaces are. May be given several times
    #[arg(long = "box", value_name = "X0,Y0,Z0,X1,Y1,Z1=N", value_parser = level_of_box)]
    boxes: Vec<([f64; 6], u8)>,
    /// Write the leaves to a file, .npz: level, i, j, k and flag of each, and the lines of level 0
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// zlib level of .npz, 1 (fast) to 9 (small), or none [default: 6]
    #[arg(long, value_name = "LEVEL", value_parser = compression)]
    compress: Option<Compress>,
    /// Print the numbers of leaves as JSON
    #[arg(long)]
    json: bool,
}

fn level_of_flag(text: &str) -> std::result::Result<(u8, u8), String> {
    let parsed = text.split_once('=').and_then(|(flag, level)| Some((flag.parse().ok()?, level.parse().ok()?)));
    parsed.ok_or_else(|| format!("\"{text}\" is not FLAG=N, such as 2=1"))
}

fn level_of_box(text: &str) -> std::result::Result<([f64; 6], u8), String> {
    let parsed = text.split_once('=').and_then(|(ends, level)| {
        let ends: Vec<f64> = ends.split(',').map(f64::from_str).collect::<std::result::Result<_, _>>().ok()?;
        Some((<[f64; 6]>::try_from(ends).ok()?, level.parse().ok()?))
    });
    parsed.ok_or_else(|| format!("\"{text}\" is not X0,Y0,Z0,X1,Y1,Z1=N, such as 0,0,0,10,10,4=2"))
}

pub(crate) fn run(arguments: &Arguments, token: &CancelToken) -> Result<()> {
    let job = arguments.job.job()?;
    arguments.job.set_threads(job.max_memory)?;
    let output = arguments.output.as_deref().map(open).transpose()?;
    let finer = f64::from(arguments.levels).exp2();
    let sources = read_finer_job_files(&job, finer, token, Progress::new(arguments.json))?;
    let mut control = Control::default();
    control.cancel = token.clone();
    let mut how = Refinement::new(arguments.levels);
    (how.level_of_flags, how.boxes) = (arguments.level.clone(), arguments.boxes.clone());
    let refined = pollster::block_on(async {
        let mut engine = Engine::open(job.backend, arguments.job.adapter.as_deref()).await?;
        refine(&job, &sources, &how, &mut engine, &control).await
    })?;
    refined.findings.iter().for_each(terminal::warn_of);
    if let Some(file) = output {
        let compress = arguments.compress.unwrap_or(DEFAULT_COMPRESS);
        file.fill(|out| write_leaves(&refined.octree, &refined.lines, compress, out))?;
        file.persist()?;
    }
    if arguments.json {
        return terminal::print_exact(&format!("{:#}\n", facts(&refined)));
    }
    terminal::print(&table(&refined))
}

fn open(path: &Path) -> Result<PendingFile> {
    if !path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("npz")) {
        let message = format!("{}: leaves are written to .npz only", path.display());
        return Err(Error::new("job-value", message, "name a file that ends in .npz"));
    }
    PendingFile::open(path)
}

/// Leaves of each level, and cells of the uniform mesh of the finest.
fn counts(refined: &Refined) -> (Vec<u64>, u64) {
    let tree = &refined.octree;
    let finest = tree.dims(tree.n_levels() - 1);
    ((0..tree.n_levels()).map(|level| tree.n_leaves(level)).collect(), finest.iter().map(|n| u64::from(*n)).product())
}

fn facts(refined: &Refined) -> serde_json::Value {
    let (leaves, uniform) = counts(refined);
    let levels = leaves.iter().enumerate().map(|(level, n)| json!({ "dims": refined.octree.dims(level), "leaves": n }));
    let sum: u64 = leaves.iter().sum();
    let warnings: Vec<&str> = refined.findings.iter().map(|finding| &finding.sentence[..]).collect();
    json!({ "levels": levels.collect::<Vec<_>>(), "leaves": sum, "uniform_cells": uniform, "warnings": warnings })
}

fn table(refined: &Refined) -> String {
    let (leaves, uniform) = counts(refined);
    let sum: u64 = leaves.iter().sum();
    let mut text = String::new();
    for (level, n) in leaves.iter().enumerate() {
        let [nx, ny, nz] = refined.octree.dims(level);
        text += &format!("level {level:<2}  {} leaves of {nx} x {ny} x {nz} cells\n", HumanCount(*n));
    }
    let part = 100.0 * sum as f64 / uniform as f64;
    text += &format!(
        "leaves    {}, {part:.3} % of the {} cells of the finest size\n",
        HumanCount(sum),
        HumanCount(uniform)
    );
    text
}
