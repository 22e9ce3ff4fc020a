//! What a mesh would cost, before it is made.
//!
//! Geometries, mesh lines, rays -> [`Estimate`]. Cells and rays are exact. Crossings are expected: a facet whose projection
//! across the rays has the area A is crossed by A / (area of a cell) rays on average, whatever its shape; of a facet that
//! reaches past the domain the share of its box inside counts. Cost: O(facets).

use crate::parallel::*;
use serde::Serialize;

use crate::geometry::Geometry;
use crate::lines::Lines;
use crate::rays::Rays;

/// What a mesh would cost.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimate {
    /// Number of cells on x, y, z.
    pub dims: [u32; 3],
    /// First corner of the box.
    pub origin: [f64; 3],
    /// Cell size on x, y, z.
    pub spacing: [f64; 3],
    /// Number of cells.
    pub cells: u64,
    /// Number of rays.
    pub rays: u64,
    /// Expected number of crossings.
    pub crossings: f64,
    /// Expected bytes of the columns in memory: 4 a ray and 4 a run.
    pub columns_bytes: f64,
    /// Bytes of all flags, one a cell: a file's, never memory's.
    pub flags_bytes: u64,
}

/// Estimates a mesh.
pub fn estimate(geometries: &[Geometry], lines: &Lines, rays: &Rays) -> Estimate {
    let crossings = geometries.iter().map(|geometry| expected_crossings(geometry, lines, rays)).sum();
    Estimate {
        dims: lines.dims,
        origin: lines.origin,
        spacing: lines.spacing,
        cells: lines.n_cells(),
        rays: rays.n_rays(),
        crossings,
        columns_bytes: 4.0 * (crossings + rays.n_rays() as f64),
        flags_bytes: lines.n_cells(),
    }
}

/// Expected number of crossings of one geometry.
fn expected_crossings(geometry: &Geometry, lines: &Lines, rays: &Rays) -> f64 {
    let cell = |corner: [f32; 3]| {
        let world = geometry.world_from_corner(corner);
        rays.across.map(|axis| (world[axis] - lines.origin[axis]) / lines.spacing[axis])
    };
    let crossings = |facet: &[[f32; 3]; 3]| {
        let [a, b, c] = facet.map(cell);
        let area = ((b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1])).abs() / 2.0;
        let inside = [0, 1].map(|axis| {
            let (low, high) = (a[axis].min(b[axis]).min(c[axis]), a[axis].max(b[axis]).max(c[axis]));
            share_inside(low, high, f64::from(rays.counts[axis]))
        });
        area * inside[0] * inside[1]
    };
    geometry.facets.par_iter().map(crossings).sum()
}

/// Share of the interval that lies within 0 .. n.
fn share_inside(low: f64, high: f64, n: f64) -> f64 {
    if high <= low { 0.0 } else { ((high.min(n) - low.max(0.0)) / (high - low)).max(0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Control;
    use crate::cpu;
    use crate::frame::Frame;
    use crate::job::Rule;

    /// A sphere-like body of many facets.
    fn ball(centre: [f32; 3], radius: f32) -> Geometry {
        let n = 24u32;
        let point = |i: u32, j: u32| {
            let (theta, phi) =
                (std::f32::consts::PI * j as f32 / n as f32, std::f32::consts::TAU * (i % n) as f32 / n as f32);
            let direction = [theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos()];
            [0, 1, 2].map(|axis| centre[axis] + radius * direction[axis])
        };
        let quads = (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
        let facets = quads.flat_map(|(i, j)| {
            let [a, b, c, d] = [point(i, j), point(i, j + 1), point(i + 1, j + 1), point(i + 1, j)];
            [[a, b, c], [a, c, d]]
        });
        Geometry::new("ball", 1, facets.collect())
    }

    #[test]
    fn crossings_and_bytes_are_within_a_few_percent() {
        let lines = Lines::new([0.0; 3], [0.1, 0.2, 0.1], [100, 50, 100]).unwrap();
        for (centre, radius) in [([5.0, 5.0, 5.0], 4.0), ([0.0, 5.0, 5.0], 4.0)] {
            let geometries = [ball(centre, radius)];
            let frame = Frame::new(&geometries, &lines).unwrap();
            for axis in 0..3 {
                let rays = Rays::new(axis, lines.dims);
                let expected = estimate(&geometries, &lines, &rays);
                let columns = cpu::columns(&frame, &rays, Rule::Parity, &Control::default()).unwrap();
                let ratio = expected.crossings / columns.n_crossings() as f64;
                assert!((0.9..1.1).contains(&ratio), "{centre:?} along {axis}: crossings off by {ratio}");
                let ratio = expected.columns_bytes / (4 * (columns.n_runs() + rays.n_rays())) as f64;
                assert!((0.8..1.25).contains(&ratio), "{centre:?} along {axis}: bytes off by {ratio}");
            }
        }
    }

    #[test]
    fn a_geometry_outside_costs_nothing() {
        let lines = Lines::new([0.0; 3], [1.0; 3], [10; 3]).unwrap();
        let rays = Rays::new(2, lines.dims);
        assert_eq!(estimate(&[ball([50.0; 3], 4.0)], &lines, &rays).crossings, 0.0);
    }
}
