//! Signed distances: against all facets one by one by another formula, with the signs of the mesh, by windows, and in all files that hold them.

use hexcast::distance::Distance;
use hexcast::job::{Band, DistanceJob, Everywhere, GeometryJob, Job, LinesJob, Points};
use hexcast::lines::Lines;
use hexcast::pipeline::Engine;
use hexcast::report::MeshFacts;

use super::cli::{Folder, SPOT, done, hexcast, json};
use super::models::{self, Facets};
use super::open_surfaces::{flags_of, meshed, without};
use super::soups::Random;

fn measured(bodies: &[Facets], job: &Job) -> (Distance, Vec<u8>, Lines) {
    let (mesh, facts) = meshed(bodies, job, 0, &mut Engine::cpu()).unwrap();
    let MeshFacts { distance, distance_report, .. } = facts;
    let (distance, report) = (distance.expect("it was asked for"), distance_report.expect("a report, too"));
    assert_eq!(report.width, Some(distance.width).filter(|width| width.is_finite()));
    (distance, flags_of(&mesh), mesh.lines().clone())
}

fn all(distance: &Distance) -> Vec<f64> {
    distance.distances(&distance.dims().map(|n| 0..n)).unwrap()
}

type Vector = [f64; 3];

fn minus(one: Vector, other: Vector) -> Vector {
    [0, 1, 2].map(|axis| one[axis] - other[axis])
}

fn dot(one: Vector, other: Vector) -> f64 {
    (0..3).map(|axis| one[axis] * other[axis]).sum()
}

/// The distance of a point from a facet, by barycentric coordinates of what is nearest (Eberly, Distance between point and triangle in 3D).
fn from_facet(point: Vector, facet: &[[f32; 3]; 3]) -> f64 {
    let [corner, b, c] = facet.map(|corner| corner.map(f64::from));
    let (one, other, from) = (minus(b, corner), minus(c, corner), minus(corner, point));
    let (a00, a01, a11) = (dot(one, one), dot(one, other), dot(other, other));
    let (b0, b1) = (dot(one, from), dot(other, from));
    let determinant = a00 * a11 - a01 * a01;
    let at = |s: f64, t: f64| {
        let place = [0, 1, 2].map(|axis| from[axis] + s * one[axis] + t * other[axis]);
        dot(place, place).sqrt()
    };
    let part = |above: f64, below: f64| if below > 0.0 { (above / below).clamp(0.0, 1.0) } else { 0.0 };
    let mut least = at(part(-b0, a00), 0.0).min(at(0.0, part(-b1, a11)));
    let along = part(a11 + b1 - a01 - b0, a00 - 2.0 * a01 + a11);
    least = least.min(at(along, 1.0 - along));
    if determinant > 1e-18 * a00 * a11 {
        let (s, t) = ((a01 * b1 - a11 * b0) / determinant, (a01 * b0 - a00 * b1) / determinant);
        if s >= 0.0 && t >= 0.0 && s + t <= 1.0 {
            least = least.min(at(s, t));
        }
    }
    least
}

/// The point of an index, x fastest.
fn point(lines: &Lines, distance: &Distance, index: usize) -> Vector {
    let [nx, ny, _] = distance.dims().map(|n| n as usize);
    let place = [index % nx, index / nx % ny, index / (nx * ny)];
    [0, 1, 2].map(|axis| match distance.of_nodes {
        true => lines.line(axis, place[axis] as u32),
        false => lines.centre(axis, place[axis] as u32),
    })
}

/// Compares distances with those of all facets, in cells.
fn check(distance: &Distance, bodies: &[Facets], lines: &Lines, case: &str) -> usize {
    let cell = lines.smallest().iter().fold(f64::INFINITY, |least, size| least.min(*size));
    let mut n_known = 0;
    for (index, found) in all(distance).into_iter().enumerate() {
        let point = point(lines, distance, index);
        let facets = bodies.iter().flatten();
        let expected = facets.map(|facet| from_facet(point, facet)).fold(distance.width, f64::min);
        n_known += usize::from(expected < distance.width);
        assert!((found.abs() - expected).abs() <= 1e-9 * cell, "{case}, point {index}: {found}, not {expected}");
    }
    n_known
}

fn random_job(random: &mut Random, n: usize) -> Job {
    let at = random.one_of(&[Points::Centres, Points::Nodes]);
    let band = random.one_of(&[Band::Cells(3.0), Band::Cells(0.7), Band::Word(Everywhere::All)]);
    let mut list = |size: &[f64]| {
        let mut lines = vec![-1.3];
        while lines.len() <= n {
            lines.push(lines[lines.len() - 1] + random.one_of(size));
        }
        lines
    };
    let (x, y, z) = (list(&[0.25, 0.3, 0.5]), list(&[0.3]), list(&[0.2, 0.4]));
    let distance = Some(set!(DistanceJob { at, band, ..DistanceJob::default() }));
    set!(Job { lines: Some(LinesJob { x, y, z }), distance, ..Job::default() })
}

