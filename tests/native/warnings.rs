//! Warnings of a mesh: a table of jobs and of all that each is warned about.

use hexcast::control::Control;
use hexcast::geometry::{Facet, Fill};
use hexcast::job::{AxisChoice, GeometryJob, Job, Open, Rule};
use hexcast::pipeline::{Engine, MeshOptions, mesh};
use hexcast::sources::Source;

use super::models;

/// A box, its flag and its priority.
type Body = ([[f32; 3]; 2], u8, i32);

const ROOM: Body = ([[0.0; 3], [8.0; 3]], 1, 0);

/// Meshes boxes in a domain of 8 x 8 x 8 unit cells; returns the warnings. Where `open` says what to do then, boxes lack a facet.
fn warnings(bodies: &[Body], open: Option<Open>, axis: AxisChoice) -> Vec<String> {
    let surfaces = bodies.iter().map(|&([low, high], flag, priority)| {
        let mut facets: Vec<Facet> = models::cuboid(low, high);
        if open.is_some() {
            facets.truncate(facets.len() - 1);
        }
        (facets, Some(flag), priority)
    });
    let job = set!(Job { axis, open: open.unwrap_or_default(), ..Job::default() });
    warnings_of(&surfaces.collect::<Vec<_>>(), &job)
}

/// Meshes surfaces with flags and priorities in the same domain.
fn warnings_of(surfaces: &[(Vec<Facet>, Option<u8>, i32)], job: &Job) -> Vec<String> {
    let source = |(facets, ..): &(Vec<Facet>, Option<u8>, i32)| {
        Source::from_facets("box.stl", facets.clone()).expect("finite facets")
    };
    let geometry = |(index, &(_, flag, priority)): (usize, &(Vec<Facet>, Option<u8>, i32))| {
        set!(GeometryJob { name: Some(format!("box {index}")), flag, priority, ..GeometryJob::new("box.stl") })
    };
    let geometries = surfaces.iter().enumerate().map(geometry).collect();
    let domain = Some([0.0, 0.0, 0.0, 8.0, 8.0, 8.0]);
    // what the checks of shells find is the business of `lost_shells`
    let job = set!(Job { geometries, domain, dims: Some([8; 3]), quick: true, ..job.clone() });
    warnings_of_sources(&job, surfaces.iter().map(source).collect())
}

/// Meshes the surfaces of a job on the CPU; returns the warnings.
fn warnings_of_sources(job: &Job, sources: Vec<Source>) -> Vec<String> {
    let (options, mut engine, control) = (MeshOptions::default(), Engine::cpu(), Control::default());
    let meshed = pollster::block_on(mesh(job, sources, &options, &mut engine, &control));
    meshed.expect("a mesh").1.warnings
}

const AXES: [AxisChoice; 3] = [AxisChoice::X, AxisChoice::Y, AxisChoice::Z];

