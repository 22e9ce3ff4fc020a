//! Facts for solvers about cells that differ in size.

use serde::Serialize;

use super::Lines;
use crate::base::length::Length;

/// Lines that are not equally spaced, and how their distances change.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Grading {
    /// All lines along x, ascending, in the unit of the files: cells + 1 of them.
    pub x: Vec<f64>,
    /// Those along y.
    pub y: Vec<f64>,
    /// Those along z.
    pub z: Vec<f64>,
    /// Size of the smallest cell on x, y, z.
    pub smallest: [f64; 3],
    /// Size of the largest.
    pub largest: [f64; 3],
    /// The greatest ratio of the sizes of two neighbours, at least 1.
    pub ratio: [f64; 3],
    /// The longest step of a solver of the wave equation on these cells by central differences, as the length that light goes in it:
    /// `c dt = 1 / sqrt(1/dx^2 + 1/dy^2 + 1/dz^2)` of the smallest sizes (Courant, Friedrichs and Lewy 1928).
    pub courant_length: f64,
    /// The same in seconds, in vacuum; null where the unit of lengths is not known.
    pub courant_seconds: Option<f64>,
}

/// Metres a second of light in vacuum.
const LIGHT: f64 = 299_792_458.0;

impl Grading {
    /// Describes lines whose lengths have a unit; None where they are equally spaced.
    pub fn of(lines: &Lines, unit: Option<&str>) -> Option<Grading> {
        if !lines.is_graded() {
            return None;
        }
        let lists = [0, 1, 2].map(|axis| lines.list(axis));
        let sizes =
            [0, 1, 2].map(|axis: usize| lists[axis].windows(2).map(|two| two[1] - two[0]).collect::<Vec<f64>>());
        let [smallest, largest] = [f64::min as fn(f64, f64) -> f64, f64::max]
            .map(|choose| [0, 1, 2].map(|axis: usize| sizes[axis].iter().copied().fold(sizes[axis][0], choose)));
        let ratio =
            |sizes: &Vec<f64>| sizes.windows(2).map(|two| (two[0] / two[1]).max(two[1] / two[0])).fold(1.0, f64::max);
        let courant_length = 1.0 / smallest.iter().map(|size| 1.0 / (size * size)).sum::<f64>().sqrt();
        let ratio = [0, 1, 2].map(|axis: usize| ratio(&sizes[axis]));
        let [x, y, z] = lists;
        Some(Grading { x, y, z, smallest, largest, ratio, courant_length, courant_seconds: None }.with_unit(unit))
    }

    /// Says what the unit of lengths is, which the seconds of `courant_seconds` need.
    #[doc(hidden)]
    pub fn with_unit(self, unit: Option<&str>) -> Grading {
        let courant_seconds = unit.and_then(Length::of_name).map(|unit| unit.metres(self.courant_length) / LIGHT);
        Grading { courant_seconds, ..self }
    }
}
