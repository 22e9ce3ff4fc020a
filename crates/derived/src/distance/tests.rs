//! Numbers of blocks and of bands: the same bits as by all facets, one by one.

use super::blocks::{Blocks, Memory};
use super::facet::{Corners, Facet};
use super::features::Features;
use super::scan::{Part, Places, Scan};
use super::tree::Tree;

struct Random(u64);

impl Random {
    fn below(&mut self, size: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / f64::from(1 << 24) * size
    }
}

/// Facets that have no corner in common, a tenth of them large.
fn soup(random: &mut Random, n: usize) -> Vec<Corners> {
    let facet = |index: usize| {
        let place = [0, 1, 2].map(|_| random.below(7.0));
        [0, 1, 2].map(|_| place.map(|at| at + random.below(if index.is_multiple_of(10) { 9.0 } else { 0.5 })))
    };
    (0..n).map(facet).collect()
}

/// A surface with a rim, whose facets share corners and edges: rough, in steps, or a plane.
fn sheet(random: &mut Random, height: f64, is_stepped: bool) -> Vec<Corners> {
    const N: usize = 9;
    let heights: Vec<f64> = (0..N * N).map(|_| random.below(height)).collect();
    let corner = |x: usize, y: usize| {
        let at = heights[x + N * y];
        [0.9 * x as f64 - 0.7, 0.8 * y as f64 + 0.1, 3.0 + if is_stepped { at.round() } else { at }]
    };
    let squares = (0..N - 1).flat_map(|y| (0..N - 1).map(move |x| (x, y)));
    let both = |(x, y): (usize, usize)| {
        let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
        // half of them are turned over
        [[a, b, c], if x.is_multiple_of(2) { [a, c, d] } else { [c, a, d] }]
    };
    squares.flat_map(both).collect()
}

fn cases() -> Vec<(&'static str, Vec<Corners>)> {
    let mut random = Random(1);
    let spike = |to: [f64; 3]| {
        let [a, b, c] = [[2.0, 2.0, 2.0], [5.0, 2.0, 2.0], [2.0, 5.0, 2.0]];
        [[a, c, b], [a, b, to], [b, c, to], [c, a, to]]
    };
    let flat = [[1.0, 2.0, 3.0]; 3];
    let lines = [[[4.0, 1.0, 1.0], [6.0, 2.0, 4.0], [4.0, 1.0, 1.0]], [[0.0; 3], [8.0, 4.0, 2.0], [2.0, 1.0, 0.5]]];
    let soup = soup(&mut random, 120);
    vec![
        ("soup", soup.clone()),
        ("each facet twice", soup.iter().chain(&soup).copied().collect()),
        ("rough", sheet(&mut random, 2.5, false)),
        ("steps", sheet(&mut random, 3.0, true)),
        ("plane", sheet(&mut random, 0.0, false)),
        ("spikes", spike([3.0, 3.0, 9.0]).into_iter().chain(spike([2.1, 2.1, 2.2])).collect()),
        ("points and lines", [flat].into_iter().chain(lines).chain(soup[..9].iter().copied()).collect()),
        ("none", Vec::new()),
    ]
}

/// Compares what is found of all points with the least by all facets.
fn check(name: &str, facets: &[Facet], width: f64, found: impl Fn(Places) -> Vec<f64>) {
    let all = [41, 38, 27].map(|n| (0..n).map(|at| f64::from(at) * 0.61 - 1.0).collect::<Vec<f64>>());
    let found = found([0, 1, 2].map(|axis| &all[axis][..]));
    let mut index = 0;
    for z in &all[2] {
        for y in &all[1] {
            for x in &all[0] {
                let squares = facets.iter().map(|facet| facet.square(&[*x, *y, *z]));
                let expected = squares.fold(f64::INFINITY, f64::min).sqrt().min(width);
                let found = found[index];
                assert!(
                    found.to_bits() == expected.to_bits(),
                    "{name}, width {width}, ({x}, {y}, {z}): {found}, not {expected}"
                );
                index += 1;
            }
        }
    }
}

/// Points near and far, of many blocks.
#[test]
fn numbers_do_not_depend_on_blocks() {
    for (name, corners) in cases() {
        let facets: Vec<Facet> = corners.iter().map(Facet::new).collect();
        let tree = Tree::new(corners);
        for width in [f64::INFINITY, 4.0, 0.3] {
            check(name, &facets, width, |places| {
                Blocks { tree: &tree, width, places }.distances(&mut Memory::default())
            });
        }
    }
}

#[test]
fn what_a_band_has_is_the_least_by_all_facets() {
    for (name, corners) in cases() {
        let facets: Vec<Facet> = corners.iter().map(Facet::new).collect();
        let tree = Tree::new(corners);
        let features = Features::new(tree.facets());
        for width in [9.0, 1.7, 0.3] {
            check(name, &facets, width, |places| {
                Scan { tree: &tree, features: &features, width, places }.distances(&mut Part::default())
            });
        }
    }
}
