//! A body that moves through a box: after every step only what it touches is meshed again.
//!
//!     cargo run --example moving_body -- part.stl

use hexcast::files::read_file;
use hexcast::pipeline::MeshOptions;
use hexcast::{Control, Error, GeometryJob, Job, Mesher, MesherOptions, Result, Source};

/// Moves a body along x, `n` steps of `length`; numbers of cells that changed at each.
pub(crate) fn cells_of_steps(source: &Source, n: u32, length: f64) -> Result<Vec<u64>> {
    let mut mesher = Mesher::new(MesherOptions::default())?;
    let mut job = Job::new(vec![GeometryJob::new(source.file.clone())]);
    // without a domain the box would follow the body
    job.domain = Some([-2.0, -2.0, -2.0, 4.0, 2.0, 2.0]);
    job.cells = Some(96);
    let control = Control::default();
    let mut scene = mesher.scene(job, vec![source.clone()], MeshOptions::default(), &control)?;
    let mut cells = Vec::new();
    for step in 1..=n {
        scene.job_mut().geometries[0].translate = Some([length * f64::from(step), 0.0, 0.0]);
        let update = mesher.update(&mut scene, &control)?;
        // a solver would set these cells; where the box is another one, all of them
        let changed = update.changed.unwrap_or_default();
        cells.push(changed.iter().map(|run| u64::from(run.end - run.start)).sum());
    }
    Ok(cells)
}

fn main() -> Result<()> {
    let Some(file) = std::env::args().nth(1) else {
        return Err(Error::new("job-value", "the name of an STL file is needed", ""));
    };
    let source = read_file(&file, &Control::default())?;
    println!("{:?}", cells_of_steps(&source, 10, 0.1)?);
    Ok(())
}
