//! The finished mesh: lines, columns and the names of the flags, with the queries and the slabs that every output uses.
//!
//! Lines, columns, names -> [`Mesh`]. The flags of all cells are never in memory at once: [`Mesh::for_each_slab`] expands them
//! in file order, `flags[x + nx * (y + ny * z)]`, one slab ahead of the consumer.
//! Cost: two slabs of memory; expansion runs at the speed of memory, beside the consumer.

pub mod level;
pub mod octree;
pub mod outline;

use sha2::{Digest, Sha256};

use crate::staggered::SheetFace;
use crate::walls::Walls;
use hexcast_core::base::checksum::hex;
use hexcast_core::base::control::{Control, at_once};
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::parallel::beside;
pub use hexcast_core::cells::columns::Named;
use hexcast_core::cells::columns::{BoxRuns, ChangedRun, Columns, SlabColumns, SomeRuns};
use hexcast_core::cells::flags::{
    CellBox, bits_of_box, expand, expand_bits, flags_of_box, n_bytes_of_bits, n_cells, slabs_of_box,
};
use hexcast_core::grid::lines::Lines;
use outline::Outline;

/// Bytes of a slab where the caller does not say: long enough to keep all cores busy, short enough for a browser.
pub const SLAB_BYTES: usize = 32 << 20;

/// Expands a slab from columns into a buffer, which it makes as long as it must be.
type Fill = dyn Fn(&Columns, &CellBox, &mut Vec<u8>) -> Result<()> + Sync;

/// A Cartesian mesh: cells between lines, each with a property flag.
#[derive(Debug, Clone, PartialEq)]
pub struct Mesh {
    pub(crate) lines: Lines,
    pub(crate) columns: Columns,
    pub(crate) names: Vec<Named>,
    pub(crate) unit: Option<String>,
    pub(crate) plates: Vec<SheetFace>,
    pub(crate) walls: Option<Walls>,
    pub(crate) outline: Option<Outline>,
}

impl Mesh {
    /// Joins lines and columns of the same box.
    ///
    /// # Errors
    /// `job-conflict` where lines and columns differ in their number of cells.
    pub fn new(lines: Lines, columns: Columns, names: Vec<Named>, unit: Option<String>) -> Result<Mesh> {
        if lines.dims() != columns.dims() {
            let message = format!("the lines have {:?} cells, and the columns {:?}", lines.dims(), columns.dims());
            return Err(Error::new("job-conflict", message, "mesh again with these lines"));
        }
        Ok(Mesh { lines, columns, names, unit, plates: Vec::new(), walls: None, outline: None })
    }

    /// Adds the faces of geometries without thickness.
    pub fn with_plates(self, plates: Vec<SheetFace>) -> Mesh {
        Mesh { plates, ..self }
    }

    /// Adds the names of the faces between flags.
    pub fn with_walls(self, walls: Option<Walls>) -> Mesh {
        Mesh { walls, ..self }
    }

    /// Adds the outline of a fluid.
    pub fn with_outline(self, outline: Option<Outline>) -> Mesh {
        Mesh { outline, ..self }
    }

    /// Names the flags anew.
    pub fn with_names(self, names: Vec<Named>) -> Mesh {
        Mesh { names, ..self }
    }

    /// Gives some rays other runs, and the flags these names; all rays have so many crossings then. Returns what that changes.
    ///
    /// # Errors
    /// `job-conflict` where the columns are in a store.
    #[doc(hidden)]
    pub fn splice(&mut self, some: &SomeRuns, n_crossings: u64, names: Vec<Named>) -> Result<Vec<ChangedRun>> {
        let changed = self.columns.splice(some, n_crossings)?;
        self.names = names;
        Ok(changed)
    }

    /// Names the unit of every length.
    pub fn with_unit(self, unit: Option<String>) -> Mesh {
        Mesh { unit, ..self }
    }

    /// The planes between cells.
    pub fn lines(&self) -> &Lines {
        &self.lines
    }

    /// The flags, as runs along rays; they have as many cells as the lines.
    pub fn columns(&self) -> &Columns {
        &self.columns
    }

    /// Names of the flags in use, in the order of the job.
    pub fn names(&self) -> &[Named] {
        &self.names
    }

