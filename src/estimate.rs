//! The estimate: what a mesh would cost, before a ray is cast.
//!
//! Geometries, lines, rays -> [`Estimate`]. A ray crosses a facet where it passes through the facet's projection. Over all
//! offsets of the rays the expected number of crossings of a facet is the area of its projection, in cells across, so the
//! sum over all facets, clipped to the rectangle of the rays, is the expected number of crossings of the mesh. Crossings
//! below and beyond the domain along the rays count, as they do in the mesh.
//!
//! Bytes follow from rays, runs and cells. A run is taken to begin at every crossing before the end of its ray: too many where
//! geometries overlap, lie beside the domain, or have parts thinner than a cell.
//! Weakness: the sizes of compressed files are rules of thumb, good to a factor of three for curved surfaces; flat ones
//! compress better. Those marked exact are exact.
//! Cost: one pass over the corners.

use serde::Serialize;

use crate::cpu;
use crate::error::{Error, MORE_MEMORY, Result};
use crate::geometry::Geometry;
use crate::job::ByteSize;
use crate::lines::Lines;
use crate::mesh::SLAB_BYTES;
use crate::rays::Rays;
use crate::write::{npy, raw};

mod expected;

use expected::Expected;

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
    /// Most bytes of memory that meshing and writing takes at once; the GPU's, if that needs more.
    pub host_bytes: u64,
    /// What they are made of.
    pub host: HostBytes,
    /// Bytes of GPU buffers at most, if the GPU meshes.
    pub device_bytes: u64,
    /// Bytes of the files.
    pub file_bytes: FileBytes,
}

/// Bytes of memory on the host.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct HostBytes {
    /// Facets as read and as snapped; gone when the mesh is made.
    pub facets: u64,
    /// The lattice of the CPU backend.
    pub lattice: u64,
    /// Facets on their way to the GPU.
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
    /// Bytes besides the columns while they are made; the GPU brings them in bands of at most `band_bytes`.
    pub fn working(&self, on_gpu: bool, band_bytes: u64) -> u64 {
        self.facets + if on_gpu { self.upload + self.band.min(band_bytes) } else { self.lattice + self.round }
    }

    /// Most bytes held at once by meshing, if all columns stay in memory.
    pub fn meshing(&self, on_gpu: bool) -> u64 {
        self.columns + self.working(on_gpu, u64::MAX)
    }
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
        let expected = Expected::new(geometries, lines, rays);
        let crossings = expected.crossings.round() as u64;
        let host = host_bytes(facets, &expected, lines, rays);
        Estimate {
            dims: lines.dims,
            origin: lines.origin,
            spacing: lines.spacing,
            cells: lines.n_cells(),
            ray_axis: ["x", "y", "z"][rays.axis],
            rays: rays.n_rays(),
            facets,
            crossings,
            column_bytes: host.columns,
            host_bytes: host.meshing(false).max(host.meshing(true)).max(host.columns + host.slabs),
            host,
            device_bytes: device_bytes(facets, rays),
            file_bytes: file_bytes(lines, rays.n_rays(), expected.runs as u64),
        }
    }

    /// Refuses a mesh that takes more memory than allowed.
    ///
    /// # Errors
    /// `memory`, with the numbers.
    pub fn check(&self, allowed: &Allowed) -> Result<()> {
        let Allowed { max_bytes, on_gpu, can_spill, flags } = *allowed;
        let flags = if flags { self.cells } else { 0 };
        let columns = if can_spill { 0 } else { self.host.columns };
        let meshing = self.host.working(on_gpu, band_bytes(max_bytes)) + columns;
        let needed = meshing.max((columns + flags).saturating_add(2 * slab_bytes(max_bytes)));
        if needed <= max_bytes {
            return Ok(());
        }
        let flags_text = if flags > 0 { format!(", flags in memory {}", ByteSize(flags)) } else { String::new() };
        let message = format!(
            "the mesh takes about {} of memory (columns {}, facets {}{flags_text}); {} are allowed",
            ByteSize(needed),
            ByteSize(self.host.columns),
            ByteSize(self.host.facets),
            ByteSize(max_bytes),
        );
        let hint = match (flags > 0, can_spill) {
            (true, _) => "leave out --flags-in-memory: files are written without it; or allow more with --max-memory",
            (_, false) => MORE_MEMORY,
            (_, true) => "allow more with max_memory (--max-memory), or mesh fewer facets",
        };
        Err(Error::new("memory", message, hint))
    }
}

