//! OpenMC: the flags of equal cells as a lattice (`geometry.xml`).
//!
//! One file: a lattice of universes, one for each flag, within six planes on which particles leave (`boundary="vacuum"`). Kept flags are
//! filled with the material whose `id` is the flag (256 for flag 0), which the user's `materials.xml` has; others are void. Lengths are in cm.
//!
//! The cells of a plane are written from the greatest y down, as OpenMC reads them; planes from the least z up.
//! Source: OpenMC user guide, "Geometry Specification". Cost: two slabs of flags, which are whole planes.

use std::fmt::Write as _;

use crate::export::{
    format::Format,
    limits::equal_cells,
    names::names,
    output::{Export, Files, Out},
    unit::known,
    xml::Xml,
};
use hexcast_core::base::error::{Error, Result};
use hexcast_core::grid::lines::Lines;

pub(in crate::export) static FORMAT: Format = Format {
    program: "OpenMC",
    about: "a lattice",
    on_disk: "the name must be this",
    unit: Some((WHAT, "centimetres")),
    check_lines,
    ..Format::new(&["geometry.xml"], |job, name, files| Box::pin(write(job, name, files)))
};

const WHAT: &str = "OpenMC";
/// Ids of the lattice and of the cell around it; those of universes and of their cells are flags + 1.
const OUTER: &str = "1000";
/// Id of the material of flag 0: ids are positive.
const BACKGROUND_MATERIAL: usize = 256;

fn check_lines(lines: &Lines) -> Result<()> {
    equal_cells(lines, WHAT)?;
    let n_cells = lines.dims().iter().map(|&n| u128::from(n)).product::<u128>();
    if n_cells > i32::MAX as u128 {
        let message = format!("{n_cells} cells: OpenMC numbers up to {}", i32::MAX);
        return Err(Error::new("export-too-large", message, "mesh with larger cells"));
    }
    Ok(())
}

async fn write(job: &Export<'_>, name: &str, files: &mut dyn Files) -> Result<()> {
    let mesh = job.mesh;
    let keeps = job.options.selection(mesh, false)?;
    let unit = known(mesh.unit(), WHAT, "centimetres")?;
    let pitch = equal_cells(mesh.lines(), WHAT)?.map(|size| unit.centimetres(size));
    let dims = mesh.dims();
    let [low, high] =
        [[0; 3], dims].map(|line| [0, 1, 2].map(|axis| unit.centimetres(mesh.lines().line(axis, line[axis]))));
    let names = names(mesh, 60, &["box", "lattice"]);
    let cells = mesh.columns().cells_per_flag();
    let mut out = Out::create(files, name)?;
    let mut xml = Xml::new(&mut out.file)?;
    xml.open("geometry", &[])?;
    let region = [("region", "1 -2 3 -4 5 -6"), ("universe", "0")];
    xml.empty("cell", &[&[("id", OUTER), ("name", "box"), ("fill", OUTER)][..], &region].concat())?;
    for flag in (0..256).filter(|&flag| cells[flag] > 0) {
        let id = (flag + 1).to_string();
        let material = match flag {
            _ if !keeps[flag] => "void".to_string(),
            0 => BACKGROUND_MATERIAL.to_string(),
            _ => flag.to_string(),
        };
        xml.empty("cell", &[("id", &id), ("name", &names[flag]), ("material", &material), ("universe", &id)])?;
    }
    for side in 0..6 {
        let kind = ["x-plane", "y-plane", "z-plane"][side / 2];
        let at = format!("{:?}", if side % 2 == 0 { low } else { high }[side / 2]);
        let id = (side + 1).to_string();
        xml.empty("surface", &[("id", &id), ("type", kind), ("coeffs", &at), ("boundary", "vacuum")])?;
    }
    xml.open("lattice", &[("id", OUTER), ("name", "lattice")])?;
    let text = |numbers: [f64; 3]| numbers.map(|number| format!("{number:?}")).join(" ");
    xml.text("pitch", &[], &text(pitch))?;
    xml.text("dimension", &[], &dims.map(|n| n.to_string()).join(" "))?;
    xml.text("lower_left", &[], &text(low))?;
    xml.open("universes", &[])?;
    let [nx, ny] = [dims[0] as usize, dims[1] as usize];
    job.for_each_slab(nx * ny, &mut |flags| {
        let mut line = String::with_capacity(4 * nx + 1);
        // rows from the greatest y down; a slab is whole planes
        flags.chunks_exact(nx * ny).flat_map(|plane| plane.chunks_exact(nx).rev()).try_for_each(|row| {
            line.clear();
            line.push('\n');
            for flag in row {
                // a String takes all that is written to it
                let _ = write!(line, "{} ", u32::from(*flag) + 1);
            }
            xml.more(&line)
        })
    })
    .await?;
    ["universes", "lattice", "geometry"].iter().try_for_each(|element| xml.close(element))?;
    out.finish()
}
