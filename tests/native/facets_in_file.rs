//! Surfaces whose facets stay in their file, as memory is small for them: the same meshes and reports as of facets in memory, within the limit.

use std::io::Write;
use std::sync::Arc;

use hexcast::Result;
use hexcast::control::Control;
use hexcast::estimate::Estimate;
use hexcast::files::FileAt;
use hexcast::geometry::Facet;
use hexcast::job::{AxisChoice, GeometryJob, Job};
use hexcast::memory::Memory;
use hexcast::mesh::Mesh;
use hexcast::pipeline::{self, Engine, MeshOptions, prepare};
use hexcast::report::{CallerFacts, Report};
use hexcast::sources::Source;
use serde_json::Value;
use tempfile::NamedTempFile;

use super::findings::stl;
use super::models::{Facets, cuboid, joined, torus};

/// A binary STL on disk.
fn written(facets: &[Facet]) -> NamedTempFile {
    let mut file = NamedTempFile::new().expect("a place");
    file.write_all(&stl(facets)).expect("room");
    file
}

/// Reads a file where so many bytes of memory are left.
fn read(file: &NamedTempFile, n_left: u64) -> Result<Source> {
    let mut control = Control::default();
    control.memory = Memory::limited(n_left, 0);
    let mut input = file.reopen().expect("it is there");
    let n_bytes = input.metadata().expect("it is there").len();
    let again = Arc::new(FileAt::new(file.reopen().expect("it is there")));
    Source::read_again("ring.stl", n_bytes, (&mut input, again), &control)
}

fn job(cells: u32, axis: AxisChoice) -> Job {
    set!(Job { geometries: vec![GeometryJob::new("ring.stl")], cells: Some(cells), axis, ..Job::default() })
}

fn mesh(job: &Job, source: Source) -> Result<(Mesh, Value)> {
    let (options, control) = (MeshOptions::default(), Control::default());
    let (mesh, facts) = pollster::block_on(pipeline::mesh(job, vec![source], &options, &mut Engine::cpu(), &control))?;
    let mut report: Value = serde_json::from_str(&Report::new(facts, CallerFacts::default()).to_json()).expect("JSON");
    let fields = report.as_object_mut().expect("an object");
    // what it took of time and memory
    ["seconds", "cells_per_second", "peak_bytes"]
        .iter()
        .for_each(|key| drop(fields.remove(*key).expect("it is there")));
    Ok((mesh, report))
}

/// A ring of 80,000 facets: ten groups that are read together, the last of them short.
fn ring() -> Facets {
    torus([0.1, -0.2, 0.3], [2.0, 0.7], 200)
}

#[test]
fn facets_stay_in_their_file_where_they_would_take_more_than_half_of_what_is_left() {
    let (facets, file) = (ring(), written(&ring()));
    let n_bytes = 36 * facets.len() as u64;
    for (n_left, stays) in [(2 * n_bytes, false), (2 * n_bytes - 2, true)] {
        let source = read(&file, n_left).unwrap();
        let read = &source.contents.solids[0].facets;
        assert_eq!((read.n_bytes() == 0, read.len()), (stays, facets.len()));
        let mut found = Vec::new();
        read.for_each(|facet| found.push(*facet)).unwrap();
        assert_eq!(found, facets);
        let mut chunks = read.chunks(1 << 13);
        let mut found = Vec::new();
        while let Some(some) = chunks.next_some().unwrap() {
            assert!(some.len() <= 1 << 13);
            found.extend_from_slice(some);
        }
        assert_eq!(found, facets);
    }
    // the same facts, and the same hash of the file
    let [memory, file] = [u64::MAX, n_bytes].map(|n_left| read(&file, n_left).unwrap());
    assert_eq!(memory.blake3, file.blake3);
    assert_eq!(memory.contents.zero_area, file.contents.zero_area);
}

#[test]
fn meshes_and_reports_are_those_of_facets_in_memory() {
    let file = written(&ring());
    let read = |n_left| read(&file, n_left).unwrap();
    let in_file = || read(1_000_000);
    assert_eq!(in_file().contents.solids[0].facets.n_bytes(), 0);
    for axis in [AxisChoice::X, AxisChoice::Y, AxisChoice::Z] {
        for cells in [7, 60] {
            let job = job(cells, axis);
            assert_eq!(mesh(&job, in_file()).unwrap(), mesh(&job, read(u64::MAX)).unwrap(), "{axis:?} {cells}");
        }
    }
    let turned = set!(GeometryJob { rotate: Some([10.0, 20.0, 30.0]), ..GeometryJob::new("ring.stl") });
    let of = job(40, AxisChoice::Auto);
    let jobs = [
        set!(Job { geometries: vec![turned], ..of.clone() }),
        set!(Job { window: Some([0, 3, 0, 10, 20, 5]), ..of.clone() }),
        set!(Job { certify: true, ..of.clone() }),
        set!(Job { invert: true, ..of.clone() }),
    ];
    for job in jobs {
        assert_eq!(mesh(&job, in_file()).unwrap(), mesh(&job, read(u64::MAX)).unwrap(), "{job:?}");
    }
}

