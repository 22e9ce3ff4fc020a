//! Makes values of types that may get more fields, where these are not of the same crate.

/// A value with other fields than another: what `Type { key: value, ..other }` is where the type may get more fields.
#[doc(hidden)]
#[macro_export]
macro_rules! set {
    ($type:ident { $($key:ident $(: $value:expr)?,)+ ..$other:expr }) => {{
        let mut made: $type = $other;
        $($crate::set!(@ made $key $(: $value)?);)+
        made
    }};
    (@ $made:ident $key:ident: $value:expr) => {
        $made.$key = $value
    };
    (@ $made:ident $key:ident) => {
        $made.$key = $key
    };
}
