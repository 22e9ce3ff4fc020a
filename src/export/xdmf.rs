//! XDMF: the cells of some flags as hexahedra, for ParaView, VTK, meshio and dolfinx.
//!
//! Two files: `NAME.xdmf` describes the mesh, and `NAME.h5` beside it holds `points` (x, y, z), `cells` (the eight corners in VTK's order) and
//! `flag`; its attributes have the names of flags, their materials as JSON, and the unit. XDMF, not VTKHDF, as dolfinx reads it. Lengths are in the unit of the mesh.
//! Source: the XDMF model and format, version 3. Cost: the memory of [`layers`](super::layers); the flags are expanded four times.

use super::hdf5::{File, Shape, Table};
use super::layers::for_each_layer;
use super::output::{Export, Files, Out};
use super::xml::Xml;
use crate::error::Result;

pub(super) fn file_names(name: &str) -> [String; 2] {
    let stem = name.rsplit_once('.').map_or(name, |(stem, _)| stem);
    [name.to_string(), format!("{stem}.h5")]
}

pub(super) async fn write(job: &Export<'_>, name: &str, files: &mut dyn Files) -> Result<()> {
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
    describe(&document, &data, [n_points, n_cells], files)?;

    let compress = job.options.compress;
    // numbers of points and cells as f64, u64 and u8
    let mut file = File::create(files, &data, 24 * n_points as u64 + 65 * n_cells as u64)?;
    for named in &job.mesh.names {
        let key = format!("flag {}", named.flag);
        file.text(&key, &named.name)?;
        named.material.json().iter().try_for_each(|material| file.text(&format!("{key} material"), material))?;
    }
    job.mesh.unit.iter().try_for_each(|unit| file.text("unit", unit))?;
    let lines = [0, 1, 2].map(|axis| job.mesh.lines.list(axis));
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
    file.finish(files)
}

fn describe(name: &str, data: &str, [n_points, n_cells]: [usize; 2], files: &mut dyn Files) -> Result<()> {
    // the file of numbers is found beside this one
    let data = data.rsplit('/').next().unwrap_or(data);
    let mut out = Out::create(files, name)?;
    let mut xml = Xml::new(&mut out.file)?;
    xml.open("Xdmf", &[("Version", "3.0")])?;
    xml.open("Domain", &[])?;
    xml.open("Grid", &[("Name", "Grid"), ("GridType", "Uniform")])?;
    let cells = n_cells.to_string();
    xml.open("Topology", &[("TopologyType", "Hexahedron"), ("NumberOfElements", &cells), ("NodesPerElement", "8")])?;
    item(&mut xml, &format!("{cells} 8"), ["UInt", "8"], &format!("{data}:/cells"))?;
    xml.close("Topology")?;
    xml.open("Geometry", &[("GeometryType", "XYZ")])?;
    item(&mut xml, &format!("{n_points} 3"), ["Float", "8"], &format!("{data}:/points"))?;
    xml.close("Geometry")?;
    xml.open("Attribute", &[("Name", "flag"), ("AttributeType", "Scalar"), ("Center", "Cell")])?;
    item(&mut xml, &cells, ["UChar", "1"], &format!("{data}:/flag"))?;
    xml.close("Attribute")?;
    ["Grid", "Domain", "Xdmf"].iter().try_for_each(|element| xml.close(element))?;
    out.finish()
}

fn item<W: std::io::Write>(xml: &mut Xml<W>, dimensions: &str, [kind, bytes]: [&str; 2], place: &str) -> Result<()> {
    let attributes = [("Dimensions", dimensions), ("NumberType", kind), ("Precision", bytes), ("Format", "HDF")];
    xml.text("DataItem", &attributes, place)
}
