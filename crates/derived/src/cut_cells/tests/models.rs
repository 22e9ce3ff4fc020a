//! Closed surfaces, and what is measured of them.

use std::f64::consts::{PI, TAU};

use super::super::*;
use hexcast_core::base::control::{Control, at_once};
use hexcast_core::grid::closed::Closed;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::window::CellWindow;
use hexcast_core::input::geometry::{Facet, Geometry};
use hexcast_core::input::job::Rule;
use hexcast_core::stages::inside::Kind;

pub(in crate::cut_cells) type Facets = Vec<Facet>;

/// All that can be measured.
pub(super) const ALL: CutWanted =
    CutWanted { centroids: true, faces: true, face_centroids: true, edges: true, surfaces: true };

/// Surface of a map from a grid of n by m squares, which closes both ways.
fn closed(n: usize, m: usize, at: impl Fn(f64, f64) -> [f64; 3]) -> Facets {
    let corner = |i: usize, j: usize| at((i % n) as f64 / n as f64, (j % m) as f64 / m as f64).map(|x| x as f32);
    let squares = (0..n).flat_map(|i| (0..m).map(move |j| (i, j)));
    let of_square = |(i, j)| {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    squares.flat_map(of_square).collect()
}

pub(super) fn torus(n: usize, [ring, tube]: [f64; 2]) -> Facets {
    closed(n, n, |u, v| {
        let ((su, cu), (sv, cv)) = (libm::sincos(TAU * u), libm::sincos(TAU * v));
        turned([(ring + tube * cv) * cu, (ring + tube * cv) * su, tube * sv])
    })
}

fn turned([x, y, z]: [f64; 3]) -> [f64; 3] {
    let (x, y) = (0.8 * x - 0.6 * y, 0.6 * x + 0.8 * y);
    [x, 0.28 * y - 0.96 * z, 0.96 * y + 0.28 * z]
}

/// Of n meridians, about a place.
pub(in crate::cut_cells) fn sphere(n: usize, radius: f64, [x, y, z]: [f64; 3]) -> Facets {
    let rows = n / 2;
    let corner = |i: usize, j: usize| {
        let (su, cu) = libm::sincos(TAU * (i % n) as f64 / n as f64);
        let (sv, cv) = libm::sincos(PI * j as f64 / rows as f64);
        let sv = if j == 0 || j == rows { 0.0 } else { sv };
        [x + radius * sv * cu, y + radius * sv * su, z - radius * cv].map(|x| x as f32)
    };
    let squares = (0..n).flat_map(|i| (0..rows).map(move |j| (i, j)));
    let of_square = |(i, j)| {
        let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
        [[a, b, c], [a, c, d]]
    };
    squares.flat_map(of_square).filter(|[a, b, c]| a != b && b != c && c != a).collect()
}

pub(in crate::cut_cells) fn cuboid(low: [f32; 3], high: [f32; 3]) -> Facets {
    let corner = |bits: usize| std::array::from_fn(|axis| if bits >> axis & 1 == 1 { high[axis] } else { low[axis] });
    let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let of_side = |side: [usize; 4]| {
        let [a, b, c, d] = side.map(corner);
        [[a, b, c], [a, c, d]]
    };
    sides.into_iter().flat_map(of_side).collect()
}

/// Outwards whatever the order of its corners.
pub(super) fn tetrahedron(mut corners: [[f32; 3]; 4]) -> Facets {
    let side = |to: usize| [0, 1, 2].map(|axis| f64::from(corners[to][axis]) - f64::from(corners[0][axis]));
    let [u, v, w] = [1, 2, 3].map(side);
    let cross = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    if cross[0] * w[0] + cross[1] * w[1] + cross[2] * w[2] < 0.0 {
        corners.swap(0, 1);
    }
    let [a, b, c, d] = corners;
    vec![[a, c, b], [a, b, d], [b, c, d], [c, a, d]]
}

/// Numbers from 0 to 1.
pub(super) struct Random(pub(super) u64);

impl Random {
    pub(super) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f64 / (1u64 << 24) as f64
    }
}

/// Surfaces with flags, the later of which win.
pub(super) struct Model {
    pub(super) name: &'static str,
    pub(super) surfaces: Vec<(u8, Facets)>,
}

impl Model {
    pub(super) fn of_one(name: &'static str, facets: Facets) -> Model {
        Model { name, surfaces: vec![(7, facets)] }
    }

    pub(super) fn frame(&self, lines: &Lines) -> Frame {
        let geometry = |(flag, facets): &(u8, Facets)| Geometry::new(self.name, *flag, facets.clone()).unwrap();
        Frame::new(&self.surfaces.iter().map(geometry).collect::<Vec<_>>(), lines).unwrap()
    }

    pub(super) fn measured(&self, lines: &Lines) -> CutCells {
        measured(&self.frame(lines), lines, CellWindow::all(lines.dims()), Rule::Nonzero)
    }

    /// Volume of the snapped surface of a geometry.
    pub(super) fn volume(&self, index: usize, lines: &Lines) -> f64 {
        let frame = self.frame(lines);
        let mut sixfold = 0i128;
        for facet in frame.facets_at(index) {
            let [a, b, c] = facet.map(|corner| corner.map(i128::from));
            sixfold += a[0] * (b[1] * c[2] - b[2] * c[1])
                + a[1] * (b[2] * c[0] - b[0] * c[2])
                + a[2] * (b[0] * c[1] - b[1] * c[0]);
        }
        let unit: f64 = lines.smallest().iter().map(|size| size / f64::from(1u32 << frame.fraction_bits)).product();
        sixfold as f64 / 6.0 * unit
    }
}

