//! Sizes in bytes: a number, or a number and a unit.

use std::fmt;
use std::str::FromStr;

use serde::de::{self, Visitor};
use serde::{Deserialize, Deserializer, Serialize};

/// A number of bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
pub struct ByteSize(pub u64);

/// Units by their names in lower case: powers of 1000, and of 1024 with an i.
const UNITS: &[(&str, u64)] = &[
    ("", 1),
    ("b", 1),
    ("k", 1000),
    ("kb", 1000),
    ("m", 1_000_000),
    ("mb", 1_000_000),
    ("g", 1_000_000_000),
    ("gb", 1_000_000_000),
    ("t", 1_000_000_000_000),
    ("tb", 1_000_000_000_000),
    ("kib", 1 << 10),
    ("mib", 1 << 20),
    ("gib", 1 << 30),
    ("tib", 1 << 40),
];

impl FromStr for ByteSize {
    type Err = String;

    /// Reads a size such as `512MiB`, `2GB`, `1.5 TB` or `4096`.
    fn from_str(text: &str) -> Result<ByteSize, String> {
        let wrong = || format!("\"{text}\" is not a size: a number and a unit such as 512MiB or 2GB is needed");
        let text = text.trim();
        let split = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
        let (number, unit) = text.split_at(split);
        let unit = unit.trim().to_ascii_lowercase();
        let (_, factor) = UNITS.iter().find(|(name, _)| *name == unit).ok_or_else(wrong)?;
        match scaled(number.trim(), *factor) {
            Some(0) => Err(format!("\"{text}\" is no memory: at least 1 byte is needed, such as 512MiB")),
            bytes => bytes.map(ByteSize).ok_or_else(wrong),
        }
    }
}

/// A decimal number times a factor, rounded down; six digits after the point count. None where it is not a number, or too
/// large.
fn scaled(number: &str, factor: u64) -> Option<u64> {
    let (whole, fraction) = number.split_once('.').unwrap_or((number, "0"));
    let digits = |text: &str| (!text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit())).then_some(());
    digits(whole).and(digits(fraction))?;
    let parts = fraction.bytes().chain([b'0'; 6]).take(6).fold(0, |parts, digit| 10 * parts + u64::from(digit - b'0'));
    whole.parse::<u64>().ok()?.checked_mul(factor)?.checked_add(factor * parts / 1_000_000)
}

impl fmt::Display for ByteSize {
    /// Writes the size with three digits and a unit of 1000.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bytes = self.0 as f64;
        let scaled = [(1e12, "TB"), (1e9, "GB"), (1e6, "MB"), (1e3, "kB")].into_iter().find(|(unit, _)| bytes >= *unit);
        match scaled {
            Some((unit, name)) => {
                let hundredths = (bytes / unit * 100.0).round() as u64;
                write!(f, "{}.{:02} {name}", hundredths / 100, hundredths % 100)
            }
            None => write!(f, "{} bytes", self.0),
        }
    }
}

impl<'de> Deserialize<'de> for ByteSize {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<ByteSize, D::Error> {
        struct NumberOrText;
        impl Visitor<'_> for NumberOrText {
            type Value = ByteSize;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a number of bytes, at least 1, or a text such as \"2GB\"")
            }

            fn visit_u64<E: de::Error>(self, bytes: u64) -> Result<ByteSize, E> {
                if bytes == 0 {
                    return Err(E::invalid_value(de::Unexpected::Unsigned(0), &self));
                }
                Ok(ByteSize(bytes))
            }

            fn visit_i64<E: de::Error>(self, bytes: i64) -> Result<ByteSize, E> {
                match u64::try_from(bytes) {
                    Ok(bytes) => self.visit_u64(bytes),
                    Err(_) => Err(E::invalid_value(de::Unexpected::Signed(bytes), &self)),
                }
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<ByteSize, E> {
                text.parse().map_err(E::custom)
            }
        }
        deserializer.deserialize_any(NumberOrText)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_with_and_without_units() {
        let table = [
            ("4096", 4096),
            ("512MiB", 512 << 20),
            ("2GB", 2_000_000_000),
            ("1.5 gib", 3 << 29),
            (" 3k ", 3000),
            ("0.25 kB", 250),
            ("1.9999999MB", 1_999_999),
            ("2TiB", 2 << 40),
        ];
        for (text, bytes) in table {
            assert_eq!(text.parse(), Ok(ByteSize(bytes)), "{text}");
        }
        for text in ["", "GB", "-1GB", "0", "1e30", "2 parsecs", "nan", "0.1b", "1.", ".5GB", "1.5.2kB", "20000000TB"] {
            assert!(text.parse::<ByteSize>().unwrap_err().contains("512MiB"), "{text}");
        }
        let job = |json: &str| {
            crate::input::job::Job::from_json(&format!(
                "{{\"geometries\": [{{\"file\": \"a\"}}], \"max_memory\": {json}}}"
            ))
        };
        assert_eq!(job("\"2GB\"").unwrap().max_memory, Some(ByteSize(2_000_000_000)));
        assert_eq!(job("77").unwrap().max_memory, Some(ByteSize(77)));
        for wrong in ["0", "-3", "1.5", "\"much\"", "[1]"] {
            let error = job(wrong).unwrap_err();
            assert!(error.code() == "job-value" && error.to_string().starts_with("max_memory"), "{error}");
        }
        assert_eq!([ByteSize(999), ByteSize(5_230_000_000)].map(|size| size.to_string()), ["999 bytes", "5.23 GB"]);
    }
}