#[test]
fn a_geometry_without_cells_is_named_with_the_cause() {
    let body = |low: [f32; 3], high: [f32; 3], flag: u8| ([low, high], flag, 0);
    let cases: &[(&str, &[Body], &[&str])] = &[
        ("one body", &[ROOM], &[]),
        ("a plate with cells", &[ROOM, body([1.0, 1.0, 2.25], [7.0, 7.0, 2.75], 2)], &[]),
        (
            "a plate between centres",
            &[ROOM, body([1.0, 1.0, 2.75], [7.0, 7.0, 3.25], 2)],
            &["geometry \"box 1\" (flag 2) got no cell: it is 0.5 thick along z, a cell is 1.0; use smaller cells, \
              or keep it with fill = \"separating\" or \"conservative\""],
        ),
        (
            "the same with a flag that others have",
            &[ROOM, body([1.0, 2.75, 1.0], [7.0, 3.25, 7.0], 1)],
            &["geometry \"box 1\" (flag 1) got no cell: it is 0.5 thick along y, a cell is 1.0; use smaller cells, \
              or keep it with fill = \"separating\" or \"conservative\""],
        ),
        (
            "a plate up to a centre: cell 2 ends the body, and cell 3 is not in it",
            &[ROOM, body([2.5, 1.0, 1.0], [3.4, 7.0, 7.0], 2)],
            &[
                "geometry \"box 1\" (flag 2) got no cell: it is 0.9000001 thick along x, a cell is 1.0; use smaller cells, \
                  or keep it with fill = \"separating\" or \"conservative\"",
            ],
        ),
        ("a plate on the next centre", &[ROOM, body([2.5, 1.0, 1.0], [3.5, 7.0, 7.0], 2)], &[]),
        (
            "a body beside the domain",
            &[ROOM, body([1.0, 1.0, 9.0], [7.0, 7.0, 12.0], 1)],
            &[
                "geometry \"box 1\" (flag 1) got no cell: it reaches from 9.0 to 12.0 along z, the domain from 0.0 to 8.0",
            ],
        ),
        (
            "a body before the domain",
            &[ROOM, body([-3.0, 1.0, 1.0], [0.0, 7.0, 7.0], 2)],
            &[
                "geometry \"box 1\" (flag 2) got no cell: it reaches from -3.0 to 0.0 along x, the domain from 0.0 to 8.0",
            ],
        ),
        (
            "a body in the last half cell",
            &[ROOM, body([7.75, 1.0, 1.0], [7.875, 7.0, 7.0], 2)],
            &["geometry \"box 1\" (flag 2) got no cell: it is 0.125 thick along x, a cell is 1.0; use smaller cells, \
              or keep it with fill = \"separating\" or \"conservative\""],
        ),
        (
            "a body covered by one of higher priority",
            &[([[0.0; 3], [8.0; 3]], 1, 1), body([1.0, 1.0, 1.0], [4.0, 7.0, 7.0], 2)],
            &[
                "geometry \"box 1\" (flag 2) got no cell: its cells are those of \"box 0\" (flag 1), which wins; give it a higher priority",
            ],
        ),
    ];
    for (what, bodies, expected) in cases {
        for axis in AXES {
            assert_eq!(warnings(bodies, None, axis), *expected, "{what}, along {axis:?}");
        }
    }
}

#[test]
fn a_plate_with_the_cells_along_its_surface_is_told_who_has_them() {
    let (domain, plate) = ([[0.0; 3], [8.0; 3]], [[1.0, 1.0, 2.75], [7.0, 7.0, 3.25]]);
    for fill in [Fill::Separating, Fill::Conservative] {
        for axis in AXES {
            let found = |room_wins: bool| {
                let bodies = [(domain, i32::from(room_wins), None), (plate, 0, Some(fill))];
                let [room, plate] = [0, 1].map(|index| {
                    let (_, priority, fill) = bodies[index];
                    set!(GeometryJob {
                        name: Some(format!("box {index}")),
                        priority,
                        fill,
                        ..GeometryJob::new("box.stl")
                    })
                });
                let sources = bodies.map(|([low, high], ..)| {
                    Source::from_facets("box.stl", models::cuboid(low, high)).expect("finite facets")
                });
                let domain = Some([0.0, 0.0, 0.0, 8.0, 8.0, 8.0]);
                let job = set!(Job {
                    geometries: vec![room, plate],
                    domain,
                    dims: Some([8; 3]),
                    axis,
                    quick: true,
                    ..Job::default()
                });
                warnings_of_sources(&job, sources.to_vec())
            };
            let sentence = "geometry \"box 1\" (flag 2) got no cell: its cells are those of \"box 0\" (flag 1), which wins; \
                            give it a higher priority";
            assert_eq!(found(true), [sentence], "{fill:?}");
            assert!(found(false).iter().all(|warning| !warning.contains("got no cell")), "{fill:?}");
        }
    }
}

