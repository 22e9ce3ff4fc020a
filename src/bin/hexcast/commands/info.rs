//! `hexcast info`: what files hold, and whether surfaces are closed; the report of column files.

use std::path::Path;
use std::process::ExitCode;

use hexcast::control::{CancelToken, Control};
use hexcast::geometry::{Geometry, SharedFacets};
use hexcast::job::ByteSize;
use hexcast::mesh::Mesh;
use hexcast::read::Conversion;
use hexcast::report::ColumnsReport;
use hexcast::sources::Source;
use hexcast::surface::{Surface, surface_within};
use hexcast::{Error, Result};
use indicatif::{BinaryBytes, HumanCount};
use serde_json::{Value, json};

use crate::files::{reading, standard_streams};
use crate::options::{arguments::default_max_memory, spelling::input_name};
use crate::screen::{
    memory,
    progress::Progress,
    summary::{self, Table, short, three},
    terminal,
};

const EXAMPLES: &str = "\
Examples:
    hexcast info part.stl
    hexcast info part.hxc
    hexcast info *.stl --json | jq '.[] | {file, watertight, open_edges}'";

/// Show what files hold: facets, solids, box and volume of surfaces, and whether they are closed; the report of column files
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// Surfaces (STL, OBJ, OFF, PLY, 3MF, GLB, also packed by gzip; STEP, IGES) and column files (.hxc), or - for standard input. After a file with an error the next ones are still shown
    #[arg(value_name = "FILE", required = true, value_parser = input_name())]
    files: Vec<String>,
    /// Print a JSON list with one object per file
    #[arg(long)]
    json: bool,
    /// Most memory to use, such as 2GB or 512MiB [default: 3/4 of the available memory]
    #[arg(long, value_name = "SIZE", help_heading = "Memory")]
    max_memory: Option<ByteSize>,
}

/// Most solids of a file that are listed for people.
const MAX_SOLIDS: usize = 20;

/// A file and what its facets form together.
struct Facts {
    source: Source,
    solids: Vec<(String, usize)>,
    bounding_box: Option<[[f64; 3]; 2]>,
    signed_volume: f64,
    surface: Surface,
}

/// What a file holds.
enum Found {
    Surface(Box<Facts>),
    /// Without a number of bytes from standard input.
    Columns {
        file: String,
        n_bytes: Option<u64>,
        mesh: Box<Mesh>,
    },
    Wrong {
        file: String,
        error: Error,
    },
}

pub(crate) fn run(arguments: &Arguments, token: &CancelToken) -> Result<ExitCode> {
    standard_streams::check_once(arguments.files.iter().map(Path::new))?;
    let max_memory = arguments.max_memory.or_else(default_max_memory);
    let found = rayon::scope(|_| found(&arguments.files, max_memory, token))?;
    if arguments.json {
        let list: Value = found.iter().map(in_json).collect();
        terminal::print_exact(&format!("{list:#}\n"))?;
    } else {
        let texts: Vec<String> = found.iter().filter_map(in_words).collect();
        terminal::print(&texts.join("\n"))?;
    }
    let errors: Vec<Error> = found.into_iter().filter_map(Found::into_error).collect();
    errors.iter().for_each(terminal::complain_of);
    // the first decides
    Ok(errors.first().map_or(ExitCode::SUCCESS, |error| ExitCode::from(terminal::exit_code(error))))
}

/// What the files hold, in their order; an error of one is no reason to leave out the others.
fn found(files: &[String], max_memory: Option<ByteSize>, token: &CancelToken) -> Result<Vec<Found>> {
    let max_bytes = max_memory.map_or(u64::MAX, |size| size.0);
    let mut found = Vec::new();
    for file in files {
        let read = if reading::is_columns(Path::new(file)) {
            columns(file, max_bytes, token)
        } else {
            let sources = reading::read_files(&[file], max_memory, token, Progress::new(false));
            let source = sources.and_then(|mut sources| sources.pop().ok_or(Error::Cancelled));
            source.and_then(|source| facts(source, max_bytes)).map(|facts| Found::Surface(Box::new(facts)))
        };
        match read {
            Err(Error::Cancelled) => return Err(Error::Cancelled),
            Err(error) => found.push(Found::Wrong { file: file.clone(), error }),
            Ok(read) => found.push(read),
        }
    }
    Ok(found)
}

