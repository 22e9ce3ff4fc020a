//! `hexcast convert`: a column file to any format.

use std::io::BufReader;
use std::path::PathBuf;

use hexcast::column_file::read_columns_within;
use hexcast::control::{CancelToken, Control};
use hexcast::{Error, Result};
use indicatif::BinaryBytes;

use super::outputs::{FormatArguments, Outputs};
use super::progress::Progress;
use super::reading::open_file;
use super::summary::Table;

const EXAMPLES: &str = "\
Examples:
    hexcast convert part.hxc part.vti
    hexcast convert part.hxc part.raw --bits";

/// Convert a column file (.hxc) to .vti, .npy, .raw, .zarr or .hxc; the same bytes as `hexcast mesh` would write
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// Column file
    #[arg(value_name = "IN.hxc")]
    input: PathBuf,
    /// Output, .vti, .npy, .raw, .zarr or .hxc
    #[arg(value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    formats: FormatArguments,
    /// Print nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

pub(crate) fn run(arguments: &Arguments, token: &CancelToken) -> Result<()> {
    let name = arguments.input.display();
    let failed = |error| Error::io(format!("reading {name}"), error);
    let file = open_file(&arguments.input)?;
    let mut outputs = Outputs::open(
        std::slice::from_ref(&arguments.output),
        None,
        &arguments.formats,
        &[&arguments.input],
        u64::MAX,
    )?;
    let n_bytes = file.metadata().map_err(failed)?.len();
    let mut control = Control::default();
    control.cancel = token.clone();
    let progress = Progress::new(arguments.quiet);
    let bar = progress.bytes("read", Some(n_bytes));
    let mut input = BufReader::with_capacity(1 << 20, bar.wrap_read(file));
    let mesh = read_columns_within(&mut input, u64::MAX, &control);
    bar.finish_and_clear();
    let mesh = mesh.map_err(|error| error.at(name))?;
    outputs.write(&mesh, &control, progress)?;
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
