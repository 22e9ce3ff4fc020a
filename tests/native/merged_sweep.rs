//! Random jobs cut into parts at random: the merged report is that of the whole, byte for byte, but for times and memory. And the report is the
//! same along all axes, but for what is said of rays.
//!
//! `HEXCAST_MERGED_JOBS=500` checks so many; with `HEXCAST_SEED` each is that of this seed.

use hexcast::control::Control;
use hexcast::job::{Fill, FractionsJob, Job, LinesJob, LinksJob, Open, PartJob, Stencil};
use hexcast::mesh::Mesh;
use hexcast::pipeline::{Engine, MeshOptions, merge, mesh};
use hexcast::read::read_bytes;
use hexcast::report::{CallerFacts, Report};
use hexcast::sources::Source;
use hexcast_core::cells::flags::flags_of_box;
use serde_json::Value;

use super::models::Facets;
use super::soups::Random;
use super::verify::{AXES, stl, sweep};

fn report(surfaces: &[Facets], job: &Job) -> hexcast::Result<(Mesh, Value)> {
    let source = |(index, facets): (usize, &Facets)| {
        Source::new(format!("{index}.stl"), read_bytes(&stl(facets)).expect("a binary STL"), None)
    };
    let sources = surfaces.iter().enumerate().map(source).collect();
    let options = MeshOptions::default();
    let (mut engine, control) = (Engine::cpu(), Control::default());
    let (mesh, facts) = pollster::block_on(mesh(job, sources, &options, &mut engine, &control))?;
    Ok((mesh, serde_json::to_value(Report::new(facts, CallerFacts::default())).expect("JSON")))
}

/// A report without what depends on the run, and without some keys.
fn lasting(mut report: Value, without: &[&str]) -> Value {
    let object = report.as_object_mut().expect("an object");
    ["seconds", "peak_bytes", "cells_per_second"].iter().chain(without).for_each(|key| drop(object.shift_remove(*key)));
    report
}

/// Jobs of all kinds, with all that is measured.
fn job(seed: u64) -> (Vec<Facets>, Job, Random) {
    let (surfaces, mut job, mut random) = sweep::job(seed);
    for (index, entry) in job.geometries.iter_mut().enumerate() {
        entry.file = format!("{index}.stl");
    }
    job = set!(Job { window: None, part: None, halo: None, halo_edge: None, close_gaps: None, gap_flag: None, ..job });
    job.certify = random.below(2) == 0;
    // whole rays decide it
    job.open = if job.open == Open::Parity { Open::Winding } else { job.open };
    job.geometries.iter_mut().for_each(|entry| entry.open = entry.open.filter(|open| *open != Open::Parity));
    if random.below(2) == 0 {
        let stencil = if job.lines.is_some() || job.graded.is_some() { Stencil::D3Q7 } else { Stencil::D3Q27 };
        job.links = Some(set!(LinksJob { stencil, fluid: vec![0], ..LinksJob::default() }));
    }
    if random.below(2) == 0 {
        let rays = random.one_of(&[None, None, None, Some(1), Some(2), Some(4)]);
        let faces = random.below(2) == 0;
        job.fractions = Some(set!(FractionsJob { rays, surfaces: true, faces, ..FractionsJob::default() }));
        // what has fractions is closed, more often than not
        job.fill = Fill::Centre;
        job.geometries.iter_mut().for_each(|entry| (entry.fill, entry.shell) = (None, false));
    }
    job.staggered = random.below(4) == 0;
    (surfaces, job, random)
}

