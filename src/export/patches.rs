//! Patches: how faces at the boundary of the exported cells are grouped, and what groups are called.
//!
//! A face lies at a side of the box or beside a cell that is not exported. By side, the groups are the six sides and the flags beside the cells; by
//! neighbour, all sides of the box are one group; by solid, a face has the name of the solid whose facet made it, and where none did, its name by side.

use super::layers::{Layer, N_SIDES};
use super::names::{names, unique};
use super::output::Export;
use crate::error::{Error, Result};
use crate::mesh::Mesh;

/// By what faces at the boundary of exported cells are named.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum PatchNames {
    /// By the side of the box, else by the flag of the neighbour.
    #[default]
    Side,
    /// By the flag of the neighbour; all sides of the box have one name.
    Neighbour,
    /// By the solid, or else the geometry, whose facet made the face.
    Solid,
}

/// Place of the group of all sides of the box.
const OUTSIDE: usize = N_SIDES;
/// Place of the group of flag 0.
const FLAGS: usize = OUTSIDE + 1;
/// Place of the group of the first wall.
const WALLS: usize = FLAGS + 256;

/// The groups of faces.
pub(super) struct Patches<'a> {
    job: &'a Export<'a>,
    by: PatchNames,
    /// Names of all groups: the sides, the outside, the flags, the walls.
    names: Vec<String>,
}

impl<'a> Patches<'a> {
    /// `sides` are the names of the sides of the box, names have at most `longest` characters.
    pub(super) fn new(job: &'a Export<'a>, sides: &[&str; N_SIDES], longest: usize) -> Patches<'a> {
        let by = job.options.patches;
        let walls = match (&job.mesh.walls, by) {
            (Some(walls), PatchNames::Solid) => unique(walls.names.clone(), longest, sides),
            _ => Vec::new(),
        };
        let outside = if by == PatchNames::Neighbour { &["outside"][..] } else { &[] };
        let taken: Vec<&str> = sides.iter().chain(outside).copied().chain(walls.iter().map(String::as_str)).collect();
        let flags = names(job.mesh, longest, &taken);
        let names = sides.iter().map(ToString::to_string).chain(["outside".to_string()]).chain(flags).chain(walls);
        Patches { job, by, names: names.collect() }
    }

    pub(super) fn len(&self) -> usize {
        self.names.len()
    }

    pub(super) fn name(&self, patch: usize) -> &str {
        &self.names[patch]
    }

    /// Whether a fluid may flow through a patch: that is so at the sides of the box, and where the caller says it.
    pub(super) fn is_open(&self, patch: usize) -> bool {
        let said = &self.job.options.open_patches;
        patch < FLAGS || patch >= WALLS && said.iter().any(|name| *name == self.names[patch])
    }

    /// The group of the face of a cell, beside which is another flag or the outside.
    pub(super) fn of(&self, layer: &Layer, cell: [usize; 2], side: usize) -> usize {
        let neighbour = layer.neighbour(cell, side);
        if let Some(walls) = self.job.mesh.walls.as_ref().filter(|_| self.by == PatchNames::Solid) {
            let mut face = [cell[0] as u32, cell[1] as u32, layer.z];
            face[side / 2] += (side % 2) as u32;
            if let Some(wall) = walls.wall(side / 2, face) {
                return WALLS + wall as usize;
            }
        }
        match neighbour {
            None if self.by == PatchNames::Neighbour => OUTSIDE,
            None => side,
            Some(flag) => FLAGS + usize::from(flag),
        }
    }
}

/// Refuses names by solids that are not known, and open patches that are no solid.
///
/// # Errors
/// `job-conflict`.
pub(super) fn check(mesh: &Mesh, by: PatchNames, open: &[String], longest: usize) -> Result<()> {
    let solids = match (&mesh.walls, by) {
        (None, PatchNames::Solid) => {
            let message =
                "patches are to have the names of solids, and the mesh does not know which facets made its faces";
            let hint = "mesh the surfaces with this output; column files do not hold it";
            return Err(Error::new("job-conflict", message, hint));
        }
        (Some(walls), PatchNames::Solid) => unique(walls.names.clone(), longest, &[]),
        _ => Vec::new(),
    };
    let Some(unknown) = open.iter().find(|name| !solids.contains(name)) else { return Ok(()) };
    let message = match by {
        PatchNames::Solid => {
            format!("there is no patch \"{unknown}\" to be open; those of solids are {}", solids.join(", "))
        }
        _ => format!("the patch \"{unknown}\" is to be open, and patches do not have the names of solids"),
    };
    Err(Error::new("job-conflict", message, "name solids, and take their names for patches (--patches solid)"))
}
