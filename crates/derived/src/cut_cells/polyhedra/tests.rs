//! Meshes of polyhedra are closed, have all of the fluid, and are off by the square of the cell's size.

use std::collections::HashMap;

use super::*;
use crate::cut_cells::tests::models::{cuboid, sphere};
use crate::cut_cells::{CutBy, CutWanted, cut_cells, outline};
use hexcast_core::base::control::{Control, at_once};
use hexcast_core::base::error::Error;
use hexcast_core::grid::closed::Closed;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::window::CellWindow;
use hexcast_core::input::geometry::{Facet, Geometry};
use hexcast_core::input::job::Rule;
use hexcast_core::stages::inside::Kind;

/// A mesh of flag 7, or of what is around it, with its volume and the exact one.
struct Found {
    outline: Outline,
    cells: Polyhedra,
    volume: f64,
    exact: f64,
}

fn found(facets: &[Facet], lines: &Lines, fluid: u8) -> Found {
    let frame = Frame::new(&[Geometry::new("body", 7, facets.to_vec()).unwrap()], lines).unwrap();
    let is_oriented = [Closed::of(frame.facets_at(0)).nonzero];
    let by = CutBy { frame: &frame, lines, rule: Rule::Nonzero, kinds: &[Kind::Cast], is_oriented: &is_oriented };
    let control = Control::default();
    let (window, job) = (CellWindow::all(lines.dims()), CutWanted::default());
    let exact = at_once(cut_cells(by, window, job, u64::MAX, &control)).unwrap().volumes[usize::from(fluid)];
    let outline = at_once(outline(by, (fluid, vec!["body".into()]), &|_| 0, u64::MAX, &control)).unwrap();
    // cells that no surface passes have the flag of their corners, which those before them along x have
    let [nx, ny, nz] = lines.dims();
    let cut: HashMap<u64, [u8; 8]> = outline.cells.iter().map(|of| (of.cell, of.corners)).collect();
    let mut is_whole = Vec::new();
    for index in 0..u64::from(nx) * u64::from(ny) * u64::from(nz) {
        let before = if index % u64::from(nx) == 0 { fluid == 0 } else { is_whole[index as usize - 1] };
        is_whole.push(cut.get(&index).map_or(before, |corners| corners[1] == fluid));
    }
    let cells = at_once(Polyhedra::new(lines, &outline, &is_whole, &control)).unwrap();
    let volume = cells.volumes().iter().map(|(volume, _)| volume).sum();
    Found { outline, cells, volume, exact }
}

fn equal(n: u32) -> Lines {
    Lines::new([-5.0; 3], [10.0 / f64::from(n); 3], [n; 3]).unwrap()
}

/// Holds what every mesh must: each cell is closed and has a volume, faces point from lower numbers to higher, in order, and each point is used.
fn check(name: &str, of: &Polyhedra) {
    for (cell, (volume, vector)) in of.volumes().into_iter().enumerate() {
        assert!(volume > 0.0, "{name}: cell {cell} has volume {volume}");
        assert!(vector.iter().all(|part| part.abs() < 1e-12), "{name}: cell {cell} is open by {vector:?}");
    }
    let key = |face: &Face| match face.behind {
        Behind::Cell(other) => (0, face.owner, other),
        _ => (1, face.owner, 0),
    };
    assert!(of.faces.is_sorted_by_key(key), "{name}");
    let mut is_used = vec![false; of.points.len()];
    for face in &of.faces {
        assert!(if let Behind::Cell(other) = face.behind { face.owner < other && other < of.n_cells } else { true });
        of.corners(face).iter().for_each(|&at| is_used[at as usize] = true);
    }
    assert!(is_used.into_iter().all(|is_used| is_used), "{name}");
}

#[test]
fn bodies_of_any_kind_make_closed_cells() {
    let mut seed = 1u64;
    let mut random = || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 40) as f64 / (1u64 << 24) as f64
    };
    for soup in 0..60 {
        // those that touch, overlap, and lie in lines, too
        let mut facets = Vec::new();
        for _ in 0..=soup % 5 {
            let at = |random: &mut dyn FnMut() -> f64| {
                [0, 1, 2].map(|_| ((random() * 9.0 - 4.5) * 2.0).round() as f32 / 2.0)
            };
            let (a, mut b, c, d) = (at(&mut random), at(&mut random), at(&mut random), at(&mut random));
            if soup % 2 == 0 {
                b[0] += random() as f32 / 3.0;
            }
            let side = |p: [f32; 3]| [0, 1, 2].map(|axis| f64::from(p[axis]) - f64::from(a[axis]));
            let [u, v, w] = [b, c, d].map(side);
            let turn = planar::dot(planar::cross(u, v), w);
            let [b, c] = if turn < 0.0 { [c, b] } else { [b, c] };
            facets.extend([[a, c, b], [a, b, d], [b, c, d], [c, a, d]]);
        }
        for fluid in [0, 7] {
            let Found { cells, .. } = found(&facets, &equal(10), fluid);
            check(&format!("soup {soup}, fluid {fluid}"), &cells);
        }
    }
}

