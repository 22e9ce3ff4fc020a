//! Pictures of a mesh, PNG: slices through its cells, and its stair-step surface seen from outside.
//!
//! Mesh, [`Slices`] -> [`Picture`] by [`slices()`]; mesh, [`View`] -> [`Picture`] by [`view()`]. Both read columns, and
//! no more cells than a picture has pixels. Proportions are those of the model, whatever the lines. Each flag has the colour
//! that it has on the page.
//! [`lines_svg`] draws the lines alone, before there is a mesh.

mod canvas;
mod lines;
mod look;
mod place;
mod png;
mod scene;
mod slices;
mod view;

pub use canvas::Picture;
pub use lines::lines_svg;
pub use look::Look;
pub use place::{Cut, Place};
pub use slices::{Slices, slices};
pub use view::{View, view};

#[doc(hidden)]
pub use {slices::slices_with_rests, view::view_with_rests};

use hexcast_core::base::error::{Error, Result};
use hexcast_derived::mesh::Mesh;

/// Pixels around everything.
const MARGIN: u32 = 12;

/// Refuses what takes more memory than is allowed.
fn check_memory(what: &str, n_bytes: u64, max_bytes: u64) -> Result<()> {
    if n_bytes <= max_bytes {
        return Ok(());
    }
    let message = format!("{what} takes {n_bytes} bytes of memory; {max_bytes} are allowed");
    Err(Error::new("memory", message, "ask for a smaller picture, or for fewer slices at once, or allow more memory"))
}

/// A coordinate as text.
fn coordinate(mesh: &Mesh, value: f64) -> String {
    // as many digits as tell cells apart
    let longest = (0..3).map(|axis| {
        let [low, high] = [0, mesh.dims()[axis]].map(|index| mesh.lines().line(axis, index));
        (high - low) / f64::from(mesh.dims()[axis])
    });
    let least = longest.fold(f64::INFINITY, f64::min);
    let decimals = (2.0 - libm::log10(least)).ceil().clamp(0.0, 17.0) as usize;
    let text = format!("{value:.decimals$}");
    let short = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    let short = if short == "-0" { "0" } else { short };
    mesh.unit().as_ref().map_or(short.into(), |unit| format!("{short} {unit}"))
}
