//! A window of a mesh, as one of many processes would make it: only its own cells, in their own memory.
//!
//!     cargo run --example window -- part.stl

use hexcast::job::PartJob;
use hexcast::{Error, GeometryJob, Job, Mesh, Mesher, MesherOptions, Result};

/// Meshes part `index` of `n`, counted from 1: slabs across z that cost about the same. Returns it and the first of its cells.
pub(crate) fn part(file: &str, index: u32, n: u32) -> Result<(Mesh, [u32; 3])> {
    let mut job = Job::new(vec![GeometryJob::new(file)]);
    (job.cells, job.part) = (Some(100), Some(PartJob::new(index, [1, 1, n])));
    let (mesh, report) = Mesher::new(MesherOptions::default())?.mesh(&job)?;
    let first = report.mesh.window.map_or([0; 3], |window| window.first);
    Ok((mesh, first))
}

fn main() -> Result<()> {
    let Some(file) = std::env::args().nth(1) else {
        return Err(Error::new("job-value", "the name of an STL file is needed", ""));
    };
    for index in 1..=4 {
        let (mesh, first) = part(&file, index, 4)?;
        let [nx, ny, nz] = mesh.dims();
        println!("part {index} of 4: {nx} x {ny} x {nz} cells from {first:?} on");
    }
    Ok(())
}
