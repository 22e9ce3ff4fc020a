//! Cells that differ in size: what a job may ask for is as among equal cells.
//!
//! Two laws hold it to that. Where the last line is a bit off, all goes by the tables, and cells are equal but for that bit: everything
//! must come out as of equal cells. And boxes that are stretched with their lines have the same cells.

use std::collections::BTreeSet;
use std::sync::Arc;

use hexcast::columns::MemoryStore;
use hexcast::control::{CancelToken, Control};
use hexcast::job::{AxisChoice, ByteSize, Fill, GeometryJob, HaloEdge, Job, LinesJob, Open, PartJob, PerAxis, Rule};
use hexcast::mesh::Mesh;
use hexcast::pipeline::{self, Engine, MeshOptions, SpillTarget};
use hexcast::report::{CertificateReport, MeshFacts};
use hexcast::sources::Source;
use serde_json::Value;

use super::cli::{Folder, SPOT, done, json};
use super::memory::on_two_threads;
use super::models::{self, Facets};
use super::open_surfaces::{flags_of, meshed, without};

/// Cells of a quarter from 0 to 8.
fn equal() -> Job {
    set!(Job { cell_size: Some(PerAxis::All(0.25)), domain: Some([0.0, 0.0, 0.0, 8.0, 8.0, 8.0]), ..Job::default() })
}

/// The same as lists, the last line along x a bit off.
pub(crate) fn nearly(job: &Job) -> Job {
    let list: Vec<f64> = (0..=32).map(|line| f64::from(line) * 0.25).collect();
    let mut x = list.clone();
    x[32] = 8.0f64.next_up();
    let lines = Some(LinesJob { x, y: list.clone(), z: list });
    set!(Job { lines, cell_size: None, domain: None, ..job.clone() })
}

pub(crate) fn bodies() -> Vec<Facets> {
    let shells = models::joined([models::sphere([3.0; 3], 2.4, 12), models::sphere([4.6, 4.5, 4.4], 2.3, 10)]);
    let plate = models::cuboid([1.0, 1.5, 3.1], [7.0, 6.5, 3.3]);
    let holed = without(&models::sphere([5.1, 5.0, 4.9], 2.2, 10), 0.1, 5);
    let corners = models::octahedron([0.5, 0.5, 0.5], [4.5, 4.0, 3.5]);
    vec![shells, plate, holed, corners]
}

/// What a job may ask for, each with the settings of the bodies.
pub(crate) fn wishes() -> Vec<(&'static str, Job)> {
    let each = |settings: &dyn Fn(usize) -> GeometryJob| (0..4).map(settings).collect::<Vec<GeometryJob>>();
    let ranked = each(&|index| set!(GeometryJob { priority: [2, 0, 1, 1][index], ..GeometryJob::default() }));
    let one = |geometry: GeometryJob| vec![geometry.clone(), geometry.clone(), geometry.clone(), geometry];
    let job = |geometries: Vec<GeometryJob>| set!(Job { geometries, ..equal() });
    let inverted = one(set!(GeometryJob { invert: true, ..GeometryJob::default() }));
    let shell = |fill: Fill| one(set!(GeometryJob { fill: Some(fill), shell: true, ..GeometryJob::default() }));
    let window = Some([3, 0, 5, 20, 32, 9]);
    vec![
        ("plain", job(vec![])),
        ("priorities", job(ranked.clone())),
        ("nonzero", set!(Job { rule: Rule::Nonzero, ..job(ranked.clone()) })),
        ("inverted", job(inverted)),
        ("vote", set!(Job { open: Open::Vote, ..job(ranked.clone()) })),
        ("vote by nonzero", set!(Job { open: Open::Vote, rule: Rule::Nonzero, ..job(vec![]) })),
        ("parity", set!(Job { open: Open::Parity, ..job(ranked.clone()) })),
        ("gaps closed", set!(Job { close_gaps: Some(3), ..job(ranked.clone()) })),
        ("conservative", set!(Job { fill: Fill::Conservative, ..job(ranked.clone()) })),
        ("separating", set!(Job { fill: Fill::Separating, ..job(ranked.clone()) })),
        ("conservative shells", job(shell(Fill::Conservative))),
        ("separating shells", job(shell(Fill::Separating))),
        ("certificate", set!(Job { certify: true, thin_cells: Some(4), ..job(ranked.clone()) })),
        ("window", set!(Job { window, certify: true, fill: Fill::Conservative, ..job(ranked.clone()) })),
        ("halo", set!(Job { window, halo: Some(5), ..job(ranked.clone()) })),
        ("clamped halo", set!(Job { window, halo: Some(6), halo_edge: Some(HaloEdge::Clamp), ..job(vec![]) })),
        ("part", set!(Job { part: Some(PartJob::new(3, [2, 1, 2])), fill: Fill::Separating, ..job(ranked) })),
    ]
}

