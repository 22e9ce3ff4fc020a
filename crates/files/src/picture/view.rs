//! Views: the stair-step surface of a mesh from a direction, in parallel projection.
//!
//! The rectangles of the skin that face the eye are a [`Scene`]. Bands of its rows are drawn one after another, some at a time on several
//! cores.
//! Cost: O(rectangles) a band of rows, and O(pixels) a rectangle that is seen; memory for rectangles, pixels, and the points of some bands.

use std::ops::Range;

use super::canvas::{LINE, PIXEL_BYTES, Picture, check_sides, legend_height};
use super::scene::{FINE, ROWS, Scene};
use super::{Look, MARGIN, check_memory, coordinate};
use hexcast_core::base::control::{Control, at_once};
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::parallel::*;
use hexcast_core::cells::flags::CellBox;
use hexcast_derived::mesh::Mesh;
use hexcast_derived::skin::{Skin, check_box, skin_with_rests};

/// Pixels of the longer side where nobody says.
const SIZE: u32 = 1000;
/// Most rectangles; a mesh of more is drawn with coarser cells.
const MAX_QUADS: usize = 4_000_000;
/// Most bytes of a rectangle: in the skin, and as it is seen.
const QUAD_BYTES: u64 = 176;

/// From where, and what of it is seen.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct View {
    /// Direction to the eye, in degrees: around z from x, and up from the plane of x and y.
    pub direction: [f64; 2],
    /// Cells that are shown; all if None.
    pub cells: Option<CellBox>,
    /// Size, flags and colours.
    pub look: Look,
}

impl Default for View {
    fn default() -> View {
        View { direction: [-60.0, 25.0], cells: None, look: Look::default() }
    }
}

impl View {
    /// Looks from a direction: degrees around z from x, and up from the plane of x and y.
    pub fn with_direction(mut self, direction: [f64; 2]) -> View {
        self.direction = direction;
        self
    }

    /// Shows a box of cells only.
    pub fn with_cells(mut self, cells: CellBox) -> View {
        self.cells = Some(cells);
        self
    }

    /// Sets how it looks.
    pub fn with_look(mut self, look: Look) -> View {
        self.look = look;
        self
    }

    /// Refuses what [`view()`] would refuse of every mesh of so many cells on x, y and z, and a picture for which there is no room
    /// where what is seen is as high as it is wide.
    ///
    /// # Errors
    /// `job-value` and `memory` as for [`view()`].
    pub fn check(&self, dims: [u32; 3]) -> Result<()> {
        if !self.direction.iter().all(|angle| angle.is_finite()) {
            let message = format!("a view from {:?} degrees cannot be drawn", self.direction);
            return Err(Error::new("job-value", message, "give two finite angles"));
        }
        check_sides([self.size(); 2])?;
        let side = u64::from(self.size());
        check_memory(&format!("a view of {side} x {side} pixels"), PIXEL_BYTES * side * side, self.look.max_bytes)?;
        self.cells.iter().try_for_each(|cells| check_box(cells, dims))
    }

    fn size(&self) -> u32 {
        self.look.size.unwrap_or(SIZE)
    }
}

/// Draws the surface of a mesh, with a legend of the flags on it.
///
/// # Errors
/// `job-value` where the picture would have no pixel or more than 32,768 on a side, the cells are not those of the mesh, or none of them has
/// a flag that is shown; `memory` where it takes more than is allowed; `io` where the columns are in a store that fails; `cancelled`.
pub fn view(mesh: &Mesh, view: &View, control: &Control) -> Result<Picture> {
    at_once(view_with_rests(mesh, view, &control.without_pauses()))
}

