//! Staggered grids against an oracle in big integers: winding numbers at edges and faces, links from centre to centre across sheets.

use std::collections::BTreeSet;

use hexcast::geometry::Geometry;
use hexcast::job::{Fill, GeometryJob, Job, LinesJob, Rule};
use hexcast::lines::Lines;
use hexcast::pipeline::Engine;
use hexcast::staggered::{COMPONENTS, SheetFace, Staggered};
use num_bigint::BigInt;

use super::models::{self, Facets};
use super::open_surfaces::{Exact, crossed, flags_of, meshed, without};
use super::oracle;
use super::soups::Random;

fn staggered(bodies: &[Facets], job: &Job, axis: usize, engine: &mut Engine) -> (Staggered, Lines, Vec<u8>) {
    let (mesh, facts) = meshed(bodies, job, axis, engine).unwrap();
    let report = facts.staggered_report.expect("it was asked for");
    let staggered = facts.staggered.expect("it was asked for");
    assert_eq!(report.sheet_faces, staggered.sheets.len() as u64);
    assert_eq!(report.components.len(), staggered.points.len());
    for (component, points) in report.components.iter().zip(&staggered.points) {
        let flags = all(&staggered, &component.name);
        assert_eq!((&component.name[..], component.dims), (points.name, points.dims()));
        for of in &component.flags {
            let n = flags.iter().filter(|flag| **flag == of.flag).count() as u64;
            assert_eq!(of.points, n, "{} of flag {}", component.name, of.flag);
            assert!(n > 0, "{} has no point of flag {}", component.name, of.flag);
        }
        assert_eq!(component.flags.iter().map(|of| of.points).sum::<u64>(), flags.len() as u64);
    }
    let flags = flags_of(&mesh);
    (staggered, mesh.lines().clone(), flags)
}

/// Flags at all points of a component.
fn all(staggered: &Staggered, name: &str) -> Vec<u8> {
    let points = staggered.points.iter().find(|points| points.name == name).expect("a component");
    points.flags(&points.dims().map(|n| 0..n)).unwrap()
}

fn job(graded: bool, random: &mut Random) -> Job {
    let mut list = |n: u32| {
        let size = |random: &mut Random| if graded { 0.25 * (1 + random.below(8)) as f64 } else { 1.0 };
        let mut lines = vec![-0.5];
        (0..n).for_each(|_| lines.push(lines[lines.len() - 1] + size(random)));
        lines
    };
    let (x, y, z) = (list(8), list(9), list(7));
    set!(Job { lines: Some(LinesJob { x, y, z }), staggered: true, ..Job::default() })
}

/// A closed body of coordinates on lines, on centres and anywhere.
fn body(random: &mut Random) -> Facets {
    let kind = random.below(4);
    let mut place = || match random.below(3) {
        0 => random.below(14) as f32 * 0.5,
        _ => random.below(1 << 16) as f32 / 8192.0 - 0.5,
    };
    match kind {
        0 => models::tetrahedron(std::array::from_fn(|_| std::array::from_fn(|_| place()))),
        1 => models::octahedron([place(), 1.0, 0.5], [7.5, place(), 7.0]),
        2 => models::cuboid([1.0, 1.5, 0.25 * place()], [2.0 + 0.5 * place(), 6.5, 5.5]),
        _ => models::sphere([0.25 * place() + 2.0, 3.0, 3.0], 2.6, 7),
    }
}

#[test]
fn points_have_the_flags_that_winding_numbers_give_them() {
    let (mut n_inside, mut n_graded) = (0, 0);
    for seed in 100_000..100_120 {
        let mut random = Random::new(seed);
        let bodies = vec![body(&mut random), body(&mut random)];
        let rule = [Rule::Parity, Rule::Nonzero][seed as usize % 2];
        let priorities = [random.below(2) as i32, 0];
        let geometries = priorities.map(|priority| set!(GeometryJob { priority, ..GeometryJob::default() })).to_vec();
        let job = set!(Job { geometries, rule, ..job(seed % 3 > 0, &mut random) });
        let (found, lines, _) = staggered(&bodies, &job, seed as usize % 3, &mut Engine::cpu());
        n_graded += usize::from(lines.is_graded());
        let geometry = |index: usize| {
            set!(Geometry {
                priority: priorities[index],
                ..Geometry::new("g", index as u8 + 1, bodies[index].clone()).unwrap()
            })
        };
        let geometries: Vec<Geometry> = (0..2).map(geometry).collect();
        if !oracle::is_closed(&geometries, &lines, rule) {
            continue;
        }
        // a body in one plane is a sheet
        let is_flat = bodies
            .iter()
            .any(|body| (0..3).any(|axis| body.iter().flatten().all(|corner| corner[axis] == body[0][0][axis])));
        if is_flat {
            continue;
        }
        assert!(found.sheets.is_empty(), "seed {seed}");
        for (name, at_faces) in COMPONENTS {
            let flags = all(&found, name);
            assert!(flags == oracle::flags_around(&geometries, &lines, rule, at_faces), "seed {seed}: {name}");
            n_inside += flags.iter().filter(|flag| **flag != 0).count();
        }
    }
    assert!(n_graded > 30 && n_inside > 10_000, "{n_graded} graded, {n_inside} points inside");
}

