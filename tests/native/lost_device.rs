//! A device that is lost in the middle of a mesh is opened again, and the mesh goes on where it stopped.

use std::sync::{Arc, Mutex};

use hexcast::control::Control;
use hexcast::cpu;
use hexcast::frame::Frame;
use hexcast::geometry::Geometry;
use hexcast::gpu::Gpu;
use hexcast::lines::Lines;
use hexcast::map::Rule;
use hexcast::pipeline::Engine;
use hexcast::rays::Rays;

use super::kernels;
use super::models;

/// Meshes a sphere in many bands and destroys the device after the first: none of its bands can come home any more.
#[test]
fn a_destroyed_device_costs_no_ray() {
    let Some(known) = kernels::gpu() else { return };
    let gpu = pollster::block_on(Gpu::open(Some(&known.facts.name))).expect("it was opened before");
    let device = gpu.device().clone();
    let mut engine = Engine::with_gpu(gpu);

    let geometries = [Geometry::new("ball", 1, models::sphere([0.0; 3], 1.0, 24))];
    let lines = Lines::new([-1.1; 3], [2.2 / 1024.0, 2.2 / 2048.0, 2.2 / 16.0], [1024, 2048, 16]).expect("lines");
    let frame = Frame::new(&geometries, &lines).expect("frame");
    let rays = Rays::new(2, lines.dims);
    let seen = Arc::new(Mutex::new(Vec::new()));
    let heard = seen.clone();
    let control = Control::with_progress(move |at| {
        let mut seen = heard.lock().expect("no other thread panics");
        if seen.is_empty() {
            device.destroy();
        }
        seen.push(at.rays_done);
    });
    let meshed = pollster::block_on(engine.columns(&frame, &rays, Rule::Parity, &control));
    let (columns, _) = meshed.expect("another device takes over");

    assert_eq!(engine.backend(), "gpu");
    assert_eq!(columns, cpu::columns(&frame, &rays, Rule::Parity, &Control::default()).expect("columns"));
    let seen = seen.lock().expect("no other thread panics");
    assert!(seen[0] < rays.n_rays(), "all was done before the device was destroyed");
    assert!(seen.is_sorted_by(|a, b| a < b), "every band is done once, in order: {seen:?}");
    assert_eq!(seen.last(), Some(&rays.n_rays()));
    println!("{} of {} rays were done when {} was destroyed", seen[0], rays.n_rays(), known.facts.name);
}
