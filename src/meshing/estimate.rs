//! The estimate: what a mesh would cost, before a ray is cast.
//!
//! Geometries, lines, rays -> [`Estimate`]. A ray crosses a facet where it passes through the facet's projection. Over all
//! offsets of the rays the expected number of crossings of a facet is the area of its projection, in cells across, so the
//! sum over all facets, clipped to the rectangle of the rays, is the expected number of crossings of the mesh. Crossings
//! below and beyond the domain along the rays count, as they do in the mesh.
//!
//! Bytes follow from rays, runs and cells. A run is taken to begin at every crossing before the end of its ray: too many where
//! geometries overlap, lie beside the domain, or have parts thinner than a cell.
//! Weakness: the sizes of compressed files are rules of thumb, right within a factor of three for curved surfaces; flat ones
//! compress better. Sizes marked exact are exact.
//! Cost: one pass over the corners.

use serde::Serialize;

use hexcast_core::base::control::{Control, at_once};
use hexcast_core::base::error::Result;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::lines::{Grading, Lines};
use hexcast_core::grid::rays::Rays;
use hexcast_core::input::geometry::{Geometry, SharedFacets};
use hexcast_core::stages::cast::sizes::MOST_BAND;
use hexcast_core::stages::cpu;
use hexcast_core::stages::expected_crossings::{Sums, expected, expected_of_frame};
use hexcast_derived::mesh::SLAB_BYTES;
use hexcast_files::write::{npy, raw};

mod device;
mod memory_limits;
mod plan;
mod work;

pub use memory_limits::{Allowed, Device};
#[doc(hidden)]
pub use plan::BandLimit;
pub(crate) use plan::MemoryBudget;
pub use plan::{block_cache_bytes, slab_bytes};

/// What a mesh would hold and take.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Estimate {
    /// Number of cells on x, y, z.
    pub dims: [u32; 3],
    /// First corner of the box.
    pub origin: [f64; 3],
    /// Cell size on x, y, z; null where cells differ in size.
    pub spacing: Option<[f64; 3]>,
    /// The lines and how their distances change; null where all cells are equal.
    pub grading: Option<Grading>,
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
    /// Most bytes of memory that meshing and writing takes at once; the GPU's, if that needs more.
    pub host_bytes: u64,
    /// What they are made of.
    pub host: HostBytes,
    /// Bytes of GPU buffers at most, if the GPU meshes.
    pub device_bytes: u64,
    /// Bytes of the files.
    pub file_bytes: FileBytes,
    /// Expected number of runs.
    #[serde(skip)]
    runs: u64,
    /// Expected number of (facet, bin) pairs on the GPU.
    #[serde(skip)]
    pairs: u64,
    /// Expected number of facets on the GPU.
    #[serde(skip)]
    box_facets: u64,
    /// Rays along both axes across, and ray rows of a strip of the CPU backend.
    #[serde(skip)]
    shape: [u32; 3],
}

/// Bytes of memory on the host.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct HostBytes {
    /// Facets as read and as snapped; gone when the mesh is made.
    pub facets: u64,
    /// The lattice of the CPU backend.
    pub lattice: u64,
    /// Facets of bands on their way to the GPU.
    pub upload: u64,
    /// Columns, packed.
    pub columns: u64,
    /// Columns as the CPU backend makes them, on top of the packed ones: those of one round.
    pub round: u64,
    /// The largest band as the GPU brings it, on top of the packed ones.
    pub band: u64,
    /// Flags being written.
    pub slabs: u64,
}

impl HostBytes {
    /// Most bytes held at once by meshing, if all columns stay in memory.
    pub fn meshing(&self, on_gpu: bool) -> u64 {
        self.columns + self.facets + if on_gpu { self.upload + self.band } else { self.lattice + self.round }
    }
}

/// Bytes of a mesh in each format; those of 2^64 and more read as 2^64 - 1.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct FileBytes {
    /// `.raw`, a byte a cell; exact.
    pub raw: u64,
    /// `.raw`, a bit a cell; exact.
    pub raw_bits: u64,
    /// `.npy`, a byte a cell; exact.
    pub npy: u64,
    /// `.npy`, a bit a cell; exact.
    pub npy_bits: u64,
    /// `.vti` without compression, of cells that differ in size `.vtr`; the head is estimated.
    pub vti: u64,
    /// The same, zlib.
    pub vti_zlib: u64,
    /// Column file without compression.
    pub hxc: u64,
    /// Column file, zlib.
    pub hxc_zlib: u64,
}

