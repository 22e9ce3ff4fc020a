//! The case table: small domains that between them reach every branch of every stage. Kernels, the line, golden files and
//! the browser all run this one table.
//!
//! It needs `models` and `soups` beside it and nothing of the machine: no files, no clock, no platform mathematics. Names are
//! unique and stable (golden files carry them); `why` says what a case is for.

use hexcast::geometry::{Facet, Geometry, Placing};
use hexcast::lines::Lines;
use hexcast_core::stages::map::Rule;

use super::models::{self, Facets, cube, cuboid, flipped, joined, moved, octahedron, scaled, sphere, tetrahedron};
use super::soups;

/// One thing to mesh.
#[derive(Debug, Clone)]
pub(crate) struct Case {
    /// Unique name, lower case with hyphens.
    pub name: String,
    /// Why the case exists.
    pub why: &'static str,
    /// What to mesh.
    pub geometries: Vec<Geometry>,
    /// Where.
    pub lines: Lines,
    /// What is inside.
    pub rule: Rule,
}

impl Case {
    fn nonzero(mut self) -> Case {
        self.rule = Rule::Nonzero;
        self
    }

    /// The facets of all geometries.
    pub(crate) fn n_facets(&self) -> usize {
        self.geometries.iter().map(|geometry| geometry.facets.len()).sum()
    }
}

/// Builds a case of one geometry with flag 1, rule parity.
pub(crate) fn one(name: &str, why: &'static str, lines: Lines, facets: Facets) -> Case {
    several(name, why, lines, vec![Geometry::new(name, 1, facets).unwrap()])
}

/// Builds a case of several geometries, rule parity.
pub(crate) fn several(name: &str, why: &'static str, lines: Lines, geometries: Vec<Geometry>) -> Case {
    Case { name: name.into(), why, geometries, lines, rule: Rule::Parity }
}

/// Unit cells from the origin: the centre of cell i is i + 1/2.
pub(crate) fn unit_cells(dims: [u32; 3]) -> Lines {
    lines([0.0; 3], [1.0; 3], dims)
}

/// Lines from sizes known to be good.
/// The same cells, moved along x.
pub(crate) fn moved_by(lines: &Lines, x: f64) -> Lines {
    let [x0, y0, z0] = lines.origin();
    Lines::new([x0 + x, y0, z0], lines.smallest(), lines.dims()).expect("sizes are positive")
}

pub(crate) fn lines(origin: [f64; 3], spacing: [f64; 3], dims: [u32; 3]) -> Lines {
    Lines::new(origin, spacing, dims).expect("sizes are positive")
}

/// All cases.
pub(crate) fn cases() -> Vec<Case> {
    let groups = [
        domains(),
        ties(),
        shapes(),
        sizes(),
        depths(),
        shells(),
        materials(),
        open_meshes(),
        placings(),
        random_soups(),
    ];
    groups.into_iter().flatten().collect()
}