/// What a certificate counts, without places.
fn counts(certificate: &Option<CertificateReport>) -> Vec<String> {
    let Some(found) = certificate else { return Vec::new() };
    let walls = found
        .thin_walls
        .iter()
        .map(|wall| format!("{} {} {wall:?}", wall.geometry, wall.axis).replace(&format!("{:?}", wall.place), ""));
    let overlaps = found.overlaps.iter().map(|of| format!("{:?} {} {}", of.indices, of.cells, of.longest));
    let gaps = found.gaps.iter().map(|gap| format!("{:?} {} {}", gap.flags, gap.axis, gap.cells));
    walls.chain(overlaps).chain(gaps).collect()
}

#[test]
fn all_that_a_job_may_ask_for_comes_out_as_of_equal_cells() {
    let bodies = bodies();
    for (name, job) in wishes() {
        for axis in 0..3 {
            let made = |job: &Job| {
                meshed(&bodies, job, axis, &mut Engine::cpu()).unwrap_or_else(|error| panic!("{name}: {error}"))
            };
            let [(mesh, facts), (graded, of_graded)] = [made(&job), made(&nearly(&job))];
            assert!(!mesh.lines().is_graded() && graded.lines().is_graded(), "{name}");
            assert!(flags_of(&mesh) == flags_of(&graded), "{name}, rays along {axis}: flags differ");
            assert!(facts.flags.iter().any(|flag| flag.cells > 50), "{name}");
            assert_eq!(facts.flags_hash, of_graded.flags_hash, "{name}");
            let numbers = |facts: &MeshFacts| [facts.crossings, facts.odd_rays, facts.runs, facts.doubtful.cells];
            assert_eq!(numbers(&facts), numbers(&of_graded), "{name}, rays along {axis}");
            assert_eq!((&facts.filled, &facts.open.len()), (&of_graded.filled, &of_graded.open.len()), "{name}");
            assert_eq!(counts(&facts.certificate), counts(&of_graded.certificate), "{name}, rays along {axis}");
            assert_eq!(facts.certificate.is_some(), job.certify);
            for (one, other) in facts.flags.iter().zip(&of_graded.flags) {
                assert!((one.volume - other.volume).abs() <= 1e-12 * one.volume, "{name}: {one:?} and {other:?}");
            }
        }
    }
}

#[test]
fn open_surfaces_are_refused_alike() {
    let bodies = [bodies().swap_remove(2)];
    let job = set!(Job { open: Open::Error, ..equal() });
    let [one, other] = [job.clone(), nearly(&job)].map(|job| meshed(&bodies, &job, 0, &mut Engine::cpu()).unwrap_err());
    assert_eq!((one.code(), one.to_string()), ("surface-open", other.to_string()));
}

/// Lines and boxes, and where a stretch puts them.
fn stretched(at: f32) -> f32 {
    at + at * at / 16.0
}

fn job_of(line: &dyn Fn(f32) -> f32, job: &Job) -> Job {
    let list: Vec<f64> = (0..=12u8).map(|index| f64::from(line(index.into()))).collect();
    set!(Job { lines: Some(LinesJob { x: list.clone(), y: list.clone(), z: list }), ..job.clone() })
}

