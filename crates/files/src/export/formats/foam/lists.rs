//! The lists of a `polyMesh`: their files, heads and numbers, in text or binary.

use crate::export::{layers::N_SIDES, output::Out, patches::Patches};
use hexcast_core::base::error::Result;

/// Names of the patches on the sides of the box.
pub(super) const SIDE_NAMES: [&str; N_SIDES] = ["xMin", "xMax", "yMin", "yMax", "zMin", "zMax"];
/// Most characters of a name.
pub(super) const LONGEST_NAME: usize = 60;
/// Greatest label of an OpenFOAM of 32 bits, which is the usual one.
pub(super) const MAX_LABEL: u64 = i32::MAX as u64;

/// The lists of a `polyMesh`.
pub(super) const PARTS: [&str; 6] = ["points", "faces", "owner", "neighbour", "boundary", "cellZones"];

pub(super) fn file_names(name: &str) -> Vec<String> {
    let is_case = name.to_ascii_lowercase().ends_with(".foam");
    let folder = if is_case { "constant/polyMesh" } else { name };
    let case = is_case.then(|| name.to_string());
    PARTS.iter().map(|part| format!("{folder}/{part}")).chain(case).collect()
}

pub(super) fn note(points: u64, cells: u64, faces: u64, internal: u64) -> String {
    format!("    note \"nPoints:{points} nCells:{cells} nFaces:{faces} nInternalFaces:{internal}\";\n")
}

pub(super) fn head(out: &mut Out, is_ascii: bool, (class, object): (&str, &str), note: &str) -> Result<()> {
    // patches are text in either form
    let format = if is_ascii || object == "boundary" { "ascii" } else { "binary" };
    out.text(format_args!(
        "FoamFile\n{{\n    version 2.0;\n    format {format};\n    arch \"LSB;label=32;scalar=64\";\n    class {class};\n{note}    \
         location \"constant/polyMesh\";\n    object {object};\n}}\n\n"
    ))
}

/// Begins a list of so many.
pub(super) fn list(out: &mut Out, is_ascii: bool, n: u64) -> Result<()> {
    let newline = if is_ascii { "\n" } else { "" };
    out.text(format_args!("{n}\n({newline}"))
}

/// Writes a number of a point, face or cell, at most [`MAX_LABEL`].
pub(super) fn put_label(out: &mut Out, is_ascii: bool, label: u64) -> Result<()> {
    if is_ascii { out.text(format_args!("{label}\n")) } else { out.put(&(label as i32).to_le_bytes()) }
}

/// Writes a patch.
pub(super) fn put_patch(out: &mut Out, (patches, patch): (&Patches<'_>, usize), n: u64, start: u64) -> Result<()> {
    let name = patches.name(patch);
    let kind = if patches.is_open(patch) { "patch" } else { "wall" };
    out.text(format_args!("{name}\n{{\n    type {kind};\n    nFaces {n};\n    startFace {start};\n}}\n"))
}