    /// Unit of every length, such as "mm", if the caller named one.
    pub fn unit(&self) -> Option<&str> {
        self.unit.as_deref()
    }

    /// Faces that geometries without thickness cover, in the order of their axes, then x fastest. Column files do not have them.
    pub fn plates(&self) -> &[SheetFace] {
        &self.plates
    }

    /// Which solids made the faces between flags, where that was asked for. Column files do not have them.
    pub fn walls(&self) -> Option<&Walls> {
        self.walls.as_ref()
    }

    /// The outline of the cells of one flag, where that was asked for. Column files do not have it.
    pub fn outline(&self) -> Option<&Outline> {
        self.outline.as_ref()
    }

    /// Number of cells on x, y and z.
    pub fn dims(&self) -> [u32; 3] {
        self.lines.dims()
    }

    /// Number of cells of the box.
    pub fn n_cells(&self) -> u64 {
        self.lines.n_cells()
    }

    /// Looks up the flag of the cell (x, y, z).
    ///
    /// # Errors
    /// `job-value` where the cell lies outside the mesh; `io` where the columns are in a store that fails.
    pub fn flag(&self, cell: [u32; 3]) -> Result<u8> {
        if (0..3).any(|axis| cell[axis] >= self.dims()[axis]) {
            return Err(self.outside(format!("cell {cell:?}")));
        }
        self.columns.flag(cell)
    }

    /// Expands the flags of a box of cells, one byte a cell, x fastest; its end is exclusive.
    ///
    /// # Errors
    /// `job-value` where the box reaches past the mesh or ends before it starts; `io` as for [`Mesh::flag`].
    pub fn box_flags(&self, cells: &CellBox) -> Result<Vec<u8>> {
        flags_of_box(&*self.columns_of_box(cells)?, cells)
    }

    /// Expands the flags of a box of cells, a bit a cell as `write::bits` has them; its end is exclusive.
    ///
    /// # Errors
    /// Those of [`Mesh::box_flags`].
    pub fn box_bits(&self, cells: &CellBox) -> Result<Vec<u8>> {
        bits_of_box(&*self.columns_of_box(cells)?, cells)
    }

    /// Cuts the runs of the rays through a box of cells to it; its end is exclusive.
    ///
    /// # Errors
    /// Those of [`Mesh::box_flags`]; `memory` where the box has 2^32 runs.
    pub fn box_runs(&self, cells: &CellBox) -> Result<BoxRuns> {
        self.columns_of_box(cells)?.runs_of_box(cells)
    }

    /// Expands the flags of a box of cells into memory of the caller's, as [`Mesh::box_flags`] does into new memory.
    ///
    /// # Errors
    /// Those of [`Mesh::box_flags`]; `job-value` where `out` does not have a byte for each cell of the box.
    pub fn fill_box(&self, cells: &CellBox, out: &mut [u8]) -> Result<()> {
        let columns = self.columns_of_box(cells)?;
        if out.len() != n_cells(cells) {
            let message = format!("{} bytes for the flags of {} cells", out.len(), n_cells(cells));
            return Err(Error::new("job-value", message, "give a byte for each cell of the box"));
        }
        expand(&columns, cells, out)
    }

