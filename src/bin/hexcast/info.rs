//! `hexcast info`: what files hold, and whether surfaces are closed; the report of column files.

use std::path::Path;

use hexcast::Result;
use hexcast::control::{CancelToken, Control};
use hexcast::geometry::{Geometry, SharedFacets};
use hexcast::mesh::Mesh;
use hexcast::report::ColumnsReport;
use hexcast::sources::Source;
use hexcast::surface::{Surface, surface};
use indicatif::{BinaryBytes, HumanCount};
use serde_json::{Value, json};

use super::arguments::default_max_memory;
use super::progress::Progress;
use super::summary::{Table, three};
use super::{reading, summary};

const EXAMPLES: &str = "\
Examples:
    hexcast info part.stl
    hexcast info part.hxc
    hexcast info *.stl --json | jq '.[] | {file, watertight, open_edges}'";

/// Show what files hold: of STL the facets, solids, box, volume, and whether the surface is closed; of column files the report
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// STL files and column files (.hxc)
    #[arg(value_name = "FILE", required = true)]
    files: Vec<String>,
    /// Print a JSON list with one object a file
    #[arg(long)]
    json: bool,
}

/// Most solids of a file that are listed for people.
const MAX_SOLIDS: usize = 20;

/// A file and what its facets form together.
struct Facts {
    source: Source,
    solids: Vec<(String, usize)>,
    geometry: Geometry,
    surface: Surface,
}

/// What a file holds.
enum Found {
    Surface(Box<Facts>),
    Columns { file: String, n_bytes: u64, mesh: Box<Mesh> },
}

pub(crate) fn run(arguments: &Arguments, token: &CancelToken) -> Result<()> {
    let is_columns = |file: &&str| reading::is_columns(Path::new(file));
    let files: Vec<&str> = arguments.files.iter().map(String::as_str).collect();
    let surfaces: Vec<&str> = files.iter().filter(|file| !is_columns(file)).copied().collect();
    let mut surfaces = reading::read_files(&surfaces, default_max_memory(), token, Progress::new(false))?.into_iter();
    let mut found = Vec::new();
    for file in files {
        found.extend(match is_columns(&file) {
            true => Some(columns(file, token)?),
            false => surfaces.next().map(facts).transpose()?.map(|facts| Found::Surface(Box::new(facts))),
        });
    }
    if arguments.json {
        let list: Value = found.iter().map(in_json).collect();
        return super::terminal::print_exact(&format!("{list:#}\n"));
    }
    let texts: Vec<String> = found.iter().map(in_words).collect();
    super::terminal::print(&texts.join("\n"))
}

/// Opens a column file, of which only the index is read to memory.
fn columns(file: &str, token: &CancelToken) -> Result<Found> {
    let mut control = Control::default();
    control.cancel = token.clone();
    let max_bytes = default_max_memory().map_or(u64::MAX, |size| size.0);
    let mesh = Box::new(reading::open_columns(Path::new(file), max_bytes, &control)?);
    let n_bytes = std::fs::metadata(file).map_or(0, |metadata| metadata.len());
    Ok(Found::Columns { file: file.into(), n_bytes, mesh })
}

fn in_json(found: &Found) -> Value {
    match found {
        Found::Surface(facts) => surface_in_json(facts),
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

fn in_words(found: &Found) -> String {
    match found {
        Found::Surface(facts) => surface_in_words(facts),
        Found::Columns { file, n_bytes, mesh } => summary::of_columns(file, *n_bytes, &ColumnsReport::new(mesh)),
    }
}

fn facts(mut source: Source) -> Result<Facts> {
    let solids = std::mem::take(&mut source.contents.solids);
    let names = solids.iter().map(|solid| (solid.name.clone(), solid.facets.len())).collect();
    let facets = SharedFacets::join(&solids.into_iter().map(|solid| solid.facets).collect::<Vec<_>>());
    let surface = surface(&facets);
    let geometry = Geometry::new(source.file.clone(), 1, facets)?;
    Ok(Facts { solids: names, geometry, surface, source })
}

fn surface_in_json(facts: &Facts) -> Value {
    let Facts { source, solids, geometry, surface } = facts;
    let contents = &source.contents;
    let solids: Value = solids.iter().map(|(name, facets)| json!({"name": name, "facets": facets})).collect();
    json!({
        "file": source.file,
        "format": contents.format.name(),
        "bytes": contents.n_bytes,
        "sha256": source.sha256,
        "facets": contents.n_facets,
        "solids": solids,
        "bounding_box": geometry.bounding_box(),
        "signed_volume": geometry.signed_volume(),
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
    let Facts { source, solids, geometry, surface } = facts;
    let contents = &source.contents;
    let mut table = Table::default();
    table.line("file", format!("{} ({})", source.file, BinaryBytes(contents.n_bytes)));
    let colours = if contents.has_colours { ", with colours" } else { "" };
    table.line("format", format!("{}{colours}", contents.format.name()));
    table.line("facets", HumanCount(contents.n_facets));
    for (name, n_facets) in solids.iter().filter(|(name, _)| solids.len() > 1 || !name.is_empty()).take(MAX_SOLIDS) {
        table.line("solid", format!("\"{name}\": {} facets", HumanCount(*n_facets as u64)));
    }
    if let Some(n_more @ 1..) = solids.len().checked_sub(MAX_SOLIDS) {
        table.line("solid", format!("{} more solids; --json lists all", HumanCount(n_more as u64)));
    }
    let [low, high] = geometry.bounding_box().unwrap_or_default();
    let extent = [0, 1, 2].map(|axis| high[axis] - low[axis]);
    table.line("box", format!("{} to {}, extent {}", three(low), three(high), three(extent)));
    let volume = geometry.signed_volume();
    let remark = match (surface.closed_oriented, volume < 0.0) {
        (false, _) => " (of an open or inconsistent surface: it depends on the reference point)",
        (true, true) => " (negative: facets face inwards)",
        (true, false) => "",
    };
    table.line("volume", format!("{volume}{remark}"));
    table.line("area", surface.area);
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
