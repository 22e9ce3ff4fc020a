//! Edges and faces outside metal: against boxes whose lengths and areas follow from their coordinates, cut by windows, and held to the step that they allow.

use hexcast::conformal::{Conformal, PARTS};
use hexcast::job::{ConformalJob, GeometryJob, Job, LinesJob, Material};
use hexcast::lines::Lines;
use hexcast::pipeline::Engine;
use hexcast::report::ConformalReport;

use super::cli::{Folder, SPOT, hexcast, json};
use super::cuboids::{Cuboid, ends_between, holder, stretches};
use super::models::{self, Facets};
use super::open_surfaces::meshed;
use super::soups::Random;

fn conformal(bodies: &[Facets], job: &Job) -> (Conformal, ConformalReport, Lines) {
    let (mesh, facts) = meshed(bodies, job, 0, &mut Engine::cpu()).unwrap();
    let (found, report) = (facts.conformal.expect("it was asked for"), facts.conformal_report.expect("one, too"));
    assert_eq!(report.dt_factor, found.dt_factor);
    (found, report, mesh.lines().clone())
}

/// All fractions of a component.
fn all(found: &Conformal, part: usize) -> Vec<f64> {
    found.parts[part].fractions(&found.parts[part].dims().map(|n| 0..n)).unwrap()
}

/// A box of coordinates that are multiples of 1/8, many of them on lines.
fn random_cuboid(random: &mut Random) -> Cuboid {
    let ends =
        ends_between(|| if random.below(2) == 0 { random.below(8) as f64 } else { random.below(56) as f64 / 8.0 });
    let priority = random.below(3) as i32;
    Cuboid { ends, priority, is_inverted: random.below(6) == 0, is_metal: random.below(2) == 0, eps: 1.0 }
}

fn is_metal(cuboids: &[Cuboid], point: [f64; 3]) -> bool {
    cuboids.get(holder(cuboids, point)).is_some_and(|of| of.is_metal)
}

/// What of an edge or face lies outside metal, seen from the side of it where that is least.
fn expected(cuboids: &[Cuboid], part: usize, place: [u32; 3], lines: &Lines) -> f64 {
    let (_, is_on_line) = PARTS[part];
    let of_axis = |axis: usize, side: f64| match is_on_line[axis] {
        true => vec![(lines.line(axis, place[axis]) + side / 64.0, 1.0)],
        false => stretches(cuboids, axis, [0, 1].map(|end| lines.line(axis, place[axis] + end))),
    };
    let seen_from = |side: usize| {
        let along = [0, 1, 2].map(|axis| of_axis(axis, if side >> axis & 1 == 1 { 1.0 } else { -1.0 }));
        let mut outside = 0.0;
        for &(x, of_x) in &along[0] {
            for &(y, of_y) in &along[1] {
                for &(z, of_z) in &along[2] {
                    outside += if is_metal(cuboids, [x, y, z]) { 0.0 } else { of_x * of_y * of_z };
                }
            }
        }
        outside
    };
    (0..8).map(seen_from).fold(1.0, f64::min)
}

