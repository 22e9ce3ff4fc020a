//! A scene: a mesh whose geometries move, of which only what changed is meshed again.
//!
//! # Theory
//! The crossings of each geometry are kept ([`Kept`]). An edit snaps and casts the geometries that it changes, on the CPU, and makes the
//! runs again of the rays that these cross otherwise. That is the mesh of the whole job, byte for byte: nothing else decides a cell as
//! long as the lines and the precision of the snap stay, and the rays of one axis decide all geometries. Else the whole is meshed again, by the
//! backend, and the answer says why ([`Whole`]).
//!
//! A GPU would take longer to be asked than the CPU takes for the rays of one body; a whole mesh is its work.
//!
//! # Practice
//! [`Scene::job_mut`] and [`Scene::sources_mut`] make edits, as many as are wanted; [`Scene::update`] meshes them. The first update casts all
//! geometries once, as does the first after a whole mesh. Give the job a domain: without one the box follows the geometries, and every edit
//! that moves its sides is a whole mesh.

use std::mem::replace;
use std::sync::Arc;

use serde::Serialize;

use crate::meshing::measured::Measured;
use crate::meshing::pipeline::{self, Engine, MeshOptions, Prepared, SpillTarget, findings_without_cells, prepare};
use crate::meshing::report::{CallerFacts, ColumnsReport, Report};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::base::finding::{Finding, in_order_of_codes};
use hexcast_core::cells::columns::{ChangedRun, SomeRuns};
use hexcast_core::grid::frame::Frame;
use hexcast_core::input::geometry::Geometry;
use hexcast_core::input::job::{Job, Rule};
use hexcast_core::input::sources::Source;
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::kept::Kept;
use hexcast_derived::mesh::Mesh;

/// Why an update meshed the whole.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Whole {
    /// The lines are other ones, or the axis of the rays, the rule, the unit or the precision of the snap: that is less where a geometry lies far
    /// outside of the box.
    Box,
    /// Rays of one axis do not decide a geometry, or did not before the edit: it is open, flat, inverted, a shell or has cells along its surface.
    Surface,
    /// The job or the options ask for more than cells (links, fractions, a staggered grid, walls, a certificate, doubtful cells), for
    /// closed gaps, or for a window or part; or they did before the edit.
    Asked,
    /// The crossings of all geometries exceed the memory allowed.
    Memory,
}

/// What an update did.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Update {
    /// The cells whose flags changed, in the order of rays, `i + n_i * j`, and cells; None where the box has other lines or rays, so that all
    /// may have.
    #[serde(skip)]
    pub changed: Option<Vec<ChangedRun>>,
    /// Why the whole was meshed; None where some rays were enough.
    pub whole: Option<Whole>,
    /// Rays whose runs were made again.
    pub rays: u64,
    /// What the reader should know. Where some rays were enough: which geometries have no cell, and about the lines; shells and volumes were not
    /// looked at.
    pub findings: Vec<Finding>,
}

impl Update {
    /// What it did, as JSON, without the cells that changed.
    pub fn to_json(&self) -> String {
        // a struct of numbers and texts always has a JSON form
        serde_json::to_string(self).unwrap_or_default()
    }
}

/// A job, and its mesh, which follows the edits of the job.
pub struct Scene {
    job: Job,
    sources: Vec<Source>,
    options: MeshOptions,
    /// What the mesh is of.
    prepared: Prepared,
    rule: Rule,
    mesh: Mesh,
    measured: Arc<Measured>,
    /// Of the mesh, if it was made as a whole.
    report: Option<Report>,
    cells_per_flag: [u64; 256],
    /// Of the geometries of the mesh; None before they are needed.
    kept: Option<Kept>,
    /// Whether a geometry of the mesh is open.
    is_open: bool,
    /// Whether more than rays decided what is in the mesh.
    has_more: bool,
}

impl Scene {
    /// Meshes a job: `sources[i]` is the file of `job.geometries[i]`. The columns stay in memory: what the options say of a store is not looked
    /// at.
    ///
    /// # Errors
    /// Those of [`pipeline::mesh`].
    pub async fn new(
        job: Job,
        sources: Vec<Source>,
        options: MeshOptions,
        engine: &mut Engine,
        control: &Control,
    ) -> Result<Scene> {
        let options = options.with_spill(SpillTarget::None);
        let prepared = prepare(&job, sources.clone())?;
        let (mesh, measured, report) = whole(&job, &sources, &options, engine, control).await?;
        let (rule, cells_per_flag, is_open) = (job.rule, mesh.columns().cells_per_flag(), is_open(&report));
        let has_more = asks_for_more(&job, &options, &prepared);
        let (kept, report) = (None, Some(report));
        Ok(Scene {
            job,
            sources,
            options,
            prepared,
            rule,
            mesh,
            measured,
            report,
            cells_per_flag,
            kept,
            is_open,
            has_more,
        })
    }

