//! Merges the reports of windows that together are a box into the report of the whole box, but for times and memory.
//!
//! Reports of windows, as JSON -> that of the whole. The windows are a grid that divides the box. Counts add up, as do the sums of
//! `flags_hash`. Where windows cut rays, each piece of a ray has the crossings of the whole ray, so only those of the first piece
//! count; a run counts where it begins. Facts of surfaces are the same in all reports; findings with counts are made anew.
//! Seconds add up, too; of memory the maximum counts.
//! Cost: little more than reading the reports.

use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Value, json};

use crate::meshing::report::{
    DoubtReport, FlagSum, MAX_BOXES, OpenReport, PointsReport, ShellCheck, StaggeredReport, WindowSums, flag_reports,
};
use hexcast_core::base::error::Result;
use hexcast_core::base::finding::sentences;
use hexcast_core::cells::columns::CellRun;
use hexcast_core::cells::fingerprint::hash_of_sums;
use hexcast_core::grid::lines::{Grading, Lines};
use hexcast_core::grid::rays::Rays;
use hexcast_core::grid::totals::{Ruler, Total};
use hexcast_core::open_surfaces::doubt::Doubt;
use hexcast_derived::fractions::parts_of_cell;
use hexcast_derived::staggered::COMPONENTS;

mod certificate;
mod findings;
mod part;

use certificate::merged_certificate;
use findings::{Counted, findings, merged_shells};
use part::{HINT, Part, lines_of_box, part, refused, total};

/// What must be equal in the reports of all windows.
const SAME: &[&str] =
    &["version", "unit", "spacing", "inputs", "end_points", "snap_in_cells", "rule", "ray_axis", "gaps"];

/// Merges the reports of all windows of a box, in any order.
///
/// # Errors
/// `job-value` where one is not the report of a window; `job-conflict` where they are not of one job, do not divide its box, have a halo and do not say what they have without it,
/// or are windows that cut rays and do not say which runs begin in them.
pub fn merge(reports: &[Value]) -> Result<Value> {
    let reports: Vec<Cow<Value>> = reports.iter().map(without_halo).collect();
    let parts: Vec<Part> = reports.iter().enumerate().map(|(index, of)| part(index, of)).collect::<Result<_>>()?;
    let first = parts.first().ok_or_else(|| refused("job-value", "no report is given", "give those of all parts"))?;
    check_same(&parts)?;
    let axis = ["x", "y", "z"].iter().position(|name| first.report["ray_axis"] == *name).unwrap_or(0);
    check_grid(&parts)?;
    let runs = runs(&parts, axis)?;
    let whole = lines_of_box(&parts)?;
    let mut merged = first.report.clone();
    merged["dims"] = json!(whole.dims());
    merged["origin"] = json!(whole.origin());
    merged["grading"] = json!(Grading::of(&whole, first.report["unit"].as_str()));
    merged["window"] = Value::Null;
    merged["flags_sha256"] = Value::Null;
    let job = merged["job"].as_object_mut().ok_or_else(|| refused("job-value", "a report has no job", HINT))?;
    ["part", "window"].iter().for_each(|key| drop(job.shift_remove(*key)));
    for key in ["cells", "rays_kept"] {
        merged[key] = json!(sum(&parts, |report| &report[key]));
    }
    for key in ["rays", "crossings", "odd_rays"] {
        let at_start = parts.iter().filter(|part| part.window.first[axis] == 0);
        merged[key] = json!(at_start.map(|part| part.report[key].as_u64().unwrap_or(0)).sum::<u64>());
    }
    merged["runs"] = json!(runs);
    let has_checks = parts.iter().any(|part| !part.report["device_check"].is_null());
    if has_checks {
        let of = |key: &str| sum(&parts, |report| &report["device_check"][key]);
        merged["device_check"] = json!({ "rays": of("rays"), "differing": of("differing") });
    }
    for index in 0..merged["filled"].as_array().map_or(0, Vec::len) {
        merged["filled"][index]["added_cells"] = json!(sum(&parts, |report| &report["filled"][index]["added_cells"]));
    }
    merge_measured(&mut merged, &parts, &whole)?;
    merged["staggered"] = json!(merged_staggered(&parts, whole.dims()));
    let mut geometries = first.geometries.clone();
    let bounds = first.window.volume_bounds.clone().unwrap_or_else(|| vec![None; geometries.len()]);
    geometries.iter_mut().zip(bounds).for_each(|(geometry, bound)| geometry.volume_bound = bound);
    for (index, geometry) in geometries.iter_mut().enumerate() {
        let checks: Option<Vec<&ShellCheck>> =
            parts.iter().map(|part| part.geometries.get(index)?.shells.as_ref()).collect();
        geometry.shells = checks.and_then(|checks| ShellCheck::merged(&checks));
    }
    let open = merged_open(&parts);
    let cells = cells_per_flag(&parts);
    let ruler = Ruler::new(&whole, &whole);
    let volumes = match whole.cell_volume() {
        Some(volume) => cells.map(|n| n as f64 * volume),
        None => totals_per_flag(&parts, |sums| &sums.volumes)?.map(|total| ruler.volume(total, 1)),
    };
    let flags = flag_reports(&geometries, &cells, &volumes, &whole);
    merged["flags"] = json!(flags);
    merged["flags_hash"] = json!(hash(&parts, whole.dims()));
    merged["doubtful"] = json!(merged_doubtful(&parts, whole.dims())?);
    let certificate = merged_certificate(&parts, &geometries, &whole)?;
    let shells = merged_shells(&parts);
    let rays = Rays::new(axis, whole.dims());
    let counted = Counted {
        open: &open,
        geometries: &geometries,
        flags: &flags,
        shells: &shells,
        certificate: &certificate,
        lines: &whole,
        cells: [[0; 3], whole.dims()],
        report: &merged,
    };
    let findings = findings(&parts, &counted, &rays);
    (merged["findings"], merged["warnings"]) = (json!(findings), json!(sentences(&findings)));
    (merged["geometries"], merged["open"], merged["certificate"]) =
        (json!(geometries), json!(open), json!(certificate));
    merge_costs(&mut merged, &parts);
    Ok(merged)
}

