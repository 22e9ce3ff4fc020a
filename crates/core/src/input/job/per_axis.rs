//! One number for the three axes, or three.

use serde::Serialize;

/// One number for all axes, or one an axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum PerAxis<T> {
    /// The same for x, y and z.
    All(T),
    /// x, y and z.
    Each([T; 3]),
}

impl<T: Copy> PerAxis<T> {
    /// The three numbers.
    pub fn each(self) -> [T; 3] {
        match self {
            PerAxis::All(value) => [value; 3],
            PerAxis::Each(values) => values,
        }
    }
}