/// The faces that a surface crosses: link by link, facet by facet.
fn crossed_faces(facets: &[[Exact; 3]], lines: &Lines, bits: u64) -> Vec<(u8, [u32; 3])> {
    let [centres, faces] = [oracle::centres, oracle::faces].map(|of| [0, 1, 2].map(|axis| of(lines, axis, bits)));
    let exact: Vec<[Exact; 3]> =
        facets.iter().map(|facet| facet.each_ref().map(|corner| corner.each_ref().map(|c| c << 200u32))).collect();
    let mut found = Vec::new();
    for axis in 0..3 {
        let mut dims = lines.dims();
        dims[axis] += 1;
        let n = dims[axis] as usize - 1;
        // with the mirror images of the first and the last
        let mut along = centres[axis].clone();
        along.insert(0, &faces[axis][0] * 2 - &centres[axis][0]);
        along.push(&faces[axis][n] * 2 - &centres[axis][n - 1]);
        for (z, y) in (0..dims[2]).flat_map(|z| (0..dims[1]).map(move |y| (z, y))) {
            for x in 0..dims[0] {
                let face = [x, y, z];
                let end = |behind: usize| -> Exact {
                    std::array::from_fn(|of| {
                        let at = face[of] as usize;
                        let place = if of == axis { &along[at + behind] } else { &centres[of][at] };
                        (place << 200u32) - (BigInt::from(1) << [130u32, 65, 0][of])
                    })
                };
                let ends = [end(0), end(1)];
                let is_crossed = |facet: &[Exact; 3]| {
                    let [from, to] = ends.each_ref().map(|end| crossed(std::slice::from_ref(facet), end, axis).0);
                    from != to
                };
                if exact.iter().any(is_crossed) {
                    found.push((axis as u8, face));
                }
            }
        }
    }
    found
}

/// A sheet: a plate across an axis on a line, on centres or anywhere, or a surface with an edge, which must be called a shell.
fn sheet(kind: u64, random: &mut Random) -> (Facets, GeometryJob) {
    let at = [0.5, 2.0, 3.3, -0.5, 1.75, 0.0][random.below(6) as usize];
    let plate = [[1.0, 1.25, at], [6.0, 1.25, at], [6.0, 5.5, at], [1.0, 5.5, at]];
    match kind {
        axis @ 0..3 => {
            let turn = |corner: [f32; 3]| std::array::from_fn(|of| corner[(of + 2 - axis as usize) % 3]);
            let [a, b, c, d] = plate.map(turn);
            (vec![[a, b, c], [a, c, d]], GeometryJob::default())
        }
        _ => {
            let fill = Some([Fill::Separating, Fill::Conservative][kind as usize % 2]);
            let facets = without(&models::sphere([3.0, 3.25, 2.5], 2.4, 8), 0.4, kind);
            (facets, set!(GeometryJob { fill, shell: true, ..GeometryJob::default() }))
        }
    }
}

