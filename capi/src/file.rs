//! Files of a mesh, and their options.

use std::ffi::c_char;
use std::path::Path;

use hexcast::control::Control;
use hexcast::files::saved::{FileOptions, save};

use crate::border::{behind, text};
use crate::error::{HexcastError, call, status};
use crate::mesh::HexcastMesh;

/// Writes the mesh to a file, or to the files or the folder of a solver or of Zarr, in the format that the end of `path` names, as
/// `hexcast mesh -o` does: .raw, .npy, .npz, .vti, .vtr, .hxc, .zarr.zip, .zarr; .foam or constant/polyMesh, .inp, .msh, .xdmf, .csx.xml, .in, .eb,
/// geometry.xml, .nrrd, .vox, .binvox. A mesh of a window or part is written as a mesh of these cells alone, where they are in space. What has
/// the name is replaced when all is written, not before; where it fails, nothing is left, and where the process is killed, a folder .hexcast-....part. A .raw gets a file .raw.json beside it.
///
/// `options` is JSON, or NULL for the defaults: {"compress": level of zlib, 0 for none to 9 (6), "bits": eight cells a byte (false), "axis_order": "zyx" or "xyz",
/// "map": {"flag": what is written for it}, "export_flags": [flags] (all but 0), "ascii": text in place of binary numbers (false), "patches":
/// "side", "neighbour" or "solid" (for which the mesher needs the option "walls"), "open_patches": [solids]}. They are those of the command line. .foam has cut cells where
/// the job has the key "cut_cells", and .eb needs it with "boundary"; what such files lack of the mesh, hexcast_mesh_lacks says.
///
/// Flags are expanded in slabs of some MB, whatever the size of the mesh. Threads may write the same mesh at the same time, to
/// different files. Returns 0, or 1 for an error.
///
/// Errors: output-name for an unknown ending; job-value for NULL and for wrong options; job-conflict where an option does not apply to the format, and where
/// a file of the mesh's own surfaces would be written over; lines-graded, export-unit, export-material and export-too-large where the format
/// cannot hold this mesh; io where the system refuses.
///
/// # Safety
/// `mesh` is a mesh that was not freed; `path` is a text; `options` is NULL or a text; `error` is NULL or a place for a pointer.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn hexcast_mesh_write(
    mesh: *const HexcastMesh,
    path: *const c_char,
    options: *const c_char,
    error: *mut *mut HexcastError,
) -> i32 {
    let act = || {
        // SAFETY: the caller vouches for both
        let (mesh, path) = unsafe { (behind(mesh, "the mesh")?, text(path, "the path")?) };
        let options = match options.is_null() {
            true => FileOptions::default(),
            // SAFETY: it is a text, for which the caller vouches
            false => FileOptions::of_json(unsafe { text(options, "the options of the file") }?)?,
        };
        let of_mesh = (mesh.origin.zarr, &mesh.origin.inputs[..]);
        let lacks = save(&mesh.mesh, Path::new(path), &options, of_mesh, &Control::default())?;
        mesh.say(&lacks);
        Ok(())
    };
    // SAFETY: the caller vouches for the place of the error
    status(unsafe { call(error, act) })
}
