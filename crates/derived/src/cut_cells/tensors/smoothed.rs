//! The permittivity that stands for a cell in which several substances lie.
//!
//! Fractions of a cell, their permittivities, a normal -> a symmetric tensor.
//!
//! # Theory
//! Across an interface the component of D along its normal n is the same on both sides, and so are those of E across n. Kottke's tau has for a permittivity what these know of the
//! others: it is linear in what is continuous, so that it may be averaged over the cell, and taken back. Of isotropic substances that is, with P = n n^T,
//! P <1/eps>^-1 + (1 - P) <eps>, however many there are.
//!
//! Degenerate cases: where all are the same, that one, to the last bit; with no normal, their mean.
//!
//! Source: Farjadpour et al. (2006); Kottke, Farjadpour and Johnson (2008), Eq. 4 and 5.

/// A symmetric tensor: xx, yy, zz, yz, xz, xy.
pub type Tensor = [f64; 6];

/// The permittivity of each flag; None of metal.
pub type OfFlags = [Option<Tensor>; 256];

/// Where a tensor has what of a matrix.
const PLACES: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [1, 2], [0, 2], [0, 1]];

type Matrix = [[f64; 3]; 3];

/// That of a substance without directions.
pub fn isotropic(eps: f64) -> Tensor {
    [eps, eps, eps, 0.0, 0.0, 0.0]
}

/// A number for a tensor: a third of its trace.
pub(super) fn mean_of(of: &Tensor) -> f64 {
    if is_isotropic(of) { of[0] } else { (of[0] + of[1] + of[2]) / 3.0 }
}

fn is_isotropic(of: &Tensor) -> bool {
    *of == isotropic(of[0])
}

/// The permittivity of a cell of which each of some substances has a part; what these lack to 1 counts as if they had it in proportion.
pub(super) fn smoothed(parts: &[(f64, Tensor)], normal: Option<[f64; 3]>) -> Tensor {
    let Some((_, first)) = parts.first() else { return isotropic(1.0) };
    if parts.iter().all(|(_, of)| of == first) {
        return *first;
    }
    let total: f64 = parts.iter().map(|(part, _)| part).sum();
    let mean = std::array::from_fn(|at| parts.iter().map(|(part, of)| part * of[at]).sum::<f64>() / total);
    let Some(normal) = normal else { return mean };
    if parts.iter().all(|(_, of)| is_isotropic(of)) {
        let across = total / parts.iter().map(|(part, of)| part / of[0]).sum::<f64>();
        return std::array::from_fn(|at| {
            let [row, column] = PLACES[at];
            mean[at] + (across - mean[0]) * (normal[row] * normal[column])
        });
    }
    let axes = axes_of(normal);
    let mut tau = [[0.0; 3]; 3];
    for (part, of) in parts {
        let of_one = tau_of(&seen_along(&axes, &matrix(of)));
        tau.as_flattened_mut().iter_mut().zip(of_one.as_flattened()).for_each(|(sum, of)| *sum += part * of / total);
    }
    let transposed = [0, 1, 2].map(|row| [0, 1, 2].map(|column: usize| axes[column][row]));
    let found = seen_along(&transposed, &of_tau(&tau));
    PLACES.map(|[row, column]| 0.5 * (found[row][column] + found[column][row]))
}

fn matrix(of: &Tensor) -> Matrix {
    let mut matrix = [[0.0; 3]; 3];
    for (&[row, column], &number) in PLACES.iter().zip(of) {
        (matrix[row][column], matrix[column][row]) = (number, number);
    }
    matrix
}

/// A normal and two axes across it, each of length 1.
fn axes_of(normal: [f64; 3]) -> Matrix {
    let shortest = (0..3).min_by(|&one, &other| normal[one].abs().total_cmp(&normal[other].abs())).unwrap_or(0);
    let along = normal[shortest];
    let across = [0, 1, 2].map(|axis| f64::from(u8::from(axis == shortest)) - along * normal[axis]);
    let length = across.iter().map(|of| of * of).sum::<f64>().sqrt();
    let one = across.map(|of| of / length);
    let other = [0, 1, 2].map(|axis: usize| {
        let [i, j] = [(axis + 1) % 3, (axis + 2) % 3];
        normal[i] * one[j] - normal[j] * one[i]
    });
    [normal, one, other]
}

