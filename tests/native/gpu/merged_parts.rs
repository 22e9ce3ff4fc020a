//! Reports of random parts merge into those of the whole, on both backends, whichever axes are cut.

use hexcast::geometry::Facet;
use hexcast::gpu::Gpu;
use hexcast::job::{GeometryJob, Job, PartJob, Rule};
use hexcast::pipeline::{Engine, merge};
use hexcast::report::{CallerFacts, Report};
use serde_json::Value;

use super::kernels;
use crate::models;
use crate::open_surfaces::meshed;
use crate::soups::Random;

/// Drops what depends on the run: times and memory, and how many rays of a GPU were cast again.
fn lasting(report: &mut Value) {
    let object = report.as_object_mut().expect("an object");
    ["seconds", "peak_bytes", "cells_per_second", "device_check"].iter().for_each(|key| drop(object.remove(*key)));
}

/// A random body: a block, a ball, a plate, or a ball with holes.
fn body(random: &mut Random, round: u64) -> Vec<Facet> {
    let mut at = || [0, 1, 2].map(|_| random.below(56) as f32 / 8.0);
    let (one, size) = (at(), at());
    match random.below(4) {
        0 => models::cuboid(one, [0, 1, 2].map(|axis: usize| one[axis] + 0.25 + 0.6 * size[axis])),
        1 => models::sphere(one, 0.5 + 0.3 * size[0], 10),
        2 => models::cuboid(one, [one[0] + 0.5 + size[0], one[1] + 0.5 + size[1], one[2] + 0.3]),
        _ => models::joined([models::sphere(one, 1.9, 10), models::sphere([one[0] + 1.1, one[1], one[2]], 1.3, 10)]),
    }
    .into_iter()
    .skip((round % 5 == 4) as usize)
    .collect()
}

#[test]
fn reports_of_random_parts_merge_to_those_of_the_whole_on_both_backends() {
    let gpu = pollster::block_on(Gpu::open(Some(&kernels::gpu().facts.name))).expect("it was opened before");
    let mut engines = [Engine::cpu(), Engine::with_gpu(gpu)];
    let mut random = Random::new(14);
    let mut seen = [0; 4];
    for round in 0..60 {
        let bodies: Vec<Vec<Facet>> = (0..1 + random.below(4)).map(|_| body(&mut random, round)).collect();
        let dims = [0; 3].map(|_: i32| 2 + random.below(13) as u32);
        let mut job = set!(Job {
            dims: Some(dims),
            domain: Some([0.0, 0.0, 0.0, 8.0, 8.0, 8.0]),
            certify: true,
            ..Job::default()
        });
        job.rule = [Rule::Parity, Rule::Parity, Rule::Nonzero][(round % 3) as usize];
        job.thin_cells = [None, Some(4)][(round % 2) as usize];
        let geometry =
            |random: &mut Random| set!(GeometryJob { priority: random.below(3) as i32 - 1, ..GeometryJob::default() });
        job.geometries = bodies.iter().map(|_| geometry(&mut random)).collect();
        let of = dims.map(|n| 1 + random.below(u64::from(n.min(4))) as u32);
        let axis = random.below(3) as usize;
        let engine = &mut engines[usize::from(round % 6 == 5)];
        let mut report = |job: &Job| {
            let (_, facts) = meshed(&bodies, job, axis, engine).expect("a mesh");
            serde_json::from_str(&Report::new(facts, CallerFacts::default()).to_json()).expect("it is JSON")
        };
        let mut expected: Value = report(&job);
        let parts: Vec<Value> = (1..=of.iter().product())
            .map(|index| report(&set!(Job { part: Some(PartJob::new(index, of)), ..job.clone() })))
            .collect();
        let mut merged = merge(&parts).expect("they are parts of one mesh");
        lasting(&mut merged);
        lasting(&mut expected);
        for (key, value) in expected.as_object().expect("an object") {
            assert_eq!(&merged[key], value, "round {round}, {dims:?} in {of:?}, rays along {axis}: {key}");
        }
        let lists =
            ["thin_walls", "overlaps", "gaps"].map(|key| expected["certificate"][key].as_array().map_or(0, Vec::len));
        let n_open = expected["open"].as_array().map_or(0, Vec::len);
        seen.iter_mut().zip(lists.into_iter().chain([n_open])).for_each(|(seen, n)| *seen += n);
    }
    assert!(seen.iter().all(|n| *n > 5), "what is to be merged is there: {seen:?}");
}
