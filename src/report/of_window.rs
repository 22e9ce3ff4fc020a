//! What the report says of a window, and what its merge with those of other windows needs.

use serde::{Deserialize, Serialize};

use super::StaggeredReport;
use crate::finding::Finding;

/// Which cells of a box were meshed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WindowReport {
    /// The first, on x, y, z; without the halo.
    pub first: [u32; 3],
    /// The end, exclusive; without the halo.
    pub end: [u32; 3],
    /// Number of cells of the box on x, y, z.
    pub of: [u32; 3],
    /// First corner of the box.
    pub origin: [f64; 3],
    /// Cells beyond these on both sides of every axis, which `dims`, `origin` and all counts include.
    pub halo: u32,
    /// What these cells add to the sum that `flags_hash` is made of, see `docs/flags_hash.md`: 32 hexadecimal digits; null with a halo and
    /// where the columns have spilled.
    pub flags_sum: Option<String>,
    /// `volume_bound` of each geometry in the whole box; null unless these cells are a part (`--part`).
    pub volume_bounds: Option<Vec<Option<f64>>>,
    /// Runs of the whole box that begin in these cells; null unless these are a part without halo, or no ray is cut before them.
    pub runs: Option<u64>,
    /// The points of a staggered grid as in `staggered`, but of those on its last line along an axis only where that is the last of the box: so each point
    /// is counted in one part; null unless asked for.
    pub staggered: Option<StaggeredReport>,
    /// Geometries with cells in two or more of their shells here, on the rays of the box that are looked at; empty for the rule `nonzero`.
    pub shells: Vec<ShellsReport>,
    /// Geometries that have no cell here; null unless these cells are a part without halo. A geometry that all parts list has none in the box.
    pub without_cells: Option<Vec<WithoutCells>>,
}

/// A geometry with cells in two or more of its shells.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ShellsReport {
    /// Its index in `geometries`, from 0.
    pub geometry: usize,
    /// Number of these cells on the rays that are looked at.
    pub cells: u64,
}

impl ShellsReport {
    /// Counts cells of a geometry.
    pub fn new(geometry: usize, cells: u64) -> ShellsReport {
        ShellsReport { geometry, cells }
    }

    /// Says it; `name` is that of the geometry.
    pub fn finding(&self, name: &str, n_rays: u64) -> Finding {
        let sentence = format!(
            "shells of geometry \"{name}\" overlap, or a cavity is turned the wrong way: {} cells on {n_rays} rays that were looked at lie \
             in two or more shells, and the rule parity takes those in two for outside; rule = \"nonzero\" (--rule nonzero) takes them for \
             inside",
            self.cells
        );
        let found = Finding::new("shells-overlap", sentence).of_geometry(self.geometry, name);
        found.with_count("cells", self.cells).with_count("rays", n_rays)
    }
}

/// A geometry that has no cell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WithoutCells {
    /// Its index in `geometries`, from 0.
    pub geometry: usize,
    /// What to say if it has none in the whole box; null where the cells of another part tell why.
    pub finding: Option<Finding>,
    /// The sentence of this finding.
    pub warning: Option<String>,
}

impl WithoutCells {
    /// Names a geometry, and what to say of it, if that is known.
    pub fn new(geometry: usize, finding: Option<Finding>) -> WithoutCells {
        let warning = finding.as_ref().map(|finding| finding.sentence.clone());
        WithoutCells { geometry, finding, warning }
    }
}