    /// Columns that are cheap to expand in a box.
    fn columns_of_box(&self, cells: &CellBox) -> Result<SlabColumns<'_>> {
        if (0..3).any(|axis| cells[axis].end > self.dims()[axis] || cells[axis].start > cells[axis].end) {
            return Err(self.outside(format!("box {cells:?}")));
        }
        let n_rays: u64 = self.columns.rays().across.iter().map(|&axis| cells[axis].len() as u64).product();
        if 2 * n_rays < self.columns.rays().n_rays() {
            return Ok(SlabColumns::Whole(&self.columns));
        }
        self.columns.for_slab(&cells[self.columns.rays().axis])
    }

    /// Splits the mesh, in file order, in slabs of whole z planes of at most `max_bytes` flags, or of whole rows along x
    /// where one plane is already larger; at least one row each.
    pub fn slabs(&self, max_bytes: usize) -> impl Iterator<Item = CellBox> + use<> {
        slabs_of_box(&self.dims().map(|n| 0..n), max_bytes)
    }

    /// Hands the flags of all cells, x fastest, slab by slab to `consume`, which runs on this thread while the next slab
    /// is expanded on others. Holds two slabs of at most `max_bytes` (at least a row).
    ///
    /// # Errors
    /// `cancelled`, looked at before every slab; `io` as for [`Mesh::flag`]; whatever `consume` returns.
    pub fn for_each_slab(
        &self,
        max_bytes: usize,
        control: &Control,
        mut consume: impl FnMut(&[u8]) -> Result<()>,
    ) -> Result<()> {
        at_once(self.for_each_slab_with_rests(max_bytes, &control.without_pauses(), &mut consume))
    }

    /// Like [`Mesh::for_each_slab`], with a rest before every slab ([`Control::rest`]): for work that goes on when its caller wants more.
    ///
    /// # Errors
    /// Those of [`Mesh::for_each_slab`].
    #[doc(hidden)]
    pub async fn for_each_slab_with_rests(
        &self,
        max_bytes: usize,
        control: &Control,
        consume: &mut dyn FnMut(&[u8]) -> Result<()>,
    ) -> Result<()> {
        let fill = |columns: &Columns, cells: &CellBox, out: &mut Vec<u8>| {
            out.resize(n_cells(cells), 0);
            expand(columns, cells, out)
        };
        self.hand_slabs(&mut self.slabs(max_bytes), control, &fill, consume).await
    }

    /// Like [`Mesh::for_each_slab`], with a bit a cell as `write::bits` has them.
    ///
    /// # Errors
    /// Those of [`Mesh::for_each_slab`].
    pub fn for_each_slab_of_bits(
        &self,
        max_bytes: usize,
        control: &Control,
        mut consume: impl FnMut(&[u8]) -> Result<()>,
    ) -> Result<()> {
        at_once(self.for_each_slab_of_bits_with_rests(max_bytes, &control.without_pauses(), &mut consume))
    }

    /// Like [`Mesh::for_each_slab_of_bits`], with a rest before every slab.
    ///
    /// # Errors
    /// Those of [`Mesh::for_each_slab`].
    #[doc(hidden)]
    pub async fn for_each_slab_of_bits_with_rests(
        &self,
        max_bytes: usize,
        control: &Control,
        consume: &mut dyn FnMut(&[u8]) -> Result<()>,
    ) -> Result<()> {
        let fill = |columns: &Columns, cells: &CellBox, out: &mut Vec<u8>| {
            out.resize(n_bytes_of_bits(cells), 0);
            expand_bits(columns, cells, out)
        };
        self.hand_slabs(&mut self.slabs(max_bytes.saturating_mul(8)), control, &fill, consume).await
    }

    /// Hands slabs to `consume` while `fill` makes the next from columns that are cheap to expand there; compiled once.
    async fn hand_slabs(
        &self,
        slabs: &mut dyn Iterator<Item = CellBox>,
        control: &Control,
        fill: &Fill,
        consume: &mut dyn FnMut(&[u8]) -> Result<()>,
    ) -> Result<()> {
        let axis = self.columns.rays().axis;
        let fill = |cells: &CellBox, out: &mut Vec<u8>| fill(&*self.columns.for_slab(&cells[axis])?, cells, out);
        let (mut now, mut next) = (Vec::new(), Vec::new());
        control.check()?;
        let mut ahead = slabs.next();
        ahead.iter().try_for_each(|cells| fill(cells, &mut now))?;
        while ahead.is_some() {
            control.rest().await?;
            ahead = slabs.next();
            let mut filled = Ok(());
            beside(|| filled = ahead.iter().try_for_each(|cells| fill(cells, &mut next)), || consume(&now))?;
            filled?;
            std::mem::swap(&mut now, &mut next);
        }
        Ok(())
    }

    /// Hashes the flags of all cells, x fastest, one byte a cell: SHA-256 in hexadecimal, that of the `.raw` file.
    ///
    /// # Errors
    /// `cancelled`; `io` as for [`Mesh::flag`].
    pub fn flags_sha256(&self, control: &Control) -> Result<String> {
        self.flags_sha256_in_slabs(SLAB_BYTES, control)
    }

    /// Hashes the flags of all cells like [`Mesh::flags_sha256`], holding two slabs of at most `max_bytes`.
    ///
    /// # Errors
    /// Those of [`Mesh::flags_sha256`].
    pub fn flags_sha256_in_slabs(&self, max_bytes: usize, control: &Control) -> Result<String> {
        let mut hash = Sha256::new();
        self.for_each_slab(max_bytes, control, |flags| {
            hash.update(flags);
            Ok(())
        })?;
        Ok(hex(&hash.finalize()))
    }

    fn outside(&self, what: String) -> Error {
        let [nx, ny, nz] = self.dims();
        Error::new("job-value", format!("{what} is not inside the mesh of {nx} x {ny} x {nz} cells"), "")
    }
}

