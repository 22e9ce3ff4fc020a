//! The largest stable step of a grid with metal.
//!
//! Faraday's law for a face and Ampere's for an edge make the matrix C of a step, scaled by lengths and areas so that it is symmetric: `S = G G'`. Steps up to `2 / (c sqrt(l))` are
//! stable, with l the largest eigenvalue of S. Without metal l is that of Yee, `4 (1/dx^2 + 1/dy^2 + 1/dz^2)` of the smallest cells; what is larger belongs to fields
//! near cut faces, which fall off within a cell. So S is that of the faces of cut cells, and l is found by Lanczos' iteration (1950), whose estimates grow; the iteration
//! stops when they do no more, and the step is kept 1 % below.
//!
//! Outside cells that are cut the bound of Yee is taken at once. Cost: 60 iterations or so of 8 multiplications a face.

use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::base::sort::sort;
use hexcast_core::grid::lines::Lines;

use super::places::{Grid, Outside, edges_of_face};

/// What is kept below the bound.
const SPARE: f64 = 0.99;
/// Iterations at most, and between two looks at the estimate.
const MOST: usize = 400;
const LOOK: usize = 10;
/// How much it may still grow between two looks.
const GROWTH: f64 = 1e-4;

/// The largest stable step, as a part of that of the smallest cells without metal: 1 where no face is cut.
///
/// # Errors
/// `cancelled`.
pub(super) async fn factor(
    outside: &[Outside; 6],
    lines: &Lines,
    cells: [[u32; 3]; 2],
    control: &Control,
) -> Result<f64> {
    let largest = Scheme::new(outside, lines, cells).largest(control).await?;
    let smallest = lines.smallest();
    let yee = smallest.iter().map(|size| 4.0 / (size * size)).sum::<f64>();
    Ok(if largest > yee * (1.0 + 1e-9) { SPARE * (yee / largest).sqrt() } else { 1.0 })
}

/// Sizes of the cells of a window along each axis, with one more at both ends: that of the neighbour, or, at an end of the box, the same again.
fn sizes(lines: &Lines, [first, end]: [[u32; 3]; 2]) -> [Vec<f64>; 3] {
    let dims = lines.dims();
    [0, 1, 2].map(|axis: usize| {
        let size = |cell: u32| lines.cell_size(axis, cell.min(dims[axis] - 1));
        let before = size(first[axis].saturating_sub(1));
        [before].into_iter().chain((first[axis]..=end[axis]).map(size)).collect()
    })
}

/// G of the faces of cut cells: a row a face, with four edges.
struct Scheme {
    edges: Vec<[u32; 4]>,
    scales: Vec<[f64; 4]>,
    n_edges: usize,
}

impl Scheme {
    fn new(outside: &[Outside; 6], lines: &Lines, [first, end]: [[u32; 3]; 2]) -> Scheme {
        let cells = [0, 1, 2].map(|axis| end[axis] - first[axis]);
        let sizes = sizes(lines, [first, end]);
        let size = |axis: usize, cell: u32| sizes[axis][cell as usize + 1];
        // between the centres before and behind a line
        let between = |axis: usize, line: u32| 0.5 * (sizes[axis][line as usize] + sizes[axis][line as usize + 1]);
        let grids: [Grid; 3] = std::array::from_fn(|along| Grid::of_part(cells, along));
        let (mut keys, mut scales) = (Vec::new(), Vec::new());
        for axis in 0..3 {
            let grid = Grid::of_part(cells, 3 + axis);
            for &(face, area) in outside[3 + axis].all().iter().filter(|(_, area)| *area > 0.0) {
                let place = grid.place(face);
                let [one, other] = [(axis + 1) % 3, (axis + 2) % 3];
                let of_face = between(axis, place[axis]) / (area * size(one, place[one]) * size(other, place[other]));
                let mut row = [0.0; 4];
                let edges = edges_of_face(axis, place);
                for (at, (along, edge)) in edges.into_iter().enumerate() {
                    let index = grids[along].index(edge);
                    let length = outside[along].get(index).unwrap_or(1.0) * size(along, edge[along]);
                    let [p, q] = [(along + 1) % 3, (along + 2) % 3];
                    let scale = (of_face * length / (between(p, edge[p]) * between(q, edge[q]))).sqrt();
                    // around the face
                    row[at] = if at == 0 || at == 3 { scale } else { -scale };
                    keys.push((along as u64) << 62 | index);
                }
                scales.push(row);
            }
        }
        let mut all = keys.clone();
        sort(&mut all);
        all.dedup();
        let number = |key: &u64| all.binary_search(key).unwrap_or(0) as u32;
        let edges = keys.chunks_exact(4).map(|four| [0, 1, 2, 3].map(|at: usize| number(&four[at]))).collect();
        Scheme { edges, scales, n_edges: all.len() }
    }

