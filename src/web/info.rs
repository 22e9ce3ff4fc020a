//! Facts of errors, engines, surfaces and meshes as JSON.

use serde::Serialize;

use crate::meshing::pipeline::Engine;
use hexcast_core::input::geometry::Geometry;
use hexcast_core::input::sources::Source;
use hexcast_core::input::surface::Surface;

/// Writes plain data as JSON.
pub(super) fn json(value: &impl Serialize) -> String {
    // structs of numbers, strings and lists always have a JSON form
    serde_json::to_string(value).unwrap_or_default()
}

/// What `www/protocol/error.js` makes an error of.
#[derive(Serialize)]
pub(super) struct ErrorFacts<'a> {
    pub(super) code: &'a str,
    pub(super) message: &'a str,
    pub(super) hint: &'a str,
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
    sha256: Option<&'a str>,
    solids: Vec<&'a str>,
    facets: u64,
    bounding_box: Option<[[f64; 3]; 2]>,
    volume: f64,
    warnings: &'a [String],
}

/// `FileInfo` of `www/job.d.ts`; the geometry has the facets of all solids.
pub(super) fn file_info(source: &Source, geometry: &Geometry) -> String {
    let contents = &source.contents;
    json(&FileInfo {
        file: &source.file,
        format: contents.format.name(),
        unit: contents.unit,
        bytes: contents.n_bytes,
        sha256: source.sha256.as_deref(),
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

/// What `SurfaceInfo` of `www/job.d.ts` adds: the first of the surfaces is all solids together, the others are each of them if there are
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