/// Where the body is, seen from the domain.
fn domains() -> Vec<Case> {
    let dims = unit_cells([5, 6, 7]);
    let one_cell = unit_cells([1; 3]);
    let arms = |axis: usize| {
        let (mut low, mut high) = ([2.2; 3], [3.7; 3]);
        (low[axis], high[axis]) = (-4.0, 12.0);
        cuboid(low, high)
    };
    let besides = (0..6).flat_map(|side| {
        let mut by = [0.5; 3];
        by[side / 2] = if side % 2 == 0 { -9.0 } else { 9.0 };
        cube(by, 4.0)
    });
    vec![
        several("nothing", "no geometry at all", dims.clone(), vec![]),
        one("no-facets", "a geometry without facets", dims.clone(), vec![]),
        one("all-inside", "the domain lies within the body", dims.clone(), cube([-20.0; 3], 60.0)),
        one(
            "sticks-out",
            "a body leaves the domain on all six sides",
            dims.clone(),
            [arms(0), arms(1), arms(2)].concat(),
        )
        .nonzero(),
        one("all-outside", "a body beyond each of the six sides", dims.clone(), besides.collect()),
        one(
            "exact-fit",
            "the body is the domain: faces on the outer lines",
            dims.clone(),
            cuboid([0.0; 3], [5.0, 6.0, 7.0]),
        ),
        one("one-cell-full", "a domain of one cell inside the body", one_cell.clone(), cube([-3.0; 3], 7.0)),
        one("one-cell-corner", "a domain of one cell, its centre on a corner", one_cell.clone(), cube([0.5; 3], 7.0)),
        one("one-cell-low-corner", "the corner that owns its centre", one_cell.clone(), cube([-6.5; 3], 7.0)),
        one("one-cell-missed", "a domain of one cell, the body beside it", one_cell, cube([2.0; 3], 7.0)),
        one(
            "far-away",
            "a span of nearly 2^18 cells: the fewest fraction bits",
            dims,
            tetrahedron([[-9.0, -9.0, -9.0], [260_000.0, 3.0, 5.0], [2.0, 8_000.0, 3.0], [1.0, 2.0, 90_000.0]]),
        ),
    ]
}

/// Corners, edges and faces exactly on centres and lines.
fn ties() -> Vec<Case> {
    let eight = unit_cells([8; 3]);
    let centred = [[0.5, 0.5, 0.5], [6.5, 1.5, 2.5], [2.5, 6.5, 1.5], [1.5, 2.5, 6.5]];
    let flat = |i: usize, j: usize| 2.5 + ((i * 5 + j * 3) % 4) as f32;
    vec![
        one("unit-cube", "lines on every face, exactly full", lines([0.0; 3], [0.125; 3], [8; 3]), cube([0.0; 3], 1.0)),
        one("cube-on-centres", "all faces through centres: half-open cells decide", eight.clone(), cube([1.5; 3], 4.0)),
        one("tetrahedron-on-centres", "corners on centres, slanted ties", eight.clone(), tetrahedron(centred)),
        one("octahedron-on-rays", "apexes and edges on rays", eight.clone(), octahedron([0.5; 3], [6.5; 3])),
        one(
            "octahedron-on-lines",
            "apexes between rays, faces through centres",
            eight.clone(),
            octahedron([1.0; 3], [7.0; 3]),
        ),
        one(
            "small-octahedron",
            "a body between centres but for its apexes",
            eight.clone(),
            octahedron([2.5; 3], [3.5; 3]),
        ),
        one(
            "cone-on-ray",
            "64 facets meet on one ray",
            eight.clone(),
            models::cone([3.5, 3.5, 0.5], 3.0, [3.5, 3.5, 7.5], 64),
        ),
        one(
            "terrain-on-rays",
            "every vertex on a ray and on a centre",
            lines([-0.5; 3], [1.0; 3], [9, 9, 8]),
            models::terrain([8, 8], 1.0, 0.5, flat),
        ),
        one("roofs", "slopes of 45 degrees through centres, level along one axis each", eight.clone(), {
            let gable = [[0.5, 0.5, 0.5], [7.5, 3.5, 7.5], [0.5, 7.5, 0.5], [3.5, 0.5, 3.5]];
            (0..3).flat_map(|axis| soups::body(soups::Body::Prism(axis), gable)).collect()
        }),
        one("checkerboard", "cubes that touch at edges and corners only", eight.clone(), {
            let black = (0..64).filter(|i| (i % 4 + i / 4 % 4 + i / 16) % 2 == 0);
            black.flat_map(|i| cube([i % 4, i / 4 % 4, i / 16].map(|k| k as f32 * 2.0 + 0.5), 2.0)).collect()
        }),
        one("touching-cubes", "two bodies that share a face in one file", eight.clone(), {
            joined([cuboid([1.0; 3], [3.5, 5.0, 5.0]), cuboid([3.5, 1.0, 1.0], [7.0, 5.0, 5.0])])
        }),
        one("all-facets-collapsed", "points and lines only: nothing is hit", eight, {
            let along = [[0.5, 0.5, 0.5], [6.5, 0.5, 0.5], [2.5, 0.5, 0.5]];
            let lines = vec![[[2.5; 3]; 3], [[0.5; 3], [6.5; 3], [3.5; 3]], along];
            joined([lines.clone(), flipped(lines)])
        }),
    ]
}

