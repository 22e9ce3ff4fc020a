//! Caps: triangles that close the holes of a surface, and how far their solid angle moves its winding number.
//!
//! Loops of open edges -> caps; caps, cells -> [`Shift`]s. With theta(P) the solid angle of all caps at P over 4 pi, a surface
//! whose winding number is w has the winding number w + theta together with its caps. That is an integer n, so round(w) =
//! n + m with m = floor(1/2 - theta). m is 0 wherever |theta| < 1/2, which is nearly everywhere.
//!
//! The cells where it is not are found in blocks. Of a triangle of area A at a distance of at least d from every centre of a block
//! of half diagonal r, theta differs from its value at the middle by at most A r / (2 pi d^3), and from that with its gradient
//! by at most 3 A r^2 / (4 pi d^4): the integrand n.x / |x|^3, a dipole, has derivatives of at most 2 / |x|^3 and 6 / |x|^4.
//! Where the sum of these leaves m in no doubt the whole block has it; else the block is split in eight, down to one cell, for
//! which theta is computed. Triangles far from a block are not looked at again in its parts: their value and gradient at its
//! middle serve, unless the error leaves a cell in doubt. So every cell has the m that it has by itself.
//!
//! Centres are moved by a fraction of the snap's unit, so that none lies in the plane of a cap: there theta jumps by 1.
//! Cost: O(log n) triangles a block, some 100 ns each; some hundred blocks a hole.

use std::f64::consts::PI;

use glam::DVec3;

use crate::frame::SnappedFacet;
use crate::parallel::*;

/// Triangles this many half diagonals away from a block are evaluated once for all its cells.
const FAR: f64 = 4.0;
/// More than all rounding errors of theta.
const ROUNDING: f64 = 1e-6;
/// How far the points at which theta is evaluated lie before the centres, in units of the snap.
const BEFORE: DVec3 = DVec3::new(0.4375, 0.28125, 0.15625);
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

/// Finds the cells of a box of `dims` cells where m is not 0. A cell is 2^`fraction_bits` units of the snap; `sizes` are its
/// lengths along the axes, in any unit.
pub(super) fn shifts(caps: &[SnappedFacet], dims: [u32; 3], fraction_bits: u32, sizes: [f64; 3]) -> Vec<Shift> {
    let unit = 1.0 / f64::from(1u32 << fraction_bits);
    let scale = DVec3::from(sizes) / sizes[0];
    let place = |corner: [i32; 3]| DVec3::from(corner.map(f64::from)) * unit * scale;
    let triangles: Vec<Triangle> = caps.iter().filter_map(|cap| Triangle::new(cap.map(place))).collect();
    if triangles.is_empty() {
        return Vec::new();
    }
    let search = Search { triangles, scale, before: BEFORE * unit * scale };
    let all: Vec<u32> = (0..search.triangles.len() as u32).collect();
    let starts = |axis: usize| (0..dims[axis]).step_by(dims[axis].div_ceil(BLOCKS) as usize);
    let mut blocks = Vec::new();
    for z in starts(2) {
        for y in starts(1) {
            for x in starts(0) {
                let low = [x, y, z];
                blocks.push((low, [0, 1, 2].map(|axis| (low[axis] + dims[axis].div_ceil(BLOCKS)).min(dims[axis]))));
            }
        }
    }
    let of_block = |(low, high)| {
        let mut found = Vec::new();
        search.descend(low, high, &all, &mut Vec::new(), &mut found);
        found
    };
    let found: Vec<Vec<Shift>> = blocks.into_par_iter().map(of_block).collect();
    found.concat()
}

/// A triangle of a cap, in cells of the first axis.
struct Triangle {
    corners: [DVec3; 3],
    low: DVec3,
    high: DVec3,
    normal: DVec3,
    area: f64,
}