/// A report as it would be without its halo, where it says that: with what it measured in cells that are not of the halo, and its costs.
fn without_halo(report: &Value) -> Cow<'_, Value> {
    let bare = &report["window"]["without_halo"];
    if !bare["window"]["sums"].is_object() {
        return Cow::Borrowed(report);
    }
    let mut bare = bare.clone();
    ["links", "fractions", "seconds", "peak_bytes"].iter().for_each(|key| bare[key] = report[key].clone());
    for key in ["fractions", "areas"] {
        bare["window"]["sums"][key] = report["window"]["sums"][key].clone();
    }
    Cow::Owned(bare)
}

/// Refuses reports of different jobs.
fn check_same(parts: &[Part]) -> Result<()> {
    let of_job = |report: &Value| {
        let mut job = report["job"].clone();
        if let Some(job) = job.as_object_mut() {
            ["part", "window"].iter().for_each(|key| drop(job.shift_remove(*key)));
        }
        job
    };
    let first = &parts[0];
    for (index, part) in parts.iter().enumerate() {
        let differs = SAME.iter().find(|key| part.report[**key] != first.report[**key]).copied();
        let differs = differs.or((of_job(part.report) != of_job(first.report)).then_some("job"));
        let differs = differs.or((part.window.of != first.window.of).then_some("window.of"));
        let differs = differs.or((part.open.len() != first.open.len()).then_some("open"));
        if let Some(key) = differs {
            let message = format!("reports 1 and {} are not of parts of one mesh: they differ in {key}", index + 1);
            return Err(refused("job-conflict", message, "mesh all parts with the same files, job and version"));
        }
    }
    Ok(())
}

/// Refuses windows that are not a grid over the box.
fn check_grid(parts: &[Part]) -> Result<()> {
    let of = parts[0].window.of;
    let mut n_windows = 1;
    let mut covers = true;
    for axis in 0..3 {
        let ends: BTreeSet<[u32; 2]> =
            parts.iter().map(|part| [part.window.first[axis], part.window.end[axis]]).collect();
        let mut next = 0;
        covers &= ends.iter().all(|&[first, end]| std::mem::replace(&mut next, end) == first && first < end)
            && next == of[axis];
        n_windows *= ends.len();
    }
    let distinct: BTreeSet<[[u32; 3]; 2]> = parts.iter().map(|part| [part.window.first, part.window.end]).collect();
    if !covers || distinct.len() != n_windows || parts.len() != n_windows {
        let [nx, ny, nz] = of;
        let message =
            format!("the windows of {} reports do not divide the {nx} x {ny} x {nz} cells of the box", parts.len());
        return Err(refused(
            "job-conflict",
            message,
            "give the report of each part once; `hexcast parts` lists the parts",
        ));
    }
    Ok(())
}