#[test]
fn a_file_that_changed_meanwhile_is_an_error_that_says_where() {
    let facets = ring();
    for (place, first, end) in [(0, 1, 8192), (79_999, 73_729, 80_000), (30_000, 24_577, 32_768)] {
        let file = written(&facets);
        let source = read(&file, 1_000_000).unwrap();
        let mut other = facets.clone();
        other[place][1][2] += 0.5;
        file.reopen().and_then(|mut open| open.write_all(&std::fs::read(written(&other).path())?)).expect("room");
        let error = mesh(&job(20, AxisChoice::Z), source).unwrap_err();
        assert_eq!(error.code(), "io");
        let said = format!(
            "ring.stl: facets {first} to {end} of 80000 are others than when it was read first: the file changed while it was used"
        );
        assert_eq!(error.to_string(), said);
    }
    let file = written(&facets);
    let source = read(&file, 1_000_000).unwrap();
    file.as_file().set_len(100_000).expect("ours");
    let error = mesh(&job(20, AxisChoice::Z), source).unwrap_err();
    assert!(error.code() == "io" && error.to_string().starts_with("reading ring.stl again: "), "{error}");
}

#[test]
fn shells_are_checked_as_those_of_facets_in_memory() {
    // of 20 cells the plate and the box have none, and a finding says so
    let plate = cuboid([4.0, 4.0, 4.2], [6.0, 6.0, 4.201]);
    let several = written(&joined([ring(), plate, cuboid([-4.0; 3], [-3.1, -3.1, -3.9])]));
    for cells in [20, 50] {
        let job = job(cells, AxisChoice::Z);
        let found = mesh(&job, read(&several, 1_000_000).unwrap()).unwrap();
        assert_eq!(found, mesh(&job, read(&several, u64::MAX).unwrap()).unwrap());
        let shells = &found.1["geometries"][0]["shells"];
        assert_eq!(shells["shells"], 3, "{shells}");
        assert_eq!(shells["without_cells"], if cells == 20 { 2 } else { 1 }, "{shells}");
    }
}

#[test]
fn a_surface_that_is_open_is_decided_as_ever() {
    let file = written(&ring()[1..]);
    let mesh = |n_left| mesh(&job(20, AxisChoice::Z), read(&file, n_left).unwrap()).unwrap();
    assert_eq!(mesh(1_000_000), mesh(u64::MAX));
}

#[test]
fn what_needs_all_facets_at_once_says_so() {
    let file = written(&ring()[1..]);
    let facets = &read(&file, 1_000_000).unwrap().contents.solids[0].facets;
    let error = facets.in_memory("a picture").unwrap_err();
    assert_eq!(
        (error.code(), error.hint()),
        ("memory", "allow more with max_memory (--max-memory), or leave that out")
    );
    assert_eq!(
        error.to_string(),
        "79999 facets would take 2.88 MB of memory, more than half of what was left, and stay in their file; a picture needs all at once"
    );
}

#[test]
fn estimates_count_what_is_held() {
    let file = written(&ring());
    let of = |n_left| {
        let prepared = prepare(&job(20, AxisChoice::Z), vec![read(&file, n_left).unwrap()]).unwrap();
        Estimate::new(&prepared.geometries, &prepared.lines, &prepared.rays)
    };
    let [memory, file] = [u64::MAX, 1_000_000].map(of);
    assert_eq!((memory.crossings, memory.column_bytes), (file.crossings, file.column_bytes));
    assert_eq!(memory.host.facets, 74 * 80_000);
    // a chunk, which may be larger than such a small list, and the few facets that rays may meet
    assert!(file.host.facets < 36 * (1 << 17) + 38 * 8_000, "{}", file.host.facets);
}

#[cfg(all(feature = "cli", target_os = "linux"))]
#[test]
fn the_command_meshes_a_large_surface_in_less_memory_than_its_facets_take() {
    let file = written(&torus([0.0; 3], [2.0, 0.7], 800));
    let folder = super::cli::Folder::new();
    let path = file.path().to_str().expect("text");
    let outputs = ["small.hxc", "large.hxc"].map(|name| folder.path(name));
    let mesh = |output: &str, max: &str| {
        super::memory_limits::watched(&[
            "mesh",
            path,
            "--cells",
            "60",
            "--backend",
            "cpu",
            "-o",
            output,
            "--max-memory",
            max,
        ])
    };
    // 1,280,000 facets take 46 MB
    let (code, said, peak) = mesh(&outputs[0], "48MB");
    assert!(code == 0 && peak <= 48_000_000, "{peak} bytes: {said}");
    let (code, said, _) = mesh(&outputs[1], "400MB");
    assert_eq!(code, 0, "{said}");
    let [small, large] = outputs.map(|output| std::fs::read(output).expect("written"));
    assert_eq!(small, large);
}
