use std::future::ready;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

use super::*;
use crate::base::control::at_once;
use crate::input::geometry::Facet;
use crate::input::job::Rule;
use crate::stages::cast::Cast;
use crate::stages::cpu::columns;

/// A wavy ball of 2 n x n facets and a tetrahedron, of which the later wins.
fn geometries(n: usize) -> Vec<Geometry> {
    let corner = |i: usize, j: usize| {
        let (u, v) = ((i % n) as f64 / n as f64 * std::f64::consts::TAU, j as f64 / n as f64 * std::f64::consts::PI);
        let radius = if j == 0 || j == n { 1.0 } else { 1.0 + 0.1 * (5.0 * u).sin() * v.sin() };
        let around = if j == 0 || j == n { [0.0; 2] } else { [radius * v.sin() * u.cos(), radius * v.sin() * u.sin()] };
        [around[0], around[1], radius * v.cos()].map(|c| c as f32)
    };
    let square = |i: usize, j: usize| {
        let [a, b, c, d] = [corner(i, j), corner(i, j + 1), corner(i + 1, j + 1), corner(i + 1, j)];
        [[a, b, c], [a, c, d]]
    };
    let ball: Vec<Facet> = (0..n).flat_map(|j| (0..n).flat_map(move |i| square(i, j))).collect();
    let [o, x, y, z] = [[-0.5; 3], [0.9, -0.5, -0.5], [-0.5, 0.9, -0.5], [-0.5, -0.5, 0.9]];
    let tetrahedron = vec![[o, y, x], [o, x, z], [o, z, y], [x, y, z]];
    vec![Geometry::new("ball", 3, ball).unwrap(), Geometry::new("tetrahedron", 5, tetrahedron).unwrap()]
}

fn lines() -> Lines {
    Lines::new([-1.2; 3], [0.15; 3], [16; 3]).unwrap()
}

fn snapped(geometries: &[Geometry], rays: Option<&Rays>) -> (Snapped, usize) {
    let lines = lines();
    let n_rests = Arc::new(AtomicUsize::new(0));
    let counted = n_rests.clone();
    let control = Control::default().pausing(move || {
        counted.fetch_add(1, Relaxed);
        Box::pin(ready(()))
    });
    let (snapped, _) =
        at_once(super::snapped(geometries, &lines, (rays, Rule::Parity), &Memory::default(), &control)).unwrap();
    (snapped, n_rests.load(Relaxed))
}

#[test]
fn with_all_facets_it_is_the_frame_and_what_its_facets_tell() {
    let geometries = geometries(40);
    let (found, _) = snapped(&geometries, None);
    assert_eq!(found.frame, Frame::new(&geometries, &lines()).unwrap());
    assert_eq!(found.closed, [0, 1].map(|rank| Closed::of(found.frame.facets_at(rank))));
    assert!(found.closed.iter().all(|closed| closed.is_proper));
    for rank in [0, 1] {
        let facets = found.frame.facets_at(rank);
        let along = |axis: usize| facets.as_flattened().iter().map(move |corner| corner[axis]);
        let low = [0, 1, 2].map(|axis| along(axis).min().unwrap());
        let high = [0, 1, 2].map(|axis| along(axis).max().unwrap());
        assert_eq!(found.ends[rank], Some([low, high]));
        let parts = facets.chunks(volume_bound::CHUNK).map(|part| BoundSums::of(part, found.frame.fraction_bits));
        assert_eq!(found.bound_sums[rank], parts.fold(BoundSums::default(), BoundSums::plus));
    }
}

#[test]
fn facets_that_no_ray_meets_go_and_all_else_stays() {
    let geometries = geometries(300);
    let (whole, _) = snapped(&geometries, None);
    for axis in 0..3 {
        let rays = Rays::new(axis, lines().dims());
        let (few, _) = snapped(&geometries, Some(&rays));
        assert!(10 * few.frame.facets.len() < whole.frame.facets.len(), "{} stay", few.frame.facets.len());
        assert!(few.frame.facets.capacity() == few.frame.facets.len());
        assert_eq!((&few.closed, &few.ends, &few.bound_sums), (&whole.closed, &whole.ends, &whole.bound_sums));
        let meshed = |frame: &Frame| columns(&Cast { frame, rays: &rays, rule: Rule::Parity }, &Control::default());
        assert_eq!(meshed(&few.frame).unwrap().cells_per_flag(), meshed(&whole.frame).unwrap().cells_per_flag());
        let runs = |frame: &Frame| {
            let columns = meshed(frame).unwrap();
            (0..rays.n_rays()).map(|ray| columns.ray(ray).unwrap().into_owned()).collect::<Vec<_>>()
        };
        assert_eq!(runs(&few.frame), runs(&whole.frame));
    }
}

#[test]
fn it_rests_after_some_facets() {
    // 720,000 facets: two rests, and three before their edges are compared; surfaces of few rest once before that
    let n_rests = |n| snapped(&geometries(n), None).1;
    assert_eq!(n_rests(4), 2);
    assert!(n_rests(600) >= 2 + 2 + 2, "{}", n_rests(600));
}

#[test]
fn an_open_surface_is_found_and_room_is_made_for_all() {
    let mut geometries = geometries(600);
    let facets = geometries[0].facets.slice().to_vec();
    geometries[0].facets = facets[1..].to_vec().into();
    let (found, _) = snapped(&geometries, None);
    assert_eq!(found.closed.iter().map(|closed| closed.parity).collect::<Vec<_>>(), [false, true]);
    let mut room = Vec::new();
    make_room(&mut room, 100, 0.0);
    assert_eq!(room.capacity(), 100);
    // as many stay of all as of the first quarter
    room.resize(100, [[0; 3]; 3]);
    make_room(&mut room, 100, 0.25);
    assert_eq!(room.capacity(), 404);
    // some more did: there is room for those of now
    room.resize(400, [[0; 3]; 3]);
    make_room(&mut room, 200, 0.9);
    assert_eq!(room.capacity(), 600);
}
