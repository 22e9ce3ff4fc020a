//! Meshes: numbers of cells, lines, flags of boxes, the report.

use std::ffi::{CString, c_char};
use std::ptr;

use hexcast::mesh::Mesh;
use hexcast::report::Report;
use hexcast::{Error, Result};

use crate::border::{array, array_mut, behind, c_text, free};
use crate::error::{HexcastError, call};

/// A finished mesh. Freed by hexcast_mesh_free.
pub struct HexcastMesh {
    mesh: Mesh,
    report: CString,
    /// First cell and end, exclusive, in the box, and the cells of that.
    window: [[u32; 3]; 3],
}

impl HexcastMesh {
    pub(crate) fn new(mesh: Mesh, report: &Report) -> HexcastMesh {
        let dims = mesh.dims();
        let window = report.mesh.window.as_ref().map_or([[0; 3], dims, dims], |w| [w.first, w.end, w.of]);
        HexcastMesh { mesh, report: c_text(&report.to_json()), window }
    }
}

/// What all functions that return a number return.
fn status(done: Option<()>) -> i32 {
    if done.is_some() { 0 } else { 1 }
}

/// Puts the numbers of cells on x, y and z at `dims`: those of the window where the job has one. Returns 0, or 1 for an error.
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
            *line = mesh.mesh.lines.line(axis as usize, index);
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
