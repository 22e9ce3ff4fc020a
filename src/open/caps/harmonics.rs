//! Solid harmonics: expansions of the solid angle of many triangles, far from them and around a point.
//!
//! # Theory
//! With the regular and irregular solid harmonics U and T in the scaling of Dehnen (2014, Computational Astrophysics and Cosmology
//! 1:1), 1/|x - P| = sum over n and m of conj(U_n^m(x)) T_n^m(P) for |x| < |P|. A triangle is a sheet of dipoles, theta(P) =
//! -1/(4 pi) times the flux of grad 1/|x - P| through it; so its moments M_n^m are those of the flux of grad U_n^m. That gradient is the
//! curl of -(x cross grad U_n^m) / (n + 1), so by Stokes the flux is a sum over the edges. Along one of them e cross x is constant, and
//! what is left is a polynomial of degree n - 1, which Gauss's formula integrates exactly.
//!
//! Of moments about c and a point z, both with some reach, the terms of degree n + k <= p, their order, of (x - c) - (P - z) stay. The gradient of
//! a harmonic |x|^n P_n is at most sqrt(n (n + 1)) |x|^(n-1), so that what is left out is at most [`tail`].
//!
//! Cost: 15 complex numbers an expansion of low degree and 120 of high; 0.1 and 5 microseconds to move one, 0.05 and 0.3 to evaluate it.

use std::array::from_fn;
use std::f64::consts::PI;

use glam::DVec3;