/// Shapes with every slope.
fn shapes() -> Vec<Case> {
    let l_shape = [[0.3, 0.3], [7.7, 0.6], [7.5, 2.2], [2.1, 1.9], [1.8, 7.3], [0.6, 7.6]];
    let skew = [[0.1, 0.2, 0.3], [7.9, 1.1, 2.3], [2.2, 7.7, 0.9], [1.3, 2.6, 7.8]];
    let wedge = [[0.4, 0.3, 0.2], [5.2, 1.7, 0.9], [1.1, 6.2, 1.8]];
    let hills = |i: usize, j: usize| 3.0 + ((i * i + 3 * j) % 7) as f32 * 0.61;
    let ring = models::torus([12.0, 12.0, 5.0], [8.0, 3.3], 24);
    vec![
        one("tetrahedron", "no ties at all", unit_cells([8; 3]), tetrahedron(skew)),
        one(
            "concave-prism",
            "cap facets that overlap and cancel",
            unit_cells([8; 3]),
            models::prism(&l_shape, 0.8, 6.1),
        ),
        one("wedge", "slanted parallel sides", unit_cells([8, 8, 9]), models::wedge(wedge, [1.0, 0.7, 5.9])),
        one("sphere", "all slopes, silhouettes", unit_cells([20, 21, 22]), sphere([10.1, 10.4, 11.2], 9.0, 24)),
        one("torus", "a hole, four crossings a ray", unit_cells([24, 24, 10]), ring),
        one("terrain", "hills between rays", unit_cells([16, 12, 8]), models::terrain([14, 10], 1.1, 0.7, hills)),
    ]
}

/// Very large, very small, very thin, very many.
fn sizes() -> Vec<Case> {
    let dims = unit_cells([6, 7, 8]);
    let needle = [[0.3, 0.4, 0.5], [5.9, 6.8, 7.9], [5.9, 6.8, 7.901], [5.901, 6.8, 7.9]];
    let on_diagonal = [[0.5; 3], [5.5; 3], [5.5, 5.5, 5.625], [5.5, 5.625, 5.5]];
    let plates = |n: usize, pitch: f32| {
        (0..n).flat_map(move |i| cuboid([0.1, 0.1, i as f32 * pitch], [5.2, 3.1, (i as f32 + 0.5) * pitch]))
    };
    let huge = [[-900.0, -900.0, -900.0], [900.0, -800.0, 3.0], [-700.0, 950.0, 4.0], [-850.0, -750.0, 990.0]];
    let bead = |i: u32| sphere([(i % 5) as f32 + 0.5, (i / 5) as f32 + 0.5, 2.4], 0.3, 8);
    vec![
        one("large-facets", "facets a hundred times the domain", dims.clone(), tetrahedron(huge)),
        one("large-and-small", "one facet over all rays beside many over none", unit_cells([70, 66, 9]), {
            joined([tetrahedron([[-5.0; 3], [160.0, 0.0, 3.0], [0.0, 150.0, 4.0], [1.0, 1.0, 9.0]]), {
                sphere([60.2, 60.1, 5.0], 2.0, 32)
            }])
        }),
        one("tiny-facets", "thousands of facets within a few cells", dims.clone(), sphere([2.9, 3.1, 4.2], 1.7, 64)),
        one("beads", "bodies smaller than a cell around centres", dims.clone(), (0..30).flat_map(bead).collect()),
        one("between-centres", "a body smaller than a cell that holds no centre", dims.clone(), cube([2.6; 3], 0.8)),
        one("thin-plate", "a plate of a hundredth of a cell through centres", dims.clone(), {
            cuboid([0.2, 0.2, 3.495], [5.8, 6.8, 3.505])
        }),
        one("lost-plate", "a plate of a hundredth of a cell between centres", dims.clone(), {
            cuboid([0.2, 0.2, 3.6], [5.8, 6.8, 3.61])
        }),
        one("needle", "a sliver across the domain", dims.clone(), tetrahedron(needle)),
        one("needle-on-centres", "a sliver along a diagonal of centres", unit_cells([6; 3]), tetrahedron(on_diagonal)),
        one("many-crossings", "240 crossings on a ray", unit_cells([6, 4, 240]), plates(120, 2.0).collect()),
        one("crossings-in-a-cell", "many crossings of one ray in one cell", dims, plates(60, 0.11).collect()),
        one("deep", "few long rays", unit_cells([2, 3, 1500]), cuboid([0.5, 0.2, 3.3], [1.6, 2.9, 1499.5])),
        one("wide", "rays of one cell, many bins", unit_cells([130, 130, 1]), sphere([64.0, 65.0, 0.5], 61.7, 32)),
        one("row", "one row of cells along x", unit_cells([300, 1, 1]), sphere([150.0, 0.5, 0.5], 120.3, 16)),
    ]
}

