//! STL: the closed surfaces of some flags as facets, to show or print a mesh anywhere.
//!
//! Binary: one list of facets, whose attribute is the flag. As text a solid for each flag, with its name. Lengths are in the unit of the mesh, which
//! the format does not have. Where cells touch along an edge alone, four facets meet there, for corners have no numbers.
//! Cost: that of [`surfaces`](crate::export::surfaces).

use crate::export::{
    format::Format,
    names::names,
    output::{Export, Files, Out},
    surfaces::{HELD, Surface, surfaces},
};
use hexcast_core::base::error::{Error, Result};
use hexcast_core::input::surface::doubled_area_vector;

pub(in crate::export) static FORMAT: Format = Format {
    program: "STL",
    about: "closed surfaces of cells",
    has_ascii: true,
    held: HELD,
    ..Format::new(&[".stl"], |job, name, files| Box::pin(write(job, name, files)))
};

/// Most characters of the name of a solid.
const LONGEST_NAME: usize = 127;
const HEADER_BYTES: usize = 80;

async fn write(job: &Export<'_>, name: &str, files: &mut dyn Files) -> Result<()> {
    let keeps = job.options.selection(job.mesh, false)?;
    let surfaces = surfaces(job, &keeps, [0.0; 3]).await?;
    let n: u64 = surfaces.iter().map(|surface| surface.triangles.len() as u64).sum();
    let Ok(n) = u32::try_from(n) else {
        let message = format!("the surfaces have {n} facets, and .stl holds up to {}", u32::MAX);
        return Err(Error::new("export-too-large", message, "export fewer flags, or mesh with larger cells"));
    };
    let mut out = Out::create(files, name)?;
    if job.options.ascii {
        let names = names(job.mesh, LONGEST_NAME, &[]);
        surfaces.iter().try_for_each(|surface| write_text(surface, &names[usize::from(surface.flag)], &mut out))?;
        return out.finish();
    }
    out.put(&[0; HEADER_BYTES])?;
    out.put(&n.to_le_bytes())?;
    for surface in &surfaces {
        for (normal, corners) in facets(surface) {
            [normal].iter().chain(&corners).flatten().try_for_each(|number| out.put(&number.to_le_bytes()))?;
            out.put(&u16::from(surface.flag).to_le_bytes())?;
        }
    }
    out.finish()
}

fn write_text(surface: &Surface, name: &str, out: &mut Out<'_>) -> Result<()> {
    out.text(format_args!("solid {name}\n"))?;
    for ([x, y, z], corners) in facets(surface) {
        out.text(format_args!("facet normal {x} {y} {z}\nouter loop\n"))?;
        corners.iter().try_for_each(|[x, y, z]| out.text(format_args!("vertex {x:?} {y:?} {z:?}\n")))?;
        out.put(b"endloop\nendfacet\n")?;
    }
    out.text(format_args!("endsolid {name}\n"))
}

/// The normal of each facet, which lies along an axis, and its corners.
fn facets(surface: &Surface) -> impl Iterator<Item = ([f32; 3], [[f32; 3]; 3])> {
    surface.triangles.iter().map(|triangle| {
        let corners = triangle.map(|corner| surface.corners[corner as usize]);
        // no 0 with a sign
        let normal = doubled_area_vector(&corners).map(|along| if along == 0.0 { 0.0 } else { along.signum() as f32 });
        (normal, corners)
    })
}
