//! Meshes: numbers of cells, lines, flags of boxes, what was measured, the report.

use std::ffi::{CString, c_char, c_void};
use std::path::{Path, PathBuf};
use std::ptr;
use std::sync::{Arc, Mutex, PoisonError};

use hexcast::control::Control;
use hexcast::job::{Job, ZarrJob};
use hexcast::measured::Measured;
use hexcast::mesh::Mesh;
use hexcast::report::{ColumnsReport, MeshFacts};
use hexcast::sources::Source;
use hexcast::write::Array;
use hexcast::{Error, Result};

use crate::border::{Number, array, array_mut, behind, c_text, free, text};
use crate::error::{HexcastError, call, status};

/// A finished mesh. Freed by hexcast_mesh_free.
pub struct HexcastMesh {
    pub(crate) mesh: Mesh,
    report: CString,
    /// First cell and end, exclusive, in the box, and the cells of that.
    window: [[u32; 3]; 3],
    measured: Arc<Measured>,
    doubt: Option<Box<HexcastMesh>>,
    /// What files lack that were written, as JSON; the last is of the last file.
    lacks: Mutex<Vec<CString>>,
    pub(crate) origin: Origin,
}

/// What a mesh was made of, as far as its files need it.
#[derive(Clone)]
pub(crate) struct Origin {
    /// Files of its surfaces, which no output replaces.
    pub(crate) inputs: Vec<PathBuf>,
    /// Shapes of the shards of Zarr stores.
    pub(crate) zarr: ZarrJob,
}

impl Origin {
    pub(crate) fn new(job: &Job, sources: &[Source]) -> Origin {
        // what was in memory has no hash
        let read = sources.iter().filter(|source| source.blake3.is_some());
        let inputs = read.filter_map(|source| Path::new(&source.file).canonicalize().ok()).collect();
        Origin { inputs, zarr: job.zarr.unwrap_or_default() }
    }
}

impl HexcastMesh {
    /// Of a mesh, the facts of its report, which is also there as JSON, and what it has beside its cells.
    pub(crate) fn new(
        mesh: Mesh,
        (facts, report): (Option<&MeshFacts>, &str),
        measured: Arc<Measured>,
        origin: Origin,
    ) -> HexcastMesh {
        let dims = mesh.dims();
        let window = facts.and_then(|facts| facts.window.as_ref());
        let window = window.map_or([[0; 3], dims, dims], |w| [w.first, w.end, w.of]);
        let doubt = measured.doubt.as_ref().map(|mask| {
            let report = c_text(&serde_json::to_string(&ColumnsReport::new(mask)).unwrap_or_default());
            let (mesh, measured, origin) = (mask.clone(), Arc::default(), origin.clone());
            Box::new(HexcastMesh { mesh, report, window, measured, doubt: None, lacks: Mutex::default(), origin })
        });
        HexcastMesh { mesh, report: c_text(report), window, measured, doubt, lacks: Mutex::default(), origin }
    }

    /// Remembers what a file lacks that was written.
    pub(crate) fn say(&self, lacks: &[String]) {
        // a list of texts always has a JSON form
        let text = c_text(&serde_json::to_string(lacks).unwrap_or_default());
        let mut said = self.lacks.lock().unwrap_or_else(PoisonError::into_inner);
        if said.last() != Some(&text) {
            // those before it stay: callers may read them
            said.push(text);
        }
    }
}

/// An array of a mesh, and what its numbers are.
#[repr(C)]
pub struct HexcastArray {
    /// Their type as NumPy names it: "|u1" uint8_t, "|i1" int8_t, "<i2" int16_t, "<i4" int32_t, "<u4" uint32_t, "<u8" uint64_t, "<f4" float,
    /// "<f8" double; a text that ends with a zero byte.
    pub kind: [c_char; 4],
    /// Number of axes, 1 to 4.
    pub n_axes: u32,
    /// Length of each axis, the last one fastest; 0 for those that it does not have.
    pub shape: [u64; 4],
    /// Bytes of all numbers.
    pub n_bytes: u64,
}

impl Number for HexcastArray {}

/// Puts the numbers of cells on x, y and z at `dims`: those of the window where the job has one. Returns 0, or 1 for an error.
///
/// Errors: job-value for NULL.
///
/// # Safety
/// `mesh` is a mesh that was not freed; `dims` points to 3 numbers; `error` is NULL or a place for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_mesh_dims(
    mesh: *const HexcastMesh,
    dims: *mut u32,
    error: *mut *mut HexcastError,
) -> i32 {
    let act = || {
        // SAFETY: the caller vouches for both
        let (mesh, dims) = unsafe { (behind(mesh, "the mesh")?, array_mut(dims, 3, "dims")?) };
        dims.copy_from_slice(&mesh.mesh.dims());
        Ok(())
    };
    // SAFETY: the caller vouches for the place of the error
    status(unsafe { call(error, act) })
}

