//! The bytes of an STL file become those of a `.vti` file, for ParaView.
//!
//!     cargo run --example stl_to_vti -- part.stl part.vti

use hexcast::pipeline::MeshOptions;
use hexcast::write::{Compress, Format, Options, write};
use hexcast::{Control, Error, GeometryJob, Job, Mesher, MesherOptions, Result, Source};

/// Meshes a surface with 64 cells along its longest axis.
pub(crate) fn vti_of_stl(name: &str, mut stl: &[u8]) -> Result<Vec<u8>> {
    let control = Control::default();
    let source = Source::read(name, stl.len() as u64, &mut stl, &control)?;
    let mut job = Job::new(vec![GeometryJob::new(name)]);
    job.cells = Some(64);
    let mut mesher = Mesher::new(MesherOptions::default())?;
    let (mesh, _) = mesher.mesh_sources(&job, vec![source], &MeshOptions::default(), &control)?;
    let mut vti = Vec::new();
    write(&mesh, Format::Vti, &Options::default().with_compress(Compress::Zlib(6)), &mut vti, &control)?;
    Ok(vti)
}

fn main() -> Result<()> {
    let files: Vec<String> = std::env::args().skip(1).collect();
    let [input, output] = &files[..] else {
        return Err(Error::new("job-value", "two names are needed: of the STL file and of the .vti file", ""));
    };
    let stl = std::fs::read(input).map_err(|error| Error::io(format!("reading {input}"), error))?;
    let vti = vti_of_stl(input, &stl)?;
    std::fs::write(output, vti).map_err(|error| Error::io(format!("writing {output}"), error))
}
