//! What JavaScript calls, in this file and `web/`. `www/core.js` is its only caller; people use `www/hexcast.js`.
//!
//! Facts cross as JSON, numbers of cells as f64 (exact to 2^53), bytes as copies: no array of JavaScript is kept or detached.
//! An error becomes the JSON of `{code, message, hint}`. Long calls are async and check for cancellation between rounds.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use js_sys::{Function, Promise};
use sha2::{Digest, Sha256};
use wasm_bindgen::prelude::*;
use wasm_bindgen_futures::JsFuture;

use crate::checksum::hex;
use crate::control::{CancelToken, Control, Progress};
use crate::error::Error;
use crate::estimate::Estimate;
use crate::geometry::Facet;
use crate::job::{BackendChoice, Job};
use crate::pipeline::{self, Engine, MeshOptions, SpillTarget};
use crate::read::Reader;
use crate::report::{CallerFacts, Report};
use crate::sources::Source;

mod file;
mod info;
mod leak;
mod mesh;
mod values;

pub use file::JsFile;
use file::JsFileStore;
pub use mesh::{WebEncoder, WebHash, WebMesh, WebSkin};
use values::{JsResult, forget, js_error, keep, kept};

/// Version of hexcast.
#[wasm_bindgen]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").into()
}

/// WGSL of the kernel that makes flags of [`WebMesh::box_runs`].
#[wasm_bindgen(js_name = expandText)]
pub fn expand_text() -> String {
    crate::gpu::expand_text().to_string()
}

/// All error codes, comma-separated, for the test that holds the types to them.
#[wasm_bindgen(js_name = errorCodes)]
pub fn error_codes() -> String {
    crate::error::CODES.iter().map(|(code, ..)| *code).collect::<Vec<_>>().join(",")
}

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
        Ok(WebSurface { source: Rc::new(Source::new(self.file, contents, Some(sha256))) })
    }
}

/// A surface that was read.
#[wasm_bindgen]
pub struct WebSurface {
    source: Rc<Source>,
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
        let source = Source::from_facets(file, facets).map_err(js_error)?;
        Ok(WebSurface { source: Rc::new(source) })
    }

    /// Facts as JSON: `SurfaceInfo` of `www/hexcast.d.ts`.
    pub fn info(&self) -> JsResult<String> {
        info::surface_info(&self.source).map_err(js_error)
    }

    /// Corners of all facets, 9 numbers each.
    pub fn corners(&self) -> Vec<f32> {
        self.source
            .contents
            .solids
            .iter()
            .flat_map(|solid| solid.facets.as_flattened().as_flattened())
            .copied()
            .collect()
    }
}

/// Cancels one call.
#[wasm_bindgen]
pub struct WebSwitch {
    token: CancelToken,
}

#[wasm_bindgen]
impl WebSwitch {
    /// Makes a switch that has not been used.
    #[wasm_bindgen(constructor)]
    #[expect(clippy::new_without_default, reason = "a JavaScript constructor")]
    pub fn new() -> WebSwitch {
        WebSwitch { token: CancelToken::default() }
    }

    /// Cancels the call.
    pub fn cancel(&self) {
        self.token.cancel();
    }
}

/// A job and its surfaces.
#[wasm_bindgen]
pub struct WebJob {
    job: Job,
    sources: Vec<Rc<Source>>,
    token: CancelToken,
}

#[wasm_bindgen]
impl WebJob {
    /// Reads a job from JSON, with a `file` for each geometry; a switch can cancel its mesh.
    #[wasm_bindgen(constructor)]
    pub fn new(json: &str, switch: &WebSwitch) -> JsResult<WebJob> {
        let job = Job::from_plain_json(json).map_err(js_error)?;
        Ok(WebJob { job, sources: Vec::new(), token: switch.token.clone() })
    }

    /// Adds the surface of the next geometry.
    pub fn add(&mut self, surface: &WebSurface) {
        self.sources.push(surface.source.clone());
    }

    /// What the mesh would cost, as JSON: `Estimate` without seconds.
    pub fn estimate(&self) -> JsResult<String> {
        let prepared = pipeline::prepare(&self.job, self.sources()).map_err(js_error)?;
        let estimate = Estimate::new(&prepared.geometries, &prepared.lines, &prepared.rays);
        Ok(info::json(&estimate))
    }

