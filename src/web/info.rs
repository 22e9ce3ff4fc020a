//! Facts of errors, engines, surfaces and meshes as JSON.

use serde::Serialize;

use crate::error::Result;
use crate::geometry::{Geometry, SharedFacets};
use crate::pipeline::Engine;
use crate::read::Solid;
use crate::sources::Source;
use crate::surface::surface;

/// Writes plain data as JSON.
pub(super) fn json(value: &impl Serialize) -> String {
    // structs of numbers, strings and lists always have a JSON form
    serde_json::to_string(value).unwrap_or_default()
}

/// What `www/error.js` makes an error of.
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
struct SurfaceInfo<'a> {
    file: &'a str,
    format: &'a str,
    bytes: u64,
    sha256: Option<&'a str>,
    solids: Vec<&'a str>,
    closed_solids: usize,
    facets: u64,
    bounding_box: Option<[[f64; 3]; 2]>,
    volume: f64,
    area: f64,
    closed_oriented: bool,
    closed_parity: bool,
    open_edges: u64,
    nonmanifold_edges: u64,
    flipped_edges: u64,
    shells: u64,
    warnings: &'a [String],
}

/// `SurfaceInfo` of `www/hexcast.d.ts`.
pub(super) fn surface_info(source: &Source) -> Result<String> {
    let contents = &source.contents;
    let facets = SharedFacets::join(&contents.solids.iter().map(|solid| solid.facets.clone()).collect::<Vec<_>>());
    let checked = surface(&facets);
    let is_closed = |solid: &&Solid| surface(&solid.facets).closed_parity;
    let closed_solids = match contents.solids.len() {
        1 => usize::from(checked.closed_parity),
        _ => contents.solids.iter().filter(is_closed).count(),
    };
    let geometry = Geometry::new("", 1, facets)?;
    Ok(json(&SurfaceInfo {
        file: &source.file,
        format: contents.format.name(),
        bytes: contents.n_bytes,
        sha256: source.sha256.as_deref(),
        solids: contents.solids.iter().map(|solid| solid.name.as_str()).collect(),
        closed_solids,
        facets: contents.n_facets,
        bounding_box: geometry.bounding_box(),
        volume: geometry.signed_volume(),
        area: checked.area,
        closed_oriented: checked.closed_oriented,
        closed_parity: checked.closed_parity,
        open_edges: checked.open_edges,
        nonmanifold_edges: checked.nonmanifold_edges,
        flipped_edges: checked.flipped_edges,
        shells: checked.shells,
        warnings: &contents.warnings,
    }))
}