#[test]
fn sheets_are_the_faces_whose_links_they_cross_and_their_edges_have_their_flag() {
    let (mut n_faces, mut n_hidden) = (0, 0);
    for seed in 0..40 {
        let mut random = Random::new(1000 + seed);
        let (facets, shell) = sheet(seed % 5, &mut random);
        let solid = models::cuboid([2.0, 2.25, 1.25], [7.25, 4.0, 9.0]);
        let of_solid = set!(GeometryJob { priority: [1, -1][seed as usize % 2], ..GeometryJob::default() });
        let geometries = vec![shell, of_solid];
        let job = set!(Job { geometries, ..job(seed % 3 > 0, &mut random) });
        let bodies = [facets.clone(), solid.clone()];
        let (found, lines, _) = staggered(&bodies, &job, seed as usize % 3, &mut Engine::cpu());
        let geometries = [Geometry::new("s", 1, facets).unwrap(), Geometry::new("b", 2, solid).unwrap()];
        let (snapped, _) = oracle::snapped_all(&geometries, &lines);
        let all_facets =
            [Geometry::new("all", 1, geometries.iter().flat_map(|of| of.facets.slice().to_vec()).collect::<Facets>())
                .unwrap()];
        let bits = oracle::snapped_facets(&all_facets[0], &lines).1;
        let inside =
            COMPONENTS.map(|(_, at)| oracle::insides_around(&geometries, &lines, Rule::Parity, at).swap_remove(1));
        let index = |[x, y, z]: [u32; 3], component: usize| {
            let [nx, ny, _] = found.points[component].dims();
            (x + nx * (y + ny * z)) as usize
        };
        // the solid has flag 2; where it is above, it hides the sheet
        let is_above = seed % 2 == 0;
        let every = crossed_faces(&snapped[0], &lines, bits);
        let is_hidden = |&(axis, face): &(u8, [u32; 3])| {
            is_above && inside[3 + usize::from(axis)][index(face, 3 + usize::from(axis))]
        };
        let expected: Vec<SheetFace> =
            every.iter().filter(|of| !is_hidden(of)).map(|&(axis, face)| SheetFace::new(axis, face, 1)).collect();
        n_hidden += every.len() - expected.len();
        n_faces += expected.len();
        assert_eq!(found.sheets, expected, "seed {seed}");
        let mut edges: BTreeSet<(usize, usize)> = BTreeSet::new();
        for SheetFace { axis, face, .. } in expected {
            for along in (0..3usize).filter(|&along| along != usize::from(axis)) {
                let across = 3 - along - usize::from(axis);
                let mut other = face;
                other[across] += 1;
                edges.extend([face, other].map(|edge| (along, index(edge, along))));
            }
        }
        for (component, (name, _)) in COMPONENTS.iter().enumerate() {
            for (at, flag) in all(&found, name).into_iter().enumerate() {
                let (is_inside, is_edge) = (inside[component][at], edges.contains(&(component, at)));
                let expected = match (is_inside, is_edge) {
                    (true, true) => 1 + u8::from(is_above),
                    (true, false) => 2,
                    (false, is_edge) => u8::from(is_edge),
                };
                assert_eq!(flag, expected, "seed {seed}: {name} {at}");
            }
        }
    }
    assert!(n_faces > 800 && n_hidden > 50, "{n_faces} faces, {n_hidden} hidden");
}

#[test]
fn boxes_on_lines_and_a_plate_have_points_that_can_be_counted() {
    let lines = || (0..=8).map(f64::from).collect::<Vec<f64>>();
    let job =
        set!(Job { lines: Some(LinesJob { x: lines(), y: lines(), z: lines() }), staggered: true, ..Job::default() });
    // 3 x 2 x 4 cells, from centre to centre along z
    let (found, _, _) = staggered(&[models::cuboid([2.0, 3.0, 1.5], [5.0, 5.0, 5.5])], &job, 0, &mut Engine::cpu());
    let n = |name: &str| all(&found, name).iter().filter(|flag| **flag != 0).count();
    // (low, high] holds as many lines as cells
    assert_eq!(["Ex", "Ey", "Ez", "Hx", "Hy", "Hz"].map(n), [24; 6]);
    assert_eq!(all(&found, "Ez")[3 + 9 * (4 + 9 * 2)], 1);
    assert_eq!(all(&found, "Ez")[2 + 9 * (4 + 9 * 2)], 0);
    // a plate on a line, 3 x 2 faces: 3 x 3 edges along x, 4 x 2 along y
    let [a, b, c, d] = [[2.0, 3.0, 4.0], [5.0, 3.0, 4.0], [5.0, 5.0, 4.0], [2.0, 5.0, 4.0]];
    let (found, _, flags) = staggered(&[vec![[a, b, c], [a, c, d]]], &job, 2, &mut Engine::cpu());
    let n = |name: &str| all(&found, name).iter().filter(|flag| **flag != 0).count();
    assert_eq!(["Ex", "Ey", "Ez", "Hx", "Hy", "Hz"].map(n), [9, 8, 0, 0, 0, 0]);
    assert!(found.sheets.iter().all(|of| of.axis == 2 && of.face[2] == 4) && found.sheets.len() == 6);
    assert!(flags.iter().all(|flag| *flag == 0));
    // inverted, it is no sheet: all is outside of it
    let inverted =
        set!(Job { geometries: vec![set!(GeometryJob { invert: true, ..GeometryJob::default() })], ..job.clone() });
    let (found, _, flags) = staggered(&[vec![[a, b, c], [a, c, d]]], &inverted, 2, &mut Engine::cpu());
    assert!(found.sheets.is_empty() && flags.iter().all(|flag| *flag == 1));
    assert!(COMPONENTS.iter().all(|(name, _)| all(&found, name).iter().all(|flag| *flag == 1)));
    // at both ends of the box, too
    for end in [0.0, 8.0] {
        let [a, b, c, d] = [a, b, c, d].map(|[x, y, _]| [x, y, end]);
        let (found, _, _) = staggered(&[vec![[a, b, c], [a, c, d]]], &job, 1, &mut Engine::cpu());
        assert!(found.sheets.iter().all(|of| of.face[2] == end as u32) && found.sheets.len() == 6, "{end}");
    }
}

