//! What the report says of a staggered grid.

use serde::Serialize;

use crate::error::Result;
use crate::staggered::Staggered;

/// The points of a staggered grid, counted.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct StaggeredReport {
    /// The components, Ex, Ey, Ez, Hx, Hy and Hz.
    pub components: Vec<ComponentReport>,
    /// Number of faces that are sheets.
    pub sheet_faces: u64,
}

/// The points of a component.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ComponentReport {
    /// Such as "Ex".
    pub name: &'static str,
    /// Number of points on x, y and z.
    pub dims: [u32; 3],
    /// Every flag that a point has, ascending; 0 is the background.
    pub flags: Vec<PointsReport>,
}

/// The points of a flag.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct PointsReport {
    /// The flag.
    pub flag: u8,
    /// Number of points.
    pub points: u64,
}

impl StaggeredReport {
    /// Counts points.
    ///
    /// # Errors
    /// `io` where columns are in a store that fails.
    pub fn new(staggered: &Staggered) -> Result<StaggeredReport> {
        let component = |points: &crate::staggered::Points| {
            let flags = (0..=u8::MAX).zip(points.n_per_flag()?).filter(|(_, n)| *n > 0);
            let flags = flags.map(|(flag, points)| PointsReport { flag, points }).collect();
            Ok(ComponentReport { name: points.name, dims: points.dims(), flags })
        };
        let components = staggered.points.iter().map(component).collect::<Result<_>>()?;
        Ok(StaggeredReport { components, sheet_faces: staggered.sheets.len() as u64 })
    }
}
