//! Patches: how faces at the boundary of the exported cells are grouped, and what groups are called.
//!
//! A face lies at a side of the box or beside a cell that is not exported. By side, the groups are the six sides and the flags beside the cells; by
//! neighbour, all sides of the box are one group; by solid, a face has the name of the solid whose facet made it, and where none did, its name by side.

use super::layers::{Layer, N_SIDES, SIDES, for_each_layer};
use super::names::{names, unique};
use super::options::{ExportOptions, PatchNames};
use super::output::Export;
use hexcast_core::base::error::{Error, Result};
use hexcast_derived::mesh::Mesh;

/// Names of the sides of the box where a program has none of its own.
const SIDE_NAMES: [&str; N_SIDES] = ["xMin", "xMax", "yMin", "yMax", "zMin", "zMax"];
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
        let walls = match (&job.mesh.walls(), by) {
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
        if let Some(walls) = self.job.mesh.walls().as_ref().filter(|_| self.by == PatchNames::Solid) {
            let mut face = [cell[0] as u32, cell[1] as u32, layer.z];
            face[side / 2] += (side % 2) as u32;
            if let Some(wall) = walls.wall(side / 2, face) {
                return WALLS + wall as usize;
            }
        }
        self.of_flag(side, neighbour)
    }

    /// The group of a face at a side of the box, or beside a flag.
    fn of_flag(&self, side: usize, flag: Option<u8>) -> usize {
        match flag {
            None if self.by == PatchNames::Neighbour => OUTSIDE,
            None => side,
            Some(flag) => FLAGS + usize::from(flag),
        }
    }

    /// The group of a face of a cut cell on the surface: the flag behind it, and whose facet it is.
    pub(super) fn of_surface(&self, flag: u8, wall: u32) -> usize {
        let is_wall = self.by == PatchNames::Solid && WALLS + (wall as usize) < self.names.len();
        if is_wall { WALLS + wall as usize } else { self.of_flag(0, Some(flag)) }
    }

    /// The group of a face of a cut cell at a side of the box: by solid that of the face of the cell, else that of the first beside it that has one.
    pub(super) fn of_side(&self, side: usize, cell: [u32; 3]) -> usize {
        let walls = self.job.mesh.walls().filter(|_| self.by == PatchNames::Solid);
        let Some(walls) = walls else { return self.of_flag(side, None) };
        let axis = side / 2;
        let mut face = cell;
        face[axis] += (side % 2) as u32;
        let [first, second] = [(axis + 1) % 3, (axis + 2) % 3];
        let beside = [0, -1, 1].into_iter().flat_map(|one| [0, -1, 1].map(|other| (one, other)));
        let mut near = beside.filter_map(|(one, other)| {
            let mut near = face;
            near[first] = near[first].checked_add_signed(one)?;
            near[second] = near[second].checked_add_signed(other)?;
            walls.wall(axis, near)
        });
        near.next().map_or(self.of_flag(side, None), |wall| WALLS + wall as usize)
    }
}

/// A face of a cell of a layer, and its group.
struct Face<'a> {
    layer: &'a Layer<'a>,
    cell: [usize; 2],
    side: usize,
    patch: usize,
}

/// The faces at the boundary of exported cells, group by group.
pub(super) struct Boundary<'a> {
    pub(super) patches: Patches<'a>,
    keeps: &'a [bool; 256],
    /// Faces of each group, and the lines between which they lie.
    groups: Vec<(u64, [[u32; 3]; 2])>,
}