fn random_body(random: &mut Random) -> Facets {
    let mut place = || [0, 1, 2].map(|_| random.between(-20, 60) as f32 / 16.0);
    let (low, high) = (place(), place());
    match random.below(4) {
        0 => models::sphere(low, 1.25, 5),
        1 => models::octahedron(
            [0, 1, 2].map(|axis| low[axis].min(high[axis]) - 0.5),
            [0, 1, 2].map(|axis| low[axis].max(high[axis])),
        ),
        2 => models::torus(low, [1.5, 0.25], 6),
        // a needle, thinner than a cell
        _ => models::cuboid(low, [low[0] + 3.0, low[1] + 0.01, low[2] + 0.001]),
    }
}

#[test]
fn numbers_are_the_distances_of_all_facets_and_signs_those_of_the_cells() {
    let (mut n_known, mut n_inside, mut n_open) = (0, 0, 0);
    for seed in 160_000..160_040 {
        let mut random = Random::new(seed);
        let mut bodies: Vec<Facets> = (0..1 + seed % 3).map(|_| random_body(&mut random)).collect();
        if seed % 4 == 0 {
            bodies[0] = without(&bodies[0], 0.1, seed);
            n_open += 1;
        }
        let job = random_job(&mut random, 11);
        let (distance, flags, lines) = measured(&bodies, &job);
        n_known += check(&distance, &bodies, &lines, &format!("seed {seed}"));
        if !distance.of_nodes {
            let is_inside: Vec<bool> = all(&distance).iter().map(|number| number.is_sign_negative()).collect();
            let expected: Vec<bool> = flags.iter().map(|flag| *flag != 0).collect();
            assert!(is_inside == expected, "seed {seed}");
            n_inside += is_inside.iter().filter(|is_inside| **is_inside).count();
        }
    }
    assert!(
        n_known > 20_000 && n_inside > 300 && n_open > 5,
        "{n_known} within bands, {n_inside} inside, {n_open} open"
    );
}

/// Nodes are cells of a box that is shifted by half a cell.
#[test]
fn signs_of_nodes_are_those_of_cells_around_them() {
    let bodies = [models::torus([3.0, 3.0, 3.0], [2.0, 0.75], 12), models::cuboid([1.0, 1.0, 1.0], [3.0, 4.0, 2.0])];
    let job = |start: f64, n: u32, at: Points| {
        let list: Vec<f64> = (0..=n).map(|line| start + f64::from(line) * 0.5).collect();
        let distance = Some(set!(DistanceJob { at, ..DistanceJob::default() }));
        set!(Job { lines: Some(LinesJob { x: list.clone(), y: list.clone(), z: list }), distance, ..Job::default() })
    };
    let (of_nodes, ..) = measured(&bodies, &job(0.0, 12, Points::Nodes));
    let (of_centres, ..) = measured(&bodies, &job(-0.25, 13, Points::Centres));
    assert_eq!((of_nodes.dims(), all(&of_nodes)), (of_centres.dims(), all(&of_centres)));
}

#[test]
fn windows_have_the_numbers_of_the_whole() {
    for seed in 170_000..170_010 {
        let mut random = Random::new(seed);
        let bodies = [random_body(&mut random), random_body(&mut random)];
        let job = random_job(&mut random, 13);
        let (whole, _, lines) = measured(&bodies, &job);
        let dims = lines.dims();
        let cuts = dims.map(|n| [0, random.between(1, n as i32 - 1) as u32, n]);
        let more = u32::from(whole.of_nodes);
        for window in 0..8 {
            let ends = [0, 1, 2].map(|axis| [cuts[axis][window >> axis & 1], cuts[axis][(window >> axis & 1) + 1]]);
            let [first, end] = [0, 1].map(|of| ends.map(|ends| ends[of]));
            let asked = [first[0], first[1], first[2], end[0], end[1], end[2]];
            let (found, ..) = measured(&bodies, &set!(Job { window: Some(asked), ..job.clone() }));
            let expected = whole.distances(&[0, 1, 2].map(|axis| first[axis]..end[axis] + more)).unwrap();
            assert_eq!(found.origin, first);
            assert!(all(&found) == expected, "seed {seed}: from {first:?} to {end:?}");
        }
    }
}