#[test]
fn a_surface_that_is_open_is_named_along_every_axis() {
    let expected = "geometry \"box 0\" is not closed: open edges 3, loops 1, the longest edge at (4, 4, 8); ";
    for axis in AXES {
        let found = warnings(&[ROOM], Some(Open::Winding), axis);
        let [warning] = &found[..] else { panic!("{found:?}") };
        assert!(warning.starts_with(expected) && warning.contains(" along x, 0 along y, "), "{warning}");
        assert!(warning.ends_with("of 512 cells were doubtful and were decided by the winding number"), "{warning}");
        assert_eq!(found, warnings(&[ROOM], Some(Open::Winding), AxisChoice::Auto));
    }
}

#[test]
fn rays_of_one_axis_that_find_a_surface_open_are_counted() {
    let mut n_open = 0;
    for axis in AXES {
        let mut found = warnings(&[ROOM], Some(Open::Parity), axis);
        found.retain(|warning| {
            !warning.starts_with("geometry \"box 0\" is not closed: open edges 3, 3 of them between")
        });
        assert!(found.len() < 2, "{found:?}");
        // a facet of a side across the rays is missing: half of them enter and do not leave
        if let Some(warning) = found.first() {
            let n_odd: u32 = warning.split(' ').next().unwrap_or_default().parse().expect("a number");
            assert!((28..=36).contains(&n_odd) && warning.contains(" of 64 rays do not leave"), "{warning}");
            n_open += 1;
        }
    }
    assert_eq!(n_open, 1, "the facet is missing across one axis");
}

#[test]
fn a_geometry_without_cells_says_whether_it_is_flat_or_open_or_misses_all_centres() {
    let only = |facets: Vec<Facet>| {
        let room = models::cuboid([0.0; 3], [8.0; 3]);
        warnings_of(&[(room, None, 0), (facets, None, 0)], &Job::default())
    };
    let line = vec![[[1.0, 1.0, 1.0], [5.0, 5.0, 5.0], [3.0, 3.0, 3.0]]; 2];
    let flat = "geometry \"box 1\" (flag 2) got no cell: none of its facets has an area; repair the file";
    assert_eq!(only(line), [flat]);
    let square =
        vec![[[1.0, 1.0, 1.0], [7.0, 1.0, 1.0], [7.0, 7.0, 6.0]], [[1.0, 1.0, 1.0], [7.0, 7.0, 6.0], [1.0, 7.0, 6.0]]];
    let found = only(square);
    let sheet = "geometry \"box 1\" (flag 2) got no cell: its surface is not closed and encloses no centre of a cell; close it, or keep it \
                 with fill = \"separating\" or \"conservative\"";
    assert!(found.len() == 2 && found[0].contains("is not closed: open edges 4") && found[1] == sheet, "{found:?}");
    let level =
        vec![[[1.0, 1.0, 3.0], [7.0, 1.0, 3.0], [7.0, 7.0, 3.0]], [[1.0, 1.0, 3.0], [7.0, 7.0, 3.0], [1.0, 7.0, 3.0]]];
    let found = only(level);
    let in_plane = "got no cell: it lies in a plane across z, with no inside; files for openEMS and gprMax have its faces if it is a perfect \
                    conductor; for others take those of a staggered grid (staggered), or keep it";
    assert!(found.len() == 2 && found[1].contains(in_plane), "{found:?}");
    // a slanted plate between the diagonals of centres
    let plate = models::tetrahedron([[1.0, 1.0, 1.1], [5.0, 1.0, 5.1], [1.0, 5.0, 1.1], [5.0, 5.0, 5.15]]);
    let found = only(plate);
    assert!(
        found.len() == 1 && found[0].contains("it encloses no centre of a cell; use smaller cells, or keep it"),
        "{found:?}"
    );
}

