//! A body that moves in a scene, timed: ten spheres of 20,000 facets in a box of so many cells, of which one moves by a third of a cell at a time.

use std::error::Error;
use std::time::Instant;

use hexcast::job::{BackendChoice, GeometryJob, Job};
use hexcast::mesher::{Mesher, MesherOptions};
use hexcast::pipeline::MeshOptions;
use hexcast::{Control, Source};
use serde_json::json;

use crate::line::median;
use crate::spheres::sphere;

/// Slices and stacks of a sphere.
const FINE: [u32; 2] = [100, 101];
const N_SPHERES: u32 = 10;

/// Prints the median seconds of an update, of the first one, and of a whole mesh.
pub(crate) fn measure(cells: u32, runs: u32) -> Result<(), Box<dyn Error>> {
    let mut mesher = Mesher::new(MesherOptions::default().with_backend(BackendChoice::Cpu))?;
    let body = |index: u32| {
        let at = [index % 3, index / 3 % 2, index / 6].map(|n| f64::from(n) + 0.5);
        Source::from_facets("sphere", sphere(at, FINE))
    };
    let sources: Vec<Source> = (0..N_SPHERES).map(body).collect::<Result<_, _>>()?;
    let mut job = Job::new(vec![GeometryJob::new("sphere"); N_SPHERES as usize]);
    (job.domain, job.dims) = (Some([0.0, 0.0, 0.0, 3.0, 3.0, 3.0]), Some([cells; 3]));
    let control = Control::default();
    let mut scene = mesher.scene(job, sources, MeshOptions::default(), &control)?;
    let (mut seconds, mut changed, mut rays) = (Vec::new(), 0, 0);
    for step in 0..=runs.max(1) {
        let by = f64::from(step + 1) / f64::from(cells);
        scene.job_mut().geometries[0].translate = Some([by, 0.5 * by, 0.25 * by]);
        let start = Instant::now();
        let update = mesher.update(&mut scene, &control)?;
        seconds.push(start.elapsed().as_secs_f64());
        (changed, rays) = (update.changed.map_or(0, |runs| runs.len()), update.rays);
    }
    let mut wholes = Vec::new();
    for _ in 0..runs.max(1) {
        let start = Instant::now();
        let (mesh, _) =
            mesher.mesh_sources(scene.job(), scene.sources().to_vec(), &MeshOptions::default(), &control)?;
        wholes.push(start.elapsed().as_secs_f64());
        assert!(mesh == *scene.mesh(), "an update differs from the whole");
    }
    let facets: usize = scene.sources().iter().map(|source| source.contents.n_facets as usize).sum();
    println!(
        "{}",
        json!({
            "case": "moved", "n": cells, "facets": facets, "moved_facets": facets as u32 / N_SPHERES, "cells": scene.mesh().n_cells(),
            "rays": rays, "changed_runs": changed, "first_s": seconds[0],
            "update_s": median(seconds[1..].iter().copied()), "whole_s": median(wholes.into_iter()),
        })
    );
    Ok(())
}
