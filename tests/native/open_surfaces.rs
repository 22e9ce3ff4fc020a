//! Surfaces with holes: every cell against the definition, computed another way, and the laws that hold for all.
//!
//! The definition: rays of three axes, counted in big integers against every facet, also those that are missing; where they are not all even, or do not
//! agree, the solid angle of all facets at the centre, and of the triangles that close small holes, summed in f64.

use hexcast::control::Control;
use hexcast::geometry::{Facet, Geometry};
use hexcast::job::{AxisChoice, GeometryJob, Job, LinesJob, Open, Rule};
use hexcast::lines::Lines;
use hexcast::mesh::Mesh;
use hexcast::pipeline::{self, Engine, MeshOptions};
use hexcast::read::{Contents, read_bytes};
use hexcast::report::MeshFacts;
use hexcast::sources::Source;
use num_bigint::{BigInt, Sign};

use super::hole_oracle::closing;
use super::models::{self, Facets};
use super::oracle;
use super::soups::Random;

const ONE: &str =
    "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid\n";

/// Meshes facets, a geometry each, with the settings of those of the job.
pub(crate) fn meshed(
    parts: &[Facets],
    job: &Job,
    axis: usize,
    engine: &mut Engine,
) -> hexcast::Result<(Mesh, MeshFacts)> {
    let axis = [AxisChoice::X, AxisChoice::Y, AxisChoice::Z][axis];
    let given = |index: usize| job.geometries.get(index).cloned().unwrap_or_default();
    let geometries =
        (0..parts.len()).map(|index| set!(GeometryJob { file: format!("{index}.stl"), ..given(index) })).collect();
    let job = set!(Job { geometries, axis, ..job.clone() });
    let source = |(index, facets): (usize, &Facets)| Source::new(format!("{index}.stl"), contents(facets), None);
    let sources = parts.iter().enumerate().map(source).collect();
    let options = MeshOptions::default().with_doubt_mask(true);
    pollster::block_on(pipeline::mesh(&job, sources, &options, engine, &Control::default()))
}

fn contents(facets: &Facets) -> Contents {
    let mut contents = read_bytes(ONE.as_bytes()).expect("it is ASCII");
    contents.solids[0].facets = facets.clone().into();
    contents
}

pub(crate) fn flags_of(mesh: &Mesh) -> Vec<u8> {
    mesh.box_flags(&mesh.dims().map(|n| 0..n)).expect("columns in memory")
}

pub(crate) fn without(facets: &[Facet], share: f64, seed: u64) -> Facets {
    let mut random = Random::new(seed);
    facets.iter().filter(|_| random.below(1 << 20) as f64 >= share * f64::from(1 << 20)).copied().collect()
}

/// What decides a cell.
#[derive(Debug, PartialEq)]
pub(crate) enum Expected {
    Sure(bool),
    ByWinding(bool),
    /// The winding number is too near to a half for f64.
    Open,
}

/// A point or corner in units of 2^-200 of the snap, so that a centre can stand before itself by three very different lengths.
pub(crate) type Exact = [BigInt; 3];

/// A geometry by the definition.
pub(crate) struct Definition {
    rule: Rule,
    /// Facets, those that are missing, and those that close other small holes.
    exact: Vec<[Exact; 3]>,
    placed: Vec<[[f64; 3]; 3]>,
    /// Those that rays meet come first.
    n_met: usize,
    /// Lengths of a unit of the snap, and of the smallest cell along x.
    ratio: [f64; 3],
    smallest: f64,
    bits: u64,
}

fn number(c: &BigInt) -> f64 {
    i64::try_from(c).expect("26 bits") as f64
}

impl Definition {
    pub(crate) fn new(facets: &Facets, lines: &Lines, rule: Rule) -> Definition {
        let geometry = Geometry::new("g", 1, facets.clone()).unwrap();
        let (mut snapped, bits) = oracle::snapped_facets(&geometry, lines);
        let ratio: [f64; 3] = std::array::from_fn(|axis| lines.smallest()[axis] / f64::from(1u32 << bits));
        let (missing, patches) = closing(&snapped, ratio);
        snapped.extend(missing);
        // rays do not meet what closes the other holes
        let n_met = snapped.len();
        snapped.extend(patches);
        let exact: Vec<[Exact; 3]> =
            snapped.iter().map(|facet| facet.each_ref().map(|corner| corner.each_ref().map(|c| c << 200u32))).collect();
        let placed: Vec<[[f64; 3]; 3]> = snapped
            .iter()
            .map(|facet| facet.each_ref().map(|corner| std::array::from_fn(|axis| number(&corner[axis]) * ratio[axis])))
            .collect();
        Definition { rule, exact, placed, n_met, ratio, smallest: lines.smallest()[0], bits }
    }