/// Puts the cells of the whole box that the mesh has at `first` and `end`, the end exclusive, and the numbers of cells of the whole
/// box at `of`; 3 numbers each. Returns 0, or 1 for an error.
///
/// Errors: job-value for NULL.
///
/// # Safety
/// `mesh` is a mesh that was not freed; `first`, `end` and `of` point to 3 numbers each that are not those of another; `error` is NULL
/// or a place for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_mesh_window(
    mesh: *const HexcastMesh,
    first: *mut u32,
    end: *mut u32,
    of: *mut u32,
    error: *mut *mut HexcastError,
) -> i32 {
    let act = || {
        // SAFETY: the caller vouches for it
        let mesh = unsafe { behind(mesh, "the mesh") }?;
        for (numbers, (place, name)) in mesh.window.iter().zip([(first, "first"), (end, "end"), (of, "of")]) {
            // SAFETY: the caller vouches for it
            unsafe { array_mut(place, 3, name) }?.copy_from_slice(numbers);
        }
        Ok(())
    };
    // SAFETY: the caller vouches for the place of the error
    status(unsafe { call(error, act) })
}

/// Puts the mesh lines of an axis (0, 1 or 2 for x, y or z) at `lines`, in the unit of the surfaces: one more than cells. `n` is the
/// length of `lines` and must be that. Returns 0, or 1 for an error.
///
/// Errors: job-value for NULL, for another axis and for another length.
///
/// # Safety
/// `mesh` is a mesh that was not freed; `lines` points to `n` numbers; `error` is NULL or a place for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_mesh_lines(
    mesh: *const HexcastMesh,
    axis: u32,
    lines: *mut f64,
    n: usize,
    error: *mut *mut HexcastError,
) -> i32 {
    let act = || {
        // SAFETY: the caller vouches for both
        let (mesh, lines) = unsafe { (behind(mesh, "the mesh")?, array_mut(lines, n, "lines")?) };
        let dims = mesh.mesh.dims();
        let Some(&n_cells) = dims.get(axis as usize) else {
            return Err(Error::new("job-value", format!("axis {axis} is none of 0, 1 and 2"), ""));
        };
        if n != n_cells as usize + 1 {
            let message = format!("lines has {n} numbers; {n_cells} cells have {} lines", u64::from(n_cells) + 1);
            return Err(Error::new("job-value", message, "give one more than the cells of the axis"));
        }
        for (index, line) in (0..=n_cells).zip(lines) {
            *line = mesh.mesh.lines().line(axis as usize, index);
        }
        Ok(())
    };
    // SAFETY: the caller vouches for the place of the error
    status(unsafe { call(error, act) })
}

/// Puts the flags of a box of cells at `flags`, a byte a cell, x fastest: flags[x + nx * (y + ny * z)] with nx = end[0] - first[0] and
/// so on. The cells are counted from the first of the mesh, of the window where the job has one; the end is exclusive. `n_bytes` is the
/// length of `flags` and must be the number of cells of the box. Returns 0, or 1 for an error.
///
/// Errors: job-value for NULL, for a box that is not inside the mesh, and for another length.
///
/// # Safety
/// `mesh` is a mesh that was not freed; `first` and `end` point to 3 numbers each; `flags` points to `n_bytes` bytes that no other
/// thread uses meanwhile; `error` is NULL or a place for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_mesh_fill_box(
    mesh: *const HexcastMesh,
    first: *const u32,
    end: *const u32,
    flags: *mut u8,
    n_bytes: usize,
    error: *mut *mut HexcastError,
) -> i32 {
    let act = || {
        // SAFETY: the caller vouches for all of them
        let (mesh, flags) = unsafe { (behind(mesh, "the mesh")?, array_mut(flags, n_bytes, "flags")?) };
        // SAFETY: as above
        let [first, end] = unsafe { [array(first, 3, "first")?, array(end, 3, "end")?] };
        fill(&mesh.mesh, first, end, flags)
    };
    // SAFETY: the caller vouches for the place of the error
    status(unsafe { call(error, act) })
}

fn fill(mesh: &Mesh, first: &[u32], end: &[u32], flags: &mut [u8]) -> Result<()> {
    mesh.fill_box(&[0, 1, 2].map(|axis| first[axis]..end[axis]), flags)
}

