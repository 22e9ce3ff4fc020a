//! Progress, and a cancel from another thread.
//!
//!     cargo run --example progress_and_cancel

use std::sync::mpsc;
use std::thread;

use hexcast::control::Progress;
use hexcast::geometry::Facet;
use hexcast::pipeline::MeshOptions;
use hexcast::{Control, GeometryJob, Job, Mesher, MesherOptions, Result, Source};

/// Meshes a cube of 2000 cells a side, and cancels when a part of the rays is done. Returns what was told of the progress and the result.
pub(crate) fn cancelled_after(part: f64) -> (Vec<Progress>, Result<()>) {
    let (tell, told) = mpsc::channel();
    // called after every band, from the thread that meshes; that nobody listens any more is no error
    let control = Control::with_progress(move |progress| tell.send(progress).unwrap_or_default());
    let token = control.cancel.clone();
    let watching = thread::spawn(move || {
        let mut found = Vec::new();
        for progress in told {
            found.push(progress);
            if progress.rays_done as f64 >= part * progress.n_rays as f64 {
                token.cancel();
            }
        }
        found
    });
    let result = mesh(control);
    // the control is gone, and with it the sender
    (watching.join().unwrap_or_default(), result)
}

fn mesh(control: Control) -> Result<()> {
    let mut job = Job::new(vec![GeometryJob::new("cube")]);
    job.cells = Some(2000);
    let sources = vec![Source::from_facets("cube", cube())?];
    Mesher::new(MesherOptions::default())?.mesh_sources(&job, sources, &MeshOptions::default(), &control)?;
    Ok(())
}

/// The facets of a cube from 0 to 1.
fn cube() -> Vec<Facet> {
    let corner = |number: u8| [0, 1, 2].map(|axis| f32::from(number >> axis & 1));
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let facets = sides.map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    facets.as_flattened().iter().map(|facet| facet.map(corner)).collect()
}

fn main() {
    let (told, result) = cancelled_after(0.5);
    for Progress { rays_done, n_rays, .. } in told {
        println!("{rays_done} of {n_rays} rays");
    }
    match result {
        Ok(()) => println!("done before the cancel"),
        Err(error) => println!("{error}"),
    }
}
