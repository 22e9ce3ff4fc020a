//! A box of cells of AMReX.

/// Cells around each grid that its arrays have too.
pub(super) const GHOSTS: i32 = 2;

/// A box of cells: the first, and the last.
#[derive(Clone, Copy)]
pub(super) struct Grid {
    pub(super) low: [i32; 3],
    pub(super) high: [i32; 3],
}

impl Grid {
    /// With so many more cells on both sides of each axis.
    pub(super) fn grown(self, n: i32) -> Grid {
        Grid { low: self.low.map(|of| of - n), high: self.high.map(|of| of + n) }
    }

    /// As AMReX writes it, of cells, or of places that are nodes along some axes.
    pub(super) fn text(self, is_nodal: [bool; 3]) -> String {
        let list = |of: [i32; 3]| format!("({},{},{})", of[0], of[1], of[2]);
        let nodal = is_nodal.map(i32::from);
        let high = [0, 1, 2].map(|axis| self.high[axis] + nodal[axis]);
        format!("({} {} {})", list(self.low), list(high), list(nodal))
    }
}
