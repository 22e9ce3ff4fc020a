//! The tests that run in a real browser, in a dedicated worker as on the page: the same case table, checks of
//! kernels and golden files as the native ones, from the same source.
#![cfg(target_arch = "wasm32")]

wasm_bindgen_test::wasm_bindgen_test_configure!(run_in_dedicated_worker);

#[macro_use]
extern crate hexcast_core;

#[path = "../native/angles.rs"]
mod angles;
#[allow(dead_code)] // the native tests use the rest
#[path = "../native/cases.rs"]
mod cases;
#[path = "../native/golden.rs"]
mod golden;
#[path = "../native/kernel_checks.rs"]
mod kernel_checks;
mod kernels;
mod line;
#[allow(dead_code)] // the native tests use the rest
#[path = "../native/models.rs"]
mod models;
#[allow(dead_code)] // the native tests use the rest
#[path = "../native/soups.rs"]
mod soups;