    /// What decides a place, in units of the snap.
    pub(crate) fn at(&self, place: &Exact) -> Expected {
        let Definition { rule, exact, placed, n_met, ratio, smallest, .. } = self;
        let before = [130u32, 65, 0].map(|power| BigInt::from(1) << power);
        let point: Exact = std::array::from_fn(|axis| (&place[axis] << 200u32) - &before[axis]);
        let rays: Vec<(i64, i64)> = (0..3).map(|axis| crossed(&exact[..*n_met], &point, axis)).collect();
        let is_even = |&(below, above): &(i64, i64)| match rule {
            Rule::Parity => (below + above) % 2 == 0,
            Rule::Nonzero => below + above == 0,
        };
        let is_inside = |&(below, _): &(i64, i64)| if *rule == Rule::Parity { below % 2 != 0 } else { below != 0 };
        let insides: Vec<bool> = rays.iter().map(is_inside).collect();
        if rays.iter().all(is_even) && insides.iter().all(|&inside| inside == insides[0]) {
            return Expected::Sure(insides[0]);
        }
        let at: [f64; 3] = std::array::from_fn(|axis| (number(&place[axis]) - [0.3, 0.2, 0.1][axis]) * ratio[axis]);
        // the angle jumps where the centre passes a facet: there the side is exact
        let angle = |(facet, exact): (&[[f64; 3]; 3], &[Exact; 3])| {
            let angle = solid_angle(facet, at);
            let is_turned = angle.abs() > std::f64::consts::PI && (angle > 0.0) != is_behind(exact, &point);
            if is_turned { -angle } else { angle }
        };
        let sum: f64 = placed.iter().zip(exact).map(angle).sum();
        let winding = sum / (4.0 * std::f64::consts::PI);
        let whole = winding.round();
        // on an edge the angle may be anything
        let is_at_edge = placed.iter().any(|facet| distance_to_edges(facet, at) < 1e-4 * smallest);
        if ((winding - whole).abs() - 0.5).abs() < 1e-4 || is_at_edge {
            Expected::Open
        } else if *rule == Rule::Parity {
            Expected::ByWinding(whole.rem_euclid(2.0) == 1.0)
        } else {
            Expected::ByWinding(whole != 0.0)
        }
    }
}

/// Cells of one geometry, by the definition.
fn expected(facets: &Facets, lines: &Lines, rule: Rule, fill: impl Fn([u32; 3], Expected)) {
    let definition = Definition::new(facets, lines, rule);
    let centres = [0, 1, 2].map(|axis| oracle::centres(lines, axis, definition.bits));
    let [nx, ny, nz] = lines.dims();
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                let centre: Exact = std::array::from_fn(|axis| centres[axis][[x, y, z][axis] as usize].clone());
                fill([x, y, z], definition.at(&centre));
            }
        }
    }
}

fn distance_to_edges(facet: &[[f64; 3]; 3], at: [f64; 3]) -> f64 {
    let to_edge = |k: usize| {
        let [from, to] = [facet[k], facet[(k + 1) % 3]];
        let (edge, own): ([f64; 3], [f64; 3]) =
            (std::array::from_fn(|k| to[k] - from[k]), std::array::from_fn(|k| at[k] - from[k]));
        let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
        let along = if dot(edge, edge) > 0.0 { (dot(edge, own) / dot(edge, edge)).clamp(0.0, 1.0) } else { 0.0 };
        (0..3).map(|k| (own[k] - along * edge[k]).powi(2)).sum::<f64>().sqrt()
    };
    (0..3).map(to_edge).fold(f64::INFINITY, f64::min)
}

/// Whether a facet turns its back on a point.
fn is_behind([a, b, c]: &[Exact; 3], point: &Exact) -> bool {
    let side = |from: &Exact, to: &Exact| -> Exact { std::array::from_fn(|k| &to[k] - &from[k]) };
    let (u, v, w) = (side(a, b), side(a, c), side(point, a));
    let height: BigInt = (0..3)
        .map(|k| {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            (&u[i] * &v[j] - &u[j] * &v[i]) * &w[k]
        })
        .sum();
    height.sign() == Sign::Plus
}

