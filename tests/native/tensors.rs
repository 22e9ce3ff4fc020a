//! Smoothed permittivity: against boxes and planes whose fractions and normals follow from their coordinates, and cut by windows.

use hexcast::job::{AnisotropicJob, BackgroundJob, ConformalJob, GeometryJob, Job, LinesJob, Material, TensorsJob};
use hexcast::lines::Lines;
use hexcast::pipeline::Engine;
use hexcast::report::TensorsReport;
use hexcast::tensors::{Tensor, Tensors};

use super::cli::{Folder, SPOT, hexcast, json};
use super::cuboids::{Cuboid, ends_between, holder, stretches};
use super::models::{self, Facets};
use super::open_surfaces::meshed;
use super::soups::Random;

/// Ex, Ey and Ez lie on lines along two axes each.
const IS_ON_LINE: [[bool; 3]; 3] = [[false, true, true], [true, false, true], [true, true, false]];
/// Where a tensor has what of a matrix.
const PLACES: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [1, 2], [0, 2], [0, 1]];

fn tensors(bodies: &[Facets], job: &Job) -> (Tensors, TensorsReport, Lines) {
    let (mesh, facts) = meshed(bodies, job, 0, &mut Engine::cpu()).unwrap();
    (facts.tensors.expect("they were asked for"), facts.tensors_report.expect("one, too"), mesh.lines().clone())
}

fn all(found: &Tensors, part: usize) -> Vec<Tensor> {
    found.parts[part].tensors(&found.parts[part].dims().map(|n| 0..n)).unwrap()
}

/// The places of the points of a component, with their tensors.
fn points(found: &Tensors, part: usize) -> Vec<([u32; 3], Tensor)> {
    let [nx, ny, _] = found.parts[part].dims();
    let place = |index: u32| [index % nx, index / nx % ny, index / (nx * ny)];
    (0..).zip(all(found, part)).map(|(index, of)| (place(index), of)).collect()
}

fn off(one: &Tensor, other: &Tensor) -> f64 {
    one.iter().zip(other).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max)
}

/// The ends of the cell around a point.
fn cell_around(lines: &Lines, part: usize, place: [u32; 3]) -> [[f64; 2]; 3] {
    [0, 1, 2].map(|axis| {
        let (at, list) = (place[axis] as usize, lines.list(axis));
        if !IS_ON_LINE[part][axis] {
            return [list[at], list[at + 1]];
        }
        let last = list.len() - 1;
        let half = |cell: usize| 0.5 * (list[cell + 1] - list[cell]);
        // beyond the ends as far as within
        [list[at] - half(at.max(1) - 1), list[at] + half(at.min(last - 1))]
    })
}

/// Isotropic substances in layers across a normal.
fn layered(parts: &[(f64, f64)], normal: Option<[f64; 3]>) -> Tensor {
    let mean = parts.iter().map(|(part, eps)| part * eps).sum::<f64>();
    let across = 1.0 / parts.iter().map(|(part, eps)| part / eps).sum::<f64>();
    PLACES.map(|[i, j]| {
        let same = if i == j { 1.0 } else { 0.0 };
        normal.map_or(mean * same, |n| n[i] * n[j] * across + (same - n[i] * n[j]) * mean)
    })
}

/// A box of coordinates that are multiples of 1/8, many of them on lines or in the middle between two.
fn random_cuboid(random: &mut Random) -> Cuboid {
    let ends = ends_between(|| match random.below(3) {
        0 => random.below(8) as f64,
        1 => random.below(8) as f64 - 0.5,
        _ => random.below(56) as f64 / 8.0,
    });
    let eps = [1.0, 2.25, 4.0, 12.0][random.below(4) as usize];
    let (priority, is_inverted) = (random.below(3) as i32, random.below(6) == 0);
    Cuboid { ends, priority, is_inverted, eps, is_metal: false }
}

/// What each body, and the background, has of some stretches.
fn parts_of(cuboids: &[Cuboid], along: &[&[(f64, f64)]; 3]) -> Vec<f64> {
    let mut parts = vec![0.0; cuboids.len() + 1];
    for &(x, of_x) in along[0] {
        for &(y, of_y) in along[1] {
            for &(z, of_z) in along[2] {
                parts[holder(cuboids, [x, y, z])] += of_x * of_y * of_z;
            }
        }
    }
    parts
}

