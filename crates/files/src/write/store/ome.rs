//! What a store says in the words of OME-Zarr 0.5, so that viewers of volumes open it: its axes, its levels and where they lie, and the
//! names and colours of its flags.
//!
//! Lines of each level, names -> the attribute `ome` of the group. A place is that of the middle of a cell. Where cells differ in size, which the format does not have,
//! places are numbers of cells, and the description says so. Source: the specification of OME-Zarr 0.5, "multiscales" and "image-label".

use serde_json::{Value, json};

use crate::colours::colour;
use hexcast_core::base::length::Length;
use hexcast_core::grid::lines::Lines;
use hexcast_core::input::job::Levels;
use hexcast_derived::mesh::Named;

/// A level: the path of its array, its lines, and how many cells of the mesh one of its cells has along an axis.
pub(super) struct OmeLevel<'a> {
    pub(super) path: String,
    pub(super) lines: &'a Lines,
    pub(super) step: f64,
}

/// The attribute of a store whose array has this name.
pub(super) fn ome(
    array: &str,
    levels: &[OmeLevel<'_>],
    (names, unit): (Option<&[Named]>, Option<&str>),
    rule: Option<Levels>,
) -> Value {
    let is_graded = levels.first().is_some_and(|level| level.lines.is_graded());
    let unit = unit.filter(|_| !is_graded).and_then(Length::of_name).and_then(Length::udunits);
    let axis = |name: &str| match unit {
        Some(unit) => json!({ "name": name, "type": "space", "unit": unit }),
        None => json!({ "name": name, "type": "space" }),
    };
    let dataset = |level: &OmeLevel<'_>| {
        // the length of a cell along each axis, and the middle of the first
        let (scale, first) = match level.lines.spacing().filter(|_| !is_graded) {
            Some(spacing) => (spacing, [0, 1, 2].map(|axis| level.lines.centre(axis, 0))),
            None => ([level.step; 3], [(level.step - 1.0) / 2.0; 3]),
        };
        let transforms = json!([
            { "type": "scale", "scale": [scale[2], scale[1], scale[0]] },
            { "type": "translation", "translation": [first[2], first[1], first[0]] },
        ]);
        json!({ "path": level.path, "coordinateTransformations": transforms })
    };
    let mut image = json!({
        "name": array,
        "axes": [axis("z"), axis("y"), axis("x")],
        "datasets": levels.iter().map(dataset).collect::<Vec<Value>>(),
    });
    let mut told = Vec::new();
    if let Some(rule) = rule {
        image["type"] = json!(rule);
        told.push(described(rule));
    }
    if is_graded {
        told.push(
            "Cells differ in size: places are numbers of cells, and the arrays x, y and z have the middles of cells.",
        );
    }
    if !told.is_empty() {
        let method = concat!("hexcast ", env!("CARGO_PKG_VERSION"));
        image["metadata"] = json!({ "method": method, "description": told.join(" ") });
    }
    let mut all = json!({ "version": "0.5", "multiscales": [image] });
    if let Some(names) = names {
        all["image-label"] = label(names);
    }
    all
}

/// What a rule does, in a sentence.
fn described(rule: Levels) -> &'static str {
    match rule {
        Levels::Majority => {
            "A cell of a coarser level has the flag that most of its eight cells of the level before have, background too; of equal ones that of \
             the fewest cells."
        }
        _ => "A cell of a coarser level has the flag, of those in it, that has the fewest cells in the mesh.",
    }
}

/// Names and colours of flags.
fn label(names: &[Named]) -> Value {
    let mut names: Vec<&Named> = names.iter().collect();
    names.sort_by_key(|named| named.flag);
    let colour_of = |named: &&Named| {
        let [red, green, blue] = colour(named.flag);
        json!({ "label-value": named.flag, "rgba": [red, green, blue, 255] })
    };
    let name_of = |named: &&Named| json!({ "label-value": named.flag, "name": named.name });
    let [colours, properties]: [Vec<Value>; 2] =
        [names.iter().map(colour_of).collect(), names.iter().map(name_of).collect()];
    match names.is_empty() {
        true => json!({}),
        false => json!({ "colors": colours, "properties": properties }),
    }
}
