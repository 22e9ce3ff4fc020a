//! Gmsh: the cells of some flags as hexahedra in a file of MSH 4.1.
//!
//! Every flag is a volume and a physical group of its name, whose number is the flag (256 for flag 0: numbers are positive). Lengths are in the
//! unit of the mesh, as the format has none. Where names of patches are asked for ([`patches`](crate::export::patches)), the faces at the boundary of the exported
//! cells are quadrangles, each patch a surface and a physical group of its name. Binary, or text on request.
//! Source: Gmsh reference manual, "MSH file format". Cost: the memory of [`layers`](crate::export::layers); the flags are expanded once for the points, and once for
//! each flag and patch.

use crate::export::{
    format::Format,
    layers::for_each_layer,
    names::names,
    output::{Export, Files, Out},
    patches::Boundary,
};
use hexcast_core::base::error::Result;

pub(in crate::export) static FORMAT: Format = Format {
    program: "Gmsh",
    about: "hexahedra, MSH 4.1",
    has_ascii: true,
    longest_name: Some(LONGEST_NAME),
    ..Format::new(&[".msh"], |job, name, files| Box::pin(write(job, name, files)))
};

/// Type of an element of eight corners.
const HEXAHEDRON: u64 = 5;
/// Type of an element of four corners.
const QUADRANGLE: u64 = 3;
/// Most characters of a name.
const LONGEST_NAME: usize = 127;
/// Number of the volume of flag 0.
const BACKGROUND_TAG: u64 = 256;

