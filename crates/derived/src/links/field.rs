//! What the links of a mesh are found from, and their order.

use hexcast_core::base::error::Result;
use hexcast_core::cells::columns::Columns;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::window::CellWindow;
use hexcast_core::input::job::Rule;
use hexcast_core::stages::inside::Kind;

/// What the links of a mesh are found from.
pub struct Field<'a> {
    /// All facets, also those that the columns were not made of.
    pub frame: &'a Frame,
    /// What is inside.
    pub rule: Rule,
    /// How the cells of each rank are decided.
    pub kinds: &'a [Kind],
    /// The finished mesh.
    pub columns: &'a Columns,
    /// The first cell of these columns, counted in the box.
    pub first: [u32; 3],
    /// The cells whose links are wanted.
    pub window: CellWindow,
    /// Whether all flags are those of ranks that are decided by rays. If not, the columns have the neighbours of these cells, too.
    pub is_plain: bool,
    /// Along which axes the box continues with itself: links lead through these sides. Only of a whole box.
    pub periodic: [bool; 3],
}

impl Field<'_> {
    /// The number in its geometry of a facet of the frame, and the geometry; `starts` has the first facet of each position.
    pub(super) fn facet_of_geometry(&self, facet: u32, starts: &[usize]) -> (i32, i16) {
        let position = usize::from(self.frame.position_of_facet[facet as usize]);
        ((facet as usize - starts[position]) as i32, self.frame.ranks.geometry_at[position] as i16)
    }

    /// The flag that the mesh has for a cell of the box.
    pub(super) fn flag(&self, cell: [u32; 3]) -> Result<u8> {
        self.columns.flag([0, 1, 2].map(|axis| cell[axis] - self.first[axis]))
    }
}

/// Orders cells as files do, then directions.
pub(super) fn place([x, y, z]: [u32; 3], direction: u8, [nx, ny, _]: [u32; 3]) -> u64 {
    let cell = u64::from(x) + u64::from(nx) * (u64::from(y) + u64::from(ny) * u64::from(z));
    cell << 5 | u64::from(direction)
}