/// Rays with hundreds and thousands of crossings, which the GPU's kernels for few crossings leave to those for many, and these to the
/// CPU: 1 ray and 100, one geometry and several, both rules.
fn depths() -> Vec<Case> {
    let mut cases = Vec::new();
    for n_crossings in [200u32, 2000, 9000] {
        for side in [1, 10] {
            for n_geometries in [1, 3] {
                // each geometry has every third plate; those of several are thicker and overlap
                let plate = |i: u32| {
                    let z = i as f32 * 2.0 + 0.3;
                    cuboid(
                        [-1.0, -1.0, z],
                        [side as f32 + 0.5, side as f32 - 0.3, z + if n_geometries == 1 { 1.1 } else { 3.2 }],
                    )
                };
                let of_geometry =
                    |g: u32| (g..n_crossings / 2).step_by(n_geometries as usize).flat_map(plate).collect::<Facets>();
                let name = format!("plates-{n_crossings}-{side}-{n_geometries}");
                let geometries: Vec<Geometry> = (0..n_geometries)
                    .map(|g| Geometry::new(format!("plates {g}"), 7 - g as u8, of_geometry(g)).unwrap())
                    .collect();
                let lines = unit_cells([side, side, n_crossings + 2]);
                let why = "as many crossings on every ray";
                cases.push(several(&format!("{name}-parity"), why, lines.clone(), geometries.clone()));
                cases.push(several(&format!("{name}-nonzero"), why, lines, geometries).nonzero());
            }
        }
    }
    cases
}

/// Shells of one geometry: where the two rules differ.
fn shells() -> Vec<Case> {
    let ten = unit_cells([10; 3]);
    let nested = || joined([cube([1.0; 3], 8.0), cube([2.5; 3], 5.0), cube([4.2; 3], 1.6)]);
    let overlapping = || joined([cube([0.5; 3], 5.0), cube([3.5; 3], 5.0), sphere([5.0; 3], 3.0, 16)]);
    let hollow = || joined([cube([1.0; 3], 8.0), flipped(cube([2.5; 3], 5.0))]);
    let twice = || joined([cube([2.0; 3], 5.5), cube([2.0; 3], 5.5)]);
    let opposed = || joined([cube([2.0; 3], 5.5), flipped(cube([2.0; 3], 5.5))]);
    let both = |name: &str, why: &'static str, facets: Facets| {
        let parity = one(&format!("{name}-parity"), why, ten.clone(), facets.clone());
        [parity, one(&format!("{name}-nonzero"), why, ten.clone(), facets).nonzero()]
    };
    [
        both("nested-shells", "shells within shells", nested()),
        both("overlapping-shells", "bodies of one file that overlap", overlapping()),
        both("hollow", "an inner shell turned inwards", hollow()),
        both("body-twice", "every facet given twice", twice()),
        both("opposed-bodies", "every facet and its reverse", opposed()),
        both("inside-out", "all normals inwards", flipped(sphere([5.0; 3], 4.3, 16))),
    ]
    .concat()
}