/// The tensor of a cell, and whether it has more than one permittivity.
fn expected(cuboids: &[Cuboid], background: f64, ends: [[f64; 2]; 3]) -> (Tensor, bool) {
    let along = [0, 1, 2].map(|axis| stretches(cuboids, axis, ends[axis]));
    let all = along.each_ref().map(|of| &of[..]);
    let eps = |body: usize| cuboids.get(body).map_or(background, |of| of.eps);
    let counts = |body: &usize| !cuboids.get(*body).is_some_and(|of| of.is_metal);
    let fractions = parts_of(cuboids, &all);
    let bodies: Vec<usize> = (0..fractions.len()).filter(counts).collect();
    let total = bodies.iter().map(|&body| fractions[body]).sum::<f64>();
    if total == 0.0 {
        return (layered(&[(1.0, 1.0)], None), false);
    }
    let parts: Vec<(f64, f64)> = bodies.iter().map(|&body| (fractions[body] / total, eps(body))).collect();
    let mean = parts.iter().map(|(part, eps)| part * eps).sum::<f64>();
    let held: Vec<f64> = parts.iter().filter(|(part, _)| *part > 0.0).map(|(_, eps)| *eps).collect();
    if held.iter().all(|of| *of == held[0]) {
        return (layered(&[(1.0, held[0])], None), false);
    }
    let mut rise = [0.0; 3];
    let mut is_flat = [true; 3];
    for axis in 0..3 {
        for (sign, at) in [(-1.0, 0), (1.0, along[axis].len() - 1)] {
            let side = [(along[axis][at].0, 1.0)];
            let mut of_face = all;
            of_face[axis] = &side;
            let of_face = parts_of(cuboids, &of_face);
            for &body in &bodies {
                rise[axis] += sign * of_face[body] * (eps(body) - mean) / (ends[axis][1] - ends[axis][0]);
                is_flat[axis] &= (of_face[body] - fractions[body]).abs() < 1e-9;
            }
        }
    }
    let length = rise.iter().map(|of| of * of).sum::<f64>().sqrt();
    let normal = match is_flat.iter().filter(|of| !**of).count() {
        _ if length > 1e-8 => Some(rise.map(|of| of / length)),
        1 => Some(is_flat.map(|of| if of { 0.0 } else { 1.0 })),
        _ => None,
    };
    (layered(&parts, normal), true)
}

fn job_of(cuboids: &[Cuboid], background: f64, graded: bool, random: &mut Random) -> Job {
    let geometry = |of: &Cuboid| {
        let material = match of.is_metal {
            true => set!(Material { pec: true, ..Material::default() }),
            false => set!(Material { eps_r: Some(of.eps), ..Material::default() }),
        };
        set!(GeometryJob { priority: of.priority, invert: of.is_inverted, material, ..GeometryJob::default() })
    };
    let mut list = || {
        let sizes = [0.5, 1.0, 2.0, 0.5];
        let mut lines = vec![-1.0];
        while lines[lines.len() - 1] < 7.0 {
            let size = if graded { sizes[random.below(4) as usize] } else { 1.0 };
            lines.push(lines[lines.len() - 1] + size);
        }
        lines
    };
    let (x, y, z) = (list(), list(), list());
    let material = set!(Material { eps_r: Some(background), ..Material::default() });
    let has_metal = cuboids.iter().any(|of| of.is_metal);
    set!(Job {
        geometries: cuboids.iter().map(geometry).collect(),
        background: Some(set!(BackgroundJob { material, ..BackgroundJob::default() })),
        lines: Some(LinesJob { x, y, z }),
        tensors: Some(TensorsJob::default()),
        conformal: has_metal.then(ConformalJob::default),
        ..Job::default()
    })
}

/// Some boxes, one of them metal at times.
fn random_boxes(seed: u64, random: &mut Random) -> Vec<Cuboid> {
    let mut cuboids: Vec<Cuboid> = (0..1 + seed % 4).map(|_| random_cuboid(random)).collect();
    cuboids[0].is_metal = seed.is_multiple_of(5);
    cuboids
}

