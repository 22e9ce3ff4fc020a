//! Flags at any points: against the oracle in big integers, against winding numbers in f64, against cells, and by the definition of open surfaces.

use hexcast::geometry::{Facet, Geometry};
use hexcast::job::{Fill, GeometryJob, Job, LinesJob, Open};
use hexcast::lines::Lines;
use hexcast::pipeline::{Engine, MeshOptions};
use hexcast::points::PointFlags;
use hexcast::{Control, Source};

use super::models::{self, Facets};
use super::open_surfaces::{Definition, Expected, flags_of, meshed, small_cases, solid_angle};
use super::oracle;
use super::soups::{self, Random};

fn asked(bodies: &[Facets], job: &Job) -> hexcast::Result<PointFlags> {
    let given = |index: usize| job.geometries.get(index).cloned().unwrap_or_default();
    let geometries =
        (0..bodies.len()).map(|index| set!(GeometryJob { file: format!("{index}.stl"), ..given(index) })).collect();
    let job = set!(Job { geometries, ..job.clone() });
    let source = |(index, facets): (usize, &Facets)| Source::from_facets(format!("{index}.stl"), facets.clone());
    let sources = bodies.iter().enumerate().map(source).collect::<hexcast::Result<_>>()?;
    PointFlags::new(&job, sources, &MeshOptions::default(), &Control::default())
}

fn flags(bodies: &[Facets], job: &Job, points: &[[f64; 3]]) -> Vec<u8> {
    asked(bodies, job).unwrap().flags(points, &Control::default()).unwrap()
}

/// A job of the same lines, and these as the job has them.
fn of_lines(lines: &Lines) -> (Job, Lines) {
    let [x, y, z] = [0, 1, 2].map(|axis| lines.list(axis));
    let listed = Lines::from_lists([&x, &y, &z].map(Vec::clone)).unwrap();
    (set!(Job { lines: Some(LinesJob { x, y, z }), ..Job::default() }), listed)
}

/// Points on corners, edges and facets, beside them, anywhere in and around a box, and far from it.
fn points_at(facets: &[Facet], lines: &Lines, random: &mut Random, n: usize) -> Vec<[f64; 3]> {
    let ends = [0, 1, 2].map(|axis| [lines.line(axis, 0), lines.line(axis, lines.dims()[axis])]);
    let share = |random: &mut Random| random.below(1 << 20) as f64 / f64::from(1 << 20);
    let anywhere = |random: &mut Random| ends.map(|[low, high]| low + (1.6 * share(random) - 0.3) * (high - low));
    let mut points = Vec::new();
    while points.len() < n {
        let facet = facets[random.below(facets.len() as u64) as usize].map(|corner| corner.map(f64::from));
        let [a, b, c] = facet;
        let mut near: [f64; 3] = match random.below(6) {
            0 => a,
            1 => std::array::from_fn(|axis| 0.5 * (a[axis] + b[axis])),
            2 => std::array::from_fn(|axis| 0.25 * (2.0 * a[axis] + b[axis] + c[axis])),
            _ => anywhere(random),
        };
        let other = anywhere(random);
        // with one coordinate of a corner: over or beside it
        match random.below(8) {
            axis @ 0..3 => near[axis as usize] = other[axis as usize],
            3 => near[random.below(3) as usize] += random.one_of(&[1e-12, -1e-12, 1e-4, -1e-4]),
            4 => near[random.below(3) as usize] = random.one_of(&[1e30, -1e30, 1e9, -1e9, 0.0]),
            _ => {}
        }
        points.push(near);
    }
    points
}