impl Estimate {
    /// Estimates the mesh of geometries on lines by rays.
    pub fn new(geometries: &[Geometry], lines: &Lines, rays: &Rays) -> Estimate {
        // nothing cancels it
        let expected = at_once(expected(geometries, lines, rays, &Control::default())).unwrap_or_default();
        Estimate::of(&expected, geometries, lines, rays)
    }

    /// The same with rests.
    ///
    /// # Errors
    /// `cancelled`.
    pub async fn with_rests(
        geometries: &[Geometry],
        lines: &Lines,
        rays: &Rays,
        control: &Control,
    ) -> Result<Estimate> {
        Ok(Estimate::of(&expected(geometries, lines, rays, control).await?, geometries, lines, rays))
    }

    /// Says what the unit of lengths is, which the Courant step in seconds needs.
    pub fn with_unit(self, unit: Option<&str>) -> Estimate {
        Estimate { grading: self.grading.map(|grading| grading.with_unit(unit)), ..self }
    }

    /// The same of equal cells, from the snapped facets that the rays may hit.
    pub(crate) fn of_frame(frame: &Frame, geometries: &[Geometry], lines: &Lines, rays: &Rays) -> Estimate {
        let mut estimate = Estimate::of(&expected_of_frame(frame, rays), geometries, lines, rays);
        estimate.host.facets = bytes_as_read(geometries) + SNAPPED_BYTES * frame.facets.len() as u64;
        estimate
    }

    fn of(expected: &Sums, geometries: &[Geometry], lines: &Lines, rays: &Rays) -> Estimate {
        let facets: u64 = geometries.iter().map(|geometry| geometry.facets.len() as u64).sum();
        let crossings = expected.crossings.round() as u64;
        let host = host_bytes(facet_bytes(geometries, expected), expected, lines, rays);
        let mut estimate = Estimate {
            dims: lines.dims(),
            origin: lines.origin(),
            spacing: lines.spacing(),
            grading: Grading::of(lines, None),
            cells: lines.n_cells(),
            ray_axis: ["x", "y", "z"][rays.axis],
            rays: rays.n_rays(),
            facets,
            crossings,
            column_bytes: host.columns,
            host_bytes: 0,
            host,
            device_bytes: 0,
            file_bytes: file_bytes(lines, rays.n_rays(), expected.runs as u64),
            runs: expected.runs as u64,
            pairs: expected.bin_facets as u64,
            box_facets: expected.facets as u64,
            shape: [rays.counts[0], rays.counts[1], cpu::rows_of_strip(rays)],
        };
        estimate.device_bytes = estimate.device_bytes_of(estimate.rows());
        estimate.host.upload = estimate.upload_bytes_of(estimate.rows());
        let host = estimate.host;
        let snapping = host.facets + bytes_of_snap(geometries);
        estimate.host_bytes = host.meshing(false).max(host.meshing(true)).max(host.columns + host.slabs).max(snapping);
        estimate
    }

    /// Rays of a ray row.
    fn rays_across(&self) -> u64 {
        self.shape[0].into()
    }

    /// Ray rows.
    fn rows(&self) -> u64 {
        self.shape[1].into()
    }

    /// Ray rows of a strip of the CPU backend.
    fn strip_rows(&self) -> u64 {
        self.shape[2].into()
    }

    /// Rays of a strip of the CPU backend.
    fn strip_rays(&self) -> u64 {
        self.strip_rows() * self.rays_across()
    }
}

/// Bytes of a snapped facet.
const SNAPPED_BYTES: u64 = 38;
/// Bytes of the hashes of the edges of a facet that stays in its file, while those of its geometry are compared. Others have room by then: when
/// they have been snapped the columns are made.
const EDGE_BYTES: u64 = 12;

/// Bytes of facets as they were read.
fn bytes_as_read(geometries: &[Geometry]) -> u64 {
    geometries.iter().map(|geometry| geometry.facets.n_bytes()).sum()
}

/// Bytes of facets, as read and snapped; of those that stay in a file, the ones with a ray under their boxes are held.
fn facet_bytes(geometries: &[Geometry], expected: &Sums) -> u64 {
    let n: usize = geometries.iter().map(|geometry| geometry.facets.len()).sum();
    let n = if geometries.iter().any(|geometry| geometry.facets.stay_in_file()) {
        (expected.facets as u64).min(n as u64)
    } else {
        n as u64
    };
    let of_chunk = geometries.iter().map(|geometry| geometry.facets.chunk_bytes()).max().unwrap_or(0);
    bytes_as_read(geometries) + of_chunk + SNAPPED_BYTES * n
}

