//! Facets in memory become a mesh, which is asked for cells.
//!
//!     cargo run --example facets_to_query

use hexcast::geometry::Facet;
use hexcast::job::PerAxis;
use hexcast::pipeline::MeshOptions;
use hexcast::{Control, GeometryJob, Job, Mesh, Mesher, MesherOptions, Result, Source};

/// The facets of an octahedron around the origin, whose corners are `size` away from it.
pub(crate) fn octahedron(size: f32) -> Vec<Facet> {
    let tip = |axis: usize, side: f32| {
        let mut corner = [0.0; 3];
        corner[axis] = side * size;
        corner
    };
    let facet = |number: usize| {
        let sides = [0, 1, 2].map(|axis| if number >> axis & 1 == 0 { -1.0 } else { 1.0 });
        let [x, y, z] = [0, 1, 2].map(|axis| tip(axis, sides[axis]));
        // counter-clockwise seen from outside
        if sides.iter().product::<f32>() > 0.0 { [x, y, z] } else { [x, z, y] }
    };
    (0..8).map(facet).collect()
}

/// Meshes an octahedron of size 1 in cells of a tenth.
pub(crate) fn meshed() -> Result<Mesh> {
    let mut body = GeometryJob::new("body");
    body.flag = Some(7);
    let mut job = Job::new(vec![body]);
    job.cell_size = Some(PerAxis::All(0.1));
    let source = Source::from_facets("body", octahedron(1.0))?;
    let mut mesher = Mesher::new(MesherOptions::default())?;
    let (mesh, _) = mesher.mesh_sources(&job, vec![source], &MeshOptions::default(), &Control::default())?;
    Ok(mesh)
}

pub(crate) fn main() -> Result<()> {
    let mesh = meshed()?;
    let [nx, ny, nz] = mesh.dims();
    println!("{nx} x {ny} x {nz} cells");
    println!("the cell in the middle has flag {}", mesh.flag([nx / 2, ny / 2, nz / 2])?);
    println!("the cell at the corner has flag {}", mesh.flag([0, 0, 0])?);
    // one byte a cell, x fastest; the end is exclusive
    let layer = mesh.box_flags(&[0..nx, 0..ny, nz / 2..nz / 2 + 1])?;
    println!("the layer in the middle has {} cells inside", layer.iter().filter(|&&flag| flag == 7).count());
    Ok(())
}
