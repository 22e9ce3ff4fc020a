//! What the links of a mesh are found from, and their order.

use crate::columns::Columns;
use crate::frame::Frame;
use crate::inside::Kind;
use crate::job::Rule;

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
    /// Whether all flags are those of ranks that are decided by rays.
    pub is_plain: bool,
}

impl Field<'_> {
    /// The number in its geometry of a facet of the frame, and the geometry; `starts` has the first facet of each rank.
    pub(super) fn facet_of_geometry(&self, rank: u8, facet: u32, starts: &[usize]) -> (i32, i16) {
        let rank = usize::from(rank);
        ((facet as usize - starts[rank]) as i32, self.frame.ranks.geometry_at[rank] as i16)
    }
}

/// Orders cells as files do, then directions.
pub(super) fn place([x, y, z]: [u32; 3], direction: u8, [nx, ny, _]: [u32; 3]) -> u64 {
    let cell = u64::from(x) + u64::from(nx) * (u64::from(y) + u64::from(ny) * u64::from(z));
    cell << 5 | u64::from(direction)
}
