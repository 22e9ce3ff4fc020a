//! What the package says of every format, as `docs/formats.json`: all of it is asked of the writers.

use serde_json::{Map, Value, json};

use super::*;
use crate::write::{self, Compress, Format, Options};
use hexcast_core::testing::assert_schema_is_committed;

const FACTS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/formats.json");
/// What the package calls the files of what a job asks for besides the cells.
const MEASURED: [&str; 17] = [
    "links.npz",
    "links.h5",
    "links",
    "staggered.npz",
    "conformal.npz",
    "distance.npz",
    "distance.vti",
    "distance.vtr",
    "distance.npy",
    "distance.h5",
    "distance.zarr",
    "tensors.npz",
    "fractions.npz",
    "fractions.vti",
    "fractions.vtr",
    "fractions.npy",
    "fractions.zarr",
];

fn media_type(ending: &str) -> &'static str {
    match ending.rsplit('.').next().unwrap_or_default() {
        "vti" => "application/vnd.vtk.vti+xml",
        "vtr" => "application/vnd.vtk.vtr+xml",
        "zarr" | "zip" => "application/zip",
        "xml" => "application/xml",
        "h5" => "application/x-hdf5",
        _ => "application/octet-stream",
    }
}

/// A name of the package as one of the library: a store is one file there.
fn format_of(name: &str) -> Option<Format> {
    let ending = name.rsplit('.').next()?;
    Format::of_name(&format!("mesh.{}", if ending == "zarr" { "zarr.zip" } else { ending })).ok()
}

fn row(kind: &str, media: &str, compresses: bool, spacing: &str) -> Value {
    json!({ "kind": kind, "type": media, "compresses": compresses, "ascii": false, "unit": false, "spacing": spacing })
}

/// Facts of a file of the mesh, or of numbers of its cells.
fn of_cells(kind: &str, name: &str) -> Value {
    // records of links and HDF5 have writers of their own
    let Some(format) = format_of(name) else {
        return row(kind, media_type(name), name.ends_with(".h5"), "any");
    };
    let options = Options { compress: Compress::Zlib(6), ..Options::default() };
    let compresses = write::exact_size(&pattern(0, DIMS, 3), format, &options).is_none();
    let is_equal = write::check_lines(&graded(), format).is_err();
    row(kind, media_type(name), compresses, if is_equal { "equal" } else { "any" })
}

fn graded() -> Lines {
    Lines::from_lists([vec![0.0, 1.0, 3.0], vec![0.0, 1.0, 2.0], vec![0.0, 1.0, 2.0]]).unwrap()
}

fn of_exporter(exporter: Exporter, ending: &str) -> Value {
    let has_several = exporter.file_names(&format!("mesh{ending}")).len() > 1;
    let media = if has_several { "application/zip" } else { media_type(ending) };
    let bricks = pattern(0, DIMS, 3).lines().clone();
    let spacing = match (exporter.check_lines(&graded()), exporter.check_lines(&bricks)) {
        (Ok(()), Ok(())) => "any",
        (Err(_), Ok(())) => "equal",
        _ => "cubes",
    };
    let mut facts = row("export", media, exporter.compresses() || has_several, spacing);
    facts["ascii"] = exporter.has_ascii().into();
    facts["unit"] = exporter.check_unit(None).is_err().into();
    facts["program"] = exporter.program().into();
    facts["about"] = exporter.about().into();
    // an ending without a dot is a whole name; several files are one archive in the package
    let name = if ending.starts_with('.') { "NAME" } else { "" };
    facts["file"] = format!("{name}{ending}{}", if has_several { ".zip" } else { "" }).into();
    facts
}

#[test]
fn the_facts_of_formats_are_those_of_the_writers() {
    let mut facts = Map::new();
    for name in ["vti", "vtr", "npy", "npz", "raw", "hxc", "zarr"] {
        facts.insert(name.into(), of_cells("cells", name));
    }
    for name in MEASURED {
        facts.insert(name.into(), of_cells("measured", name));
    }
    for exporter in Exporter::ALL {
        let (ending, _) = Exporter::ENDINGS.into_iter().find(|(_, other)| *other == exporter).unwrap();
        facts.insert(ending.trim_start_matches('.').into(), of_exporter(exporter, ending));
    }
    assert_schema_is_committed(FACTS, &Value::Object(facts), "the_facts_of_formats");
}