/// What the points of E have where some flags conduct, by the cells around each; of those that conduct the one of the last geometry wins.
fn conducting(
    flags: &[u8],
    [nx, ny, nz]: [usize; 3],
    along: usize,
    [x, y, z]: [usize; 3],
    conductors: &[u8],
) -> Option<u8> {
    let (mut best, place) = (None, [x, y, z]);
    for (i, j) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let mut cell = place.map(|at| at as isize);
        cell[(along + 1) % 3] -= i;
        cell[(along + 2) % 3] -= j;
        let n = [nx, ny, nz];
        if (0..3).all(|axis| (0..n[axis] as isize).contains(&cell[axis])) {
            let [x, y, z] = cell.map(|at| at as usize);
            best = best.max(Some(flags[x + nx * (y + ny * z)]).filter(|flag| conductors.contains(flag)));
        }
    }
    best
}

#[test]
fn all_edges_of_the_cells_of_conductors_conduct() {
    let (mut n_more, mut n_all) = (0, 0);
    for seed in 0..30 {
        let mut random = Random::new(5000 + seed);
        let bodies = vec![body(&mut random), body(&mut random), body(&mut random)];
        let conductors = [vec![1], vec![1, 3], vec![2, 3]][seed as usize % 3].clone();
        let plain = job(seed % 2 > 0, &mut random);
        let asked = set!(Job { conductors: conductors.clone(), ..plain.clone() });
        let (found, _, flags) = staggered(&bodies, &asked, seed as usize % 3, &mut Engine::cpu());
        let (by_points, lines, _) = staggered(&bodies, &plain, 0, &mut Engine::cpu());
        let n = lines.dims().map(|n| n as usize);
        for (along, (name, _)) in COMPONENTS.iter().enumerate() {
            let (all_flags, without) = (all(&found, name), all(&by_points, name));
            let [px, py, _] = found.points[along].dims().map(|n| n as usize);
            for (index, (flag, point)) in all_flags.iter().zip(&without).enumerate() {
                let place = [index % px, index / px % py, index / (px * py)];
                let by_cells = match along < 3 && !conductors.contains(point) {
                    true => conducting(&flags, n, along, place, &conductors),
                    false => None,
                };
                assert_eq!(*flag, by_cells.unwrap_or(*point), "seed {seed}: {name} {place:?}");
                n_more += usize::from(flag != point);
            }
            n_all += all_flags.len();
            // any box of points has the same
            let dims = found.points[along].dims();
            let some = dims.map(|n| 1 + random.below(2) as u32..n - random.below(3) as u32);
            let of_box = found.points[along].flags(&some).unwrap();
            let mut index = 0;
            for (z, y) in some[2].clone().flat_map(|z| some[1].clone().map(move |y| (z, y))) {
                for x in some[0].clone() {
                    let at = x as usize + dims[0] as usize * (y as usize + dims[1] as usize * z as usize);
                    assert_eq!(of_box[index], all_flags[at], "seed {seed}: {name}");
                    index += 1;
                }
            }
        }
        // points of a window are those of the box, also beside cells that are not in it
        let window = [2, 1, 3, 6, 7, 7];
        let (part, _) = meshed(&bodies, &set!(Job { window: Some(window), ..asked }), 1, &mut Engine::cpu()).unwrap();
        assert_eq!(part.dims(), [4, 6, 4]);
        let facts =
            meshed(&bodies, &set!(Job { window: Some(window), conductors, ..plain }), 1, &mut Engine::cpu()).unwrap().1;
        let part = facts.staggered.unwrap();
        for (of_part, of_box) in part.points.iter().zip(&found.points) {
            let n = of_part.dims();
            let cells = [0, 1, 2].map(|axis| window[axis]..window[axis] + n[axis]);
            assert!(all(&part, of_part.name) == of_box.flags(&cells).unwrap(), "seed {seed}: {}", of_part.name);
        }
    }
    assert!(n_more > 1000, "{n_more} of {n_all} points conduct by their cells alone");
}

