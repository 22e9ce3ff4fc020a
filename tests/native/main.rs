//! The native integration tests: one binary.
//!
//! `cases` is the table that everything runs, made by `models` and `soups`; `backends` meshes it; `oracle` knows the truth.
//!
//! Tests that need a GPU have "gpu" in their path, and fail where there is none. On a machine without one
//! `cargo test --test native -- --skip gpu` leaves them out, and says how many.

#[macro_use(set)]
extern crate hexcast_core;

mod agreement;
mod angles;
mod backends;
mod bad_edges;
mod boards;
mod cases;
mod certificates;
#[cfg(feature = "cli")]
mod cli;
#[cfg(feature = "cli")]
mod column_files;
#[cfg(feature = "cli")]
mod command_inputs;
mod command_outputs;
mod compare;
#[cfg(feature = "cli")]
mod conformal;
mod converge;
mod cuboids;
mod cut_faces;
mod distance;
#[cfg(feature = "cli")]
mod examples;
mod facets_in_file;
mod famous_cases;
#[cfg(feature = "cli")]
mod findings;
mod formats;
mod fraction_sweep;
mod fractions;
mod fuzz;
mod gaps;
mod golden;
mod golden_cpu;
mod graded;
#[cfg(feature = "cli")]
mod graded_command;
#[cfg(feature = "cli")]
mod graded_laws;
mod graded_sizes;
#[cfg(feature = "cli")]
mod halos;
mod hole_oracle;
#[cfg(feature = "gpu")]
mod gpu {
    mod broken_drivers;
    mod device_memory;
    mod flags_buffer;
    mod graded;
    mod kernels;
    mod lost_device;
    mod merged_parts;
    mod open_surfaces;
    mod own_device;
    mod windows;
}
#[cfg(feature = "cli")]
mod job_files;
#[cfg(feature = "gpu")]
mod kernel_checks;
mod layering;
mod leak;
#[cfg(feature = "cli")]
mod leak_command;
mod links;
mod lost_shells;
mod many_geometries;
#[cfg(feature = "cli")]
mod measured_command;
mod measured_windows;
#[cfg(feature = "cli")]
mod memory;
#[cfg(all(feature = "cli", target_os = "linux"))]
mod memory_limits;
#[cfg(feature = "cli")]
mod merged_reports;
#[cfg(feature = "cli")]
mod merged_sweep;
mod mesher;
mod missing_facets;
mod models;
mod open_surfaces;
mod oracle;
#[cfg(feature = "cli")]
mod parallel_store;
#[cfg(feature = "cli")]
mod parts;
#[cfg(feature = "cli")]
mod paths;
mod periodic_links;
#[cfg(feature = "cli")]
mod pictures;
mod plates;
mod points;
mod properties;
mod public_api;
mod refine;
#[cfg(feature = "cli")]
mod reports;
mod scene;
mod seven_cases;
#[cfg(feature = "gpu")]
mod shaders;
mod sheets;
mod soups;
mod staggered;
#[cfg(feature = "cli")]
mod strangers;
#[cfg(feature = "cli")]
mod tensors;
#[cfg(feature = "cli")]
mod tolerances;
#[cfg(feature = "cli")]
mod verify;
mod volumes;
mod walls;
#[cfg(feature = "cli")]
mod warnings;
#[cfg(feature = "gpu")]
mod widths;