#[test]
fn closed_geometries_have_the_points_that_big_integers_give_them() {
    let (mut n_closed, mut n_inside, mut n_graded) = (0, 0, 0);
    for seed in 0..150 {
        let case = soups::soup(seed);
        let mut random = Random::new(seed + 7_000);
        let own = if seed % 2 == 0 { case.lines } else { soups::thinned(&case.lines, &mut random) };
        let (job, lines) = of_lines(&own);
        if !oracle::is_closed(&case.geometries, &lines, case.rule) {
            continue;
        }
        let of_job =
            |of: &Geometry| set!(GeometryJob { flag: Some(of.flag), priority: of.priority, ..GeometryJob::default() });
        let job = set!(Job { geometries: case.geometries.iter().map(of_job).collect(), rule: case.rule, ..job });
        let bodies: Vec<Facets> = case.geometries.iter().map(|of| of.facets.slice().to_vec()).collect();
        let points = points_at(&bodies.concat(), &lines, &mut random, 150);
        let (found, wanted) =
            (flags(&bodies, &job, &points), oracle::flags_at(&case.geometries, &lines, case.rule, &points));
        for ((point, found), wanted) in points.iter().zip(&found).zip(&wanted) {
            assert_eq!(found, wanted, "seed {seed}, {point:?}");
        }
        assert_eq!(found.len(), points.len());
        n_closed += 1;
        n_inside += found.iter().filter(|flag| **flag > 0).count();
        n_graded += usize::from(lines.is_graded());
    }
    assert!(
        n_closed > 100 && n_inside > 1000 && n_graded > 20,
        "{n_closed} soups, {n_inside} points, {n_graded} graded"
    );
}

/// Shares neither the snap nor rays with what it checks.
#[test]
fn points_are_inside_where_the_winding_number_of_the_surface_in_its_file_says_so() {
    let bodies = [
        models::sphere([3.1, 3.2, 2.9], 2.7, 24),
        models::torus([4.0, 4.1, 3.7], [2.2, 0.9], 17),
        models::terrain([12, 9], 7.0, 0.3, |i, j| 2.0 + ((i * 7 + j * 5) % 11) as f32 * 0.31),
    ];
    let mut random = Random::new(11);
    for (number, body) in bodies.iter().enumerate() {
        let points: Vec<[f64; 3]> =
            (0..1500).map(|_| [0; 3].map(|_| random.below(1 << 30) as f64 / f64::from(1 << 30) * 9.0 - 1.0)).collect();
        let found = flags(std::slice::from_ref(body), &set!(Job { cells: Some(9), ..Job::default() }), &points);
        let mut n_inside = 0;
        for (point, flag) in points.iter().zip(found) {
            let sum: f64 =
                body.iter().map(|facet| solid_angle(&facet.map(|corner| corner.map(f64::from)), *point)).sum();
            let winding = sum.abs() / (4.0 * std::f64::consts::PI);
            assert!((winding - winding.round()).abs() < 1e-6, "body {number}, {point:?}: {winding}");
            assert_eq!(f64::from(flag), winding.round(), "body {number}, {point:?}");
            n_inside += usize::from(flag);
        }
        assert!(n_inside > 40 && n_inside < 1400, "body {number}: {n_inside}");
    }
}

fn centres(lines: &Lines) -> Vec<[f64; 3]> {
    let [x, y, z] = [0, 1, 2].map(|axis| -> Vec<f64> {
        (0..lines.dims()[axis]).map(|cell| 0.5 * (lines.line(axis, cell) + lines.line(axis, cell + 1))).collect()
    });
    let rows = z.iter().flat_map(|&z| y.iter().map(move |&y| (y, z)));
    rows.flat_map(|(y, z)| x.iter().map(move |&x| [x, y, z])).collect()
}

