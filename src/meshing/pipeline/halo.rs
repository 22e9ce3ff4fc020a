//! The halo of a window: the cells around it. Halo cells within the box are meshed with the window; those beyond the box are
//! background, or have the flag of the nearest cell of the box.

use super::prepare::Prepared;
use hexcast_core::base::error::Result;
use hexcast_core::cells::columns::Columns;
use hexcast_core::grid::lines::Lines;
use hexcast_core::input::job::HaloEdge;
use hexcast_core::open_surfaces::doubt::Doubtful;

/// Cells before and behind what was meshed, on x, y, z, and what they are.
pub(super) struct Beyond([[u32; 3]; 2], HaloEdge);

impl Beyond {
    /// Those of a prepared window; none without a halo that reaches beyond the box.
    pub(super) fn new(prepared: &Prepared) -> Beyond {
        let &Prepared { ref whole, halo, halo_edge, .. } = prepared;
        let [first, end] = prepared.cells();
        let before = first.map(|cell| halo.saturating_sub(cell));
        Beyond([before, [0, 1, 2].map(|axis| halo.saturating_sub(whole.dims()[axis] - end[axis]))], halo_edge)
    }

    fn is_none(&self) -> bool {
        self.0 == [[0; 3]; 2]
    }

    /// Adds them to columns.
    ///
    /// # Errors
    /// `memory` where the columns have left it.
    pub(super) fn around(&self, columns: Columns) -> Result<Columns> {
        if self.is_none() { Ok(columns) } else { columns.padded(self.0, self.1) }
    }

    /// A place that is counted from the first cell that was meshed, counted from the first of the mesh.
    pub(super) fn moved(&self, place: [u32; 3]) -> [u32; 3] {
        [0, 1, 2].map(|axis| place[axis] + self.0[0][axis])
    }

    /// Adds them to what is counted from the first cell that was meshed; no cell beyond the box is doubtful.
    ///
    /// # Errors
    /// Those of [`Beyond::around`].
    pub(super) fn around_doubtful(&self, mut doubtful: Doubtful) -> Result<Doubtful> {
        let before = self.0[0];
        for cells in &mut doubtful.boxes {
            *cells = cells.map(|cell| [0, 1, 2].map(|axis| cell[axis] + before[axis]));
        }
        let background = Beyond(self.0, HaloEdge::Background);
        doubtful.mask = doubtful.mask.map(|mask| background.around(mask)).transpose()?;
        Ok(doubtful)
    }
}

impl Prepared {
    /// The lines of all cells that the mesh will have, also of those of a halo that lie beyond the box.
    pub fn mesh_lines(&self) -> Lines {
        match self.halo {
            0 => self.lines.clone(),
            halo => self.whole.with_halo(self.cells(), halo),
        }
    }
}
