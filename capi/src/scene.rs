//! Scenes: meshes that follow the edits of their jobs.

use std::ffi::{CString, c_char, c_void};
use std::ptr;
use std::sync::Mutex;

use hexcast::Scene;
use hexcast::scene::Update;

use crate::border::{array_mut, behind, c_text, free};
use crate::error::{HexcastError, call, crashed, status};
use crate::facets::{HexcastFacets, job_with_sources};
use crate::mesh::{HexcastMesh, Origin};
use crate::mesher::{HexcastMesher, HexcastProgress, control};

/// A job whose geometries move, and its mesh, of which each update makes what changed. Freed by hexcast_scene_free.
pub struct HexcastScene(Mutex<Held>);

struct Held {
    scene: Scene,
    told: Option<Told>,
}

/// What the last update did.
struct Told {
    json: CString,
    changed: Option<Vec<HexcastChangedRun>>,
}

/// Consecutive cells of a column whose flag changed.
#[repr(C)]
pub struct HexcastChangedRun {
    /// The column, as hexcast_mesh_columns counts them.
    pub column: u64,
    /// First cell.
    pub start: u32,
    /// The cell after the last.
    pub end: u32,
    /// The flag that they had.
    pub before: u8,
    /// The flag that they have.
    pub after: u8,
}

impl Told {
    fn of(update: &Update) -> Told {
        let of_run = |run: &hexcast::columns::ChangedRun| HexcastChangedRun {
            column: run.ray,
            start: run.start,
            end: run.end,
            before: run.before,
            after: run.after,
        };
        let changed = update.changed.as_ref().map(|runs| runs.iter().map(of_run).collect());
        Told { json: c_text(&update.to_json()), changed }
    }
}

/// Meshes a job whose geometries will move, as hexcast_mesh_with_progress does. Give the job a "domain": without one the box follows the
/// geometries, and every edit that moves its sides is a whole mesh. Returns NULL for an error.
///
/// Errors: those of hexcast_mesh_with_progress.
///
/// # Safety
/// As for hexcast_mesh_with_progress.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_scene_new(
    mesher: *const HexcastMesher,
    job: *const c_char,
    facets: *const HexcastFacets,
    n_facets: usize,
    progress: HexcastProgress,
    user: *mut c_void,
    error: *mut *mut HexcastError,
) -> *mut HexcastScene {
    let act = || {
        // SAFETY: the caller vouches for it
        let mesher = unsafe { behind(mesher, "the mesher") }?;
        // SAFETY: the caller vouches for the job, the facets and what these point to
        let (job, sources) = unsafe { job_with_sources(job, (facets, n_facets), &[]) }?;
        let mut open = mesher.mesher.lock().map_err(|_| crashed())?;
        let scene = open.scene(job, sources, mesher.options.clone(), &control(progress, user))?;
        Ok(HexcastScene(Mutex::new(Held { scene, told: None })))
    };
    // SAFETY: the caller vouches for the place of the error
    unsafe { call(error, act) }.map_or(ptr::null_mut(), |scene| Box::into_raw(Box::new(scene)))
}

/// Gives a scene another job, and meshes what that changes: the same cells as the whole mesh of that job. `facets` are those that are new or
/// other ones: a geometry whose "file" has none of them keeps the facets that the scene has under this name, also those that were read from
/// disk. Any mesher may update it. Returns 0, or 1 for an error, after which the mesh is as before.
///
/// Errors: those of hexcast_mesh_with_progress.
///
/// # Safety
/// `scene` is a scene that was not freed; else as for hexcast_mesh_with_progress.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_scene_update(
    scene: *const HexcastScene,
    mesher: *const HexcastMesher,
    job: *const c_char,
    facets: *const HexcastFacets,
    n_facets: usize,
    progress: HexcastProgress,
    user: *mut c_void,
    error: *mut *mut HexcastError,
) -> i32 {
    let act = || {
        // SAFETY: the caller vouches for both
        let (scene, mesher) = unsafe { (behind(scene, "the scene")?, behind(mesher, "the mesher")?) };
        let mut held = scene.0.lock().map_err(|_| crashed())?;
        // SAFETY: the caller vouches for the job, the facets and what these point to
        let (job, sources) = unsafe { job_with_sources(job, (facets, n_facets), held.scene.sources()) }?;
        let mut open = mesher.mesher.lock().map_err(|_| crashed())?;
        held.told = Some(Told::of(&open.update_to(&mut held.scene, job, sources, &control(progress, user))?));
        Ok(())
    };
    // SAFETY: the caller vouches for the place of the error
    status(unsafe { call(error, act) })
}