/// Several geometries in one domain.
fn materials() -> Vec<Case> {
    let ten = unit_cells([10; 3]);
    let overlapping = |priorities: [i32; 3]| -> Vec<Geometry> {
        let bodies = [cube([0.5; 3], 6.0), sphere([5.5; 3], 3.9, 16), cuboid([4.0, 0.0, 3.3], [9.5, 9.0, 6.5])];
        let place = |(i, facets)| {
            set!(Geometry {
                priority: priorities[i],
                ..Geometry::new(format!("body {i}"), [3, 200, 9][i], facets).unwrap()
            })
        };
        bodies.into_iter().enumerate().map(place).collect()
    };
    let crowd = (0..255u32).map(|i| {
        let place = [i % 8, i / 8 % 8, i / 64].map(|k| k as f32 * 1.1 + 0.3);
        Geometry::new(format!("body {i}"), (i + 1) as u8, cube(place, 1.9)).unwrap()
    });
    let halves = vec![
        Geometry::new("left", 4, cuboid([1.0; 3], [4.5, 8.0, 8.0])).unwrap(),
        Geometry::new("right", 4, cuboid([4.5, 1.0, 1.0], [9.0, 8.0, 8.0])).unwrap(),
    ];
    let mixed = vec![
        Geometry::new("closed", 1, cube([1.0; 3], 7.0)).unwrap(),
        Geometry::new("empty", 2, vec![]).unwrap(),
        Geometry::new("lost", 3, cube([5.6; 3], 0.5)).unwrap(),
    ];
    vec![
        several("later-wins", "equal priorities: meshed in order", ten.clone(), overlapping([0; 3])),
        several("priorities", "priorities against the order", ten.clone(), overlapping([5, -5, 0])),
        several("priorities-nonzero", "the same with winding numbers", ten.clone(), overlapping([1, 1, 0])).nonzero(),
        several("crowd", "255 geometries, up to eight over each other", ten.clone(), crowd.collect()),
        several("touching-files", "two files that share a face and a flag", ten.clone(), halves),
        several("empty-among-others", "a geometry without facets and one without cells", ten, mixed),
    ]
}

/// Surfaces with a boundary: rays with an odd count.
fn open_meshes() -> Vec<Case> {
    let dims = unit_cells([7, 8, 9]);
    let without = |facets: Facets, gone: &[usize]| -> Vec<Facet> {
        facets.into_iter().enumerate().filter(|(index, _)| !gone.contains(index)).map(|(_, facet)| facet).collect()
    };
    let body = || cuboid([1.2, 1.2, 1.2], [5.8, 6.8, 7.8]);
    let mut extra = body();
    extra.push(extra[5]);
    let mut flip = body();
    flip[2].swap(0, 1);
    vec![
        one("no-lid-x", "a box without the side at high x", dims.clone(), without(body(), &[2, 3])),
        one("no-lid-y", "a box without the side at low y", dims.clone(), without(body(), &[4, 5])),
        one("no-lid-z", "a box without the top", dims.clone(), without(body(), &[10, 11])),
        one("no-facet", "a box without half a side", dims.clone(), without(body(), &[10])).nonzero(),
        one("one-facet", "a single facet", dims.clone(), vec![[[0.3, 0.2, 1.0], [6.8, 1.2, 3.0], [2.0, 7.7, 8.0]]]),
        one("facet-twice", "a closed box with one facet given twice", dims.clone(), extra),
        one("facet-turned", "a closed box with one normal inwards, for the winding number", dims.clone(), flip)
            .nonzero(),
        one(
            "half-sphere",
            "a bowl",
            dims.clone(),
            without(sphere([3.3, 4.1, 4.6], 3.1, 16), &(0..112).collect::<Vec<_>>()),
        ),
        several("open-among-closed", "an open body over a closed one", dims, {
            vec![
                Geometry::new("closed", 1, cube([0.7; 3], 5.0)).unwrap(),
                Geometry::new("open", 2, without(body(), &[8])).unwrap(),
            ]
        }),
    ]
}

