//! Slices: the flags of one plane of cells, for a picture.
//!
//! Mesh, axis, index -> [`Slice`]. Where the plane has more cells than the picture pixels, one cell of every `step` x `step`
//! is shown: the middle one. Cost: O(cells) at the speed of memory where every cell is shown, else a search in a ray's
//! runs a pixel; no memory besides the picture.

use hexcast_core::base::parallel::*;

use crate::mesh::Mesh;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::flags::flags_of_box;

/// Flags of a plane of cells.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Slice {
    /// Pixels along the first of the two other axes: y for a slice across x, else x.
    pub width: u32,
    /// Pixels along the second of the two other axes: y for a slice across z, else z.
    pub height: u32,
    /// Cells a pixel on both axes; at least 1.
    pub step: u32,
    /// Flags, `flags[column + width * row]`; length `width * height`. Pixel (c, r) shows cell
    /// `c * step + step / 2` (or the last) on the first axis, likewise on the second.
    pub flags: Vec<u8>,
}

/// Cuts the plane of cells `index` of an axis (0, 1, 2) from the mesh, in at most `out_max` pixels (width, height; taken
/// as 1 where they are 0), by the smallest step for which it fits.
///
/// # Errors
/// `job-value` where the mesh has no such axis or plane; `io` where its columns are in a store that fails.
pub fn slice(mesh: &Mesh, axis: usize, index: u32, out_max: [u32; 2]) -> Result<Slice> {
    let dims = mesh.dims();
    if axis > 2 || index >= dims[axis] {
        let message = format!("plane {index} of axis {axis} is not inside the mesh of {dims:?} cells");
        return Err(Error::new("job-value", message, "axes are 0 to 2, planes are counted from 0"));
    }
    let across = [[1, 2], [0, 2], [0, 1]][axis];
    let counts = across.map(|axis| dims[axis]);
    let step = (0..2).map(|side| counts[side].div_ceil(out_max[side].max(1))).max().unwrap_or(1);
    let [width, height] = counts.map(|n| n.div_ceil(step));
    if step == 1 {
        let mut cells = dims.map(|n| 0..n);
        cells[axis] = index..index + 1;
        return Ok(Slice { width, height, step, flags: flags_of_box(&mesh.columns, &cells)? });
    }
    let shown = |pixel: usize, side: usize| (pixel as u32 * step).saturating_add(step / 2).min(counts[side] - 1);
    let mut flags = vec![0; width as usize * height as usize];
    flags.par_chunks_mut(width as usize).enumerate().try_for_each(|(row, out)| {
        let mut cell = [index; 3];
        cell[across[1]] = shown(row, 1);
        for (column, flag) in out.iter_mut().enumerate() {
            cell[across[0]] = shown(column, 0);
            *flag = mesh.columns.flag(cell)?;
        }
        Ok(())
    })?;
    Ok(Slice { width, height, step, flags })
}