pub(super) fn measured(frame: &Frame, lines: &Lines, window: CellWindow, rule: Rule) -> CutCells {
    let kinds = vec![Kind::Cast; frame.ranks.flag_of_rank.len()];
    measured_as(frame, lines, window, (rule, &kinds))
}

pub(super) fn measured_as(frame: &Frame, lines: &Lines, window: CellWindow, by: (Rule, &[Kind])) -> CutCells {
    measured_of(frame, lines, window, by, ALL)
}

/// Volumes alone.
pub(super) fn measured_alone(frame: &Frame, lines: &Lines, window: CellWindow) -> CutCells {
    let kinds = vec![Kind::Cast; frame.ranks.flag_of_rank.len()];
    measured_of(frame, lines, window, (Rule::Nonzero, &kinds), CutWanted::default())
}

fn measured_of(
    frame: &Frame,
    lines: &Lines,
    window: CellWindow,
    (rule, kinds): (Rule, &[Kind]),
    job: CutWanted,
) -> CutCells {
    let positions = 0..frame.ranks.geometry_at.len();
    let is_oriented: Vec<bool> = positions.map(|position| Closed::of(frame.facets_at(position)).nonzero).collect();
    let by = CutBy { frame, lines, rule, kinds, is_oriented: &is_oriented };
    at_once(cut_cells(by, window, job, u64::MAX, &Control::default())).unwrap()
}

pub(super) fn equal() -> Lines {
    Lines::new([-5.0; 3], [1.0; 3], [10; 3]).unwrap()
}

/// Places that f32 and the frame hold exactly, so that its faces are those of the lines.
pub(super) fn graded() -> Lines {
    let list = vec![-5.0, -4.0, -2.75, -2.0, -1.5, -1.0, -0.25, 0.5, 1.0, 2.0, 3.0, 3.5, 5.0];
    Lines::from_lists([list.clone(), list.clone(), list]).unwrap()
}

/// Single bodies.
pub(super) fn bodies() -> Vec<Model> {
    let prism = |[low, high]: [f32; 2]| {
        let [a, b, c] = [[-3.3, -2.9], [3.1, -2.2], [0.4, 3.7]];
        let at = |[x, y]: [f32; 2], z: f32| [x, y, z];
        let mut facets = vec![[at(a, low), at(c, low), at(b, low)], [at(a, high), at(b, high), at(c, high)]];
        for [p, q] in [[a, b], [b, c], [c, a]] {
            facets.extend([[at(p, low), at(q, low), at(q, high)], [at(p, low), at(q, high), at(p, high)]]);
        }
        facets
    };
    vec![
        Model::of_one("ball", sphere(24, 3.3, [0.1, -0.2, 0.3])),
        Model::of_one("ball at lines", sphere(16, 3.0, [0.0; 3])),
        Model::of_one("fine ball", sphere(40, 1.9, [0.3, 0.2, 0.1])),
        Model::of_one("ball beyond the box", sphere(20, 3.0, [-4.0, 4.2, 0.3])),
        Model::of_one("box on lines", cuboid([-2.0, -1.0, -4.0], [1.0, 3.0, 2.0])),
        Model::of_one("box", cuboid([-2.3, -1.1, -4.4], [1.3, 3.2, 2.6])),
        Model::of_one("thin plate", prism([0.3, 0.301])),
        Model::of_one("thin plate at a line", prism([1.0, 1.003])),
        Model::of_one("torus", torus(24, [2.6, 0.9])),
        Model::of_one("thin torus", torus(20, [3.1, 0.13])),
        Model::of_one(
            "tetrahedron",
            tetrahedron([[-4.1, -3.7, -2.9], [4.2, -3.1, -2.2], [0.3, 4.4, -1.9], [0.6, 0.2, 4.6]]),
        ),
    ]
}

/// Several bodies, and the volumes that their flags have where all lies in the box.
pub(super) fn several() -> Vec<(Model, Vec<f64>)> {
    let ball = |radius| sphere(24, radius, [0.1, -0.2, 0.3]);
    let lines = equal();
    let of = |name, surfaces: Vec<Facets>| Model { name, surfaces: (1u8..).zip(surfaces).collect() };
    let nested = of("nested", vec![ball(3.3), ball(3.1), ball(1.4)]);
    let volumes = [0, 1, 2].map(|index| nested.volume(index, &lines));
    let of_nested = vec![volumes[0] - volumes[1], volumes[1] - volumes[2], volumes[2]];
    let touching = [cuboid([-2.3, -1.1, -4.4], [0.4, 3.2, 2.6]), cuboid([0.4, -1.1, -4.4], [1.3, 3.2, 2.6])];
    let coplanar = [cuboid([-2.0, -1.0, -4.0], [1.0, 3.0, 2.0]), cuboid([1.0, -1.0, -4.0], [3.0, 3.0, 2.0])];
    let [a, b, c, d, e] =
        [[-3.1f32, -2.7, -1.9], [3.2, -2.1, -1.2], [0.3, 3.4, -1.1], [0.6, 0.2, 3.6], [0.2, 0.1, -4.1]];
    let back_to_back = [tetrahedron([a, b, c, d]), tetrahedron([a, b, c, e])];
    let apart = [sphere(12, 0.6, [0.4, 0.4, 0.4]), sphere(12, 0.55, [1.35, 1.1, 0.5])];
    let mut cases = vec![(nested, of_nested)];
    for (name, bodies) in
        [("touching", touching), ("coplanar at lines", coplanar), ("back to back", back_to_back), ("apart", apart)]
    {
        let model = of(name, bodies.to_vec());
        let volumes = [0, 1].map(|index| model.volume(index, &lines)).to_vec();
        cases.push((model, volumes));
    }
    cases
}
