//! Solid harmonics: expansions of the solid angle of many triangles, far from them and around a point.
//!
//! # Theory
//! With the regular and irregular solid harmonics U and T in the scaling of Dehnen (2014, Computational Astrophysics and Cosmology
//! 1:1), 1/|x - P| = sum over n and m of conj(U_n^m(x)) T_n^m(P) for |x| < |P|. A triangle is a sheet of dipoles, theta(P) =
//! -1/(4 pi) times the flux of grad 1/|x - P| through it; so its moments M_n^m are those of the flux of grad U_n^m. That gradient is the
//! curl of -(x cross grad U_n^m) / (n + 1), so by Stokes the flux is a sum over the edges. Along one of them e cross x is constant, and
//! what is left is a polynomial of degree n - 1, which Gauss's formula with [`POINTS`] points integrates exactly.
//!
//! Of moments about c and a point z, both with some reach, the terms of degree n + k <= [`ORDER`] of (x - c) - (P - z) stay. The gradient of
//! a harmonic |x|^n P_n is at most sqrt(n (n + 1)) |x|^(n-1), so that what is left out is at most [`tail`].
//!
//! Cost: 120 complex numbers an expansion; some 5 microseconds to move one, 0.3 to evaluate it.

use std::array::from_fn;
use std::f64::consts::PI;

use glam::DVec3;

/// Highest degree of the terms.
pub(super) const ORDER: usize = 14;
/// Of (n, m) with 0 <= m <= n <= [`ORDER`].
const TERMS: usize = (ORDER + 1) * (ORDER + 2) / 2;
/// Points of Gauss's formula, exact to degree 13.
const POINTS: usize = 7;
/// The places in 0 to 1 of the first half and the middle, and their weights (Abramowitz and Stegun, table 25.4).
const GAUSS: [(f64, f64); 4] = [
    (0.025_446_043_828_620_74, 0.064_742_483_084_434_85),
    (0.129_234_407_200_302_78, 0.139_852_695_744_638_34),
    (0.297_077_424_311_301_4, 0.190_915_025_252_559_47),
    (0.5, 0.208_979_591_836_734_7),
];

type Complex = [f64; 2];

fn times([a, b]: Complex, [c, d]: Complex) -> Complex {
    [a * c - b * d, a * d + b * c]
}

fn conjugate([a, b]: Complex) -> Complex {
    [a, -b]
}

/// Where a term is.
fn at(n: usize, m: usize) -> usize {
    n * (n + 1) / 2 + m
}

/// Terms with m >= 0; of -m it is (-1)^m times the conjugate.
#[derive(Clone)]
pub(super) struct Terms(Box<[Complex; TERMS]>);

impl Terms {
    pub(super) fn zero() -> Terms {
        Terms(Box::new([[0.0; 2]; TERMS]))
    }

    fn of(&self, n: usize, m: isize) -> Complex {
        let [a, b] = self.0[at(n, m.unsigned_abs())];
        match m {
            0.. => [a, b],
            _ if m % 2 == 0 => [a, -b],
            _ => [-a, b],
        }
    }

    fn add_to(&mut self, n: usize, m: usize, [a, b]: Complex) {
        let term = &mut self.0[at(n, m)];
        term[0] += a;
        term[1] += b;
    }
}

/// U_n^m at a point.
fn regular(point: DVec3) -> Terms {
    let (mut terms, square) = (Terms::zero(), point.length_squared());
    let u = &mut terms.0;
    u[0] = [1.0, 0.0];
    for m in 0..=ORDER {
        if m > 0 {
            let half = 0.5 / m as f64;
            u[at(m, m)] = times(u[at(m - 1, m - 1)], [point.x * half, point.y * half]);
        }
        for n in m + 1..=ORDER {
            let below = if n > m + 1 { u[at(n - 2, m)] } else { [0.0; 2] };
            let (last, by) = (u[at(n - 1, m)], 1.0 / ((n + m) * (n - m)) as f64);
            let step = (2 * n - 1) as f64 * point.z;
            u[at(n, m)] = [0, 1].map(|k| (step * last[k] - square * below[k]) * by);
        }
    }
    terms
}

/// T_n^m at a point.
fn irregular(point: DVec3) -> Terms {
    let (mut terms, by) = (Terms::zero(), 1.0 / point.length_squared());
    let t = &mut terms.0;
    t[0] = [by.sqrt(), 0.0];
    for m in 0..=ORDER {
        if m > 0 {
            let step = (2 * m - 1) as f64 * by;
            t[at(m, m)] = times(t[at(m - 1, m - 1)], [point.x * step, point.y * step]);
        }
        for n in m + 1..=ORDER {
            let below = if n > m + 1 { t[at(n - 2, m)] } else { [0.0; 2] };
            let last = t[at(n - 1, m)];
            let (step, less) = ((2 * n - 1) as f64 * point.z, ((n - 1) * (n - 1) - m * m) as f64);
            t[at(n, m)] = [0, 1].map(|k| (step * last[k] - less * below[k]) * by);
        }
    }
    terms
}

/// Adds the moments of a triangle about the origin.
pub(super) fn add_triangle(moments: &mut Terms, corners: [DVec3; 3]) {
    for k in 0..3 {
        let (from, edge) = (corners[k], corners[(k + 1) % 3] - corners[k]);
        let across = edge.cross(from);
        for point in 0..POINTS {
            let (place, weight) = GAUSS[point.min(POINTS - 1 - point)];
            let place = if 2 * point < POINTS { place } else { 1.0 - place };
            add_slopes(moments, &regular(from + edge * place), across * (weight / (4.0 * PI)));
        }
    }
}

