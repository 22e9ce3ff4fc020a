//! Walls: whose facets made the faces between cells of different flags, and those at the sides of the box.
//!
//! # Theory
//! The link between the centres of the two cells of a face crosses the surface that parts them; at a side of the box it leads to the mirror image
//! of the centre, as for the sheets of staggered grids. The facet names the wall: by its solid where the geometry has several, else by its geometry.
//! Several facets may cross a link: then that of the geometry counts which has one of the two flags, of two the one of the higher rank, and of its facets the
//! first. Where none crosses, as at cells that the rays of one axis do not decide or at a box that cuts a body, the face has no wall.
//!
//! # Practice
//! Facets are found before the mesh, faces are kept once the flags are known: [`Candidates`], then [`Walls`].
//! Cost: a cast along each axis, on the CPU; 24 bytes for each crossing of a link, then 16 for each face.

use crate::staggered::{Coded, under};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::sort::sort_by_key;
use hexcast_core::cells::columns::Columns;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::rays::Rays;
use hexcast_core::input::geometry::Geometry;
use hexcast_core::input::job::Rule;
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::cpu::Strips;

/// Bytes of a crossing while they are put in order.
const BYTES_OF_CROSSING: u64 = 48;

/// The walls of a mesh.
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Walls {
    /// Their names: those of solids, or of geometries whose files name no solids.
    pub names: Vec<String>,
    /// The faces across x, y and z that have one, in order, x fastest: index of the face, a line along its axis and a cell along the others, and of its name.
    pub(crate) faces: [Vec<([u32; 3], u32)>; 3],
}

impl Walls {
    /// Index in `names` of the wall of a face across an axis.
    pub fn wall(&self, axis: usize, face: [u32; 3]) -> Option<u32> {
        let key = |[x, y, z]: [u32; 3]| (z, y, x);
        let faces = &self.faces[axis];
        let at = faces.binary_search_by_key(&key(face), |(face, _)| key(*face)).ok()?;
        Some(faces[at].1)
    }
}

/// A link that a facet crosses.
struct Crossed {
    face: [u32; 3],
    /// Position of its geometry.
    position: u16,
    wall: u32,
    facet: u32,
}

/// The facets that cross links, counted from the first cell that is meshed.
#[doc(hidden)]
pub struct Candidates {
    names: Vec<String>,
    across: [Vec<Crossed>; 3],
    flag_at: Vec<u8>,
}

impl Candidates {
    /// Those of some cells of the box, the first and the end, exclusive; `frame` has all facets.
    ///
    /// # Errors
    /// `cancelled`; `memory` where they would take more than `max_bytes`.
    #[doc(hidden)]
    pub fn new(
        frame: &Frame,
        geometries: &[Geometry],
        cells: [[u32; 3]; 2],
        (max_bytes, control): (u64, &Control),
    ) -> Result<Candidates> {
        let (names, first_of) = names(geometries);
        let wall_of = |facet: usize| {
            let position = usize::from(frame.position_of_facet[facet]);
            let index = frame.ranks.geometry_at[position];
            let in_geometry = (facet - frame.range_at(position).start) as u64;
            (position as u16, first_of[index] + geometries[index].solid_of(in_geometry) as u32)
        };
        let (mut across, mut n) = ([const { Vec::new() }; 3], 0);
        for (axis, found) in across.iter_mut().enumerate() {
            for_each_crossing(frame, (axis, cells), control, &mut |face, facet| {
                let (position, wall) = wall_of(facet as usize);
                found.push(Crossed { face, position, wall, facet });
                n += 1;
                check_bytes(n, max_bytes)
            })?;
            sort_by_key(found, |of| {
                let [x, y, z] = of.face;
                (z, y, x, u16::MAX - of.position, of.facet)
            });
        }
        let flag_at = frame.ranks.geometry_at.iter().map(|&index| geometries[index].flag).collect();
        Ok(Candidates { names, across, flag_at })
    }