#[test]
fn a_flag_that_two_geometries_have_by_chance_is_said() {
    let at = |x: f32| models::cuboid([x, 1.0, 1.0], [x + 2.0, 7.0, 7.0]);
    let found = |flags: [Option<u8>; 3]| {
        let surfaces: Vec<_> = flags.iter().zip([0.0, 3.0, 6.0]).map(|(&flag, x)| (at(x), flag, 0)).collect();
        warnings_of(&surfaces, &Job::default())
    };
    for flags in [[None; 3], [Some(1), Some(1), None], [Some(7), Some(7), Some(7)]] {
        assert_eq!(found(flags), Vec::<String>::new(), "{flags:?}");
    }
    let sentence = "geometries \"box 0\" and \"box 1\" both have the flag 2, which nobody gave to \"box 1\": it is its position in the \
                    job; give it a flag, for example 1";
    assert_eq!(found([Some(2), None, None]), [sentence]);
    assert_eq!(found([None, Some(1), None]).len(), 1);
}

#[test]
fn shells_that_overlap_are_said_where_the_rule_leaves_two_of_them_outside() {
    let balls = models::joined([models::sphere([3.2; 3], 2.6, 12), models::sphere([4.8; 3], 2.6, 12)]);
    let cavity = |inner: Vec<Facet>| models::joined([models::cuboid([1.0; 3], [7.0; 3]), inner]);
    let inner = models::cuboid([2.6; 3], [5.4; 3]);
    let with = |facets: &Vec<Facet>, rule: Rule, axis: AxisChoice| {
        warnings_of(&[(facets.clone(), None, 0)], &set!(Job { rule, axis, ..Job::default() }))
    };
    for axis in AXES {
        let found = with(&balls, Rule::Parity, axis);
        assert!(
            matches!(&found[..], [one] if one.starts_with("shells of geometry \"box 0\" overlap, or a cavity")),
            "{found:?}"
        );
        assert_eq!(with(&balls, Rule::Nonzero, axis), Vec::<String>::new());
        // a hole that is turned inwards is one, and one that is turned outwards might be none
        assert_eq!(with(&cavity(models::flipped(inner.clone())), Rule::Parity, axis), Vec::<String>::new());
        let found = with(&cavity(inner.clone()), Rule::Parity, axis);
        assert!(matches!(&found[..], [one] if one.contains("8 cells on 64 rays")), "{found:?}");
        // facets that do not agree say nothing
        let mut mixed = balls.clone();
        mixed.iter_mut().step_by(3).for_each(|facet| facet.swap(1, 2));
        assert_eq!(with(&mixed, Rule::Parity, axis), Vec::<String>::new());
        let inwards = with(&models::flipped(models::sphere([4.0; 3], 3.0, 12)), Rule::Parity, axis);
        assert!(matches!(&inwards[..], [one] if one.contains("is inside out")), "{inwards:?}");
    }
}

#[test]
fn a_closed_surface_that_is_inside_out_is_said_and_has_its_cells() {
    let out = models::sphere([4.0; 3], 3.0, 12);
    let volume = models::signed_volume(&out);
    let holed = models::flipped(out[..out.len() - 1].to_vec());
    // a cavity faces inwards, rightly
    let hollow = [out.clone(), models::flipped(models::sphere([4.0; 3], 2.0, 12))].concat();
    for (facets, is_said) in [
        (out.clone(), false),
        (models::flipped(out), true),
        (hollow.clone(), false),
        (models::flipped(hollow), true),
        (holed, false),
    ] {
        for rule in [Rule::Parity, Rule::Nonzero] {
            let job = set!(Job { rule, ..Job::default() });
            let found = warnings_of(&[(facets.clone(), Some(1), 0)], &job);
            let said: Vec<&String> = found.iter().filter(|text| text.contains("is inside out")).collect();
            assert_eq!(said.len(), usize::from(is_said), "{rule:?}: {found:?}");
            assert!(
                said.iter().all(|text| text.starts_with("geometry \"box 0\"") && text.contains("its volume is -")),
                "{said:?}"
            );
        }
    }
    assert!(volume > 0.0);
}
