//! Abaqus and CalculiX: the cells of some flags as bricks in an input file (`.inp`).
//!
//! Nodes (set `NALL`) in metres, then the elements of each flag (type C3D8I, set of the flag's name), a solid section and a material for each flag
//! whose E and nu are given, node sets of the sides of the box that have nodes (`XMIN` ... `ZMAX`), and for each flag the surface
//! `S_` + name: the sides of its elements towards other flags, exported or not, and beyond the box. Where names of patches are asked for, the sides of
//! each are a surface, too, `S_` + name + `_` + that of the patch ([`patches`](crate::export::patches)). Steps, loads and whatever else the problem
//! has are the user's, in a file that includes this one (`*INCLUDE, INPUT=mesh.inp`). Materials and lengths are in SI units.
//!
//! Numbers have at most 20 characters, of which CalculiX reads no more, so coordinates are rounded to 13 digits. Source: Abaqus keywords
//! guide, CalculiX CrunchiX manual. Cost: the memory of [`layers`](crate::export::layers), and the flags are expanded once for each part of the file.

use std::collections::BTreeSet;

use crate::export::{
    format::Format,
    layers::{Layer, N_SIDES, for_each_layer},
    names::{names, said, unique},
    options::PatchNames,
    output::{Export, Files, Out},
    patches::Patches,
    unit::metres,
};
use hexcast_core::base::error::{Error, Result};
use hexcast_derived::mesh::Named;
use hexcast_core::input::geometry::Material;

pub(in crate::export) static FORMAT: Format = Format {
    program: "Abaqus, CalculiX",
    about: "bricks, sets, surfaces",
    longest_name: Some(LONGEST_NAME),
    unit: Some(("an Abaqus file, whose materials are in SI units,", "metres")),
    check_materials,
    ..Format::new(&[".inp"], |job, name, files| Box::pin(write(job, name, files)))
};

/// Greatest number of a node or an element in Abaqus.
const MAX_NUMBER: u64 = 999_999_999;
const SIDE_NAMES: [&str; N_SIDES] = ["XMIN", "XMAX", "YMIN", "YMAX", "ZMIN", "ZMAX"];
/// Number of the face of an element on each side.
const FACES: [u8; N_SIDES] = [6, 4, 3, 5, 1, 2];
/// Sets that this file has besides those of the flags.
const TAKEN: [&str; 8] = ["NALL", "EALL", "XMIN", "XMAX", "YMIN", "YMAX", "ZMIN", "ZMAX"];
/// Most characters of a name: two of 80 are for the prefix of surfaces and materials.
const LONGEST_NAME: usize = 78;
/// Most numbers in a line of a set.
const IN_LINE: usize = 12;

/// Refuses a material of which only half is known.
fn check_materials(names: &[Named], flags: &[u8]) -> Result<()> {
    for named in names.iter().filter(|named| flags.contains(&named.flag)) {
        let (has, lacks) = match (named.material.youngs_modulus, named.material.nu) {
            (Some(_), None) => ("E", "nu"),
            (None, Some(_)) => ("nu", "E"),
            _ => continue,
        };
        let message = format!("{} has {has} and no {lacks}, and an Abaqus file needs both", said(names, named.flag));
        return Err(Error::new(
            "export-material",
            message,
            "say both: on the command line FILE:E=2.1e11,nu=0.3, in a job material = { E = 2.1e11, nu = 0.3 }",
        ));
    }
    Ok(())
}

async fn write(job: &Export<'_>, name: &str, files: &mut dyn Files) -> Result<()> {
    let keeps = job.options.selection(job.mesh, false)?;
    let unit = metres(job.mesh.unit(), "an Abaqus file")?;
    let n_cells: u64 = (0..256).filter(|&flag| keeps[flag]).map(|flag| job.mesh.columns().cells_per_flag()[flag]).sum();
    let mut n_points = 0u64;
    for_each_layer(job, &keeps, &mut |layer| {
        layer.for_each_point(|_, _| {
            n_points += 1;
            Ok(())
        })
    })
    .await?;
    if n_cells.max(n_points) > MAX_NUMBER {
        let message = format!("{n_cells} elements and {n_points} nodes: Abaqus numbers up to {MAX_NUMBER}");
        return Err(Error::new("export-too-large", message, "export fewer flags, or mesh with larger cells"));
    }
    let lines =
        [0, 1, 2].map(|axis| job.mesh.lines().list(axis).into_iter().map(|line| unit.metres(line)).collect::<Vec<_>>());
    let deck = Deck { job, keeps: &keeps, names: names(job.mesh, LONGEST_NAME, &TAKEN) };
    let mut out = Out::create(files, name)?;
    out.text(format_args!(
        "*HEADING\nhexcast {}: {n_cells} elements, {n_points} nodes, in metres\n*NODE, NSET=NALL\n",
        env!("CARGO_PKG_VERSION")
    ))?;
    for_each_layer(job, &keeps, &mut |layer| {
        let z = lines[2][layer.z as usize];
        layer.for_each_point(|[x, y], point| {
            out.text(format_args!("{}, {:.12e}, {:.12e}, {z:.12e}\n", point + 1, lines[0][x], lines[1][y]))
        })
    })
    .await?;
    deck.elements(&mut out).await?;
    deck.sides(&mut out).await?;
    deck.surfaces(&mut out).await?;
    if job.options.patches != PatchNames::Side {
        deck.patches(&mut out).await?;
    }
    out.finish()
}

struct Deck<'a> {
    job: &'a Export<'a>,
    keeps: &'a [bool; 256],
    names: Vec<String>,
}