/// The runs of the box, each counted where it begins; `axis` is that of the rays.
fn runs(parts: &[Part], axis: usize) -> Result<u64> {
    let begun: Option<u64> = parts.iter().map(|part| part.window.runs).sum();
    begun.ok_or_else(|| {
        let name = ["x", "y", "z"][axis];
        let message = format!("the windows cut rays along {name}, and the reports do not say which runs begin in each");
        refused(
            "job-conflict",
            message,
            "mesh them as parts (--part), or let rays run along an axis that no window cuts (--axis)",
        )
    })
}

fn sum<'a>(parts: &[Part<'a>], of: impl Fn(&'a Value) -> &'a Value) -> u64 {
    parts.iter().map(|part| of(part.report).as_u64().unwrap_or(0)).sum()
}

fn cells_per_flag(parts: &[Part]) -> [u64; 256] {
    let mut cells = [0; 256];
    parts.iter().flat_map(|part| &part.flags).for_each(|flag| cells[usize::from(flag.flag)] += flag.cells);
    cells
}

/// What the windows have of each flag, exactly.
fn totals_per_flag(parts: &[Part], of: impl Fn(&WindowSums) -> &Vec<FlagSum>) -> Result<[Total; 256]> {
    let mut totals = [Total::default(); 256];
    for FlagSum { flag, sum, .. } in parts.iter().flat_map(|part| of(&part.window.sums)) {
        totals[usize::from(*flag)].add(total(sum)?);
    }
    Ok(totals)
}

fn hash(parts: &[Part], dims: [u32; 3]) -> Option<String> {
    let sums: Option<Vec<&str>> = parts.iter().map(|part| part.window.flags_sum.as_deref()).collect();
    hash_of_sums(sums?.into_iter(), dims)
}

/// Rays along an axis are counted by the windows at its start: those behind them have the same.
fn merged_open(parts: &[Part]) -> Vec<OpenReport> {
    let mut open = parts[0].open.clone();
    for (index, merged) in open.iter_mut().enumerate() {
        merged.doubtful_cells = parts.iter().map(|part| part.open[index].doubtful_cells).sum();
        merged.odd_rays = [0, 1, 2].map(|axis| {
            let at_start = parts.iter().filter(|part| part.window.first[axis] == 0);
            at_start.map(|part| part.open[index].odd_rays[axis]).sum()
        });
    }
    open
}

/// The boxes of all doubtful cells, as the whole mesh has them; where some parts list only their largest, the largest of these.
fn merged_doubtful(parts: &[Part], dims: [u32; 3]) -> Result<DoubtReport> {
    let boxes = parts.iter().flat_map(|part| {
        let first = part.window.first;
        part.doubtful
            .boxes
            .iter()
            .map(move |corners| corners.map(|cell| [0, 1, 2].map(|axis| cell[axis] + first[axis])))
    });
    let n_cells: u64 = parts.iter().map(|part| part.doubtful.cells).sum();
    let rays = Rays::new(0, dims);
    let mut runs = Vec::new();
    for [low, high] in boxes {
        for z in low[2]..high[2] {
            let ray = |y: u32| u64::from(y) + u64::from(dims[1]) * u64::from(z);
            runs.extend((low[1]..high[1]).map(|y| CellRun { ray: ray(y), start: low[0], end: high[0] }));
        }
    }
    let mut doubt = Doubt::new(rays, MAX_BOXES, None);
    if !runs.is_empty() {
        doubt.add(vec![(0..dims[2], runs)])?;
    }
    let report = DoubtReport::new(&doubt.finish()?);
    Ok(DoubtReport { cells: n_cells, are_all: report.cells_in_boxes == n_cells, ..report })
}