/// What the last update did, as JSON: "whole": null where some rays were enough, else why the whole was meshed ("box", "surface", "asked" or
/// "memory"), "rays": how many were made again, "findings" as in a report. Lives until the next update; "" before the first, and for NULL.
///
/// # Safety
/// `scene` is NULL or a scene that was not freed, and that no thread updates.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_scene_told(scene: *const HexcastScene) -> *const c_char {
    // SAFETY: the caller vouches for it
    let held = unsafe { scene.as_ref() }.and_then(|scene| scene.0.lock().ok());
    held.and_then(|held| held.told.as_ref().map(|told| told.json.as_ptr())).unwrap_or(c"".as_ptr())
}

/// Hands out the runs of cells whose flags the last update changed, in the order of columns and cells, without a copy. Where the box has other
/// lines or columns all may have: `*runs` is NULL and `*n_runs` SIZE_MAX. Before the first update there are none. They live until the next
/// update or hexcast_scene_free. Returns 0, or 1 for an error.
///
/// Errors: job-value for NULL.
///
/// # Safety
/// `scene` is a scene that was not freed, and that no thread updates; `runs` and `n_runs` point to one each; `error` is NULL or a place for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_scene_changed(
    scene: *const HexcastScene,
    runs: *mut *const HexcastChangedRun,
    n_runs: *mut usize,
    error: *mut *mut HexcastError,
) -> i32 {
    let act = || {
        // SAFETY: the caller vouches for both
        let (scene, runs) = unsafe { (behind(scene, "the scene")?, array_mut(runs, 1, "runs")?) };
        // SAFETY: as above
        let n_runs = unsafe { array_mut(n_runs, 1, "n_runs") }?;
        let held = scene.0.lock().map_err(|_| crashed())?;
        (runs[0], n_runs[0]) = match &held.told {
            None => (ptr::null(), 0),
            Some(Told { changed: None, .. }) => (ptr::null(), usize::MAX),
            Some(Told { changed: Some(changed), .. }) => (changed.as_ptr(), changed.len()),
        };
        Ok(())
    };
    // SAFETY: the caller vouches for the place of the error
    status(unsafe { call(error, act) })
}

/// The mesh of the last update, a handle of its own: it stays as it is when the scene goes on, shares with it what does not change, and is
/// freed by hexcast_mesh_free. Where some rays were enough for that update, its report has what the columns say. Returns NULL for an error.
///
/// Errors: job-value for NULL.
///
/// # Safety
/// `scene` is a scene that was not freed; `error` is NULL or a place for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_scene_mesh(
    scene: *const HexcastScene,
    error: *mut *mut HexcastError,
) -> *mut HexcastMesh {
    let act = || {
        // SAFETY: the caller vouches for it
        let scene = unsafe { behind(scene, "the scene") }?;
        let held = scene.0.lock().map_err(|_| crashed())?;
        let scene = &held.scene;
        let facts = scene.report().map(|report| &report.mesh);
        Ok(HexcastMesh::new(
            scene.mesh().clone(),
            (facts, &scene.report_json()),
            scene.measured().clone(),
            Origin::new(scene.job(), scene.sources()),
        ))
    };
    // SAFETY: the caller vouches for the place of the error
    unsafe { call(error, act) }.map_or(ptr::null_mut(), |mesh| Box::into_raw(Box::new(mesh)))
}

/// Frees a scene.
///
/// # Safety
/// `scene` is NULL or a scene that was not freed and that no thread uses.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_scene_free(scene: *mut HexcastScene) {
    // SAFETY: `hexcast_scene_new` made it with `Box::into_raw`, and the caller vouches for the rest
    unsafe { free(scene) };
}

/// Threads may share a scene.
const _: () = {
    const fn is_shared<T: Send + Sync>() {}
    is_shared::<HexcastScene>();
};
