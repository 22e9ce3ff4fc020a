//! Preview: a surface simplified for drawing.
//!
//! Facets, a number -> at most that many facets. If the surface has no more, these are all of them. Otherwise the space is
//! divided into a grid of boxes: all corners in a box become the first of them, and facets with two corners in one box are
//! left out. While too many facets are left, the boxes are made twice as large.
//!
//! Source: Rossignac and Borrel (1993), *Multi-resolution 3D approximations for rendering complex scenes*. It needs no edges and no second
//! copy of the facets, as other ways to simplify a surface do.
//! Cost: a pass over the facets for each size of boxes, with rests; some 100 bytes per facet that is left.

use crate::base::control::Control;
use crate::base::error::Result;
use crate::input::edges::Vertices;
use crate::input::geometry::Facet;

/// Boxes along the longest side at first: as fine as pictures are.
const BOXES: u32 = 512;
/// Facets between two rests: some tens of milliseconds.
const FACETS_AT_ONCE: usize = 1 << 18;

/// Facets within a box, at most so many. The control is told which share of them this size of boxes has done; it may begin again.
///
/// # Errors
/// `cancelled`.
pub async fn preview(
    facets: &[Facet],
    [low, high]: [[f64; 3]; 2],
    max_facets: usize,
    control: &Control,
) -> Result<Vec<Facet>> {
    if facets.len() <= max_facets {
        return Ok(facets.to_vec());
    }
    let length = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    let mut boxes = Boxes { low, length, n: BOXES };
    let (mut left, mut n_done) = (Vec::new(), 0);
    while n_done < facets.len() {
        let end = facets.len().min(n_done + FACETS_AT_ONCE);
        left.extend(facets[n_done..end].iter().filter(|facet| boxes.keep_apart(facet)));
        n_done = end;
        if left.len() > max_facets {
            boxes.n /= 2;
            n_done = 0;
            left.clear();
        }
        control.rest_at(n_done as f64 / facets.len() as f64).await?;
    }
    boxes.join_corners(&mut left);
    Ok(left)
}

/// The boxes that the space is divided into.
struct Boxes {
    low: [f64; 3],
    /// Length of the longest side, and boxes along it.
    length: f64,
    n: u32,
}

impl Boxes {
    /// Whether all corners of a facet are in different boxes.
    fn keep_apart(&self, facet: &Facet) -> bool {
        let [a, b, c] = facet.map(|corner| self.of(corner));
        a != b && b != c && c != a
    }

    /// Makes all corners in a box the first of them.
    fn join_corners(&self, facets: &mut [Facet]) {
        let numbers = Vertices::of(facets.len(), &|facet, corner| self.of(facets[facet][corner]));
        let mut corner_of_box: Vec<[f32; 3]> = Vec::new();
        for (index, facet) in facets.iter_mut().enumerate() {
            for (corner, number) in facet.iter_mut().zip(numbers.of_facet(index)) {
                // numbers come in order
                if number == corner_of_box.len() {
                    corner_of_box.push(*corner);
                }
                *corner = corner_of_box[number];
            }
        }
    }

    fn of(&self, corner: [f32; 3]) -> [u32; 3] {
        let boxes = f64::from(self.n);
        let at = |axis: usize| boxes * (f64::from(corner[axis]) - self.low[axis]) / self.length;
        // a number beyond the ends, or none at all, becomes one of the ends
        [0, 1, 2].map(|axis| at(axis).min(boxes - 1.0) as u32)
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;
    use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

    use super::*;
    use crate::base::control::at_once;

    /// Two facets for each of n x n squares of a wavy sheet of length 1.
    fn sheet(n: usize) -> Vec<Facet> {
        let corner = |i: usize, j: usize| {
            let [x, y] = [i, j].map(|at| at as f32 / n as f32);
            [x, y, 0.1 * (9.0 * x).sin() * (7.0 * y).cos()]
        };
        let square = |i: usize, j: usize| {
            let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
            [[a, b, c], [a, c, d]]
        };
        (0..n).flat_map(|i| (0..n).flat_map(move |j| square(i, j))).collect()
    }

    fn preview(facets: &[Facet], max_facets: usize) -> Vec<Facet> {
        let n_rests = AtomicUsize::new(0);
        let control = Control::default().on_share(move |share| {
            assert!((0.0..=1.0).contains(&share));
            assert!(n_rests.fetch_add(1, Relaxed) < 1000);
        });
        at_once(super::preview(facets, [[0.0, 0.0, -0.1], [1.0, 1.0, 0.1]], max_facets, &control)).unwrap()
    }

    #[test]
    fn few_facets_stay_as_they_are() {
        let facets = sheet(10);
        assert_eq!(preview(&facets, 200), facets);
    }

    #[test]
    fn of_many_facets_so_many_are_left_that_they_cover_the_surface() {
        let facets = sheet(600);
        let left = preview(&facets, 40_000);
        assert!((5_000..=40_000).contains(&left.len()), "{}", left.len());
        // corners are corners of the surface, and the facets seen from above cover the square but for its rim
        let corners: HashSet<[u32; 3]> = facets.iter().flatten().map(|corner| corner.map(f32::to_bits)).collect();
        assert!(left.iter().flatten().all(|corner| corners.contains(&corner.map(f32::to_bits))));
        let area = |[a, b, c]: &Facet| 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs();
        let covered: f32 = left.iter().map(area).sum();
        assert!((0.9..1.1).contains(&covered), "{covered}");
    }

    #[test]
    fn facets_that_never_become_fewer_by_themselves_are_not_too_many() {
        let mut state = 1u64;
        let mut random = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 40) as f32 / (1 << 24) as f32
        };
        let facets: Vec<Facet> =
            (0..20_000).map(|_| [[(); 3]; 3].map(|corner| corner.map(|()| random() * 0.1))).collect();
        assert!(preview(&facets, 5_000).len() <= 5_000);
        let points = vec![[[0.5; 3]; 3]; 100];
        assert_eq!(preview(&points, 10), Vec::<Facet>::new());
    }
}
