//! The sidecar of `.raw`: a JSON object that says what the bytes mean.
//!
//! One key a line. `lines` holds the coordinates of all mesh lines, n + 1 numbers an axis; an axis with more than
//! [`MAX_LINES`] equal cells has null there, and line i is `origin + i * spacing`, evaluated in f64. Where cells differ in size `spacing`
//! is null. All numbers parse back to
//! the same f64. `map` is there where bytes are not the flags: by flag what is written for it; `flags` and `flags_hash` speak of the flags.

use serde::Serialize;

use hexcast_core::cells::fingerprint::flags_hash;
use hexcast_core::grid::lines::Lines;
use hexcast_core::input::geometry::Material;
use hexcast_derived::mesh::Mesh;

use super::{AxisOrder, Options, Written};
use hexcast_core::cells::flags::row_bytes;

/// Most cells along an axis whose lines are listed: some 2 MB of text.
pub const MAX_LINES: u32 = 100_000;

/// Version of the sidecar; grows when the meaning of a key changes.
const VERSION: u64 = 1;

/// A value of the sidecar.
#[derive(Serialize)]
#[serde(untagged)]
enum Fact<'a> {
    Text(&'a str),
    Perhaps(Option<&'a str>),
    Number(u64),
    Dims([u32; 3]),
    Flags(Vec<Flag<'a>>),
    /// Numbers that are JSON already, on one line.
    #[serde(skip)]
    Numbers(String),
}

#[derive(Serialize)]
struct Flag<'a> {
    flag: usize,
    name: Option<&'a str>,
    cells: u64,
    #[serde(skip_serializing_if = "Material::is_empty")]
    material: Material,
}

/// Describes a `.raw` file: layout, dims, origin, spacing, lines, flags with names and cells, unit, SHA-256 if it was made,
/// the hash of the flags (`docs/flags_hash.md`) if the columns can be read.
pub fn sidecar_json(mesh: &Mesh, options: &Options, written: &Written) -> String {
    let [nx, ny, nz] = mesh.dims();
    let order = match options.axis_order {
        AxisOrder::Zyx => "x fastest, then y, then z: cell (x, y, z) is number x + nx * (y + ny * z)",
        AxisOrder::Xyz => "z fastest, then y, then x: cell (x, y, z) is number z + nz * (y + ny * x)",
    };
    let mut facts = vec![
        ("format", Fact::Text("hexcast raw")),
        ("version", Fact::Number(VERSION)),
        ("generator", Fact::Text(concat!("hexcast ", env!("CARGO_PKG_VERSION")))),
        ("dims", Fact::Dims([nx, ny, nz])),
        ("axis_order", Fact::Text(order)),
        ("dtype", Fact::Text(if options.bits { "bit" } else { "uint8" })),
    ];
    if options.bits {
        let order = "little: the first cell of a byte is its lowest bit; every row along x starts a byte";
        facts.extend([("row_bytes", Fact::Number(row_bytes(nx).into())), ("bit_order", Fact::Text(order))]);
    }
    if let Some(map) = &options.map {
        let changed = map.iter().enumerate().filter(|(flag, value)| *flag != usize::from(**value));
        let changed: Vec<String> = changed.map(|(flag, value)| format!("\"{flag}\":{value}")).collect();
        facts.push(("map", Fact::Numbers(format!("{{{}}}", changed.join(",")))));
    }
    let [x, y, z] = [0, 1, 2].map(|axis| lines(mesh.lines(), axis).map_or("null".into(), |lines| numbers(&lines)));
    let flags_hash = flags_hash(mesh.columns()).ok();
    facts.extend([
        ("unit", Fact::Perhaps(mesh.unit())),
        ("origin", Fact::Numbers(numbers(&mesh.lines().origin()))),
        ("spacing", Fact::Numbers(mesh.lines().spacing().map_or("null".into(), |spacing| numbers(&spacing)))),
        ("n_bytes", Fact::Number(written.n_bytes)),
        ("sha256", Fact::Perhaps(written.sha256.as_deref())),
        ("flags_hash", Fact::Perhaps(flags_hash.as_deref())),
        ("flags", Fact::Flags(flags(mesh))),
        ("lines", Fact::Numbers(format!("{{\"x\":{x},\"y\":{y},\"z\":{z}}}"))),
    ]);
    let text = |fact: &Fact| match fact {
        Fact::Numbers(text) => text.clone(),
        // numbers, strings and lists always have a JSON form
        fact => serde_json::to_string(fact).unwrap_or_default(),
    };
    let facts: Vec<String> = facts.iter().map(|(key, fact)| format!("  \"{key}\": {}", text(fact))).collect();
    format!("{{\n{}\n}}\n", facts.join(",\n"))
}

/// A list of numbers, finite ones, in the fewest digits that parse back to them.
fn numbers(list: &[f64]) -> String {
    let texts: Vec<String> = list.iter().map(|number| format!("{number:?}")).collect();
    format!("[{}]", texts.join(","))
}

/// The flags in use, with names, numbers of cells and materials; flag 0 where it has a name.
fn flags(mesh: &Mesh) -> Vec<Flag<'_>> {
    let cells = mesh.columns().cells_per_flag();
    let flag = |flag: usize| {
        let named = mesh.names().iter().find(|named| usize::from(named.flag) == flag);
        let material = named.map_or(Material::default(), |named| named.material);
        Flag { flag, name: named.map(|named| named.name.as_str()), cells: cells[flag], material }
    };
    let is_told = |fact: &Flag| (fact.flag > 0 && fact.cells > 0) || fact.name.is_some();
    (0..cells.len()).map(flag).filter(is_told).collect()
}

/// Coordinates of the mesh lines of an axis; none where they are too many.
pub(super) fn lines(lines: &Lines, axis: usize) -> Option<Vec<f64>> {
    let n = lines.dims()[axis];
    (n <= MAX_LINES || lines.is_graded()).then(|| lines.list(axis))
}