    /// The largest eigenvalue.
    async fn largest(&self, control: &Control) -> Result<f64> {
        let mut fields = (0..self.edges.len() as u64).map(spread).collect::<Vec<f64>>();
        let mut before = vec![0.0; fields.len()];
        if !scaled(&mut fields) {
            return Ok(0.0);
        }
        let (mut diagonal, mut beside, mut last) = (Vec::new(), Vec::new(), 0.0);
        let (mut of_edges, mut found) = (vec![0.0; self.n_edges], 0.0);
        for iteration in 1..=MOST {
            control.rest().await?;
            self.spread_to_edges(&fields, &mut of_edges);
            let mut next: Vec<f64> = self.edges.iter().zip(&self.scales).map(|row| gathered(row, &of_edges)).collect();
            let own = dot(&next, &fields);
            for ((next, field), before) in next.iter_mut().zip(&fields).zip(&before) {
                *next -= own * field + last * before;
            }
            diagonal.push(own);
            last = dot(&next, &next).sqrt();
            let is_done = last <= 1e-12 * own.abs();
            if is_done || iteration % LOOK == 0 {
                let estimate = largest_of(&diagonal, &beside);
                if is_done || estimate <= found * (1.0 + GROWTH) {
                    return Ok(estimate);
                }
                found = estimate;
            }
            beside.push(last);
            next.iter_mut().for_each(|next| *next /= last);
            before = std::mem::replace(&mut fields, next);
        }
        Ok(found)
    }

    fn spread_to_edges(&self, fields: &[f64], of_edges: &mut [f64]) {
        of_edges.fill(0.0);
        for ((edges, scales), field) in self.edges.iter().zip(&self.scales).zip(fields) {
            edges.iter().zip(scales).for_each(|(&edge, scale)| of_edges[edge as usize] += scale * field);
        }
    }
}

fn gathered((edges, scales): (&[u32; 4], &[f64; 4]), of_edges: &[f64]) -> f64 {
    edges.iter().zip(scales).map(|(&edge, scale)| scale * of_edges[edge as usize]).sum()
}

fn dot(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(one, other)| one * other).sum()
}

/// Gives it the length 1; false where it is 0.
fn scaled(fields: &mut [f64]) -> bool {
    let length = dot(fields, fields).sqrt();
    fields.iter_mut().for_each(|field| *field /= length);
    length > 0.0
}

/// A number from -1 to 1 for each number, as if by chance: SplitMix64.
fn spread(number: u64) -> f64 {
    let mut bits = number.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    bits = (bits ^ bits >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    bits = (bits ^ bits >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((bits ^ bits >> 31) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// The largest eigenvalue of a symmetric matrix of three diagonals, by bisection: of smaller numbers fewer eigenvalues are below (Sturm).
fn largest_of(diagonal: &[f64], beside: &[f64]) -> f64 {
    let radius = |at: usize| {
        let before = if at > 0 { beside[at - 1].abs() } else { 0.0 };
        before + if at + 1 < diagonal.len() { beside[at].abs() } else { 0.0 }
    };
    let mut high = diagonal.iter().enumerate().map(|(at, own)| own + radius(at)).fold(f64::MIN, f64::max);
    let mut low = diagonal.iter().copied().fold(f64::MIN, f64::max);
    let all_are_below = |bound: f64| {
        let mut pivot = 1.0;
        diagonal.iter().enumerate().all(|(at, own)| {
            let square = if at > 0 { beside[at - 1] * beside[at - 1] } else { 0.0 };
            pivot = own - bound - square / pivot;
            pivot < 0.0
        })
    };
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        *(if all_are_below(middle) { &mut high } else { &mut low }) = middle;
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_eigenvalue_is_found() {
        // of the second difference on n places: 2 - 2 cos(n pi / (n + 1))
        for n in [1usize, 2, 7, 40] {
            let (diagonal, beside) = (vec![2.0; n], vec![-1.0; n - 1]);
            let expected = 2.0 - 2.0 * (std::f64::consts::PI * n as f64 / (n as f64 + 1.0)).cos();
            let found = largest_of(&diagonal, &beside);
            assert!((found - expected).abs() < 1e-12, "{n}: {found}, not {expected}");
        }
    }
}
