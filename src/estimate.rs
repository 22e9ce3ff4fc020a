//! The estimate: what a mesh would cost, before a ray is cast.
//!
//! Geometries, lines, rays -> [`Estimate`]. A ray crosses a facet where it passes through the facet's projection. Over all
//! offsets of the rays the expected number of crossings of a facet is the area of its projection, in cells across, so the
//! sum over all facets, clipped to the rectangle of the rays, is the expected number of crossings of the mesh. Crossings
//! below and beyond the domain along the rays count, as they do in the mesh.
//!
//! Bytes follow from rays, runs and cells. A run is taken to begin at every crossing: too many where geometries overlap or
//! end with the domain.
//! Weakness: the sizes of compressed files are rules of thumb, good to a factor of three for curved surfaces; flat ones
//! compress better. Those marked exact are exact.
//! Cost: one pass over the corners.

use crate::parallel::*;
use serde::Serialize;

use crate::geometry::{Facet, Geometry};
use crate::lines::Lines;
use crate::rays::Rays;
use crate::write::{npy, raw};

/// What a mesh would hold and take.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Estimate {
    /// Number of cells on x, y, z.
    pub dims: [u32; 3],
    /// First corner of the box.
    pub origin: [f64; 3],
    /// Cell size on x, y, z.
    pub spacing: [f64; 3],
    /// Number of cells.
    pub cells: u64,
    /// Axis of the rays: "x", "y" or "z".
    pub ray_axis: &'static str,
    /// Number of rays.
    pub rays: u64,
    /// Number of facets of all geometries.
    pub facets: u64,
    /// Expected number of crossings of rays and facets.
    pub crossings: u64,
    /// Bytes of the columns in memory.
    pub column_bytes: u64,
    /// Bytes of memory that meshing and writing takes: facets as read and as snapped, columns, slabs.
    pub host_bytes: u64,
    /// Bytes of GPU buffers at most, if the GPU meshes.
    pub device_bytes: u64,
    /// Bytes of the files.
    pub file_bytes: FileBytes,
}

/// Bytes of a mesh in each format; those of 2^64 and more read as 2^64 - 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct FileBytes {
    /// `.raw`, a byte a cell; exact.
    pub raw: u64,
    /// `.raw`, a bit a cell; exact.
    pub raw_bits: u64,
    /// `.npy`, a byte a cell; exact.
    pub npy: u64,
    /// `.npy`, a bit a cell; exact.
    pub npy_bits: u64,
    /// `.vti` without compression; the head is estimated.
    pub vti: u64,
    /// `.vti`, zlib.
    pub vti_zlib: u64,
    /// Column file without compression.
    pub hxc: u64,
    /// Column file, zlib.
    pub hxc_zlib: u64,
}

impl Estimate {
    /// Estimates the mesh of geometries on lines by rays.
    pub fn new(geometries: &[Geometry], lines: &Lines, rays: &Rays) -> Estimate {
        let facets: u64 = geometries.iter().map(|geometry| geometry.facets.len() as u64).sum();
        let crossings = expected_crossings(geometries, lines, rays).round() as u64;
        let column_bytes = 4 * (rays.n_rays() + crossings);
        Estimate {
            dims: lines.dims,
            origin: lines.origin,
            spacing: lines.spacing,
            cells: lines.n_cells(),
            ray_axis: ["x", "y", "z"][rays.axis],
            rays: rays.n_rays(),
            facets,
            crossings,
            column_bytes,
            host_bytes: facets * HOST_FACET_BYTES + column_bytes + 2 * crate::mesh::SLAB_BYTES as u64,
            device_bytes: device_bytes(facets, rays.n_rays()),
            file_bytes: file_bytes(lines, rays.n_rays(), crossings),
        }
    }
}

/// Bytes of a facet: 36 as read, 37 snapped, 40 on their way to the device.
const HOST_FACET_BYTES: u64 = 113;

/// Sum over all facets of the cells across that their projections cover within the rectangle of the rays.
pub fn expected_crossings(geometries: &[Geometry], lines: &Lines, rays: &Rays) -> f64 {
    let mut sum = 0.0;
    for geometry in geometries {
        let project = |corner: [f32; 3]| {
            let world = geometry.world_from_corner(corner);
            rays.across.map(|axis| (world[axis] - lines.origin[axis]) / lines.spacing[axis])
        };
        let area = |facet: &Facet| covered_area(facet.map(project), rays.counts.map(f64::from));
        // blocks of fixed size, so that the number of threads does not change the last bits
        let blocks: Vec<f64> = geometry.facets.par_chunks(4096).map(|block| block.iter().map(area).sum()).collect();
        sum += blocks.iter().sum::<f64>();
    }
    sum
}

/// Area of the part of a triangle inside the rectangle from 0, 0 to `size`.
fn covered_area(triangle: [[f64; 2]; 3], size: [f64; 2]) -> f64 {
    let inside = |point: &[f64; 2]| (0..2).all(|axis| (0.0..=size[axis]).contains(&point[axis]));
    if triangle.iter().all(inside) {
        return polygon_area(&triangle);
    }
    let mut polygon = triangle.to_vec();
    for axis in 0..2 {
        polygon = clip(&polygon, |point| point[axis]);
        polygon = clip(&polygon, |point| size[axis] - point[axis]);
    }
    polygon_area(&polygon)
}

/// The part of a convex polygon where a linear function is not negative (Sutherland and Hodgman 1974).
fn clip(polygon: &[[f64; 2]], height: impl Fn(&[f64; 2]) -> f64) -> Vec<[f64; 2]> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (index, point) in polygon.iter().enumerate() {
        let next = &polygon[(index + 1) % polygon.len()];
        let (here, there) = (height(point), height(next));
        if here >= 0.0 {
            kept.push(*point);
        }
        if (here < 0.0) != (there < 0.0) {
            let t = here / (here - there);
            kept.push([0, 1].map(|axis| point[axis] + t * (next[axis] - point[axis])));
        }
    }
    kept
}

