//! Caps: triangles that close the holes of a surface, and how far their solid angle moves its winding number.
//!
//! Loops of open edges -> caps; caps, cells -> [`Shift`]s. With theta(P) the solid angle of all caps at P over 4 pi, a surface
//! whose winding number is w has the winding number w + theta together with its caps. That is an integer n, so round(w) =
//! n + m with m = floor(1/2 - theta). m is 0 wherever |theta| < 1/2, which is nearly everywhere.
//!
//! The cells where it is not are found in blocks. Of a triangle of area A at a distance of at least d from every centre of a block
//! of half diagonal r, theta differs from its value at the middle by at most A r / (2 pi d^3), and from that with its gradient
//! by at most 3 A r^2 / (4 pi d^4): the integrand n.x / |x|^3, a dipole, has a k-th derivative of at most (k + 1)! / |x|^(k + 2).
//! A triangle that is small beside d is one dipole at its centre: that is off by at most A s / (48 pi d^4), with s the sum of its
//! squared edges, as the first moment about the centre is 0; and with the second derivative, too, by A r^3 / (pi d^5) more.
//! Where the sum of these leaves m in no doubt the whole block has it; else the block is split in eight, down to one cell, for
//! which theta is computed. Triangles far from a block are not looked at again in its parts: their value and derivatives at its
//! middle serve, unless the error leaves a cell in doubt. So every cell has the m that it has by itself.
//!
//! Theta jumps by 1 where a centre passes a triangle. So sides are exact, and of the plane itself the one that the tie rule of rays says,
//! the centre a little before itself; theta is that of a point that is moved by a fraction of the snap's unit, and 1 more or less where
//! a triangle lies between the two.
//! Cost: O(log n) triangles a block, some 100 ns each; some hundred blocks a hole.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use crate::frame::SnappedFacet;
use crate::parallel::*;

mod triangle;

use triangle::{BEFORE, Triangle};

/// Triangles this many half diagonals away from a block are evaluated once for all its cells.
const FAR: f64 = 4.0;
/// More than all rounding errors of theta.
const ROUNDING: f64 = 1e-6;
/// Blocks along an axis that are looked at side by side.
const BLOCKS: u32 = 4;

/// Cells of a box, its end exclusive, whose rounded winding number is that of surface and caps plus m, where m is not 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shift {
    pub(super) low: [u32; 3],
    pub(super) high: [u32; 3],
    pub(super) m: i32,
}

/// Closes each loop with a fan around the mean of its corners, or one triangle.
pub(super) fn caps(loops: &[Vec<[i32; 3]>]) -> Vec<SnappedFacet> {
    let mut caps = Vec::new();
    for corners in loops {
        if let &[a, b, c] = &corners[..] {
            caps.push([c, b, a]);
            continue;
        }
        let n = corners.len() as i64;
        let mean = [0, 1, 2].map(|axis| (corners.iter().map(|corner| i64::from(corner[axis])).sum::<i64>() / n) as i32);
        let next = corners.iter().cycle().skip(1);
        caps.extend(corners.iter().zip(next).map(|(&at, &next)| [next, at, mean]));
    }
    caps
}

/// A box of cells.
pub(super) struct Cells<'a> {
    /// The first, and their number.
    pub(super) first: [u32; 3],
    pub(super) dims: [u32; 3],
    /// The centre of a cell along an axis, in units of the snap from the centre of cell 0.
    pub(super) centre: &'a (dyn Fn(usize, u32) -> i64 + Sync),
}