impl Triangle {
    /// None for one without area, which has no solid angle.
    fn new(corners: [DVec3; 3]) -> Option<Triangle> {
        let [a, b, c] = corners;
        let doubled = (b - a).cross(c - a);
        let length = doubled.length();
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        (length > 0.0).then(|| Triangle { corners, low, high, normal: doubled / length, area: 0.5 * length })
    }

    /// Solid angle at a point over 4 pi, positive where the triangle turns its back on it (van Oosterom and Strackee 1983).
    fn theta(&self, point: DVec3) -> f64 {
        let [a, b, c] = self.corners.map(|corner| corner - point);
        let [la, lb, lc] = [a.length(), b.length(), c.length()];
        let top = a.dot(b.cross(c));
        let bottom = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        libm::atan2(top, bottom) / (2.0 * PI)
    }

    /// Change of theta a unit of length: the field of a current around the triangle (Biot and Savart), over 4 pi.
    fn gradient(&self, point: DVec3) -> DVec3 {
        let corners = self.corners.map(|corner| corner - point);
        let lengths = corners.map(DVec3::length);
        let of_edge = |(from, to): (usize, usize)| {
            let (a, b, la, lb) = (corners[from], corners[to], lengths[from], lengths[to]);
            a.cross(b) * ((la + lb) / (la * lb * (la * lb + a.dot(b))))
        };
        [(0, 1), (1, 2), (2, 0)].map(of_edge).into_iter().fold(DVec3::ZERO, |sum, edge| sum + edge) / (4.0 * PI)
    }

    /// At most the distance from any point of a box.
    fn distance(&self, middle: DVec3, half: DVec3) -> f64 {
        let apart = (self.low - (middle + half)).max((middle - half) - self.high).max(DVec3::ZERO);
        let across = self.normal.dot(middle - self.corners[0]).abs() - self.normal.abs().dot(half);
        apart.length().max(across)
    }
}

/// Triangles far from a block, evaluated at its middle.
struct Evaluated {
    triangles: Vec<u32>,
    middle: DVec3,
    theta: f64,
    gradient: DVec3,
    /// Of theta with the gradient, in the block.
    error: f64,
}

/// Theta of some triangles at a point, how it changes around it, and how far all this may be wrong.
#[derive(Clone, Copy, Default)]
struct Known {
    theta: f64,
    gradient: DVec3,
    error: f64,
}

fn known(far: &[Evaluated], point: DVec3) -> Known {
    far.iter().fold(Known::default(), |sum, one| Known {
        theta: sum.theta + one.theta + one.gradient.dot(point - one.middle),
        gradient: sum.gradient + one.gradient,
        error: sum.error + one.error,
    })
}

struct Search {
    triangles: Vec<Triangle>,
    scale: DVec3,
    before: DVec3,
}

