//! `hexcast convert`: a column file to any format.

use std::path::PathBuf;

use hexcast::control::{CancelToken, Control};
use hexcast::files::open_file;
use hexcast::job::{ByteSize, ZarrJob};
use hexcast::write::Format;
use hexcast::write::zarr::Place;
use hexcast::{Error, Result};
use indicatif::BinaryBytes;

use super::arguments::default_max_memory;
use super::outputs::{FormatArguments, Outputs, Targets};
use super::progress::Progress;
use super::reading::open_columns;
use super::summary::Table;

const EXAMPLES: &str = "\
Examples:
    hexcast convert part.hxc part.vti
    hexcast convert part.hxc part.raw --bits";

/// Convert a column file (.hxc) to .vti, .vtr, .npy, .npz, .raw, .zarr or .hxc; the same bytes as `hexcast mesh` would write
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// Column file
    #[arg(value_name = "IN.hxc")]
    input: PathBuf,
    /// Output, .vti, .vtr, .npy, .raw, .zarr or .hxc
    #[arg(value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    formats: FormatArguments,
    /// Most memory to take, such as 2GB or 512MiB; the columns stay in their file [default: 3/4 of what is available]
    #[arg(long, value_name = "SIZE", help_heading = "Memory")]
    max_memory: Option<ByteSize>,
    /// Print nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

pub(crate) fn run(arguments: &Arguments, token: &CancelToken) -> Result<()> {
    let max_bytes = arguments.max_memory.or_else(default_max_memory).map_or(u64::MAX, |size| size.0);
    // first: a missing input is the more useful message
    open_file(&arguments.input)?;
    let meshes = std::slice::from_ref(&arguments.output);
    let zarr = ZarrJob::default();
    let targets = Targets { meshes, doubt: None, report: None, zarr, is_part: false, has_archive: false };
    let mut outputs = Outputs::open(&targets, &arguments.formats, &[&arguments.input], max_bytes)?;
    if arguments.formats.hash.is_some() && outputs.flags_files().next().is_none_or(|format| format != Format::Raw) {
        let message = "--hash is given, but only the sidecar of a .raw has the hash";
        return Err(Error::new("job-conflict", message, "convert to .raw, or leave out --hash"));
    }
    let mut control = Control::default();
    control.cancel = token.clone();
    let progress = Progress::new(arguments.quiet);
    // the other half is for the outputs
    let mesh = open_columns(&arguments.input, max_bytes / 2, &control)?;
    let place = Place { whole: mesh.lines.clone(), first: [0; 3] };
    outputs.write(&mesh, &place, None, &control, progress)?;
    control.check()?;
    let files = outputs.finish("")?;
    if arguments.quiet {
        return Ok(());
    }
    let mut table = Table::default();
    let [nx, ny, nz] = mesh.dims();
    table.line("cells", format!("{nx} x {ny} x {nz}"));
    for file in files {
        table.line("written", format!("{} ({})", file.path.display(), BinaryBytes(file.n_bytes)));
    }
    super::terminal::print(&table.finish())
}