#[test]
fn tensors_of_boxes_are_those_of_their_coordinates() {
    let (mut n_cut, mut n_graded, mut n_metal) = (0, 0, 0);
    for seed in 160_000..160_150 {
        let mut random = Random::new(seed);
        let cuboids = random_boxes(seed, &mut random);
        let bodies: Vec<Facets> = cuboids.iter().map(Cuboid::facets).collect();
        let job = job_of(&cuboids, 1.5, seed % 3 == 0, &mut random);
        let (found, report, lines) = tensors(&bodies, &job);
        let mut n_mixed = 0;
        for (part, is_on_line) in IS_ON_LINE.iter().enumerate() {
            let dims = [0, 1, 2].map(|axis| lines.dims()[axis] + u32::from(is_on_line[axis]));
            assert_eq!(found.parts[part].dims(), dims);
            for (place, of) in points(&found, part) {
                let (expected, is_mixed) = expected(&cuboids, 1.5, cell_around(&lines, part, place));
                let name = found.parts[part].name;
                assert!(off(&of, &expected) < 1e-11, "seed {seed}: {name} {place:?}: {of:?}, not {expected:?}");
                n_mixed += u64::from(is_mixed);
            }
        }
        assert_eq!(report.cut_points, n_mixed, "seed {seed}");
        n_cut += n_mixed;
        n_graded += usize::from(lines.is_graded());
        n_metal += usize::from(cuboids[0].is_metal);
    }
    assert!(n_cut > 10_000 && n_graded > 30 && n_metal > 20, "{n_cut} cut, {n_graded} graded, {n_metal} with metal");
}

/// The part of a cell in which n x < c, for n with positive components: by inclusion and exclusion of its corners.
fn below_plane(normal: [f64; 3], c: f64, ends: [[f64; 2]; 3]) -> f64 {
    let mut sum = 0.0;
    for corner in 0..8usize {
        let at = [0, 1, 2].map(|axis: usize| ends[axis][corner >> axis & 1]);
        let left = c - (0..3).map(|axis| normal[axis] * at[axis]).sum::<f64>();
        sum += if corner.count_ones() % 2 == 0 { 1.0 } else { -1.0 } * left.max(0.0).powi(3);
    }
    let volume = ends.iter().map(|of| of[1] - of[0]).product::<f64>();
    sum / (6.0 * normal.iter().product::<f64>() * volume)
}

/// What lies below the plane x + 2 y + 2 z = c around the lines, as far as these see: a tetrahedron.
fn below_slope(c: f32) -> Facets {
    let (o, a) = ([-64.0, -64.0, -64.0], c + 256.0);
    let [x, y, z] = [[a, -64.0, -64.0], [-64.0, 0.5 * (c + 192.0), -64.0], [-64.0, -64.0, 0.5 * (c + 192.0)]];
    vec![[o, y, x], [o, x, z], [o, z, y], [x, y, z]]
}

fn job_of_slope(eps: [f64; 2], lists: [Vec<f64>; 3]) -> Job {
    let material = |eps| set!(Material { eps_r: Some(eps), ..Material::default() });
    let geometries = vec![set!(GeometryJob { material: material(eps[0]), ..GeometryJob::default() })];
    let [x, y, z] = lists;
    set!(Job {
        geometries,
        background: Some(set!(BackgroundJob { material: material(eps[1]), ..BackgroundJob::default() })),
        lines: Some(LinesJob { x, y, z }),
        tensors: Some(TensorsJob::default()),
        ..Job::default()
    })
}

fn even(n: u32) -> Vec<f64> {
    (0..=n).map(f64::from).collect()
}

#[test]
fn a_tilted_plane_has_its_normal_and_its_fractions() {
    let normal = [1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0];
    let graded = [vec![0.0, 1.0, 3.0, 3.5, 5.0, 6.0], vec![0.0, 0.5, 2.0, 4.0, 5.0], vec![0.0, 2.0, 3.0, 5.0, 5.5]];
    let mut n_cut = 0;
    for (lists, c) in [([even(6), even(5), even(5)], 13.0), ([even(6), even(5), even(5)], 11.5), (graded, 12.0)] {
        let (found, report, lines) = tensors(&[below_slope(c as f32)], &job_of_slope([12.0, 2.0], lists));
        assert_eq!([report.without_normal, report.sampled_points], [0; 2]);
        for part in 0..3 {
            for (place, of) in points(&found, part) {
                let below = below_plane([1.0, 2.0, 2.0], c, cell_around(&lines, part, place));
                let expected = layered(&[(below, 12.0), (1.0 - below, 2.0)], Some(normal));
                assert!(off(&of, &expected) < 1e-5, "{c} {part} {place:?}: {of:?}, not {expected:?}");
                n_cut += u64::from(below > 0.01 && below < 0.99);
            }
        }
    }
    assert!(n_cut > 300, "{n_cut}");
}

