//! Cells that differ in size have the same flags on the GPU as on the CPU, whatever a job asks for.

use std::sync::Arc;

use hexcast::columns::{Columns, MemoryStore};
use hexcast::control::Control;
use hexcast::estimate::Device;
use hexcast::geometry::Geometry;
use hexcast::gpu::{Forced, Gpu, Options, Usage};
use hexcast::job::{ByteSize, Job, PartJob};
use hexcast::lines::Lines;
use hexcast::pipeline::{Engine, SpillTarget};
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::rays::Rays;
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::cpu;
use hexcast_core::stages::map::Rule;

use super::kernels;
use crate::cases::{Case, cases};
use crate::graded_laws::{bodies, lines_of, long_run, nearly, wishes};
use crate::models;
use crate::open_surfaces::{flags_of, meshed};
use crate::soups::{Random, anywhere, crumbs, soup, thinned};

fn frame_of(case: &Case) -> Frame {
    Frame::new(&case.geometries, &case.lines).unwrap_or_else(|error| panic!("{}: {error}", case.name))
}

fn columns_of(gpu: &Gpu, cast: &Cast, options: &Options) -> (Columns, Usage) {
    let mut bands = Vec::new();
    let usage = pollster::block_on(gpu.continue_columns(cast, options, &Control::default(), &mut bands));
    let usage = usage.unwrap_or_else(|error| panic!("{options:?}: {error}"));
    (Columns::new(*cast.rays, bands).expect("bands in order"), usage)
}

#[test]
fn soups_on_lists_have_the_columns_of_the_cpu() {
    let [mut n_graded, mut n_crossings] = [0u64; 2];
    for seed in 3000..3300 {
        let (mut case, mut random) = (if seed % 10 == 0 { crumbs(seed) } else { soup(seed) }, Random::new(seed));
        case.lines = if seed % 2 == 0 { thinned(&case.lines, &mut random) } else { anywhere(&case.lines, &mut random) };
        let frame = frame_of(&case);
        n_graded += u64::from(frame.is_graded());
        for axis in 0..3 {
            let rays = Rays::new(axis, case.lines.dims());
            let cast = Cast { frame: &frame, rays: &rays, rule: case.rule };
            let expected = cpu::columns(&cast, &Control::default()).expect("nobody cancels");
            let (found, _) = columns_of(kernels::gpu(), &cast, &Options::default());
            assert!(found == expected, "seed {seed}, axis {axis}");
            n_crossings += expected.n_crossings();
        }
    }
    assert!(n_graded > 200 && n_crossings > 10_000, "{n_graded} graded, {n_crossings} crossings");
}

#[test]
fn equal_cells_as_lists_have_the_columns_of_equal_cells() {
    let mut n_cases = 0;
    for case in cases() {
        // where f64 cannot hold the sizes, lists round otherwise
        let is_even = |axis: usize| {
            let list = case.lines.list(axis);
            list.windows(2).all(|two| two[1] - two[0] == case.lines.smallest()[axis])
        };
        if !(0..3).all(is_even) {
            continue;
        }
        let listed = Case { lines: case.lines.as_lists(), ..case.clone() };
        let [of_equal, of_listed] = [&case, &listed].map(frame_of);
        assert!(of_listed.is_graded() && !of_equal.is_graded());
        for axis in 0..3 {
            let rays = Rays::new(axis, case.lines.dims());
            let cast = |frame| Cast { frame, rays: &rays, rule: case.rule };
            let expected = cpu::columns(&cast(&of_equal), &Control::default()).expect("nobody cancels");
            let (found, _) = columns_of(kernels::gpu(), &cast(&of_listed), &Options::default());
            let counts = [&found, &expected].map(|columns| (columns.odd_rays(), columns.n_crossings()));
            assert!(found == expected && counts[0] == counts[1], "{}, axis {axis}", case.name);
        }
        n_cases += 1;
    }
    assert!(n_cases > 60, "{n_cases} cases");
}

fn engine() -> Engine {
    Engine::with_gpu(pollster::block_on(Gpu::open(Some(&kernels::gpu().facts.name))).expect("it was opened before"))
}

