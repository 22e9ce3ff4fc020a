//! Convergence: areas against faces counted cell by cell, errors of bodies whose volume and area are known, and the command.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use hexcast::control::Control;
use hexcast::converge::{areas, converge};
use hexcast::job::{FractionsJob, GeometryJob, Job, LinksJob};
use hexcast::mesh::Mesh;
use hexcast::mesher::Mesher;
use hexcast::pipeline::{self, Engine, MeshOptions};
use hexcast::sources::Source;
use hexcast::{Error, Result};
use serde_json::Value;

use super::cli::{Folder, SPOT, done, hexcast, json};
use super::models::{Facets, cuboid, sphere};

fn job_of(surfaces: &[(&str, Facets)], domain: [f64; 6]) -> (Job, Vec<Source>) {
    let geometries = surfaces.iter().map(|(name, _)| GeometryJob::new(*name)).collect();
    let sources = surfaces.iter().map(|(name, facets)| Source::from_facets(*name, facets.clone()).expect("facets"));
    (set!(Job { domain: Some(domain), ..Job::new(geometries) }), sources.collect())
}

fn levels(job: &Job, sources: &[Source], sizes: &[u32]) -> Result<Vec<hexcast::converge::Level>> {
    pollster::block_on(converge(job, sources, sizes, &mut Engine::cpu(), &Control::default()))
}

/// How often a caller is asked to wait, so that it can cancel.
fn n_pauses(act: impl FnOnce(Control)) -> usize {
    let n = Arc::new(AtomicUsize::new(0));
    let counted = n.clone();
    act(Control::default().pausing(move || {
        counted.fetch_add(1, Relaxed);
        Box::pin(std::future::ready(()))
    }));
    n.load(Relaxed)
}

#[test]
fn what_is_measured_can_be_cancelled_between_its_steps() {
    let (job, sources) = job_of(&[("ball.stl", sphere([2.0; 3], 1.5, 24))], [0.0, 0.0, 0.0, 4.0, 4.0, 4.0]);
    let job = set!(Job { cells: Some(60), ..job });
    let meshed = |job: Job| {
        n_pauses(|control| {
            let options = MeshOptions::default();
            let mut engine = Engine::cpu();
            let mesh = pipeline::mesh(&job, sources.clone(), &options, &mut engine, &control);
            pollster::block_on(mesh).expect("a mesh");
        })
    };
    let plain = meshed(job.clone());
    let with_links = meshed(set!(Job { links: Some(LinksJob::default()), ..job.clone() }));
    // a pair of directions after the other
    assert!(with_links >= plain + 9, "{with_links} pauses with links, {plain} without");
    let with_fractions = meshed(set!(Job { fractions: Some(FractionsJob::default()), ..job.clone() }));
    assert!(with_fractions > plain, "{with_fractions} pauses with fractions, {plain} without");
    let compared = n_pauses(|control| {
        let job = set!(Job { cells: None, ..job.clone() });
        pollster::block_on(converge(&job, &sources, &[60], &mut Engine::cpu(), &control)).expect("levels");
    });
    // for faces, and for the bytes of a column file
    assert!(compared >= plain + 2, "{compared} pauses to compare, {plain} to mesh");
}

/// Faces of a flag across an axis, each looked at from the cell.
fn faces_by_cells(mesh: &Mesh, flag: u8, axis: usize) -> u64 {
    let dims = mesh.dims();
    let mut n = 0;
    for at in 0..mesh.n_cells() {
        let [x, y] = [dims[0], dims[1]].map(u64::from);
        let cell = [at % x, at / x % y, at / (x * y)].map(|index| index as u32);
        if mesh.flag(cell).expect("a cell") != flag {
            continue;
        }
        for step in [-1, 1] {
            let mut beside = cell.map(i64::from);
            beside[axis] += step;
            let is_within = (0..i64::from(dims[axis])).contains(&beside[axis]);
            let other = if is_within { mesh.flag(beside.map(|index| index as u32)).expect("a cell") } else { 0 };
            n += u64::from(other != flag);
        }
    }
    n
}

#[test]
fn areas_are_those_of_faces_counted_cell_by_cell() {
    let surfaces = [("a.stl", cuboid([0.0; 3], [3.0, 2.0, 1.0])), ("b.stl", cuboid([1.0, 1.0, 0.5], [4.0, 4.0, 4.0]))];
    // the box cuts the second body
    let (mut job, sources) = job_of(&surfaces, [-0.3, -0.2, -0.1, 3.7, 3.1, 3.3]);
    job = set!(Job { dims: Some([11, 7, 13]), ..job });
    let mut mesher = Mesher::with_engine(Engine::cpu());
    let made = mesher.mesh_sources(&job, sources, &MeshOptions::default(), &Control::default());
    let (mesh, _) = made.expect("a mesh");
    let found = pollster::block_on(areas(&mesh, &Control::default())).expect("areas");
    let spacing = mesh.lines().spacing().expect("equal cells");
    for (flag, axis) in [(1, 0), (1, 1), (1, 2), (2, 0), (2, 1), (2, 2)] {
        let face: f64 = (0..3).filter(|other| *other != axis).map(|other| spacing[other]).product();
        let expected = faces_by_cells(&mesh, flag, axis);
        assert!(expected > 0);
        assert_eq!(found[usize::from(flag)][axis], expected as f64 * face, "flag {flag} across {axis}");
    }
    assert_eq!(found[3], [0.0; 3]);
}

