//! `hexcast parts`: the windows that a mesh can be divided into.

use hexcast::control::CancelToken;
use hexcast::job::{ZarrJob, numbers_of_parts};
use hexcast::parts::parts;
use hexcast::pipeline::{part_step, prepare};
use hexcast::{Error, Result};
use serde::Serialize;

use crate::files::reading::read_job_files;
use crate::options::arguments::JobArguments;
use crate::screen::progress::Progress;

const EXAMPLES: &str = "\
Examples:
    hexcast parts --job ship.toml --n 64
    hexcast parts ship.stl --cells 4000 --n 4x4x4";

/// Divide a mesh into windows that take about the same time, and print them as JSON; `hexcast mesh --part K/N` meshes one
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    #[command(flatten)]
    job: JobArguments,
    /// Number of slabs across z, or of parts along x, y and z
    #[arg(long, value_name = "N|NXxNYxNZ", value_parser = numbers)]
    n: Numbers,
    /// Cut along the borders of the shards of a Zarr store, as `mesh --part K/N -o OUT.zarr` does
    #[arg(long)]
    zarr: bool,
}

/// Numbers of parts along x, y and z.
#[derive(Clone, Copy)]
struct Numbers([u32; 3]);

#[derive(Serialize)]
struct Part {
    /// What `--part` takes.
    part: String,
    /// What `--window` takes.
    window: [u32; 6],
    cells: u64,
}

#[derive(Serialize)]
struct Parts {
    /// Number of cells on x, y, z.
    dims: [u32; 3],
    parts: Vec<Part>,
}

fn numbers(text: &str) -> std::result::Result<Numbers, String> {
    let wrong =
        || format!("\"{text}\" is not a number of parts: a number such as 64 is needed, or three such as 4x4x4");
    numbers_of_parts(text).map(Numbers).ok_or_else(wrong)
}

pub(crate) fn run(arguments: &Arguments, token: &CancelToken) -> Result<()> {
    let Numbers(of) = arguments.n;
    let mut job = arguments.job.job()?;
    if job.window.is_some() || job.part.is_some() {
        let message = "the job has a window or a part, and hexcast parts divides whole meshes";
        return Err(Error::new("job-conflict", message, "remove window and part"));
    }
    arguments.job.set_threads(job.max_memory)?;
    let zarr = job.zarr.or(arguments.zarr.then(ZarrJob::default));
    let sources = read_job_files(&job, token, Progress::new(false))?;
    // the limit on cells is for those that are meshed
    job.max_cells = None;
    let prepared = prepare(&job, sources)?;
    let step = part_step(zarr.as_ref(), &prepared.whole)?;
    let windows = parts(&prepared.geometries, &prepared.whole, &prepared.rays, of, step)?;
    let [nx, ny, nz] = of;
    let part = |(index, [first, end]): (usize, [[u32; 3]; 2])| Part {
        part: if [nx, ny] == [1, 1] { format!("{}/{nz}", index + 1) } else { format!("{}/{nx}x{ny}x{nz}", index + 1) },
        window: [first[0], first[1], first[2], end[0], end[1], end[2]],
        cells: (0..3).map(|axis| u64::from(end[axis] - first[axis])).product(),
    };
    let parts = Parts { dims: prepared.whole.dims(), parts: windows.into_iter().enumerate().map(part).collect() };
    // structs of numbers and names always have a JSON form
    let json = serde_json::to_string_pretty(&parts).unwrap_or_default();
    crate::screen::terminal::print_exact(&format!("{json}\n"))
}