#[test]
fn one_permittivity_everywhere_is_itself_to_the_last_bit() {
    let (found, report, _) = tensors(&[below_slope(13.0)], &job_of_slope([2.2, 2.2], [even(6), even(6), even(6)]));
    assert_eq!((report.cut_points, report.without_normal), (0, 0));
    for part in 0..3 {
        assert!(all(&found, part).iter().all(|of| *of == [2.2, 2.2, 2.2, 0.0, 0.0, 0.0]));
    }
    let crystal = [3.0, 5.0, 7.0, 0.5, -0.75, 1.0];
    let anisotropic = [0, 1].map(|flag| set!(AnisotropicJob { flag, eps_r: crystal, ..AnisotropicJob::default() }));
    let both = set!(TensorsJob { anisotropic: anisotropic.to_vec(), ..TensorsJob::default() });
    let lists = [even(6), even(6), even(6)];
    let job = set!(Job { tensors: Some(both), ..job_of_slope([1.0, 1.0], lists.clone()) });
    let (found, ..) = tensors(&[below_slope(13.0)], &job);
    assert!((0..3).all(|part| all(&found, part).iter().all(|of| *of == crystal)));
    // turned, it differs from itself in no mean of its axes
    let turned = [7.0, 3.0, 5.0, 1.0, 0.5, -0.75];
    let first = set!(AnisotropicJob { flag: 1, eps_r: turned, ..AnisotropicJob::default() });
    let two = set!(TensorsJob { anisotropic: vec![anisotropic[0].clone(), first], ..TensorsJob::default() });
    let (found, report, lines) =
        tensors(&[below_slope(13.0)], &set!(Job { tensors: Some(two), ..job_of_slope([1.0, 1.0], lists) }));
    assert!(report.cut_points > 100 && report.without_normal == 0, "{report:?}");
    for part in 0..3 {
        for (place, of) in points(&found, part) {
            let below = below_plane([1.0, 2.0, 2.0], 13.0, cell_around(&lines, part, place));
            assert_is_of_layers(&of, &[(below, turned), (1.0 - below, crystal)]);
        }
    }
}

