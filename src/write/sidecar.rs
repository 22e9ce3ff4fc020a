//! The sidecar of `.raw`: a JSON object that says what the bytes mean.
//!
//! One key a line. `lines` holds the coordinates of all mesh lines, n + 1 numbers an axis; an axis with more than
//! [`MAX_LINES`] cells has null there, and line i is `origin + i * spacing`, evaluated in f64. All numbers parse back to
//! the same f64.

use serde_json::{Value, json};

use crate::mesh::Mesh;

use super::{Options, Written, bits};

/// Most cells along an axis whose lines are listed: some 2 MB of text.
pub const MAX_LINES: u32 = 100_000;

/// Version of the sidecar; grows when the meaning of a key changes.
const VERSION: u32 = 1;

/// Describes a `.raw` file: layout, dims, origin, spacing, lines, flags with names and cells, unit, SHA-256.
pub fn sidecar_json(mesh: &Mesh, options: &Options, written: &Written) -> String {
    let [nx, ny, nz] = mesh.dims();
    let mut entries = vec![
        ("format", json!("hexcast raw")),
        ("version", json!(VERSION)),
        ("generator", json!(concat!("hexcast ", env!("CARGO_PKG_VERSION")))),
        ("dims", json!([nx, ny, nz])),
        ("axis_order", json!("x fastest, then y, then z: cell (x, y, z) is number x + nx * (y + ny * z)")),
        ("dtype", json!(if options.bits { "bit" } else { "uint8" })),
    ];
    if options.bits {
        entries.push(("row_bytes", json!(bits::row_bytes(nx))));
        entries.push((
            "bit_order",
            json!("little: the first cell of a byte is its lowest bit; every row along x starts a byte"),
        ));
    }
    entries.extend([
        ("unit", json!(mesh.unit)),
        ("origin", json!(mesh.lines.origin)),
        ("spacing", json!(mesh.lines.spacing)),
        ("n_bytes", json!(written.n_bytes)),
        ("sha256", json!(written.sha256)),
        ("flags", flag_entries(mesh)),
        ("lines", json!({"x": lines(mesh, 0), "y": lines(mesh, 1), "z": lines(mesh, 2)})),
    ]);
    let entries: Vec<String> = entries.iter().map(|(key, value)| format!("  \"{key}\": {value}")).collect();
    format!("{{\n{}\n}}\n", entries.join(",\n"))
}

/// The flags in use, with names and numbers of cells.
pub(super) fn flag_entries(mesh: &Mesh) -> Value {
    let cells = mesh.columns.cells_per_flag();
    let name = |flag| mesh.names.iter().find(|named| usize::from(named.flag) == flag).map(|named| named.name.as_str());
    let used = (1..cells.len()).filter(|&flag| cells[flag] > 0 || name(flag).is_some());
    used.map(|flag| json!({"flag": flag, "name": name(flag), "cells": cells[flag]})).collect()
}

/// Coordinates of the mesh lines of an axis; none where they are too many.
pub(super) fn lines(mesh: &Mesh, axis: usize) -> Option<Vec<f64>> {
    let n = mesh.dims()[axis];
    (n <= MAX_LINES).then(|| (0..=n).map(|index| mesh.lines.line(axis, index)).collect())
}
