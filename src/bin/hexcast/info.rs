//! `hexcast info`: what files hold and whether their surfaces are closed.

use hexcast::Result;
use hexcast::control::CancelToken;
use hexcast::geometry::{Geometry, SharedFacets};
use hexcast::sources::Source;
use hexcast::surface::{Surface, surface};
use indicatif::{BinaryBytes, HumanCount};
use serde_json::{Value, json};

use super::progress::Progress;
use super::reading::read_files;
use super::summary::{Table, three};

const EXAMPLES: &str = "\
Examples:
    hexcast info part.stl
    hexcast info *.stl --json | jq '.[] | {file, watertight, open_edges}'";

/// Tell what STL files hold: facets, solids, box, volume, and whether the surface is closed
#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// STL files
    #[arg(value_name = "FILE", required = true)]
    files: Vec<String>,
    /// Print a JSON list with one object a file
    #[arg(long)]
    json: bool,
}

/// A file and what its facets form together.
struct Facts {
    source: Source,
    solids: Vec<(String, usize)>,
    geometry: Geometry,
    surface: Surface,
}

pub(crate) fn run(arguments: &Arguments, token: &CancelToken) -> Result<()> {
    let files: Vec<&str> = arguments.files.iter().map(String::as_str).collect();
    let facts: Vec<Facts> = read_files(&files, token, Progress::new(false))?.into_iter().map(facts).collect();
    if arguments.json {
        let list: Value = facts.iter().map(in_json).collect();
        return super::terminal::print(&format!("{list:#}\n"));
    }
    let texts: Vec<String> = facts.iter().map(in_words).collect();
    super::terminal::print(&texts.join("\n"))
}

fn facts(mut source: Source) -> Facts {
    let solids = std::mem::take(&mut source.contents.solids);
    let names = solids.iter().map(|solid| (solid.name.clone(), solid.facets.len())).collect();
    let facets = SharedFacets::join(&solids.into_iter().map(|solid| solid.facets).collect::<Vec<_>>());
    let surface = surface(&facets);
    Facts { solids: names, geometry: Geometry::new(source.file.clone(), 1, facets), surface, source }
}

fn in_json(facts: &Facts) -> Value {
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

fn in_words(facts: &Facts) -> String {
    let Facts { source, solids, geometry, surface } = facts;
    let contents = &source.contents;
    let mut table = Table::default();
    table.line("file", format!("{} ({})", source.file, BinaryBytes(contents.n_bytes)));
    let colours = if contents.has_colours { ", with colours" } else { "" };
    table.line("format", format!("{}{colours}", contents.format.name()));
    table.line("facets", HumanCount(contents.n_facets));
    for (name, n_facets) in solids.iter().filter(|(name, _)| solids.len() > 1 || !name.is_empty()) {
        table.line("solid", format!("\"{name}\": {} facets", HumanCount(*n_facets as u64)));
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
