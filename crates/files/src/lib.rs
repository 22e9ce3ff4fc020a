//! What hexcast writes. Callers use the crate `hexcast`, which passes on what they may rely on; the rest changes without notice.

#[cfg(any(feature = "pictures", feature = "export"))]
pub mod colours;
#[cfg(feature = "export")]
pub mod export;
#[cfg(feature = "pictures")]
pub mod picture;
pub mod shards;
pub mod write;
