//! The arrays of what was measured, one by one, for JavaScript.

use serde::Serialize;
use wasm_bindgen::prelude::*;

use super::mesh::WebMesh;
use super::values::{JsResult, js_error};
use hexcast_files::write::Array;

/// An array as `www/core/arrays.js` reads it.
#[derive(Serialize)]
struct Described<'a> {
    name: &'a str,
    kind: &'a str,
}

#[wasm_bindgen]
impl WebMesh {
    /// Names and types of the arrays of `links`, `fractions` or `staggered`, as JSON.
    #[wasm_bindgen(js_name = arraysOf)]
    pub fn arrays_of(&self, of: &str) -> JsResult<String> {
        let arrays = self.measured.arrays(&self.mesh, of).map_err(js_error)?;
        let described: Vec<Described> =
            arrays.iter().map(|of| Described { name: of.name(), kind: of.kind() }).collect();
        Ok(super::info::json(&described))
    }

    /// The bytes of one of these arrays, in their order.
    #[wasm_bindgen(js_name = arrayOf)]
    pub fn array_of(&self, of: &str, index: usize) -> JsResult<Vec<u8>> {
        let arrays = self.measured.arrays(&self.mesh, of).map_err(js_error)?;
        arrays.get(index).map_or(Ok(Vec::new()), Array::bytes).map_err(js_error)
    }
}
