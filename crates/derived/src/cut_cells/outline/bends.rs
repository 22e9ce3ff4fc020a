//! Where the surface of a fluid bends sharply within a cell: the edges of a body on faces, and its corner in the cell.
//!
//! Corners in the fluid, crossings, corners of pieces, exact areas and volume -> [`Shape`]. From crossing to crossing a surface is flat; where it bends by 30 degrees or more, off the straight
//! line by more than what is drawn to corners of the mesh ([`SNAP`]), one of its own corners is taken in: that which brings the area on the face nearest to the exact one, and at least halves what was
//! amiss. A bend that makes the fluid on a face so concave that its middle does not see all of the surface is left out, as the cell would be of a wrong shape: an edge of a body near to a corner of
//! a cell around it. So a face has the same bend from both of its cells, as both have the same corners, crossings and area. Where one edge of a body, or three or more, end in a cell, its corner there is
//! found by the volume.

use super::super::edges::{ACROSS, ends_of};
use super::super::polyhedra::cell::{BEND, CROSSING, Vertex, bodies, loops, on_face, polygons};
use super::super::polyhedra::{SNAP, planar};

/// Cosine of the least angle.
const STRAIGHT: f64 = 0.866;
/// Areas and volumes that are right to this are not made better.
const RIGHT: f64 = 1e-3;

/// How the fluid lies in a cell.
pub(super) struct Shape {
    pub(super) bends: [[f64; 2]; 6],
    pub(super) peak: [f64; 3],
}

/// Corners of pieces in a cell: where on each face, and where in the cell.
#[derive(Default)]
pub(super) struct Places {
    pub(super) on_faces: Vec<(usize, [f64; 2])>,
    pub(super) within: Vec<[f64; 3]>,
}

impl Shape {
    /// Of a cell with these corners in the fluid, exact areas on faces and exact volume.
    pub(super) fn new(fluid: u8, crossings: &[f64; 12], places: &Places, areas: &[f64; 6], volume: f64) -> Shape {
        let cell = Cell { fluid, crossings };
        let (mut bends, mut of_faces) = ([[f64::NAN; 2]; 6], [0.0; 6]);
        for face in 0..6 {
            let own = places.on_faces.iter().filter(|(of, _)| *of == face).map(|(_, at)| *at);
            (bends[face], of_faces[face]) = cell.bend(face, own, areas[face]);
        }
        let (mut rings, mut n_bends) = (Vec::new(), 0);
        loops(fluid, |_, vertices| {
            let ring: Vec<[f64; 3]> = vertices.iter().filter_map(|&vertex| cell.place(vertex, &bends)).collect();
            n_bends = ring.len() - vertices.len() / 2;
            rings.push(ring);
        });
        // cones over the faces at the low corner have no volume
        let faces = (of_faces[1] + of_faces[3] + of_faces[5]) / 3.0;
        let off = |flat: f64| (flat - volume).abs();
        let flat = faces + rings.iter().map(|ring| below(ring)).sum::<f64>();
        let mut peak = [f64::NAN; 3];
        if let [ring] = &rings[..]
            && bodies(fluid).0 == 1
            && (n_bends == 1 || n_bends > 2)
            && off(flat) > RIGHT
        {
            let all = places.within.iter().map(|&at| (faces + fan(ring, at), at));
            // what has no volume vanishes
            let all = all.filter(|(flat, at)| flat.abs() < RIGHT || is_outside(ring, *at, cell.middle(ring)));
            if let Some((with_peak, at)) =
                all.min_by(|one, other| least((off(one.0), &one.1), (off(other.0), &other.1)))
                && off(with_peak) < 0.5 * off(flat)
            {
                peak = at;
            }
        }
        Shape { bends, peak }
    }
}

/// What is known of a cell.
struct Cell<'a> {
    fluid: u8,
    crossings: &'a [f64; 12],
}