#[test]
fn centres_of_cells_have_the_flags_of_the_cells_also_of_open_surfaces() {
    let mut n_doubtful = 0;
    for (index, (name, facets, rule)) in small_cases().into_iter().enumerate() {
        let open = [Open::Winding, Open::Vote][index / 2 % 2];
        let of_open =
            set!(GeometryJob { open: Some(open), invert: index % 5 == 0, flag: Some(9), ..GeometryJob::default() });
        // under a closed body and over another
        let bodies = [models::cuboid([0.5, 0.5, 0.5], [3.0, 3.0, 3.0]), facets, models::sphere([5.0; 3], 1.5, 8)];
        let geometries =
            vec![GeometryJob::default(), of_open, set!(GeometryJob { priority: 1, ..GeometryJob::default() })];
        let given = Lines::new([0.0; 3], [1.0; 3], [8; 3]).unwrap();
        let given = if index % 3 == 0 { soups::anywhere(&given, &mut Random::new(index as u64)) } else { given };
        let (job, _) = of_lines(&given);
        let job = set!(Job { geometries, rule, ..job });
        let (mesh, facts) = meshed(&bodies, &job, index % 3, &mut Engine::cpu()).unwrap();
        n_doubtful += facts.doubt.map_or(0, |mask| flags_of(&mask).iter().filter(|flag| **flag > 0).count());
        let points = centres(mesh.lines());
        let (found, cells) = (flags(&bodies, &job, &points), flags_of(&mesh));
        assert_eq!(found.len(), cells.len());
        for ((point, found), cell) in points.iter().zip(found).zip(cells) {
            assert_eq!(found, cell, "{name}, {rule:?}, {point:?}");
        }
    }
    assert!(n_doubtful > 500, "{n_doubtful} doubtful cells");
}

#[test]
fn points_around_holes_are_those_of_the_definition() {
    let (mut n_sure, mut n_wound) = (0, 0);
    for (index, (name, facets, rule)) in small_cases().into_iter().enumerate() {
        let (job, lines) = of_lines(&Lines::new([0.0; 3], [1.0; 3], [8; 3]).unwrap());
        let definition = Definition::new(&facets, &lines, rule);
        let geometry = Geometry::new("g", 1, facets.clone()).unwrap();
        let mut random = Random::new(31 + index as u64);
        let points = points_at(&facets, &lines, &mut random, 60);
        // the definition counts in 26 bits
        let points: Vec<[f64; 3]> = points.into_iter().filter(|point| point.iter().all(|at| at.abs() < 20.0)).collect();
        let found = flags(&[facets], &set!(Job { rule, ..job }), &points);
        for (point, flag) in points.iter().zip(found) {
            let place = [0, 1, 2].map(|axis| oracle::unit_of(&geometry, &lines, axis, point[axis]));
            let (wanted, n) = match definition.at(&place) {
                Expected::Sure(wanted) => (wanted, &mut n_sure),
                Expected::ByWinding(wanted) => (wanted, &mut n_wound),
                Expected::Open => continue,
            };
            assert_eq!(flag == 1, wanted, "{name}, {rule:?}, {point:?}");
            *n += 1;
        }
    }
    assert!(n_sure > 1000 && n_wound > 300, "{n_sure} sure, {n_wound} by winding numbers");
}

#[test]
fn surfaces_boxes_priorities_and_insides_are_as_documented() {
    let cube = models::cube([1.0; 3], 2.0);
    let job = set!(Job { domain: Some([0.0, 0.0, 0.0, 2.0, 2.0, 2.0]), cells: Some(4), ..Job::default() });
    // a point on a surface counts as a little nearer to the start; the box cuts the cube, and no point
    let points =
        [[1.0, 2.0, 2.0], [3.0, 2.0, 2.0], [2.0, 2.0, 3.0], [2.0, 2.0, 1.0], [2.5, 2.5, 2.5], [1e300, 2.0, 2.0]];
    let of = |geometry: GeometryJob| {
        flags(std::slice::from_ref(&cube), &set!(Job { geometries: vec![geometry], ..job.clone() }), &points)
    };
    assert_eq!(of(GeometryJob::default()), [0, 1, 1, 0, 1, 0]);
    assert_eq!(of(set!(GeometryJob { invert: true, ..GeometryJob::default() })), [1, 0, 0, 1, 0, 1]);
    assert_eq!(of(set!(GeometryJob { shell: true, fill: Some(Fill::Separating), ..GeometryJob::default() })), [0; 6]);
    // also where the shell is open, and must not be
    let shell = set!(GeometryJob { shell: true, open: Some(Open::Error), ..GeometryJob::default() });
    let open_shell = set!(Job { geometries: vec![shell], ..job.clone() });
    assert_eq!(flags(&[cube[1..].to_vec()], &open_shell, &points), [0; 6]);
    assert_eq!(of(set!(GeometryJob { fill: Some(Fill::Conservative), ..GeometryJob::default() })), [0, 1, 1, 0, 1, 0]);
    // infinity is far, and windows do not count
    let windowed = set!(Job { window: Some([0, 0, 0, 1, 1, 1]), ..job.clone() });
    assert_eq!(flags(std::slice::from_ref(&cube), &windowed, &[[f64::INFINITY, 2.0, 2.0], [2.0; 3]]), [0, 1]);
    let (low, high) = (set!(GeometryJob { priority: 1, ..GeometryJob::default() }), GeometryJob::default());
    let both = [cube.clone(), models::cube([2.0; 3], 2.0)];
    let in_both =
        |geometries: Vec<GeometryJob>| flags(&both, &set!(Job { geometries, ..job.clone() }), &[[2.5; 3], [3.5; 3]]);
    assert_eq!(in_both(vec![high.clone(), high.clone()]), [2, 2]);
    assert_eq!(in_both(vec![low, high]), [1, 2]);
}

