//! What the report says of a window, and what its merge with those of other windows needs.

use serde::{Deserialize, Serialize};

use super::StaggeredReport;
use hexcast_core::base::finding::Finding;
use hexcast_core::grid::totals::Total;
use hexcast_derived::certificate::Overlap;
use hexcast_derived::fractions::Fractions;

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
    /// Volumes and areas before they are rounded.
    #[serde(default)]
    pub sums: WindowSums,
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
    /// The report that these cells have without their halo, but for what is measured at surfaces: what a merge takes. Null unless they are a part with a halo
    /// whose report may be merged, and the columns fit in memory.
    #[serde(default)]
    pub without_halo: Option<serde_json::Value>,
}

/// Volumes and areas of some cells of a box, exactly: whole numbers in hexadecimal digits that add up to those of the box, in units that follow from
/// the lines of the box (`crates/core/src/grid/totals.rs`).
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct WindowSums {
    /// `flags[].volume`; empty among equal cells, whose number says it.
    pub volumes: Vec<FlagSum>,
    /// `fractions.volumes`.
    pub fractions: Vec<FlagSum>,
    /// `fractions.areas`.
    pub areas: Vec<String>,
    /// The volume of each of `certificate.overlaps`.
    pub overlaps: Vec<String>,
}

/// What cells have of a flag.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FlagSum {
    /// The flag.
    pub flag: u8,
    /// The sum.
    pub sum: String,
}

impl WindowSums {
    /// Writes sums as text; `volumes` has those of all flags.
    #[doc(hidden)]
    pub fn new(volumes: Option<&[Total; 256]>, fractions: Option<&Fractions>, overlaps: &[Overlap]) -> WindowSums {
        let of_flags = |totals: &[Total]| -> Vec<FlagSum> {
            let some = (0..=u8::MAX).zip(totals).filter(|(_, total)| **total != Total::default());
            some.map(|(flag, total)| FlagSum { flag, sum: total.text() }).collect()
        };
        let totals = fractions.map(|fractions| &fractions.totals);
        WindowSums {
            volumes: volumes.map_or(Vec::new(), |totals| of_flags(totals)),
            fractions: totals.map_or(Vec::new(), |totals| of_flags(&totals.volumes)),
            areas: totals.iter().flat_map(|totals| &totals.areas).map(|total| total.text()).collect(),
            overlaps: overlaps.iter().map(|overlap| overlap.total.text()).collect(),
        }
    }
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
