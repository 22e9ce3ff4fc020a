//! `hexcast estimate`: what a mesh would cost, without making it.

use hexcast::Result;
use hexcast::control::CancelToken;
use hexcast::estimate::{Allowed, Estimate};
use hexcast::job::BackendChoice;
use hexcast::pipeline::prepare;
use indicatif::{BinaryBytes, HumanCount};

use super::arguments::JobArguments;
use super::progress::Progress;
use super::reading::read_job_files;
use super::summary::{Table, size, three};

const EXAMPLES: &str = "\
Examples:
    hexcast estimate part.stl --cells 4096
    hexcast estimate --job antenna.toml --max-cell-size 0.1 --json";

/// Tell what a mesh would cost in cells, memory and bytes on disk, without making it
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    job: JobArguments,
    /// Print the estimate as JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(arguments: &Arguments, token: &CancelToken) -> Result<()> {
    let job = arguments.job.job()?;
    arguments.job.set_threads()?;
    let sources = read_job_files(&job, token, Progress::new(false))?;
    let prepared = prepare(&job, sources)?;
    let estimate = Estimate::new(&prepared.geometries, &prepared.lines, &prepared.rays);
    if arguments.json {
        // a struct of numbers always has a JSON form
        return super::print(&format!("{}\n", serde_json::to_string_pretty(&estimate).unwrap_or_default()));
    }
    let max_bytes = job.max_memory.map_or(u64::MAX, |size| size.0);
    let on_gpu = job.backend != BackendChoice::Cpu;
    let fits = estimate.check(&Allowed { max_bytes, on_gpu, can_spill: false, flags: false }).is_ok();
    let verdict = if fits { "enough" } else { "too little without --spill or --resume" };
    let text = in_words(&estimate, job.unit.as_deref());
    super::print(&format!("{text}{:<11} {} allowed: {verdict}\n", "memory", BinaryBytes(max_bytes)))
}

fn in_words(estimate: &Estimate, unit: Option<&str>) -> String {
    let mut table = Table::default();
    let [nx, ny, nz] = estimate.dims;
    let unit = unit.map_or(String::new(), |unit| format!(" {unit}"));
    let cells = HumanCount(estimate.cells);
    table.line("cells", format!("{nx} x {ny} x {nz} = {cells}, each {}{unit}", size(estimate.spacing)));
    table.line("origin", format!("{}{unit}", three(estimate.origin)));
    table.line("facets", HumanCount(estimate.facets));
    table.line("rays", format!("{} along {}", HumanCount(estimate.rays), estimate.ray_axis));
    table.line("crossings", format!("about {}", HumanCount(estimate.crossings)));
    let (columns, host) = (BinaryBytes(estimate.column_bytes), BinaryBytes(estimate.host_bytes));
    table.line("memory", format!("about {host}, of which columns {columns}"));
    table.line("memory", format!("on a GPU at most about {}", BinaryBytes(estimate.device_bytes)));
    let files = &estimate.file_bytes;
    table.line("files", format!(".raw {}, with --bits {}", BinaryBytes(files.raw), BinaryBytes(files.raw_bits)));
    table.line("files", format!(".npy {}, with --bits {}", BinaryBytes(files.npy), BinaryBytes(files.npy_bits)));
    let (vti, plain) = (BinaryBytes(files.vti_zlib), BinaryBytes(files.vti));
    table.line("files", format!(".vti about {vti}, with --compress=none {plain}"));
    let (hxc, plain) = (BinaryBytes(files.hxc_zlib), BinaryBytes(files.hxc));
    table.line("files", format!(".hxc about {hxc}, with --compress=none about {plain}"));
    table.finish()
}