#[test]
fn all_that_a_job_may_ask_for_is_the_same_on_the_gpu() {
    let (bodies, mut gpu) = (bodies(), engine());
    let stretched = |job: &Job| {
        let window = job.window.map(|_| [3, 0, 5, 20, 25, 9]);
        set!(Job { lines: Some(lines_of(&bodies)), cell_size: None, domain: None, window, ..job.clone() })
    };
    for (index, (name, job)) in wishes().into_iter().enumerate() {
        for job in [nearly(&job), stretched(&job)] {
            let axis = index % 3;
            let [one, other] = [&mut Engine::cpu(), &mut gpu].map(|engine| meshed(&bodies, &job, axis, engine));
            let ((mesh, facts), (on_gpu, of_gpu)) = (one.expect(name), other.expect(name));
            assert!(on_gpu.lines().is_graded() && of_gpu.backend == "gpu" && of_gpu.adapter.is_some(), "{name}");
            let check = of_gpu.device_check.expect("a GPU meshed");
            assert!(check.rays > 0 && check.differing == 0, "{name}: {check:?}");
            assert!(mesh == on_gpu && flags_of(&mesh) == flags_of(&on_gpu), "{name}, rays along {axis}: flags differ");
            assert_eq!((&facts.flags_hash, facts.crossings), (&of_gpu.flags_hash, of_gpu.crossings), "{name}");
            assert_eq!((&facts.filled, &facts.doubtful), (&of_gpu.filled, &of_gpu.doubtful), "{name}");
            assert_eq!(facts.warnings, of_gpu.warnings, "{name}");
        }
    }
}

#[test]
fn parts_have_the_cells_of_the_cpu() {
    let (bodies, mut gpu) = (bodies(), engine());
    for index in 1..=8 {
        let part = Some(PartJob::new(index, [2, 2, 2]));
        let job = set!(Job { lines: Some(lines_of(&bodies)), part, ..Job::default() });
        let [one, other] = [&mut Engine::cpu(), &mut gpu]
            .map(|engine| meshed(&bodies, &job, index as usize % 3, engine).expect("a part"));
        assert!(one.0 == other.0 && other.1.backend == "gpu", "part {index}");
    }
}

#[test]
fn columns_that_spill_are_those_that_are_kept() {
    let mut gpu = engine();
    let (kept, facts) = long_run(&mut gpu, None, SpillTarget::None, &Control::default()).expect("a mesh");
    let spill = SpillTarget::Temporary(Arc::new(MemoryStore::default()));
    // what a GPU holds counts only where that is the host's memory
    let limit = if gpu.device() == Device::Shared { 9_000_000 } else { facts.peak_bytes.meshing * 3 / 4 };
    let (spilled, of_spilled) = long_run(&mut gpu, Some(ByteSize(limit)), spill, &Control::default()).expect("a mesh");
    let (expected, _) = long_run(&mut Engine::cpu(), None, SpillTarget::None, &Control::default()).expect("a mesh");
    assert!(kept == expected && flags_of(&spilled) == flags_of(&expected) && spilled.columns().is_spilled());
    assert_eq!((facts.backend, of_spilled.backend), ("gpu", "gpu"));
    let peak = of_spilled.peak_bytes;
    assert!(peak.spilled > 0, "{peak:?}");
}

/// Lines that get farther and farther from each other.
fn growing(n: u32, from: f64, to: f64) -> Lines {
    let place = |line: u32| f64::from(line) / f64::from(n);
    let list = || (0..=n).map(|line| from + (to - from) * (0.5 * place(line) + 0.5 * place(line).powi(2))).collect();
    Lines::from_lists([list(), list(), list()]).expect("lines")
}

#[test]
fn no_limit_of_memory_is_exceeded_and_none_changes_a_cell() {
    let gpu = pollster::block_on(Gpu::open(Some(&kernels::gpu().facts.name))).expect("it was opened before");
    for (facets, n) in [(models::sphere([0.0; 3], 1.0, 140), 64), (models::sphere([0.0; 3], 1.0, 48), 300)] {
        let frame = Frame::new(&[Geometry::new("a", 1, facets).unwrap()], &growing(n, -1.1, 1.1)).expect("frame");
        let rays = Rays::new(2, frame.dims);
        let cast = Cast { frame: &frame, rays: &rays, rule: Rule::Parity };
        let expected = cpu::columns(&cast, &Control::default()).expect("nobody cancels");
        let (free, usage) = columns_of(&gpu, &cast, &Options::default());
        assert!(free == expected && usage.left == 0 && usage.checked[0] > 0, "{usage:?}");
        for limit in [1 << 20, 1 << 22] {
            for facets_of_batch in [None, Some(1000)] {
                let forced = Forced { facets_of_batch, ..Forced::default() };
                let options = Options { max_bytes: Some(limit), forced, ..Options::default() };
                let (found, usage) = columns_of(&gpu, &cast, &options);
                assert!(found == expected, "{options:?}");
                assert!(
                    usage.peak_bytes <= limit && usage.left == 0,
                    "{} of {limit} bytes: {usage:?}",
                    usage.peak_bytes
                );
            }
        }
        // what a band turns out not to hold is meshed in smaller ones, down to what the CPU casts
        let (found, usage) = columns_of(&gpu, &cast, &Options { max_bytes: Some(1 << 16), ..Options::default() });
        assert!(found == expected && usage.peak_bytes <= 1 << 16, "{usage:?}");
    }
}