/// Says what an array of a mesh is. `of` is "links", "fractions", "staggered", "conformal", "distance" or "tensors", which the job asked for by these keys, and `name` one of the
/// arrays that docs/links.md, docs/fractions.md, docs/staggered.md, docs/conformal.md, docs/distance.md or docs/tensors.md lists, such as "q". Returns 0, or 1 for an error.
///
/// Errors: job-value for NULL and for names that there are not; job-conflict where the job did not ask for it.
///
/// # Safety
/// `mesh` is a mesh that was not freed; `of` and `name` are texts; `array` points to one; `error` is NULL or a place for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_mesh_array(
    mesh: *const HexcastMesh,
    of: *const c_char,
    name: *const c_char,
    array: *mut HexcastArray,
    error: *mut *mut HexcastError,
) -> i32 {
    let act = || {
        // SAFETY: the caller vouches for all of them
        let (mesh, of, name) = unsafe { (behind(mesh, "the mesh")?, text(of, "of")?, text(name, "name")?) };
        // SAFETY: as above
        let out = unsafe { array_mut(array, 1, "array") }?;
        with_array(mesh, (of, name), |array| {
            let (kind, shape) = (array.kind().bytes().take(3), array.shape());
            out[0].kind.iter_mut().zip(kind).for_each(|(to, byte)| *to = byte as c_char);
            out[0].shape.iter_mut().zip(shape).for_each(|(to, n)| *to = *n);
            (out[0].n_axes, out[0].n_bytes) = (shape.len() as u32, array.n_bytes());
            Ok(())
        })
    };
    // SAFETY: the caller vouches for the place of the error
    status(unsafe { call(error, act) })
}

/// Puts the numbers of an array, as hexcast_mesh_array describes it, at `bytes`, little-endian. `n_bytes` is the length of `bytes` and must be
/// that of the array. Returns 0, or 1 for an error.
///
/// Errors: those of hexcast_mesh_array; job-value for another length.
///
/// # Safety
/// `mesh` is a mesh that was not freed; `of` and `name` are texts; `bytes` points to `n_bytes` bytes that no other thread uses meanwhile;
/// `error` is NULL or a place for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_mesh_fill_array(
    mesh: *const HexcastMesh,
    of: *const c_char,
    name: *const c_char,
    bytes: *mut c_void,
    n_bytes: usize,
    error: *mut *mut HexcastError,
) -> i32 {
    let act = || {
        // SAFETY: the caller vouches for all of them
        let (mesh, of, name) = unsafe { (behind(mesh, "the mesh")?, text(of, "of")?, text(name, "name")?) };
        // SAFETY: as above
        let out = unsafe { array_mut(bytes.cast::<u8>(), n_bytes, "bytes") }?;
        with_array(mesh, (of, name), |array| array.fill(out, &Control::default()))
    };
    // SAFETY: the caller vouches for the place of the error
    status(unsafe { call(error, act) })
}

fn with_array(mesh: &HexcastMesh, (of, name): (&str, &str), act: impl FnOnce(&Array) -> Result<()>) -> Result<()> {
    let arrays = mesh.measured.arrays(&mesh.mesh, of)?;
    let Some(array) = arrays.iter().find(|array| array.name() == name) else {
        let names: Vec<&str> = arrays.iter().map(Array::name).collect();
        let message = format!("{of} of this mesh have no array \"{name}\"");
        return Err(Error::new("job-value", message, format!("name one of {}", names.join(", "))));
    };
    act(array)
}

/// The cells that the rays of open surfaces do not decide: a mesh with flag 1 there. NULL unless the mesher has the option "doubt". Lives as long as the mesh,
/// and must not be freed.
///
/// # Safety
/// `mesh` is NULL or a mesh that was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_mesh_doubt(mesh: *const HexcastMesh) -> *const HexcastMesh {
    // SAFETY: it is NULL or alive, for which the caller vouches
    let doubt = unsafe { mesh.as_ref() }.and_then(|mesh| mesh.doubt.as_deref());
    doubt.map_or(ptr::null(), ptr::from_ref)
}

/// What the file lacks of the mesh that was written last (hexcast_mesh_write), as a JSON list of sentences: parts of cut cells that its format cannot hold. "[]" where it lacks
/// nothing, and before the first file; NULL for NULL. Lives as long as the mesh.
///
/// # Safety
/// `mesh` is NULL or a mesh that was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_mesh_lacks(mesh: *const HexcastMesh) -> *const c_char {
    // SAFETY: the caller vouches for it
    let Some(mesh) = (unsafe { mesh.as_ref() }) else { return ptr::null() };
    let said = mesh.lacks.lock().unwrap_or_else(PoisonError::into_inner);
    said.last().map_or(c"[]".as_ptr(), |text| text.as_ptr())
}

/// The report as JSON; NULL for NULL. Lives as long as the mesh.
///
/// # Safety
/// `mesh` is NULL or a mesh that was not freed.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_mesh_report(mesh: *const HexcastMesh) -> *const c_char {
    // SAFETY: it is NULL or alive, for which the caller vouches
    unsafe { mesh.as_ref() }.map_or(ptr::null(), |mesh| mesh.report.as_ptr())
}

/// Frees a mesh.
///
/// # Safety
/// `mesh` is NULL or a mesh that was not freed and that no thread uses.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_mesh_free(mesh: *mut HexcastMesh) {
    // SAFETY: `hexcast_mesh` made it with `Box::into_raw`, and the caller vouches for the rest
    unsafe { free(mesh) };
}