/// Transforms, units, negative places, sizes that f32 cannot hold.
fn placings() -> Vec<Case> {
    let rotated = |degrees: [f64; 3]| {
        let place = Placing::new([1.5, 1.0, 0.8], degrees, [6.0, 6.0, 6.0]).unwrap();
        vec![set!(Geometry {
            world_from_file: place,
            ..Geometry::new("bar", 1, cuboid([-3.0, -2.0, -4.0], [3.0, 1.0, 4.0])).unwrap()
        })]
    };
    let cells = unit_cells([12; 3]);
    let skew = [[-7.9, -7.1, -7.3], [-0.3, -6.2, -5.5], [-6.0, -0.2, -4.4], [-4.1, -3.3, -0.1]];
    let oblong = lines([0.1, -0.2, 1.0 / 3.0], [0.1, 0.07, 1.0 / 30.0], [9, 14, 30]);
    vec![
        several("turned-30-40-50", "a transform in f64", cells.clone(), rotated([30.0, 40.0, 50.0])),
        several("turned-90", "quarter turns are exact", cells, rotated([90.0, 180.0, 270.0])),
        one("all-negative", "a body in the negative octant", lines([-8.0; 3], [0.5; 3], [16; 3]), tetrahedron(skew)),
        one("oblong-cells", "three spacings that f64 cannot hold", oblong, sphere([0.5, 0.3, 0.8], 0.38, 24)),
        one("micrometres", "cells of 1e-7", lines([0.0; 3], [1e-7; 3], [10; 3]), {
            scaled(&tetrahedron([[0.0; 3], [1.0, 0.1, 0.2], [0.1, 1.0, 0.3], [0.2, 0.3, 1.0]]), 1e-6)
        }),
        one("kilometres", "cells of 100", lines([0.0; 3], [100.0; 3], [10; 3]), {
            scaled(&tetrahedron([[0.0; 3], [1.0, 0.1, 0.2], [0.1, 1.0, 0.3], [0.2, 0.3, 1.0]]), 1e3)
        }),
        one(
            "far-origin",
            "a domain far from the origin, where f32 steps are seen",
            lines([1e5, -2e5, 3e5], [0.25; 3], [10; 3]),
            moved(&octahedron([0.0; 3], [2.5; 3]), [1e5, -2e5, 3e5]),
        ),
    ]
}

/// Pinned seeds of the random soups.
fn random_soups() -> Vec<Case> {
    (1..=8).map(soups::soup).chain((1..=2).map(soups::crumbs)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_reasons_given() {
        let mut names: Vec<String> = cases().into_iter().map(|case| case.name).collect();
        assert!(names.len() >= 60, "{} cases", names.len());
        names.sort();
        let n_cases = names.len();
        names.dedup();
        assert_eq!(names.len(), n_cases);
        for case in cases() {
            let is_plain = case.name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-');
            assert!(is_plain && !case.why.is_empty(), "{}", case.name);
            // thousands of crossings a ray take thousands of plates
            let (cells, facets) = if case.name.starts_with("plates") { (1_000_000, 60_000) } else { (50_000, 8_000) };
            let is_small = case.lines.n_cells() <= cells && case.n_facets() <= facets;
            assert!(is_small, "{} is not small", case.name);
        }
    }
}
