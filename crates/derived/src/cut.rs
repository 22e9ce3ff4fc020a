//! Cuts a box of cells out of a mesh, for a closer look; or takes every n-th cell, for a preview of a large mesh.
//!
//! Mesh, box, stride n -> mesh. The box is divided into blocks of n cells an axis. A block becomes one cell, as large as the block, with
//! the flag of the cell in its middle: number n / 2 of it, rounded down. For an odd n the centres are the same, so these are the flags that
//! cells of n times the size have at those centres. Cells at the end of the box that do not fill a block are left out.
//!
//! Crossings and odd rays are not counted again: the numbers of the whole mesh stay.
//!
//! Cost: one pass over the rays of the box.

use crate::mesh::Mesh;
use crate::staggered::SheetFace;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::cells::flags::CellBox;
use hexcast_core::grid::lines::Lines;

/// The mesh of a box of cells, of blocks of `stride` cells on x, y, z; at most `max_bytes` of memory are taken.
///
/// # Errors
/// - `job-value`: the box reaches beyond the mesh or is empty, a stride is 0, or no block fits the box.
/// - `memory`: the columns take more than is allowed; `io` where those of the mesh cannot be read; `cancelled`.
pub fn cut(mesh: &Mesh, cells: &CellBox, stride: [u32; 3], max_bytes: u64, control: &Control) -> Result<Mesh> {
    check(mesh, cells, stride)?;
    let dims = [0, 1, 2].map(|axis| (cells[axis].end - cells[axis].start) / stride[axis]);
    let columns = mesh.columns.cut(cells, stride, max_bytes, control)?;
    let plates = mesh.plates.iter().filter_map(|plate| within(plate, cells, stride, dims)).collect();
    let lines = lines(&mesh.lines, cells, stride, dims)?;
    Ok(Mesh::new(lines, columns, mesh.names.clone(), mesh.unit.clone())?.with_plates(plates))
}

/// The face of a plate, on the nearest line of blocks, where it is that of the cell in their middle.
fn within(plate: &SheetFace, cells: &CellBox, stride: [u32; 3], dims: [u32; 3]) -> Option<SheetFace> {
    let mut face = [0; 3];
    for axis in 0..3 {
        let at = plate.face[axis].checked_sub(cells[axis].start)?;
        let is_across = axis == usize::from(plate.axis);
        face[axis] = if is_across { (at + stride[axis] / 2) / stride[axis] } else { at / stride[axis] };
        let is_taken = is_across || at % stride[axis] == stride[axis] / 2;
        if !is_taken || face[axis] >= dims[axis] + u32::from(is_across) {
            return None;
        }
    }
    Some(SheetFace { face, ..*plate })
}

fn check(mesh: &Mesh, cells: &CellBox, stride: [u32; 3]) -> Result<()> {
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let (first, end, n) = (cells[axis].start, cells[axis].end, mesh.dims()[axis]);
        if first >= end || end > n {
            let message = format!("the box has cells {first} to {end} along {name}, of {n}");
            return Err(Error::new("job-value", message, "give the first cell and the end, which is exclusive"));
        }
        if stride[axis] == 0 || stride[axis] > end - first {
            let message = format!("the stride along {name} is {}, of {} cells", stride[axis], end - first);
            return Err(Error::new("job-value", message, "give a stride of at least 1 that fits the cells"));
        }
    }
    Ok(())
}

fn lines(lines: &Lines, cells: &CellBox, stride: [u32; 3], dims: [u32; 3]) -> Result<Lines> {
    let line = |axis: usize, block: u32| lines.line(axis, cells[axis].start + block * stride[axis]);
    match lines.spacing() {
        Some(spacing) => {
            let spacing = [0, 1, 2].map(|axis| spacing[axis] * f64::from(stride[axis]));
            Lines::new([0, 1, 2].map(|axis| line(axis, 0)), spacing, dims)
        }
        None => Lines::from_lists([0, 1, 2].map(|axis| (0..=dims[axis]).map(|block| line(axis, block)).collect())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::pattern;

    #[test]
    fn blocks_have_the_flag_of_the_cell_in_their_middle() {
        let cases = [
            ([0..9, 0..5, 0..7], [1, 1, 1]),
            ([2..9, 1..5, 0..6], [1, 1, 1]),
            ([0..9, 0..5, 0..7], [3, 2, 4]),
            ([1..8, 0..5, 3..7], [2, 5, 3]),
        ];
        for axis in 0..3 {
            let mesh = pattern(axis, [9, 5, 7], 3);
            for (cells, stride) in &cases {
                let found = cut(&mesh, cells, *stride, u64::MAX, &Control::default()).unwrap();
                let dims = [0, 1, 2].map(|a| cells[a].len() as u32 / stride[a]);
                assert_eq!(found.dims(), dims);
                for z in 0..dims[2] {
                    for (x, y) in (0..dims[1]).flat_map(|y| (0..dims[0]).map(move |x| (x, y))) {
                        let block = [x, y, z];
                        let cell = [0, 1, 2].map(|a| cells[a].start + block[a] * stride[a] + stride[a] / 2);
                        assert_eq!(
                            found.flag(block),
                            mesh.flag(cell),
                            "axis {axis}, {cells:?} by {stride:?}, {block:?}"
                        );
                    }
                }
                for a in 0..3 {
                    let end = cells[a].start + dims[a] * stride[a];
                    let (low, high) = (mesh.lines.line(a, cells[a].start), mesh.lines.line(a, end));
                    assert_eq!(found.lines.line(a, 0), low);
                    assert!((found.lines.line(a, dims[a]) - high).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn boxes_beyond_the_mesh_and_strides_that_fit_nothing_are_refused() {
        let mesh = pattern(0, [9, 5, 7], 3);
        for (cells, stride) in
            [([0..10, 0..5, 0..7], [1; 3]), ([3..3, 0..5, 0..7], [1; 3]), ([0..9, 0..5, 0..7], [1, 6, 1])]
        {
            let error = cut(&mesh, &cells, stride, u64::MAX, &Control::default()).unwrap_err();
            assert_eq!(error.code(), "job-value", "{error}");
        }
    }
}