/// Of these several are known by one rank.
#[test]
fn of_three_hundred_geometries_each_has_its_points() {
    let low = |index: usize| [index % 7, index / 7 % 7, index / 49].map(|place| 2.0 * place as f32);
    let bodies: Vec<Facets> = (0..300).map(|index| models::cube(low(index), 1.0)).collect();
    let flag = |index: usize| 1 + (index * index % 5) as u8;
    let geometries =
        (0..300).map(|index| set!(GeometryJob { flag: Some(flag(index)), ..GeometryJob::default() })).collect();
    let inner = (0..300).map(|index| low(index).map(|at| f64::from(at) + 0.3));
    let points: Vec<[f64; 3]> = inner.flat_map(|point| [point, [point[0] + 1.0, point[1], point[2]]]).collect();
    let found = flags(&bodies, &set!(Job { geometries, cells: Some(20), ..Job::default() }), &points);
    let wanted: Vec<u8> = (0..300).flat_map(|index| [flag(index), 0]).collect();
    assert_eq!(found, wanted);
}

#[test]
fn what_cannot_be_decided_is_an_error() {
    let cube = models::cube([1.0; 3], 2.0);
    let job = set!(Job { cells: Some(4), ..Job::default() });
    let asked_cube = asked(std::slice::from_ref(&cube), &job).unwrap();
    let error = asked_cube.flags(&[[0.0; 3], [0.0, f64::NAN, 1.0]], &Control::default()).unwrap_err();
    assert_eq!((error.code(), &error.to_string()[..]), ("job-value", "point 1 is [0.0, NaN, 1.0]"));
    assert!(asked_cube.snap().iter().all(|&snap| snap > 0.0 && snap < 1e-6), "{:?}", asked_cube.snap());
    assert_eq!(asked_cube.flags(&[], &Control::default()).unwrap(), [0u8; 0]);
    let cancelled = Control::default();
    cancelled.cancel.cancel();
    assert_eq!(asked_cube.flags(&[[0.0; 3]], &cancelled).unwrap_err().code(), "cancelled");
    let open = cube[1..].to_vec();
    for (policy, code) in [(Open::Error, "surface-open"), (Open::Parity, "surface-open")] {
        let job = set!(Job {
            geometries: vec![set!(GeometryJob { open: Some(policy), ..GeometryJob::default() })],
            ..job.clone()
        });
        assert_eq!(asked(std::slice::from_ref(&open), &job).err().map(|error| error.code()), Some(code), "{policy:?}");
    }
    let little = set!(Job { max_memory: Some(hexcast::job::ByteSize(1500)), ..job });
    assert_eq!(asked(&[cube], &little).err().map(|error| error.code()), Some("memory"));
}
