//! Makes values of types that may get more fields.

/// A value with other fields than another: what `Type { key: value, ..other }` is where the type may get more fields.
macro_rules! set {
    ($type:ident { $($key:ident $(: $value:expr)?,)+ ..$other:expr }) => {{
        let mut made: $type = $other;
        $(set!(@ made $key $(: $value)?);)+
        made
    }};
    (@ $made:ident $key:ident: $value:expr) => {
        $made.$key = $value
    };
    (@ $made:ident $key:ident) => {
        $made.$key = $key
    };
}