/// Adds up the points of a staggered grid, each of which one window counts.
fn merged_staggered(parts: &[Part], dims: [u32; 3]) -> Option<StaggeredReport> {
    let all: Option<Vec<&StaggeredReport>> = parts.iter().map(|part| part.window.staggered.as_ref()).collect();
    let (all, mut merged) = (all?, parts[0].window.staggered.clone()?);
    merged.sheet_faces = all.iter().map(|of| of.sheet_faces).sum();
    for (component, (name, is_on_line)) in merged.components.iter_mut().zip(COMPONENTS) {
        let own = all.iter().flat_map(|of| &of.components).filter(|of| of.name == name);
        let mut points = BTreeMap::new();
        own.flat_map(|of| &of.flags).for_each(|of| *points.entry(of.flag).or_insert(0) += of.points);
        component.dims = [0, 1, 2].map(|axis| dims[axis] + u32::from(is_on_line[axis]));
        component.flags = points.into_iter().map(|(flag, points)| PointsReport { flag, points }).collect();
    }
    Some(merged)
}

/// Adds up what was measured at surfaces.
fn merge_measured(merged: &mut Value, parts: &[Part], whole: &Lines) -> Result<()> {
    if !merged["links"].is_null() {
        for key in ["links", "cells", "through_walls", "without_facet"] {
            merged["links"][key] = json!(sum(parts, |report| &report["links"][key]));
        }
    }
    if !merged["conformal"].is_null() {
        for key in ["cut_edges", "cut_faces", "enlarged_faces", "unbalanced_faces", "sampled_cells"] {
            merged["conformal"][key] = json!(sum(parts, |report| &report["conformal"][key]));
        }
        for key in ["dt_factor", "dt"] {
            let least = parts.iter().filter_map(|part| part.report["conformal"][key].as_f64()).reduce(f64::min);
            merged["conformal"][key] = json!(least);
        }
    }
    if !merged["tensors"].is_null() {
        for key in ["cut_points", "without_normal", "sampled_points"] {
            merged["tensors"][key] = json!(sum(parts, |report| &report["tensors"][key]));
        }
    }
    if merged["fractions"].is_null() {
        return Ok(());
    }
    for key in ["cut_cells", "sampled_cells"] {
        merged["fractions"][key] = json!(sum(parts, |report| &report["fractions"][key]));
    }
    let (ruler, rays) = (Ruler::new(whole, whole), merged["fractions"]["rays"].as_u64().unwrap_or(1).min(16));
    let of_flags = (0..=u8::MAX).zip(totals_per_flag(parts, |sums| &sums.fractions)?);
    let volumes = of_flags.map(|(flag, total)| (flag, ruler.volume(total, parts_of_cell(rays as u32))));
    let volumes = volumes.filter(|(_, volume)| *volume > 0.0);
    merged["fractions"]["volumes"] = volumes.map(|(flag, volume)| json!({ "flag": flag, "volume": volume })).collect();
    for geometry in 0..merged["fractions"]["areas"].as_array().map_or(0, Vec::len) {
        let mut area = Total::default();
        for part in parts {
            area.add(total(part.window.sums.areas.get(geometry).map_or("", String::as_str))?);
        }
        merged["fractions"]["areas"][geometry] = json!(ruler.area(area));
    }
    Ok(())
}

/// Adds up seconds; of memory keeps the most.
fn merge_costs(merged: &mut Value, parts: &[Part]) {
    let of =
        |group: &str, key: &str| parts.iter().filter_map(|part| part.report[group][key].as_f64()).collect::<Vec<f64>>();
    for key in ["total", "read", "lines", "snap", "columns", "measured", "flags", "device", "report", "hash", "write"] {
        let all = of("seconds", key);
        merged["seconds"][key] = if all.is_empty() { Value::Null } else { json!(all.iter().sum::<f64>()) };
    }
    for key in ["host", "meshing", "device", "spilled"] {
        merged["peak_bytes"][key] =
            json!(parts.iter().filter_map(|part| part.report["peak_bytes"][key].as_u64()).max());
    }
    let seconds = merged["seconds"]["total"].as_f64().unwrap_or(0.0).max(1e-9);
    merged["cells_per_second"] = json!(merged["cells"].as_f64().unwrap_or(0.0) / seconds);
}
