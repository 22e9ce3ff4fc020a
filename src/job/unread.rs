//! Keys whose work is done natively only. In wasm they are refused whatever they are, so they are not read: that would take more code
//! than what they are.

use serde::de::{Deserialize, Deserializer, IgnoredAny};

use super::{FractionsJob, GradedJob, LinesJob, LinksJob, PerAxis};

macro_rules! unread {
    ($($key:ident => $value:expr),*) => {
        $(impl<'de> Deserialize<'de> for $key {
            fn deserialize<D: Deserializer<'de>>(from: D) -> Result<$key, D::Error> {
                IgnoredAny::deserialize(from).map(|_| $value)
            }
        })*
    };
}

unread! {
    LinesJob => LinesJob::default(),
    GradedJob => GradedJob { max_size: PerAxis::All(1.0), min_size: None, growth: None, absorbing: None },
    LinksJob => LinksJob::default(),
    FractionsJob => FractionsJob::default()
}
