//! Warnings of a mesh: a table of jobs and of all that each is warned about.

use hexcast::control::Control;
use hexcast::geometry::{Facet, SharedFacets};
use hexcast::job::{AxisChoice, GeometryJob, Job, Open};
use hexcast::pipeline::{Engine, MeshOptions, mesh};
use hexcast::read::{Contents, Format, Solid};
use hexcast::sources::Source;

use super::models;

/// A box, its flag and its priority.
type Body = ([[f32; 3]; 2], u8, i32);

const ROOM: Body = ([[0.0; 3], [8.0; 3]], 1, 0);

/// Meshes boxes in a domain of 8 x 8 x 8 unit cells; returns the warnings. Where `open` says what to do then, boxes lack a facet.
fn warnings(bodies: &[Body], open: Option<Open>, axis: AxisChoice) -> Vec<String> {
    let source = |&([low, high], ..): &Body| {
        let mut facets: Vec<Facet> = models::cuboid(low, high);
        if open.is_some() {
            facets.truncate(facets.len() - 1);
        }
        let n_facets = facets.len() as u64;
        let solids = vec![Solid { name: String::new(), facets: SharedFacets::from(facets) }];
        let contents = Contents {
            format: Format::StlBinary,
            solids,
            n_facets,
            n_bytes: 0,
            wrong_normals: 0,
            zero_normals: 0,
            zero_area: 0,
            has_colours: false,
            warnings: vec![],
        };
        Source { file: "box.stl".into(), contents, sha256: String::new() }
    };
    let geometry = |(index, &(_, flag, priority)): (usize, &Body)| GeometryJob {
        name: Some(format!("box {index}")),
        flag: Some(flag),
        priority,
        ..GeometryJob::new("box.stl")
    };
    let geometries = bodies.iter().enumerate().map(geometry).collect();
    let domain = Some([0.0, 0.0, 0.0, 8.0, 8.0, 8.0]);
    let job = Job { geometries, domain, dims: Some([8; 3]), axis, open: open.unwrap_or_default(), ..Job::default() };
    let sources = bodies.iter().map(source).collect();
    let (options, mut engine, control) = (MeshOptions::default(), Engine::cpu(), Control::default());
    let meshed = pollster::block_on(mesh(&job, sources, &options, &mut engine, &control));
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
                "geometry \"box 1\" (flag 2) got no cell: it is 0.9000000953674316 thick along x, a cell is 1.0; use smaller cells, \
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
            &["geometry \"box 1\" (flag 2) got no cell: it is 3.0 thick along x, a cell is 1.0; use smaller cells, \
               or check the priorities of the geometries that overlap it"],
        ),
    ];
    for (what, bodies, expected) in cases {
        for axis in AXES {
            assert_eq!(warnings(bodies, None, axis), *expected, "{what}, along {axis:?}");
        }
    }
}

#[test]
fn a_surface_that_is_open_is_named_along_every_axis() {
    let expected = "geometry \"box 0\" is not closed: open edges 3, in 1 loops, the longest edge at (4, 4, 8); ";
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
        let found = warnings(&[ROOM], Some(Open::Parity), axis);
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