impl Found {
    fn into_error(self) -> Option<Error> {
        if let Found::Wrong { error, .. } = self { Some(error) } else { None }
    }
}

/// Opens a column file, of which only the index is read to memory.
fn columns(file: &str, max_bytes: u64, token: &CancelToken) -> Result<Found> {
    let mut control = Control::default();
    control.cancel = token.clone();
    let mesh = Box::new(reading::open_columns(Path::new(file), max_bytes)?);
    let n_bytes = std::fs::metadata(file).ok().map(|metadata| metadata.len());
    Ok(Found::Columns { file: file.into(), n_bytes, mesh })
}

fn in_json(found: &Found) -> Value {
    match found {
        Found::Surface(facts) => surface_in_json(facts),
        Found::Wrong { file, error } => {
            json!({"file": file, "error": {"code": error.code(), "message": error.to_string(), "hint": error.hint()}})
        }
        Found::Columns { file, n_bytes, mesh } => {
            let mut report = json!({"file": file, "format": "column file", "bytes": n_bytes});
            if let (Some(facts), Ok(Value::Object(more))) =
                (report.as_object_mut(), serde_json::to_value(ColumnsReport::new(mesh)))
            {
                facts.extend(more);
            }
            report
        }
    }
}

/// The facts as text; those of a wrong file are its error, which goes to standard error.
fn in_words(found: &Found) -> Option<String> {
    match found {
        Found::Surface(facts) => Some(surface_in_words(facts)),
        Found::Columns { file, n_bytes, mesh } => Some(summary::of_columns(file, *n_bytes, &ColumnsReport::new(mesh))),
        Found::Wrong { .. } => None,
    }
}

/// Examines a surface, whose facets are not kept.
fn facts(mut source: Source, max_bytes: u64) -> Result<Facts> {
    let solids = std::mem::take(&mut source.contents.solids);
    let names = solids.iter().map(|solid| (solid.name.clone(), solid.facets.len())).collect();
    let facets = SharedFacets::join(&solids.into_iter().map(|solid| solid.facets).collect::<Vec<_>>());
    let limit = memory::limit(max_bytes);
    limit.take_held(facets.n_bytes(), "the facets as they were read")?.keep();
    let examined = facets.in_memory("the examination of its edges").and_then(|facets| surface_within(facets, &limit));
    let surface = examined.map_err(|error| error.at(&source.file))?;
    let geometry = Geometry::new(source.file.clone(), 1, facets)?;
    let (bounding_box, signed_volume) = (geometry.bounding_box(), geometry.signed_volume());
    Ok(Facts { solids: names, bounding_box, signed_volume, surface, source })
}

fn surface_in_json(facts: &Facts) -> Value {
    let Facts { source, solids, bounding_box, signed_volume, surface } = facts;
    let contents = &source.contents;
    let solids: Value = solids.iter().map(|(name, facets)| json!({"name": name, "facets": facets})).collect();
    json!({
        "file": source.file,
        "format": contents.format.name(),
        "unit": contents.unit,
        "bytes": contents.n_bytes,
        "blake3": source.blake3,
        "deviation": contents.conversion.as_ref().map(|of| of.deviation),
        "facets": contents.n_facets,
        "solids": solids,
        "bounding_box": bounding_box,
        "signed_volume": signed_volume,
        "area": surface.area,
        "shells": surface.shells,
        "watertight": surface.watertight,
        "closed_oriented": surface.closed_oriented,
        "closed_parity": surface.closed_parity,
        "open_edges": surface.open_edges,
        "nonmanifold_edges": surface.nonmanifold_edges,
        "flipped_edges": surface.flipped_edges,
        "worst_open_edges": surface.worst_open_edges,
        "zero_area": surface.zero_area,
        "collapsed": surface.collapsed,
        "wrong_normals": contents.wrong_normals,
        "zero_normals": contents.zero_normals,
        "has_colours": contents.has_colours,
        "warnings": contents.warnings,
    })
}

