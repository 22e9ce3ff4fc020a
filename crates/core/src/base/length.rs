//! Units of length by their names.

/// A unit of length as a quotient of whole numbers, so that 0.3 mm become the number nearest to 0.0003 m.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Length {
    times: f64,
    over: f64,
    /// Its name in UDUNITS, if it has one there.
    udunits: Option<&'static str>,
}

/// Names of units, how many metres they are, the first number over the second, and their names in UDUNITS.
const UNITS: [(&[&str], f64, f64, Option<&str>); 11] = [
    (&["m", "metre", "metres", "meter", "meters"], 1.0, 1.0, Some("meter")),
    (&["dm"], 1.0, 1e1, Some("decimeter")),
    (&["cm"], 1.0, 1e2, Some("centimeter")),
    (&["mm", "millimetre", "millimetres", "millimeter", "millimeters"], 1.0, 1e3, Some("millimeter")),
    (&["um", "\u{b5}m", "\u{3bc}m", "micron", "microns"], 1.0, 1e6, Some("micrometer")),
    (&["nm"], 1.0, 1e9, Some("nanometer")),
    (&["km"], 1e3, 1.0, Some("kilometer")),
    (&["in", "inch", "inches"], 254.0, 1e4, Some("inch")),
    (&["ft", "foot", "feet"], 3048.0, 1e4, Some("foot")),
    (&["mil", "thou"], 254.0, 1e7, None),
    (&["yd", "yard", "yards"], 9144.0, 1e4, Some("yard")),
];

impl Length {
    /// Finds a unit by its name: m, dm, cm, mm, um (also with the micro sign), nm, km, in, ft, yd or mil.
    pub fn of_name(name: &str) -> Option<Length> {
        let name = name.trim();
        let known = UNITS.iter().find(|(names, ..)| names.contains(&name));
        known.map(|&(_, times, over, udunits)| Length { times, over, udunits })
    }

    /// Its name in UDUNITS, such as "millimeter"; None for mil.
    pub fn udunits(self) -> Option<&'static str> {
        self.udunits
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
