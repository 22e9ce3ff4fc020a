//! Single axes: where fixed lines and edges of metal are, and what is said of them.

use super::*;
use crate::base::finding::sentences;
use crate::set;

/// A job, a box and bodies in it.
struct Case {
    job: GradedJob,
    domain: Domain,
    bodies: Vec<(BoundingBox, Sizing)>,
}

/// A body along x: two ends, the largest size (0: none) and whether it is metal.
type AlongX = ([f64; 2], f64, bool);
type EndsCase = (&'static [[f64; 2]], &'static [f64], &'static [&'static str]);
type EdgesCase = (f64, &'static [AlongX], &'static [(f64, f64, f64)], &'static str);

/// Bodies in a box that ends at `last`, with the largest and the smallest size and the growth of a job.
fn along_x(last: f64, [most, least, growth]: [f64; 3], bodies: &[AlongX]) -> Case {
    let job = set!(GradedJob { min_size: Some(least), growth: Some(growth), ..GradedJob::new(PerAxis::All(most)) });
    let bodies: Vec<(BoundingBox, Sizing)> = bodies
        .iter()
        .map(|&([low, high], size, metal)| {
            let sizing = set!(Sizing { max_size: (size > 0.0).then_some(size), metal, ..Sizing::default() });
            ([[low, 0.0, 0.0], [high, 4.0, 4.0]], sizing)
        })
        .collect();
    let job_of_domain = set!(Job { domain: Some([0.0, 0.0, 0.0, last, 4.0, 4.0]), ..Job::default() });
    let domain = Domain::new(&job_of_domain, &[]).unwrap();
    Case { job, domain, bodies }
}

impl Case {
    fn with_axis<T>(&self, axis: usize, of: impl FnOnce(Axis<'_>) -> T) -> T {
        let bodies: Vec<Body> = self
            .bodies
            .iter()
            .zip(["a", "b", "c"])
            .map(|(&(bounds, sizing), name)| Body { name, bounds, sizing })
            .collect();
        of(Axis { job: &self.job, domain: &self.domain, bodies: &bodies, axis })
    }
}

#[test]
fn ends_nearer_than_the_smallest_cell_share_a_line() {
    // ends of bodies in a box of 4 with cells of at least an eighth -> places of lines, and what the sentences say
    let cases: [EndsCase; 8] = [
        (&[[0.125, 3.875]], &[0.0, 0.125, 3.875, 4.0], &[]),
        (&[[0.1, 3.9]], &[0.0, 4.0], &["\"a\" at x = 0.1 ", "\"a\" at x = 3.9 "]),
        (
            &[[1.0, 2.0], [1.125, 2.1]],
            &[0.0, 1.0, 1.125, 2.0, 4.0],
            &["it is 1.0000000000000009e-1 from that of \"a\" at 2,"],
        ),
        (&[[1.0, 1.05]], &[0.0, 1.0, 4.0], &["from that of its other side at 1,"]),
        (&[[0.0, 4.0]], &[0.0, 4.0], &[]),
        (&[[-1.0, 5.0]], &[0.0, 4.0], &[]),
        (&[[5.0, 6.0], [-2.0, -1.0]], &[0.0, 4.0], &[]),
        (&[[1.0, 3.9], [3.9, 6.0]], &[0.0, 1.0, 4.0], &["from that of the domain at 4,", "from that of \"a\" at 4,"]),
    ];
    for (ends, places, said) in cases {
        let bodies: Vec<_> = ends.iter().map(|ends| (*ends, 0.0, false)).collect();
        along_x(4.0, [1.0, 0.125, 1.3], &bodies).with_axis(0, |axis| {
            let mut findings = Vec::new();
            let fixed = axis.fixed(&mut findings);
            assert_eq!(fixed.iter().map(|of| of.at).collect::<Vec<_>>(), places, "{ends:?}");
            assert_eq!(findings.len(), said.len(), "{ends:?}: {findings:?}");
            said.iter().for_each(|said| {
                assert!(findings.iter().any(|found| found.sentence.contains(said)), "{said}: {findings:?}")
            });
        });
    }
}

#[test]
fn cells_around_edges_of_metal_leave_room_on_both_sides() {
    // bodies in a box of 30 -> the place of each edge, its side and the size of its cell
    let cases: [EdgesCase; 9] = [
        (0.1, &[([10.0, 20.0], 0.0, true)], &[(10.0, -1.0, 30.0 / 7.0), (20.0, 1.0, 30.0 / 7.0)], ""),
        (0.1, &[([10.0, 15.0], 0.0, true)], &[(10.0, -1.0, 3.0), (15.0, 1.0, 3.0)], ""),
        (0.1, &[([7.0, 27.0], 0.0, true)], &[(7.0, -1.0, 3.0), (27.0, 1.0, 9.0 / 7.0)], ""),
        // the size inside of it
        (0.1, &[([10.0, 14.0], 1.0, true)], &[(10.0, -1.0, 1.0), (14.0, 1.0, 1.0)], ""),
        (0.1, &[([10.0, 12.0], 0.5, true)], &[(10.0, -1.0, 0.5), (12.0, 1.0, 0.5)], ""),
        (1.0, &[([10.0, 14.0], 1.0, true)], &[(10.0, -1.0, 1.0), (14.0, 1.0, 1.0)], ""),
        (1.1, &[([10.0, 14.0], 1.0, true)], &[], "\"a\" at x = 14 lies on a line: a cell around it would be smaller"),
        // what ends there, too
        (
            0.1,
            &[([10.0, 14.0], 1.0, true), ([14.0, 20.0], 0.0, false)],
            &[(10.0, -1.0, 1.0)],
            "\"a\" at x = 14 lies on a line: another",
        ),
        (
            0.1,
            &[([10.0, 14.0], 1.0, true), ([5.0, 14.0], 0.0, true)],
            &[(5.0, -1.0, 15.0 / 7.0), (10.0, -1.0, 1.0), (14.0, 1.0, 1.0)],
            "",
        ),
    ];
    for (least, bodies, expected, said) in cases {
        along_x(30.0, [9.0, least, 1.3], bodies).with_axis(0, |axis| {
            let mut findings = Vec::new();
            let fixed = axis.fixed(&mut findings);
            let edges = axis.edges(&fixed, &axis.wanted(&fixed), &mut findings);
            let found: Vec<_> = edges.iter().map(|edge| (fixed[edge.index].at, edge.outwards, edge.size)).collect();
            assert_eq!(found.len(), expected.len(), "{bodies:?}: {found:?}, {findings:?}");
            for (found, expected) in found.iter().zip(expected) {
                assert_eq!((found.0, found.1), (expected.0, expected.1));
                assert!((found.2 - expected.2).abs() < 1e-12, "{found:?}, {expected:?}");
            }
            assert!(
                said.is_empty() == findings.is_empty()
                    && findings.iter().any(|found| found.sentence.contains(said)) != said.is_empty(),
                "{findings:?}"
            );
        });
    }
    // a short one
    let mut case = along_x(30.0, [9.0, 0.01, 1.3], &[([10.0, 10.5], 0.1, true)]);
    case.bodies[0].0[1] = [10.5, 1.0, 1.0];
    case.with_axis(0, |axis| {
        let fixed = axis.fixed(&mut Vec::new());
        let edges = axis.edges(&fixed, &axis.wanted(&fixed), &mut Vec::new());
        assert_eq!(edges.iter().map(|edge| edge.size).collect::<Vec<_>>(), [0.1, 0.1]);
    });
    // a line a third of the size inside, and one two thirds outside
    let fixed = [0.0, 10.0, 20.0].map(|at| Fixed { at, owners: Vec::new() });
    for (outwards, expected) in [(1.0, [0.0, 9.0, 12.0, 20.0]), (-1.0, [0.0, 8.0, 11.0, 20.0])] {
        assert_eq!(places(&fixed, &[Edge { index: 1, outwards, size: 3.0 }]), (expected.to_vec(), vec![1]));
    }
}

#[test]
fn lines_lie_beside_edges_of_metal_unless_it_is_thin_there() {
    // extents of metal, and along which axes its edges have lines at thirds
    for (extents, expected) in [
        ([10.0, 4.0, 4.0], [true; 3]),
        ([3.0, 4.0, 4.0], [true; 3]),
        ([2.0, 4.0, 6.0], [true; 3]),
        ([1.9, 4.0, 6.0], [false, true, true]),
        ([1.0, 4.0, 4.0], [false, true, true]),
        ([1.0, 2.0, 8.0], [true; 3]),
        ([8.0, 2.0, 0.5], [true, true, false]),
    ] {
        let low = [10.0, 20.0, 0.0];
        let bounds = [low, [0, 1, 2].map(|axis| low[axis] + extents[axis])];
        for metal in [true, false] {
            let mut case = along_x(40.0, [1.0, 0.1, 1.3], &[]);
            case.bodies = vec![(bounds, set!(Sizing { metal, ..Sizing::default() }))];
            let found = [0, 1, 2].map(|axis| case.with_axis(axis, |axis| axis.has_thirds(0)));
            assert_eq!(found, expected.map(|is| is && metal), "{extents:?}");
        }
    }
}

#[test]
fn a_cell_around_an_edge_that_its_neighbours_would_divide_is_smaller_or_none() {
    // cells of b grow slowly, so that those at the edge of a are smaller than the one around it
    let bodies = [([20.0, 60.0], 0.0, true), ([70.0, 90.0], 1.0, false)];
    let said = |least: f64| {
        along_x(100.0, [1.2, least, 1.01], &bodies).with_axis(0, |axis| {
            let mut findings = Vec::new();
            let lines = axis.lines(&mut findings);
            (lines.is_ok(), sentences(&findings))
        })
    };
    assert_eq!(said(0.1), (true, vec![]));
    let expected = [20, 60].map(|at| {
        format!("the edge of \"a\" at x = {at} lies on a line: a cell around it would be smaller than the smallest")
    });
    assert_eq!(said(0.7), (true, expected.to_vec()));
    assert_eq!(said(1.0).1, expected);
}

#[test]
fn lines_that_nothing_divides_are_equally_spaced_up_to_as_many_as_fit() {
    let made = |last: f64, size: f64| {
        along_x(last, [size, size / 1000.0, 1.3], &[]).with_axis(0, |axis| axis.lines(&mut Vec::new()))
    };
    for n in 1..40 {
        let list = made(0.1 * f64::from(n), 0.03).unwrap();
        let spacing = 0.1 * f64::from(n) / (list.len() - 1) as f64;
        assert!(spacing <= 0.03 + 1e-9 && spacing * list.len() as f64 > 0.1 * f64::from(n), "{spacing}");
        let inner = &list[..list.len() - 1];
        assert!(inner.iter().enumerate().all(|(k, line)| *line == k as f64 * spacing), "{n}: {list:?}");
    }
    let most = MAX_LISTED as f64 - 1.0;
    assert_eq!(made(most, 1.0).unwrap().len(), MAX_LISTED);
    let error = made(most + 1.0, 1.0).unwrap_err();
    assert_eq!(
        (error.code(), error.to_string().as_str()),
        ("too-many-cells", "262143 cells along x: at most 262142 fit")
    );
}