/// Like [`view()`], with a rest every some rows of the mesh and of pixels ([`Control::rest`]).
///
/// # Errors
/// Those of [`view()`].
pub async fn view_with_rests(mesh: &Mesh, view: &View, control: &Control) -> Result<Picture> {
    view.check(mesh.dims())?;
    let (look, size) = (&view.look, view.size());
    let skin = skin_within(mesh, view, control).await?;
    let mut scene = Scene::new(mesh, &skin, view.direction, control).await?;
    let (texts, step) = (descriptions(mesh, view, &skin), skin.step);
    drop(skin);
    let extent = scene.extent();
    let pixels = f64::from(size) / extent.x.max(extent.y);
    let [width, height] = [extent.x, extent.y].map(|length| (length * pixels).round().max(1.0) as u32);
    scene.show(look, [width, height], pixels)?;
    let deep = extent.z / f64::from(mesh.dims().into_iter().max().unwrap_or(1)) * f64::from(step);
    let held = QUAD_BYTES * scene.n_quads() as u64 + scene.band_bytes();
    let whole = width.max(320) + 2 * MARGIN;
    let below = MARGIN + height + MARGIN;
    // without the texts, whose height follows from what is seen
    let mut picture = Picture::new(whole, below, look.max_bytes.saturating_sub(held))?;
    let left = look.max_bytes.saturating_sub(held + picture.n_bytes());
    let n_at_once = (left / scene.band_bytes()).clamp(1, current_num_threads() as u64) as usize;
    // used again for the next bands: cores would keep what they free
    let mut memory = vec![Vec::new(); n_at_once];
    let mut has = [false; 256];
    let colours = look.colours();
    let bands: Vec<Range<usize>> =
        (0..scene.fine[1]).step_by(ROWS).map(|start| start..(start + ROWS).min(scene.fine[1])).collect();
    for bands in bands.chunks(n_at_once) {
        let seen = scene.between(bands[0].start..bands[bands.len() - 1].end + 1);
        let drawn: Vec<(Vec<[u8; 3]>, [bool; 256])> =
            bands.par_iter().zip(&mut memory).map(|band| scene.pixels(&seen, band, deep, &colours)).collect();
        for (rows, (pixels, of_band)) in bands.iter().zip(drawn) {
            for (at, rgb) in (0..).zip(pixels) {
                picture.set(MARGIN + at % width, MARGIN + rows.start as u32 / FINE + at / width, rgb);
            }
            (0..256).for_each(|flag| has[flag] |= of_band[flag]);
        }
        control.rest().await?;
    }
    let legend = look.legend(mesh, &has);
    picture.grow(2 * LINE + legend_height(whole, &legend) + MARGIN)?;
    for (index, text) in (0..).zip(&texts) {
        picture.text([MARGIN, below + index * LINE], text, whole - 2 * MARGIN);
    }
    picture.legend(below + 2 * LINE, &legend);
    Ok(picture)
}

/// The surface, within the memory that is allowed.
async fn skin_within(mesh: &Mesh, view: &View, control: &Control) -> Result<Skin> {
    let max_bytes = view.look.max_bytes;
    let max_quads = MAX_QUADS.min(usize::try_from(max_bytes / QUAD_BYTES).unwrap_or(MAX_QUADS));
    let skin = skin_with_rests(mesh, max_quads, view.cells.clone(), control).await?;
    // coarser because of the memory, or would be
    if max_quads < MAX_QUADS && skin.step > 1 {
        check_memory("the surface", QUAD_BYTES * MAX_QUADS as u64, max_bytes)?;
    }
    Ok(skin)
}

/// What is written below the picture.
fn descriptions(mesh: &Mesh, view: &View, skin: &Skin) -> [String; 2] {
    let [nx, ny, nz] = mesh.dims();
    let [around, up] = view.direction;
    let length = |axis: usize| {
        let [low, high] = [0, mesh.dims()[axis]].map(|index| mesh.lines().line(axis, index));
        coordinate(mesh, high - low)
    };
    let coarse = if skin.step == 1 { String::new() } else { format!(", drawn in cells of {}", skin.step) };
    let size = format!("{} x {} x {}", length(0), length(1), length(2));
    [format!("{nx} x {ny} x {nz} cells, {size}"), format!("seen from {around}, {up} degrees{coarse}")]
}
