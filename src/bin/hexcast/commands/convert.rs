//! `hexcast convert`: a column file to any format.

use std::path::PathBuf;

use hexcast::control::{CancelToken, Control};
use hexcast::cut::cut;
use hexcast::job::{ByteSize, PerAxis};
use hexcast::mesh::Mesh;
use hexcast::write::Format;
use hexcast::{Error, Result};
use indicatif::BinaryBytes;

use crate::files::{
    output::Meshed,
    outputs::{FormatArguments, Outputs, Targets},
    reading::{check_columns, open_columns},
};
use crate::options::arguments::{default_max_memory, list, per_axis};
use crate::screen::{progress::Progress, summary::Table, terminal};

const EXAMPLES: &str = "\
Examples:
    hexcast convert part.hxc part.vti
    hexcast convert part.hxc part.raw --bits
    hexcast convert pipe.hxc case/pipe.foam --unit mm --export-flags 1,2
    hexcast convert part.hxc closer.vti --window 0,0,400,512,512,600
    hexcast convert part.hxc preview.vti --stride 8
    hexcast convert part.hxc - --format npy | python3 plot.py";

/// Convert a column file (.hxc) to any format or solver, with the same bytes as `hexcast mesh` would write
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// Column file, or - for standard input
    #[arg(value_name = "IN.hxc")]
    input: PathBuf,
    /// Output, .vti, .vtr, .npy, .npz, .raw, .zarr, .zarr.zip, .hxc or the file of a solver as for `hexcast mesh`, or - for standard output with --format
    #[arg(value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    formats: FormatArguments,
    /// Unit of the lengths, such as mm, instead of the unit in the file
    #[arg(long, value_name = "UNIT")]
    unit: Option<String>,
    /// Only these cells: the first on each axis, and the end, exclusive
    #[arg(long, value_name = "I0,J0,K0,I1,J1,K1", value_parser = list::<u32, 6>, help_heading = "Cells")]
    window: Option<[u32; 6]>,
    /// Every n-th cell: a block of N cells along each axis becomes one cell, as large as the block, with the flag of the cell in its
    /// middle. Cells at the end that do not fill a block are left out
    #[arg(long, value_name = "N|NX,NY,NZ", value_parser = per_axis::<u32>, help_heading = "Cells")]
    stride: Option<PerAxis<u32>>,
    /// Most memory to use, such as 2GB or 512MiB; the columns stay in their file [default: 3/4 of the available memory]
    #[arg(long, value_name = "SIZE", help_heading = "Memory")]
    max_memory: Option<ByteSize>,
    /// Print nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

pub(crate) fn run(arguments: &Arguments, token: &CancelToken) -> Result<()> {
    let max_bytes = arguments.max_memory.or_else(default_max_memory).map_or(u64::MAX, |size| size.0);
    // first: a missing input is the more useful message
    check_columns(&arguments.input)?;
    let targets = Targets { meshes: std::slice::from_ref(&arguments.output), ..Targets::default() };
    let mut outputs = Outputs::open(&targets, &arguments.formats, max_bytes)?;
    if arguments.formats.hash.is_some() && arguments.formats.format_of(&arguments.output) != Ok(Format::Raw) {
        let message = "--hash is given, but only the sidecar of a .raw has the hash";
        return Err(Error::new("job-conflict", message, "convert to .raw, or leave out --hash"));
    }
    arguments.formats.check_whole()?;
    let mut control = Control::default();
    control.cancel = token.clone();
    let progress = Progress::new(arguments.quiet);
    // the other half is for the outputs
    let mesh = open_columns(&arguments.input, max_bytes / 2)?;
    let unit = arguments.unit.clone().or(mesh.unit().map(String::from));
    let mesh = mesh.with_unit(unit);
    let (mesh, left_out) = taken(arguments, mesh, max_bytes / 4, &control)?;
    let meshed = Meshed::new(&mesh, &control, progress);
    outputs.write_cells(&meshed)?;
    outputs.finish(&meshed, "")?;
    for warning in arguments.formats.merged(&mesh).into_iter().chain(outputs.written.warnings) {
        terminal::complain(&terminal::one_line(&format!("warning: {warning}")));
    }
    if arguments.quiet || outputs.has_standard_output {
        return Ok(());
    }
    let mut table = Table::default();
    let [nx, ny, nz] = mesh.dims();
    table.line("cells", format!("{nx} x {ny} x {nz}"));
    if left_out != [0; 3] {
        let [x, y, z] = left_out;
        table.line("left out", format!("{x}, {y} and {z} cells at the end of x, y and z, which do not fill a block"));
    }
    for file in outputs.written.files {
        table.line("written", format!("{} ({})", file.path.display(), BinaryBytes(file.n_bytes)));
    }
    terminal::print(&table.finish())
}

/// The cells that are asked for, and how many at the end of each axis do not fill a block.
fn taken(arguments: &Arguments, mesh: Mesh, max_bytes: u64, control: &Control) -> Result<(Mesh, [u32; 3])> {
    if arguments.window.is_none() && arguments.stride.is_none() {
        return Ok((mesh, [0; 3]));
    }
    let [nx, ny, nz] = mesh.dims();
    let [i0, j0, k0, i1, j1, k1] = arguments.window.unwrap_or([0, 0, 0, nx, ny, nz]);
    let cells = [i0..i1, j0..j1, k0..k1];
    let stride = arguments.stride.map_or([1; 3], PerAxis::each);
    let mesh = cut(&mesh, &cells, stride, max_bytes, control)?;
    Ok((mesh, [0, 1, 2].map(|axis| cells[axis].len() as u32 % stride[axis])))
}
