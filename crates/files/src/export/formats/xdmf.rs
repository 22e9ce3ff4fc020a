//! XDMF: the cells of some flags as hexahedra, for ParaView, VTK, meshio and dolfinx.
//!
//! Two files: `NAME.xdmf` describes the mesh, and `NAME.h5` beside it holds `points` (x, y, z), `cells` (the eight corners in VTK's order) and
//! `flag`; where names of patches are asked for ([`patches`](crate::export::patches)) also `facets`, four corners each, and `wall`, the number of the patch, as a
//! second grid. Its attributes have the names of flags and patches, materials as JSON, and the unit. XDMF, not VTKHDF, as dolfinx reads it. Lengths are in
//! the unit of the mesh.
//! Source: the XDMF model and format, version 3. Cost: the memory of [`layers`](crate::export::layers); the flags are expanded four times.

use crate::export::{
    format::Format,
    hdf5::{File, Shape, Table},
    layers::for_each_layer,
    output::{Export, Files, Out},
    patches::Boundary,
    xml::Xml,
};
use hexcast_core::base::error::Result;

pub(in crate::export) static FORMAT: Format = Format {
    program: "XDMF",
    about: "hexahedra for ParaView, meshio and dolfinx",
    on_disk: "with their numbers beside it in .h5",
    compresses: true,
    longest_name: Some(LONGEST_NAME),
    file_names: |name| file_names(name).to_vec(),
    ..Format::new(&[".xdmf"], |job, name, files| Box::pin(write(job, name, files)))
};

/// Most characters of a name.
const LONGEST_NAME: usize = 127;

fn file_names(name: &str) -> [String; 2] {
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    [name.to_string(), format!("{stem}.h5")]
}

async fn write(job: &Export<'_>, name: &str, files: &mut dyn Files) -> Result<()> {
    let keeps = job.options.selection(job.mesh, false)?;
    let [document, data] = file_names(name);
    let (mut n_points, mut n_cells) = (0usize, 0usize);
    for_each_layer(job, &keeps, &mut |layer| {
        layer.for_each_cell(|_, _, _| {
            n_cells += 1;
            Ok(())
        })?;
        layer.for_each_point(|_, _| {
            n_points += 1;
            Ok(())
        })
    })
    .await?;
    let boundary = Boundary::new(job, &keeps, LONGEST_NAME).await?;
    let n_facets = boundary.n_faces() as usize;
    describe(&document, &data, [n_points, n_cells, n_facets], files)?;

    let compress = job.options.compress;
    // numbers of points and cells as f64, u64 and u8
    let mut file = File::create(files, &data, 24 * n_points as u64 + 65 * n_cells as u64 + 36 * n_facets as u64)?;
    for (patch, ..) in boundary.used() {
        file.text(&format!("wall {}", patch + 1), boundary.patches.name(patch))?;
    }
    for named in job.mesh.names() {
        let key = format!("flag {}", named.flag);
        file.text(&key, &named.name)?;
        named.material.json().iter().try_for_each(|material| file.text(&format!("{key} material"), material))?;
    }
    job.mesh.unit().iter().try_for_each(|unit| file.text("unit", unit))?;
    let lines = [0, 1, 2].map(|axis| job.mesh.lines().list(axis));
    let shape = Shape { name: "points", dims: &[n_points, 3], compress };
    let mut points = Table::<f64>::new(&mut file, shape)?;
    for_each_layer(job, &keeps, &mut |layer| {
        layer.for_each_point(|[x, y], _| points.push(&[lines[0][x], lines[1][y], lines[2][layer.z as usize]]))
    })
    .await?;
    points.finish(&mut file)?;
    let shape = Shape { name: "cells", dims: &[n_cells, 8], compress };
    let mut cells = Table::<u64>::new(&mut file, shape)?;
    for_each_layer(job, &keeps, &mut |layer| layer.for_each_cell(|cell, _, _| cells.push(&layer.corners(cell))))
        .await?;
    cells.finish(&mut file)?;
    let shape = Shape { name: "flag", dims: &[n_cells], compress };
    let mut flags = Table::<u8>::new(&mut file, shape)?;
    for_each_layer(job, &keeps, &mut |layer| layer.for_each_cell(|_, flag, _| flags.push(&[flag]))).await?;
    flags.finish(&mut file)?;
    if n_facets > 0 {
        let shape = Shape { name: "facets", dims: &[n_facets, 4], compress };
        let mut facets = Table::<u64>::new(&mut file, shape)?;
        for (patch, ..) in boundary.used() {
            boundary.for_each_of(patch, &mut |corners| facets.push(&corners)).await?;
        }
        facets.finish(&mut file)?;
        let shape = Shape { name: "wall", dims: &[n_facets], compress };
        let mut walls = Table::<u32>::new(&mut file, shape)?;
        for (patch, n, _) in boundary.used() {
            (0..n).try_for_each(|_| walls.push(&[patch as u32 + 1]))?;
        }
        walls.finish(&mut file)?;
    }
    file.finish(files)
}

fn describe(name: &str, data: &str, [n_points, n_cells, n_facets]: [usize; 3], files: &mut dyn Files) -> Result<()> {
    // the file of numbers is found beside this one
    let data = data.rsplit('/').next().unwrap_or(data);
    let mut out = Out::create(files, name)?;
    let mut xml = Xml::new(&mut out.file)?;
    xml.open("Xdmf", &[("Version", "3.0")])?;
    xml.open("Domain", &[])?;
    let cells = ("Grid", "Hexahedron", "8", "cells", ("flag", ["UChar", "1"]), n_cells);
    let facets = ("facets", "Quadrilateral", "4", "facets", ("wall", ["UInt", "4"]), n_facets);
    for (name, shape, n_corners, corners, (values, kind), n) in [cells, facets].into_iter().filter(|of| of.5 > 0) {
        xml.open("Grid", &[("Name", name), ("GridType", "Uniform")])?;
        let n = n.to_string();
        xml.open("Topology", &[("TopologyType", shape), ("NumberOfElements", &n), ("NodesPerElement", n_corners)])?;
        item(&mut xml, &format!("{n} {n_corners}"), ["UInt", "8"], &format!("{data}:/{corners}"))?;
        xml.close("Topology")?;
        xml.open("Geometry", &[("GeometryType", "XYZ")])?;
        item(&mut xml, &format!("{n_points} 3"), ["Float", "8"], &format!("{data}:/points"))?;
        xml.close("Geometry")?;
        xml.open("Attribute", &[("Name", values), ("AttributeType", "Scalar"), ("Center", "Cell")])?;
        item(&mut xml, &n, kind, &format!("{data}:/{values}"))?;
        xml.close("Attribute")?;
        xml.close("Grid")?;
    }
    ["Domain", "Xdmf"].iter().try_for_each(|element| xml.close(element))?;
    out.finish()
}

fn item<W: std::io::Write>(xml: &mut Xml<W>, dimensions: &str, [kind, bytes]: [&str; 2], place: &str) -> Result<()> {
    let attributes = [("Dimensions", dimensions), ("NumberType", kind), ("Precision", bytes), ("Format", "HDF")];
    xml.text("DataItem", &attributes, place)
}
