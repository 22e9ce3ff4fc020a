//! Holes of few edges: the facet that is missing is added, or the surface goes on as around it, and no cell changes.

use hexcast::geometry::Facet;
use hexcast::job::{Job, Open, Rule};
use hexcast::pipeline::Engine;
use hexcast::report::OpenReport;

use super::models::{self, Facets};
use super::open_surfaces::{flags_of, meshed};
use super::soups::Random;

/// The flags along each axis, and what is said of the surface, which must be the same along all.
fn flags_and_report(facets: &Facets, job: &Job) -> (Vec<u8>, Option<OpenReport>) {
    let of_axis = |axis: usize| {
        let (mesh, facts) = meshed(std::slice::from_ref(facets), job, axis, &mut Engine::cpu()).expect("a mesh");
        (flags_of(&mesh), facts.open.first().cloned())
    };
    let first = of_axis(0);
    (1..3).for_each(|axis| assert_eq!(of_axis(axis), first, "axis {axis}"));
    first
}

fn jobs() -> impl Iterator<Item = Job> {
    let job =
        |rule| set!(Job { dims: Some([40; 3]), domain: Some([0.0, 0.0, 0.0, 8.0, 8.0, 8.0]), rule, ..Job::default() });
    [Rule::Parity, Rule::Nonzero].into_iter().map(job)
}

/// Removes facets of which no two share a corner.
fn without_some(whole: &[Facet], seed: u64) -> Facets {
    let mut random = Random::new(seed);
    let mut touched: Vec<[f32; 3]> = Vec::new();
    let is_left = |facet: &&Facet| {
        let is_removed = random.below(5) == 0 && !facet.iter().any(|corner| touched.contains(corner));
        touched.extend(facet.iter().filter(|_| is_removed));
        !is_removed
    };
    whole.iter().filter(is_left).copied().collect()
}

#[test]
fn facets_that_are_missing_cost_no_cell() {
    for (name, whole) in [
        ("ball", models::sphere([4.0; 3], 3.4, 24)),
        ("ring", models::torus([4.0; 3], [2.4, 1.1], 18)),
        ("cone", models::outwards(models::cone([4.0, 4.0, 1.0], 3.0, [4.0, 4.5, 7.0], 30))),
    ] {
        for job in jobs() {
            let (flags, report) = flags_and_report(&whole, &job);
            assert_eq!(report, None, "{name} is closed");
            let holed = without_some(&whole, 7);
            let (same, report) = flags_and_report(&holed, &job);
            let report = report.expect("it is open");
            let n_removed = (whole.len() - holed.len()) as u64;
            assert!(n_removed > 0, "{name}");
            assert_eq!((report.added_facets, report.holes, report.open_edges), (n_removed, n_removed, 3 * n_removed));
            assert_eq!((report.doubtful_cells, report.odd_rays), (0, [0; 3]), "{name}");
            assert!(flags == same, "{name}, {:?}", job.rule);
        }
    }
}

/// All edges are open, and of the eight triangles around them four are there.
#[test]
fn an_octahedron_of_every_other_facet_is_whole() {
    let whole = models::octahedron([0.7, 1.1, 0.9], [7.2, 6.8, 7.4]);
    let half: Facets = (0..8usize).filter(|octant| octant.count_ones() % 2 == 0).map(|octant| whole[octant]).collect();
    for job in jobs() {
        let (flags, _) = flags_and_report(&whole, &job);
        let (same, report) = flags_and_report(&half, &job);
        assert_eq!(report.map(|report| (report.added_facets, report.open_edges)), Some((4, 12)));
        assert!(flags == same, "{:?}", job.rule);
    }
}

