//! Signed distances: how far each cell centre, or each node, is from the nearest surface, negative inside.
//!
//! Facets in world coordinates, codes of the points -> [`Distance`], whose numbers are made when they are asked for.
//!
//! # Theory
//! A number is the distance to the nearest facet as the file has it, unsnapped: exact but for rounding in 64 bits. Its sign is no question of normals: it is that of the cells,
//! by the same rays, also at edges, corners, and surfaces that are not closed. So it is never another than that of the mesh.
//!
//! All surfaces count, also those between two geometries or within one. Outside, a number is the distance to all geometries together; inside, to the nearest of
//! their surfaces. Who wants that of some alone names their flags: then the others are not there.
//!
//! # Practice
//! Within a band around the surfaces numbers are exact; beyond it they are its width. A narrow band is scanned from the surface (`scan.rs`); in a wide one, and where all numbers
//! are asked for, points look for what is nearest (`blocks.rs`).
//! Cost: some 130 bytes a facet, 190 where it is scanned, and columns of the points. Numbers take eight bytes each while they are written.

mod blocks;
mod facet;
mod features;
mod scan;
#[cfg(test)]
mod tests;
mod tree;

use std::sync::Arc;

use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::parallel::*;
use hexcast_core::cells::columns::Columns;
use hexcast_core::cells::flags::{CellBox, flags_of_box};
use hexcast_core::grid::lines::Lines;
use hexcast_core::input::geometry::Geometry;

use blocks::{Blocks, Memory};
use features::Features;
use scan::{Part, Scan};
use tree::Tree;

/// Points along y and z that a core fills together.
const TOGETHER: u32 = 32;

/// Up to as many cells a band is scanned from the surface. In a wider one many parts of a rough surface look at the same points.
const MOST_SCANNED: f64 = 16.0;

/// Signed distances of a box of points.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Distance {
    /// Largest distance that is known, in the unit of the files; infinite where all are.
    pub width: f64,
    /// Whether the points are the nodes of the mesh in place of the centres of its cells.
    pub of_nodes: bool,
    /// The cell of the first point, counted in the box: 0 but for windows.
    pub origin: [u32; 3],
    tree: Arc<Tree>,
    /// Where the band is narrow.
    features: Option<Arc<Features>>,
    places: [Vec<f64>; 3],
    /// Codes of the points: 0, or rank + 1 of the geometry.
    codes: Columns,
    is_inside: Vec<bool>,
}

/// Which points have distances, and up to which.
#[doc(hidden)]
pub struct Asked {
    /// Cells of the box: the first and the end, exclusive.
    pub window: [[u32; 3]; 2],
    /// Whether the points are nodes.
    pub of_nodes: bool,
    /// Largest distance in cells, the largest along its longest edge; None for all.
    pub band: Option<f64>,
}

impl Distance {
    /// Takes the facets of some geometries. `codes` has 0 or rank + 1 of all points, of which ranks with another flag than 0 are inside.
    ///
    /// # Errors
    /// `memory` where facets stay in their file, or would take more than `max_bytes`.
    #[doc(hidden)]
    pub fn new<'a>(
        lines: &Lines,
        asked: &Asked,
        geometries: impl Iterator<Item = &'a Geometry> + Clone,
        (codes, flag_of_rank): (Columns, &[u8]),
        max_bytes: u64,
    ) -> Result<Distance> {
        let n_facets = geometries.clone().map(|geometry| geometry.facets.len() as u64).sum::<u64>();
        let is_scanned = asked.band.is_some_and(|band| band <= MOST_SCANNED);
        let n_bytes = Tree::n_bytes(n_facets) + if is_scanned { Features::n_bytes(n_facets) } else { 0 };
        if n_bytes > max_bytes {
            let message = format!(
                "distances to {n_facets} facets take {n_bytes} bytes: {max_bytes} are left of the memory allowed"
            );
            let hint = "allow more with max_memory (--max-memory), or simplify the surfaces";
            return Err(Error::new("memory", message, hint));
        }
        let mut facets = Vec::with_capacity(n_facets as usize);
        for geometry in geometries {
            let placing = geometry.placing();
            facets.par_extend(geometry.facets.in_memory("distances")?.par_iter().map(|facet| facet.map(&placing)));
        }
        let Asked { window: [first, end], of_nodes, band } = *asked;
        let places = [0, 1, 2].map(|axis| match of_nodes {
            true => (first[axis]..=end[axis]).map(|line| lines.line(axis, line)).collect(),
            false => (first[axis]..end[axis]).map(|cell| lines.centre(axis, cell)).collect(),
        });
        let is_inside = [0].iter().chain(flag_of_rank).map(|flag| *flag != 0).collect();
        let width = band.map_or(f64::INFINITY, |cells| cells * longest_edge(lines));
        let tree = Tree::new(facets);
        let features = is_scanned.then(|| Arc::new(Features::new(tree.facets())));
        Ok(Distance { width, of_nodes, origin: first, tree: Arc::new(tree), features, places, codes, is_inside })
    }

    /// Number of points on each axis.
    pub fn dims(&self) -> [u32; 3] {
        self.codes.dims()
    }

    /// Number of facets whose distances count.
    pub fn n_facets(&self) -> u64 {
        self.tree.n_facets()
    }

    /// The distances of a box of points, x fastest, in the unit of the files: negative inside.
    ///
    /// # Errors
    /// `io` where the flags of the points are in a store that fails.
    pub fn distances(&self, some: &CellBox) -> Result<Vec<f64>> {
        let codes = flags_of_box(&*self.codes.for_slab(&some[self.codes.rays().axis])?, some)?;
        let mut distances = on_all_cores(|| self.unsigned(some));
        for (distance, code) in distances.iter_mut().zip(&codes) {
            *distance = if self.is_inside[usize::from(*code)] { -*distance } else { *distance };
        }
        Ok(distances)
    }

    fn unsigned(&self, some: &CellBox) -> Vec<f64> {
        let [nx, ny, nz] = [0, 1, 2].map(|axis| some[axis].len());
        let of = |axis: usize, from: usize, n: usize| &self.places[axis][some[axis].start as usize + from..][..n];
        let n_across = (ny as u32).div_ceil(TOGETHER).max(1);
        let starts = |number: u32| [number % n_across, number / n_across].map(|at| (at * TOGETHER) as usize);
        let n_of = |start: usize, n: usize| (n - start).min(TOGETHER as usize);
        let filled = map_within(0..n_across * (nz as u32).div_ceil(TOGETHER), |memory: &mut (Memory, Part), number| {
            let [y, z] = starts(number);
            let places = [of(0, 0, nx), of(1, y, n_of(y, ny)), of(2, z, n_of(z, nz))];
            let (tree, width) = (&self.tree, self.width);
            match &self.features {
                Some(features) => Scan { tree, features, width, places }.distances(&mut memory.1),
                None => Blocks { tree, width, places }.distances(&mut memory.0),
            }
        });
        let mut distances = vec![0.0; nx * ny * nz];
        for (number, of_some) in (0u32..).zip(filled) {
            let [y, z] = starts(number);
            let n_down = n_of(y, ny);
            for (row, of_row) in of_some.chunks_exact(nx.max(1)).enumerate() {
                let at = nx * (y + row % n_down + ny * (z + row / n_down));
                distances[at..at + nx].copy_from_slice(of_row);
            }
        }
        distances
    }
}

/// The longest edge of a cell.
fn longest_edge(lines: &Lines) -> f64 {
    let along = |axis: usize| (0..lines.dims()[axis]).map(move |cell| lines.cell_size(axis, cell));
    (0..3).flat_map(along).fold(0.0, f64::max)
}
