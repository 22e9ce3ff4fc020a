//! `hexcast leak`: whether a path leads from one point to another, and where it is narrowest.

use std::fmt::Display;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use hexcast::control::{CancelToken, Control};
use hexcast::geometry::Geometry;
use hexcast::job::{ByteSize, GeometryJob, Job};
use hexcast::leak::{Answer, Leak, MAX_WIDTH, Narrowest, NearFacet, Question, leak};
use hexcast::mesh::Mesh;
use hexcast::sources::geometries;
use hexcast::write::leak_vtp;
use hexcast::{Error, Result};
use indicatif::{BinaryBytes, HumanCount};

use crate::files::{
    output_file::{OutputFile, PendingFile},
    reading::{check_columns, open_columns, read_job_files},
};
use crate::options::{
    arguments::{default_max_memory, list, number},
    job_files::read_job,
};
use crate::screen::{
    progress::Progress,
    summary::{Table, short, size, three},
};

const EXAMPLES: &str = "\
Examples:
    hexcast mesh case.stl --cells 500 --padding-cells 4 -o case.hxc
    hexcast leak case.hxc --from 0,0,0 --to 60,0,0
    hexcast leak case.hxc --from 0,0,0 --to 60,0,0 --surface case.stl -o path.vtp

The exit code is 0 where there is no path, and 9 where there is one.

The shortest path has the fewest steps from cell to cell through faces. The narrowest place is where the largest
cube that can pass still passes and a cube one cell wider does not; cells beyond the mesh count as background. If
there are two holes, the shortest path takes the nearer one and the cube the wider one: the output has both ways.
Part 0 of the output is the narrowest place, 1 the shortest path, 2 the way of the cube.";

/// Look for a path between two points of a mesh: the shortest one, and its narrowest place
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// Column file
    #[arg(value_name = "MESH.hxc")]
    mesh: PathBuf,
    /// Point at which paths begin, in the unit of the mesh
    #[arg(long, value_name = "X,Y,Z", value_parser = list::<f64, 3>, allow_hyphen_values = true)]
    from: [f64; 3],
    /// Point at which they end
    #[arg(long, value_name = "X,Y,Z", value_parser = list::<f64, 3>, allow_hyphen_values = true)]
    to: [f64; 3],
    /// Flags of cells that a path may use [default: that of the cell at --from]
    #[arg(long, value_name = "F,F,...", value_delimiter = ',', value_parser = number::<u8>)]
    flags: Vec<u8>,
    /// List the facets of this job's surfaces that lie within a cell of the narrowest place
    #[arg(long, value_name = "JOB.toml|JOB.json", conflicts_with = "surfaces")]
    job: Option<PathBuf>,
    /// List the facets of this STL file that lie within a cell of the narrowest place; place the
    /// file as in coil.stl:scale=2 if need be; may be given several times
    #[arg(id = "surfaces", long = "surface", value_name = "FILE")]
    surfaces: Vec<String>,
    /// Write the paths and the narrowest place as lines, .vtp, for ParaView
    #[arg(short, long, value_name = "OUT.vtp")]
    output: Option<PathBuf>,
    /// Print what was found as JSON
    #[arg(long)]
    json: bool,
    /// Most memory to use, such as 2GB or 512MiB [default: 3/4 of the available memory]
    #[arg(long, value_name = "SIZE", help_heading = "Memory")]
    max_memory: Option<ByteSize>,
}

/// Exit code where there is a path.
const LEAKS: u8 = 9;
/// Most facets of a geometry that are listed for people.
const MAX_FACETS: usize = 20;

pub(crate) fn run(arguments: &Arguments, token: &CancelToken) -> Result<ExitCode> {
    let max_memory = arguments.max_memory.or_else(default_max_memory);
    let max_bytes = max_memory.map_or(u64::MAX, |size| size.0);
    // first: a missing input is the more useful message
    check_columns(&arguments.mesh)?;
    let output = arguments.output.as_deref().map(open_output).transpose()?;
    let surfaces = read_surfaces(arguments, max_memory, token)?;
    let mut control = Control::default();
    control.cancel = token.clone();
    // the other half is for the open cells
    let mesh = open_columns(&arguments.mesh, max_bytes / 2)?;
    let question = Question::new(arguments.from, arguments.to)
        .with_flags(arguments.flags.clone())
        .with_max_bytes(max_bytes - max_bytes / 2);
    let found = leak(&mesh, &question, &control)?;
    let file = output.map(|file| write(file, &leak_vtp(&found))).transpose()?;
    let answer = Answer::new(found, &mesh, surfaces.as_deref())?;
    if arguments.json {
        // a struct of numbers always has a JSON form
        let json = serde_json::to_value(&answer).unwrap_or_default();
        crate::screen::terminal::print_exact(&format!("{json:#}\n"))?;
    } else {
        crate::screen::terminal::print(&in_words(&answer.leak, &mesh, answer.facets.as_deref(), file.as_ref()))?;
    }
    Ok(if answer.is_tight { ExitCode::SUCCESS } else { ExitCode::from(LEAKS) })
}