    /// Keeps what lies between different flags, and at the sides of the box; `moved` counts a face from the first cell of the mesh.
    ///
    /// # Errors
    /// `io` where columns are in a store that fails.
    #[doc(hidden)]
    pub fn walls(self, columns: &Columns, moved: impl Fn([u32; 3]) -> [u32; 3]) -> Result<Walls> {
        let mut faces = [const { Vec::new() }; 3];
        for (axis, found) in self.across.iter().enumerate() {
            let n = columns.dims()[axis];
            let mut first: Vec<&[Crossed]> = found.chunk_by(|one, other| one.face == other.face).collect();
            let beside = |side: u32| {
                let cell = |of: &&[Crossed]| {
                    let mut cell = of[0].face;
                    cell[axis] = (cell[axis] + side).saturating_sub(1).min(n - 1);
                    (cell, 0)
                };
                under(columns, &first.iter().map(cell).collect::<Vec<Coded>>())
            };
            let both: Vec<[u8; 2]> = beside(0)?.into_iter().zip(beside(1)?).map(|(one, other)| [one, other]).collect();
            for (of, flags) in first.drain(..).zip(both) {
                let is_end = of[0].face[axis] == 0 || of[0].face[axis] == n;
                if flags[0] == flags[1] && !is_end {
                    continue;
                }
                let has_flag = |crossed: &&Crossed| flags.contains(&self.flag_at[usize::from(crossed.position)]);
                let Some(crossed) = of.iter().find(has_flag).or(of.first()) else { continue };
                faces[axis].push((moved(crossed.face), crossed.wall));
            }
        }
        Ok(Walls { names: self.names, faces })
    }
}

/// Calls `visit` with each face across an axis whose link a facet crosses, and the facet.
fn for_each_crossing(
    frame: &Frame,
    (axis, [first, mut end]): (usize, [[u32; 3]; 2]),
    control: &Control,
    visit: &mut dyn FnMut([u32; 3], u32) -> Result<()>,
) -> Result<()> {
    let n_faces = end[axis] - first[axis] + 1;
    let mut frame = frame.clone().with_mirrored_ends(axis);
    let mut indices = None;
    end[axis] += 2;
    if [first, end] != [[0; 3], frame.dims] {
        let (window, of_facets) = frame.window_along(axis, [first, end]);
        (frame, indices) = (window, Some(of_facets));
    }
    let rays = Rays::new(axis, frame.dims);
    let mut strips = Strips::new(&Cast { frame: &frame, rays: &rays, rule: Rule::Parity }, None);
    let n_across = u64::from(rays.counts[0]);
    while let Some(crossings) = strips.crossings(true, control)? {
        for some in &crossings {
            for (ray, ends) in (some.first_ray..).zip(some.offsets.windows(2)) {
                let across = [(ray % n_across) as u32, (ray / n_across) as u32];
                for at in ends[0] as usize..ends[1] as usize {
                    // the first centre above is behind the face, and one more is before the first
                    let centre = some.events[at] >> 9;
                    if (1..=n_faces).contains(&centre) {
                        let facet = some.facets[at];
                        let facet = indices.as_ref().map_or(facet, |indices: &Vec<u32>| indices[facet as usize]);
                        visit(rays.cell([across[0], across[1], centre - 1]), facet)?;
                    }
                }
            }
        }
    }
    Ok(())
}

/// The names of all walls, and which is the first of each geometry.
#[doc(hidden)]
pub fn names(geometries: &[Geometry]) -> (Vec<String>, Vec<u32>) {
    let (mut names, mut first_of): (Vec<String>, Vec<u32>) = (Vec::new(), Vec::new());
    for geometry in geometries {
        first_of.push(names.len() as u32);
        if geometry.solids.len() < 2 {
            names.push(geometry.name.clone());
            continue;
        }
        for (number, (_, solid)) in (1..).zip(&geometry.solids) {
            names.push(if solid.is_empty() { format!("{}_{number}", geometry.name) } else { solid.clone() });
        }
    }
    (names, first_of)
}

/// Refuses more crossings than memory holds.
fn check_bytes(n: u64, max_bytes: u64) -> Result<()> {
    if BYTES_OF_CROSSING * n <= max_bytes {
        return Ok(());
    }
    let n_bytes = BYTES_OF_CROSSING * n;
    let message =
        format!("{n} faces of walls or more take {n_bytes} bytes: {max_bytes} are left of the memory allowed");
    let hint = "allow more with max_memory (--max-memory), use larger cells, or leave out --patches solid";
    Err(Error::new("memory", message, hint))
}