#[test]
fn surfaces_of_some_flags_are_as_if_there_were_no_others() {
    let bodies = [models::sphere([2.0; 3], 1.5, 8), models::sphere([3.0; 3], 1.0, 8), models::cube([0.5; 3], 1.0)];
    let list: Vec<f64> = (0..=20).map(|line| f64::from(line) * 0.25).collect();
    let lines = LinesJob { x: list.clone(), y: list.clone(), z: list };
    let geometries: Vec<GeometryJob> =
        (1..=3).map(|flag| set!(GeometryJob { flag: Some(flag), ..GeometryJob::default() })).collect();
    let job = |flags: &[u8], geometries: &[GeometryJob]| {
        let band = Band::Word(Everywhere::All);
        let distance = Some(set!(DistanceJob { band, flags: flags.to_vec(), ..DistanceJob::default() }));
        let (lines, geometries) = (Some(lines.clone()), geometries.to_vec());
        set!(Job { lines, geometries, distance, ..Job::default() })
    };
    let (of_some, ..) = measured(&bodies, &job(&[1, 3], &geometries));
    let (alone, ..) = measured(&[bodies[0].clone(), bodies[2].clone()], &job(&[], &[]));
    assert_eq!(all(&of_some), all(&alone));
    let (of_all, ..) = measured(&bodies, &job(&[], &geometries));
    assert_ne!(all(&of_all), all(&alone));
    // of nothing there is nothing
    for none in [[2..2, 0..3, 0..3], [0..3, 2..2, 0..3], [0..3, 0..3, 2..2]] {
        assert!(alone.distances(&none).unwrap().is_empty());
    }
}

#[test]
fn files_hold_the_numbers_of_the_library() {
    let folder = Folder::new();
    let mesh = |name: &str, more: &[&str]| {
        let out = folder.path(name);
        done(&[&["mesh", SPOT, "--cells", "20", "--backend", "cpu", "--distance", &out], more].concat());
    };
    for (at, names) in [("centres", &["d.npz", "d.vti", "d.vtr"][..]), ("nodes", &["n.npz", "n.vti", "n.vtr"][..])] {
        mesh("d.npy", &["--distance-at", at]);
        let bytes = folder.bytes("d.npy");
        let start = bytes.iter().position(|byte| *byte == b'\n').unwrap() + 1;
        let numbers = &bytes[start..];
        assert_eq!(numbers.len() % 8, 0);
        for name in names {
            mesh(name, &["--distance-at", at, "--compress", "none"]);
            let file = folder.bytes(name);
            assert!(file.windows(numbers.len()).any(|some| some == numbers), "{name}");
            let of = if at == "nodes" { "<PointData" } else { "<CellData" };
            let has = |text: &str| file.windows(text.len()).any(|some| some == text.as_bytes());
            assert!(name.ends_with("npz") || has(of) && has("type=\"Float64\" Name=\"distance\""), "{name}");
        }
    }
}

#[test]
fn reports_say_how_far_distances_are_known() {
    let folder = Folder::new();
    let mesh =
        |more: &[&str]| json(&[&["mesh", SPOT, "--cell-size", "0.05", "--backend", "cpu", "--json"], more].concat());
    let out = folder.path("d.zarr");
    let report = mesh(&["--distance", &out, "--distance-band", "2"])["distance"].take();
    assert_eq!(report["width"].as_f64().map(|width| (width * 1e9).round()), Some(1e8));
    assert!(report["facets"].as_u64().is_some_and(|facets| facets > 1000), "{report}");
    let out = folder.path("d.zarr.zip");
    assert!(mesh(&["--distance", &out, "--distance-band", "all"])["distance"]["width"].is_null());
    assert!(mesh(&[])["distance"].is_null());
}

#[test]
fn what_cannot_be_measured_is_said_with_a_remedy() {
    let folder = Folder::new();
    let refused = |name: &str, more: &[&str]| {
        let out = folder.path(name);
        let all = [&["mesh", SPOT, "--cells", "12", "--backend", "cpu", "--distance", &out], more].concat();
        let output = hexcast(&all);
        assert!(!output.status.success(), "{all:?}");
        String::from_utf8(output.stderr).unwrap()
    };
    let cases: [(&str, &[&str], &str); 6] = [
        ("d.npz", &["--distance-flags", "7"], "no geometry has flag 7, which distance.flags (--distance-flags) names"),
        ("d.npz", &["--distance-band", "0"], "distance.band is 0"),
        ("d.npz", &["--distance-band", "some"], "\"some\" is no band"),
        ("d.raw", &[], "no format of distances has this ending"),
        ("d.zarr", &["--distance-at", "nodes"], "a Zarr store holds numbers of cells, and nodes are asked for"),
        ("d.npz", &["--close-gaps", "2"], "distance is given with close_gaps"),
    ];
    for (name, more, expected) in cases {
        let message = refused(name, more);
        assert!(message.contains(expected), "{message}");
    }
}
