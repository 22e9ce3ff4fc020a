//! What helps against findings: patches of the job, and the options of the command line that do the same.

use serde_json::{Value, json};

use hexcast_core::base::finding::{Finding, Remedy};
use hexcast_core::input::geometry::{Fill, Geometry};
use hexcast_core::input::job::{DEFAULT_CELLS, Job};

/// Adds to findings what helps; `geometries` are those of the job.
pub(super) fn add_remedies(findings: &mut [Finding], job: &Job, geometries: &[Geometry]) {
    for finding in findings {
        let geometry = finding.geometry.as_ref().and_then(|of| geometries.get(of.index));
        let remedies = match (finding.code, geometry) {
            ("shell-lost", Some(geometry)) => of_lost_shells(finding, job, (geometry, geometries)),
            _ => remedy(finding, job, geometries).into_iter().collect(),
        };
        finding.remedies.extend(remedies);
    }
}

/// What helps against a finding, if a change of the job does.
fn remedy(finding: &Finding, job: &Job, geometries: &[Geometry]) -> Option<Remedy> {
    let number = |key: &str| finding.values.get(key);
    let geometry = finding.geometry.as_ref().and_then(|of| geometries.get(of.index));
    match finding.code {
        "end-without-line" => smaller_cells(finding),
        "cells-fine" => {
            let tolerance = number("tolerance")?;
            let patch = json!({ "tolerance": tolerance });
            Some(Remedy::new("Allow a larger tolerance", patch, format!("--tolerance {tolerance}")))
        }
        "surface-open-parity" => by_winding(job, geometry?),
        "flag-shared" => own_flag(job, geometry?, number("free_flag")?.as_u64()?),
        "shells-overlap" => Some(Remedy::new("Use the winding number", json!({ "rule": "nonzero" }), "--rule nonzero")),
        "wall-thin" if number("lost")?.as_u64() == Some(0) => None,
        "wall-thin" | "no-cell-thin" | "no-cell-flat" | "no-cell-open" | "no-cell-small" => {
            let is_filled = geometry?.fill != Fill::Centre;
            if is_filled { None } else { fill(job, (geometry?, geometries), "Keep thin walls", "separating") }
        }
        "no-cell-covered" | "plate-covered" => win(job, geometry?, geometries.get(finding.other.as_ref()?.index)?),
        _ => None,
    }
}

/// What gives cells to shells that have none: more cells, or a fill.
fn of_lost_shells(finding: &Finding, job: &Job, (geometry, all): (&Geometry, &[Geometry])) -> Vec<Remedy> {
    let count = |key: &str| finding.values.get(key).and_then(serde_json::Number::as_u64);
    let factor = count("cells_factor").and_then(|factor| u32::try_from(factor).ok());
    let thickness = finding.values.get("thickness").and_then(serde_json::Number::as_f64).filter(|thick| *thick > 0.0);
    let finer = match factor {
        Some(factor) => more_cells(job, factor),
        None if job.graded.is_some() => thickness.and_then(|thickness| {
            let entry = job.geometries.get(geometry.entry)?;
            let value = Value::from(thickness);
            Some(Remedy::of_entry("Use smaller cells there", (geometry.entry, &entry.file), "max_size", value))
        }),
        None => None,
    };
    let is_kept = count("crossed") == Some(finding.boxes.len() as u64);
    let by = match geometry.fill {
        Fill::Centre if is_kept => Some("separating"),
        Fill::Centre | Fill::Separating => Some("conservative"),
        _ => None,
    };
    let filled = by.and_then(|by| fill(job, (geometry, all), "Keep thin parts", by));
    finer.into_iter().chain(filled).collect()
}

/// So many times as many equal cells along each axis.
fn more_cells(job: &Job, factor: u32) -> Option<Remedy> {
    let label = format!("Use {factor} times as many cells along each axis");
    let chosen = job.dims.is_some() || job.cell_size.is_some() || job.max_cell_size.is_some();
    if let Some(dims) = job.dims {
        let dims = dims.map(|n| n.saturating_mul(factor));
        let [x, y, z] = dims;
        return Some(Remedy::new(label, json!({ "dims": dims }), format!("--dims {x},{y},{z}")));
    }
    if let Some(size) = job.cell_size {
        let sizes = size.each().map(|size| size / f64::from(factor));
        let [x, y, z] = sizes;
        return Some(Remedy::new(label, json!({ "cell_size": sizes }), format!("--cell-size {x},{y},{z}")));
    }
    let cells = job.cells.unwrap_or(DEFAULT_CELLS).saturating_mul(factor);
    (!chosen).then(|| Remedy::new(label, json!({ "cells": cells }), format!("--cells {cells}")))
}

/// Smallest cells of a generated grid that leave room for a line of its own; not for ends that all but meet.
fn smaller_cells(finding: &Finding) -> Option<Remedy> {
    let of = |key: &str| finding.values.get(key).and_then(serde_json::Number::as_f64);
    let (distance, smallest) = (of("distance")?, of("smallest_cell")?);
    let patch = json!({ "graded": { "min_size": distance } });
    (distance >= 0.01 * smallest).then(|| Remedy::new("Allow smaller cells", patch, format!("--min-size {distance}")))
}

/// Fills a geometry, and lets it win over those that would have its cells: what is thin lies on what is not. Others stay as they are.
fn fill(job: &Job, (geometry, all): (&Geometry, &[Geometry]), label: &str, by: &str) -> Option<Remedy> {
    let entry = job.geometries.get(geometry.entry)?;
    let mut keys = vec![("fill", Value::from(by))];
    // of two with one priority the later wins
    let own = all.iter().position(|other| std::ptr::eq(other, geometry))?;
    let others = all.iter().enumerate().filter(|(_, other)| other.entry != geometry.entry);
    let stronger = others.filter(|(index, other)| (other.priority, *index) > (geometry.priority, own));
    if let Some(strongest) = stronger.map(|(_, other)| other.priority).max() {
        keys.push(("priority", strongest.checked_add(1)?.into()));
    }
    Some(Remedy::of_keys(label, (geometry.entry, &entry.file), &keys))
}

/// Asks for the winding number: for all geometries, unless the entry of this one has the key itself.
fn by_winding(job: &Job, geometry: &Geometry) -> Option<Remedy> {
    const LABEL: &str = "Use the winding number";
    let entry = job.geometries.get(geometry.entry)?;
    let of_entry = Remedy::of_entry(LABEL, (geometry.entry, &entry.file), "open", "winding".into());
    if entry.open.is_some() {
        return Some(of_entry);
    }
    // the job of a report has the key in its entries, too
    let mut patch = json!({ "open": "winding" });
    patch["geometries"] = of_entry.patch["geometries"].clone();
    Some(Remedy::new(LABEL, patch, "--open winding"))
}

/// Gives a geometry that nobody gave a flag one that is free; solids of a file have flags that count up.
fn own_flag(job: &Job, geometry: &Geometry, free: u64) -> Option<Remedy> {
    let entry = job.geometries.get(geometry.entry).filter(|entry| !job.splits(entry))?;
    Some(Remedy::of_entry(format!("Give it flag {free}"), (geometry.entry, &entry.file), "flag", free.into()))
}

/// Gives a geometry a higher priority than another; solids of one entry have the same.
fn win(job: &Job, geometry: &Geometry, winner: &Geometry) -> Option<Remedy> {
    let entry = job.geometries.get(geometry.entry).filter(|_| geometry.entry != winner.entry)?;
    let priority = Value::from(winner.priority.checked_add(1)?);
    Some(Remedy::of_entry("Let it win", (geometry.entry, &entry.file), "priority", priority))
}
