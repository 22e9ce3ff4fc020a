//! Some keys of a text of JSON, so that errors name its lines.

use std::fmt;
use std::marker::PhantomData;

use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeOwned, DeserializeSeed, Deserializer, IgnoredAny, IntoDeserializer, MapAccess, Visitor};

use crate::base::error::Result;
use crate::input::job::text::of_json_text;

/// Reads those keys of a text that `is_wanted`.
///
/// # Errors
/// `job-value` with the key, line and column.
pub(super) fn of_keys<T: DeserializeOwned>(text: &str, is_wanted: &dyn Fn(&str) -> bool) -> Result<T> {
    of_json_text(text, Wanted { is_wanted, made: PhantomData })
}

struct Wanted<'a, T> {
    is_wanted: &'a dyn Fn(&str) -> bool,
    made: PhantomData<T>,
}

impl<'de, T: DeserializeOwned> DeserializeSeed<'de> for Wanted<'_, T> {
    type Value = T;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> std::result::Result<T, D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de, T: DeserializeOwned> Visitor<'de> for Wanted<'_, T> {
    type Value = T;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the keys of a job in { }")
    }

    fn visit_map<A: MapAccess<'de>>(self, keys: A) -> std::result::Result<T, A::Error> {
        T::deserialize(MapAccessDeserializer::new(Keys { keys, is_wanted: self.is_wanted }))
    }
}

/// Keys without those that are not wanted.
struct Keys<'a, A> {
    keys: A,
    is_wanted: &'a dyn Fn(&str) -> bool,
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for Keys<'_, A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> std::result::Result<Option<K::Value>, A::Error> {
        while let Some(key) = self.keys.next_key::<String>()? {
            if (self.is_wanted)(&key) {
                return seed.deserialize(key.into_deserializer()).map(Some);
            }
            let _: IgnoredAny = self.keys.next_value()?;
        }
        Ok(None)
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> std::result::Result<V::Value, A::Error> {
        self.keys.next_value_seed(seed)
    }
}
