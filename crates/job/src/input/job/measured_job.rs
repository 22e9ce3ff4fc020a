//! What a job asks for beside the cells: links from cells to surfaces, fractions of flags in cells, edges and faces outside metal, smoothed permittivity, distances to surfaces, and cells cut at a surface.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::base::error::{Error, Result};

/// The directions of the links of a cell, as lattice Boltzmann methods name them: `D3Q` and their number, that of the cell itself included.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub enum Stencil {
    /// Over the 6 faces.
    D3Q7,
    /// Over faces and the 8 corners.
    D3Q15,
    /// Over faces and the 12 edges.
    #[default]
    D3Q19,
    /// Over faces, edges and corners.
    D3Q27,
}

impl Stencil {
    /// The directions in cells, x, y, z. The first is that of the cell itself. The others come in pairs of opposites: 2 k is the
    /// opposite of 2 k - 1. Faces come first, then edges, then corners.
    pub fn directions(self) -> Vec<[i8; 3]> {
        let (edges, corners) = match self {
            Stencil::D3Q7 => (false, false),
            Stencil::D3Q15 => (false, true),
            Stencil::D3Q19 => (true, false),
            Stencil::D3Q27 => (true, true),
        };
        let is_in = |direction: &[i8; 3]| match direction.iter().filter(|&&step| step != 0).count() {
            2 => edges,
            3 => corners,
            _ => true,
        };
        let pairs = HALVES.iter().filter(|half| is_in(half)).flat_map(|&half| [half, half.map(|step| -step)]);
        [[0; 3]].into_iter().chain(pairs).collect()
    }
}

/// One direction of each pair.
const HALVES: [[i8; 3]; 13] = [
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 1, 0],
    [1, -1, 0],
    [1, 0, 1],
    [1, 0, -1],
    [0, 1, 1],
    [0, 1, -1],
    [1, 1, 1],
    [1, 1, -1],
    [1, -1, 1],
    [-1, 1, 1],
];

/// Asks for the distances from cells of a fluid to surfaces along links.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct LinksJob {
    /// The directions.
    pub stencil: Stencil,
    /// Flags of the fluid; by default 0, the background.
    pub fluid: Vec<u8>,
}

impl Default for LinksJob {
    fn default() -> LinksJob {
        LinksJob { stencil: Stencil::default(), fluid: vec![0] }
    }
}

/// Rays of a cell along each axis where fractions are measured by rays and the job does not say by how many.
const DEFAULT_RAYS: u32 = 4;

/// How fractions of cells are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum FractionsMethod {
    /// Exactly but for rounding, from the facets within each cell.
    Exact,
    /// By rays, of which `rays` says how many.
    Rays,
}

/// Asks for the fraction of each flag in the cells that surfaces cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct FractionsJob {
    /// How they are measured: by default exactly, or by rays where `rays` is given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<FractionsMethod>,
    /// Rays of a cell along each of two axes, of the method `rays`: 1, 2, 4, 8 or 16; by default 4. The fraction of a cell that one plane cuts is off by less
    /// than 1 / rays.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rays: Option<u32>,
    /// Also measures which fraction of each face of these cells a flag has.
    pub faces: bool,
    /// Also measures area, centre and normal of the surface of each geometry in each cell.
    pub surfaces: bool,
    /// Also measures which fraction of each of the twelve edges of these cells a flag has: exact alone.
    pub edges: bool,
    /// Also measures the centre of what a flag has of a cell, and, with `faces`, of each of its faces: exact alone.
    pub centroids: bool,
}

impl FractionsJob {
    /// How many rays of a cell along each axis measure them; None where nothing is sampled.
    pub fn by_rays(&self) -> Option<u32> {
        match (self.method, self.rays) {
            (Some(FractionsMethod::Exact), _) | (None, None) => None,
            (Some(FractionsMethod::Rays), rays) | (None, rays) => Some(rays.unwrap_or(DEFAULT_RAYS)),
        }
    }
}

/// The least area of a face by default, as a part of the fraction of its longest edge.
const DEFAULT_STABLE: f64 = 0.125;

/// Asks for the fractions of edges and faces that lie outside metal, for conformal solvers of Maxwell's equations.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct ConformalJob {
    /// Flags that are metal, 0 for the background; by default those of perfect conductors (`pec = true`) and of geometries with `metal = true`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub metal: Vec<u8>,
    /// The least area of a face outside metal, as a part of the fraction of its longest edge, 0 to 1; by default 1/8. Faces beside it give what it lacks. The
    /// larger, the longer the stable step; 0 leaves areas as they are.
    pub stable: f64,
}