/// Bytes that facets which stay in their files take for a moment.
fn bytes_of_snap(geometries: &[Geometry]) -> u64 {
    let in_files = geometries.iter().map(|geometry| &geometry.facets).filter(|facets| facets.stay_in_file());
    EDGE_BYTES * in_files.map(SharedFacets::len).max().unwrap_or(0) as u64
}

fn host_bytes(facet_bytes: u64, expected: &Sums, lines: &Lines, rays: &Rays) -> HostBytes {
    let (n_rays, runs) = (rays.n_rays(), expected.runs);
    // a byte a ray and four bytes every 64 rays; four bytes a ray until they are packed
    let index = n_rays + n_rays.div_ceil(64) * 4;
    let columns = index + 4 * runs as u64;
    let round_rays = (u64::from(cpu::STRIPS_PER_ROUND) * u64::from(cpu::rows_of_strip(rays)))
        .saturating_mul(u64::from(rays.counts[0]))
        .min(n_rays);
    let strips = u64::from(rays.counts[1].div_ceil(cpu::rows_of_strip(rays)));
    // the last round is unpacked, after the packed columns before it
    let extra = |rays: u64| ((4 * n_rays - index.min(4 * n_rays)) as f64 * (rays as f64 / n_rays as f64)) as u64;
    HostBytes {
        facets: facet_bytes,
        lattice: 4 * (expected.strip_facets as u64 + strips),
        upload: 0,
        columns,
        round: extra(round_rays),
        band: extra(n_rays.min(MOST_BAND)),
        slabs: 2 * lines.n_cells().min(SLAB_BYTES as u64),
    }
}

/// Bytes of a line in the text of a `.vtr`, about.
const BYTES_OF_LINE: u64 = 18;

fn file_bytes(lines: &Lines, rays: u64, runs: u64) -> FileBytes {
    const VTI_HEAD: u64 = 1000;
    // the lists of lines, as text
    let n_lines: u64 = lines.dims().iter().map(|&n| u64::from(n) + 1).sum();
    let head = VTI_HEAD + if lines.is_graded() { BYTES_OF_LINE * n_lines } else { 0 };
    let bytes = |size: Option<u64>| size.unwrap_or(u64::MAX);
    let raw_bytes = bytes(raw::n_bytes(lines.dims(), false));
    let hxc = 200 + rays + 2 * runs;
    FileBytes {
        raw: raw_bytes,
        raw_bits: bytes(raw::n_bytes(lines.dims(), true)),
        npy: bytes(npy::n_bytes(lines.dims(), false)),
        npy_bits: bytes(npy::n_bytes(lines.dims(), true)),
        vti: raw_bytes.saturating_add(head),
        // measured at level 6: what does not change shrinks two hundredfold, and a run takes some bits where it begins
        vti_zlib: head.saturating_add(raw_bytes / 200).saturating_add(runs / 2),
        hxc,
        hxc_zlib: 200 + hxc / 10,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hexcast_core::input::job::Rule;

    fn fixture(name: &str) -> Geometry {
        let path = format!("{}/tests/fixtures/{name}", env!("CARGO_MANIFEST_DIR"));
        let contents = hexcast_core::input::read::read_bytes(&std::fs::read(path).unwrap()).unwrap();
        Geometry::new(name, 1, contents.solids[0].facets.clone()).unwrap()
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
                    let columns = cpu::columns(
                        &hexcast_core::stages::cast::Cast { frame: &frame, rays: &rays, rule: Rule::Parity },
                        &Control::default(),
                    )
                    .unwrap();
                    let found = Estimate::new(&geometries, &lines, &rays);
                    let what = format!("{name}, part {part}, axis {axis}");
                    assert_within_a_quarter(found.crossings, columns.n_crossings(), &what);
                    if part == 1.0 {
                        assert_within_a_quarter(found.column_bytes, columns.n_bytes(), &what);
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
    fn sizes_that_are_called_exact_follow_the_formats() {
        let lines = Lines::new([0.0; 3], [1.0; 3], [9, 5, 7]).unwrap();
        let found = file_bytes(&lines, 35, 0);
        assert_eq!((found.raw, found.raw_bits, found.npy % 64), (315, 70, 315 % 64));
    }
}