#[cfg(test)]
mod stored;
#[cfg(test)]
mod tests {
    use super::*;

    use crate::testing::{pattern, pattern_flag, pattern_flags};

    #[test]
    fn slabs_of_any_size_give_all_flags_in_file_order() {
        let dims = [9, 5, 7];
        for axis in 0..3 {
            let mesh = pattern(axis, dims, 3);
            for max_bytes in [1, 9, 17, 18, 44, 45, 100, 200, 1 << 20] {
                let mut flags = Vec::new();
                let collect = |slab: &[u8]| {
                    assert!(slab.len() <= max_bytes.max(9), "{} > {max_bytes}", slab.len());
                    flags.extend_from_slice(slab);
                    Ok(())
                };
                mesh.for_each_slab(max_bytes, &Control::default(), collect).unwrap();
                assert_eq!(flags, pattern_flags(dims, 3), "axis {axis}, slabs of {max_bytes}");
            }
        }
    }

    #[test]
    fn the_hash_is_that_of_the_bytes() {
        let mesh = pattern(1, [9, 5, 7], 3);
        let expected = hex(&Sha256::digest(pattern_flags([9, 5, 7], 3)));
        assert_eq!(mesh.flags_sha256(&Control::default()).unwrap(), expected);
        assert_eq!(hex(&Sha256::digest(b"abc"))[..16], *"ba7816bf8f01cfea");
    }

    #[test]
    fn queries_outside_the_mesh_are_errors() {
        let mesh = pattern(2, [9, 5, 7], 3);
        assert_eq!(mesh.flag([8, 4, 6]).unwrap(), pattern_flag([8, 4, 6], 3));
        assert_eq!(mesh.flag([9, 0, 0]).unwrap_err().code(), "job-value");
        assert_eq!(mesh.box_flags(&[0..9, 0..5, 0..7]).unwrap(), pattern_flags([9, 5, 7], 3));
        assert_eq!(mesh.box_flags(&[0..9, 0..6, 0..7]).unwrap_err().code(), "job-value");
        let mut out = vec![9; 30];
        mesh.fill_box(&[2..7, 1..3, 4..7], &mut out).unwrap();
        assert_eq!(out, mesh.box_flags(&[2..7, 1..3, 4..7]).unwrap());
        assert_eq!(mesh.fill_box(&[2..7, 1..3, 4..6], &mut out).unwrap_err().code(), "job-value");
        assert_eq!(mesh.fill_box(&[2..7, 1..3, 5..8], &mut out).unwrap_err().code(), "job-value");
        #[expect(clippy::reversed_empty_ranges, reason = "what a careless caller hands in")]
        let reversed = [5..2, 0..1, 0..1];
        assert_eq!(mesh.box_flags(&reversed).unwrap_err().code(), "job-value");
    }

    #[test]
    fn lines_and_columns_must_have_the_same_cells() {
        let mesh = pattern(0, [9, 5, 7], 3);
        let lines = Lines::new(mesh.lines.origin(), mesh.lines.smallest(), [9, 5, 8]).unwrap();
        assert_eq!(Mesh::new(lines, mesh.columns, vec![], None).unwrap_err().code(), "job-conflict");
    }

    #[test]
    fn cancel_stops_between_slabs() {
        let mesh = pattern(0, [9, 5, 7], 3);
        let control = Control::default();
        let mut slabs = 0;
        let stop = |_: &[u8]| {
            slabs += 1;
            control.cancel.cancel();
            Ok(())
        };
        assert_eq!(mesh.for_each_slab(45, &control, stop), Err(Error::Cancelled));
        assert_eq!(slabs, 1);
    }
}
