//! Numbers of a job file: lists of exactly so many, one number or three, flags.
//!
//! Serde takes the first three numbers of a longer list, and some formats ignore the rest; here a number too many is an error,
//! as one too few is. Messages say what is expected, the caller adds the key.

use std::fmt;
use std::marker::PhantomData;

use serde::Serialize;
use serde::de::value::SeqAccessDeserializer;
use serde::de::{Deserialize, Deserializer, Error, IntoDeserializer, SeqAccess, Unexpected, Visitor};

/// Reads an optional list of exactly N numbers.
pub(super) fn list<'de, D, T, const N: usize>(deserializer: D) -> Result<Option<[T; N]>, D::Error>
where
    D: Deserializer<'de>,
    T: Deserialize<'de>,
{
    let list = Option::<Vec<T>>::deserialize(deserializer)?;
    list.map(|list| exactly(list, &format!("{N} numbers").as_str())).transpose()
}

/// Reads an optional flag; the error of another number names the range, not a Rust type.
pub(super) fn flag<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<u8>, D::Error> {
    let number = Option::<i64>::deserialize(deserializer)?;
    let flag = |number| {
        u8::try_from(number).map_err(|_| D::Error::invalid_value(Unexpected::Signed(number), &"a flag: 1 to 255"))
    };
    number.map(flag).transpose()
}

/// Reads a number that is neither infinite nor NaN, which JSON does not have; for pictures, which are native only.
#[cfg(not(target_arch = "wasm32"))]
pub(super) fn finite<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    let number = f64::deserialize(deserializer)?;
    if number.is_finite() {
        return Ok(number);
    }
    Err(D::Error::invalid_value(Unexpected::Float(number), &"a finite number"))
}

fn exactly<T, E: Error, const N: usize>(list: Vec<T>, expected: &dyn serde::de::Expected) -> Result<[T; N], E> {
    let found = list.len();
    <[T; N]>::try_from(list).map_err(|_| E::invalid_length(found, expected))
}

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

struct OneOrThree<T>(PhantomData<T>);

impl<'de, T: Deserialize<'de>> Visitor<'de> for OneOrThree<T> {
    type Value = PerAxis<T>;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number or a list of three")
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<PerAxis<T>, E> {
        T::deserialize(value.into_deserializer()).map(PerAxis::All)
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<PerAxis<T>, E> {
        T::deserialize(value.into_deserializer()).map(PerAxis::All)
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<PerAxis<T>, E> {
        T::deserialize(value.into_deserializer()).map(PerAxis::All)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, list: A) -> Result<PerAxis<T>, A::Error> {
        let list = Vec::<T>::deserialize(SeqAccessDeserializer::new(list))?;
        exactly(list, &self).map(PerAxis::Each)
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for PerAxis<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<PerAxis<T>, D::Error> {
        deserializer.deserialize_any(OneOrThree(PhantomData))
    }
}
