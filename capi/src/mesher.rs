//! Meshers: they take jobs and surfaces, and hand out meshes.

use std::ffi::{c_char, c_void};
use std::ptr;
use std::sync::{Arc, Mutex};

use hexcast::control::{CancelToken, Control, Progress};
use hexcast::job::BackendChoice;
use hexcast::measured::Measured;
use hexcast::mesher::{Mesher, MesherOptions};
use hexcast::pipeline::MeshOptions;
use hexcast::{Error, Result};
use serde::Deserialize;

use crate::border::{behind, free, text};
use crate::error::{HexcastError, call, crashed};
use crate::facets::{HexcastFacets, job_with_sources};
use crate::mesh::{HexcastMesh, Origin};

/// A backend, the GPU or the CPU, that meshes one job after the other. Freed by hexcast_mesher_free.
pub struct HexcastMesher {
    pub(crate) mesher: Mutex<Mesher>,
    pub(crate) options: MeshOptions,
}

/// Options of a mesher, as JSON.
#[derive(Deserialize, Default)]
#[serde(default, deny_unknown_fields)]
struct Wanted {
    backend: BackendChoice,
    adapter: Option<String>,
    doubt: bool,
    walls: bool,
}

impl Wanted {
    fn of_json(json: &str) -> Result<Wanted> {
        serde_json::from_str(json).map_err(|error| {
            let hint = "give {\"backend\": \"auto\", \"gpu\" or \"cpu\", \"adapter\": a part of the GPU's name, \"doubt\" and \"walls\": true or false}";
            Error::new("job-value", format!("the options of the mesher: {error}"), hint)
        })
    }

    fn open(self) -> Result<HexcastMesher> {
        let options = MesherOptions::default().with_backend(self.backend);
        let mesher = Mesher::new(self.adapter.into_iter().fold(options, MesherOptions::with_adapter))?;
        let options = MeshOptions::default().with_doubt_mask(self.doubt).with_walls(self.walls);
        Ok(HexcastMesher { mesher: Mutex::new(mesher), options })
    }
}

/// Opens a mesher. `options` is JSON, or NULL for the defaults: {"backend": "auto", "gpu" or "cpu", "adapter": a part of the name of
/// the GPU, "doubt": true for a mask of doubtful cells with each mesh (hexcast_mesh_doubt), "walls": true to remember whose facets the faces between
/// flags are, for "patches": "solid" of hexcast_mesh_write}. With "auto" the CPU meshes where there is no GPU. Returns NULL for an error.
///
/// Errors: job-value for wrong options; no-adapter and device-... where the GPU that was asked for is not there or cannot be used.
///
/// # Safety
/// `options` is NULL or a text; `error` is NULL or a place for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_mesher_new(
    options: *const c_char,
    error: *mut *mut HexcastError,
) -> *mut HexcastMesher {
    let open = || {
        if options.is_null() {
            return Wanted::default().open();
        }
        // SAFETY: it is a text, for which the caller vouches
        Wanted::of_json(unsafe { text(options, "the options of the mesher") }?)?.open()
    };
    // SAFETY: the caller vouches for the place of the error
    unsafe { call(error, open) }.map_or(ptr::null_mut(), |mesher| Box::into_raw(Box::new(mesher)))
}

/// Frees a mesher.
///
/// # Safety
/// `mesher` is NULL or a mesher that was not freed and that no thread uses.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_mesher_free(mesher: *mut HexcastMesher) {
    // SAFETY: `hexcast_mesher_new` made it with `Box::into_raw`, and the caller vouches for the rest
    unsafe { free(mesher) };
}

/// Meshes a job, which is JSON with the keys of the job file. "window": [i0, j0, k0, i1, j1, k1] meshes only these cells of the box,
/// the end exclusive, with the flags that the whole mesh has there; "part": {"index": 1 to n, "of": [1, 1, n]} one of n windows that
/// cost about the same. "backend" is not looked at: the mesher has one. Facets are taken from `facets` where one has the name of the
/// job's file, and are copied; other files are read from disk. `facets` may be NULL where `n_facets` is 0. Returns NULL for an error.
///
/// Errors: job-syntax, job-value, job-conflict and job-empty, domain-empty, lines-... and too-many-... for the job; job-value and job-conflict for facets that
/// are not as HexcastFacets says; io where a file cannot be read; stl-... and file-syntax where it is no surface; surface-open; memory; device-... for the
/// GPU.
///
/// # Safety
/// `mesher` is a mesher that was not freed; `job` is a text; `facets` points to so many facets, whose `corners` and `file` are as
/// they say; `error` is NULL or a place for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_mesh(
    mesher: *const HexcastMesher,
    job: *const c_char,
    facets: *const HexcastFacets,
    n_facets: usize,
    error: *mut *mut HexcastError,
) -> *mut HexcastMesh {
    // SAFETY: the caller vouches for all of it
    unsafe { hexcast_mesh_with_progress(mesher, job, facets, n_facets, None, ptr::null_mut(), error) }
}