#[test]
fn the_certificate_of_stretched_boxes_is_that_of_boxes_and_volumes_are_those_of_cells() {
    let boxes = [
        ([1.0, 1.0, 1.0], [6.0, 6.0, 6.0]),
        ([4.0, 3.0, 2.0], [9.0, 8.0, 3.0]),
        ([7.0, 1.0, 1.0], [11.0, 6.0, 4.0]),
        ([2.0, 7.0, 2.0], [10.0, 9.0, 10.0]),
        ([2.0, 2.25, 9.0], [10.0, 2.375, 11.0]),
    ];
    let boxes = boxes.map(|(low, high)| models::cuboid(low, high));
    let job = set!(Job { certify: true, thin_cells: Some(3), ..Job::default() });
    for axis in 0..3 {
        let made = |line: &dyn Fn(f32) -> f32, job: &Job| {
            let bodies = boxes.clone().map(|body| models::mapped(&body, |corner| corner.map(line)));
            meshed(&bodies, &job_of(line, job), axis, &mut Engine::cpu()).unwrap()
        };
        let [(equal, facts), (graded, of_graded)] = [made(&|at| at, &job), made(&stretched, &job)];
        assert!(!equal.lines().is_graded() && graded.lines().is_graded() && flags_of(&equal) == flags_of(&graded));
        let [one, other] = [facts, of_graded].map(|facts| facts.certificate.unwrap());
        let walls = |of: &CertificateReport| {
            of.thin_walls
                .iter()
                .map(|wall| (wall.index, wall.axis, wall.rays, wall.lost, wall.cells))
                .collect::<Vec<_>>()
        };
        assert_eq!(walls(&one), walls(&other));
        assert!(
            one.thin_walls.iter().any(|wall| wall.lost > 0) && one.overlaps.len() > 1 && one.gaps.len() > 1,
            "{one:?}"
        );
        assert_eq!((one.overlaps.len(), one.gaps.len()), (other.overlaps.len(), other.gaps.len()));
        for (gap, of_graded) in one.gaps.iter().zip(&other.gaps) {
            assert_eq!((gap.flags, gap.axis, gap.cells), (of_graded.flags, of_graded.axis, of_graded.cells));
            assert_eq!(gap.bounds.map(|corner| corner.map(|at| f64::from(stretched(at as f32)))), of_graded.bounds);
        }
        let alone: Vec<Vec<u8>> = (0..boxes.len())
            .map(|index| {
                let body = models::mapped(&boxes[index], |corner| corner.map(stretched));
                let job = job_of(&stretched, &Job::default());
                flags_of(&meshed(&[body], &job, 0, &mut Engine::cpu()).unwrap().0)
            })
            .collect();
        let size = |index: usize| f64::from(stretched(index as f32 + 1.0) - stretched(index as f32));
        for (overlap, of_graded) in one.overlaps.iter().zip(&other.overlaps) {
            assert_eq!(
                (overlap.indices, overlap.cells, overlap.longest),
                (of_graded.indices, of_graded.cells, of_graded.longest)
            );
            let [winner, loser] = overlap.indices;
            let both = (0..12usize.pow(3)).filter(|&cell| alone[winner][cell] != 0 && alone[loser][cell] != 0);
            let volume: f64 = both.map(|cell| size(cell % 12) * size(cell / 12 % 12) * size(cell / 144)).sum();
            assert!((of_graded.volume / volume - 1.0).abs() < 1e-12, "{of_graded:?}: {volume}");
            // a place inside of both
            let place = [0, 1, 2].map(|axis| graded.lines().position(axis, of_graded.place[axis]) as usize);
            let cell = place[0] + 12 * (place[1] + 12 * place[2]);
            assert!(alone[winner][cell] != 0 && alone[loser][cell] != 0, "{of_graded:?}");
        }
    }
}

/// Lines that grow from 0.05 to 0.6, over the box of a model.
pub(crate) fn lines_of(model: &[Facets]) -> LinesJob {
    let corners = || model.iter().flatten().flatten();
    let list = |axis: usize| {
        let low = corners().map(|corner| corner[axis]).fold(f32::INFINITY, f32::min);
        let high = corners().map(|corner| corner[axis]).fold(f32::NEG_INFINITY, f32::max);
        let (mut at, mut size, mut list) = (f64::from(low) - 0.3, 0.05 + 0.01 * axis as f64, Vec::new());
        while at < f64::from(high) + 0.6 {
            list.push(at);
            at += size;
            size = (size * 1.1).min(0.6);
        }
        list
    };
    LinesJob { x: list(0), y: list(1), z: list(2) }
}

