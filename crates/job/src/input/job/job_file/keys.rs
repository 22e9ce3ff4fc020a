//! Keys of a job file: those that a struct has, and those of a text of JSON that are wanted, so that errors name its lines.

use std::fmt;
use std::marker::PhantomData;

use serde::de::value::MapAccessDeserializer;
use serde::de::{
    self, Deserialize, DeserializeOwned, DeserializeSeed, Deserializer, IgnoredAny, IntoDeserializer, MapAccess,
    Visitor,
};
use serde::forward_to_deserialize_any;

use crate::base::error;
use crate::input::job::text::of_json_text;

/// The names of the keys of a struct; none of any other type.
pub(super) fn names<T: for<'de> Deserialize<'de>>() -> &'static [&'static str] {
    T::deserialize(Asking).err().map_or(&[], |Asked(keys)| keys)
}

/// Reads nothing: the error says which keys were asked for.
struct Asking;

#[derive(Debug)]
struct Asked(&'static [&'static str]);

impl<'de> Deserializer<'de> for Asking {
    type Error = Asked;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Asked> {
        Err(Asked(&[]))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        keys: &'static [&'static str],
        _: V,
    ) -> Result<V::Value, Asked> {
        Err(Asked(keys))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct newtype_struct seq tuple
        tuple_struct map enum identifier ignored_any
    }
}

impl fmt::Display for Asked {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.0)
    }
}

impl std::error::Error for Asked {}

impl de::Error for Asked {
    fn custom<T: fmt::Display>(_: T) -> Asked {
        Asked(&[])
    }
}

/// Reads those keys of a text that `is_wanted`.
///
/// # Errors
/// `job-value` with the key, line and column.
pub(super) fn of_keys<T: DeserializeOwned>(text: &str, is_wanted: &dyn Fn(&str) -> bool) -> error::Result<T> {
    of_json_text(text, Wanted { is_wanted, made: PhantomData })
}

struct Wanted<'a, T> {
    is_wanted: &'a dyn Fn(&str) -> bool,
    made: PhantomData<T>,
}

impl<'de, T: DeserializeOwned> DeserializeSeed<'de> for Wanted<'_, T> {
    type Value = T;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<T, D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de, T: DeserializeOwned> Visitor<'de> for Wanted<'_, T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the keys of a job in { }")
    }

    fn visit_map<A: MapAccess<'de>>(self, keys: A) -> Result<T, A::Error> {
        T::deserialize(MapAccessDeserializer::new(WantedKeys { keys, is_wanted: self.is_wanted }))
    }
}

/// WantedKeys without those that are not wanted.
struct WantedKeys<'a, A> {
    keys: A,
    is_wanted: &'a dyn Fn(&str) -> bool,
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for WantedKeys<'_, A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, A::Error> {
        while let Some(key) = self.keys.next_key::<String>()? {
            if (self.is_wanted)(&key) {
                return seed.deserialize(key.into_deserializer()).map(Some);
            }
            let _: IgnoredAny = self.keys.next_value()?;
        }
        Ok(None)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, A::Error> {
        self.keys.next_value_seed(seed)
    }
}