impl Default for ConformalJob {
    fn default() -> ConformalJob {
        ConformalJob { metal: Vec::new(), stable: DEFAULT_STABLE }
    }
}

/// Asks for the cells of one flag to be cut at its surface, for files of polyhedra and embedded boundaries. Only closed bodies have such cells, and only whole boxes are cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct CutCellsJob {
    /// The flag, 0 for what is around all geometries; by default that of the geometries, which then have one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fluid: Option<u8>,
    /// Also measures what the flag has of faces and edges, for embedded boundaries (`.eb`).
    pub boundary: bool,
}

/// Where distances are asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Points {
    /// At the centres of cells.
    #[default]
    Centres,
    /// At the crossings of lines: one more than cells along each axis.
    Nodes,
}

/// How far from surfaces distances are known.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(untagged, expecting = "a number of cells, or \"all\", is needed")]
pub enum Band {
    /// So many cells, of the longest edge of any.
    Cells(f64),
    /// "all".
    Word(Everywhere),
}

/// "all".
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Everywhere {
    /// All distances are known.
    All,
}

impl Band {
    /// The number of cells; None everywhere.
    pub fn cells(self) -> Option<f64> {
        match self {
            Band::Cells(cells) => Some(cells),
            Band::Word(Everywhere::All) => None,
        }
    }
}

impl FromStr for Band {
    type Err = Error;

    fn from_str(text: &str) -> Result<Band> {
        if text == "all" {
            return Ok(Band::Word(Everywhere::All));
        }
        let refused = |_| Error::new("job-value", format!("\"{text}\" is no band"), "give a number of cells, or all");
        text.parse().map(Band::Cells).map_err(refused)
    }
}

/// Asks for the signed distance of points to the nearest surface.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct DistanceJob {
    /// Where: "centres" of cells, or "nodes", the crossings of lines.
    pub at: Points,
    /// How far from surfaces distances are known, in cells (of the longest edge of any), above 0; or "all". By default 3. Beyond it they are its width.
    pub band: Band,
    /// Flags of the geometries whose surfaces count, as if there were no others; by default all.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub flags: Vec<u8>,
}

impl Default for DistanceJob {
    fn default() -> DistanceJob {
        DistanceJob { at: Points::Centres, band: Band::Cells(3.0), flags: Vec::new() }
    }
}

/// Asks for the permittivity that stands for the cell around each point of E on a staggered (Yee) grid. What substances have is in their materials (`eps_r`).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(default, deny_unknown_fields)]
#[non_exhaustive]
pub struct TensorsJob {
    /// Substances whose permittivity depends on the direction, in place of `eps_r` of their materials.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub anisotropic: Vec<AnisotropicJob>,
}

/// A substance whose permittivity depends on the direction.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct AnisotropicJob {
    /// Its flag, 0 for the background.
    pub flag: u8,
    /// Relative permittivity: xx, yy, zz, yz, xz and xy of a symmetric, positive tensor.
    pub eps_r: [f64; 6],
}

impl TensorsJob {
    pub(super) fn validate(&self) -> Result<()> {
        for (index, of) in self.anisotropic.iter().enumerate() {
            let key = format!("tensors.anisotropic[{index}]");
            if !of.is_positive() {
                let message = format!(
                    "{key}.eps_r is {:?}; allowed: xx, yy, zz, yz, xz and xy of a symmetric tensor whose principal values are positive",
                    of.eps_r
                );
                return Err(Error::new("job-value", message, ""));
            }
            if self.anisotropic[..index].iter().any(|other| other.flag == of.flag) {
                let message = format!("{key} has flag {}, which an entry before it has", of.flag);
                return Err(Error::new("job-conflict", message, "give a flag one permittivity"));
            }
        }
        Ok(())
    }
}

impl AnisotropicJob {
    /// Whether the tensor is finite and positive: all its principal values are.
    pub(super) fn is_positive(&self) -> bool {
        let [xx, yy, zz, yz, xz, xy] = self.eps_r;
        let minor = xx * yy - xy * xy;
        let all = zz * minor - xx * yz * yz - yy * xz * xz + 2.0 * xy * yz * xz;
        self.eps_r.iter().all(|of| of.is_finite()) && xx > 0.0 && minor > 0.0 && all > 0.0
    }
}
