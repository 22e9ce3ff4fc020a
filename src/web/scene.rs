//! A scene for JavaScript: a mesh that follows the edits of its job.

use std::cell::{Cell, RefCell};

use wasm_bindgen::prelude::*;

use super::mesh::WebMesh;
use crate::meshing::scene::{Scene, Update};
use hexcast_core::cells::columns::ChangedRun;

/// A scene, and what its last update did.
#[wasm_bindgen]
pub struct WebScene {
    /// None while it is updated.
    pub(super) scene: RefCell<Option<Scene>>,
    update: RefCell<Option<Update>>,
    n_made: Cell<u32>,
}

impl WebScene {
    pub(super) fn new(scene: Scene) -> WebScene {
        WebScene { scene: RefCell::new(Some(scene)), update: RefCell::default(), n_made: Cell::default() }
    }

    /// Keeps what an update did.
    pub(super) fn tell(&self, update: Update) {
        self.update.replace(Some(update));
        self.n_made.update(|n| n + 1);
    }
}

#[wasm_bindgen]
impl WebScene {
    /// The mesh of now, which stays as it is.
    pub fn mesh(&self) -> WebMesh {
        let scene = self.scene.borrow();
        let scene = scene.as_ref().expect("a scene that is not updated");
        let of_files = (scene.measured().clone(), scene.job().zarr.unwrap_or_default());
        WebMesh::new(scene.mesh().clone(), of_files, scene.report_json())
    }

    /// What the last update did, as JSON; empty before the first one.
    pub fn update(&self) -> String {
        self.update.borrow().as_ref().map(Update::to_json).unwrap_or_default()
    }

    /// Number of updates that were made.
    #[wasm_bindgen(js_name = nMade)]
    pub fn n_made(&self) -> u32 {
        self.n_made.get()
    }

    /// Runs of cells that it changed, five numbers each: ray, first cell, the cell after the last, flag before and after; undefined where all
    /// may have.
    pub fn changed(&self) -> Option<Vec<u32>> {
        let update = self.update.borrow();
        let runs = update.as_ref()?.changed.as_deref()?;
        // columns in wasm32's memory have fewer than 2^32 rays
        let numbers = |run: &ChangedRun| [run.ray as u32, run.start, run.end, run.before.into(), run.after.into()];
        Some(runs.iter().flat_map(numbers).collect())
    }
}
