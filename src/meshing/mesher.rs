//! A mesher for callers without an async executor: a backend that is opened once, and calls that return when a mesh is done.
//!
//! It blocks on [`pipeline::mesh`], which asynchronous callers await themselves. Natively only: a browser must not block.

use std::time::Instant;

use crate::meshing::files::read_job_files;
use crate::meshing::pipeline::points::PointFlags;
use crate::meshing::pipeline::{self, Engine, MeshOptions};
use crate::meshing::report::{CallerFacts, Report};
use crate::meshing::scene::{Scene, Update};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::input::job::{BackendChoice, Job};
use hexcast_core::input::sources::Source;
use hexcast_derived::mesh::Mesh;
#[cfg(feature = "gpu")]
use hexcast_gpu::{Device, DeviceMesh, Gpu, Queue};

/// Which backend a [`Mesher`] opens.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct MesherOptions {
    /// GPU or CPU. That of a job is not looked at.
    pub backend: BackendChoice,
    /// A part of the name of the GPU, where there are several.
    pub adapter: Option<String>,
}

impl MesherOptions {
    /// Chooses the backend.
    pub fn with_backend(self, backend: BackendChoice) -> MesherOptions {
        MesherOptions { backend, ..self }
    }

    /// Chooses the GPU whose name contains this.
    pub fn with_adapter(self, adapter: impl Into<String>) -> MesherOptions {
        MesherOptions { adapter: Some(adapter.into()), ..self }
    }
}

/// An open backend that meshes one job after the other. Opening a GPU takes longer than many a mesh: keep it.
pub struct Mesher {
    engine: Engine,
}

impl Mesher {
    /// Opens a backend; see [`Engine::open`] for what `Auto` does.
    ///
    /// # Errors
    /// Those of [`Engine::open`].
    pub fn new(options: MesherOptions) -> Result<Mesher> {
        let engine = pollster::block_on(Engine::open(options.backend, options.adapter.as_deref()))?;
        Ok(Mesher { engine })
    }

    /// Meshes on a device of the caller's: see [`Gpu::from_device`] for what it needs, and whose errors are whose.
    ///
    /// # Errors
    /// Those of [`Gpu::from_device`].
    #[cfg(feature = "gpu")]
    pub fn with_device(device: Device, queue: Queue) -> Result<Mesher> {
        let gpu = pollster::block_on(Gpu::from_device(device, queue))?;
        Ok(Mesher::with_engine(Engine::with_gpu(gpu)))
    }

    /// Takes a backend that is open.
    pub fn with_engine(engine: Engine) -> Mesher {
        Mesher { engine }
    }

    /// The backend.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// Reads the files that a job names, and meshes it.
    ///
    /// # Errors
    /// Those of [`read_job_files`] and [`pipeline::mesh`].
    pub fn mesh(&mut self, job: &Job) -> Result<(Mesh, Report)> {
        job.validate()?;
        let start = Instant::now();
        let control = Control::default();
        let sources = read_job_files(job, &control)?;
        let read = start.elapsed().as_secs_f64();
        self.mesh_read(job, sources, read, &MeshOptions::default(), &control)
    }

    /// Meshes a job whose surfaces are in memory: `sources[i]` has those of `job.geometries[i]`, whose file is then only a name.
    ///
    /// # Errors
    /// Those of [`pipeline::mesh`].
    pub fn mesh_sources(
        &mut self,
        job: &Job,
        sources: Vec<Source>,
        options: &MeshOptions,
        control: &Control,
    ) -> Result<(Mesh, Report)> {
        self.mesh_read(job, sources, 0.0, options, control)
    }

    /// Meshes a job as [`Mesher::mesh_sources`] does, for edits of which only what they change is meshed again.
    ///
    /// # Errors
    /// Those of [`Scene::new`].
    pub fn scene(&mut self, job: Job, sources: Vec<Source>, options: MeshOptions, control: &Control) -> Result<Scene> {
        let made = pollster::block_on(Scene::new(job, sources, options, &mut self.engine, control));
        self.engine.seconds = 0.0;
        made
    }

    /// Meshes what the edits of a scene have changed.
    ///
    /// # Errors
    /// Those of [`Scene::update`].
    pub fn update(&mut self, scene: &mut Scene, control: &Control) -> Result<Update> {
        pollster::block_on(scene.update(&mut self.engine, control))
    }

    /// Gives a scene another job with its surfaces, and meshes what that changes.
    ///
    /// # Errors
    /// Those of [`Scene::update_to`].
    pub fn update_to(
        &mut self,
        scene: &mut Scene,
        job: Job,
        sources: Vec<Source>,
        control: &Control,
    ) -> Result<Update> {
        pollster::block_on(scene.update_to(job, sources, &mut self.engine, control))
    }

    /// Reads the files that a job names, and meshes it on the GPU, where the runs stay: see [`pipeline::mesh_on_device`].
    ///
    /// # Errors
    /// Those of [`read_job_files`] and [`pipeline::mesh_on_device`].
    #[cfg(feature = "gpu")]
    pub fn mesh_on_device(&mut self, job: &Job) -> Result<DeviceMesh> {
        job.validate()?;
        let control = Control::default();
        let sources = read_job_files(job, &control)?;
        self.mesh_sources_on_device(job, sources, &MeshOptions::default(), &control)
    }

    /// The same of a job whose surfaces are in memory, as of [`Mesher::mesh_sources`].
    ///
    /// # Errors
    /// Those of [`pipeline::mesh_on_device`].
    #[cfg(feature = "gpu")]
    pub fn mesh_sources_on_device(
        &mut self,
        job: &Job,
        sources: Vec<Source>,
        options: &MeshOptions,
        control: &Control,
    ) -> Result<DeviceMesh> {
        pollster::block_on(pipeline::mesh_on_device(job, sources, options, &self.engine, control))
    }

    /// Reads the files that a job names, for the flags at any points: see [`PointFlags`]. The backend does nothing for it.
    ///
    /// # Errors
    /// Those of [`read_job_files`] and [`PointFlags::new`].
    pub fn points(&self, job: &Job) -> Result<PointFlags> {
        job.validate()?;
        let control = Control::default();
        PointFlags::new(job, read_job_files(job, &control)?, &MeshOptions::default(), &control)
    }

    fn mesh_read(
        &mut self,
        job: &Job,
        sources: Vec<Source>,
        read: f64,
        options: &MeshOptions,
        control: &Control,
    ) -> Result<(Mesh, Report)> {
        let (mesh, facts) = pollster::block_on(pipeline::mesh(job, sources, options, &mut self.engine, control))?;
        // the next mesh does not open it
        self.engine.seconds = 0.0;
        Ok((mesh, Report::new(facts, CallerFacts::default().with_read(read))))
    }
}