#[test]
fn parts_of_random_jobs_have_the_report_of_the_whole_together() {
    let n_jobs = std::env::var("HEXCAST_MERGED_JOBS").map_or(40, |n| n.parse().expect("a number of jobs"));
    let only: Option<u64> = std::env::var("HEXCAST_SEED").ok().and_then(|n| n.parse().ok());
    let (mut seed, mut wrong, mut n_done, mut n_parts) = (0, Vec::new(), 0, 0);
    let mut n_with = [0; 6];
    while n_done < n_jobs {
        seed = only.unwrap_or(seed + 1);
        let (surfaces, job, mut random) = job(seed);
        let Ok((_, whole)) = report(&surfaces, &job) else { continue };
        let dims = [0, 1, 2].map(|axis| whole["dims"][axis].as_u64().expect("a number"));
        let of = dims.map(|n| 1 + random.below(n.min(3)) as u32);
        let parts = (1..=of.iter().product()).map(|index| {
            let halo = if job.staggered { None } else { random.one_of(&[None, None, Some(1), Some(2)]) };
            set!(Job { part: Some(PartJob::new(index, of)), halo, ..job.clone() })
        });
        let parts: Vec<Job> = parts.collect();
        let reports: hexcast::Result<Vec<Value>> = parts.iter().map(|part| Ok(report(&surfaces, part)?.1)).collect();
        let merged = reports.and_then(|reports| merge(&reports));
        n_done += 1;
        n_parts += parts.len();
        let has = |key: &str| !whole[key].is_null();
        let is_apart = ["open", "filled"].iter().any(|key| whole[*key].as_array().is_some_and(|list| !list.is_empty()));
        let seen = [
            has("grading"),
            has("links"),
            has("fractions"),
            has("certificate"),
            has("links") && is_apart,
            parts.iter().any(|part| part.halo.is_some()),
        ];
        n_with.iter_mut().zip(seen).for_each(|(n, is_so)| *n += u32::from(is_so));
        match merged.map(|merged| lasting(merged, &[])) {
            Ok(merged) => {
                let whole = lasting(whole, &[]);
                let differs = |(key, value): (&String, &Value)| {
                    (merged[key] != *value).then(|| format!("{key}: {} is not {value}", merged[key]))
                };
                let differing: Vec<String> = whole.as_object().into_iter().flatten().filter_map(differs).collect();
                // with the order of keys
                let [one, other] = [&merged, &whole].map(Value::to_string);
                if one != other {
                    wrong.push(format!("seed {seed} in {of:?}: {differing:?} {}", job.to_json()));
                }
            }
            Err(error) => wrong.push(format!("seed {seed} in {of:?}: {error}")),
        }
    }
    println!(
        "seeds 1 to {seed}: {n_done} jobs in {n_parts} parts; graded, links, fractions, certified, links apart, halos: {n_with:?}"
    );
    assert!(wrong.is_empty(), "{} of {n_done}:\n{}", wrong.len(), wrong.join("\n"));
    assert!(n_with.iter().all(|n| 20 * n > n_jobs), "{n_with:?}");
}

#[test]
fn the_report_is_the_same_along_all_axes() {
    let (mut seed, mut n_graded) = (1000, 0);
    while n_graded < 15 {
        seed += 1;
        let (surfaces, job, _) = job(seed);
        let of_axis = |axis| report(&surfaces, &set!(Job { axis, ..job.clone() }));
        let Ok((mesh, first)) = of_axis(AXES[0]) else { continue };
        n_graded += u32::from(mesh.lines().is_graded());
        let of_rays =
            ["ray_axis", "rays", "crossings", "runs", "odd_rays", "job", "certificate", "warnings", "findings"];
        for axis in AXES {
            let (_, other) = of_axis(axis).expect("a mesh");
            let [one, other] = [&first, &other].map(|report| lasting(report.clone(), &of_rays));
            for (key, value) in one.as_object().expect("an object") {
                assert_eq!(&other[key], value, "seed {seed}, {axis:?}: {key}");
            }
            assert_eq!(one.to_string(), other.to_string(), "seed {seed}, {axis:?}");
        }
        let n = mesh.dims();
        let flags = flags_of_box(mesh.columns(), &[0..n[0], 0..n[1], 0..n[2]]).expect("in memory");
        for flag in first["flags"].as_array().expect("a list") {
            let mut volume = 0.0;
            for (index, _) in (0u32..).zip(&flags).filter(|(_, of)| flag["flag"] == **of) {
                let cell = [index % n[0], index / n[0] % n[1], index / (n[0] * n[1])];
                volume += (0..3).map(|axis| mesh.lines().cell_size(axis, cell[axis])).product::<f64>();
            }
            let found = flag["volume"].as_f64().expect("a number");
            assert!((found - volume).abs() <= 1e-12 * volume, "seed {seed}: {found}, {volume}");
        }
    }
}

#[test]
fn sums_of_lines_far_from_zero_and_of_tiny_cells_are_those_of_the_whole() {
    let list = |from: f64, step: f64| (0..14).map(|k| from + step * f64::from(k * k)).collect::<Vec<f64>>();
    let surfaces = vec![super::models::sphere([1e4 + 80.0, 3.0, -50.0], 60.0, 20)];
    for step in [1.0, 1.0 / 3.0, 0.7] {
        let lines = LinesJob { x: list(1e4, step), y: list(-60.1, step), z: list(-123.4, step) };
        let mut job = set!(Job { lines: Some(lines), certify: true, axis: AXES[1], ..Job::default() });
        job.geometries = vec![hexcast::job::GeometryJob::new("0.stl")];
        let (_, whole) = report(&surfaces, &job).expect("a mesh");
        assert!(whole["flags"][0]["volume"].as_f64() > Some(0.0));
        for of in [[3, 2, 1], [1, 5, 2], [13, 1, 3]] {
            let part = |index| set!(Job { part: Some(PartJob::new(index, of)), ..job.clone() });
            let reports: Vec<Value> =
                (1..=of.iter().product()).map(|index| report(&surfaces, &part(index)).expect("a mesh").1).collect();
            let merged = merge(&reports).expect("a report");
            assert_eq!(lasting(merged, &[]).to_string(), lasting(whole.clone(), &[]).to_string(), "{step} {of:?}");
        }
    }
}
