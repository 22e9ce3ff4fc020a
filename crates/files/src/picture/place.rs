//! Where slices are cut.

use std::str::FromStr;

use hexcast_core::base::error::{Error, Result};
use hexcast_core::grid::lines::{AXES, Lines};
use hexcast_derived::mesh::Mesh;

/// A place along an axis; as text a coordinate such as `0.5`, or `25%`.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Place {
    /// In the unit of the mesh.
    Coordinate(f64),
    /// Of the length of the mesh, 0 to 100.
    Percent(f64),
}

impl FromStr for Place {
    type Err = Error;

    fn from_str(text: &str) -> Result<Place> {
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
        let found = match text.strip_suffix('%') {
            Some(percent) => number(percent).filter(|percent| (0.0..=100.0).contains(percent)).map(Place::Percent),
            None => number(text).map(Place::Coordinate),
        };
        let message = || format!("{text:?} is not a place; allowed: a coordinate such as 0.5, or 0% to 100%");
        found.ok_or_else(|| Error::new("job-value", message(), ""))
    }
}

/// A plane of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cut {
    /// The axis across it: 0, 1 or 2.
    pub axis: usize,
    /// Index of the cells along this axis.
    pub index: u32,
}

impl Cut {
    /// The plane of cells at a place along an axis; of two that it lies between, the upper one.
    ///
    /// # Errors
    /// `job-value` where there is no such axis, or the mesh does not reach that far.
    pub fn at(mesh: &Mesh, axis: usize, place: Place) -> Result<Cut> {
        Cut::of_lines(mesh.lines(), axis, place)
    }

    /// The same of a mesh that has these lines.
    ///
    /// # Errors
    /// Those of [`Cut::at`].
    pub(super) fn of_lines(lines: &Lines, axis: usize, place: Place) -> Result<Cut> {
        if axis > 2 {
            return Err(Error::new("job-value", format!("there is no axis {axis}"), "axes are 0, 1 and 2"));
        }
        let [low, high] = ends(lines, axis);
        let coordinate = match place {
            Place::Coordinate(at) => at,
            Place::Percent(percent) => (low + 0.01 * percent * (high - low)).clamp(low, high),
        };
        if !(low..=high).contains(&coordinate) {
            let message =
                format!("{coordinate} is not within the mesh, which reaches from {low} to {high} along {}", AXES[axis]);
            return Err(Error::new("job-value", message, "choose a place within the mesh"));
        }
        Ok(Cut { axis, index: cell_at(lines, axis, coordinate) })
    }
}

/// The first and the last line of an axis.
pub(super) fn ends(lines: &Lines, axis: usize) -> [f64; 2] {
    [0, lines.dims()[axis]].map(|index| lines.line(axis, index))
}

/// The cell of an axis that a coordinate lies in; the first or last beyond the mesh.
pub(super) fn cell_at(lines: &Lines, axis: usize, coordinate: f64) -> u32 {
    let (mut low, mut high) = (0, lines.dims()[axis] - 1);
    while low < high {
        let middle = low + (high - low).div_ceil(2);
        if lines.line(axis, middle) <= coordinate { low = middle } else { high = middle - 1 }
    }
    low
}