/// Finds the cells of a box where m is not 0, counted from its first. Caps are counted from cell 0, so that numbers, and with them m, are
/// the same whatever the box. The smallest cell is 2^`fraction_bits` units of the snap; `sizes` are its lengths along the axes, in any
/// unit.
pub(super) fn shifts(caps: &[SnappedFacet], cells: &Cells, fraction_bits: u32, sizes: [f64; 3]) -> Vec<Shift> {
    let unit = 1.0 / f64::from(1u32 << fraction_bits);
    let scale = DVec3::from(sizes) / sizes[0];
    let place = |corner: [i32; 3]| DVec3::from(corner.map(f64::from)) * unit * scale;
    let triangles: Vec<Triangle> = caps.iter().filter_map(|&cap| Triangle::new(cap, place)).collect();
    if triangles.is_empty() {
        return Vec::new();
    }
    let &Cells { first, dims, centre } = cells;
    let search =
        Search { triangles, centre, unit, scale, before: DVec3::from(BEFORE.map(f64::from)) / 32.0 * unit * scale };
    let all: Vec<u32> = (0..search.triangles.len() as u32).collect();
    let starts = |axis: usize| (0..dims[axis]).step_by(dims[axis].div_ceil(BLOCKS) as usize);
    let mut blocks = Vec::new();
    for z in starts(2) {
        for y in starts(1) {
            for x in starts(0) {
                let low = [x, y, z];
                let high = |axis: usize| (low[axis] + dims[axis].div_ceil(BLOCKS)).min(dims[axis]);
                blocks.push((
                    [0, 1, 2].map(|axis| first[axis] + low[axis]),
                    [0, 1, 2].map(|axis| first[axis] + high(axis)),
                ));
            }
        }
    }
    let of_block = |(low, high)| {
        let mut found = Vec::new();
        search.descend(low, high, &all, &mut Vec::new(), &mut found);
        found
    };
    let found: Vec<Vec<Shift>> = blocks.into_par_iter().map(of_block).collect();
    let from_first = |cell: [u32; 3]| [0, 1, 2].map(|axis| cell[axis] - first[axis]);
    let of_box = |shift: Shift| Shift { low: from_first(shift.low), high: from_first(shift.high), ..shift };
    found.into_iter().flatten().map(of_box).collect()
}

/// Triangles far from a block, evaluated at its middle.
struct Evaluated {
    triangles: Vec<u32>,
    /// Those that are dipoles.
    dipoles: Vec<u32>,
    middle: DVec3,
    theta: f64,
    gradient: DVec3,
    /// Of the dipoles.
    curvature: DMat3,
    /// Of theta with its derivatives, in the block.
    error: f64,
    /// The part of the error that is left where dipoles are evaluated at a point.
    dipole_error: f64,
}

impl Evaluated {
    fn new(middle: DVec3) -> Evaluated {
        Evaluated {
            triangles: Vec::new(),
            dipoles: Vec::new(),
            middle,
            theta: 0.0,
            gradient: DVec3::ZERO,
            curvature: DMat3::ZERO,
            error: 0.0,
            dipole_error: 0.0,
        }
    }

    /// Adds a triangle at a distance from a block of this radius, in the way that is less wrong.
    fn add(&mut self, index: u32, triangle: &Triangle, distance: f64, radius: f64) {
        let by_gradient = 3.0 * triangle.area * radius * radius / (4.0 * PI * distance.powi(4));
        let dipole_error = triangle.dipole_error(distance);
        let by_dipole = dipole_error + triangle.area * radius.powi(3) / (PI * distance.powi(5));
        if by_dipole < by_gradient {
            let (gradient, curvature) = triangle.dipole_derivatives(self.middle);
            self.dipoles.push(index);
            self.theta += triangle.dipole(self.middle);
            self.gradient += gradient;
            self.curvature += curvature;
            self.error += by_dipole;
            self.dipole_error += dipole_error;
        } else {
            self.triangles.push(index);
            self.theta += triangle.theta(self.middle);
            self.gradient += triangle.gradient(self.middle);
            self.error += by_gradient;
        }
    }
}

/// Theta of some triangles at a point, how it changes around it, and how far all this may be wrong.
struct Known {
    theta: f64,
    gradient: DVec3,
    curvature: DMat3,
    error: f64,
}

fn known(far: &[Evaluated], point: DVec3) -> Known {
    let nothing = Known { theta: 0.0, gradient: DVec3::ZERO, curvature: DMat3::ZERO, error: 0.0 };
    far.iter().fold(nothing, |sum, one| {
        let step = point - one.middle;
        let turn = one.curvature * step;
        Known {
            theta: sum.theta + one.theta + (one.gradient + turn * 0.5).dot(step),
            gradient: sum.gradient + one.gradient + turn,
            curvature: sum.curvature + one.curvature,
            error: sum.error + one.error,
        }
    })
}

/// At most the change of what is known within a radius.
fn change(known: &Known, radius: f64) -> f64 {
    let [x, y, z] = [known.curvature.x_axis, known.curvature.y_axis, known.curvature.z_axis].map(DVec3::length_squared);
    known.gradient.length() * radius + 0.5 * (x + y + z).sqrt() * radius * radius
}