    /// The mesh of the last update. A clone takes no more memory than later updates change.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// What the mesh has beside its cells, where the job asks for it.
    pub fn measured(&self) -> &Arc<Measured> {
        &self.measured
    }

    /// The report of the mesh; None where some rays were enough for the last update.
    pub fn report(&self) -> Option<&Report> {
        self.report.as_ref()
    }

    /// The report of the mesh as JSON; where some rays were enough for the last update, what the columns say of it.
    pub fn report_json(&self) -> String {
        // structs of numbers and texts always have a JSON form
        match &self.report {
            Some(report) => report.to_json(),
            None => serde_json::to_string(&ColumnsReport::new(&self.mesh)).unwrap_or_default(),
        }
    }

    /// Number of its cells of every flag, 0 to 255.
    pub fn cells_per_flag(&self) -> &[u64; 256] {
        &self.cells_per_flag
    }

    /// The job, with all edits.
    pub fn job(&self) -> &Job {
        &self.job
    }

    /// The job, to be edited: what its geometries are placed at, their flags and priorities, the domain, the cells, or anything else.
    pub fn job_mut(&mut self) -> &mut Job {
        &mut self.job
    }

    /// The surfaces of the job's geometries.
    pub fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// The surfaces of the job's geometries, to be replaced; as many as these. One that is replaced by its clone has not changed.
    pub fn sources_mut(&mut self) -> &mut Vec<Source> {
        &mut self.sources
    }

    /// Meshes what the edits since the last update have changed. After an error the mesh is as before, and the edits stay: change them, and
    /// update again.
    ///
    /// # Errors
    /// Those of [`pipeline::mesh`].
    pub async fn update(&mut self, engine: &mut Engine, control: &Control) -> Result<Update> {
        let prepared = prepare(&self.job, self.sources.clone())?;
        match self.recast(&prepared, control).await? {
            Ok(runs) => self.splice(prepared, &runs).await,
            Err(why) => self.mesh_whole(prepared, why, engine, control).await,
        }
    }

    /// Gives the scene another job with its surfaces, and meshes what that changes. After an error it has the job and the surfaces of before, too.
    ///
    /// # Errors
    /// Those of [`pipeline::mesh`].
    pub async fn update_to(
        &mut self,
        job: Job,
        sources: Vec<Source>,
        engine: &mut Engine,
        control: &Control,
    ) -> Result<Update> {
        let before = (replace(&mut self.job, job), replace(&mut self.sources, sources));
        let made = self.update(engine, control).await;
        if made.is_err() {
            (self.job, self.sources) = before;
        }
        made
    }

    /// The runs of the rays that changed, or why these are not enough.
    async fn recast(&mut self, prepared: &Prepared, control: &Control) -> Result<std::result::Result<SomeRuns, Whole>> {
        if self.has_more || asks_for_more(&self.job, &self.options, prepared) {
            return Ok(Err(Whole::Asked));
        }
        if !self.is_in_same_box(prepared)? {
            return Ok(Err(Whole::Box));
        }
        if self.is_open || !prepared.geometries.iter().all(Geometry::is_plain) {
            return Ok(Err(Whole::Surface));
        }
        match self.recast_kept(prepared, control).await {
            Ok(runs) => Ok(runs.ok_or(Whole::Surface)),
            Err(error) if error.code() == "memory" => Ok(Err(Whole::Memory)),
            Err(error) => Err(error),
        }
    }

    async fn recast_kept(&mut self, prepared: &Prepared, control: &Control) -> Result<Option<SomeRuns>> {
        if self.kept.is_none() {
            let max_bytes = self.job.max_memory.map_or(pipeline::DEFAULT_MAX_BYTES, |size| size.0);
            let memory = control.memory.again(max_bytes, self.options.program_bytes);
            let Prepared { geometries, whole, rays, .. } = &self.prepared;
            self.kept = Kept::new(geometries, whole, (rays, self.rule), &memory, control).await?;
        }
        match &mut self.kept {
            Some(kept) => kept.recast(&prepared.geometries, control).await,
            None => Ok(None),
        }
    }

