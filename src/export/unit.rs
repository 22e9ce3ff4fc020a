//! Units of length, for programs that count in one of their own.

use crate::error::{Error, Result};

/// A unit of length as a quotient of whole numbers, so that 0.3 mm become the number nearest to 0.0003 m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Length {
    times: f64,
    over: f64,
}

/// Names of units, and how many metres they are: the first number over the second.
const UNITS: [(&[&str], f64, f64); 11] = [
    (&["m", "metre", "metres", "meter", "meters"], 1.0, 1.0),
    (&["dm"], 1.0, 1e1),
    (&["cm"], 1.0, 1e2),
    (&["mm", "millimetre", "millimetres", "millimeter", "millimeters"], 1.0, 1e3),
    (&["um", "\u{b5}m", "\u{3bc}m", "micron", "microns"], 1.0, 1e6),
    (&["nm"], 1.0, 1e9),
    (&["km"], 1e3, 1.0),
    (&["in", "inch", "inches"], 254.0, 1e4),
    (&["ft", "foot", "feet"], 3048.0, 1e4),
    (&["mil", "thou"], 254.0, 1e7),
    (&["yd", "yard", "yards"], 9144.0, 1e4),
];

impl Length {
    /// Finds a unit by its name: m, dm, cm, mm, um (also with the micro sign), nm, km, in, ft, yd or mil.
    pub fn of_name(name: &str) -> Option<Length> {
        let name = name.trim();
        let known = UNITS.iter().find(|(names, ..)| names.contains(&name));
        known.map(|&(_, times, over)| Length { times, over })
    }

    /// So many of this unit, in metres.
    pub fn metres(self, length: f64) -> f64 {
        length * self.times / self.over
    }

    /// So many of this unit, in centimetres.
    pub fn centimetres(self, length: f64) -> f64 {
        // the larger of both numbers is a power of ten, or the other is 1: the quotient is exact
        if self.over >= 1e2 { length * self.times / (self.over / 1e2) } else { length * (self.times * 1e2 / self.over) }
    }
}

/// The unit of a mesh, for what needs metres.
///
/// # Errors
/// Those of [`known`].
pub(super) fn metres(unit: Option<&str>, what: &str) -> Result<Length> {
    known(unit, what, "metres")
}

/// The unit of a mesh, for what needs lengths in one of its own.
///
/// # Errors
/// `export-unit` where the mesh has none, or one that is not known.
pub(super) fn known(unit: Option<&str>, what: &str, own: &str) -> Result<Length> {
    let hint = "say what the lengths are with --unit mm (in a job unit = \"mm\"): m, dm, cm, mm, um, nm, km, in, ft, yd or mil";
    let Some(unit) = unit else {
        return Err(Error::new(
            "export-unit",
            format!("{what} needs {own}, and the mesh has lengths without a unit"),
            hint,
        ));
    };
    Length::of_name(unit).ok_or_else(|| {
        Error::new(
            "export-unit",
            format!("{what} needs {own}, and the unit \"{unit}\" of the mesh is not a known one"),
            hint,
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_the_nearest_numbers() {
        let metres = |name: &str, length| Length::of_name(name).map(|unit| unit.metres(length));
        let table = [
            ("m", 0.3, 0.3),
            ("mm", 0.3, 0.0003),
            ("\u{b5}m", 7.0, 7e-6),
            ("\u{3bc}m", 7.0, 7e-6),
            ("in", 1.0, 0.0254),
        ];
        for (name, length, expected) in
            table.into_iter().chain([("ft", 10.0, 3.048), ("mil", 1000.0, 0.0254), ("km", 2.0, 2000.0)])
        {
            assert_eq!(metres(name, length), Some(expected), "{name}");
        }
        let centimetres = |name: &str, length| Length::of_name(name).map(|unit| unit.centimetres(length));
        for (name, length, expected) in [
            ("m", 0.3, 30.0),
            ("mm", 0.3, 0.03),
            ("cm", 0.7, 0.7),
            ("in", 1.0, 2.54),
            ("km", 2.0, 2e5),
            ("dm", 0.1, 1.0),
        ] {
            assert_eq!(centimetres(name, length), Some(expected), "{name}");
        }
        // M is not m: in other programs it is mega
        assert_eq!([metres("furlong", 1.0), metres("M", 1.0), metres("", 1.0)], [None; 3]);
    }
}
