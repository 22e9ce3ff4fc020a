//! Plain data from JSON, through serde: the browser's own `JSON` reads the text, so that the page does not load another.
//!
//! A failure to read knows the path of the key, such as `geometries[1].flag`, and says what was expected there.

use std::fmt;

use js_sys::{Array, JSON, Object};
use serde::de::value::StringDeserializer;
use serde::de::{self, DeserializeOwned, DeserializeSeed, Deserializer, IntoDeserializer, Unexpected, Visitor};
use serde::forward_to_deserialize_any;
use wasm_bindgen::prelude::*;

use crate::digits::Number;

/// Whole numbers up to here are exact in a JavaScript number.
const MAX_EXACT: f64 = 9_007_199_254_740_992.0;

/// Reads plain data from JSON; None where the text is none.
pub(super) fn from_json<T: DeserializeOwned>(text: &str) -> Option<Result<T, Problem>> {
    JSON::parse(text).ok().map(|value| T::deserialize(FromJs(value)))
}

/// What is wrong, and with which key; an empty path is the value itself.
#[derive(Debug)]
pub(super) struct Problem(Box<Place>);

/// The key and what is wrong with it.
#[derive(Debug)]
pub(super) struct Place {
    pub(super) path: String,
    pub(super) message: String,
}

impl Problem {
    fn new(message: String) -> Problem {
        Problem(Box::new(Place { path: String::new(), message }))
    }

    /// The path of the key, and what is wrong with it.
    pub(super) fn place(&self) -> &Place {
        &self.0
    }

    /// The words of serde, which writes numbers with code that would be loaded for them alone.
    fn unexpected(what: &str, found: Unexpected, expected: &dyn de::Expected) -> Problem {
        let found = match found {
            Unexpected::Bool(flag) => format!("boolean `{flag}`"),
            Unexpected::Unsigned(number) => format!("integer `{number}`"),
            Unexpected::Signed(number) => format!("integer `{number}`"),
            Unexpected::Float(number) => format!("floating point `{:?}`", Number(number)),
            Unexpected::Str(text) => format!("string \"{text}\""),
            Unexpected::Unit => "unit value".into(),
            Unexpected::Seq => "sequence".into(),
            Unexpected::Map => "map".into(),
            Unexpected::UnitVariant => "unit variant".into(),
            Unexpected::NewtypeVariant => "newtype variant".into(),
            Unexpected::Other(text) => text.into(),
            _ => "another value".into(),
        };
        Problem::new(format!("invalid {what}: {found}, expected {expected}"))
    }

    /// Puts the key that holds the value in front of the path.
    fn within(mut self, key: &str) -> Problem {
        let path = &mut self.0.path;
        let dot = if path.is_empty() || path.starts_with('[') { "" } else { "." };
        *path = [key, dot, path].concat();
        self
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0.message)
    }
}

impl std::error::Error for Problem {}

impl de::Error for Problem {
    fn custom<T: fmt::Display>(message: T) -> Problem {
        Problem::new(message.to_string())
    }

    fn invalid_type(found: Unexpected, expected: &dyn de::Expected) -> Problem {
        Problem::unexpected("type", found, expected)
    }

    fn invalid_value(found: Unexpected, expected: &dyn de::Expected) -> Problem {
        Problem::unexpected("value", found, expected)
    }
}

struct FromJs(JsValue);

impl FromJs {
    /// The error of a value of a wrong type.
    fn refuse(&self, expected: &dyn de::Expected) -> Problem {
        let text;
        let found = match (self.0.as_f64(), self.0.as_string(), self.0.as_bool()) {
            (Some(number), ..) if !is_whole(number) => Unexpected::Float(number),
            (Some(number), ..) => Unexpected::Signed(number as i64),
            (_, Some(string), _) => {
                text = string;
                Unexpected::Str(&text)
            }
            (_, _, Some(flag)) => Unexpected::Bool(flag),
            _ if self.0.is_null() || self.0.is_undefined() => Unexpected::Unit,
            _ if Array::is_array(&self.0) => Unexpected::Seq,
            _ => Unexpected::Map,
        };
        de::Error::invalid_type(found, expected)
    }
}

fn is_whole(number: f64) -> bool {
    number.fract() == 0.0 && number.abs() <= MAX_EXACT
}