/// Is told how far a mesh has come: so many of `n_rays` rays are done. `user` is what the caller of hexcast_mesh_with_progress gave. Returns
/// 0 to go on, any other number to cancel. It must return: neither longjmp() nor an exception may leave it.
pub type HexcastProgress = Option<unsafe extern "C" fn(rays_done: u64, n_rays: u64, user: *mut c_void) -> i32>;

/// A caller's function, and what it is called with.
struct Caller(unsafe extern "C" fn(u64, u64, *mut c_void) -> i32, *mut c_void);

// SAFETY: it is called on the thread that called `hexcast_mesh_with_progress`, before that returns, and nowhere else
unsafe impl Send for Caller {}
// SAFETY: as above
unsafe impl Sync for Caller {}

impl Caller {
    /// Whether it says that the mesh shall go on.
    fn goes_on(&self, Progress { rays_done, n_rays, .. }: Progress) -> bool {
        // SAFETY: the caller of `hexcast_mesh_with_progress` vouches for the function and its argument until that returns
        unsafe { self.0(rays_done, n_rays, self.1) == 0 }
    }
}

/// Asks a function of the caller's whether to go on after every band of rays, if there is one.
pub(crate) fn control(progress: HexcastProgress, user: *mut c_void) -> Control {
    let Some(function) = progress else { return Control::default() };
    let (caller, cancel) = (Caller(function, user), CancelToken::default());
    let asked = cancel.clone();
    let on_progress = move |progress| {
        // once is enough
        if !asked.is_cancelled() && !caller.goes_on(progress) {
            asked.cancel();
        }
    };
    let mut control = Control::with_progress(on_progress);
    control.cancel = cancel;
    control
}

/// Meshes a job as hexcast_mesh does, and calls `progress` on the calling thread after every band of rays, a few times a second for a
/// large mesh, with `user`. Where it returns another number than 0 the mesh is cancelled: NULL is returned, with the error
/// "cancelled". `progress` may be NULL, and must not use the mesher, which is busy.
///
/// Errors: those of hexcast_mesh; cancelled.
///
/// # Safety
/// As for hexcast_mesh; `progress` is NULL or a function that may be called with `user` until this function returns.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_mesh_with_progress(
    mesher: *const HexcastMesher,
    job: *const c_char,
    facets: *const HexcastFacets,
    n_facets: usize,
    progress: HexcastProgress,
    user: *mut c_void,
    error: *mut *mut HexcastError,
) -> *mut HexcastMesh {
    let mesh = || {
        // SAFETY: the caller vouches for it
        let mesher = unsafe { behind(mesher, "the mesher") }?;
        // SAFETY: the caller vouches for the job, the facets and what these point to
        let (job, sources) = unsafe { job_with_sources(job, (facets, n_facets), &[]) }?;
        let origin = Origin::new(&job, &sources);
        // a mesher that crashed is in no state to go on
        let mut open = mesher.mesher.lock().map_err(|_| crashed())?;
        let (mesh, mut report) = open.mesh_sources(&job, sources, &mesher.options, &control(progress, user))?;
        let measured = Arc::new(Measured::take(&mut report.mesh));
        Ok(HexcastMesh::new(mesh, (Some(&report.mesh), &report.to_json()), measured, origin))
    };
    // SAFETY: the caller vouches for the place of the error
    unsafe { call(error, mesh) }.map_or(ptr::null_mut(), |mesh| Box::into_raw(Box::new(mesh)))
}

/// Threads may share a mesh and a mesher.
const _: () = {
    const fn is_shared<T: Send + Sync>() {}
    is_shared::<HexcastMesh>();
    is_shared::<HexcastMesher>();
};