#[test]
fn volumes_are_off_by_the_square_of_the_size() {
    let ball = sphere(200, 4.1, [0.03, -0.02, 0.01]);
    for fluid in [0, 7] {
        let off = [10, 20, 40].map(|n| {
            let Found { outline, cells, volume, exact } = found(&ball, &equal(n), fluid);
            check("ball", &cells);
            assert_eq!(outline.n_thin(), 0);
            (volume - exact).abs() / exact
        });
        assert!(off[0] < 0.04 && off[1] < off[0] / 3.0 && off[2] < off[1] / 3.0, "fluid {fluid}: {off:?}");
    }
}

#[test]
fn small_bodies_are_joined_and_nothing_is_lost() {
    let Found { cells, .. } = found(&sphere(200, 4.1, [0.03, -0.02, 0.01]), &equal(20), 7);
    assert!(cells.counts.joined > 100, "{:?}", cells.counts);
    let least = cells.volumes().iter().map(|(volume, _)| *volume).fold(f64::INFINITY, f64::min);
    assert!(least >= 0.99 * LEAST / 8.0, "{least}");
}

#[test]
fn what_ends_at_the_sides_of_the_box_has_faces_there() {
    let Found { cells, volume, exact, .. } = found(&cuboid([-5.0, -2.5, -1.5], [5.0, 3.5, 4.5]), &equal(20), 7);
    check("bar", &cells);
    let n_of =
        |side: u8| cells.faces.iter().filter(|face| matches!(face.behind, Behind::Side(of, _) if of == side)).count();
    assert!(n_of(0) > 100 && n_of(1) > 100, "{} and {}", n_of(0), n_of(1));
    assert_eq!([2, 3, 4, 5].map(n_of), [0; 4]);
    assert!((volume / exact - 1.0).abs() < 0.02, "{volume} of {exact}");
}

#[test]
fn edges_and_corners_of_bodies_stay() {
    // in lines of the mesh, between them, and both
    let boxes = [([-3.0; 3], [2.0; 3]), ([-3.3, -2.6, -1.7], [2.4, 3.2, 3.6]), ([-3.0, -2.6, -2.0], [2.4, 3.0, 3.6])];
    for (low, high) in boxes {
        let Found { outline, cells, volume, exact } = found(&cuboid(low, high), &equal(10), 7);
        check("box", &cells);
        assert!((volume / exact - 1.0).abs() < 1e-6, "{low:?} to {high:?}: {volume} of {exact}");
        assert!((outline.volume / exact - 1.0).abs() < 1e-12 && cells.counts.wrong == 0, "{:?}", cells.counts);
        // around it some cells would be bent too much
        let Found { cells, volume, exact, .. } = found(&cuboid(low, high), &equal(10), 0);
        check("around a box", &cells);
        let least = if low[1] == low[0] { 1e-6 } else { 0.02 };
        assert!((volume / exact - 1.0).abs() < least, "around {low:?} to {high:?}: {volume} of {exact}");
        assert_eq!(cells.counts.wrong, 0);
    }
    let Found { cells, .. } = found(&cuboid([-3.0; 3], [2.0; 3]), &equal(10), 7);
    assert_eq!((cells.n_cells, cells.points.len()), (125, 216));
    // an edge that is no line: some of its cells are cut flat
    let turned: Vec<Facet> = cuboid([-2.5; 3], [2.5; 3])
        .into_iter()
        .map(|facet| facet.map(|[x, y, z]| [0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y, z + 0.21]))
        .collect();
    for fluid in [0, 7] {
        let Found { cells, volume, exact, .. } = found(&turned, &equal(20), fluid);
        check("turned box", &cells);
        assert!((volume / exact - 1.0).abs() < 1e-2 && cells.counts.wrong == 0, "fluid {fluid}: {volume} of {exact}");
    }
}

#[test]
fn what_is_thinner_than_a_cell_is_counted() {
    let plate = cuboid([-3.2, -3.2, 0.2], [3.2, 3.2, 0.4]);
    let Found { outline, cells, .. } = found(&plate, &equal(10), 0);
    assert!(outline.n_thin() > 20);
    let inside = found(&plate, &equal(10), 7);
    assert_eq!((inside.cells.n_cells, inside.outline.n_left_out()), (0, inside.outline.cells.len()));
    check("plate", &cells);
    assert_eq!(cells.n_cells, 1000);
}

#[test]
fn a_cell_that_is_open_is_an_error() {
    let mut cells = found(&cuboid([-3.0; 3], [2.0; 3]), &equal(10), 7).cells;
    cells.faces.pop();
    assert_eq!(cells.check_closed().unwrap_err().code(), "cut-open");
}

#[test]
fn it_can_be_cancelled_while_cells_are_made() {
    let (outline, control) = (Outline::new(1, Vec::new(), Vec::new(), 0.0), Control::default());
    let made = |control: &Control| at_once(Polyhedra::new(&equal(4), &outline, &[true; 64], control));
    assert_eq!(made(&control).unwrap().n_cells, 64);
    control.cancel.cancel();
    assert_eq!(made(&control), Err(Error::Cancelled));
}
