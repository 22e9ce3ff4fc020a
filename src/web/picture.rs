//! Pictures for JavaScript: the bytes of a PNG.

use hexcast_core::set;
use wasm_bindgen::prelude::*;

use super::border::{JsResult, js_error};
use super::mesh::{WebMesh, cell_box};
use super::work::WebWork;
use hexcast_files::picture::{Look, Place, Slices, View, slices_with_rests, view_with_rests};

/// How a picture looks.
#[wasm_bindgen]
pub struct WebLook(Look);

#[wasm_bindgen]
impl WebLook {
    /// Takes pixels, the flags that are shown, colours as `flag << 24 | rgb`, and most bytes of memory.
    #[wasm_bindgen(constructor)]
    pub fn new(size: Option<u32>, flags: Vec<u8>, colours: &[u32], max_bytes: f64) -> WebLook {
        let look = set!(Look { size, ..Look::default().with_flags(flags).with_max_bytes(max_bytes as u64) });
        let coloured = colours.iter().map(|packed| packed.to_be_bytes());
        WebLook(coloured.fold(look, |look, [flag, rgb @ ..]| look.with_colour(flag, rgb)))
    }
}

#[wasm_bindgen]
impl WebMesh {
    /// Draws slices: each of the places, separated by commas, along each of the axes.
    #[wasm_bindgen(js_name = drawSlices)]
    pub fn draw_slices(&self, axes: &[u8], places: &str, has_lines: bool, look: WebLook) -> JsResult<WebWork> {
        let axes: Vec<usize> = axes.iter().copied().map(usize::from).collect();
        let places = places.split(',').filter(|text| !text.is_empty()).map(str::parse);
        let places: Vec<Place> = places.collect::<Result<_, _>>().map_err(js_error)?;
        let wanted = Slices::at(&self.mesh, &axes, &places).map_err(js_error)?.with_lines(has_lines).with_look(look.0);
        let mesh = self.mesh.clone();
        Ok(WebWork::new(|control| async move {
            Ok(slices_with_rests(&mesh, &wanted, &control).await?.png_with_rests(&control).await?.into())
        }))
    }

    /// Draws the surface, from a direction of two angles; of a box of cells, first and end on x, y, z, or of all.
    #[wasm_bindgen(js_name = drawView)]
    pub fn draw_view(&self, direction: Option<Vec<f64>>, cells: Option<Vec<u32>>, look: WebLook) -> JsResult<WebWork> {
        let mut wanted = View::default().with_look(look.0);
        if let Some(&[around, up]) = direction.as_deref() {
            wanted.direction = [around, up];
        }
        wanted.cells = cells.map(|corners| cell_box(&corners)).transpose()?;
        let mesh = self.mesh.clone();
        Ok(WebWork::new(|control| async move {
            Ok(view_with_rests(&mesh, &wanted, &control).await?.png_with_rests(&control).await?.into())
        }))
    }
}