/// What E and D have together in layers across (1, 2, 2) / 3, of which E along these and D across are the same in all.
fn assert_is_of_layers(found: &Tensor, parts: &[(f64, Tensor)]) {
    let matrix = |of: &Tensor| {
        let [xx, yy, zz, yz, xz, xy] = *of;
        [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    };
    let dot = |one: [f64; 3], other: [f64; 3]| (0..3).map(|axis| one[axis] * other[axis]).sum::<f64>();
    let times = |of: &Tensor, by: [f64; 3]| matrix(of).map(|row| dot(row, by));
    let normal = [1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0];
    for (along, across) in [([2.0, -1.0, 0.0], 0.0), ([0.0, 1.0, -1.0], 0.0), ([0.0; 3], 1.0)] {
        let (mut electric, mut flux) = ([0.0; 3], [0.0; 3]);
        for (part, eps) in parts {
            let more = (across - dot(times(eps, along), normal)) / dot(times(eps, normal), normal);
            let field = [0, 1, 2].map(|axis| along[axis] + more * normal[axis]);
            electric = [0, 1, 2].map(|axis| electric[axis] + part * field[axis]);
            flux = [0, 1, 2].map(|axis| flux[axis] + part * times(eps, field)[axis]);
        }
        let by_found = times(found, electric);
        let off = (0..3).map(|axis| (by_found[axis] - flux[axis]).abs()).fold(0.0, f64::max);
        assert!(off < 1e-5, "{found:?} of {parts:?}: {by_found:?}, not {flux:?}");
    }
}

#[test]
fn windows_have_the_numbers_of_the_whole() {
    for seed in 170_000..170_040 {
        let mut random = Random::new(seed);
        let mut cuboids = random_boxes(seed, &mut random);
        let mut bodies: Vec<Facets> = cuboids.iter().map(Cuboid::facets).collect();
        if seed % 2 == 0 {
            cuboids.push(Cuboid { ends: [[0.0; 2]; 3], priority: 1, is_inverted: false, eps: 3.0, is_metal: false });
            bodies.push(models::sphere([3.1, 2.9, 3.2], 2.6, 15));
        }
        let job = job_of(&cuboids, 1.0, seed % 3 == 0, &mut random);
        let (whole, of_whole, lines) = tensors(&bodies, &job);
        let dims = lines.dims();
        let cuts = dims.map(|n| [0, random.between(1, n as i32 - 1) as u32, n]);
        let mut counts = [0; 3];
        for window in 0..8 {
            let ends = [0, 1, 2].map(|axis| [cuts[axis][window >> axis & 1], cuts[axis][(window >> axis & 1) + 1]]);
            let [first, end] = [0, 1].map(|of| ends.map(|ends| ends[of]));
            let asked = [first[0], first[1], first[2], end[0], end[1], end[2]];
            let (found, report, _) = tensors(&bodies, &set!(Job { window: Some(asked), ..job.clone() }));
            assert_eq!(found.origin, first);
            for (part, is_on_line) in IS_ON_LINE.iter().enumerate() {
                let some = [0, 1, 2].map(|axis| first[axis]..end[axis] + u32::from(is_on_line[axis]));
                let expected = whole.parts[part].tensors(&some).unwrap();
                assert!(all(&found, part) == expected, "seed {seed}: {part} from {first:?} to {end:?}");
            }
            let of_window = [report.cut_points, report.without_normal, report.sampled_points];
            counts = [0, 1, 2].map(|of: usize| counts[of] + of_window[of]);
        }
        assert_eq!(counts, [of_whole.cut_points, of_whole.without_normal, of_whole.sampled_points], "seed {seed}");
    }
}

#[test]
fn reports_of_parts_add_up_to_that_of_the_whole() {
    let folder = Folder::new();
    let (out, body) = (folder.path("e.npz"), format!("{SPOT}:eps_r=4.5"));
    let mesh = ["mesh", &body, "--cells", "24", "--backend", "cpu", "--json", "--tensors", &out];
    let whole = json(&mesh)["tensors"].take();
    assert!(whole["cut_points"].as_u64() > Some(1000), "{whole}");
    let names: Vec<String> = (1..=6).map(|part| folder.path(&format!("{part}.json"))).collect();
    for (part, name) in (1..).zip(&names) {
        let report = json(&[&mesh[..], &["--part", &format!("{part}/3x2x1")]].concat());
        std::fs::write(name, report.to_string()).unwrap();
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    assert_eq!(json(&[&["merge"], &names[..]].concat())["tensors"], whole);
}

#[test]
fn what_has_no_permittivity_is_said_with_a_remedy() {
    let folder = Folder::new();
    let (out, job) = (folder.path("e.npz"), folder.path("job.toml"));
    let spot = std::path::absolute(SPOT).unwrap();
    let crystal = |eps: &str| {
        let text = format!(
            "cells = 12\ntensors = {{ anisotropic = [{eps}] }}\n[[geometries]]\nfile = {spot:?}\nmaterial = {{ eps_r = 2 }}\n"
        );
        std::fs::write(&job, text).unwrap();
    };
    let (glass, metal, shell) =
        (format!("{SPOT}:eps_r=4.5"), format!("{SPOT}:pec=true"), format!("{SPOT}:eps_r=2,shell=true"));
    let cases: [(&[&str], &str, &str); 9] = [
        (&[SPOT, "--tensors", &out], "", "flag 1 (spot) has no permittivity"),
        (&[&metal, "--tensors", &out], "", "is a perfect conductor, which has no permittivity"),
        (&[&shell, "--tensors", &out], "", "has no volume over which tensors could average its eps_r"),
        (&[&glass, "--tensors", &folder.path("e.txt")], "", "smoothed permittivity is written as .npz"),
        (&[&glass, "--tensors", &out, "--close-gaps", "3"], "", "tensors is given with close_gaps"),
        (&[&glass, "--tensors", &out, "--part", "1/2", "--halo", "1"], "", "tensors is given with a halo"),
        (&["--job", &job], "{ flag = 1, eps_r = [1, 1, 1, 2, 0, 0] }", "whose principal values are positive"),
        (&["--job", &job], "{ flag = 7, eps_r = [1, 1, 1, 0, 0, 0] }", "no geometry has flag 7"),
        (
            &["--job", &job],
            "{ flag = 1, eps_r = [1, 1, 1, 0, 0, 0] }, { flag = 1, eps_r = [2, 1, 1, 0, 0, 0] }",
            "which an entry before it has",
        ),
    ];
    for (arguments, eps, expected) in cases {
        crystal(eps);
        let size: &[&str] = if eps.is_empty() { &["--cells", "12"] } else { &[] };
        let output = hexcast(&[&["mesh"], arguments, size, &["--backend", "cpu"]].concat());
        assert!(!output.status.success(), "{arguments:?} succeeds");
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(said.contains(expected), "{arguments:?}: {said}");
    }
    let both =
        ["mesh", &metal, "--cells", "12", "--backend", "cpu", "--tensors", &out, "--conformal", &folder.path("c.npz")];
    // vacuum beside metal has one permittivity
    assert_eq!(json(&[&both[..], &["--json"]].concat())["tensors"]["cut_points"], 0);
}
