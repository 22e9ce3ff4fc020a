//! Surfaces: read slice by slice, checked and drawn with rests, so that messages arrive in between.

use std::rc::Rc;

use wasm_bindgen::prelude::*;

use super::border::{JsResult, edge_info, file_info, js_error};
use super::work::WebWork;
use hexcast_core::base::checksum::FileHash;
use hexcast_core::base::error::Error;
use hexcast_core::input::geometry::{Facet, Geometry, SharedFacets};
use hexcast_core::input::preview::preview;
use hexcast_core::input::read::Reader;
use hexcast_core::input::sources::Source;
use hexcast_core::input::surface::surface_with_rests;

/// Reads a file, slice by slice.
#[wasm_bindgen]
pub struct WebReader {
    file: String,
    reader: Reader,
    hash: FileHash,
}

#[wasm_bindgen]
impl WebReader {
    /// Expects a file of so many bytes.
    #[wasm_bindgen(constructor)]
    pub fn new(file: String, n_bytes: f64) -> WebReader {
        WebReader { file, reader: Reader::new(n_bytes as u64), hash: FileHash::default() }
    }

    /// Takes the next slice.
    pub fn push(&mut self, slice: &[u8]) -> JsResult<()> {
        self.hash.update(slice);
        self.reader.push(slice).map_err(|error| js_error(error.at(&self.file)))
    }

    /// Ends the file.
    pub fn finish(self) -> JsResult<WebSurface> {
        let contents = self.reader.finish().map_err(|error| js_error(error.at(&self.file)))?;
        let hash = self.hash.finish();
        WebSurface::new(Source::new(self.file, contents, Some(hash)))
    }
}

/// A surface that was read.
#[wasm_bindgen]
pub struct WebSurface {
    pub(super) source: Rc<Source>,
    /// Facets of all its solids.
    geometry: Geometry,
}

impl WebSurface {
    fn new(source: Source) -> JsResult<WebSurface> {
        let solids = source.contents.solids.iter().map(|solid| solid.facets.clone());
        let geometry = Geometry::new("", 1, SharedFacets::join(&solids.collect::<Vec<_>>())).map_err(js_error)?;
        Ok(WebSurface { source: Rc::new(source), geometry })
    }
}

#[wasm_bindgen]
impl WebSurface {
    /// Takes corners of facets, 9 numbers each.
    #[wasm_bindgen(js_name = fromCorners)]
    pub fn from_corners(file: String, corners: &[f32]) -> JsResult<WebSurface> {
        let (facets, rest) = corners.as_chunks::<9>();
        if facets.is_empty() || !rest.is_empty() {
            let message = format!("{file}: {} numbers: facets are 9 numbers each, at least one", corners.len());
            return Err(js_error(Error::new("job-value", message, "give x y z of three corners a facet")));
        }
        let facet = |f: &[f32; 9]| -> Facet { [[f[0], f[1], f[2]], [f[3], f[4], f[5]], [f[6], f[7], f[8]]] };
        let facets: Vec<Facet> = facets.iter().map(facet).collect();
        WebSurface::new(Source::from_facets(file, facets).map_err(js_error)?)
    }

    /// Facts as JSON: `FileInfo` of `www/types/job.d.ts`.
    pub fn info(&self) -> String {
        file_info(&self.source, &self.geometry)
    }

    /// Corners of all facets, 9 numbers each.
    pub fn corners(&self) -> JsResult<Vec<f32>> {
        let facets = self.geometry.facets.in_memory("a list of corners").map_err(js_error)?;
        Ok(facets.as_flattened().as_flattened().to_vec())
    }

    /// Measures it, which its facts and estimates need.
    pub fn measure(&self) -> WebWork {
        let geometry = self.geometry.clone();
        WebWork::new(|control| async move { geometry.measured(&control).await.map(|_| JsValue::UNDEFINED) })
    }

    /// Looks at the edges, of all its solids together and then of each. Makes facts as JSON: what `SurfaceInfo` of `www/types/job.d.ts` adds to
    /// `FileInfo`.
    pub fn check(&self) -> WebWork {
        let solids = self.source.contents.solids.iter().map(|solid| solid.facets.clone());
        let all = self.geometry.facets.clone();
        // one solid is the whole
        let solids = solids.filter(|solid| solid.len() < all.len());
        let parts: Vec<SharedFacets> = [all.clone()].into_iter().chain(solids).collect();
        WebWork::new(|control| async move {
            let mut checked = Vec::new();
            for (index, part) in parts.iter().enumerate() {
                checked.push(
                    surface_with_rests(part.in_memory("the check of edges")?, &control.of_piece(index, parts.len()))
                        .await?,
                );
            }
            Ok(edge_info(&checked).into())
        })
    }

    /// Makes a preview of at most so many facets: their corners, 9 numbers each.
    pub fn preview(&self, max_facets: u32) -> WebWork {
        let (facets, bounds) = (self.geometry.facets.clone(), self.geometry.bounding_box().unwrap_or_default());
        WebWork::new(move |control| async move {
            let facets = preview(facets.in_memory("a preview")?, bounds, max_facets as usize, &control).await?;
            Ok(facets.into_flattened().into_flattened().into())
        })
    }
}
