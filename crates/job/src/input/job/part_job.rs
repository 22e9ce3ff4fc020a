//! One of the parts of a box, also from the command line as 3/64.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// One of the windows that a box is divided into.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct PartJob {
    /// Which part, from 1 on; x fastest.
    pub index: u32,
    /// Numbers of parts along x, y and z.
    pub of: [u32; 3],
}

impl PartJob {
    /// A part by its index, from 1 on, and the numbers of parts along x, y and z.
    pub fn new(index: u32, of: [u32; 3]) -> PartJob {
        PartJob { index, of }
    }

    /// Number of all parts.
    pub fn n_parts(&self) -> u64 {
        // of 2^96 at most the job's check leaves what is fewer than cells
        self.of.iter().fold(1u64, |n, &of| n.saturating_mul(of.into()))
    }
}

impl FromStr for PartJob {
    type Err = String;

    /// Reads a part such as `3/64`, of slabs across z, or `3/4x4x4`.
    fn from_str(text: &str) -> Result<PartJob, String> {
        let wrong =
            || format!("\"{text}\" is not a part: K/N or K/NXxNYxNZ is needed, K from 1 to N, such as 3/64 or 3/4x4x4");
        let (index, of) = text.split_once('/').ok_or_else(wrong)?;
        let part = PartJob { index: index.parse().map_err(|_| wrong())?, of: numbers_of_parts(of).ok_or_else(wrong)? };
        if (1..=part.n_parts()).contains(&part.index.into()) { Ok(part) } else { Err(wrong()) }
    }
}

/// Reads numbers of parts along x, y and z: `4x4x4`, or `64` for slabs across z. None where it is neither, or a number is 0.
pub fn numbers_of_parts(text: &str) -> Option<[u32; 3]> {
    let numbers: Option<Vec<u32>> =
        text.split('x').map(|number| number.parse().ok().filter(|&number| number > 0)).collect();
    match numbers?[..] {
        [n] => Some([1, 1, n]),
        [x, y, z] => Some([x, y, z]),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_counted_from_one() {
        assert_eq!("3/64".parse(), Ok(PartJob { index: 3, of: [1, 1, 64] }));
        assert_eq!("17/2x3x4".parse(), Ok(PartJob { index: 17, of: [2, 3, 4] }));
        assert_eq!("1/1".parse::<PartJob>().map(|part| part.n_parts()), Ok(1));
        for wrong in ["0/4", "5/4", "1", "1/0", "a/4", "-1/4", "", "1/2x2", "25/2x3x4", "1/2x0x2", "1/"] {
            assert!(wrong.parse::<PartJob>().is_err(), "{wrong}");
        }
    }
}
