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

/// Terms of degree 4, which say where a cell is for nearly all of them.
pub(super) const LOW: usize = 15;
/// Terms of degree 14, for what these leave in doubt.
pub(super) const HIGH: usize = 120;
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
const fn at(n: usize, m: usize) -> usize {
    n * (n + 1) / 2 + m
}

/// The degree of so many terms.
pub(super) const fn degree(n_terms: usize) -> usize {
    let mut degree = 0;
    while at(degree + 1, 0) < n_terms {
        degree += 1;
    }
    degree
}

/// Terms of (n, m) with 0 <= m <= n <= their degree; of -m it is (-1)^m times the conjugate. Their number is known to the compiler,
/// which unrolls the loops of low degree.
#[derive(Clone)]
pub(super) struct Terms<const N: usize>([Complex; N]);

impl<const N: usize> Terms<N> {
    pub(super) const DEGREE: usize = degree(N);

    pub(super) fn zero() -> Terms<N> {
        Terms([[0.0; 2]; N])
    }

    /// Those of n.
    fn row(&self, n: usize) -> &[Complex] {
        &self.0[at(n, 0)..=at(n, n)]
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

/// Terms from those of lower degree. `next` has n, m, and the terms (n - 1, m) and (n - 2, m), or 0 where there is none; `last` has n and the
/// term (n - 1, n - 1). So those of one n do not wait for each other.
#[inline(always)]
fn terms<const N: usize>(
    first: f64,
    next: impl Fn(usize, usize, f64, f64) -> f64,
    last: impl Fn(usize, Complex) -> Complex,
) -> Terms<N> {
    let mut terms = Terms::zero();
    terms.0[0] = [first, 0.0];
    for n in 1..=Terms::<N>::DEGREE {
        let (done, row) = terms.0.split_at_mut(at(n, 0));
        let (done, above) = done.split_at(at(n - 1, 0));
        let below = &done[at(n - 1, 0) - (n - 1)..];
        for (m, ((term, above), below)) in row.iter_mut().zip(above).zip(below).enumerate() {
            *term = from_fn(|part| next(n, m, above[part], below[part]));
        }
        row[n - 1] = above[n - 1].map(|above| next(n, n - 1, above, 0.0));
        row[n] = last(n, above[n - 1]);
    }
    terms
}

/// U_n^m at a point.
fn regular<const N: usize>(point: DVec3) -> Terms<N> {
    let square = point.length_squared();
    let next = |n: usize, m: usize, above: f64, below: f64| {
        ((2 * n - 1) as f64 * point.z * above - square * below) * INVERSE[n][m]
    };
    terms(1.0, next, |n, above| times(above, [point.x, point.y].map(|part| part * (0.5 / n as f64))))
}

/// T_n^m at a point.
fn irregular<const N: usize>(point: DVec3) -> Terms<N> {
    let by = 1.0 / point.length_squared();
    let next = |n: usize, m: usize, above: f64, below: f64| {
        ((2 * n - 1) as f64 * point.z * above - ((n - 1) * (n - 1) - m * m) as f64 * below) * by
    };
    terms(by.sqrt(), next, |n, above| times(above, [point.x, point.y].map(|part| part * ((2 * n - 1) as f64 * by))))
}

/// 1 / ((n + m) (n - m)) for m < n.
const INVERSE: [[f64; degree(HIGH)]; degree(HIGH) + 1] = {
    let mut inverse = [[0.0; degree(HIGH)]; degree(HIGH) + 1];
    let mut n = 1;
    while n <= degree(HIGH) {
        let mut m = 0;
        while m < n {
            inverse[n][m] = 1.0 / ((n + m) * (n - m)) as f64;
            m += 1;
        }
        n += 1;
    }
    inverse
};

/// Adds the moments of a triangle about the origin.
pub(super) fn add_triangle<const N: usize>(moments: &mut Terms<N>, corners: [DVec3; 3]) {
    let points = if N > LOW { &GAUSS_HIGH[..] } else { &GAUSS_LOW[..] };
    for k in 0..3 {
        let (from, edge) = (corners[k], corners[(k + 1) % 3] - corners[k]);
        let across = edge.cross(from);
        for &(place, weight) in points {
            let u = regular(from + edge * place);
            add_slopes(moments, &u, across * (weight / (4.0 * PI)));
        }
    }
}

/// Adds v grad U_n^m / (n + 1) for all n and m.
fn add_slopes<const N: usize>(moments: &mut Terms<N>, u: &Terms<N>, v: DVec3) {
    for n in 1..=Terms::<N>::DEGREE {
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
pub(super) fn add_moved<const N: usize>(to: &mut Terms<N>, moments: &Terms<N>, step: DVec3) {
    let u: Terms<N> = regular(step);
    for n in 1..=Terms::<N>::DEGREE {
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
pub(super) fn add_around<const N: usize>(local: &mut Terms<N>, moments: &Terms<N>, point: DVec3) {
    let t: Terms<N> = irregular(point);
    let sign = |k: usize| if k.is_multiple_of(2) { 1.0 } else { -1.0 };
    for k in 0..Terms::<N>::DEGREE {
        for l in 0..=k {
            let mut sum = [0.0; 2];
            for n in 1..=Terms::<N>::DEGREE - k {
                let (own, row) = (moments.row(n), t.row(n + k));
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
pub(super) fn far<const N: usize>(moments: &Terms<N>, point: DVec3) -> f64 {
    product(moments, &irregular(point))
}

/// Theta of an expansion around the origin at a point.
pub(super) fn near<const N: usize>(local: &Terms<N>, point: DVec3) -> f64 {
    product(local, &regular(point))
}

fn product<const N: usize>(one: &Terms<N>, other: &Terms<N>) -> f64 {
    // each m > 0 counts twice; four sums, so that none waits for the others
    let (mut sums, mut of_zero) = ([[0.0; 2]; 2], 0.0);
    for (k, (one, other)) in one.0.iter().zip(&other.0).enumerate() {
        (0..2).for_each(|part| sums[k % 2][part] += one[part] * other[part]);
    }
    (0..=Terms::<N>::DEGREE).for_each(|n| of_zero += one.0[at(n, 0)][0] * other.0[at(n, 0)][0]);
    2.0 * (sums[0][0] + sums[0][1] + sums[1][0] + sums[1][1]) - of_zero
}

/// The expansion around a point at `step` from the old one.
pub(super) fn moved<const N: usize>(local: &Terms<N>, step: DVec3) -> Terms<N> {
    let (u, mut to): (Terms<N>, Terms<N>) = (regular(step), Terms::zero());
    for j in 0..=Terms::<N>::DEGREE {
        for i in 0..=j as isize {
            let mut sum = [0.0; 2];
            for k in j..=Terms::<N>::DEGREE {
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
pub(super) fn add_slope<const N: usize>(local: &mut Terms<N>, theta: f64, gradient: DVec3) {
    local.add_to(0, 0, [theta, 0.0]);
    local.add_to(1, 0, [gradient.z, 0.0]);
    local.add_to(1, 1, [gradient.x, gradient.y]);
}

/// The value at the middle of an expansion, and the most that it changes within a radius: as the sum over m of |U_n^m|^2 (n - m)! (n + m)! is
/// |x|^(2 n), that follows from Schwarz's inequality.
pub(super) fn value_and_change<const N: usize>(local: &Terms<N>, radius: f64) -> (f64, f64) {
    let (mut change, mut power) = (0.0, 1.0);
    // (n - m)! (n + m)! for m = 0
    let mut square = 1.0;
    for n in 1..=Terms::<N>::DEGREE {
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

/// Most that all terms after some degree are together, of triangles of this area and points whose reaches add up to `reach`, at a distance.
pub(super) fn tail(degree: usize, area: f64, reach: f64, distance: f64) -> f64 {
    let (q, left) = (reach / distance, 1.0 - reach / distance);
    area / (4.0 * PI * distance * distance) * q.powi(degree as i32) * ((degree as f64 + 1.5) / left + q / (left * left))
}
