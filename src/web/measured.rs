//! What was measured beside the cells, for JavaScript: its arrays, one by one, and the archives that hold them.

use serde::Serialize;
use wasm_bindgen::prelude::*;

use super::mesh::WebMesh;
use super::values::{JsResult, js_error};
use crate::error::{Error, Result};
use crate::fractions::Fractions;
use crate::links::Links;
use crate::mesh::Mesh;
use crate::report::MeshFacts;
use crate::staggered::Staggered;
use crate::write::archive::Array;
use crate::write::{fractions, links, npz, staggered};

/// What a mesh has beside its cells, where its job asked for it.
#[derive(Default)]
pub(super) struct Measured {
    links: Option<Links>,
    fractions: Option<Fractions>,
    staggered: Option<Staggered>,
}

impl Measured {
    /// Takes it out of the facts, which keep what a report says of it.
    pub(super) fn take(facts: &mut MeshFacts) -> Measured {
        let MeshFacts { links, fractions, staggered, .. } = facts;
        Measured { links: links.take(), fractions: fractions.take(), staggered: staggered.take() }
    }

    /// The arrays of an archive: of `links`, `fractions`, `staggered`, or else of the mesh, so many of its cells at a time.
    ///
    /// # Errors
    /// `job-conflict` where the mesh has none of these.
    pub(super) fn arrays<'a>(&'a self, mesh: &'a Mesh, of: &str, cells_at_once: usize) -> Result<Vec<Array<'a>>> {
        let arrays = match of {
            "links" => self.links.as_ref().map(links::arrays),
            "fractions" => self.fractions.as_ref().map(fractions::arrays),
            "staggered" => self.staggered.as_ref().map(|of| staggered::arrays(of, mesh)),
            _ => Some(npz::arrays(mesh, cells_at_once)),
        };
        arrays.ok_or_else(|| {
            Error::new(
                "job-conflict",
                format!("the mesh has no {of}"),
                format!("ask for them with the key {of} of the job"),
            )
        })
    }
}

/// An array as `www/arrays.js` reads it.
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
        let arrays = self.measured.arrays(&self.mesh, of, 1).map_err(js_error)?;
        let described: Vec<Described> = arrays.iter().map(|of| Described { name: of.name, kind: of.kind }).collect();
        Ok(super::info::json(&described))
    }

    /// The bytes of one of these arrays, in their order.
    #[wasm_bindgen(js_name = arrayOf)]
    pub fn array_of(&self, of: &str, index: usize) -> JsResult<Vec<u8>> {
        let arrays = self.measured.arrays(&self.mesh, of, 1).map_err(js_error)?;
        arrays.get(index).map_or(Ok(Vec::new()), Array::bytes).map_err(js_error)
    }
}