/// One side has a corner in the middle of its long edge, and its neighbour has not.
#[test]
fn a_long_edge_beside_two_short_ones_leaves_no_hole() {
    let [low, high] = [[1.1, 1.3, 0.9], [7.2, 6.8, 7.4]];
    let whole = models::cuboid(low, high);
    let [a, b, c] = whole[0];
    let middle: [f32; 3] = std::array::from_fn(|axis| 0.5 * (a[axis] + b[axis]));
    let mut split = whole.clone();
    split.splice(0..1, [[a, middle, c], [middle, b, c]]);
    for job in jobs() {
        let (flags, _) = flags_and_report(&whole, &job);
        let (same, report) = flags_and_report(&split, &job);
        assert_eq!(report.map(|report| (report.added_facets, report.open_edges)), Some((1, 3)));
        assert!(flags == same, "{:?}", job.rule);
    }
}

/// Facets side by side are gone: of a body's edges and corners, which nothing but the facets around them tells.
#[test]
fn holes_over_edges_and_corners_cost_no_cell() {
    let [low, high] = [[1.1, 1.3, 0.9], [7.2, 6.8, 7.4]];
    let cuboid = models::cuboid(low, high);
    let neighbours = |one: &Facet, other: &Facet| one.iter().filter(|corner| other.contains(corner)).count() == 2;
    let mut n_holes = 0;
    for job in jobs() {
        let (flags, _) = flags_and_report(&cuboid, &job);
        for first in 0..cuboid.len() {
            for second in (first + 1..cuboid.len()).filter(|&second| neighbours(&cuboid[first], &cuboid[second])) {
                let is_left = |index: &usize| *index != first && *index != second;
                let holed: Facets = (0..cuboid.len()).filter(is_left).map(|index| cuboid[index]).collect();
                let (same, report) = flags_and_report(&holed, &job);
                let report = report.expect("it is open");
                assert_eq!((report.holes, report.open_edges, report.added_facets), (1, 4, 0));
                assert!(report.doubtful_cells > 0, "the rays say that they met a hole");
                let differ = flags.iter().zip(&same).filter(|(one, other)| one != other).count();
                assert_eq!(differ, 0, "facets {first} and {second}, {:?}", job.rule);
                n_holes += 1;
            }
        }
    }
    assert_eq!(n_holes, 2 * 18, "a cuboid has 12 edges and 6 diagonals");
}

/// A facet by itself has three open edges, but is there; and of two triangles that share an open edge, both may be meant.
#[test]
fn what_may_not_be_missing_is_not_added() {
    let [a, b, c, d] = [[1.0, 1.0, 1.0], [6.0, 1.0, 1.0], [3.0, 6.0, 1.0], [3.0, 3.0, 6.0]];
    let beside = |from: [f32; 3], to: [f32; 3], k: usize| [from, to, [7.5, 0.5 * k as f32, 7.0]];
    let around_one = vec![beside(a, b, 1), beside(b, c, 2), beside(c, a, 3)];
    let around_two = models::joined([around_one.clone(), vec![beside(b, d, 4), beside(d, a, 5)]]);
    for job in jobs() {
        let added = |facets: &Facets| flags_and_report(facets, &job).1.expect("it is open").added_facets;
        assert_eq!(added(&vec![[a, b, c]]), 0);
        assert_eq!(added(&around_one), 1);
        assert_eq!(added(&around_two), 0);
    }
}

#[test]
fn a_missing_facet_is_an_error_where_the_job_says_so_and_is_said_where_it_does_not() {
    let holed = without_some(&models::sphere([4.0; 3], 3.4, 24), 7);
    let job = set!(Job { dims: Some([20; 3]), open: Open::Error, ..Job::default() });
    let error = meshed(std::slice::from_ref(&holed), &job, 0, &mut Engine::cpu()).expect_err("it is open");
    assert_eq!(error.code(), "surface-open");
    let (_, facts) =
        meshed(&[holed], &set!(Job { open: Open::Winding, ..job }), 0, &mut Engine::cpu()).expect("a mesh");
    let n = facts.open[0].added_facets;
    let wanted = format!("facets added where one was missing between three open edges: {n}");
    assert!(facts.warnings.iter().any(|warning| warning.contains(&wanted)), "{:?}", facts.warnings);
}
