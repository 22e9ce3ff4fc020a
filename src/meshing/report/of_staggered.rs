//! What the report says of a staggered grid.

use serde::{Deserialize, Serialize};

use hexcast_core::base::error::Result;
use hexcast_core::derived::staggered::{COMPONENTS, Points, SheetFace, Staggered};

/// The points of a staggered grid, counted.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct StaggeredReport {
    /// The components, Ex, Ey, Ez, Hx, Hy and Hz.
    pub components: Vec<ComponentReport>,
    /// Number of faces that are sheets.
    pub sheet_faces: u64,
}

/// The points of a component.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct ComponentReport {
    /// Such as "Ex".
    pub name: String,
    /// Number of points on x, y and z.
    pub dims: [u32; 3],
    /// Every flag that a point has, ascending; 0 is the background.
    pub flags: Vec<PointsReport>,
}

/// The points of a flag.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
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
        StaggeredReport::without_last(staggered, [false; 3])
    }

    /// Counts the points of a window that no window behind it has, too: not those on its last line along an axis, unless that is the last of the box. It
    /// ends at the cell `end` of a box of so many cells.
    ///
    /// # Errors
    /// `io` where columns are in a store that fails.
    #[doc(hidden)]
    pub fn of_window(staggered: &Staggered, end: [u32; 3], of: [u32; 3]) -> Result<StaggeredReport> {
        StaggeredReport::without_last(staggered, [0, 1, 2].map(|axis| end[axis] < of[axis]))
    }

    /// Counts points, but those on the last line along some axes.
    fn without_last(staggered: &Staggered, leaves: [bool; 3]) -> Result<StaggeredReport> {
        let component = |(points, (_, is_on_line)): (&Points, (&str, [bool; 3]))| {
            let end = [0, 1, 2].map(|axis| points.dims()[axis] - u32::from(leaves[axis] && is_on_line[axis]));
            let flags = (0..=u8::MAX).zip(points.n_before(end)?).filter(|(_, n)| *n > 0);
            let flags = flags.map(|(flag, points)| PointsReport { flag, points }).collect();
            Ok(ComponentReport { name: points.name.into(), dims: end, flags })
        };
        let components = staggered.points.iter().zip(COMPONENTS).map(component).collect::<Result<_>>()?;
        // components of H across an axis have a point on each of its lines
        let [of_x, of_y, of_z] = [3, 4, 5].map(|of: usize| staggered.points[of].dims());
        let last = [of_x[0] - 1, of_y[1] - 1, of_z[2] - 1];
        let is_left = |sheet: &&SheetFace| {
            let axis = usize::from(sheet.axis);
            leaves[axis] && sheet.face[axis] == last[axis]
        };
        let n_left = staggered.sheets.iter().filter(is_left).count();
        Ok(StaggeredReport { components, sheet_faces: (staggered.sheets.len() - n_left) as u64 })
    }
}
