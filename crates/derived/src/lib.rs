//! What is found in the cells of hexcast: meshes, and what solvers and people ask of them. Callers use the crate `hexcast`, which passes on what
//! they may rely on; the rest changes without notice.

// what is public names stages that errors come from
#![allow(rustdoc::private_intra_doc_links)]

#[doc(hidden)]
pub mod certificate;
pub mod cut;
#[doc(hidden)]
pub mod cut_cells;
pub mod difference;
pub mod distance;
pub mod fractions;
pub mod gaps;
pub mod leak;
pub mod links;
pub mod mesh;
pub mod skin;
pub mod staggered;
/// What tests of several crates use.
#[cfg(any(test, feature = "testing"))]
#[doc(hidden)]
pub mod testing;
pub mod walls;
