//! What is chosen for a geometry: where it lies, which cells it has, how lines are generated around it, what it is made of.

use serde::{Deserialize, Serialize};

use crate::base::error::{Error, Result};

pub mod material;
pub mod placing;

/// How the cells of a geometry are decided whose surface is not closed. One that is closed is not affected.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Open {
    /// By the rays of three axes where they agree, elsewhere by the generalised winding number.
    #[default]
    Winding,
    /// By most of the three axes whose rays cross it an even number of times: for surfaces that cannot be oriented.
    Vote,
    /// Not at all: an error.
    Error,
    /// By the rays of one axis, up to the last matched pair of crossings of each.
    Parity,
}

/// Which cells a geometry has besides those whose centres lie inside of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Fill {
    /// No others.
    #[default]
    Centre,
    /// Every cell whose box the surface touches.
    Conservative,
    /// The cells that separate the two sides of the surface: no path from face neighbour to face neighbour leads through it.
    Separating,
}

impl Fill {
    /// Its name in jobs and reports.
    pub fn name(self) -> &'static str {
        match self {
            Fill::Centre => "centre",
            Fill::Conservative => "conservative",
            Fill::Separating => "separating",
        }
    }
}

/// How lines are generated around a geometry.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[non_exhaustive]
pub struct Sizing {
    /// Largest size of a cell across it.
    pub max_size: Option<f64>,
    /// Fewest cells across it along every axis.
    pub min_cells: Option<u32>,
    /// Whether lines lie a third of a cell inside of its edges and two thirds outside, instead of on them.
    pub metal: bool,
}

/// Most geometries of a job. Of more than 255 some must have the same flag.
pub const MAX_GEOMETRIES: usize = u16::MAX as usize;

/// Refuses more geometries than [`MAX_GEOMETRIES`].
#[doc(hidden)]
pub fn check_n_geometries(n: usize, who: &str) -> Result<()> {
    if n <= MAX_GEOMETRIES {
        return Ok(());
    }
    let message = format!("{who} {n} geometries: at most {MAX_GEOMETRIES} fit");
    Err(Error::new("too-many-geometries", message, "join files and solids of the same substance"))
}
