//! Differences of two meshes for JavaScript, found in steps.

use wasm_bindgen::prelude::*;

use super::info::json;
use super::mesh::WebMesh;
use super::values::{JsResult, js_error};
use super::work::Work;
use crate::meshing::measured::Measured;
use crate::meshing::report::ColumnsReport;
use hexcast_core::derived::difference::{Difference, difference_with_rests};
use hexcast_core::input::job::ZarrJob;

/// A comparison at work.
#[wasm_bindgen]
pub struct WebDifference {
    work: Work<Difference>,
}

#[wasm_bindgen]
impl WebDifference {
    /// Does a part of the work; false once all is done.
    pub fn step(&mut self) -> JsResult<bool> {
        self.work.step().map_err(js_error)
    }

    /// What `hexcast diff --json` prints, once all is done.
    pub fn facts(&self) -> String {
        self.work.made.as_ref().map(json).unwrap_or_default()
    }

    /// The mask, once all is done.
    pub fn finish(self) -> JsResult<WebMesh> {
        let mask = self.work.finish().map_err(js_error)?.mask;
        let report = json(&ColumnsReport::new(&mask));
        Ok(WebMesh::new(mask, (Measured::default(), ZarrJob::default()), report))
    }
}

#[wasm_bindgen]
impl WebMesh {
    /// Starts to compare it with another mesh; the mask takes at most so many bytes.
    #[wasm_bindgen(js_name = differenceFrom)]
    pub fn difference_from(&self, other: &WebMesh, max_bytes: f64) -> WebDifference {
        let (one, other) = (self.mesh.clone(), other.mesh.clone());
        let work = move |control| async move { difference_with_rests(&one, &other, max_bytes as u64, &control).await };
        WebDifference { work: Work::new(work) }
    }
}
