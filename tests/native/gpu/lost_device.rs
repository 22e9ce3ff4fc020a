//! A device that is lost in the middle of a mesh is opened again, or else the CPU takes over: the mesh continues where it stopped.

use std::sync::{Arc, Mutex};

use hexcast::columns::Columns;
use hexcast::control::Control;
use hexcast::geometry::Geometry;
use hexcast::gpu::Gpu;
use hexcast::lines::Lines;
use hexcast::pipeline::Engine;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::rays::Rays;
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::cpu;
use hexcast_core::stages::map::Rule;

use super::kernels;
use crate::models;

/// What meshing a sphere in many bands came to, on an engine whose device is destroyed after the first: none of its bands can
/// come home any more.
struct Outcome {
    engine: Engine,
    meshed: hexcast::Result<Columns>,
    /// Rays that were done at each progress.
    seen: Vec<u64>,
    rays: Rays,
    expected: Columns,
}

fn mesh_and_destroy(gpu: Gpu, prepare: impl FnOnce(Gpu) -> Engine) -> Outcome {
    let device = gpu.device().clone();
    let mut engine = prepare(gpu);
    let geometries = [Geometry::new("ball", 1, models::sphere([0.0; 3], 1.0, 24)).unwrap()];
    let lines = Lines::new([-1.1; 3], [2.2 / 1024.0, 2.2 / 2048.0, 2.2 / 16.0], [1024, 2048, 16]).expect("lines");
    let frame = Frame::new(&geometries, &lines).expect("frame");
    let rays = Rays::new(2, lines.dims());
    let seen = Arc::new(Mutex::new(Vec::new()));
    let heard = seen.clone();
    let control = Control::with_progress(move |at| {
        let mut seen = heard.lock().expect("no other thread panics");
        if seen.is_empty() {
            device.destroy();
        }
        seen.push(at.rays_done);
    });
    let cast = Cast { frame: &frame, rays: &rays, rule: Rule::Parity };
    let meshed = pollster::block_on(engine.columns(&cast, &control)).map(|(columns, _)| columns);
    let seen = seen.lock().expect("no other thread panics").clone();
    let expected = cpu::columns(&cast, &Control::default()).expect("columns");
    Outcome { engine, meshed, seen, rays, expected }
}

/// Another device of the adapter that the kernel tests use.
fn open(known: &Gpu) -> Gpu {
    pollster::block_on(Gpu::open(Some(&known.facts.name))).expect("it was opened before")
}

/// The same under a name that no adapter has: once lost it cannot be opened again.
fn open_once(known: &Gpu) -> Gpu {
    let mut gpu = open(known);
    gpu.facts.name = "an adapter that is gone".into();
    gpu
}

fn assert_all_rays(Outcome { meshed, seen, rays, expected, .. }: Outcome) {
    assert_eq!(meshed.expect("the device is opened again, or the CPU continues"), expected);
    assert!(seen[0] < rays.n_rays(), "all was done before the device was destroyed");
    assert!(seen.is_sorted_by(|a, b| a < b), "every band is done once, in order: {seen:?}");
    assert_eq!(seen.last(), Some(&rays.n_rays()));
    println!("{} of {} rays were done when the device was destroyed", seen[0], rays.n_rays());
}

#[test]
fn a_destroyed_device_costs_no_ray() {
    let known = kernels::gpu();
    let outcome = mesh_and_destroy(open(known), Engine::with_gpu);
    assert_eq!((outcome.engine.backend(), &outcome.engine.fallback), ("gpu", &None));
    assert_all_rays(outcome);
}

#[test]
fn the_cpu_goes_on_where_no_device_can_be_opened_again() {
    let known = kernels::gpu();
    let outcome = mesh_and_destroy(open_once(known), |gpu| Engine::with_gpu(gpu).with_cpu_fallback());
    assert_eq!(outcome.engine.backend(), "cpu");
    let why = outcome.engine.fallback.clone().expect("there is a reason");
    assert!(why.contains("was lost") && why.contains("opening it again") && why.contains("is gone"), "{why}");
    assert_all_rays(outcome);
}

#[test]
fn a_device_lost_for_good_is_an_error_where_the_gpu_was_asked_for() {
    let known = kernels::gpu();
    let Outcome { mut engine, meshed, .. } = mesh_and_destroy(open_once(known), Engine::with_gpu);
    let error = meshed.expect_err("there is no other");
    assert_eq!((error.code(), engine.backend()), ("device-lost", "gpu"));
    assert!(error.to_string().contains("is gone") && error.hint().contains("CPU"), "{error}: {}", error.hint());
    // the engine is still there, and says the same again
    let (frame, lines) = small();
    let rays = Rays::new(2, lines.dims());
    let cast = Cast { frame: &frame, rays: &rays, rule: Rule::Parity };
    let again = pollster::block_on(engine.columns(&cast, &Control::default()));
    assert_eq!(again.expect_err("it is still lost").code(), "device-lost");
}

fn small() -> (Frame, Lines) {
    let lines = Lines::new([-1.1; 3], [0.1; 3], [22; 3]).expect("lines");
    let geometries = [Geometry::new("ball", 1, models::sphere([0.0; 3], 1.0, 8)).unwrap()];
    (Frame::new(&geometries, &lines).expect("frame"), lines)
}