impl Search {
    /// Finds the shifts of a block; `near` are the triangles that are not in `far`.
    fn descend(&self, low: [u32; 3], high: [u32; 3], near: &[u32], far: &mut Vec<Evaluated>, found: &mut Vec<Shift>) {
        let point = |cell: [u32; 3]| DVec3::from(cell.map(f64::from)) * self.scale - self.before;
        let (first, last) = (point(low), point(high.map(|end| end - 1)));
        let (middle, half) = ((first + last) * 0.5, (last - first) * 0.5);
        let radius = half.length();
        let mut nearer = Vec::new();
        let mut farther = Evaluated { triangles: Vec::new(), middle, theta: 0.0, gradient: DVec3::ZERO, error: 0.0 };
        let mut error = 0.0;
        for &index in near {
            let triangle = &self.triangles[index as usize];
            let distance = triangle.distance(middle, half);
            if radius > 0.0 && distance >= FAR * radius {
                farther.triangles.push(index);
                farther.theta += triangle.theta(middle);
                farther.gradient += triangle.gradient(middle);
                farther.error += 3.0 * triangle.area * radius * radius / (4.0 * PI * distance.powi(4));
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
            Some(self.at(middle, &nearer, far))
        } else if error < 0.5 {
            let far = known(far, middle);
            shift(far.theta + self.sum(&nearer, middle), error + far.error + far.gradient.length() * radius)
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

    /// m of one cell that its far triangles leave in doubt: these are evaluated there, the nearest first.
    fn at(&self, point: DVec3, near: &[u32], far: &[Evaluated]) -> i32 {
        let mut theta = self.sum(near, point);
        for n_known in (0..=far.len()).rev() {
            if let Some(evaluated) = far.get(n_known) {
                theta += self.sum(&evaluated.triangles, point);
            }
            let rest = known(&far[..n_known], point);
            if let Some(m) = shift(theta + rest.theta, rest.error) {
                return m;
            }
        }
        let all: f64 = self.triangles.iter().map(|triangle| triangle.theta(point)).sum();
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
mod tests {
    use super::*;

    #[test]
    fn the_gradient_is_that_of_theta() {
        let corners = [[0.0, 0.1, 0.2], [3.0, 0.3, -0.1], [0.4, 2.0, 0.5]].map(DVec3::from);
        let triangle = Triangle::new(corners).unwrap();
        for point in [[1.0, 0.5, 2.0], [-3.0, 4.0, -2.0], [0.9, 0.8, -0.6]].map(DVec3::from) {
            let step = 1e-5;
            let difference = [DVec3::X, DVec3::Y, DVec3::Z]
                .map(|axis| (triangle.theta(point + axis * step) - triangle.theta(point - axis * step)) / (2.0 * step));
            let gradient = triangle.gradient(point);
            assert!((gradient - DVec3::from(difference)).length() < 1e-8, "{gradient} {difference:?}");
        }
    }

    #[test]
    fn blocks_give_every_cell_what_it_has_by_itself() {
        // a bent loop of 16 corners, one of 3, and one far outside, in boxes of cells that are not cubes
        let bits = 8;
        let bent: Vec<[i32; 3]> = (0..16)
            .map(|k| {
                let angle = f64::from(k) * PI / 8.0;
                let place = [8.0 + 5.0 * angle.cos(), 7.0 + 5.0 * angle.sin(), 6.0 + 4.0 * (3.0 * angle).cos()];
                place.map(|c| (c * 256.0) as i32)
            })
            .collect();
        let small = vec![[300, 500, 700], [900, 520, 650], [610, 1100, 900]];
        let beyond = vec![[-9000, 0, 0], [-9000, 4000, 0], [-9000, 4000, 4000], [-9000, 0, 4000]];
        let caps = caps(&[bent, small, beyond]);
        for (dims, sizes) in [([16, 16, 12], [1.0, 1.0, 1.0]), ([17, 5, 23], [0.1, 0.25, 0.07])] {
            let unit = 1.0 / 256.0;
            let scale = DVec3::from(sizes) / sizes[0];
            let placed = caps.iter().map(|cap| cap.map(|corner| DVec3::from(corner.map(f64::from)) * unit * scale));
            let triangles: Vec<Triangle> = placed.filter_map(Triangle::new).collect();
            let found = shifts(&caps, dims, bits, sizes);
            let mut n_moved = 0;
            for z in 0..dims[2] {
                for y in 0..dims[1] {
                    for x in 0..dims[0] {
                        let point = DVec3::from([x, y, z].map(f64::from)) * scale - BEFORE * unit * scale;
                        let theta: f64 = triangles.iter().map(|triangle| triangle.theta(point)).sum();
                        let holds = |shift: &&Shift| {
                            [x, y, z]
                                .iter()
                                .zip(shift.low.iter().zip(shift.high))
                                .all(|(&c, (&low, high))| low <= c && c < high)
                        };
                        let m: i32 = found.iter().filter(holds).map(|shift| shift.m).sum();
                        assert_eq!(m, (0.5 - theta).floor() as i32, "cell {x} {y} {z}, theta {theta}");
                        n_moved += usize::from(m != 0);
                    }
                }
            }
            assert!(n_moved > 0, "no cell is moved in {dims:?}");
        }
    }
}