fn polygon_area(polygon: &[[f64; 2]]) -> f64 {
    let Some(first) = polygon.first() else { return 0.0 };
    let from_first = |point: &[f64; 2]| [point[0] - first[0], point[1] - first[1]];
    let doubled: f64 = polygon
        .windows(2)
        .map(|two| (from_first(&two[0]), from_first(&two[1])))
        .map(|(a, b)| a[0] * b[1] - a[1] * b[0])
        .sum();
    0.5 * doubled.abs()
}

/// GPU buffers: the facets, and the rays, (facet, bin) pairs and crossings of the largest band.
fn device_bytes(facets: u64, rays: u64) -> u64 {
    const FACET: u64 = 44;
    const RAY: u64 = 8;
    const PAIR: u64 = 104;
    const EVENT: u64 = 8;
    let first_band = rays.clamp(1, 1 << 18);
    let band = rays.clamp(1, 1 << 22);
    // room is made for 16 pairs a bin of 64 rays and 3 pairs a facet, and grows with the band
    let pairs = (first_band / 4 + 3 * facets) * band.div_ceil(first_band);
    facets * FACET + band * (RAY + 6 * EVENT) + pairs * PAIR
}

fn file_bytes(lines: &Lines, rays: u64, runs: u64) -> FileBytes {
    const VTI_HEAD: u64 = 1000;
    let bytes = |size: Option<u64>| size.unwrap_or(u64::MAX);
    let raw_bytes = bytes(raw::n_bytes(lines.dims, false));
    let hxc = 200 + rays + 2 * runs;
    FileBytes {
        raw: raw_bytes,
        raw_bits: bytes(raw::n_bytes(lines.dims, true)),
        npy: bytes(npy::n_bytes(lines.dims, false)),
        npy_bits: bytes(npy::n_bytes(lines.dims, true)),
        vti: raw_bytes.saturating_add(VTI_HEAD),
        // measured at level 1: what does not change shrinks a hundredfold, and a run takes some bytes where it begins
        vti_zlib: VTI_HEAD.saturating_add(raw_bytes / 100).saturating_add(3 * runs),
        hxc,
        hxc_zlib: 200 + hxc / 4,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Control;
    use crate::cpu;
    use crate::frame::Frame;
    use crate::job::Rule;

    fn fixture(name: &str) -> Geometry {
        let path = format!("{}/tests/fixtures/{name}", env!("CARGO_MANIFEST_DIR"));
        let contents = crate::read::read_bytes(&std::fs::read(path).unwrap()).unwrap();
        Geometry::new(name, 1, contents.solids[0].facets.clone())
    }

    #[test]
    fn estimates_are_within_a_quarter_of_real_meshes() {
        for name in ["spot.stl", "featuretype.stl", "bin_color_magics.stl"] {
            let geometries = [fixture(name)];
            let [low, high] = geometries[0].bounding_box().unwrap();
            let extent = [0, 1, 2].map(|axis| high[axis] - low[axis]);
            let origin = [0, 1, 2].map(|axis| low[axis] - 0.05 * extent[axis]);
            // the whole model with some room, and the part of it in one corner
            for part in [1.0, 0.5] {
                for axis in 0..3 {
                    let dims = [40, 48, 56];
                    let spacing = [0, 1, 2].map(|axis| 1.1 * part * extent[axis] / f64::from(dims[axis]));
                    let lines = Lines::new(origin, spacing, dims).unwrap();
                    let rays = Rays::new(axis, dims);
                    let frame = Frame::new(&geometries, &lines).unwrap();
                    let columns = cpu::columns(&frame, &rays, Rule::Parity, &Control::default()).unwrap();
                    let found = Estimate::new(&geometries, &lines, &rays);
                    let what = format!("{name}, part {part}, axis {axis}");
                    assert_within_a_quarter(found.crossings, columns.n_crossings(), &what);
                    let bytes = 4 * (rays.n_rays() + columns.n_runs());
                    if part == 1.0 {
                        assert_within_a_quarter(found.column_bytes, bytes, &what);
                    }
                }
            }
        }
    }

    #[track_caller]
    fn assert_within_a_quarter(estimate: u64, real: u64, what: &str) {
        let ratio = estimate as f64 / real as f64;
        assert!((0.75..1.25).contains(&ratio), "{what}: {estimate} estimated, {real} real");
    }

    #[test]
    fn areas_are_clipped_to_the_rectangle() {
        let triangle = [[-2.0, -2.0], [6.0, -2.0], [-2.0, 6.0]];
        assert_eq!(covered_area(triangle, [2.0, 2.0]), 4.0);
        assert_eq!(covered_area(triangle, [10.0, 10.0]), 8.0);
        assert_eq!(covered_area([[3.0, 0.0], [4.0, 0.0], [3.0, 1.0]], [2.0, 2.0]), 0.0);
        assert_eq!(covered_area([[0.0, 0.0], [0.0, 2.0], [2.0, 0.0]], [2.0, 2.0]), 2.0);
    }

    #[test]
    fn sizes_that_are_called_exact_follow_the_formats() {
        let lines = Lines::new([0.0; 3], [1.0; 3], [9, 5, 7]).unwrap();
        let found = file_bytes(&lines, 35, 0);
        assert_eq!((found.raw, found.raw_bits, found.npy % 64), (315, 70, 315 % 64));
    }
}
