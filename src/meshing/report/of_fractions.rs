//! What the report says of cells that surfaces cut.

use serde::Serialize;

use hexcast_core::derived::fractions::Fractions;

/// Cells that surfaces cut, counted, and the volumes of flags that follow.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct FractionsReport {
    /// m: a cell has m x m rays.
    pub rays: u32,
    /// Cells that are cut: those with more than one flag, and those that a surface passes through where no ray meets it.
    pub cut_cells: u64,
    /// Volume of each flag that has any, ascending; 0 is the background.
    pub volumes: Vec<VolumeReport>,
    /// Area of the surface of each geometry in the box, in the order of the job; null unless surfaces are asked for.
    pub areas: Option<Vec<f64>>,
}

/// Volume of a flag, with its fractions of cells that are cut.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct VolumeReport {
    /// The flag.
    pub flag: u8,
    /// The volume.
    pub volume: f64,
}

impl FractionsReport {
    /// Counts cells.
    pub fn new(fractions: &Fractions) -> FractionsReport {
        let volumes = (0..=u8::MAX).zip(&fractions.volumes).filter(|(_, volume)| **volume > 0.0);
        FractionsReport {
            rays: fractions.rays,
            cut_cells: fractions.n_cells(),
            volumes: volumes.map(|(flag, &volume)| VolumeReport { flag, volume }).collect(),
            areas: fractions.areas.clone(),
        }
    }
}