struct Search<'a> {
    triangles: Vec<Triangle>,
    centre: &'a (dyn Fn(usize, u32) -> i64 + Sync),
    /// Cells a unit of the snap.
    unit: f64,
    scale: DVec3,
    before: DVec3,
}

impl Search<'_> {
    /// Finds the shifts of a block; `near` are the triangles that are not in `far`.
    fn descend(&self, low: [u32; 3], high: [u32; 3], near: &[u32], far: &mut Vec<Evaluated>, found: &mut Vec<Shift>) {
        let point = |cell: [u32; 3]| {
            DVec3::from(self.centre(cell).map(|units| units as f64)) * self.unit * self.scale - self.before
        };
        let (first, last) = (point(low), point(high.map(|end| end - 1)));
        let (middle, half) = ((first + last) * 0.5, (last - first) * 0.5);
        let radius = half.length();
        let mut nearer = Vec::new();
        let mut farther = Evaluated::new(middle);
        let mut error = 0.0;
        for &index in near {
            let triangle = &self.triangles[index as usize];
            let distance = triangle.distance(middle, half);
            if radius > 0.0 && distance >= FAR * radius {
                farther.add(index, triangle, distance, radius);
            } else {
                nearer.push(index);
                if radius > 0.0 {
                    // without end where the block may touch the triangle
                    error += triangle.area * radius / (2.0 * PI * distance.max(0.0).powi(3));
                }
            }
        }
        far.push(farther);
        let m = if radius == 0.0 {
            Some(self.at(low, middle, &nearer, far))
        } else if error < 0.5 {
            let far = known(far, middle);
            shift(far.theta + self.sum(&nearer, middle), error + far.error + change(&far, radius))
        } else {
            None
        };
        match m {
            Some(0) => {}
            Some(m) => found.push(Shift { low, high, m }),
            None => {
                let middles = [0, 1, 2].map(|axis| low[axis] + (high[axis] - low[axis]).div_ceil(2));
                for part in 0..8 {
                    let is_upper = [0, 1, 2].map(|axis| part >> axis & 1 == 1);
                    let low = [0, 1, 2].map(|axis| if is_upper[axis] { middles[axis] } else { low[axis] });
                    let high = [0, 1, 2].map(|axis| if is_upper[axis] { high[axis] } else { middles[axis] });
                    if (0..3).all(|axis| low[axis] < high[axis]) {
                        self.descend(low, high, &nearer, far, found);
                    }
                }
            }
        }
        far.pop();
    }

    fn centre(&self, cell: [u32; 3]) -> [i64; 3] {
        [0, 1, 2].map(|axis| (self.centre)(axis, cell[axis]))
    }

    /// m of one cell. Where its far triangles leave it in doubt these are evaluated there, the nearest first.
    fn at(&self, cell: [u32; 3], point: DVec3, near: &[u32], far: &[Evaluated]) -> i32 {
        let centre = self.centre(cell);
        let of_near = near.iter().map(|&index| self.triangles[index as usize].theta_of_centre(centre, point));
        let (mut theta, mut error) = (of_near.sum::<f64>(), 0.0);
        for n_known in (0..=far.len()).rev() {
            if let Some(evaluated) = far.get(n_known) {
                let dipoles = evaluated.dipoles.iter().map(|&index| self.triangles[index as usize].dipole(point));
                theta += self.sum(&evaluated.triangles, point) + dipoles.sum::<f64>();
                error += evaluated.dipole_error;
            }
            let rest = known(&far[..n_known], point);
            if let Some(m) = shift(theta + rest.theta, error + rest.error) {
                return m;
            }
        }
        let all: f64 = self.triangles.iter().map(|triangle| triangle.theta_of_centre(centre, point)).sum();
        (0.5 - all).floor() as i32
    }

    fn sum(&self, triangles: &[u32], point: DVec3) -> f64 {
        triangles.iter().map(|&index| self.triangles[index as usize].theta(point)).sum()
    }
}

/// m, if it is the same for every theta that is wrong by at most so much.
fn shift(theta: f64, error: f64) -> Option<i32> {
    let [low, high] = [-1.0, 1.0].map(|sign| (0.5 - theta + sign * (error + ROUNDING)).floor());
    (low == high).then_some(low as i32)
}

#[cfg(test)]
mod tests;