/// Crossings of the line through a point along an axis, before and behind it, +1 where it enters.
pub(crate) fn crossed(facets: &[[Exact; 3]], point: &Exact, axis: usize) -> (i64, i64) {
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let (mut below, mut above) = (0, 0);
    for facet in facets {
        let q: Vec<Exact> = facet.iter().map(|corner| std::array::from_fn(|k| &corner[k] - &point[k])).collect();
        let turn = |a: &Exact, b: &Exact| &a[i] * &b[j] - &a[j] * &b[i];
        let turns: Vec<BigInt> = (0..3).map(|k| turn(&q[(k + 1) % 3], &q[(k + 2) % 3])).collect();
        if turns.iter().any(|turn| turn.sign() != turns[0].sign()) || turns[0].sign() == Sign::NoSign {
            continue;
        }
        let area: BigInt = turns.iter().sum();
        let height: BigInt = turns.iter().zip(&q).map(|(turn, corner)| turn * &corner[axis]).sum();
        let is_above = height.sign() == area.sign();
        // the normal points along the axis where the turn is positive: there the line leaves
        let step = if area.sign() == Sign::Plus { -1 } else { 1 };
        if is_above { above += step } else { below += step }
    }
    (below, above)
}

pub(crate) fn solid_angle(facet: &[[f64; 3]; 3], at: [f64; 3]) -> f64 {
    let q: Vec<[f64; 3]> = facet.iter().map(|corner| std::array::from_fn(|k| corner[k] - at[k])).collect();
    let dot = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
    let cross =
        |a: &[f64; 3], b: &[f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let [a, b, c] = [&q[0], &q[1], &q[2]];
    let [la, lb, lc] = [a, b, c].map(|v| dot(v, v).sqrt());
    2.0 * dot(a, &cross(b, c)).atan2(la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb)
}

/// Surfaces with holes, small enough for the definition.
pub(crate) fn small_cases() -> Vec<(String, Facets, Rule)> {
    let bowl =
        models::sphere([4.0, 4.2, 4.1], 3.3, 10).into_iter().filter(|facet| facet.iter().all(|c| c[2] < 4.7)).collect();
    let mut open_box = models::cuboid([1.0, 1.5, 1.2], [7.0, 6.5, 7.3]);
    open_box.truncate(10);
    let mut cases: Vec<(String, Facets)> = vec![("bowl".into(), bowl), ("open box".into(), open_box)];
    for seed in 0..12 {
        let whole = match seed % 4 {
            0 => models::sphere([4.0; 3], 3.4, 9),
            1 => models::torus([4.0; 3], [2.4, 1.1], 9),
            2 => models::outwards(models::cone([4.0, 4.0, 1.0], 3.0, [4.0, 4.5, 7.0], 12)),
            _ => models::joined([models::sphere([3.0; 3], 2.4, 7), models::sphere([5.2; 3], 2.3, 6)]),
        };
        let share = [0.03, 0.1, 0.3][seed as usize % 3];
        cases.push((format!("seed {seed}, {share} removed"), without(&whole, share, seed)));
    }
    // corners on mesh lines and on centres, so that centres lie in the planes of holes
    for seed in 0..32 {
        let mut random = Random::new(100 + seed);
        let mut place = || random.below(15) as f32 * 0.5 + 0.5;
        let mut corner = || [place(), place(), place()];
        let whole = match seed % 3 {
            0 => models::tetrahedron([corner(), corner(), corner(), corner()]),
            1 => models::octahedron([1.0, 0.5, 1.5], corner().map(|c| c.max(4.0))),
            _ => models::wedge([corner(), corner(), corner()], [1.0, 0.5, 1.5]),
        };
        // two facets side by side leave a hole of four edges
        let mut holed = whole.clone();
        holed.remove(seed as usize % whole.len());
        if !seed.is_multiple_of(4) {
            holed.remove((seed as usize ^ 1) % holed.len());
        }
        if seed < 12 {
            // the same holes, of more edges than are closed without a cap
            cases.push((format!("ties of many edges, seed {seed}"), in_four(&in_four(&holed))));
        }
        cases.push((format!("ties, seed {seed}"), holed));
    }
    let both = |(name, facets): (String, Facets)| {
        [(name.clone(), facets.clone(), Rule::Parity), (name, facets, Rule::Nonzero)]
    };
    cases.into_iter().flat_map(both).collect()
}

/// Each facet in four, by the middles of its edges.
fn in_four(facets: &Facets) -> Facets {
    let middle = |a: [f32; 3], b: [f32; 3]| -> [f32; 3] { std::array::from_fn(|k| 0.5 * (a[k] + b[k])) };
    let of_one = |&[a, b, c]: &Facet| {
        let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
        [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    };
    facets.iter().flat_map(of_one).collect()
}

/// A box without its lid, given last, over two closed bodies: they keep their cells, in whatever order, unless it has a higher priority.
#[test]
fn an_open_geometry_does_not_take_the_cells_of_closed_ones() {
    let mut lidless = models::cuboid([0.0; 3], [10.0; 3]);
    lidless.truncate(10);
    let bodies = [models::cuboid([1.0, 1.0, 1.0], [4.0, 3.0, 5.0]), models::sphere([6.0, 6.0, 4.0], 2.5, 16), lidless];
    let cells_of = |order: [usize; 3], priority: i32| {
        let geometry = |index: usize| {
            let priority = if index == 2 { priority } else { 0 };
            set!(GeometryJob { flag: Some(index as u8 + 1), priority, ..GeometryJob::default() })
        };
        let geometries = order.map(geometry).to_vec();
        let domain = Some([0.0, 0.0, 0.0, 10.0, 10.0, 10.0]);
        let job = set!(Job { geometries, domain, cells: Some(20), ..Job::default() });
        let parts = order.map(|index| bodies[index].clone());
        let of_axes = [0, 1, 2].map(|axis| meshed(&parts, &job, axis, &mut Engine::cpu()).expect("it is a mesh").0);
        let flags = of_axes.each_ref().map(flags_of);
        assert!(flags[0] == flags[1] && flags[0] == flags[2]);
        let alone = |index: usize| flags[0].iter().filter(|&&flag| usize::from(flag) == index + 1).count();
        ([0, 1, 2].map(alone), flags[0].clone())
    };
    let (last, flags) = cells_of([0, 1, 2], 0);
    // a box of 3 x 2 x 4 and a ball of radius 2.5, in cells of an eighth
    assert_eq!(last[0], 6 * 4 * 8);
    assert!((400..545).contains(&last[1]), "{last:?}");
    assert!(last[2] > 3000, "{last:?}");
    assert_eq!(cells_of([2, 1, 0], 0).1, flags);
    assert_eq!(cells_of([0, 2, 1], 0).1, flags);
    let (above, _) = cells_of([0, 1, 2], 1);
    assert!(above[0] < last[0] && above[1] < last[1], "{above:?}");
}

/// Centres that lie in the planes of caps: the missing facet of a tetrahedron, whose hole has a corner on one of its edges, and five
/// missing facets of a prism. Their edges are divided, so that the holes have many.
#[test]
fn a_centre_in_the_plane_of_a_cap_is_on_the_side_that_the_tie_rule_says() {
    let tetrahedron = vec![
        [[1.0, 18.0, -8.0], [2.0, 10.0, 24.0], [-1.0, 0.0, -8.0]],
        [[2.0, 10.0, 24.0], [0.5, 11.0, 14.0], [-1.0, 0.0, -8.0]],
        [[0.5, 11.0, 14.0], [-1.0, 12.0, 4.0], [-1.0, 0.0, -8.0]],
        [[-1.0, 12.0, 4.0], [1.0, 18.0, -8.0], [-1.0, 0.0, -8.0]],
        [[1.0, -8.0, 12.0], [3.0, 2.0, 16.0], [1.5, 14.0, 24.0]],
    ];
    let prism = vec![
        [[3.0, 1.0, -0.5], [3.5, 0.5, 7.0], [3.0, 0.5, 7.0]],
        [[3.5, 0.5, 7.0], [3.0, 1.0, -0.5], [3.5, 1.0, -0.5]],
        [[3.0, 3.5, 0.5], [3.0, 1.0, -0.5], [3.0, -2.0, 4.0]],
        [[3.0, 3.5, 0.5], [3.5, 3.5, 0.5], [3.5, 1.0, -0.5]],
        [[3.0, -2.0, 4.0], [3.0, 1.0, -0.5], [3.0, 0.5, 7.0]],
        [[3.5, 3.5, 0.5], [3.0, -2.0, 4.0], [3.5, -2.0, 4.0]],
    ];
    let [tetrahedron, prism] = [tetrahedron, prism].map(|facets| in_four(&in_four(&facets)));
    let flag = |facets: &Facets, (dims, domain): ([u32; 3], [f64; 6]), (rule, axis): (Rule, usize), cell: [u32; 3]| {
        let job = set!(Job { dims: Some(dims), domain: Some(domain), rule, ..Job::default() });
        let (mesh, _) = meshed(std::slice::from_ref(facets), &job, axis, &mut Engine::cpu()).expect("a mesh");
        mesh.flag(cell).expect("columns in memory")
    };
    for axis in 0..3 {
        // winding numbers of 0.507 and 0.267
        let wide = ([4, 7, 4], [0.0, 0.0, 0.0, 2.0, 14.0, 16.0]);
        assert_eq!(flag(&tetrahedron, wide, (Rule::Nonzero, axis), [0, 6, 1]), 1, "axis {axis}");
        let narrow = ([9, 11, 11], [0.0, 0.0, 0.0, 4.0, 5.0, 5.0]);
        assert_eq!(flag(&prism, narrow, (Rule::Parity, axis), [7, 5, 2]), 0, "axis {axis}");
    }
}

#[test]
fn every_cell_of_a_surface_with_holes_is_as_defined() {
    let mut engine = Engine::cpu();
    let (n_sure, n_inside, n_outside) = (std::cell::Cell::new(0), std::cell::Cell::new(0), std::cell::Cell::new(0));
    for (index, (name, facets, rule)) in small_cases().into_iter().enumerate() {
        let dims = if name.starts_with("ties") { [8; 3] } else { [[11, 10, 12], [7, 13, 9]][index % 2] };
        // on equal cells, and on cells that differ in size
        let equal =
            set!(Job { dims: Some(dims), domain: Some([0.0, 0.0, 0.0, 8.0, 8.0, 8.0]), rule, ..Job::default() });
        let list = |n: u32| (0..=n).map(|line| 8.0 * (f64::from(line) / f64::from(n)).powf(1.5)).collect();
        let [x, y, z] = dims.map(list);
        let graded = set!(Job { lines: Some(LinesJob { x, y, z }), rule, ..Job::default() });
        let job = if index % 4 < 2 { equal } else { graded };
        let (mesh, report) = meshed(std::slice::from_ref(&facets), &job, index % 3, &mut engine).expect("a mesh");
        let doubtful = std::cell::RefCell::new(Vec::new());
        expected(&facets, mesh.lines(), rule, |cell, expected| {
            let is_inside = mesh.flag(cell).expect("columns in memory") != 0;
            match expected {
                Expected::Sure(inside) => assert_eq!(is_inside, inside, "{name}, {rule:?}: sure cell {cell:?}"),
                Expected::ByWinding(inside) => {
                    assert_eq!(is_inside, inside, "{name}, {rule:?}: doubtful cell {cell:?}")
                }
                Expected::Open => {}
            }
            let is_sure = matches!(expected, Expected::Sure(_));
            n_sure.set(n_sure.get() + u32::from(is_sure));
            doubtful.borrow_mut().push(u8::from(!is_sure));
            match expected {
                Expected::ByWinding(true) => n_inside.set(n_inside.get() + 1),
                Expected::ByWinding(false) => n_outside.set(n_outside.get() + 1),
                _ => {}
            }
        });
        let open = &report.open[0];
        let doubtful = doubtful.into_inner();
        assert_eq!(open.doubtful_cells, doubtful.iter().filter(|cell| **cell == 1).count() as u64, "{name}");
        assert_eq!(flags_of(report.doubt.as_ref().expect("asked for")), doubtful, "{name}");
        assert_eq!((report.doubtful.cells, report.doubtful.are_all), (open.doubtful_cells, true), "{name}");
        assert!(open.open_edges > 0 && open.holes > 0, "{name}: {open:?}");
    }
    println!("{} sure, {} doubtful inside, {} outside", n_sure.get(), n_inside.get(), n_outside.get());
    assert!(n_sure.get() > 10_000 && n_inside.get() > 1000 && n_outside.get() > 1000);
}

#[test]
fn facets_that_are_turned_the_wrong_way_do_no_harm() {
    let whole = without(&models::sphere([4.0; 3], 3.4, 24), 0.01, 3);
    let mut random = Random::new(9);
    let some_turned: Facets =
        whole.iter().map(|&[a, b, c]| if random.below(4) == 0 { [a, c, b] } else { [a, b, c] }).collect();
    for rule in [Rule::Parity, Rule::Nonzero] {
        let job = set!(Job { dims: Some([40; 3]), rule, ..Job::default() });
        let (mesh, _) = meshed(std::slice::from_ref(&whole), &job, 0, &mut Engine::cpu()).expect("a mesh");
        let (turned, report) = meshed(std::slice::from_ref(&some_turned), &job, 0, &mut Engine::cpu()).expect("a mesh");
        assert_eq!(flags_of(&mesh), flags_of(&turned));
        assert!(report.open[0].turned > 100, "{:?}", report.open[0]);
    }
}

#[test]
fn a_few_missing_facets_change_few_cells_and_no_streak_reaches_the_end() {
    for (name, whole) in
        [("ball", models::sphere([0.0; 3], 1.0, 48)), ("ring", models::torus([0.0; 3], [1.0, 0.4], 48))]
    {
        for (share, most) in [(0.01, 1e-4), (0.05, 5e-4), (0.1, 1e-3)] {
            let job = set!(Job {
                cells: Some(100),
                padding: Some(hexcast::job::Padding::Cells(hexcast::job::PerAxis::All(3))),
                ..Job::default()
            });
            let (closed, report) = meshed(std::slice::from_ref(&whole), &job, 0, &mut Engine::cpu()).expect("a mesh");
            assert!(report.open.is_empty(), "{name} is closed");
            let job = set!(Job {
                dims: Some(closed.dims()),
                domain: Some(report_domain(&closed)),
                padding: None,
                cells: None,
                ..job
            });
            let (open, _) = meshed(&[without(&whole, share, 7)], &job, 0, &mut Engine::cpu()).expect("a mesh");
            let (closed, open) = (flags_of(&closed), flags_of(&open));
            let n_differ = closed.iter().zip(&open).filter(|(a, b)| a != b).count();
            let differ = n_differ as f64 / closed.len() as f64;
            println!("{name}, {share} removed: {differ:.6} of the cells differ");
            assert!(differ <= most, "{name}, {share} removed: {differ}");
        }
    }
}

/// The box of a mesh.
fn report_domain(mesh: &Mesh) -> [f64; 6] {
    let lines = &mesh.lines();
    let end = |axis: usize| lines.origin()[axis] + f64::from(lines.dims()[axis]) * lines.smallest()[axis];
    [lines.origin()[0], lines.origin()[1], lines.origin()[2], end(0), end(1), end(2)]
}

#[test]
fn policies_do_what_they_say() {
    let mut open_box = models::cuboid([1.0; 3], [7.0; 3]);
    open_box.truncate(10);
    let job =
        |open| set!(Job { dims: Some([16; 3]), domain: Some([0.0, 0.0, 0.0, 8.0, 8.0, 8.0]), open, ..Job::default() });
    let mut engine = Engine::cpu();
    for axis in 0..3 {
        for open in [Open::Winding, Open::Vote] {
            let (mesh, report) =
                meshed(std::slice::from_ref(&open_box), &job(open), axis, &mut engine).expect("a mesh");
            let inside = mesh.columns().cells_per_flag()[1];
            assert_eq!(inside, 12 * 12 * 12, "{open:?}, axis {axis}");
            assert_eq!(report.open[0].odd_rays.iter().filter(|&&n| n == 144).count(), 1, "{:?}", report.open[0]);
        }
        let (_, report) =
            meshed(std::slice::from_ref(&open_box), &job(Open::Parity), axis, &mut engine).expect("a mesh");
        assert!(report.open.is_empty(), "{:?}", report.open);
    }
    let error = meshed(&[open_box], &job(Open::Error), 0, &mut engine).expect_err("it is open");
    assert_eq!(error.code(), "surface-open");
    assert!(error.to_string().contains("open edges 4, loops 1"), "{error}");
}

#[test]
fn what_deciding_takes_is_held_against_the_memory_allowed() {
    let ball = without(&models::sphere([4.0; 3], 3.4, 24), 0.05, 3);
    let job = |megabytes: u64| {
        let max_memory = Some(hexcast::job::ByteSize(megabytes * 1_000_000));
        set!(Job { dims: Some([400; 3]), max_memory, ..Job::default() })
    };
    let error = meshed(std::slice::from_ref(&ball), &job(5), 0, &mut Engine::cpu()).expect_err("it takes more");
    assert_eq!(error.code(), "memory");
    assert!(error.to_string().contains("takes about"), "{error}");
    let (_, facts) = meshed(std::slice::from_ref(&ball), &job(60), 0, &mut Engine::cpu()).expect("a mesh");
    let taken = facts.peak_bytes.meshing;
    assert!((5_000_000..60_000_000).contains(&taken), "{taken} bytes");
}
