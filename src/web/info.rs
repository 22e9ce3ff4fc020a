//! Facts of surfaces and estimates as JSON.

use serde_json::json;

use crate::geometry::{Facet, Geometry};
use crate::mesh::Mesh;
use crate::sources::Source;
use crate::surface::surface;

/// `SurfaceInfo` of `www/hexcast.d.ts`.
pub(super) fn surface_info(source: &Source) -> String {
    let contents = &source.contents;
    let facets: Vec<Facet> = contents.solids.iter().flat_map(|solid| &solid.facets).copied().collect();
    let checked = surface(&facets);
    let geometry = Geometry::new("", 1, facets);
    json!({
        "file": source.file,
        "format": contents.format.name(),
        "bytes": contents.n_bytes,
        "sha256": source.sha256,
        "solids": contents.solids.iter().map(|solid| &solid.name).collect::<Vec<_>>(),
        "facets": contents.n_facets,
        "bounding_box": geometry.bounding_box(),
        "volume": geometry.signed_volume(),
        "area": checked.area,
        "closed_oriented": checked.closed_oriented,
        "closed_parity": checked.closed_parity,
        "open_edges": checked.open_edges,
        "nonmanifold_edges": checked.nonmanifold_edges,
        "flipped_edges": checked.flipped_edges,
        "shells": checked.shells,
        "warnings": contents.warnings,
    })
    .to_string()
}

/// The report of a mesh that was read back: what the column file tells, null for what only a meshing knows.
pub(super) fn report_of_columns(mesh: &Mesh) -> String {
    let cells = mesh.columns.cells_per_flag();
    let flags: Vec<_> = (1..=255u8)
        .filter(|&flag| cells[usize::from(flag)] > 0 || mesh.names.iter().any(|named| named.flag == flag))
        .map(|flag| {
            let name = mesh.names.iter().find(|named| named.flag == flag).map_or("", |named| named.name.as_str());
            let n = cells[usize::from(flag)];
            json!({ "flag": flag, "name": name, "cells": n, "volume": n as f64 * mesh.lines.cell_volume(), "mesh_volume": null })
        })
        .collect();
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "backend": null,
        "adapter": null,
        "driver": null,
        "unit": mesh.unit,
        "dims": mesh.lines.dims,
        "origin": mesh.lines.origin,
        "spacing": mesh.lines.spacing,
        "rule": null,
        "ray_axis": (["x", "y", "z"][mesh.columns.rays.axis]),
        "rays": mesh.columns.rays.n_rays(),
        "crossings": mesh.columns.n_crossings(),
        "runs": mesh.columns.n_runs(),
        "odd_rays": mesh.columns.odd_rays(),
        "cells": mesh.lines.n_cells(),
        "flags": flags,
        "flags_sha256": null,
        "warnings": [],
        "cells_per_second": null,
        "seconds": {},
    })
    .to_string()
}
