//! The GPU backend: every stage as a WGSL kernel, in bands of ray rows.
//!
//! # Theory
//! The stages and their values are those of the CPU definition; nothing but their types is shared. A band of ray rows goes
//! through: `lattice_rows` -> scan -> `lattice_count` -> scan -> `lattice_fill` -> `intersect_setup` -> `intersect_count` -> scan
//! -> `intersect_emit` -> `map` -> scan -> `compact`. Atomics only count and hand out places; the order they give is sorted
//! away in `map`, so the columns are the same bytes on every device and for every band.
//!
//! # Practice
//! [`Gpu`] holds a device and its compiled kernels and is expensive (a tenth of a second to seconds): make one, use it for
//! many meshes. [`Gpu::columns`] runs a mesh. Its buffers live as long as the call. All calls are async because a browser
//! cannot block; natively they complete on the calling thread under any executor.

mod buffers;
mod device;
mod gather;
mod kernels;
mod layout;
mod line;
mod passes;
mod session;
mod spares;
mod stages;
#[cfg(not(target_arch = "wasm32"))]
mod warm_up;

pub use device::{AdapterFacts, AdapterKind, Gpu, adapter, adapters};
pub use kernels::{Kernel, sources};
pub use layout::Params;
pub use line::{Cast, Options, Usage};
pub use passes::Profile;