#[test]
fn windows_of_sheets_and_inverted_geometries_have_the_cells_of_the_whole() {
    let bodies = bodies();
    let graded = |job: Job| set!(Job { lines: Some(lines_of(&bodies)), cell_size: None, domain: None, ..job });
    let whole_boxes = wishes().into_iter().filter(|(_, job)| job.window.is_none() && job.part.is_none());
    for (index, (name, job)) in whole_boxes.enumerate() {
        // whose boxes depend on it
        let axis = index % 3;
        if job.open == Open::Parity || job.close_gaps.is_some() {
            continue;
        }
        let (whole, facts) = meshed(&bodies, &graded(job.clone()), 0, &mut Engine::cpu()).unwrap();
        assert!(whole.lines().is_graded());
        let flags = flags_of(&whole);
        let [nx, ny, nz] = whole.dims();
        let mut n_added = 0;
        for index in 1..=8 {
            let part = Some(PartJob::new(index, [2, 2, 2]));
            let (mesh, own) =
                meshed(&bodies, &graded(set!(Job { part, ..job.clone() })), axis, &mut Engine::cpu()).unwrap();
            let window = own.window.unwrap();
            n_added += own.filled.iter().map(|of| of.added_cells).sum::<u64>();
            let mut next = flags_of(&mesh).into_iter();
            for z in window.first[2]..window.end[2] {
                for y in window.first[1]..window.end[1] {
                    for x in window.first[0]..window.end[0] {
                        let expected = flags[(x + nx * (y + ny * z)) as usize];
                        assert_eq!(
                            next.next(),
                            Some(expected),
                            "{name}, part {index} of {nx} x {ny} x {nz}: {x} {y} {z}"
                        );
                    }
                }
            }
        }
        assert_eq!(n_added, facts.filled.iter().map(|of| of.added_cells).sum::<u64>(), "{name}");
    }
}

fn source() -> Vec<Source> {
    vec![Source::from_facets("body.stl", models::torus([4.0; 3], [2.4, 1.1], 24)).unwrap()]
}

pub(crate) fn long_run(
    engine: &mut Engine,
    max_memory: Option<ByteSize>,
    spill: SpillTarget,
    control: &Control,
) -> hexcast::Result<(Mesh, MeshFacts)> {
    let list = |n: u32| {
        let place = |line: u32| f64::from(line) / f64::from(n);
        (0..=n).map(|line| 8.0 * (0.9 * place(line) + 0.1 * place(line) * place(line))).collect::<Vec<f64>>()
    };
    let job = set!(Job {
        lines: Some(LinesJob { x: list(9), y: list(1100), z: list(1100) }),
        geometries: vec![GeometryJob::new("body.stl")],
        axis: AxisChoice::X,
        max_memory,
        ..Job::default()
    });
    let options = MeshOptions::default().with_spill(spill);
    on_two_threads(|| pollster::block_on(pipeline::mesh(&job, source(), &options, engine, control)))
}

#[test]
fn columns_on_graded_lines_spill_and_continue_after_an_interruption() {
    let (whole, _) = long_run(&mut Engine::cpu(), None, SpillTarget::None, &Control::default()).unwrap();
    assert!(whole.lines().is_graded());
    let spill = SpillTarget::Temporary(Arc::new(MemoryStore::default()));
    let (spilled, facts) = long_run(&mut Engine::cpu(), Some(ByteSize(9_000_000)), spill, &Control::default()).unwrap();
    assert!(spilled.columns().is_spilled() && facts.peak_bytes.spilled > 0, "{:?}", facts.peak_bytes);
    assert!(flags_of(&spilled) == flags_of(&whole));
    let store = Arc::new(MemoryStore::default());
    let token = CancelToken::default();
    let stop = token.clone();
    let mut control = Control::with_progress(move |_| stop.cancel());
    control.cancel = token;
    let error = long_run(&mut Engine::cpu(), None, SpillTarget::Resumable(store.clone()), &control).unwrap_err();
    assert_eq!(error.code(), "cancelled");
    let (mesh, facts) = long_run(&mut Engine::cpu(), None, SpillTarget::Resumable(store), &Control::default()).unwrap();
    assert!(facts.rays_kept > 0 && facts.rays_kept < facts.rays, "{} kept", facts.rays_kept);
    assert_eq!(mesh, whole);
}