async fn write(job: &Export<'_>, name: &str, files: &mut dyn Files) -> Result<()> {
    let keeps = job.options.selection(job.mesh, false)?;
    let cells = job.mesh.columns().cells_per_flag();
    let flags: Vec<usize> = (0..256).filter(|&flag| keeps[flag] && cells[flag] > 0).collect();
    let n_cells: u64 = flags.iter().map(|&flag| cells[flag]).sum();
    let mut boxes = vec![[[u32::MAX; 3], [0; 3]]; 256];
    let mut n_points = 0u64;
    for_each_layer(job, &keeps, &mut |layer| {
        layer.for_each_point(|_, _| {
            n_points += 1;
            Ok(())
        })?;
        layer.for_each_cell(|[x, y], flag, _| {
            let [low, high] = &mut boxes[usize::from(flag)];
            for (axis, at) in [x as u32, y as u32, layer.z].into_iter().enumerate() {
                low[axis] = low[axis].min(at);
                high[axis] = high[axis].max(at + 1);
            }
            Ok(())
        })
    })
    .await?;
    let names = names(job.mesh, LONGEST_NAME, &[]);
    let boundary = Boundary::new(job, &keeps, LONGEST_NAME).await?;
    let n_surfaces = boundary.used().count();
    let lines = [0, 1, 2].map(|axis| job.mesh.lines().list(axis));
    let is_ascii = job.options.ascii;
    let mut out = Msh { out: Out::create(files, name)?, is_ascii };
    out.text(&format!("$MeshFormat\n4.1 {} 8\n", u8::from(!is_ascii)))?;
    if !is_ascii {
        out.int(1)?;
        out.text("\n")?;
    }
    out.text(&format!("$EndMeshFormat\n$PhysicalNames\n{}\n", flags.len() + n_surfaces))?;
    for (patch, ..) in boundary.used() {
        out.text(&format!("2 {} \"{}\"\n", patch + 1, boundary.patches.name(patch)))?;
    }
    flags.iter().try_for_each(|&flag| out.text(&format!("3 {} \"{}\"\n", tag(flag), names[flag])))?;
    out.text("$EndPhysicalNames\n$Entities\n")?;
    out.sizes(&[0, 0, n_surfaces as u64, flags.len() as u64])?;
    out.end_line()?;
    let surfaces = boundary.used().map(|(patch, _, ends)| (patch as u64 + 1, ends));
    for (tag, ends) in surfaces.chain(flags.iter().map(|&flag| (tag(flag), boxes[flag]))) {
        out.int(tag)?;
        let corners = ends.map(|corner| [0, 1, 2].map(|axis| lines[axis][corner[axis] as usize]));
        out.doubles(corners.as_flattened())?;
        out.sizes(&[1])?;
        out.int(tag)?;
        out.sizes(&[0])?;
        out.end_line()?;
    }
    out.text("\n$EndEntities\n$Nodes\n")?;
    out.sizes(&[1, n_points, 1, n_points])?;
    out.end_line()?;
    // all points are in the volume of the first flag, whose cells need not have them all
    [3, tag(flags[0]), 0].iter().try_for_each(|number| out.int(*number))?;
    out.sizes(&[n_points])?;
    out.end_line()?;
    for point in 1..=n_points {
        out.sizes(&[point])?;
        out.end_line()?;
    }
    for_each_layer(job, &keeps, &mut |layer| {
        layer.for_each_point(|[x, y], _| {
            out.doubles(&[lines[0][x], lines[1][y], lines[2][layer.z as usize]])?;
            out.end_line()
        })
    })
    .await?;
    out.text("\n$EndNodes\n$Elements\n")?;
    let n_elements = n_cells + boundary.n_faces();
    out.sizes(&[(n_surfaces + flags.len()) as u64, n_elements, 1, n_elements])?;
    out.end_line()?;
    let mut number = n_cells;
    for (patch, n, _) in boundary.used() {
        [2, patch as u64 + 1, QUADRANGLE].iter().try_for_each(|number| out.int(*number))?;
        out.sizes(&[n])?;
        out.end_line()?;
        boundary
            .for_each_of(patch, &mut |corners| {
                number += 1;
                let [a, b, c, d] = corners.map(|point| point + 1);
                out.sizes(&[number, a, b, c, d])?;
                out.end_line()
            })
            .await?;
    }
    for &wanted in &flags {
        [3, tag(wanted), HEXAHEDRON].iter().try_for_each(|number| out.int(*number))?;
        out.sizes(&[cells[wanted]])?;
        out.end_line()?;
        for_each_layer(job, &keeps, &mut |layer| {
            layer.for_each_cell(|cell, flag, number| {
                if usize::from(flag) != wanted {
                    return Ok(());
                }
                let [a, b, c, d, e, f, g, h] = layer.corners(cell).map(|point| point + 1);
                out.sizes(&[number + 1, a, b, c, d, e, f, g, h])?;
                out.end_line()
            })
        })
        .await?;
    }
    out.text("\n$EndElements\n")?;
    out.out.finish()
}

/// Number of the volume and the group of a flag.
fn tag(flag: usize) -> u64 {
    if flag == 0 { BACKGROUND_TAG } else { flag as u64 }
}

/// A file of numbers, as text or binary.
struct Msh<'a> {
    out: Out<'a>,
    is_ascii: bool,
}

impl Msh<'_> {
    fn text(&mut self, text: &str) -> Result<()> {
        self.out.put(text.as_bytes())
    }

    fn int(&mut self, number: u64) -> Result<()> {
        // tags and types only, which are small
        if self.is_ascii {
            self.out.text(format_args!("{number} "))
        } else {
            self.out.put(&(number as i32).to_le_bytes())
        }
    }

    fn sizes(&mut self, numbers: &[u64]) -> Result<()> {
        numbers.iter().try_for_each(|number| match self.is_ascii {
            true => self.out.text(format_args!("{number} ")),
            false => self.out.put(&number.to_le_bytes()),
        })
    }

    fn doubles(&mut self, numbers: &[f64]) -> Result<()> {
        numbers.iter().try_for_each(|number| match self.is_ascii {
            true => self.out.text(format_args!("{number:e} ")),
            false => self.out.put(&number.to_le_bytes()),
        })
    }

    fn end_line(&mut self) -> Result<()> {
        if self.is_ascii { self.out.put(b"\n") } else { Ok(()) }
    }
}