/// Opens a temporary file for the output.
fn open_output(path: &Path) -> Result<PendingFile> {
    if !path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("vtp")) {
        let message = format!("{}: paths are written to .vtp only", path.display());
        return Err(Error::new("job-value", message, "name a file that ends in .vtp"));
    }
    PendingFile::open(path)
}

fn write(mut file: PendingFile, text: &str) -> Result<OutputFile> {
    file.put(text)?;
    let path = file.path.clone();
    file.persist()?;
    Ok(OutputFile { path, n_bytes: text.len() as u64 })
}

/// Reads the surfaces in which facets are looked for; none where none are named.
fn read_surfaces(
    arguments: &Arguments,
    max_memory: Option<ByteSize>,
    token: &CancelToken,
) -> Result<Option<Vec<Geometry>>> {
    let mut job = match &arguments.job {
        Some(path) => read_job(path)?,
        None if arguments.surfaces.is_empty() => return Ok(None),
        None => {
            let surfaces = arguments.surfaces.iter();
            Job::new(surfaces.map(|file| GeometryJob::from_argument(file)).collect::<Result<_>>()?)
        }
    };
    job.max_memory = max_memory;
    job.validate()?;
    let sources = read_job_files(&job, token, Progress::new(arguments.json))?;
    geometries(&job, sources).map(Some)
}

fn in_words(found: &Leak, mesh: &Mesh, facets: Option<&[NearFacet]>, file: Option<&OutputFile>) -> String {
    let mut table = Table::default();
    let unit = mesh.unit().map_or(String::new(), |unit| format!(" {unit}"));
    let flags = joined(&found.flags);
    let plural = if found.flags.len() == 1 { "" } else { "s" };
    let [from, to] = [found.from, found.to].map(|end| cell(end.cell));
    match &found.path {
        None => {
            table.line("tight", format!("no path through flag{plural} {flags} leads from cell {from} to cell {to}"))
        }
        Some(path) => {
            table.line("leak", format!("a path through flag{plural} {flags} leads from cell {from} to cell {to}"));
            let steps = HumanCount(path.steps);
            table.line("shortest", format!("{steps} steps from cell to cell, length {}{unit}", short(path.length)));
        }
    }
    let [at_start, at_end] = [found.from, found.to].map(|end| HumanCount(end.n_cells));
    match found.path {
        None => table.line("reached", format!("{at_start} cells from the start, {at_end} from the end")),
        Some(_) => table.line("reached", format!("{at_start} cells from both")),
    }
    match &found.narrowest {
        Some(place) => narrowest(&mut table, place, mesh, &unit),
        None if found.path.is_some() => {
            table.line("widest", format!("a cube of {MAX_WIDTH} cells passes: no place on its way is narrow"));
        }
        None => {}
    }
    if let Some(facets) = facets.filter(|_| found.narrowest.is_some()) {
        list_facets(&mut table, facets);
    }
    if let Some(file) = file {
        table.line("written", format!("{} ({})", file.path.display(), BinaryBytes(file.n_bytes)));
    }
    table.finish()
}

fn narrowest(table: &mut Table, place: &Narrowest, mesh: &Mesh, unit: &str) {
    let (width, wider) = (place.width, place.width + 1);
    let plural = if width == 1 { "" } else { "s" };
    let [from, to] = place.bounds;
    let lengths = match mesh.lines().spacing() {
        Some(spacing) => size(spacing.map(|length| length * f64::from(width))),
        None => size([0, 1, 2].map(|axis| to[axis] - from[axis])),
    };
    table.line(
        "widest",
        format!("a cube of {width} cell{plural} passes, {lengths}{unit} wide; none of {wider} cells does"),
    );
    let [low, high] = place.cells;
    let (low, last) = (cell(low), cell(high.map(|end| end - 1)));
    table.line("narrowest", format!("at {}{unit}: cells {low} to {last}", three(place.centre)));
}

fn list_facets(table: &mut Table, facets: &[NearFacet]) {
    if facets.is_empty() {
        table.line("facets", "none within a cell of the narrowest place");
    }
    for of_geometry in facets.chunk_by(|one, other| one.geometry == other.geometry) {
        let numbers: Vec<usize> = of_geometry.iter().take(MAX_FACETS).map(|near| near.facet).collect();
        let n_more = of_geometry.len() - numbers.len();
        let more = if n_more > 0 { format!(" and {n_more} more; --json lists all") } else { String::new() };
        table.line("facets", format!("\"{}\": {}{more}", of_geometry[0].geometry, joined(&numbers)));
    }
}

fn cell([x, y, z]: [u32; 3]) -> String {
    format!("({x}, {y}, {z})")
}

fn joined(numbers: &[impl Display]) -> String {
    numbers.iter().map(|number| number.to_string()).collect::<Vec<String>>().join(", ")
}