#[test]
fn a_wall_whose_cells_conduct_lies_where_its_surface_does_on_average() {
    let lines = || (0..=10).map(f64::from).collect::<Vec<f64>>();
    let mut random = Random::new(77);
    let mut off = [0.0; 2];
    for place in 0..60 {
        // anywhere in three cells
        let wall = 3.0 + (f64::from(place) + random.below(1000) as f64 / 1000.0) / 20.0;
        let body = models::cuboid([-1.0; 3], [wall as f32, 11.0, 11.0]);
        for (off, conductors) in off.iter_mut().zip([vec![], vec![1]]) {
            let lines = Some(LinesJob { x: lines(), y: lines(), z: lines() });
            let job = set!(Job { lines, staggered: true, conductors, ..Job::default() });
            let (found, ..) = staggered(std::slice::from_ref(&body), &job, 0, &mut Engine::cpu());
            let row = found.points[1].flags(&[0..11, 5..6, 5..6]).unwrap();
            let last = row.iter().rposition(|flag| *flag == 1).expect("metal");
            *off += (last as f64 - wall) / 60.0;
        }
    }
    // at the points alone half a cell is missing
    assert!((-0.6..-0.4).contains(&off[0]), "{off:?}");
    assert!(off[1].abs() < 0.1, "{off:?}");
}

#[test]
fn perfect_conductors_that_are_not_named_are_said() {
    let lines = || (0..=8).map(f64::from).collect::<Vec<f64>>();
    let bodies = [models::cuboid([1.0; 3], [3.0; 3]), models::cuboid([4.0; 3], [7.0; 3])];
    let mut geometries = vec![GeometryJob::default(), GeometryJob::default()];
    geometries[1].material.pec = true;
    let lines = Some(LinesJob { x: lines(), y: lines(), z: lines() });
    let job = set!(Job { geometries, lines, staggered: true, ..Job::default() });
    let found = |job: &Job| {
        let (_, facts) = meshed(&bodies, job, 0, &mut Engine::cpu()).unwrap();
        let said = facts.findings.into_iter().filter(|finding| finding.code == "conductor-thin");
        said.map(|finding| finding.remedies[0].option.clone().expect("an option")).collect::<Vec<String>>()
    };
    assert_eq!(found(&job), ["--conductors 2"]);
    assert_eq!(found(&set!(Job { conductors: vec![1], ..job.clone() })), ["--conductors 1,2"]);
    assert!(found(&set!(Job { conductors: vec![2], ..job.clone() })).is_empty());
    assert!(found(&set!(Job { staggered: false, ..job })).is_empty());
}

#[cfg(feature = "gpu")]
#[test]
fn a_gpu_finds_the_same_points() {
    use hexcast::job::BackendChoice;
    let mut gpu = pollster::block_on(Engine::open(BackendChoice::Gpu, None)).unwrap();
    let bodies = [models::torus([3.5; 3], [2.2, 1.0], 16), without(&models::sphere([3.0; 3], 2.4, 10), 0.1, 3)];
    let (plate, _) = sheet(2, &mut Random::new(5));
    let bodies = [&bodies[..], &[plate]].concat();
    for axis in 0..3 {
        let job = job(false, &mut Random::new(1));
        let [one, other] = [&mut Engine::cpu(), &mut gpu].map(|engine| staggered(&bodies, &job, axis, engine).0);
        assert_eq!(one.sheets, other.sheets);
        for (name, _) in COMPONENTS {
            assert!(all(&one, name) == all(&other, name), "{name}, rays along {axis}");
        }
    }
}

#[test]
fn what_has_no_staggered_grid_is_refused() {
    let whole = set!(Job { geometries: vec![GeometryJob::new("a.stl")], staggered: true, ..Job::default() });
    for job in [
        set!(Job { window: Some([0, 0, 0, 1, 1, 1]), halo: Some(1), ..whole.clone() }),
        set!(Job { part: Some(hexcast::job::PartJob::new(1, [2, 1, 1])), halo: Some(2), ..whole.clone() }),
        set!(Job { close_gaps: Some(3), ..whole.clone() }),
        set!(Job { conductors: vec![1], staggered: false, ..whole.clone() }),
    ] {
        assert_eq!(job.validate().unwrap_err().code(), "job-conflict");
    }
    assert_eq!(set!(Job { conductors: vec![0, 1], ..whole }).validate().unwrap_err().code(), "job-value");
}
