//! What JavaScript calls, in this file and `web/`. `www/core/core.js` is its only caller; people use `www/hexcast.js`.
//!
//! Facts cross as JSON, numbers of cells as f64 (exact to 2^53), bytes as copies: no array of JavaScript is kept or detached.
//! An error becomes the JSON of `{code, message, hint}`. Long calls are async and check for cancellation between rounds.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;

use js_sys::{Function, Promise};
use wasm_bindgen::prelude::*;
use wasm_bindgen_futures::JsFuture;

use crate::meshing::converge::converge;
use crate::meshing::estimate::Estimate;
use crate::meshing::measured::Measured;
use crate::meshing::pipeline::{self, Engine, MeshOptions, Prepared, SpillTarget};
use crate::meshing::report::{CallerFacts, Report};
use crate::meshing::scene::Scene;
use hexcast_core::base::control::{CancelToken, Control, Progress};
use hexcast_core::base::error::{Error, Result};
use hexcast_core::input::job::{BackendChoice, Job};
use hexcast_core::input::sources::Source;

mod border;
mod encoder;
mod export;
mod file;
mod leak;
mod mesh;
mod picture;
mod scene;
mod surface;
#[cfg(target_feature = "atomics")]
mod threads;
mod work;
mod write_options;

use border::{JsResult, engine_facts, forget, js_error, json, keep, kept};
pub use encoder::{WebEncoder, WebHash};
pub use file::JsFile;
use file::JsFileStore;
pub use mesh::{WebMesh, WebSkin};
pub use picture::WebLook;
pub use scene::WebScene;
pub use surface::{WebReader, WebSurface};
#[cfg(target_feature = "atomics")]
pub use threads::{run_thread, start_threads};
pub use work::WebWork;

/// Version of hexcast.
#[wasm_bindgen]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").into()
}

/// WGSL of the kernel that makes flags of [`WebMesh::box_runs`].
#[wasm_bindgen(js_name = expandText)]
pub fn expand_text() -> String {
    hexcast_gpu::expand_text().to_string()
}

/// All error codes, comma-separated, for the test that holds the types to them.
#[wasm_bindgen(js_name = errorCodes)]
pub fn error_codes() -> String {
    hexcast_core::base::error::CODES.iter().map(|(code, ..)| *code).collect::<Vec<_>>().join(",")
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

    /// Estimates what the mesh would cost: `Estimate` without seconds, as JSON.
    pub fn estimate(&self) -> JsResult<WebWork> {
        let prepared = pipeline::prepare(&self.job, self.sources()).map_err(js_error)?;
        Ok(WebWork::new(|control| async move {
            let Prepared { geometries, lines, rays, unit, .. } = &prepared;
            let estimate = Estimate::with_rests(geometries, lines, rays, &control).await?;
            Ok(json(&estimate.with_unit(unit.as_deref())).into())
        }))
    }

    /// The sources, whose facets stay shared.
    fn sources(&self) -> Vec<Source> {
        self.sources.iter().map(|source| (**source).clone()).collect()
    }
}

/// Where devices come from: `navigator.gpu` as it is when this is made.
#[wasm_bindgen]
pub struct WebGpu {
    instance: hexcast_gpu::Instance,
}

#[wasm_bindgen]
impl WebGpu {
    /// Looks for `navigator.gpu`, at once.
    #[wasm_bindgen(constructor)]
    #[expect(clippy::new_without_default, reason = "a JavaScript constructor")]
    pub fn new() -> WebGpu {
        WebGpu { instance: hexcast_gpu::instance() }
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
        self.engine.borrow().as_ref().map(engine_facts).unwrap_or_default()
    }

    /// Meshes a job; `progress` is called with rays done and rays in all. Columns that exceed the memory allowed go to
    /// `spill`, if it is given. The GPU's buffers take `max_device_bytes` at most, if these are.
    pub async fn mesh(
        &self,
        job: WebJob,
        read_seconds: f64,
        max_device_bytes: Option<f64>,
        progress: Function,
        spill: Option<JsFile>,
    ) -> JsResult<WebMesh> {
        // first of all, so that the file is closed whatever happens
        let spill = spill.map_or(SpillTarget::None, |file| SpillTarget::Temporary(Arc::new(JsFileStore::new(file))));
        let max_device_bytes = max_device_bytes.map(|bytes| bytes as u64);
        let options = MeshOptions { spill, max_device_bytes, ..MeshOptions::default() };
        let work = async |engine: &mut Engine, control: &Control| {
            pipeline::mesh(&job.job, job.sources(), &options, engine, control).await
        };
        let (mesh, mut facts) = self.with_engine(&job, progress, work).await?;
        let measured = Measured::take(&mut facts);
        let zarr = job.job.zarr.unwrap_or_default();
        let report = Report::new(facts, CallerFacts { read: read_seconds, ..CallerFacts::default() });
        Ok(WebMesh::new(mesh, (Arc::new(measured), zarr), json(&report)))
    }

    /// Meshes a job with so many cells along the longest side, for each of `sizes`; `progress` begins again with each. Returns JSON: the
    /// levels that `hexcast converge --json` prints.
    pub async fn converge(&self, job: WebJob, sizes: Vec<u32>, progress: Function) -> JsResult<String> {
        let work = async |engine: &mut Engine, control: &Control| {
            converge(&job.job, &job.sources(), &sizes, engine, control).await
        };
        Ok(json(&self.with_engine(&job, progress, work).await?))
    }

    /// Meshes a job that will be edited; its columns stay in memory.
    pub async fn scene(&self, job: WebJob, max_device_bytes: Option<f64>, progress: Function) -> JsResult<WebScene> {
        let max_device_bytes = max_device_bytes.map(|bytes| bytes as u64);
        let options = MeshOptions { max_device_bytes, ..MeshOptions::default() };
        let work = async |engine: &mut Engine, control: &Control| {
            Scene::new(job.job.clone(), job.sources(), options, engine, control).await
        };
        Ok(WebScene::new(self.with_engine(&job, progress, work).await?))
    }

    /// Gives a scene another job, and meshes what that changes. After an error the scene is as before.
    pub async fn update(&self, scene: &WebScene, job: WebJob, progress: Function) -> JsResult<()> {
        let work = async |engine: &mut Engine, control: &Control| {
            // there is one engine, which is free
            let mut held = scene.scene.take().expect("a scene that is not updated");
            let made = held.update_to(job.job.clone(), job.sources(), engine, control).await;
            scene.scene.replace(Some(held));
            made
        };
        scene.tell(self.with_engine(&job, progress, work).await?);
        Ok(())
    }

    /// Works with the engine, which is free again then; `progress` is called with rays done and rays in all.
    async fn with_engine<T>(
        &self,
        job: &WebJob,
        progress: Function,
        work: impl AsyncFnOnce(&mut Engine, &Control) -> Result<T>,
    ) -> JsResult<T> {
        let mut engine = self.take()?;
        let progress = keep(progress.into());
        let control = self.control(job.token.clone(), progress);
        let made = work(&mut engine, &control).await;
        forget(progress);
        self.engine.replace(Some(engine));
        made.map_err(js_error)
    }

    fn take(&self) -> JsResult<Engine> {
        let engine = self.engine.borrow_mut().take();
        engine.ok_or_else(|| js_error(Error::new("device-failed", "a mesh is already being made", "wait for it")))
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