/// Degree of the terms that say where a cell is for nearly all of them.
pub(super) const LOW: usize = 4;
/// Degree of the terms for what these leave in doubt.
pub(super) const HIGH: usize = 14;
/// Points and weights of Gauss's formulas from 0 to 1, exact to degree 3 and to degree 13 (Abramowitz and Stegun, table 25.4).
const GAUSS_LOW: [(f64, f64); 2] = [(0.211_324_865_405_187_1, 0.5), (0.788_675_134_594_812_9, 0.5)];
const GAUSS_HIGH: [(f64, f64); 7] = [
    (0.025_446_043_828_620_74, 0.064_742_483_084_434_85),
    (0.129_234_407_200_302_78, 0.139_852_695_744_638_34),
    (0.297_077_424_311_301_4, 0.190_915_025_252_559_47),
    (0.5, 0.208_979_591_836_734_7),
    (0.702_922_575_688_698_6, 0.190_915_025_252_559_47),
    (0.870_765_592_799_697_2, 0.139_852_695_744_638_34),
    (0.974_553_956_171_379_3, 0.064_742_483_084_434_85),
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
pub(super) struct Terms {
    order: usize,
    /// Of (n, m) with 0 <= m <= n <= order.
    terms: Vec<Complex>,
}

impl Terms {
    pub(super) fn zero(order: usize) -> Terms {
        Terms { order, terms: vec![[0.0; 2]; (order + 1) * (order + 2) / 2] }
    }

    pub(super) fn order(&self) -> usize {
        self.order
    }

    fn of(&self, n: usize, m: isize) -> Complex {
        let [a, b] = self.terms[at(n, m.unsigned_abs())];
        match m {
            0.. => [a, b],
            _ if m % 2 == 0 => [a, -b],
            _ => [-a, b],
        }
    }

    fn add_to(&mut self, n: usize, m: usize, [a, b]: Complex) {
        let term = &mut self.terms[at(n, m)];
        term[0] += a;
        term[1] += b;
    }
}

/// U_n^m at a point.
fn regular(point: DVec3, order: usize) -> Terms {
    let (mut terms, square) = (Terms::zero(order), point.length_squared());
    let u = &mut terms.terms[..];
    u[0] = [1.0, 0.0];
    for m in 0..=order {
        if m > 0 {
            let half = 0.5 / m as f64;
            u[at(m, m)] = times(u[at(m - 1, m - 1)], [point.x * half, point.y * half]);
        }
        for n in m + 1..=order {
            let below = if n > m + 1 { u[at(n - 2, m)] } else { [0.0; 2] };
            let (last, by) = (u[at(n - 1, m)], 1.0 / ((n + m) * (n - m)) as f64);
            let step = (2 * n - 1) as f64 * point.z;
            u[at(n, m)] = [(step * last[0] - square * below[0]) * by, (step * last[1] - square * below[1]) * by];
        }
    }
    terms
}

/// T_n^m at a point.
fn irregular(point: DVec3, order: usize) -> Terms {
    let (mut terms, by) = (Terms::zero(order), 1.0 / point.length_squared());
    let t = &mut terms.terms[..];
    t[0] = [by.sqrt(), 0.0];
    for m in 0..=order {
        if m > 0 {
            let step = (2 * m - 1) as f64 * by;
            t[at(m, m)] = times(t[at(m - 1, m - 1)], [point.x * step, point.y * step]);
        }
        for n in m + 1..=order {
            let below = if n > m + 1 { t[at(n - 2, m)] } else { [0.0; 2] };
            let last = t[at(n - 1, m)];
            let (step, less) = ((2 * n - 1) as f64 * point.z, ((n - 1) * (n - 1) - m * m) as f64);
            t[at(n, m)] = [(step * last[0] - less * below[0]) * by, (step * last[1] - less * below[1]) * by];
        }
    }
    terms
}

/// Adds the moments of a triangle about the origin.
pub(super) fn add_triangle(moments: &mut Terms, corners: [DVec3; 3]) {
    let points = if moments.order > LOW { &GAUSS_HIGH[..] } else { &GAUSS_LOW[..] };
    for k in 0..3 {
        let (from, edge) = (corners[k], corners[(k + 1) % 3] - corners[k]);
        let across = edge.cross(from);
        for &(place, weight) in points {
            let u = regular(from + edge * place, moments.order - 1);
            add_slopes(moments, &u, across * (weight / (4.0 * PI)));
        }
    }
}

/// Adds v grad U_n^m / (n + 1) for all n and m.
fn add_slopes(moments: &mut Terms, u: &Terms, v: DVec3) {
    for n in 1..=moments.order {
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
    let u = regular(step, to.order);
    for n in 1..=to.order {
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
    let order = local.order;
    let t = irregular(point, order);
    let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    for k in 0..order {
        for l in 0..=k {
            let mut sum = [0.0; 2];
            for n in 1..=order - k {
                let own = &moments.terms[at(n, 0)..=at(n, n)];
                let row = &t.terms[at(n + k, 0)..=at(n + k, n + k)];
                // those of m, and with the sign of m those of -m: from T of l - m, and beyond l from its conjugate
                own.iter().zip(&row[l..]).for_each(|(&own, &t)| add(&mut sum, times(conjugate(own), t), 1.0));
                let (lower, upper) = own.split_at(n.min(l) + 1);
                let below = lower.iter().zip(row[..=l].iter().rev()).enumerate().skip(1);
                below.for_each(|(m, (&own, &t))| add(&mut sum, times(own, t), sign(m)));
                upper.iter().zip(&row[1..]).for_each(|(&own, &t)| add(&mut sum, times(own, conjugate(t)), sign(l)));
            }
            local.add_to(k, l, sum.map(|part| sign(k) * part));
        }
    }
}

fn add(sum: &mut Complex, [a, b]: Complex, by: f64) {
    sum[0] += by * a;
    sum[1] += by * b;
}

/// Theta of moments, whose centre is the origin, at a point.
pub(super) fn far(moments: &Terms, point: DVec3) -> f64 {
    product(moments, &irregular(point, moments.order))
}

/// Theta of an expansion around the origin at a point.
pub(super) fn near(local: &Terms, point: DVec3) -> f64 {
    product(local, &regular(point, local.order))
}

fn product(one: &Terms, other: &Terms) -> f64 {
    let mut sum = 0.0;
    for n in 0..=one.order {
        let of = |m: usize| {
            let ([a, b], [c, d]) = (one.terms[at(n, m)], other.terms[at(n, m)]);
            a * c + b * d
        };
        sum += of(0) + 2.0 * (1..=n).map(of).sum::<f64>();
    }
    sum
}

/// The expansion around a point at `step` from the old one.
pub(super) fn moved(local: &Terms, step: DVec3) -> Terms {
    let order = local.order;
    let (u, mut to) = (regular(step, order), Terms::zero(order));
    for j in 0..=order {
        for i in 0..=j as isize {
            let mut sum = [0.0; 2];
            for k in j..=order {
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
    for n in 1..=local.order {
        power *= radius;
        square *= (n * n) as f64;
        let (mut sum, mut weight) = (0.0, square);
        for m in 0..=n {
            if m > 0 {
                weight *= (n + m) as f64 / (n - m + 1) as f64;
            }
            let [a, b] = local.terms[at(n, m)];
            sum += (a * a + b * b) / weight * if m == 0 { 1.0 } else { 2.0 };
        }
        change += power * sum.sqrt();
    }
    (local.terms[0][0], change)
}

/// Most that all terms after some degree are together, of triangles of this area and points whose reaches add up to `reach`, at a distance.
pub(super) fn tail(degree: usize, area: f64, reach: f64, distance: f64) -> f64 {
    let (q, left) = (reach / distance, 1.0 - reach / distance);
    area / (4.0 * PI * distance * distance) * q.powi(degree as i32) * ((degree as f64 + 1.5) / left + q / (left * left))
}