/// Methods of a trait that expect a number.
macro_rules! expect_numbers {
    ($($method:ident),*) => {
        $(fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Problem> {
            match self.0.as_f64() {
                Some(number) if !is_whole(number) => visitor.visit_f64(number),
                Some(number) if number >= 0.0 => visitor.visit_u64(number as u64),
                Some(number) => visitor.visit_i64(number as i64),
                None => Err(self.refuse(&visitor)),
            }
        })*
    };
}

/// One method for each kind of value, so that no reader is compiled for kinds that it would refuse.
impl<'de> Deserializer<'de> for FromJs {
    type Error = Problem;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Problem> {
        // a number, a text or a list of numbers is all that the job's readers leave open
        match self.0.as_string() {
            Some(text) => visitor.visit_string(text),
            None if self.0.as_f64().is_some() => self.deserialize_f64(visitor),
            None => self.deserialize_seq(visitor),
        }
    }

    expect_numbers! {
        deserialize_i32, deserialize_i64, deserialize_u8, deserialize_u32, deserialize_u64, deserialize_f64
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Problem> {
        match self.0.as_bool() {
            Some(flag) => visitor.visit_bool(flag),
            None => Err(self.refuse(&visitor)),
        }
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Problem> {
        match self.0.as_string() {
            Some(text) => visitor.visit_string(text),
            None => Err(self.refuse(&visitor)),
        }
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Problem> {
        match self.0.dyn_ref::<Array>() {
            Some(items) => visitor.visit_seq(Items { items: items.clone(), next: 0 }),
            None => Err(self.refuse(&visitor)),
        }
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Problem> {
        if !self.0.is_object() || Array::is_array(&self.0) {
            return Err(self.refuse(&visitor));
        }
        visitor.visit_map(Entries::new(self.0))
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Problem> {
        if self.0.is_null() || self.0.is_undefined() { visitor.visit_none() } else { visitor.visit_some(self) }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Problem> {
        if let Some(text) = self.0.as_string() {
            return visitor.visit_enum(text.into_deserializer());
        }
        if !self.0.is_object() || Array::is_array(&self.0) {
            return Err(self.refuse(&visitor));
        }
        let entries = Entries::new(self.0);
        match entries.entries.length() {
            1 => visitor.visit_enum(de::value::MapAccessDeserializer::new(entries)),
            _ => Err(de::Error::invalid_value(Unexpected::Map, &"an object with a single key")),
        }
    }

    forward_to_deserialize_any! {
        i8 i16 i128 u16 u128 f32 char str bytes byte_buf unit unit_struct newtype_struct tuple tuple_struct map identifier
        ignored_any
    }
}

struct Items {
    items: Array,
    next: u32,
}

impl<'de> de::SeqAccess<'de> for Items {
    type Error = Problem;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, Problem> {
        let index = self.next;
        if index == self.items.length() {
            return Ok(None);
        }
        self.next += 1;
        let item = seed.deserialize(FromJs(self.items.get(index)));
        item.map(Some).map_err(|problem| problem.within(&format!("[{index}]")))
    }
}

struct Entries {
    /// Pairs of key and value.
    entries: Array,
    next: u32,
    key: String,
}

impl Entries {
    fn new(object: JsValue) -> Entries {
        Entries { entries: Object::entries(object.unchecked_ref()), next: 0, key: String::new() }
    }

    fn entry(&self, index: u32, part: u32) -> JsValue {
        self.entries.get(index).unchecked_into::<Array>().get(part)
    }
}

impl<'de> de::MapAccess<'de> for Entries {
    type Error = Problem;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Problem> {
        if self.next == self.entries.length() {
            return Ok(None);
        }
        self.key = self.entry(self.next, 0).as_string().unwrap_or_default();
        self.next += 1;
        let key: StringDeserializer<Problem> = self.key.clone().into_deserializer();
        seed.deserialize(key).map(Some).map_err(|problem| problem.within(&self.key))
    }

    fn next_value_seed<V: DeserializeSeed<'de>>(&mut self, seed: V) -> Result<V::Value, Problem> {
        let value = self.entry(self.next - 1, 1);
        seed.deserialize(FromJs(value)).map_err(|problem| problem.within(&self.key))
    }
}
