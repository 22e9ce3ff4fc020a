//! Differences of two meshes for JavaScript.

use js_sys::Array;
use wasm_bindgen::prelude::*;

use super::info::json;
use super::mesh::WebMesh;
use super::work::WebWork;
use crate::meshing::report::ColumnsReport;
use hexcast_core::derived::difference::difference_with_rests;

#[wasm_bindgen]
impl WebMesh {
    /// Compares it with another mesh; the mask takes at most so many bytes. Makes two values: what `hexcast diff --json` prints, and the
    /// mask, a `WebMesh`.
    #[wasm_bindgen(js_name = differenceFrom)]
    pub fn difference_from(&self, other: &WebMesh, max_bytes: f64) -> WebWork {
        let (one, other) = (self.mesh.clone(), other.mesh.clone());
        WebWork::new(move |control| async move {
            let found = difference_with_rests(&one, &other, max_bytes as u64, &control).await?;
            let (facts, report) = (json(&found), json(&ColumnsReport::new(&found.mask)));
            let mask = WebMesh::new(found.mask, Default::default(), report);
            Ok(Array::of2(&facts.into(), &mask.into()).into())
        })
    }
}