impl<'a> Boundary<'a> {
    /// Counts them; none where patches are named by sides, which programs without patches do not have.
    ///
    /// # Errors
    /// Those of [`for_each_layer`].
    pub(super) async fn new(job: &'a Export<'a>, keeps: &'a [bool; 256], longest: usize) -> Result<Boundary<'a>> {
        let patches = Patches::new(job, &SIDE_NAMES, longest);
        let mut groups = vec![(0, [[u32::MAX; 3], [0; 3]]); patches.len()];
        let boundary = Boundary { patches, keeps, groups: Vec::new() };
        if boundary.patches.by != PatchNames::Side {
            boundary
                .for_each(&mut |Face { layer, cell: [x, y], side, patch }| {
                    let (n, [low, high]) = &mut groups[patch];
                    *n += 1;
                    for (axis, at) in [x as u32, y as u32, layer.z].into_iter().enumerate() {
                        let is_across = axis == side / 2;
                        let [first, last] = [is_across && side % 2 == 1, !is_across || side % 2 == 1].map(u32::from);
                        (low[axis], high[axis]) = (low[axis].min(at + first), high[axis].max(at + last));
                    }
                    Ok(())
                })
                .await?;
        }
        Ok(Boundary { groups, ..boundary })
    }

    /// The groups with faces: their places, numbers of faces, and the lines between which these lie.
    pub(super) fn used(&self) -> impl Iterator<Item = (usize, u64, [[u32; 3]; 2])> {
        let groups = self.groups.iter().enumerate();
        groups.filter(|(_, (n, _))| *n > 0).map(|(patch, (n, ends))| (patch, *n, *ends))
    }

    pub(super) fn n_faces(&self) -> u64 {
        self.groups.iter().map(|(n, _)| n).sum()
    }

    /// Calls `visit` with the four corners of each face of a group, as numbers of points.
    pub(super) async fn for_each_of(&self, wanted: usize, visit: &mut dyn FnMut([u64; 4]) -> Result<()>) -> Result<()> {
        self.for_each(&mut |Face { layer, cell, side, patch }| {
            if patch != wanted {
                return Ok(());
            }
            let corners = layer.corners(cell);
            visit(SIDES[side].map(|corner| corners[corner]))
        })
        .await
    }

    async fn for_each(&self, visit: &mut dyn FnMut(Face<'_>) -> Result<()>) -> Result<()> {
        for_each_layer(self.patches.job, self.keeps, &mut |layer| {
            layer.for_each_cell(|cell, _, _| {
                let outer = |side: &usize| layer.neighbour(cell, *side).is_none_or(|flag| !layer.keeps(flag));
                (0..N_SIDES)
                    .filter(outer)
                    .try_for_each(|side| visit(Face { layer, cell, side, patch: self.patches.of(layer, cell, side) }))
            })
        })
        .await
    }
}

/// Refuses names by solids that are not known, and open patches that are no solid.
///
/// # Errors
/// `job-conflict`.
pub(super) fn check(mesh: &Mesh, options: &ExportOptions, longest: usize) -> Result<()> {
    let walls = mesh.walls();
    if walls.is_none() && options.patches == PatchNames::Solid {
        let message = "patches are to have the names of solids, and the mesh does not know which facets made its faces";
        let hint = "mesh the surfaces with this output; column files do not hold it";
        return Err(Error::new("job-conflict", message, hint));
    }
    check_open(options, walls.as_ref().map_or(&[], |walls| &walls.names[..]), longest)
}

/// Refuses open patches that are none of these solids.
///
/// # Errors
/// `job-conflict`.
pub(super) fn check_open(options: &ExportOptions, solids: &[String], longest: usize) -> Result<()> {
    let (is_by_solid, open) = (options.patches == PatchNames::Solid, &options.open_patches);
    let solids = if is_by_solid { unique(solids.iter().cloned(), longest, &[]) } else { Vec::new() };
    let Some(unknown) = open.iter().find(|name| !solids.contains(name)) else { return Ok(()) };
    let message = match is_by_solid {
        true => format!("there is no patch \"{unknown}\" to be open; those of solids are {}", solids.join(", ")),
        false => format!("the patch \"{unknown}\" is to be open, and patches do not have the names of solids"),
    };
    Err(Error::new("job-conflict", message, "name solids, and take their names for patches (--patches solid)"))
}
