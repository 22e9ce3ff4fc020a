//! Limits of the memory of a GPU: whatever they are, the cells are those of the CPU, and the device never holds more.

use hexcast::columns::Columns;
use hexcast::control::Control;
use hexcast::estimate::BandLimit;
use hexcast::geometry::{Facet, Geometry};
use hexcast::gpu::{AdapterKind, Forced, Gpu, Options, Usage};
use hexcast::lines::Lines;
use hexcast::pipeline::Engine;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::rays::Rays;
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::cpu;
use hexcast_core::stages::crossings::Crossings;
use hexcast_core::stages::map::Rule;

use super::kernels;
use crate::models;

/// A sphere of 198,024 facets: a hundredth of 2e7.
fn fine_sphere() -> Vec<Facet> {
    models::sphere([0.0; 3], 1.0, 446)
}

/// A box around the unit sphere, with rays along z.
fn lines(n_cells: u32) -> Lines {
    let size = 2.1 / f64::from(n_cells);
    Lines::new([-1.05; 3], [size; 3], [n_cells; 3]).expect("lines")
}

/// A device of its own: what one holds is counted for all its meshes, and other tests use that of the kernel tests.
fn open() -> Gpu {
    pollster::block_on(Gpu::open(Some(&kernels::gpu().facts.name))).expect("it was opened before")
}

struct Fixture {
    frame: Frame,
    rays: Rays,
}

impl Fixture {
    fn new(facets: Vec<Facet>, lines: &Lines) -> Fixture {
        let frame = Frame::new(&[Geometry::new("a", 1, facets).unwrap()], lines).expect("frame");
        Fixture { frame, rays: Rays::new(2, lines.dims()) }
    }

    fn cast(&self) -> Cast<'_> {
        Cast { frame: &self.frame, rays: &self.rays, rule: Rule::Parity }
    }

    /// Meshes under a limit and compares all with the CPU.
    fn mesh(&self, gpu: &Gpu, options: &Options) -> Usage {
        let (cast, control, mut bands) = (self.cast(), Control::default(), Vec::new());
        let usage = pollster::block_on(gpu.continue_columns(&cast, options, &control, &mut bands));
        let usage = usage.unwrap_or_else(|error| panic!("{options:?}: {error}"));
        let expected = cpu::columns(&cast, &control).expect("columns");
        assert!(Columns::new(self.rays, bands).unwrap() == expected, "{options:?}: other columns");
        usage
    }
}

#[test]
fn many_facets_are_meshed_in_a_small_memory() {
    let (gpu, fixture) = (open(), Fixture::new(fine_sphere(), &lines(300)));
    let free = fixture.mesh(&gpu, &Options::default());
    // a five hundredth of 512 MB
    let limit = 1 << 20;
    let usage = fixture.mesh(&gpu, &Options { max_bytes: Some(limit), ..Options::default() });
    assert!(usage.peak_bytes <= limit && free.peak_bytes > limit, "{} and {}", usage.peak_bytes, free.peak_bytes);
    // where even a row of bins has too many facets they come in batches, and none is left to the CPU
    assert!(usage.n_bands > 1 && usage.deep > 0 && usage.left == 0, "{usage:?}");
    // the facets on their way are those of bands
    assert!(usage.host_bytes < free.host_bytes, "{} and {}", usage.host_bytes, free.host_bytes);
}

#[test]
fn bands_that_do_not_fit_the_share_of_one_are_meshed_one_after_the_other() {
    let (gpu, fixture) = (open(), Fixture::new(models::sphere([0.0; 3], 1.0, 48), &lines(300)));
    // a row of bins each
    let options = Options { rows_per_band: Some(8), ..Options::default() };
    let free = fixture.mesh(&gpu, &options);
    assert!(free.n_bands > 3 && free.deep == 0, "{free:?}");
    // three bands at a time hold more, one holds less
    let limit = free.peak_bytes * 2 / 3;
    let usage = fixture.mesh(&gpu, &Options { max_bytes: Some(limit), ..options });
    assert!(usage.peak_bytes <= limit && usage.deep == 0, "{} of {limit} bytes: {usage:?}", usage.peak_bytes);
}

/// Some plates, one over the other.
fn plates(n: usize) -> Vec<Facet> {
    let heights = (0..n).map(|k| -1.0 + 2.0 * k as f32 / n as f32);
    heights.flat_map(|z| models::cuboid([-1.0, -1.0, z], [1.0, 1.0, z + 0.5 / n as f32])).collect()
}

#[test]
fn rays_with_many_crossings_are_meshed_in_smaller_bands_by_drivers_on_the_processor() {
    let (gpu, fixture) = (open(), Fixture::new(plates(32), &lines(400)));
    let usage = fixture.mesh(&gpu, &Options::default());
    // 64 crossings of most of 160,000 rays are more than the 2^23 of a band
    let n_least = if gpu.facts.kind == AdapterKind::Software { 2 } else { 1 };
    assert!(usage.n_bands >= n_least && usage.deep == 0, "{usage:?}");
    // fewer crossings need no second band
    let few = Fixture::new(plates(4), &lines(400)).mesh(&gpu, &Options::default());
    assert_eq!(few.n_bands, 1, "{few:?}");
}

#[test]
fn no_limit_is_exceeded_and_none_changes_a_cell() {
    let fixtures = [
        Fixture::new(models::sphere([0.0; 3], 1.0, 140), &lines(64)),
        Fixture::new(models::sphere([0.0; 3], 1.0, 48), &lines(300)),
        // crossings close together, for the deep kernels
        Fixture::new(plates(300), &lines(24)),
    ];
    let gpu = open();
    for fixture in &fixtures {
        for limit in [1 << 20, 1 << 22] {
            let options = Options { max_bytes: Some(limit), ..Options::default() };
            let usage = fixture.mesh(&gpu, &options);
            assert!(usage.peak_bytes <= limit, "{} of {limit} bytes: {usage:?}", usage.peak_bytes);
            let forced = Forced { deep: true, ..Forced::default() };
            let usage = fixture.mesh(&gpu, &Options { forced, ..options });
            assert!(usage.peak_bytes <= limit, "{} of {limit} bytes, all rows deep: {usage:?}", usage.peak_bytes);
        }
    }
}

#[test]
fn crossings_keep_to_a_limit_of_the_devices_memory() {
    let fixture = Fixture::new(fine_sphere(), &lines(102));
    let found = |engine: &mut Engine, device_bytes: u64| {
        let mut all = Vec::new();
        let take = &mut |more: Vec<Crossings>| {
            for crossings in more {
                all.extend((0..crossings.offsets.len() - 1).map(|ray| crossings.of_ray(ray)));
            }
        };
        let (control, limits) = (Control::default(), BandLimit { n_rays: u64::MAX, device_bytes });
        let cast = fixture.cast();
        let run = engine.crossings(&cast, true, limits, &control, take);
        let used = pollster::block_on(run).expect("crossings");
        (all, used.device_bytes)
    };
    let (expected, none) = found(&mut Engine::cpu(), u64::MAX);
    assert_eq!(none, 0);
    let mut engine = Engine::with_gpu(open());
    let (whole, free) = found(&mut engine, u64::MAX);
    assert!(whole == expected && free > 1 << 21, "{free}");
    for limit in [1 << 20, 1 << 21] {
        let (crossings, bytes) = found(&mut engine, limit);
        assert!(crossings == expected && bytes > 0 && bytes <= limit, "{bytes} of {limit}");
    }
}
