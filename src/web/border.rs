//! The border: facts as JSON and errors on their way to JavaScript, and values of JavaScript that Rust holds.

use std::cell::RefCell;

use serde::Serialize;
use wasm_bindgen::prelude::*;

use crate::meshing::pipeline::Engine;
use hexcast_core::base::error::Error;
use hexcast_core::input::geometry::Geometry;
use hexcast_core::input::sources::Source;
use hexcast_core::input::surface::Surface;

pub(super) type JsResult<T> = std::result::Result<T, JsValue>;

/// Writes plain data as JSON.
pub(super) fn json(value: &impl Serialize) -> String {
    // structs of numbers, strings and lists always have a JSON form
    serde_json::to_string(value).unwrap_or_default()
}

/// What `www/protocol/error.js` makes an error of.
#[derive(Serialize)]
struct ErrorFacts<'a> {
    code: &'a str,
    message: &'a str,
    hint: &'a str,
}

/// An error as `www/core/core.js` parses it.
pub(super) fn js_error(error: Error) -> JsValue {
    let message = error.to_string();
    JsValue::from_str(&json(&ErrorFacts { code: error.code(), message: &message, hint: error.hint() }))
}

thread_local! {
    /// JavaScript values in use, by number: a closure that holds a number can be sent between threads, one that holds such a
    /// value cannot.
    static KEPT: RefCell<Vec<JsValue>> = RefCell::default();
}

pub(super) fn keep(value: JsValue) -> usize {
    KEPT.with_borrow_mut(|all| {
        let id = all.iter().position(JsValue::is_undefined).unwrap_or(all.len());
        all.resize(all.len().max(id + 1), JsValue::UNDEFINED);
        all[id] = value;
        id
    })
}

pub(super) fn forget(id: usize) {
    KEPT.with_borrow_mut(|all| all[id] = JsValue::UNDEFINED);
}

pub(super) fn kept(id: usize) -> JsValue {
    KEPT.with_borrow(|all| all[id].clone())
}

#[derive(Serialize)]
struct EngineFacts<'a> {
    backend: &'a str,
    adapter: Option<AdapterInfo<'a>>,
    fallback: Option<&'a str>,
}

#[derive(Serialize)]
struct AdapterInfo<'a> {
    name: &'a str,
    driver: &'a str,
    software: bool,
}

/// The backend, and why it is not the GPU.
pub(super) fn engine_facts(engine: &Engine) -> String {
    let software = engine.is_software();
    let adapter = engine.adapter().map(|(name, driver)| AdapterInfo { name, driver, software });
    json(&EngineFacts { backend: engine.backend(), adapter, fallback: engine.fallback.as_deref() })
}

#[derive(Serialize)]
struct FileInfo<'a> {
    file: &'a str,
    format: &'a str,
    unit: Option<&'a str>,
    bytes: u64,
    blake3: Option<&'a str>,
    solids: Vec<&'a str>,
    facets: u64,
    bounding_box: Option<[[f64; 3]; 2]>,
    volume: f64,
    warnings: &'a [String],
}

/// `FileInfo` of `www/types/job.d.ts`; the geometry has the facets of all solids.
pub(super) fn file_info(source: &Source, geometry: &Geometry) -> String {
    let contents = &source.contents;
    json(&FileInfo {
        file: &source.file,
        format: contents.format.name(),
        unit: contents.unit,
        bytes: contents.n_bytes,
        blake3: source.blake3.as_deref(),
        solids: contents.solids.iter().map(|solid| solid.name.as_str()).collect(),
        facets: contents.n_facets,
        bounding_box: geometry.bounding_box(),
        volume: geometry.signed_volume(),
        warnings: &contents.warnings,
    })
}

#[derive(Serialize)]
struct EdgeInfo {
    closed_solids: usize,
    area: f64,
    closed_oriented: bool,
    closed_parity: bool,
    open_edges: u64,
    nonmanifold_edges: u64,
    flipped_edges: u64,
    shells: u64,
}

/// What `SurfaceInfo` of `www/types/job.d.ts` adds: the first of the surfaces is all solids together, the others are each of them if there are
/// several.
pub(super) fn edge_info(checked: &[Surface]) -> String {
    let Some((all, solids)) = checked.split_first() else { return String::new() };
    let solids = if solids.is_empty() { std::slice::from_ref(all) } else { solids };
    json(&EdgeInfo {
        closed_solids: solids.iter().filter(|solid| solid.closed_parity).count(),
        area: all.area,
        closed_oriented: all.closed_oriented,
        closed_parity: all.closed_parity,
        open_edges: all.open_edges,
        nonmanifold_edges: all.nonmanifold_edges,
        flipped_edges: all.flipped_edges,
        shells: all.shells,
    })
}
