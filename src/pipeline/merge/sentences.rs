//! The sentences of a merged report: those that are the same in all parts, and those with counts, made anew.

use std::collections::BTreeMap;

use serde_json::Value;

use super::part::{Part, rank};
use crate::lines::Lines;
use crate::pipeline::warnings::{about_odd_rays, about_shells};
use crate::rays::Rays;
use crate::report::{CertificateReport, GeometryReport, OpenReport, ShellsReport};

/// What a report says in sentences that have counts.
pub(super) struct Counted<'a> {
    pub(super) open: &'a [OpenReport],
    pub(super) geometries: &'a [GeometryReport],
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
fn without_cells(parts: &[Part]) -> Vec<String> {
    let lists: Option<Vec<_>> = parts.iter().map(|part| part.window.without_cells.as_ref()).collect();
    let Some(lists) = lists else { return Vec::new() };
    let of_all = |geometry: &usize| lists.iter().all(|list| list.iter().any(|of| of.geometry == *geometry));
    let warning = |geometry: usize| {
        let mut of_geometry = lists.iter().flat_map(|list| list.iter()).filter(|of| of.geometry == geometry);
        of_geometry.find_map(|of| of.warning.clone())
    };
    lists[0].iter().map(|of| of.geometry).filter(of_all).filter_map(warning).collect()
}

/// The sentences with counts: those about rays, and those about shells and what the certificate found.
fn counted(of: &Counted, rays: &Rays) -> [Vec<String>; 2] {
    let sentence = |open: &OpenReport| {
        let geometry = of.geometries.iter().find(|geometry| geometry.name == open.geometry)?;
        Some(open.warning(geometry, of.lines))
    };
    let number = |key: &str| of.report[key].as_u64().unwrap_or(0);
    let of_rays = of.open.iter().filter_map(sentence).chain(about_odd_rays(number("odd_rays"), number("rays")));
    let shells = about_shells(of.shells, of.geometries, rays, of.cells);
    let found = of.certificate.iter().flat_map(|certificate| certificate.warnings(of.lines));
    [of_rays.collect(), shells.into_iter().chain(found).collect()]
}

/// The sentences of all parts, each once; those with counts are made anew, and those about geometries without cells.
pub(super) fn warnings(parts: &[Part], whole: &Counted, rays: &Rays) -> Vec<String> {
    let [mut before, mut between] = [Vec::new(), Vec::new()];
    for part in parts {
        let lines = whole.lines.window(part.cells());
        let own = Counted {
            open: &part.open,
            geometries: &part.geometries,
            shells: &part.window.shells,
            certificate: &part.certificate,
            lines: &lines,
            cells: part.cells(),
            report: part.report,
        };
        let own = counted(&own, rays).concat();
        for warning in part.report["warnings"].as_array().into_iter().flatten().filter_map(Value::as_str) {
            let is_known = own.iter().chain(&before).chain(&between).any(|known| known == warning);
            if !is_known {
                // what is said of geometries comes after what is said of all rays
                let list = if warning.starts_with("geometr") { &mut between } else { &mut before };
                list.push(warning.to_string());
            }
        }
    }
    let [of_rays, found] = counted(whole, rays);
    [before, of_rays, between, found, without_cells(parts)].concat()
}
