//! `hexcast diff`: the cells in which two meshes have different flags.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use hexcast::Result;
use hexcast::control::{CancelToken, Control};
use hexcast::difference::{Difference, difference};
use hexcast::job::ByteSize;
use hexcast::mesh::Mesh;
use indicatif::{BinaryBytes, HumanCount};

use crate::files::{
    output::Meshed,
    output_file::OutputFile,
    outputs::{FormatArguments, Outputs, Targets},
    reading::{check_columns, open_columns},
    standard_streams::check_once,
};
use crate::options::arguments::default_max_memory;
use crate::screen::{progress::Progress, summary::Table};

const EXAMPLES: &str = "\
Examples:
    hexcast diff old.hxc new.hxc
    hexcast diff old.hxc new.hxc -o changed.vti

The exit code is 0 where all cells have the same flags, and 1 where some differ.";

/// Exit code where cells differ.
const DIFFERS: u8 = 1;

/// Compare two meshes cell by cell: how many differ, by pairs of flags, and where
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// Column file, or - for standard input
    #[arg(value_name = "A.hxc")]
    one: PathBuf,
    /// Column file with the same number of cells on each axis, or - for standard input
    #[arg(value_name = "B.hxc")]
    other: PathBuf,
    /// Write a mask, flag 1 where the two differ, .vti, .npy, .raw, .zarr or .hxc
    #[arg(short, long, value_name = "MASK")]
    output: Option<PathBuf>,
    #[command(flatten)]
    formats: FormatArguments,
    /// Print what was found as JSON
    #[arg(long)]
    json: bool,
    /// Most memory to use, such as 2GB or 512MiB [default: 3/4 of the available memory]
    #[arg(long, value_name = "SIZE", help_heading = "Memory")]
    max_memory: Option<ByteSize>,
}

pub(crate) fn run(arguments: &Arguments, token: &CancelToken) -> Result<ExitCode> {
    let max_bytes = arguments.max_memory.or_else(default_max_memory).map_or(u64::MAX, |size| size.0);
    let inputs: [&Path; 2] = [&arguments.one, &arguments.other];
    // first: a missing input is the more useful message
    inputs.iter().try_for_each(|input| check_columns(input))?;
    check_once(inputs.into_iter())?;
    let targets = Targets { meshes: arguments.output.as_slice(), ..Targets::default() };
    let mut outputs = Outputs::open(&targets, &arguments.formats, max_bytes)?;
    let mut control = Control::default();
    control.cancel = token.clone();
    // as much is for the mask, and the rest for its file
    let [one, other] = inputs.map(|input| open_columns(input, max_bytes / 4));
    let (one, other) = (one?, other?);
    let found = difference(&one, &other, max_bytes / 4, &control)?;
    let meshed = Meshed::new(&found.mask, &control, Progress::new(arguments.json));
    outputs.write_cells(&meshed)?;
    outputs.finish(&meshed, "")?;
    if arguments.json {
        // a struct of numbers always has a JSON form
        let json = serde_json::to_value(&found).unwrap_or_default();
        crate::screen::terminal::print_exact(&format!("{json:#}\n"))?;
    } else {
        crate::screen::terminal::print(&in_words(&found, &one, &other, &outputs.written.files))?;
    }
    let is_same = found.cells == 0 && found.are_lines_equal;
    Ok(if is_same { ExitCode::SUCCESS } else { ExitCode::from(DIFFERS) })
}

fn in_words(found: &Difference, one: &Mesh, other: &Mesh, files: &[OutputFile]) -> String {
    let mut table = Table::default();
    let n_cells = HumanCount(one.n_cells());
    match found.cells {
        0 => table.line("same", format!("all {n_cells} cells have the same flags")),
        cells => table.line("different", format!("{} of {n_cells} cells", HumanCount(cells))),
    }
    if !found.are_lines_equal {
        table.line("lines", "the two meshes have other lines; cells were compared by their indices".to_string());
    }
    for pair in &found.pairs {
        let [low, high] = pair.bounds.map(|[x, y, z]| format!("{x},{y},{z}"));
        let flags = format!("{} -> {}", named(one, pair.one), named(other, pair.other));
        table.line("", format!("{flags}: {} cells, in the box of cells {low} to {high}", HumanCount(pair.cells)));
    }
    for file in files {
        table.line("written", format!("{} ({})", file.path.display(), BinaryBytes(file.n_bytes)));
    }
    table.finish()
}

/// A flag with its name, if it has one.
fn named(mesh: &Mesh, flag: u8) -> String {
    match mesh.names().iter().find(|named| named.flag == flag) {
        Some(named) => format!("{flag} \"{}\"", named.name),
        None if flag == 0 => "0 background".into(),
        None => flag.to_string(),
    }
}
