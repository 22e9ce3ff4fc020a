//! Units of length, for programs that count in one of their own.

use hexcast_core::base::error::{Error, Result};
pub use hexcast_core::base::length::Length;

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