    /// The sources, whose facets stay shared.
    fn sources(&self) -> Vec<Source> {
        self.sources.iter().map(|source| (**source).clone()).collect()
    }
}

/// Where devices come from: `navigator.gpu` as it is when this is made.
#[wasm_bindgen]
pub struct WebGpu {
    instance: crate::gpu::Instance,
}

#[wasm_bindgen]
impl WebGpu {
    /// Looks for `navigator.gpu`, at once.
    #[wasm_bindgen(constructor)]
    #[expect(clippy::new_without_default, reason = "a JavaScript constructor")]
    pub fn new() -> WebGpu {
        WebGpu { instance: crate::gpu::instance() }
    }
}

/// An open backend.
#[wasm_bindgen]
pub struct WebEngine {
    engine: Rc<RefCell<Option<Engine>>>,
    pause: usize,
}

#[wasm_bindgen]
impl WebEngine {
    /// Opens a backend: "auto", "gpu" or "cpu". `pause` returns a promise that resolves once messages have been handled.
    pub async fn open(backend: String, gpu: WebGpu, pause: Function) -> JsResult<WebEngine> {
        let choice = match backend.as_str() {
            "auto" => BackendChoice::Auto,
            "gpu" => BackendChoice::Gpu,
            "cpu" => BackendChoice::Cpu,
            other => {
                let message = format!("backend is \"{other}\"; allowed: auto, gpu, cpu");
                return Err(js_error(Error::new("job-value", message, "")));
            }
        };
        let engine = Engine::open_in(gpu.instance, choice).await.map_err(js_error)?;
        Ok(WebEngine { engine: Rc::new(RefCell::new(Some(engine))), pause: keep(pause.into()) })
    }

    /// `{backend, adapter, fallback}` as JSON, which a mesh may have changed; empty while one is made.
    pub fn facts(&self) -> String {
        self.engine.borrow().as_ref().map(info::engine_facts).unwrap_or_default()
    }

    /// Meshes a job; `progress` is called with rays done and rays in all. Columns that exceed the memory allowed go to
    /// `spill`, if it is given.
    pub async fn mesh(
        &self,
        job: WebJob,
        read_seconds: f64,
        progress: Function,
        spill: Option<JsFile>,
    ) -> JsResult<WebMesh> {
        // first of all, so that the file is closed whatever happens
        let spill = spill.map_or(SpillTarget::None, |file| SpillTarget::Temporary(Arc::new(JsFileStore::new(file))));
        let Some(mut engine) = self.engine.borrow_mut().take() else {
            return Err(js_error(Error::new("device-failed", "a mesh is already being made", "wait for it")));
        };
        let progress = keep(progress.into());
        let control = self.control(job.token.clone(), progress);
        let options = MeshOptions { spill, ..MeshOptions::default() };
        let result = pipeline::mesh(&job.job, job.sources(), &options, &mut engine, &control).await;
        forget(progress);
        *self.engine.borrow_mut() = Some(engine);
        let (mesh, facts) = result.map_err(js_error)?;
        let report = Report::new(facts, CallerFacts { read: read_seconds, ..CallerFacts::default() });
        Ok(WebMesh::new(mesh, info::json(&report)))
    }

    fn control(&self, token: CancelToken, progress: usize) -> Control {
        let mut control = Control::with_progress(move |at: Progress| {
            let progress: Function = kept(progress).unchecked_into();
            // an exception in the caller's function is the caller's
            let _ = progress.call2(&JsValue::NULL, &(at.rays_done as f64).into(), &(at.n_rays as f64).into());
        });
        control.cancel = token;
        let pause = self.pause;
        control.pausing(move || {
            Box::pin(async move {
                let promise = kept(pause).unchecked_into::<Function>().call0(&JsValue::NULL);
                if let Some(promise) = promise.ok().and_then(|value| value.dyn_into::<Promise>().ok()) {
                    let _ = JsFuture::from(promise).await;
                }
            })
        })
    }
}

impl Drop for WebEngine {
    fn drop(&mut self) {
        forget(self.pause);
    }
}
