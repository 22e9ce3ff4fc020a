//! The solids that made faces between flags: against where the faces are.

use std::collections::BTreeMap;

use hexcast::control::Control;
use hexcast::geometry::Facet;
use hexcast::job::{GeometryJob, Job, LinesJob};
use hexcast::mesh::Mesh;
use hexcast::pipeline::{self, Engine, MeshOptions};
use hexcast::sources::Source;

use super::models::{self, Facets};

/// A file with solids, as text.
fn source(name: &str, solids: &[(&str, Facets)]) -> Source {
    let corner = |[x, y, z]: &[f32; 3]| format!("vertex {x:?} {y:?} {z:?}\n");
    let facet = |facet: &Facet| {
        let corners: String = facet.iter().map(corner).collect();
        format!("facet normal 0 0 0\nouter loop\n{corners}endloop\nendfacet\n")
    };
    let solid = |(name, facets): &(&str, Facets)| {
        let facets: String = facets.iter().map(facet).collect();
        format!("solid {name}\n{facets}endsolid\n")
    };
    let text: String = solids.iter().map(solid).collect();
    Source::read(name, text.len() as u64, &mut text.as_bytes(), &Control::default()).unwrap()
}

/// Facets by which side of the middle they lie on, on each axis.
fn in_octants(facets: &[Facet], middle: [f32; 3]) -> Vec<(String, Facets)> {
    let mut octants: BTreeMap<String, Facets> = BTreeMap::new();
    for facet in facets {
        let side = |axis: usize| facet.iter().map(|corner| corner[axis] - middle[axis]).sum::<f32>() > 0.0;
        let name = [0, 1, 2].map(|axis| if side(axis) { "+" } else { "-" }).concat();
        octants.entry(name).or_default().push(*facet);
    }
    octants.into_iter().collect()
}

fn meshed(job: &Job, sources: Vec<Source>) -> Mesh {
    let options = MeshOptions::default().with_walls(true);
    let engine = &mut Engine::cpu();
    pollster::block_on(pipeline::mesh(job, sources, &options, engine, &Control::default())).unwrap().0
}

/// Every face between two flags, and at the sides of the box, with the flags on both sides.
fn for_each_face(mesh: &Mesh, mut visit: impl FnMut(usize, [u32; 3], [Option<u8>; 2])) {
    let n = mesh.dims();
    for axis in 0..3 {
        let mut end = n;
        end[axis] += 1;
        for (z, y) in (0..end[2]).flat_map(|z| (0..end[1]).map(move |y| (z, y))) {
            for x in 0..end[0] {
                let face = [x, y, z];
                let beside = [1, 0].map(|before| {
                    let mut cell = face;
                    cell[axis] = cell[axis].checked_sub(before)?;
                    mesh.flag(cell).ok()
                });
                if beside[0] != beside[1] {
                    visit(axis, face, beside);
                }
            }
        }
    }
}

#[test]
fn faces_have_the_solid_beside_them() {
    let middle = [5.03, 4.97, 5.11];
    let octants = in_octants(&models::sphere(middle, 4.2, 24), middle);
    assert_eq!(octants.len(), 8);
    let solids: Vec<(&str, Facets)> = octants.iter().map(|(name, facets)| (&**name, facets.clone())).collect();
    let lines = |sizes: &[f64], n: usize| -> Vec<f64> {
        let step = |line: &mut f64, cell: usize| {
            *line += sizes[cell % sizes.len()];
            Some(*line)
        };
        [0.0].into_iter().chain((0..n).scan(0.0, step)).collect()
    };
    for (sizes, n) in [(&[0.5][..], 20), (&[0.5, 0.7, 0.8], 15)] {
        let (x, y, z) = (lines(sizes, n), lines(sizes, n), lines(sizes, n));
        let all = [x.clone(), y.clone(), z.clone()];
        let job = set!(Job { lines: Some(LinesJob { x, y, z }), ..job(1) });
        let mesh = meshed(&job, vec![source("ball.stl", &solids)]);
        let walls = mesh.walls().unwrap();
        let (mut n_faces, mut n_near) = (0, 0);
        for_each_face(&mesh, |axis, face, flags| {
            let wall = walls.wall(axis, face);
            // no facet lies between the last centre and the side of the box
            if flags.contains(&None) {
                assert_eq!(wall, None, "{axis} {face:?}");
                return;
            }
            let place = |of: usize| {
                let at = face[of] as usize;
                let cell = (all[of][at] + all[of].get(at + 1).copied().unwrap_or(all[of][at])) / 2.0;
                (if of == axis { all[of][at] } else { cell }) - f64::from(middle[of])
            };
            let place = [0, 1, 2].map(place);
            n_faces += 1;
            let name = &walls.names[wall.expect("a facet") as usize];
            for (of, side) in name.chars().enumerate() {
                // the facet is within a cell of the face
                if place[of].abs() < 1.2 {
                    n_near += 1;
                } else {
                    assert_eq!(side == '+', place[of] > 0.0, "{axis} {face:?} {place:?} {name}");
                }
            }
        });
        assert!(n_faces > 600 && n_near < 2 * n_faces, "{n_faces} faces, {n_near}");
    }
}