impl Deck<'_> {
    /// Flags with elements.
    fn flags(&self) -> impl Iterator<Item = u8> {
        let cells = self.job.mesh.columns().cells_per_flag();
        (0..=255u8).filter(move |&flag| self.keeps[usize::from(flag)] && cells[usize::from(flag)] > 0)
    }

    async fn elements(&self, out: &mut Out<'_>) -> Result<()> {
        for wanted in self.flags() {
            let name = &self.names[usize::from(wanted)];
            out.text(format_args!("*ELEMENT, TYPE=C3D8I, ELSET={name}\n"))?;
            for_each_layer(self.job, self.keeps, &mut |layer| {
                layer.for_each_cell(|cell, flag, number| {
                    if flag != wanted {
                        return Ok(());
                    }
                    let [a, b, c, d, e, f, g, h] = layer.corners(cell).map(|point| point + 1);
                    out.text(format_args!("{}, {a}, {b}, {c}, {d}, {e}, {f}, {g}, {h}\n", number + 1))
                })
            })
            .await?;
        }
        for flag in self.flags() {
            let named = self.job.mesh.names().iter().find(|named| named.flag == flag);
            let material = named.map_or(Material::default(), |named| named.material);
            let name = &self.names[usize::from(flag)];
            let (Some(modulus), Some(nu)) = (material.youngs_modulus, material.nu) else {
                out.text(format_args!("** {name}: the job has no E and nu, so there is no section here\n"))?;
                continue;
            };
            out.text(format_args!("*MATERIAL, NAME=M_{name}\n*ELASTIC\n{modulus:.12e}, {nu:.12e}\n"))?;
            if let Some(density) = material.density {
                out.text(format_args!("*DENSITY\n{density:.12e}\n"))?;
            }
            out.text(format_args!("*SOLID SECTION, ELSET={name}, MATERIAL=M_{name}\n"))?;
        }
        Ok(())
    }

    async fn sides(&self, out: &mut Out<'_>) -> Result<()> {
        let [nx, ny, nz] = self.job.mesh.dims();
        for (side, name) in SIDE_NAMES.into_iter().enumerate() {
            let n = [nx, ny, nz][side / 2];
            let line = if side % 2 == 0 { 0 } else { n };
            let mut set = Set { head: format!("*NSET, NSET={name}\n"), n: 0 };
            for_each_layer(self.job, self.keeps, &mut |layer| {
                layer.for_each_point(|[x, y], point| {
                    let at = [x as u32, y as u32, layer.z][side / 2];
                    if at == line { set.put(out, point + 1) } else { Ok(()) }
                })
            })
            .await?;
            set.finish(out)?;
        }
        Ok(())
    }

    async fn surfaces(&self, out: &mut Out<'_>) -> Result<()> {
        for wanted in self.flags() {
            out.text(format_args!("*SURFACE, NAME=S_{}, TYPE=ELEMENT\n", self.names[usize::from(wanted)]))?;
            for_each_layer(self.job, self.keeps, &mut |layer: &Layer| {
                layer.for_each_cell(|cell, flag, number| {
                    if flag != wanted {
                        return Ok(());
                    }
                    let mut outer = (0..N_SIDES).filter(|&side| layer.neighbour(cell, side) != Some(flag));
                    outer.try_for_each(|side| out.text(format_args!("{}, S{}\n", number + 1, FACES[side])))
                })
            })
            .await?;
        }
        Ok(())
    }
}

impl Deck<'_> {
    /// The surfaces of each flag by patches.
    async fn patches(&self, out: &mut Out<'_>) -> Result<()> {
        let patches = Patches::new(self.job, &SIDE_NAMES, LONGEST_NAME);
        let mut used = BTreeSet::new();
        for_each_layer(self.job, self.keeps, &mut |layer| {
            layer.for_each_cell(|cell, flag, _| {
                let outer = (0..N_SIDES).filter(|&side| layer.neighbour(cell, side) != Some(flag));
                used.extend(outer.map(|side| (flag, patches.of(layer, cell, side))));
                Ok(())
            })
        })
        .await?;
        let wanted =
            used.iter().map(|&(flag, patch)| format!("{}_{}", self.names[usize::from(flag)], patches.name(patch)));
        let taken: Vec<&str> = self.flags().map(|flag| self.names[usize::from(flag)].as_str()).collect();
        for (&wanted, name) in used.iter().zip(unique(wanted, LONGEST_NAME, &taken)) {
            out.text(format_args!("*SURFACE, NAME=S_{name}, TYPE=ELEMENT\n"))?;
            for_each_layer(self.job, self.keeps, &mut |layer: &Layer| {
                layer.for_each_cell(|cell, flag, number| {
                    let mut of_patch = (0..N_SIDES).filter(|&side| {
                        layer.neighbour(cell, side) != Some(flag) && (flag, patches.of(layer, cell, side)) == wanted
                    });
                    of_patch.try_for_each(|side| out.text(format_args!("{}, S{}\n", number + 1, FACES[side])))
                })
            })
            .await?;
        }
        Ok(())
    }
}

/// A set of numbers, some in a line; nothing where it stays empty.
struct Set {
    head: String,
    n: usize,
}

impl Set {
    fn put(&mut self, out: &mut Out, number: u64) -> Result<()> {
        if self.n == 0 {
            out.put(self.head.as_bytes())?;
        }
        let before = if self.n == 0 {
            ""
        } else if self.n.is_multiple_of(IN_LINE) {
            ",\n"
        } else {
            ", "
        };
        self.n += 1;
        out.text(format_args!("{before}{number}"))
    }

    fn finish(self, out: &mut Out) -> Result<()> {
        if self.n == 0 { Ok(()) } else { out.put(b"\n") }
    }
}