/// What a mesh may take.
#[derive(Debug, Clone, Copy)]
pub struct Allowed {
    /// Most bytes of memory.
    pub max_bytes: u64,
    /// Whether the GPU meshes.
    pub on_gpu: bool,
    /// Whether columns may go elsewhere.
    pub can_spill: bool,
    /// Whether all flags will be held in memory.
    pub flags: bool,
}

/// Bytes of flags to write at a time within a budget: two of these slabs are held, beside the columns.
pub fn slab_bytes(max_bytes: u64) -> u64 {
    (max_bytes / 16).clamp(1 << 16, SLAB_BYTES as u64)
}

/// Bytes of columns that the GPU may bring home, within a budget, before they are packed.
pub fn band_bytes(max_bytes: u64) -> u64 {
    max_bytes / 8
}

/// Bytes of a facet: 36 as read, 37 snapped.
const FACET_BYTES: u64 = 73;
/// Bytes of a facet on its way to the device.
pub const UPLOAD_FACET_BYTES: u64 = 48;

fn host_bytes(facets: u64, expected: &Expected, lines: &Lines, rays: &Rays) -> HostBytes {
    let (n_rays, runs) = (rays.n_rays(), expected.runs);
    // a byte a ray and four bytes every 64 rays; four bytes a ray until they are packed
    let index = n_rays + n_rays.div_ceil(64) * 4;
    let columns = index + 4 * runs as u64;
    let round_rays = (u64::from(cpu::STRIPS_PER_ROUND) * u64::from(cpu::rows_of_strip(rays)))
        .saturating_mul(u64::from(rays.counts[0]))
        .min(n_rays);
    let strips = u64::from(rays.counts[1].div_ceil(cpu::rows_of_strip(rays)));
    // the last round stands unpacked behind the columns before it
    let extra = |rays: u64| ((4 * n_rays - index.min(4 * n_rays)) as f64 * (rays as f64 / n_rays as f64)) as u64;
    HostBytes {
        facets: facets * FACET_BYTES,
        lattice: 4 * (expected.strip_facets as u64 + strips),
        upload: facets * UPLOAD_FACET_BYTES,
        columns,
        round: extra(round_rays),
        band: extra(n_rays.min(MOST_BAND)),
        slabs: 2 * lines.n_cells().min(SLAB_BYTES as u64),
    }
}

/// GPU buffers: the facets, and the rays, (facet, bin) pairs and crossings of the bands in flight.
///
/// Up to [`FIRST_BAND`] rays a mesh is one band, and the bytes follow; beyond that bands grow with the speed of the device,
/// and this is the most they grow to.
fn device_bytes(facets: u64, rays: &Rays) -> u64 {
    const FACET: u64 = 52;
    const BIN: u64 = 72;
    const PAIR: u64 = 40;
    const EVENT: u64 = 4;
    let [n_i, n_j] = rays.counts.map(u64::from);
    let whole_bins = |rows: u64| (rows / 8 * 8).max(8).min(n_j);
    let first_rows = whole_bins(FIRST_BAND / n_i);
    let first_rays = first_rows * n_i;
    let bins = n_i.div_ceil(8) * first_rows.div_ceil(8);
    // room is made for 16 pairs a bin and 3 pairs a facet, and for 8 runs a ray
    let first = bins * BIN + first_rays * 8 * EVENT + (16 * bins + 3 * facets) * PAIR;
    if first_rows == n_j {
        return facets * FACET + first;
    }
    // the buffers grow with the band; three are in flight
    let most_rows = whole_bins(MOST_BAND / n_i).min(n_j.div_ceil(2));
    3 * (facets * FACET + first.saturating_mul(most_rows.div_ceil(first_rows)))
}

/// Rays of the first band on the GPU, before anything is known about the device's speed: fewer where a page waits.
pub(crate) const FIRST_BAND: u64 = if cfg!(target_arch = "wasm32") { 1 << 18 } else { 1 << 20 };
/// Most rays of a band on the GPU.
pub(crate) const MOST_BAND: u64 = 1 << 22;

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
