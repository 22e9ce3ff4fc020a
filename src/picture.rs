//! Pictures of a mesh, PNG: slices through its cells, and its stair-step surface seen from outside.
//!
//! Mesh, cuts -> [`Picture`] by [`slices`]; mesh, direction -> [`Picture`] by [`view`]. Both draw from columns, so that no more cells are
//! looked at than a picture has pixels, in the world's proportions whatever the lines. Colours are those of the page, by flag.

mod canvas;
mod slices;
mod view;

pub use canvas::Picture;
pub use slices::{Cut, slices};
pub use view::{View, view};

use crate::mesh::Mesh;

/// Pixels around everything.
const MARGIN: u32 = 12;

/// The legend of some flags: their colours with number and name, ascending.
fn legend(mesh: &Mesh, mut flags: Vec<u8>) -> Vec<(u8, String)> {
    flags.sort_unstable();
    flags.dedup();
    let name = |flag: u8| mesh.names.iter().find(|named| named.flag == flag).map(|named| named.name.clone());
    let text = |flag| match name(flag) {
        Some(name) => format!("{flag} {name}"),
        None if flag == 0 => "0 background".into(),
        None => flag.to_string(),
    };
    flags.into_iter().map(|flag| (flag, text(flag))).collect()
}

/// A coordinate as text.
fn coordinate(mesh: &Mesh, value: f64) -> String {
    // as many digits as tell cells apart
    let longest = (0..3).map(|axis| {
        let [low, high] = [0, mesh.dims()[axis]].map(|index| mesh.lines.line(axis, index));
        (high - low) / f64::from(mesh.dims()[axis])
    });
    let least = longest.fold(f64::INFINITY, f64::min);
    let decimals = (2.0 - libm::log10(least)).ceil().clamp(0.0, 17.0) as usize;
    let text = format!("{value:.decimals$}");
    let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    let short = if short == "-0" { "0" } else { short };
    mesh.unit.as_ref().map_or(short.into(), |unit| format!("{short} {unit}"))
}
