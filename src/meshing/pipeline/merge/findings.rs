//! The findings of a merged report: those that all parts make, and those with counts, made anew.

use std::collections::BTreeMap;

use serde_json::Value;

use super::part::{Part, rank};
use crate::meshing::pipeline::warnings::{about_odd_rays, about_shells};
use crate::meshing::report::{
    CertificateReport, FillReport, FlagReport, GeometryReport, OpenReport, ShellsReport, thick_flags,
};
use hexcast_core::base::finding::{Finding, Merging, in_order_of_codes, merging};
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::rays::Rays;

/// What was added up and leads to findings.
pub(super) struct Counted<'a> {
    pub(super) open: &'a [OpenReport],
    pub(super) geometries: &'a [GeometryReport],
    pub(super) flags: &'a [FlagReport],
    pub(super) shells: &'a [ShellsReport],
    pub(super) certificate: &'a Option<CertificateReport>,
    pub(super) lines: &'a Lines,
    pub(super) cells: [[u32; 3]; 2],
    pub(super) report: &'a Value,
}

/// The cells in two or more shells of each geometry, in the order of their ranks.
pub(super) fn merged_shells(parts: &[Part]) -> Vec<ShellsReport> {
    let mut cells = BTreeMap::new();
    for part in parts {
        for of in &part.window.shells {
            *cells.entry(rank(of.geometry, &part.geometries)).or_insert(0) += of.cells;
        }
    }
    cells.into_iter().map(|((_, geometry), cells)| ShellsReport::new(geometry, cells)).collect()
}

/// What to say of the geometries that no part has a cell of.
fn without_cells(parts: &[Part]) -> Vec<Finding> {
    let lists: Option<Vec<_>> = parts.iter().map(|part| part.window.without_cells.as_ref()).collect();
    let Some(lists) = lists else { return Vec::new() };
    let of_all = |geometry: &usize| lists.iter().all(|list| list.iter().any(|of| of.geometry == *geometry));
    let finding = |geometry: usize| {
        let mut of_geometry = lists.iter().flat_map(|list| list.iter()).filter(|of| of.geometry == geometry);
        of_geometry.find_map(|of| of.finding.clone())
    };
    lists[0].iter().map(|of| of.geometry).filter(of_all).filter_map(finding).collect()
}

/// Findings about rays, shells and what the certificate lists.
fn anew(of: &Counted, rays: &Rays) -> Vec<Finding> {
    let of_open = |open: &OpenReport| Some(open.finding(of.geometries.get(open.index)?, of.lines));
    let number = |key: &str| of.report[key].as_u64().unwrap_or(0);
    let of_rays = of.open.iter().filter_map(of_open).chain(about_odd_rays(number("odd_rays"), number("rays")));
    let shells = about_shells(of.shells, of.geometries, rays, of.cells);
    let of_shells =
        of.geometries.iter().enumerate().flat_map(|(index, geometry)| geometry.shell_findings(index, of.lines));
    let filled: Vec<FillReport> = serde_json::from_value(of.report["filled"].clone()).unwrap_or_default();
    let thick = thick_flags(of.flags, &filled, of.geometries);
    let found = of.certificate.iter().flat_map(|certificate| certificate.findings(of.lines));
    of_rays.chain(shells).chain(of_shells).chain(thick).chain(found).collect()
}

/// The findings of all parts, each once; those with counts are made anew, and those about geometries without cells.
pub(super) fn findings(parts: &[Part], whole: &Counted, rays: &Rays) -> Vec<Finding> {
    let mut all = anew(whole, rays);
    // a part knows the job as it was given
    for finding in &mut all {
        let mut of_parts = parts.iter().flat_map(|part| &part.findings).filter(|of| of.is_about_same(finding));
        finding.remedies = of_parts.find(|of| !of.remedies.is_empty()).map_or(Vec::new(), |of| of.remedies.clone());
    }
    for finding in parts.iter().flat_map(|part| &part.findings).filter(|of| merging(of.code) == Merging::Same) {
        if !all.iter().any(|known| known.is_same(finding)) {
            all.push(finding.clone());
        }
    }
    let without_cells = without_cells(parts);
    all.retain(|of| of.code != "shell-lost" || without_cells.iter().all(|known| known.geometry != of.geometry));
    all.extend(without_cells);
    in_order_of_codes(all)
}