fn surface_in_words(facts: &Facts) -> String {
    let Facts { source, solids, bounding_box, signed_volume, surface } = facts;
    let contents = &source.contents;
    let mut table = Table::default();
    table.line("file", format!("{} ({})", source.file, BinaryBytes(contents.n_bytes)));
    let colours = if contents.has_colours { ", with colours" } else { "" };
    let unit = contents.unit.map_or(String::new(), |unit| format!(", in {unit}"));
    table.line("format", format!("{}{colours}{unit}", contents.format.name()));
    if let Some(Conversion { deviation, program, .. }) = &contents.conversion {
        let unit = contents.unit.unwrap_or_default();
        table.line("triangles", format!("at most {} {unit} from its surfaces, by {program}", short(*deviation)));
    }
    table.line("facets", HumanCount(contents.n_facets));
    for (name, n_facets) in solids.iter().filter(|(name, _)| solids.len() > 1 || !name.is_empty()).take(MAX_SOLIDS) {
        table.line("solid", format!("\"{name}\": {} facets", HumanCount(*n_facets as u64)));
    }
    if let Some(n_more @ 1..) = solids.len().checked_sub(MAX_SOLIDS) {
        table.line("solid", format!("{} more solids; --json lists all", HumanCount(n_more as u64)));
    }
    let [low, high] = bounding_box.unwrap_or_default();
    let extent = [0, 1, 2].map(|axis| high[axis] - low[axis]);
    table.line("box", format!("{} to {}, extent {}", three(low), three(high), three(extent)));
    let volume = *signed_volume;
    let remark = match (surface.closed_oriented, volume < 0.0) {
        (false, _) => " (of an open or inconsistent surface: it depends on the reference point)",
        (true, true) => " (negative: facets face inwards)",
        (true, false) => "",
    };
    let [cubic, square] = [3, 2].map(|power| contents.unit.map_or(String::new(), |unit| format!(" {unit}^{power}")));
    table.line("volume", format!("{}{cubic}{remark}", short(volume)));
    table.line("area", format!("{}{square}", short(surface.area)));
    table.line("shells", HumanCount(surface.shells));
    closedness(&mut table, surface);
    oddities(&mut table, facts);
    table.finish()
}

fn closedness(table: &mut Table, surface: &Surface) {
    let verdict = match (surface.watertight, surface.closed_oriented, surface.closed_parity) {
        (true, ..) => "yes: every edge joins two facets, all facets face the same way",
        (_, true, true) => "yes, but some edges join more than two facets; both rules are well defined",
        (_, true, _) => "for the rule nonzero only",
        (_, _, true) => "for the rule parity only: some facets face the wrong way",
        _ => "no",
    };
    table.line("closed", verdict);
    if surface.watertight {
        return;
    }
    let (open, flipped) = (HumanCount(surface.open_edges), HumanCount(surface.flipped_edges));
    let nonmanifold = HumanCount(surface.nonmanifold_edges);
    table
        .line("edges", format!("{open} open, {nonmanifold} of more than two facets, {flipped} between flipped facets"));
    for [from, to] in &surface.worst_open_edges {
        let [from, to] = [from, to].map(|corner| three(corner.map(f64::from)));
        table.line("open edge", format!("{from} to {to}"));
    }
}

fn oddities(table: &mut Table, facts: &Facts) {
    let contents = &facts.source.contents;
    let counts = [
        (facts.surface.zero_area, "facets have no area"),
        (contents.wrong_normals, "normals point against their corners; the corners count"),
        (contents.zero_normals, "normals are zero"),
    ];
    for (count, what) in counts.into_iter().filter(|(count, _)| *count > 0) {
        table.line("note", format!("{} {what}", HumanCount(count)));
    }
    contents.warnings.iter().for_each(|warning| table.line("warning", warning));
}
