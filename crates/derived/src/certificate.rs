//! The certificate: walls that a mesh may have lost, and cells that it decided between geometries. It casts the closed
//! geometries again.
//!
//! Frame, rays of three axes -> walls thinner than some cells, and the cells that two geometries claim; columns -> gaps of one cell between
//! flags. It is made if the job asks for it, because it costs some casts on the host. Geometries that are not closed are left
//! out: rays do not decide them.
//!
//! The certificate of a window covers the cells of the window: the counts of all windows add up to those of the box.

use hexcast_core::grid::lines::Lines;
use hexcast_core::input::geometry::Geometry;
use hexcast_core::stages::cast::Cast;

mod gaps;
mod overlaps;
pub mod shells;
mod thin;

pub use gaps::{FlagGap, FlagGaps};
pub use overlaps::Overlap;
pub use thin::ThinWall;

/// Walls of fewer cells are thin where the job does not say.
pub const DEFAULT_THIN_CELLS: u32 = 2;

/// What was found, by geometries of the job.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Certificate {
    /// Walls of fewer cells were looked for.
    pub thin_cells: u32,
    /// Thin walls, a geometry and an axis each.
    pub thin_walls: Vec<ThinWall>,
    /// Pairs of geometries with common cells.
    pub overlaps: Vec<Overlap>,
    /// Gaps of one cell between flags, for each pair and axis.
    pub gaps: Vec<FlagGap>,
}

impl Certificate {
    /// Looks at the closed geometries of a frame in some cells, the first and the end, exclusive, and takes the gaps that were found in
    /// these. Cast and lines are those of the whole box, `geometries` those of the job.
    pub fn new(
        cast: &Cast,
        cells: [[u32; 3]; 2],
        lines: &Lines,
        (geometries, thin_cells): (&[Geometry], u32),
        gaps: FlagGaps,
    ) -> Certificate {
        let is_wanted = |geometry: usize| !geometries[geometry].shell;
        Certificate {
            thin_cells,
            thin_walls: thin::thin_walls(cast, lines, cells, thin_cells, is_wanted),
            overlaps: overlaps::overlaps(cast, lines, cells),
            gaps: gaps.into_list(),
        }
    }
}