fn job_of(cuboids: &[Cuboid], stable: f64, graded: bool, random: &mut Random) -> Job {
    let geometry = |of: &Cuboid| {
        let material = set!(Material { pec: of.is_metal, ..Material::default() });
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
    let conformal = set!(ConformalJob { stable, ..ConformalJob::default() });
    let geometries = cuboids.iter().map(geometry).collect();
    set!(Job { geometries, lines: Some(LinesJob { x, y, z }), conformal: Some(conformal), ..Job::default() })
}

#[test]
fn lengths_and_areas_are_those_of_boxes_from_all_sides() {
    let (mut n_cut, mut n_graded) = (0, 0);
    for seed in 140_000..140_150 {
        let mut random = Random::new(seed);
        let mut cuboids: Vec<Cuboid> = (0..1 + seed % 4).map(|_| random_cuboid(&mut random)).collect();
        cuboids[0].is_metal = true;
        let bodies: Vec<Facets> = cuboids.iter().map(Cuboid::facets).collect();
        let job = job_of(&cuboids, 0.0, seed % 3 == 0, &mut random);
        let (found, report, lines) = conformal(&bodies, &job);
        let mut counts = [0, 0];
        for part in 0..6 {
            let [nx, ny, _] = found.parts[part].dims();
            for (index, fraction) in all(&found, part).into_iter().enumerate() {
                let index = index as u32;
                let place = [index % nx, index / nx % ny, index / (nx * ny)];
                let expected = expected(&cuboids, part, place, &lines);
                let name = PARTS[part].0;
                assert!(
                    (fraction - expected).abs() < 1e-14,
                    "seed {seed}: {name} {place:?}: {fraction}, not {expected}"
                );
                assert!(
                    (fraction == 0.0) == (expected == 0.0) || expected > 0.0,
                    "seed {seed}: {name} {place:?}: {fraction}"
                );
                counts[part / 3] += u64::from(fraction > 0.0 && fraction < 1.0);
            }
        }
        assert_eq!([report.cut_edges, report.cut_faces], counts, "seed {seed}");
        assert_eq!(report.enlarged_faces, 0);
        n_cut += counts[0];
        n_graded += usize::from(lines.is_graded());
    }
    assert!(n_cut > 3000 && n_graded > 30, "{n_cut} cut edges, {n_graded} graded");
}

/// A ball of vacuum in a block of metal.
fn cavity(stable: f64, random: &mut Random) -> (Vec<Facets>, Job) {
    let mut shift = || random.below(1 << 12) as f32 / 4096.0;
    let ball = models::sphere([5.0 + shift(), 5.0 + shift(), 5.0 + shift()], 4.2, 17);
    let cuboids = vec![models::cuboid([-2.0; 3], [14.0; 3]), ball];
    let material = set!(Material { pec: true, ..Material::default() });
    let geometries = vec![set!(GeometryJob { material, ..GeometryJob::default() }), GeometryJob::default()];
    let conformal = set!(ConformalJob { stable, ..ConformalJob::default() });
    let lines: Vec<f64> = (0..=11).map(f64::from).collect();
    let lines = LinesJob { x: lines.clone(), y: lines.clone(), z: lines };
    (cuboids, set!(Job { geometries, lines: Some(lines), conformal: Some(conformal), ..Job::default() }))
}

/// The longest edge of a face across an axis, in fractions.
fn longest(edges: &[Vec<f64>; 3], axis: usize, face: [usize; 3], n: usize) -> f64 {
    let mut longest: f64 = 0.0;
    for (along, across) in [((axis + 1) % 3, (axis + 2) % 3), ((axis + 2) % 3, (axis + 1) % 3)] {
        for end in 0..2 {
            let mut place = face;
            place[across] += end;
            let dims = [0, 1, 2].map(|of| if of == along { n } else { n + 1 });
            longest = longest.max(edges[along][place[0] + dims[0] * (place[1] + dims[1] * place[2])]);
        }
    }
    longest
}

#[test]
fn faces_that_are_enlarged_take_it_from_those_beside_them() {
    let mut n_unbalanced = 0;
    for seed in 0..8 {
        let areas_and_edges = |stable: f64| {
            let (bodies, job) = cavity(stable, &mut Random::new(seed));
            let (found, report, _) = conformal(&bodies, &job);
            let [edges, areas] = [0, 3].map(|first| [0, 1, 2].map(|axis| all(&found, first + axis)));
            (areas, edges, report)
        };
        let (exact, ..) = areas_and_edges(0.0);
        for stable in [0.125, 0.25] {
            let (areas, edges, report) = areas_and_edges(stable);
            let mut n_enlarged = 0;
            for axis in 0..3 {
                let dims = [0, 1, 2].map(|of| if of == axis { 12 } else { 11 });
                for (index, (&area, &was)) in areas[axis].iter().zip(&exact[axis]).enumerate() {
                    let face = [index % dims[0], index / dims[0] % dims[1], index / (dims[0] * dims[1])];
                    let least = stable * longest(&edges, axis, face, 11);
                    assert!(was == 0.0 || area >= least - 1e-15, "seed {seed}: {face:?} across {axis} has {area}");
                    n_enlarged += u64::from(area > was);
                }
                let [sum, before] = [&areas[axis], &exact[axis]].map(|areas| areas.iter().sum::<f64>());
                let is_off = (sum - before).abs() > 1e-12 * before;
                assert!(!is_off || report.unbalanced_faces > 0, "seed {seed}: {sum} in place of {before}");
            }
            n_unbalanced += report.unbalanced_faces;
            assert_eq!(report.enlarged_faces, n_enlarged, "seed {seed}");
            assert!(n_enlarged > 50, "seed {seed}: {n_enlarged}");
        }
    }
    assert!(n_unbalanced < 10, "{n_unbalanced} faces lack something");
}

/// A field on a grid of equal cells that begins by chance, after so many steps of Yee's scheme with these edges and faces: its largest value.
fn largest_after(found: &Conformal, n: usize, (courant, steps): (f64, usize), random: &mut Random) -> f64 {
    let [edges, areas] = [0, 3].map(|first| [0, 1, 2].map(|axis| all(found, first + axis)));
    let dims = |axis: usize, along: usize, adds: usize| if axis == along { n + adds } else { n + 1 - adds };
    let index =
        |along: usize, adds: usize, [x, y, z]: [usize; 3]| x + dims(0, along, adds) * (y + dims(1, along, adds) * z);
    let mut electric = [0, 1, 2].map(|axis: usize| {
        let by_chance = |length: &f64| if *length > 0.0 { random.below(2001) as f64 / 1000.0 - 1.0 } else { 0.0 };
        edges[axis].iter().map(by_chance).collect::<Vec<f64>>()
    });
    let mut magnetic = areas.each_ref().map(|areas| vec![0.0; areas.len()]);
    let moved = |place: [usize; 3], axis: usize| [0, 1, 2].map(|of| place[of] + usize::from(of == axis));
    for _ in 0..steps {
        for axis in 0..3 {
            let [one, other] = [(axis + 1) % 3, (axis + 2) % 3];
            for z in 0..dims(2, axis, 1) {
                for y in 0..dims(1, axis, 1) {
                    for x in 0..dims(0, axis, 1) {
                        let place = [x, y, z];
                        let at = index(axis, 1, place);
                        if areas[axis][at] > 0.0 {
                            let of = |along: usize, place: [usize; 3]| {
                                let edge = index(along, 0, place);
                                electric[along][edge] * edges[along][edge]
                            };
                            let around = of(other, moved(place, one)) - of(other, place) - of(one, moved(place, other))
                                + of(one, place);
                            magnetic[axis][at] -= courant * around / areas[axis][at];
                        }
                    }
                }
            }
        }
        for axis in 0..3 {
            let [one, other] = [(axis + 1) % 3, (axis + 2) % 3];
            for z in 0..dims(2, axis, 0) {
                for y in 0..dims(1, axis, 0) {
                    for x in 0..dims(0, axis, 0) {
                        let place = [x, y, z];
                        let at = index(axis, 0, place);
                        let is_inner = place[one] > 0 && place[other] > 0 && place[one] < n && place[other] < n;
                        if is_inner && edges[axis][at] > 0.0 {
                            let of = |along: usize, place: [usize; 3]| magnetic[along][index(along, 1, place)];
                            let before = |across: usize| [0, 1, 2].map(|of| place[of] - usize::from(of == across));
                            electric[axis][at] += courant
                                * (of(other, place) - of(other, before(one)) - of(one, place) + of(one, before(other)));
                        }
                    }
                }
            }
        }
    }
    electric.iter().flatten().fold(0.0, |most: f64, of| most.max(of.abs()))
}

#[test]
fn fields_stay_at_the_step_that_is_reported_and_grow_beyond_it() {
    for (stable, least, most) in [(0.0, 0.0, 0.6), (0.125, 0.65, 0.8), (0.25, 0.85, 1.0)] {
        let (bodies, job) = cavity(stable, &mut Random::new(3));
        let (found, report, _) = conformal(&bodies, &job);
        let factor = report.dt_factor;
        assert!(factor > least && factor < most, "stable {stable}: {factor}");
        let after = |courant: f64| largest_after(&found, 11, (courant / 3f64.sqrt(), 1500), &mut Random::new(7));
        let [within, beyond] = [factor, 1.03 * factor].map(after);
        assert!(within < 200.0, "stable {stable}: {within} at {factor}");
        assert!(beyond > 1e6 || beyond.is_nan(), "stable {stable}: {beyond} beyond {factor}");
    }
}

#[test]
fn windows_have_the_numbers_of_the_whole() {
    for seed in 150_000..150_030 {
        let mut random = Random::new(seed);
        let (bodies, job) = match seed % 2 {
            0 => cavity(0.25, &mut random),
            _ => {
                let mut cuboids: Vec<Cuboid> = (0..3).map(|_| random_cuboid(&mut random)).collect();
                cuboids[2].is_metal = true;
                let job = job_of(&cuboids, 0.25, seed % 3 == 0, &mut random);
                (cuboids.iter().map(Cuboid::facets).collect(), job)
            }
        };
        let (whole, of_whole, lines) = conformal(&bodies, &job);
        let dims = lines.dims();
        let cuts = dims.map(|n| [0, random.between(1, n as i32 - 1) as u32, n]);
        let (mut counts, mut least) = ([0; 4], f64::INFINITY);
        for window in 0..8 {
            let ends = [0, 1, 2].map(|axis| [cuts[axis][window >> axis & 1], cuts[axis][(window >> axis & 1) + 1]]);
            let [first, end] = [0, 1].map(|of| ends.map(|ends| ends[of]));
            let asked = [first[0], first[1], first[2], end[0], end[1], end[2]];
            let (found, report, _) = conformal(&bodies, &set!(Job { window: Some(asked), ..job.clone() }));
            assert_eq!(found.origin, first);
            for (part, (name, is_on_line)) in PARTS.iter().enumerate() {
                let some = [0, 1, 2].map(|axis| first[axis]..end[axis] + u32::from(is_on_line[axis]));
                let expected = whole.parts[part].fractions(&some).unwrap();
                assert!(all(&found, part) == expected, "seed {seed}: {name} from {first:?} to {end:?}");
            }
            let of_window = [report.cut_edges, report.cut_faces, report.enlarged_faces, report.unbalanced_faces];
            counts = [0, 1, 2, 3].map(|of: usize| counts[of] + of_window[of]);
            least = least.min(report.dt_factor);
        }
        let ConformalReport { cut_edges, cut_faces, enlarged_faces, unbalanced_faces, .. } = of_whole;
        assert_eq!(counts, [cut_edges, cut_faces, enlarged_faces, unbalanced_faces], "seed {seed}");
        assert!((least / of_whole.dt_factor - 1.0).abs() < 0.01, "seed {seed}: {least}, not {}", of_whole.dt_factor);
    }
}

#[test]
fn sheets_have_no_area_and_no_edges() {
    let plate = models::cuboid([2.0, 2.25, 3.0], [6.0, 5.5, 3.0]);
    let material = set!(Material { pec: true, ..Material::default() });
    let geometries = vec![set!(GeometryJob { material, ..GeometryJob::default() })];
    let lines: Vec<f64> = (0..=8).map(f64::from).collect();
    let lines = LinesJob { x: lines.clone(), y: lines.clone(), z: lines };
    let job = set!(Job {
        geometries,
        lines: Some(lines),
        conformal: Some(ConformalJob::default()),
        staggered: true,
        ..Job::default()
    });
    let (mesh, facts) = meshed(std::slice::from_ref(&plate), &job, 0, &mut Engine::cpu()).unwrap();
    let (found, staggered) = (facts.conformal.unwrap(), facts.staggered.unwrap());
    assert!(staggered.sheets.len() > 8);
    let closed = |part: usize| all(&found, part).iter().filter(|of| **of == 0.0).count();
    assert_eq!(closed(5), staggered.sheets.len());
    assert_eq!([closed(2), closed(3), closed(4)], [0; 3]);
    for (part, points) in staggered.points.iter().take(3).enumerate() {
        let conducts = points.flags(&points.dims().map(|n| 0..n)).unwrap();
        let has_none: Vec<u8> = all(&found, part).iter().map(|of| u8::from(*of == 0.0)).collect();
        assert_eq!(has_none, conducts, "{}", points.name);
    }
    assert_eq!((mesh.dims(), found.dt_factor), ([8; 3], 1.0));
}

#[test]
fn reports_of_parts_add_up_to_that_of_the_whole() {
    let folder = Folder::new();
    let (out, metal) = (folder.path("c.npz"), format!("{SPOT}:pec=true"));
    let mesh = ["mesh", &metal, "--cells", "24", "--backend", "cpu", "--json", "--unit", "mm", "--conformal", &out];
    let mut whole = json(&mesh)["conformal"].take();
    let names: Vec<String> = (1..=6).map(|part| folder.path(&format!("{part}.json"))).collect();
    for (part, name) in (1..).zip(&names) {
        let report = json(&[&mesh[..], &["--part", &format!("{part}/3x2x1")]].concat());
        std::fs::write(name, report.to_string()).unwrap();
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut merged = json(&[&["merge"], &names[..]].concat())["conformal"].take();
    // the faces of a part know a little less of the fields beside them
    for key in ["dt_factor", "dt"] {
        let [step, of_parts] = [&mut whole, &mut merged].map(|of| of[key].take().as_f64().unwrap());
        assert!((of_parts / step - 1.0).abs() < 0.01, "{key}: {of_parts}, not {step}");
    }
    assert_eq!(merged, whole);
}

#[test]
fn what_cannot_be_measured_is_said_with_a_remedy() {
    let folder = Folder::new();
    let out = folder.path("c.npz");
    let refused = |arguments: &[&str]| {
        let all = [&["mesh"], arguments, &["--cells", "12", "--backend", "cpu"]].concat();
        let output = hexcast(&all);
        assert!(!output.status.success(), "{arguments:?} succeeds");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let metal = format!("{SPOT}:pec=true");
    let cases: [(&[&str], &str); 6] = [
        (&[SPOT, "--conformal", &out], "no flag is metal"),
        (&[SPOT, "--conformal", &out, "--metal", "7"], "no geometry has flag 7"),
        (&[&metal, "--conformal", &out, "--stable", "2"], "conformal.stable is 2; allowed: 0 to 1"),
        (&[&metal, "--conformal", &folder.path("c.txt")], "edges and faces outside metal are written as .npz"),
        (&[&metal, "--conformal", &out, "--close-gaps", "3"], "conformal is given with close_gaps"),
        (&[&metal, "--conformal", &out, "--part", "1/2", "--halo", "1"], "conformal is given with a halo"),
    ];
    for (arguments, expected) in cases {
        let said = refused(arguments);
        assert!(said.contains(expected), "{arguments:?}: {said}");
    }
    let report =
        json(&["mesh", &metal, "--cells", "12", "--backend", "cpu", "--conformal", &out, "--unit", "mm", "--json"]);
    let of = &report["conformal"];
    assert!(of["cut_edges"].as_u64() > Some(100) && of["dt"].as_f64() > Some(0.0), "{of}");
}
