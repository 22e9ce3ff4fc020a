//! Which links between cells are measured.

use serde::{Deserialize, Serialize};

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
