//! `hexcast info`: what a surface file holds, and whether it is closed.

use std::path::Path;

use hexcast::control::Control;
use hexcast::error::Result;
use hexcast::geometry::{Facet, Geometry};
use hexcast::surface::{Surface, surface};
use serde_json::{Value, json};

use crate::args::InfoArgs;
use crate::inputs::read;
use crate::terminal::{grouped, three};

pub(crate) fn run(arguments: &InfoArgs) -> Result<()> {
    let facts: Vec<Value> = arguments.files.iter().map(|file| info(file)).collect::<Result<_>>()?;
    if arguments.json {
        println!("{}", serde_json::to_string_pretty(&facts).unwrap_or_default());
    } else {
        facts.iter().for_each(show);
    }
    Ok(())
}

fn info(file: &Path) -> Result<Value> {
    let (contents, sha256) = read(file, &Control::default())?;
    let solids: Vec<Value> =
        contents.solids.iter().map(|solid| json!({ "name": solid.name, "facets": solid.facets.len() })).collect();
    let facets: Vec<Facet> = contents.solids.into_iter().flat_map(|solid| solid.facets).collect();
    let checked: Surface = surface(&facets);
    let geometry = Geometry::new("", 1, facets);
    Ok(json!({
        "file": file.to_string_lossy(),
        "format": contents.format.name(),
        "bytes": contents.n_bytes,
        "sha256": sha256,
        "solids": solids,
        "facets": contents.n_facets,
        "bounding_box": geometry.bounding_box(),
        "volume": geometry.signed_volume(),
        "area": checked.area,
        "watertight": checked.watertight,
        "closed_oriented": checked.closed_oriented,
        "closed_parity": checked.closed_parity,
        "open_edges": checked.open_edges,
        "nonmanifold_edges": checked.nonmanifold_edges,
        "flipped_edges": checked.flipped_edges,
        "shells": checked.shells,
        "zero_area": checked.zero_area,
        "wrong_normals": contents.wrong_normals,
        "worst_open_edges": checked.worst_open_edges,
        "warnings": contents.warnings,
    }))
}

fn show(facts: &Value) {
    let number = |key: &str| facts[key].as_u64().unwrap_or_default();
    let line = |key: &str, value: String| println!("{key:>12}  {value}");
    println!("{}", facts["file"].as_str().unwrap_or_default());
    line("format", format!("{}, {} bytes", facts["format"].as_str().unwrap_or_default(), grouped(number("bytes"))));
    for solid in facts["solids"].as_array().into_iter().flatten().filter(|solid| solid["name"] != "") {
        line("solid", format!("{} ({} facets)", solid["name"].as_str().unwrap_or_default(), solid["facets"]));
    }
    line("facets", format!("{} ({} without area)", grouped(number("facets")), grouped(number("zero_area"))));
    let corner = |end: usize| three([0, 1, 2].map(|axis| facts["bounding_box"][end][axis].clone()), ", ");
    line("box", format!("{} to {}", corner(0), corner(1)));
    line("volume", format!("{} (area {})", facts["volume"], facts["area"]));
    line("shells", facts["shells"].to_string());
    line("closed", closed(facts));
    for edge in facts["worst_open_edges"].as_array().into_iter().flatten() {
        let end = |end: usize| three([0, 1, 2].map(|axis| edge[end][axis].clone()), ", ");
        line("open edge", format!("{} to {}", end(0), end(1)));
    }
    for warning in facts["warnings"].as_array().into_iter().flatten() {
        eprintln!("warning: {}", warning.as_str().unwrap_or_default());
    }
}

fn closed(facts: &Value) -> String {
    let edges = format!(
        "{} open, {} non-manifold, {} flipped edges",
        facts["open_edges"], facts["nonmanifold_edges"], facts["flipped_edges"]
    );
    if facts["watertight"] == true {
        return "yes".into();
    }
    match (facts["closed_oriented"] == true, facts["closed_parity"] == true) {
        (true, true) => format!("yes, for both rules ({edges})"),
        (true, false) => format!("yes, for the rule nonzero ({edges})"),
        (false, true) => format!("yes, for the rule parity ({edges})"),
        (false, false) => format!("no: {edges}"),
    }
}
