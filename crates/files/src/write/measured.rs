//! What is measured beside cells, and the fractions of their flags, as arrays.

#[doc(hidden)]
pub mod conformal;
pub mod distance;
pub mod fractions;
#[doc(hidden)]
pub mod links;
pub(in crate::write) mod solid;
#[doc(hidden)]
pub mod staggered;
#[doc(hidden)]
pub mod tensors;