impl Cell<'_> {
    /// Where a vertex is; None for a bend that is not there.
    fn place(&self, vertex: Vertex, bends: &[[f64; 2]; 6]) -> Option<[f64; 3]> {
        let corner = |corner: usize| [0, 1, 2].map(|axis| (corner >> axis & 1) as f64);
        if vertex < CROSSING {
            return Some(corner(vertex.into()));
        }
        if vertex < BEND {
            let edge = usize::from(vertex - CROSSING);
            let mut at = corner(ends_of(edge)[0]);
            at[edge / 4] = self.crossings[edge];
            return Some(at);
        }
        let face = vertex - BEND;
        let at = bends[usize::from(face)];
        (!at[0].is_nan()).then(|| on_face(face, at))
    }

    /// About the middle of the fluid: that of its corners and of a loop.
    fn middle(&self, ring: &[[f64; 3]]) -> [f64; 3] {
        let corners = (0..8u8).filter(|corner| self.fluid >> corner & 1 == 1);
        let all = corners.filter_map(|corner| self.place(corner, &[[f64::NAN; 2]; 6])).chain(ring.iter().copied());
        let (n, sum) = all.fold((0.0, [0.0; 3]), |(n, sum), at| (n + 1.0, [0, 1, 2].map(|axis| sum[axis] + at[axis])));
        sum.map(|of| of / n)
    }

    /// The bend of the surface on a face, which is at one of some places, if it has one; and the area of the fluid there with it.
    fn bend(&self, face: usize, places: impl Iterator<Item = [f64; 2]>, exact: f64) -> ([f64; 2], f64) {
        const NONE: [f64; 2] = [f64::NAN; 2];
        let [first, second] = ACROSS[face / 2];
        let all: Vec<Vec<[f64; 2]>> = polygons(self.fluid, face)
            .map(|polygon| {
                let places = polygon.vertices().iter().filter_map(|&vertex| self.place(vertex, &[NONE; 6]));
                places.map(|at| [at[first], at[second]]).collect()
            })
            .collect();
        let straight = all.iter().map(|polygon| area(polygon)).sum::<f64>();
        let off = |area: f64| (area - exact).abs();
        let ([polygon], true) = (&all[..], off(straight) > RIGHT) else { return (NONE, straight) };
        // four corners and no crossing: all of the face
        let is_whole = polygons(self.fluid, face).all(|polygon| polygon.vertices()[0] < CROSSING);
        let ends = [polygon[polygon.len() - 1], polygon[0]];
        let is_sharp = |at: &[f64; 2]| {
            let [u, v] = [[at[0] - ends[0][0], at[1] - ends[0][1]], [ends[1][0] - at[0], ends[1][1] - at[1]]];
            let w = [ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]];
            let length = |of: [f64; 2]| of[0].hypot(of[1]);
            let distance = (u[0] * w[1] - u[1] * w[0]).abs() / length(w);
            let turn = u[0] * v[0] + u[1] * v[1];
            // where both ends are one, all is off the line
            (distance > SNAP || length(w) == 0.0) && turn < STRAIGHT * length(u) * length(v)
        };
        // the area, where the middle sees the surface
        let bent = |at: [f64; 2]| {
            let bent: Vec<[f64; 2]> = polygon.iter().copied().chain([at]).collect();
            let (own, middle) = moments(&bent);
            let clear = |[from, to]: [[f64; 2]; 2]| {
                let along = [to[0] - from[0], to[1] - from[1]];
                let across = along[0] * (middle[1] - from[1]) - along[1] * (middle[0] - from[0]);
                across * own.signum() >= SNAP * along[0].hypot(along[1])
            };
            // what has no area vanishes
            let is_seen = own.abs() < RIGHT || clear([ends[0], at]) && clear([at, ends[1]]);
            is_seen.then(|| (own.abs(), at))
        };
        let found = places.filter(|at| !is_whole && is_sharp(at)).filter_map(bent);
        let best = found.min_by(|one, other| least((off(one.0), &one.1), (off(other.0), &other.1)));
        match best {
            Some((bent, at)) if off(bent) < 0.5 * off(straight) => (at, bent),
            _ => (NONE, straight),
        }
    }
}

/// Whether all triangles between a loop and a point are seen from within the fluid, from its middle.
fn is_outside(ring: &[[f64; 3]], tip: [f64; 3], middle: [f64; 3]) -> bool {
    cones(ring, tip, middle).all(|volume| volume > -RIGHT)
}

/// The order of what is amiss, then of places: the same from both sides of a face.
fn least<const N: usize>(one: (f64, &[f64; N]), other: (f64, &[f64; N])) -> std::cmp::Ordering {
    let by_place = || one.1.iter().zip(other.1).map(|(one, other)| one.total_cmp(other));
    one.0.total_cmp(&other.0).then_with(|| by_place().find(|order| order.is_ne()).unwrap_or(std::cmp::Ordering::Equal))
}

fn area(polygon: &[[f64; 2]]) -> f64 {
    moments(polygon).0.abs()
}

/// Area of a polygon, less than 0 where it is clockwise, and its middle.
fn moments(polygon: &[[f64; 2]]) -> (f64, [f64; 2]) {
    let pairs = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let sums = pairs.fold([0.0; 3], |[area, x, y], (one, other)| {
        let across = 0.5 * (one[0] * other[1] - one[1] * other[0]);
        [area + across, x + across * (one[0] + other[0]) / 3.0, y + across * (one[1] + other[1]) / 3.0]
    });
    (sums[0], [sums[1] / sums[0], sums[2] / sums[0]])
}

/// The volume of the cones, from the low corner of the cell, over the flat polygons of a loop.
fn below(ring: &[[f64; 3]]) -> f64 {
    let all: Vec<u32> = (0..ring.len() as u32).collect();
    let mut volume = 0.0;
    planar::split(&all, ring, 1e-6, |polygon| {
        volume += planar::cone(polygon.iter().map(|&at| ring[at as usize]), [0.0; 3]).0;
    });
    volume
}

/// The volume of the cones, from the low corner of the cell, over the triangles between a loop and a point.
fn fan(ring: &[[f64; 3]], tip: [f64; 3]) -> f64 {
    cones(ring, tip, [0.0; 3]).sum()
}

/// The volumes of the cones, from a point, over the triangles between a loop and another.
fn cones(ring: &[[f64; 3]], tip: [f64; 3], from: [f64; 3]) -> impl Iterator<Item = f64> {
    let pairs = ring.iter().zip(ring.iter().cycle().skip(1));
    pairs.map(move |(&one, &other)| planar::cone([one, other, tip].into_iter(), from).0)
}