    /// Whether cells and snapped corners are where they were.
    fn is_in_same_box(&self, prepared: &Prepared) -> Result<bool> {
        let of = |of: &Prepared| Frame::without_facets(&of.geometries, &of.whole).map(|frame| frame.fraction_bits);
        let facts = |of: &Prepared| (of.rays, of.unit.clone());
        let is_same = self.rule == self.job.rule
            && facts(&self.prepared) == facts(prepared)
            && self.prepared.whole == prepared.whole;
        Ok(is_same && of(&self.prepared)? == of(prepared)?)
    }

    async fn splice(&mut self, prepared: Prepared, runs: &SomeRuns) -> Result<Update> {
        let n_crossings = self.kept.as_ref().map_or(0, Kept::n_crossings);
        let changed = self.mesh.splice(runs, n_crossings, prepared.names.clone())?;
        for &ChangedRun { start, end, before, after, .. } in &changed {
            let n = u64::from(end - start);
            self.cells_per_flag[usize::from(before)] -= n;
            self.cells_per_flag[usize::from(after)] += n;
        }
        (self.prepared, self.report) = (prepared, None);
        // the mesh is made: nothing cancels what is said of it
        let mut findings = self.prepared.notices.clone();
        findings.extend(self.findings_without_cells(&Control::default()).await?);
        let findings = in_order_of_codes(findings);
        Ok(Update { changed: Some(changed), whole: None, rays: runs.n_rays(), findings })
    }

    async fn findings_without_cells(&self, control: &Control) -> Result<Vec<Finding>> {
        let Some(kept) = &self.kept else { return Ok(Vec::new()) };
        let Prepared { geometries, rays, .. } = &self.prepared;
        let has_none = |index: usize| self.cells_per_flag[usize::from(geometries[index].flag)] == 0;
        let (frame, ends) = kept.frame_of(geometries, has_none, control).await?;
        let cast = Cast { frame: &frame, rays, rule: self.rule };
        findings_without_cells((&self.job, &self.prepared), (&cast, &ends), &self.mesh, &self.cells_per_flag)
    }

    async fn mesh_whole(
        &mut self,
        prepared: Prepared,
        why: Whole,
        engine: &mut Engine,
        control: &Control,
    ) -> Result<Update> {
        // its memory is for the mesh
        self.kept = None;
        let (mesh, measured, report) = whole(&self.job, &self.sources, &self.options, engine, control).await?;
        let is_same_box = self.mesh.lines() == mesh.lines() && self.mesh.columns().rays() == mesh.columns().rays();
        let changed = match is_same_box {
            true => Some(self.mesh.columns().changed_runs(mesh.columns())?),
            false => None,
        };
        self.has_more = asks_for_more(&self.job, &self.options, &prepared);
        (self.is_open, self.rule, self.prepared) = (is_open(&report), self.job.rule, prepared);
        (self.cells_per_flag, self.mesh, self.measured) = (mesh.columns().cells_per_flag(), mesh, measured);
        let (rays, findings) = (self.mesh.columns().rays().n_rays(), report.mesh.findings.clone());
        self.report = Some(report);
        Ok(Update { changed, whole: Some(why), rays, findings })
    }
}

/// Makes the whole mesh of a job.
async fn whole(
    job: &Job,
    sources: &[Source],
    options: &MeshOptions,
    engine: &mut Engine,
    control: &Control,
) -> Result<(Mesh, Arc<Measured>, Report)> {
    let (mesh, mut facts) = pipeline::mesh(job, sources.to_vec(), options, engine, control).await?;
    let measured = Arc::new(Measured::take(&mut facts));
    Ok((mesh, measured, Report::new(facts, CallerFacts::default())))
}

fn is_open(report: &Report) -> bool {
    !report.mesh.open.is_empty() || report.mesh.odd_rays > 0
}

/// Whether a job asks for something that depends on more than the rays that change.
fn asks_for_more(job: &Job, options: &MeshOptions, prepared: &Prepared) -> bool {
    let Job { close_gaps, certify, part, .. } = job;
    let is_measured = *certify || options.walls || job.is_measured();
    let is_cut = part.is_some() || prepared.window.is_some();
    is_measured || is_cut || close_gaps.is_some() || options.doubt_mask
}