#[test]
fn a_box_on_the_lines_has_no_error_and_a_ball_less_and_less() {
    let (job, sources) = job_of(&[("box.stl", cuboid([1.0; 3], [3.0, 2.0, 4.0]))], [0.0, 0.0, 0.0, 5.0, 5.0, 5.0]);
    for level in levels(&job, &sources, &[5, 10, 20]).expect("levels") {
        let found = &level.flags[0];
        assert_eq!((found.mesh_areas, found.mesh_volume), ([6.0, 12.0, 4.0], Some(6.0)));
        assert!(found.volume_error.is_some_and(|error| error.abs() < 1e-12), "{found:?}");
        assert!(found.area_error.is_some_and(|error| error.abs() < 1e-12), "{found:?}");
        assert_eq!(level.flag_bytes, level.dims.iter().map(|n| u64::from(*n)).product::<u64>());
        assert!(level.column_bytes > 0 && level.spacing == [5.0 / f64::from(level.dims[0]); 3]);
    }
    let (job, sources) = job_of(&[("ball.stl", sphere([0.0; 3], 1.0, 80))], [-1.1, -1.2, -1.3, 1.2, 1.1, 1.2]);
    let levels = levels(&job, &sources, &[12, 48, 192]).expect("levels");
    for level in &levels {
        let (found, h) = (&level.flags[0], level.spacing[0]);
        // wrong cells lie within half a diagonal of the surface, 4 pi, wrong rays within that of the shadow's edge, 2 pi
        let [volume, area] = [3.0 * h * 3f64.sqrt() / 2.0, 2.0 * h * 2f64.sqrt() / 2.0];
        assert!(found.volume_error.is_some_and(|error| error.abs() < volume), "{found:?}");
        assert!(found.area_error.is_some_and(|error| error.abs() < area), "{found:?}");
    }
    let last = &levels[2].flags[0];
    // a ball of radius 1 casts a shadow of pi along each axis, from both sides
    let shadow = 2.0 * std::f64::consts::PI;
    assert!(last.mesh_areas.iter().all(|area| (area / shadow - 1.0).abs() < 0.01), "{last:?}");
}

#[test]
fn open_surfaces_have_no_error_and_cells_of_the_job_are_refused() {
    let mut facets = cuboid([1.0; 3], [3.0, 2.0, 4.0]);
    facets.truncate(10);
    let (job, sources) = job_of(&[("open.stl", facets)], [0.0, 0.0, 0.0, 5.0, 5.0, 5.0]);
    let found = levels(&job, &sources, &[10]).expect("levels");
    assert_eq!((found[0].flags[0].volume_error, found[0].flags[0].area_error), (None, None));
    let refused = levels(&set!(Job { cells: Some(10), ..job }), &sources, &[10]);
    assert!(matches!(refused, Err(Error::Caller(_))), "{refused:?}");
}

#[test]
fn the_command_prints_a_table_and_json_and_draws_a_graph() {
    let folder = Folder::new();
    let graph = folder.path("graph.svg");
    let text = done(&["converge", SPOT, "--sizes", "10,20,40", "--backend", "cpu", "-o", &graph]);
    assert!(text.starts_with("flag 1 \"spot\"\n") && text.lines().count() == 5, "{text}");
    let svg = std::fs::read_to_string(&graph).expect("a graph");
    assert!(
        svg.starts_with("<svg") && svg.contains("volume of &quot;spot&quot;") && svg.contains("cells along"),
        "{svg}"
    );
    let found: Value = json(&["converge", SPOT, "--sizes", "10,20", "--backend", "cpu", "--json"]);
    let mesh = json(&["mesh", SPOT, "--cells", "20", "--backend", "cpu", "--json"]);
    assert_eq!(found[1]["dims"], mesh["dims"]);
    assert_eq!(found[1]["flags"][0]["cells"], mesh["flags"][0]["cells"]);
    let refused = hexcast(&["converge", SPOT, "--dims", "3,4,5"]);
    let said = String::from_utf8_lossy(&refused.stderr);
    assert!(refused.status.code() == Some(4) && said.contains("leave out dims"), "{said}");
}

#[test]
fn the_command_takes_a_job_with_cells_and_writes_over_no_input() {
    let folder = Folder::new();
    let [job, stl, png] = ["job.toml", "spot.stl", "a.png"].map(|name| folder.path(name));
    std::fs::copy(SPOT, &stl).expect("a copy");
    let text = "cells = 99\nbackend = \"cpu\"\noutput = \"a.vti\"\n[[geometries]]\nfile = \"spot.stl\"\n";
    std::fs::write(&job, text).expect("written");
    let of_job = json(&["converge", "--job", &job, "--sizes", "8,16", "--json"]);
    let of_file = json(&["converge", &stl, "--sizes", "8,16", "--backend", "cpu", "--json"]);
    let cells = |levels: &Value| [0, 1].map(|index| levels[index]["flags"][0]["cells"].clone());
    assert_eq!(cells(&of_job), cells(&of_file));
    for (name, says) in [(&stl, "graphs are written to .svg only"), (&png, "graphs are written to .svg only")] {
        let refused = hexcast(&["converge", &stl, "--sizes", "8", "--backend", "cpu", "-o", name]);
        let said = String::from_utf8_lossy(&refused.stderr);
        assert!(refused.status.code() == Some(4) && said.contains(says), "{said}");
    }
    let odd = folder.path("odd.svg");
    std::fs::rename(&stl, &odd).expect("renamed");
    let refused = hexcast(&["converge", &odd, "--sizes", "8", "--backend", "cpu", "-o", &odd]);
    let said = String::from_utf8_lossy(&refused.stderr);
    assert!(refused.status.code() == Some(4) && said.contains("is an input too"), "{said}");
    assert_eq!(folder.names(), ["job.toml", "odd.svg"]);
    assert!(folder.bytes("odd.svg") == std::fs::read(SPOT).expect("the fixture"));
}
