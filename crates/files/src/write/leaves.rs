//! The leaves of an octree as `.npz`: of each its level, its cell there and its flag. `docs/refine.md` describes it.

use std::io;

use super::archive::{Array, write_named};
use super::{Compress, npz};
use hexcast_core::base::error::Result;
use hexcast_core::grid::lines::Lines;
use hexcast_derived::mesh::octree::{LeafRun, Octree};

/// Writes a NumPy archive: `level`, `i`, `j`, `k` and `flag` of all leaves, level by level, x fastest, and the lines of level 0. Returns the number of bytes.
///
/// # Errors
/// `io` where `out` fails, or columns are in a store that does.
pub fn write_leaves(tree: &Octree, lines: &Lines, compress: Compress, out: &mut dyn io::Write) -> Result<u64> {
    write_named(&leaf_arrays(tree, lines), "the leaves", compress, out)
}

/// Lays out what a run of leaves of a level and a row has, leaf by leaf.
type Put = fn(u8, [u32; 2], &LeafRun, &mut Vec<u8>);

/// The arrays of the archive of [`write_leaves`].
pub fn leaf_arrays<'a>(tree: &'a Octree, lines: &'a Lines) -> Vec<Array<'a>> {
    let planes: Vec<(usize, u32)> =
        (0..tree.n_levels()).flat_map(|level| (0..tree.dims(level)[2]).map(move |z| (level, z))).collect();
    let n_leaves: u64 = (0..tree.n_levels()).map(|level| tree.n_leaves(level)).sum();
    let of = |named, put: Put| {
        let planes = planes.clone();
        Array::new(named, &[n_leaves], planes.len(), move |index| {
            let ((level, z), mut bytes) = (planes[index], Vec::new());
            tree.for_plane(level, z, |y, run| put(level as u8, [y, z], run, &mut bytes))?;
            Ok(bytes)
        })
    };
    let mut arrays = vec![
        of(("level", "|u1"), |level, _, run, out| out.extend(run.cells().map(|_| level))),
        of(("i", "<i4"), |_, _, run, out| out.extend(run.cells().flat_map(|x| (x as i32).to_le_bytes()))),
        of(("j", "<i4"), |_, [y, _], run, out| out.extend(run.cells().flat_map(|_| (y as i32).to_le_bytes()))),
        of(("k", "<i4"), |_, [_, z], run, out| out.extend(run.cells().flat_map(|_| (z as i32).to_le_bytes()))),
        of(("flag", "|u1"), |_, _, run, out| out.extend(run.cells().map(|_| run.flag))),
    ];
    arrays.extend(npz::lines(lines));
    arrays
}