/// A matrix in other axes, the rows.
fn seen_along(axes: &Matrix, of: &Matrix) -> Matrix {
    let times = |one: &[f64; 3], other: &[f64; 3]| {
        (0..3).flat_map(|row| (0..3).map(move |column| one[row] * of[row][column] * other[column])).sum()
    };
    axes.map(|one| axes.map(|other| times(&one, &other)))
}

/// Kottke's tau; the first axis is the normal.
fn tau_of(eps: &Matrix) -> Matrix {
    let first = eps[0][0];
    let mut tau = [0, 1, 2].map(|row| [0, 1, 2].map(|column| eps[row][column] - eps[row][0] * eps[0][column] / first));
    for at in 1..3 {
        (tau[0][at], tau[at][0]) = (eps[0][at] / first, eps[at][0] / first);
    }
    tau[0][0] = -1.0 / first;
    tau
}

/// The permittivity of a tau.
fn of_tau(tau: &Matrix) -> Matrix {
    let first = tau[0][0];
    let mut eps = [0, 1, 2].map(|row| [0, 1, 2].map(|column| tau[row][column] - tau[row][0] * tau[0][column] / first));
    for at in 1..3 {
        (eps[0][at], eps[at][0]) = (-tau[0][at] / first, -tau[at][0] / first);
    }
    eps[0][0] = -1.0 / first;
    eps
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(found: Tensor, expected: Tensor) {
        let off = found.iter().zip(expected).map(|(one, other)| (one - other).abs()).fold(0.0, f64::max);
        assert!(off < 1e-13, "{found:?}, not {expected:?}");
    }

    #[test]
    fn isotropic_substances_are_averaged_along_and_across_the_normal() {
        let parts = [(0.25, isotropic(2.0)), (0.75, isotropic(12.0))];
        let (mean, across) = (9.5, 1.0 / (0.25 / 2.0 + 0.75 / 12.0));
        assert_near(smoothed(&parts, Some([0.0, 1.0, 0.0])), [mean, across, mean, 0.0, 0.0, 0.0]);
        let (x, y) = (0.6, 0.8);
        let rise = across - mean;
        let expected = [mean + x * x * rise, mean + y * y * rise, mean, 0.0, 0.0, x * y * rise];
        assert_near(smoothed(&parts, Some([x, y, 0.0])), expected);
        assert_eq!(smoothed(&parts, None), isotropic(mean));
        let same = [(0.3, isotropic(0.1)), (0.1, isotropic(0.1)), (0.6, isotropic(0.1))];
        assert_eq!(smoothed(&same, Some([x, y, 0.0])), isotropic(0.1));
    }

    /// The fields in the layers of a cell follow from those that are continuous: what of D they have together.
    #[test]
    fn layers_of_anisotropic_substances_are_as_those_that_fields_see() {
        let tilted = [3.0, 5.0, 7.0, 0.5, -0.75, 1.0];
        let parts = [(0.125, isotropic(1.0)), (0.5, tilted), (0.375, [2.0, 2.5, 4.0, 0.0, 0.25, 0.0])];
        let normal = [2.0 / 7.0, -3.0 / 7.0, 6.0 / 7.0];
        let found = matrix(&smoothed(&parts, Some(normal)));
        let dot = |one: [f64; 3], other: [f64; 3]| (0..3).map(|axis| one[axis] * other[axis]).sum::<f64>();
        let times = |of: &Matrix, by: [f64; 3]| of.map(|row| dot(row, by));
        for (tangential, across) in [([3.0, 2.0, 0.0], 0.0), ([0.0, 2.0, 1.0], 1.0), ([3.0, 0.0, -1.0], -2.0)] {
            assert_eq!(dot(tangential, normal), 0.0);
            // E = tangential + a n in each, with a so that n D = across
            let (mut electric, mut flux) = ([0.0; 3], [0.0; 3]);
            for (part, of) in &parts {
                let eps = matrix(of);
                let a = (across - dot(times(&eps, tangential), normal)) / dot(times(&eps, normal), normal);
                let field = [0, 1, 2].map(|axis| tangential[axis] + a * normal[axis]);
                let d = times(&eps, field);
                electric = [0, 1, 2].map(|axis| electric[axis] + part * field[axis]);
                flux = [0, 1, 2].map(|axis| flux[axis] + part * d[axis]);
            }
            let by_found = times(&found, electric);
            for axis in 0..3 {
                assert!((by_found[axis] - flux[axis]).abs() < 1e-13, "{by_found:?}, not {flux:?}");
            }
        }
    }
}