/// Compares all numbers of two values, those of volumes to their last bits.
fn assert_alike(one: &Value, other: &Value, key: &str) {
    match (one, other) {
        (Value::Object(own), Value::Object(others)) => {
            assert_eq!(own.keys().collect::<BTreeSet<_>>(), others.keys().collect::<BTreeSet<_>>(), "{key}");
            own.iter().for_each(|(name, value)| assert_alike(value, &others[name], &format!("{key}.{name}")));
        }
        (Value::Array(own), Value::Array(others)) if own.len() == others.len() => {
            own.iter().zip(others).for_each(|(own, other)| assert_alike(own, other, key));
        }
        (Value::Number(own), Value::Number(others)) if key.ends_with(".volume") => {
            let [own, others] = [own, others].map(|number| number.as_f64().unwrap());
            assert!((own - others).abs() <= 1e-12 * own.abs(), "{key}: {own} and {others}");
        }
        _ => assert_eq!(one, other, "{key}"),
    }
}

#[test]
fn reports_of_parts_merge_to_that_of_the_whole() {
    let folder = Folder::new();
    let lines = folder.path("lines.json");
    let grown = |n: u32| (0..=n).map(|i| 0.05 * f64::from(i) + 0.0005 * f64::from(i * i) - 1.1).collect::<Vec<f64>>();
    let lists = serde_json::json!({ "x": grown(30), "y": grown(34), "z": grown(32) });
    std::fs::write(&lines, lists.to_string()).unwrap();
    let open = "tests/fixtures/featuretype.stl:scale=0.1";
    let moved = format!("{SPOT}:scale=0.5,name=small,flag=9");
    let cases: [(&[&str], &str, &str); 4] = [
        (&[SPOT, &moved, "--certify", "--thin-cells", "4"], "2x2x3", "y"),
        (&[SPOT, open, "--certify", "--fill", "conservative"], "3x1x2", "x"),
        (&[SPOT, &moved, "--fill", "separating", "--unit", "mm"], "4", "z"),
        (&[SPOT, &moved, "--rule", "nonzero", "--invert"], "1x3x1", "y"),
    ];
    for (job, of, axis) in cases {
        let arguments = [&["mesh", "--lines", &lines, "--backend", "cpu", "--json", "--axis", axis], job].concat();
        let mut expected = json(&arguments);
        let n: usize = of.split('x').map(|n| n.parse::<usize>().unwrap()).product();
        let names: Vec<String> = (1..=n).rev().map(|k| folder.path(&format!("{k}.json"))).collect();
        for (name, k) in names.iter().zip((1..=n).rev()) {
            done(&[&arguments[..], &["--part", &format!("{k}/{of}"), "--report", name]].concat());
        }
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let mut merged = json(&[&["merge"], &names[..]].concat());
        for report in [&mut expected, &mut merged] {
            let report = report.as_object_mut().unwrap();
            ["seconds", "peak_bytes", "cells_per_second"].iter().for_each(|key| drop(report.remove(*key)));
        }
        assert!(expected["grading"]["x"] == lists["x"] && expected["spacing"].is_null());
        assert_alike(&expected, &merged, "report");
    }
    // lines of another mesh
    let report = |k: usize| folder.path(&format!("{k}.json"));
    let mut other = folder.json("2.json");
    other["grading"]["x"][3] = 0.123.into();
    std::fs::write(report(2), other.to_string()).unwrap();
    let output = super::cli::hexcast(&["merge", &report(1), &report(2), &report(3)]);
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(4) && error.contains("has a line at 0.123 along x"), "{error}");
}
