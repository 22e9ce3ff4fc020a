//! How finely the volumes of flags in cells are measured.

use serde::{Deserialize, Serialize};

/// Rays of a cell along each axis where the job does not say.
const DEFAULT_RAYS: u32 = 4;

/// Asks for the fraction of each flag in the cells that surfaces cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct FractionsJob {
    /// Rays of a cell along each of two axes: 1, 2, 4, 8 or 16; by default 4. The fraction of a cell that one plane cuts is off by less than
    /// 1 / rays.
    pub rays: u32,
    /// Also measures which fraction of each face of these cells a flag has.
    pub faces: bool,
    /// Also measures area, centre and normal of the surface of each geometry in each cell.
    pub surfaces: bool,
}

impl Default for FractionsJob {
    fn default() -> FractionsJob {
        FractionsJob { rays: DEFAULT_RAYS, faces: false, surfaces: false }
    }
}
