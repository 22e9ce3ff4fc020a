//! Plain data as JSON, through serde: the browser's own `JSON` writes texts and numbers, so that the page does not load another.

use std::convert::Infallible;
use std::fmt;

use js_sys::JSON;
use serde::ser::{self, Serialize, Serializer};
use wasm_bindgen::prelude::*;

/// Writes plain data as JSON.
pub(super) fn json(value: &impl Serialize) -> String {
    let mut text = String::new();
    let Ok(()) = value.serialize(Writer(&mut text));
    text
}

/// What cannot happen: all that serde knows has a JSON form.
#[derive(Debug)]
pub(super) struct Never(Infallible);

impl fmt::Display for Never {
    fn fmt(&self, _: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {}
    }
}

impl std::error::Error for Never {}

impl ser::Error for Never {
    fn custom<T: fmt::Display>(message: T) -> Never {
        unreachable!("plain data without a JSON form: {message}")
    }
}

type Written = Result<(), Never>;

struct Writer<'a>(&'a mut String);

/// Appends a text or a number; numbers that JSON does not know become null.
fn put(out: &mut String, value: &JsValue) {
    // texts and numbers always have a JSON form
    out.push_str(&JSON::stringify(value).map(String::from).unwrap_or_default());
}

/// Methods of a trait that write a number as JavaScript does.
macro_rules! numbers {
    ($($method:ident: $type:ty),*) => {
        $(fn $method(self, value: $type) -> Written {
            put(self.0, &JsValue::from_f64(value as f64));
            Ok(())
        })*
    };
}

impl<'a> Serializer for Writer<'a> {
    type Ok = ();
    type Error = Never;
    type SerializeSeq = Parts<'a>;
    type SerializeTuple = Parts<'a>;
    type SerializeTupleStruct = Parts<'a>;
    type SerializeTupleVariant = Parts<'a>;
    type SerializeMap = Parts<'a>;
    type SerializeStruct = Parts<'a>;
    type SerializeStructVariant = Parts<'a>;

    numbers! {
        serialize_i8: i8, serialize_i16: i16, serialize_i32: i32, serialize_i64: i64, serialize_u8: u8, serialize_u16: u16,
        serialize_u32: u32, serialize_u64: u64, serialize_f32: f32, serialize_f64: f64
    }

    fn serialize_bool(self, value: bool) -> Written {
        self.0.push_str(if value { "true" } else { "false" });
        Ok(())
    }

    fn serialize_char(self, value: char) -> Written {
        self.serialize_str(value.encode_utf8(&mut [0; 4]))
    }

    fn serialize_str(self, value: &str) -> Written {
        put(self.0, &JsValue::from_str(value));
        Ok(())
    }

    fn serialize_bytes(self, value: &[u8]) -> Written {
        self.collect_seq(value)
    }

    fn serialize_none(self) -> Written {
        self.serialize_unit()
    }

    fn serialize_some<T: Serialize + ?Sized>(self, value: &T) -> Written {
        value.serialize(self)
    }

    fn serialize_unit(self) -> Written {
        self.0.push_str("null");
        Ok(())
    }

    fn serialize_unit_struct(self, _: &'static str) -> Written {
        self.serialize_unit()
    }

    fn serialize_unit_variant(self, _: &'static str, _: u32, variant: &'static str) -> Written {
        self.serialize_str(variant)
    }

    fn serialize_newtype_struct<T: Serialize + ?Sized>(self, _: &'static str, value: &T) -> Written {
        value.serialize(self)
    }

    fn serialize_newtype_variant<T>(self, _: &'static str, _: u32, variant: &'static str, value: &T) -> Written
    where
        T: Serialize + ?Sized,
    {
        let out = self.variant(variant).0;
        value.serialize(Writer(out))?;
        out.push('}');
        Ok(())
    }

    fn serialize_seq(self, _: Option<usize>) -> Result<Parts<'a>, Never> {
        Ok(self.begin("[", "]"))
    }

    fn serialize_tuple(self, _: usize) -> Result<Parts<'a>, Never> {
        Ok(self.begin("[", "]"))
    }

    fn serialize_tuple_struct(self, _: &'static str, _: usize) -> Result<Parts<'a>, Never> {
        Ok(self.begin("[", "]"))
    }

    fn serialize_tuple_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        _: usize,
    ) -> Result<Parts<'a>, Never> {
        Ok(self.variant(variant).begin("[", "]}"))
    }

    fn serialize_map(self, _: Option<usize>) -> Result<Parts<'a>, Never> {
        Ok(self.begin("{", "}"))
    }

    fn serialize_struct(self, _: &'static str, _: usize) -> Result<Parts<'a>, Never> {
        Ok(self.begin("{", "}"))
    }

    fn serialize_struct_variant(
        self,
        _: &'static str,
        _: u32,
        variant: &'static str,
        _: usize,
    ) -> Result<Parts<'a>, Never> {
        Ok(self.variant(variant).begin("{", "}}"))
    }
}

impl<'a> Writer<'a> {
    fn begin(self, open: &str, close: &'static str) -> Parts<'a> {
        self.0.push_str(open);
        Parts { out: self.0, is_first: true, close }
    }

    /// Begins an object whose only key is a variant.
    fn variant(self, variant: &str) -> Writer<'a> {
        self.0.push('{');
        put_key(self.0, variant);
        self
    }
}

/// Appends a key, which is an identifier of ours.
fn put_key(out: &mut String, key: &str) {
    ["\"", key, "\":"].iter().for_each(|part| out.push_str(part));
}

/// A list or an object in the making.
struct Parts<'a> {
    out: &'a mut String,
    is_first: bool,
    close: &'static str,
}

impl Parts<'_> {
    fn next(&mut self) -> Writer<'_> {
        if !std::mem::take(&mut self.is_first) {
            self.out.push(',');
        }
        Writer(self.out)
    }

    fn close(self) -> Written {
        self.out.push_str(self.close);
        Ok(())
    }
}

/// Traits of lists, each with one method for an item.
macro_rules! lists {
    ($($list:ident: $method:ident),*) => {
        $(impl ser::$list for Parts<'_> {
            type Ok = ();
            type Error = Never;

            fn $method<T: Serialize + ?Sized>(&mut self, item: &T) -> Written {
                item.serialize(self.next())
            }

            fn end(self) -> Written {
                self.close()
            }
        })*
    };
}

lists! {
    SerializeSeq: serialize_element, SerializeTuple: serialize_element, SerializeTupleStruct: serialize_field,
    SerializeTupleVariant: serialize_field
}

/// Traits of objects with known keys.
macro_rules! objects {
    ($($object:ident),*) => {
        $(impl ser::$object for Parts<'_> {
            type Ok = ();
            type Error = Never;

            fn serialize_field<T: Serialize + ?Sized>(&mut self, key: &'static str, value: &T) -> Written {
                let writer = self.next();
                put_key(writer.0, key);
                value.serialize(writer)
            }

            fn end(self) -> Written {
                self.close()
            }
        })*
    };
}

objects! { SerializeStruct, SerializeStructVariant }

impl ser::SerializeMap for Parts<'_> {
    type Ok = ();
    type Error = Never;

    fn serialize_key<T: Serialize + ?Sized>(&mut self, key: &T) -> Written {
        key.serialize(self.next())
    }

    fn serialize_value<T: Serialize + ?Sized>(&mut self, value: &T) -> Written {
        self.out.push(':');
        value.serialize(Writer(self.out))
    }

    fn end(self) -> Written {
        self.close()
    }
}
