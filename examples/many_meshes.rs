//! Many meshes with one mesher, which opens the GPU once: a body that turns.
//!
//!     cargo run --example many_meshes -- part.stl

use hexcast::files::read_file;
use hexcast::pipeline::MeshOptions;
use hexcast::{Control, Error, GeometryJob, Job, Mesher, MesherOptions, Result, Source};

/// Numbers of cells inside, at so many angles of a quarter turn about z.
pub(crate) fn cells_of_turns(source: &Source, n: u32) -> Result<Vec<u64>> {
    let mut mesher = Mesher::new(MesherOptions::default())?;
    let cells_at = |index: u32| {
        let degrees = 90.0 * f64::from(index) / f64::from(n);
        let mut body = GeometryJob::new(source.file.clone());
        body.rotate = Some([0.0, 0.0, degrees]);
        let mut job = Job::new(vec![body]);
        job.cells = Some(32);
        // the facets are shared, not copied
        let sources = vec![source.clone()];
        let (_, report) = mesher.mesh_sources(&job, sources, &MeshOptions::default(), &Control::default())?;
        Ok(report.mesh.flags.iter().map(|flag| flag.cells).sum())
    };
    (0..=n).map(cells_at).collect()
}

fn main() -> Result<()> {
    let Some(file) = std::env::args().nth(1) else {
        return Err(Error::new("job-value", "the name of an STL file is needed", ""));
    };
    let source = read_file(&file, &Control::default())?;
    println!("{:?}", cells_of_turns(&source, 9)?);
    Ok(())
}
