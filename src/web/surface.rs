//! Surfaces: read slice by slice, checked and drawn in steps, so that messages arrive in between.

use std::rc::Rc;

use sha2::{Digest, Sha256};
use wasm_bindgen::prelude::*;

use super::info;
use super::values::{JsResult, js_error};
use hexcast_core::base::checksum::hex;
use hexcast_core::base::error::Error;
use hexcast_core::input::geometry::{Facet, Geometry, Measuring, SharedFacets};
use hexcast_core::input::preview::Preview;
use hexcast_core::input::read::Reader;
use hexcast_core::input::sources::Source;
use hexcast_core::input::surface::{Surface, SurfaceCheck};

/// Reads a file, slice by slice.
#[wasm_bindgen]
pub struct WebReader {
    file: String,
    reader: Reader,
    hash: Sha256,
}

#[wasm_bindgen]
impl WebReader {
    /// Expects a file of so many bytes.
    #[wasm_bindgen(constructor)]
    pub fn new(file: String, n_bytes: f64) -> WebReader {
        WebReader { file, reader: Reader::new(n_bytes as u64), hash: Sha256::new() }
    }

    /// Takes the next slice.
    pub fn push(&mut self, slice: &[u8]) -> JsResult<()> {
        self.hash.update(slice);
        self.reader.push(slice).map_err(|error| js_error(error.at(&self.file)))
    }

    /// Ends the file.
    pub fn finish(self) -> JsResult<WebSurface> {
        let contents = self.reader.finish().map_err(|error| js_error(error.at(&self.file)))?;
        let sha256 = hex(&self.hash.finalize());
        WebSurface::new(Source::new(self.file, contents, Some(sha256)))
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

    /// Facts as JSON: `FileInfo` of `www/job.d.ts`.
    pub fn info(&self) -> String {
        info::file_info(&self.source, &self.geometry)
    }

    /// Corners of all facets, 9 numbers each.
    pub fn corners(&self) -> Vec<f32> {
        self.geometry.facets.as_flattened().as_flattened().to_vec()
    }

    /// Starts to measure it, which its facts and estimates need.
    pub fn measure(&self) -> WebMeasuring {
        WebMeasuring { geometry: self.geometry.clone(), measuring: Measuring::new() }
    }

    /// Starts to look at the edges.
    pub fn check(&self) -> WebCheck {
        let solids = self.source.contents.solids.iter().map(|solid| solid.facets.clone());
        let all = self.geometry.facets.clone();
        // one solid is the whole
        let solids = solids.filter(|solid| solid.len() < all.len());
        let parts: Vec<SharedFacets> = [all.clone()].into_iter().chain(solids).collect();
        WebCheck { check: SurfaceCheck::new(&all), parts, done: Vec::new() }
    }

    /// Starts to make a preview of at most so many facets.
    pub fn preview(&self, max_facets: u32) -> WebPreview {
        let bounds = self.geometry.bounding_box().unwrap_or_default();
        WebPreview { facets: self.geometry.facets.clone(), preview: Preview::new(bounds, max_facets as usize) }
    }
}

/// Measures a surface.
#[wasm_bindgen]
pub struct WebMeasuring {
    geometry: Geometry,
    measuring: Measuring,
}

#[wasm_bindgen]
impl WebMeasuring {
    /// Does a part of the work; false once all is done.
    pub fn step(&mut self) -> bool {
        self.measuring.step(&self.geometry.facets, self.geometry.world_from_file)
    }

    /// Keeps what was found, once all is done.
    pub fn finish(self) {
        self.geometry.keep(self.measuring);
    }
}

/// Looks at the edges of a surface, of all its solids together and then of each.
#[wasm_bindgen]
pub struct WebCheck {
    parts: Vec<SharedFacets>,
    /// Of the part after those that are done.
    check: SurfaceCheck,
    done: Vec<Surface>,
}

#[wasm_bindgen]
impl WebCheck {
    /// Does a part of the work; false once all is done.
    pub fn step(&mut self) -> bool {
        let Some(facets) = self.parts.get(self.done.len()) else { return false };
        if self.check.step(facets) {
            return true;
        }
        let next = SurfaceCheck::new(self.parts.get(self.done.len() + 1).map_or(&[], |facets| facets));
        self.done.push(std::mem::replace(&mut self.check, next).finish());
        self.done.len() < self.parts.len()
    }

    /// Share of the work that is done, 0 to 1.
    pub fn share(&self) -> f64 {
        let share = if self.done.len() < self.parts.len() { self.check.share() } else { 0.0 };
        (self.done.len() as f64 + share) / self.parts.len() as f64
    }

    /// Facts as JSON, once all is done: what `SurfaceInfo` of `www/job.d.ts` adds to `FileInfo`.
    pub fn finish(self) -> String {
        info::edge_info(&self.done)
    }
}

/// Makes a preview of a surface.
#[wasm_bindgen]
pub struct WebPreview {
    facets: SharedFacets,
    preview: Preview,
}

#[wasm_bindgen]
impl WebPreview {
    /// Does a part of the work; false once all is done.
    pub fn step(&mut self) -> bool {
        self.preview.step(&self.facets)
    }

    /// Share of the work that is done, 0 to 1; it may begin again.
    pub fn share(&self) -> f64 {
        self.preview.share(self.facets.len())
    }

    /// Corners of its facets, 9 numbers each, once all is done.
    pub fn finish(self) -> Vec<f32> {
        self.preview.finish().into_flattened().into_flattened()
    }
}
