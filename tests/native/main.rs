//! The native integration tests: one binary.
//!
//! `cases` is the table that everything runs, made by `models` and `soups`; `backends` meshes it; `oracle` knows the truth.

mod agreement;
mod angles;
mod backends;
#[cfg(feature = "gpu")]
mod broken_drivers;
mod cases;
#[cfg(feature = "cli")]
mod cli;
#[cfg(feature = "cli")]
mod column_files;
mod compare;
mod famous_cases;
mod formats;
mod golden;
mod golden_cpu;
#[cfg(feature = "gpu")]
mod kernel_checks;
#[cfg(feature = "gpu")]
mod kernels;
mod layering;
#[cfg(feature = "gpu")]
mod lost_device;
#[cfg(feature = "cli")]
mod memory;
mod models;
#[cfg(feature = "gpu")]
mod open_surfaces;
mod oracle;
mod properties;
mod seven_cases;
#[cfg(feature = "gpu")]
mod shaders;
mod soups;