fn job(n: usize) -> Job {
    set!(Job { geometries: vec![GeometryJob::new("a.stl"); n], ..Job::default() })
}

#[test]
fn a_box_on_the_sides_of_the_domain_has_its_solids_there_and_the_higher_body_names_what_two_share() {
    // sides of a duct that fills the box, and a block in it
    let facets = models::cuboid([0.0; 3], [6.0, 4.0, 5.0]);
    let side =
        |axis: usize, at: f32| facets.iter().filter(|facet| facet.iter().all(|c| c[axis] == at)).copied().collect();
    let duct: Vec<(&str, Facets)> = vec![
        ("inlet", side(0, 0.0)),
        ("outlet", side(0, 6.0)),
        ("front", side(1, 0.0)),
        ("back", side(1, 4.0)),
        ("floor", side(2, 0.0)),
        ("", side(2, 5.0)),
    ];
    let block = models::cuboid([2.2, 1.1, 1.3], [3.9, 3.2, 2.8]);
    let mut job = job(2);
    job.domain = Some([0.0, 0.0, 0.0, 6.0, 4.0, 5.0]);
    job.dims = Some([12, 8, 10]);
    job.geometries[0].name = Some("duct".into());
    job.geometries[1].name = Some("block".into());
    let sources = || vec![source("duct.stl", &duct), source("block.stl", &[("a", block.clone())])];
    let mesh = meshed(&job, sources());
    let walls = mesh.walls().unwrap();
    assert_eq!(walls.names, ["inlet", "outlet", "front", "back", "floor", "duct_6", "block"]);
    let mut n = [0; 7];
    for_each_face(&mesh, |axis, face, flags| {
        let wall = walls.wall(axis, face).expect("a wall") as usize;
        n[wall] += 1;
        let expected = if flags.contains(&None) { 2 * axis + usize::from(face[axis] > 0) } else { 6 };
        assert_eq!(wall, expected, "{axis} {face:?}");
    });
    assert_eq!(n[..6], [80, 80, 120, 120, 96, 96]);
    assert!(n[6] > 40);
    // those of a window are those of the box
    job.window = Some([3, 0, 2, 8, 8, 7]);
    for halo in [0, 2] {
        job.halo = Some(halo);
        let part = meshed(&job, sources());
        let of_part = part.walls().unwrap();
        let mut n_same = 0;
        for_each_face(&mesh, |axis, face, _| {
            let moved = [0, 1, 2].map(|of| face[of] as i64 - [3, 0, 2][of] + i64::from(halo));
            let end = [0, 1, 2].map(|of| i64::from(part.dims()[of]) + i64::from(of == axis));
            if (0..3).all(|of| (0..end[of]).contains(&moved[of])) {
                n_same += 1;
                assert_eq!(
                    of_part.wall(axis, moved.map(|at| at as u32)),
                    walls.wall(axis, face),
                    "{halo} {axis} {face:?}"
                );
            }
        });
        assert!(n_same > 100, "{n_same}");
    }
}
