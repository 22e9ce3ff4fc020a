//! Runs: the columns of a mesh as it holds them, so that nobody need expand the cells.

use hexcast::Error;

use crate::border::{Number, array_mut, behind};
use crate::error::{HexcastError, call, status};
use crate::mesh::HexcastMesh;

/// The columns of a mesh. Each holds the cells of a line along `axis`; column i + counts[0] * j has cell i on axis `across[0]` and cell j on axis
/// `across[1]`. Cells are counted from the first of the mesh.
#[repr(C)]
pub struct HexcastColumns {
    /// Axis of the columns: 0, 1 or 2 for x, y or z.
    pub axis: u32,
    /// The other two axes, ascending.
    pub across: [u32; 2],
    /// Number of columns on each of these.
    pub counts: [u32; 2],
    /// Number of cells of a column.
    pub depth: u32,
    /// Number of columns: counts[0] * counts[1].
    pub n_columns: u64,
    /// Number of runs of all columns.
    pub n_runs: u64,
}

impl Number for HexcastColumns {}

/// Puts what the columns of a mesh are at `columns`. Returns 0, or 1 for an error.
///
/// Errors: job-value for NULL.
///
/// # Safety
/// `mesh` is a mesh that was not freed; `columns` points to one; `error` is NULL or a place for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_mesh_columns(
    mesh: *const HexcastMesh,
    columns: *mut HexcastColumns,
    error: *mut *mut HexcastError,
) -> i32 {
    let act = || {
        // SAFETY: the caller vouches for both
        let (mesh, out) = unsafe { (behind(mesh, "the mesh")?, array_mut(columns, 1, "columns")?) };
        let columns = mesh.mesh.columns();
        let rays = columns.rays();
        out[0] = HexcastColumns {
            axis: rays.axis as u32,
            across: rays.across.map(|axis| axis as u32),
            counts: rays.counts,
            depth: rays.depth,
            n_columns: rays.n_rays(),
            n_runs: columns.n_runs(),
        };
        Ok(())
    };
    // SAFETY: the caller vouches for the place of the error
    status(unsafe { call(error, act) })
}

/// Hands out the runs of columns from `column` on, without a copy: those of at most `n_columns` (1 and more) that lie together in memory. `*n_given` is the
/// number of these columns, at least 1, and `*runs` their runs, column after column: those of the first are (*runs)[0] to
/// (*runs)[ends[0] - 1], those of the next (*runs)[ends[0]] to (*runs)[ends[1] - 1], and so on; a column may have none. `ends` has room for
/// `n_columns` numbers, of which `*n_given` are written. To go over all columns, call it again with column + *n_given.
///
/// A run is its first cell * 256 + its flag: HEXCAST_RUN_FIRST(run) and HEXCAST_RUN_FLAG(run). The runs of a column ascend. A run ends where the next one begins,
/// the last one at `depth` (hexcast_mesh_columns). Cells before the first run have flag 0. Neighbouring runs differ in flag, which may be 0.
///
/// The runs belong to the mesh: they are not to be changed, and are there until hexcast_mesh_free. Any number of threads may walk
/// them. Returns 0, or 1 for an error.
///
/// Errors: job-value for NULL, for n_columns = 0, and where the mesh has no such column.
///
/// # Safety
/// `mesh` is a mesh that was not freed; `ends` points to room for `n_columns` numbers that no other thread uses meanwhile; `runs` and `n_given` point
/// to one each; `error` is NULL or a place for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_mesh_runs(
    mesh: *const HexcastMesh,
    column: u64,
    n_columns: usize,
    ends: *mut u64,
    runs: *mut *const u32,
    n_given: *mut usize,
    error: *mut *mut HexcastError,
) -> i32 {
    let act = || {
        // SAFETY: the caller vouches for all of them
        let (mesh, runs) = unsafe { (behind(mesh, "the mesh")?, array_mut(runs, 1, "runs")?) };
        // SAFETY: as above
        let n_given = unsafe { array_mut(n_given, 1, "n_given") }?;
        if n_columns == 0 {
            return Err(Error::new("job-value", "n_columns is 0", "ask for at least one column"));
        }
        let n = mesh.mesh.columns().rays().n_rays();
        if column >= n {
            let message = format!("there is no column {column}: the mesh has {n}, counted from 0");
            return Err(Error::new("job-value", message, "stop at n_columns of hexcast_mesh_columns"));
        }
        let (found, found_ends) = mesh.mesh.columns().together(column, n_columns)?;
        n_given[0] = found_ends.len();
        runs[0] = found.as_ptr();
        // SAFETY: the caller vouches for `n_columns` of them, and there are no more
        let ends = unsafe { array_mut(ends, n_given[0], "ends") }?;
        ends.iter_mut().zip(found_ends).for_each(|(place, end)| *place = end);
        Ok(())
    };
    // SAFETY: the caller vouches for the place of the error
    status(unsafe { call(error, act) })
}
