//! Links of cells that rays do not decide: those of geometries that are not closed, of cells along surfaces, and of closed gaps.
//!
//! A link begins with the flag that its cell has in the mesh. Where no ray gives it that flag, the geometries that are decided apart and have it
//! hold the cell. Each crossing of such a geometry leads into it or out of it, whichever way its facet is turned. Links
//! whose cells differ, but which no crossing explains, are found by looking at all cells.

use super::Link;
use super::field::{Field, place};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::base::parallel::*;
use hexcast_core::cells::flags::flags_of_box;
use hexcast_core::grid::window::CellWindow;
use hexcast_core::stages::inside::{Inside, Kind};

/// Of a link that no surface crosses.
const HALFWAY: f32 = 0.5;

impl Field<'_> {
    /// Lets the geometries that are decided apart hold the first cell of a link, if its flag is theirs.
    pub(super) fn begin(&self, inside: &mut Inside, flag: u8) {
        let flag_of_rank = &self.frame.ranks.flag_of_rank;
        if self.is_plain || inside.flag(flag_of_rank) == flag {
            return;
        }
        for (rank, kind) in self.kinds.iter().enumerate() {
            if *kind == Kind::Apart && flag_of_rank[rank] == flag {
                inside.flip(rank);
            }
        }
    }

    /// Links of each plane of the window from the fluid to other flags that are not among those that were found, which are in order.
    pub(super) fn links_without_crossing(
        &self,
        found: &[Vec<Link>],
        directions: &[[i8; 3]],
        is_fluid: &[bool; 256],
        control: &Control,
    ) -> Result<Vec<Vec<Link>>> {
        let of_plane = |z: u32| {
            control.check()?;
            self.links_of_plane(z, &found[(z - self.window.first[2] + self.window.halo) as usize], directions, is_fluid)
        };
        (self.window.first[2]..self.window.end[2]).into_par_iter().map(of_plane).collect()
    }

    fn links_of_plane(
        &self,
        z: u32,
        mut found: &[Link],
        directions: &[[i8; 3]],
        is_fluid: &[bool; 256],
    ) -> Result<Vec<Link>> {
        let (CellWindow { first, end, .. }, dims) = (self.window, self.window.dims());
        let mut near = self.window.with_neighbours(self.frame.dims);
        (near[0][2], near[1][2]) = (z.saturating_sub(1), (z + 2).min(self.frame.dims[2]));
        let cells = [0, 1, 2].map(|axis| near[0][axis] - self.first[axis]..near[1][axis] - self.first[axis]);
        let flags = flags_of_box(&*self.columns.for_slab(&cells[self.columns.rays().axis])?, &cells)?;
        let flag = |cell: [u32; 3]| {
            let [x, y, z] = [0, 1, 2].map(|axis| (cell[axis] - near[0][axis]) as usize);
            flags[(z * cells[1].len() + y) * cells[0].len() + x]
        };
        let mut links = Vec::new();
        for y in first[1]..end[1] {
            for x in first[0]..end[0] {
                let of_box = [x, y, z];
                if !is_fluid[usize::from(flag(of_box))] {
                    continue;
                }
                let Some(cell) = self.window.place(of_box) else { continue };
                for (direction, step) in (0u8..).zip(directions).skip(1) {
                    let Some(other) = neighbour(of_box, *step, self.frame.dims) else { continue };
                    let flag = flag(other);
                    if is_fluid[usize::from(flag)] {
                        continue;
                    }
                    let here = place(cell, direction, dims);
                    while found.first().is_some_and(|link| place(link.cell, link.direction, dims) < here) {
                        found = &found[1..];
                    }
                    if found.first().is_none_or(|link| place(link.cell, link.direction, dims) != here) {
                        links.push(Link { cell, q: HALFWAY, facet: -1, geometry: -1, direction, flag });
                    }
                }
            }
        }
        Ok(links)
    }
}

/// The cell a step further, within the box.
fn neighbour(cell: [u32; 3], step: [i8; 3], dims: [u32; 3]) -> Option<[u32; 3]> {
    let mut other = [0; 3];
    for axis in 0..3 {
        other[axis] = cell[axis].checked_add_signed(step[axis].into()).filter(|&at| at < dims[axis])?;
    }
    Some(other)
}
