//! The seven ways in which a ray can meet a facet: crossing, missing, crossing a point, crossing an edge, parallel,
//! coplanar without and with intersection. Source: the paper, section 2.5 and Figure 6.
//!
//! The octahedron |x| + |y| + |z| <= 3 about the centre of cell (4, 4, 4) has its apexes, and six edges as seen along an
//! axis, on rays; the cube from centre 2 to centre 6 has four sides in planes of rays. The expected cells follow from the
//! tie rule by hand: P stands for P - (e1, e2, e3), e1 >> e2 >> e3.

use hexcast::lines::Lines;

use super::backends::{Backend, flags, mesh};
use super::cases::{Case, one, unit_cells};
use super::compare::assert_same;
use super::models::{Facets, cube, octahedron};

fn nine_cells() -> Lines {
    unit_cells([9; 3])
}

fn on_rays() -> Case {
    one("octahedron", "apexes and edges on rays", nine_cells(), octahedron([1.5; 3], [7.5; 3]))
}

fn on_planes_of_rays() -> Case {
    one("cube", "sides in planes of rays", nine_cells(), cube([2.5; 3], 4.0))
}

/// Cells of the z ray (i, j) that are inside, whatever axis is cast along.
fn cells(case: &Case, i: u32, j: u32) -> Vec<u32> {
    let along = [2, 0, 1].map(|axis| {
        let columns = mesh(Backend::Cpu, case, axis);
        assert_eq!(columns.odd_rays(), 0, "axis {axis}");
        (0..9).filter(|&k| columns.flag([i, j, k]) != Ok(0)).collect::<Vec<_>>()
    });
    assert_eq!([&along[0]; 2], [&along[1], &along[2]], "axes disagree on the ray ({i}, {j})");
    along[0].clone()
}

#[test]
fn case_1_crossing() {
    // inside two facets; |x| + |y| is 2 - e1 - e2, so both ends, at centres, are just inside
    assert_eq!(cells(&on_rays(), 5, 5), [3, 4, 5]);
}

#[test]
fn case_2_missing() {
    assert_eq!(cells(&on_rays(), 7, 7), [0u32; 0]);
    assert_eq!(cells(&on_rays(), 0, 4), [0u32; 0]);
}

#[test]
fn case_3_crossing_point() {
    // through both apexes: |x| + |y| is e1 + e2, which pulls both ends in: 1.5 and 7.5 are outside
    assert_eq!(cells(&on_rays(), 4, 4), [2, 3, 4, 5, 6]);
    // touching the apex at high x: just inside; at low x: just outside
    assert_eq!(cells(&on_rays(), 7, 4), [4]);
    assert_eq!(cells(&on_rays(), 1, 4), [0u32; 0]);
    // at high y, |x| is e1 and |y| 3 - e2: outside
    assert_eq!(cells(&on_rays(), 4, 7), [0u32; 0]);
    assert_eq!(cells(&on_rays(), 4, 1), [0u32; 0]);
}

#[test]
fn case_4_crossing_edge() {
    // over the edges from the upper and lower apex to high x: |x| is 1 - e1, ends just inside; to low x: outside
    assert_eq!(cells(&on_rays(), 5, 4), [2, 3, 4, 5, 6]);
    assert_eq!(cells(&on_rays(), 3, 4), [3, 4, 5]);
    // on the silhouette, where an upper facet meets a lower one: |x| + |y| is 3 - e1 - e2, and 3 - e1 + e2
    assert_eq!(cells(&on_rays(), 6, 5), [4]);
    assert_eq!(cells(&on_rays(), 6, 3), [4]);
    assert_eq!(cells(&on_rays(), 2, 5), [0u32; 0]);
}

#[test]
fn case_5_parallel() {
    // inside and outside the cube, in no plane of its four upright sides
    assert_eq!(cells(&on_planes_of_rays(), 4, 4), [3, 4, 5, 6]);
    assert_eq!(cells(&on_planes_of_rays(), 8, 8), [0u32; 0]);
}

#[test]
fn case_6_coplanar_without_intersection() {
    // in the plane of the side at high x, beyond the side's edge
    assert_eq!(cells(&on_planes_of_rays(), 6, 8), [0u32; 0]);
    assert_eq!(cells(&on_planes_of_rays(), 6, 0), [0u32; 0]);
    assert_eq!(cells(&on_planes_of_rays(), 2, 8), [0u32; 0]);
}

#[test]
fn case_7_coplanar_with_intersection() {
    // along the side at high x or y: inside; at low x or y: outside; along edges where two sides meet: both must agree
    assert_eq!(cells(&on_planes_of_rays(), 6, 4), [3, 4, 5, 6]);
    assert_eq!(cells(&on_planes_of_rays(), 4, 6), [3, 4, 5, 6]);
    assert_eq!(cells(&on_planes_of_rays(), 6, 6), [3, 4, 5, 6]);
    assert_eq!(cells(&on_planes_of_rays(), 2, 4), [0u32; 0]);
    assert_eq!(cells(&on_planes_of_rays(), 4, 2), [0u32; 0]);
    assert_eq!(cells(&on_planes_of_rays(), 2, 6), [0u32; 0]);
    assert_eq!(cells(&on_planes_of_rays(), 6, 2), [0u32; 0]);
}

#[test]
fn the_whole_octahedron_follows_its_formula() {
    // large epsilons stand for small ones: all distances are whole, so any sum under 1 decides alike
    let epsilon = [1e-2, 1e-4, 1e-6];
    let mut expected = Vec::new();
    for cell in 0..9 * 9 * 9 {
        let at = [cell % 9, cell / 9 % 9, cell / 81];
        let distance: f64 = (0..3).map(|axis| (f64::from(at[axis] - 4) - epsilon[axis]).abs()).sum();
        expected.push(u8::from(distance < 3.0));
    }
    for axis in 0..3 {
        assert_same(&format!("axis {axis}"), &expected, &flags(&mesh(Backend::Cpu, &on_rays(), axis)), [9; 3]);
    }
}

#[test]
fn the_cases_hold_wherever_the_body_stands_on_the_rays() {
    // the same octahedron, larger and about another centre, in a domain that cuts it
    let body: Facets = octahedron([-3.5, -2.5, 0.5], [6.5, 7.5, 10.5]);
    let case = one("cut octahedron", "apexes on rays beyond the domain", unit_cells([6, 7, 8]), body);
    let epsilon = [1e-2, 1e-4, 1e-6];
    let mut expected = Vec::new();
    for cell in 0..6 * 7 * 8 {
        let offset = [cell % 6 - 1, cell / 6 % 7 - 2, cell / 42 - 5];
        let distance: f64 = (0..3).map(|axis| (f64::from(offset[axis]) - epsilon[axis]).abs()).sum();
        expected.push(u8::from(distance < 5.0));
    }
    for axis in 0..3 {
        assert_same(&format!("axis {axis}"), &expected, &flags(&mesh(Backend::Cpu, &case, axis)), [6, 7, 8]);
    }
}