/// Adds v grad U_n^m / (n + 1) for all n and m.
fn add_slopes(moments: &mut Terms, u: &Terms, v: DVec3) {
    for n in 1..=ORDER {
        let by = 1.0 / (n + 1) as f64;
        let [plus, minus] = [[v.x * 0.5 * by, -v.y * 0.5 * by], [v.x * 0.5 * by, v.y * 0.5 * by]];
        let below = |m: isize| if m.unsigned_abs() < n { u.of(n - 1, m) } else { [0.0; 2] };
        for m in 0..=n {
            // the derivatives along x + i y, x - i y and z
            let [up, down, along] = [1, -1, 0].map(|step| below(m as isize + step));
            let (up, down) = (times([-up[0], -up[1]], plus), times(down, minus));
            moments.add_to(n, m, from_fn(|k| up[k] + down[k] + along[k] * v.z * by));
        }
    }
}

/// Adds moments whose centre lies at `step` from the new one.
pub(super) fn add_moved(to: &mut Terms, moments: &Terms, step: DVec3) {
    let u = regular(step);
    for n in 1..=ORDER {
        for m in 0..=n as isize {
            let mut sum = [0.0; 2];
            for k in 1..=n {
                let rest = (n - k) as isize;
                for l in (m - rest).max(-(k as isize))..=(m + rest).min(k as isize) {
                    let term = times(u.of(n - k, m - l), moments.of(k, l));
                    sum = from_fn(|part| sum[part] + term[part]);
                }
            }
            to.add_to(n, m as usize, sum);
        }
    }
}

/// Adds what moments, whose centre is the origin, are around a point.
pub(super) fn add_around(local: &mut Terms, moments: &Terms, point: DVec3) {
    let t = irregular(point);
    for k in 0..ORDER {
        for l in 0..=k {
            let mut sum = [0.0; 2];
            for n in 1..=ORDER - k {
                let term = times(conjugate(moments.0[at(n, 0)]), t.0[at(n + k, l)]);
                sum = from_fn(|part| sum[part] + term[part]);
                for m in 1..=n {
                    let (own, sign) = (moments.0[at(n, m)], if m % 2 == 0 { 1.0 } else { -1.0 });
                    let one = times(conjugate(own), t.0[at(n + k, m + l)]);
                    let other = times(own, t.of(n + k, l as isize - m as isize));
                    sum = from_fn(|part| sum[part] + one[part] + sign * other[part]);
                }
            }
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            local.add_to(k, l, sum.map(|part| sign * part));
        }
    }
}

/// Theta of moments, whose centre is the origin, at a point.
pub(super) fn far(moments: &Terms, point: DVec3) -> f64 {
    product(moments, &irregular(point))
}

/// Theta of an expansion around the origin at a point.
pub(super) fn near(local: &Terms, point: DVec3) -> f64 {
    product(local, &regular(point))
}

fn product(one: &Terms, other: &Terms) -> f64 {
    let mut sum = 0.0;
    for n in 0..=ORDER {
        let of = |m: usize| {
            let ([a, b], [c, d]) = (one.0[at(n, m)], other.0[at(n, m)]);
            a * c + b * d
        };
        sum += of(0) + 2.0 * (1..=n).map(of).sum::<f64>();
    }
    sum
}

/// The expansion around a point at `step` from the old one.
pub(super) fn moved(local: &Terms, step: DVec3) -> Terms {
    let (u, mut to) = (regular(step), Terms::zero());
    for j in 0..=ORDER {
        for i in 0..=j as isize {
            let mut sum = [0.0; 2];
            for k in j..=ORDER {
                let rest = (k - j) as isize;
                for l in i - rest..=i + rest {
                    let term = times(conjugate(u.of(k - j, l - i)), local.of(k, l));
                    sum = from_fn(|part| sum[part] + term[part]);
                }
            }
            to.add_to(j, i as usize, sum);
        }
    }
    to
}

/// Adds a value and its gradient.
pub(super) fn add_slope(local: &mut Terms, theta: f64, gradient: DVec3) {
    local.add_to(0, 0, [theta, 0.0]);
    local.add_to(1, 0, [gradient.z, 0.0]);
    local.add_to(1, 1, [gradient.x, gradient.y]);
}

/// The value at the middle of an expansion, and the most that it changes within a radius: as the sum over m of |U_n^m|^2 (n - m)! (n + m)! is
/// |x|^(2 n), that follows from Schwarz's inequality.
pub(super) fn value_and_change(local: &Terms, radius: f64) -> (f64, f64) {
    let (mut change, mut power) = (0.0, 1.0);
    // (n - m)! (n + m)! for m = 0
    let mut square = 1.0;
    for n in 1..=ORDER {
        power *= radius;
        square *= (n * n) as f64;
        let (mut sum, mut weight) = (0.0, square);
        for m in 0..=n {
            if m > 0 {
                weight *= (n + m) as f64 / (n - m + 1) as f64;
            }
            let [a, b] = local.0[at(n, m)];
            sum += (a * a + b * b) / weight * if m == 0 { 1.0 } else { 2.0 };
        }
        change += power * sum.sqrt();
    }
    (local.0[0][0], change)
}

/// Most that all terms after [`ORDER`] are together, of triangles of this area and points whose reaches add up to `reach`, at a distance.
pub(super) fn tail(area: f64, reach: f64, distance: f64) -> f64 {
    let (q, left) = (reach / distance, 1.0 - reach / distance);
    let order = ORDER as f64;
    area / (4.0 * PI * distance * distance) * q.powi(ORDER as i32) * ((order + 1.5) / left + q / (left * left))
}
