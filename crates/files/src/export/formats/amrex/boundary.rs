//! The embedded boundary of a fluid: what AMReX can hold of its cut cells, and on which side of its surface nodes are.
//!
//! Mesh, [`Outline`] with its parts -> [`Boundary`].
//!
//! # Theory
//! A cell has one body of fluid and one surface. Cells with several bodies, where corners on one side are not joined by edges, are covered, as AMReX does. A cell whose corners all are fluid is whole, and one without a corner in it
//! is covered; likewise a face and an edge. All other numbers are exact. Nodes at a covered cell or face have no fluid, so a cell that is whole beside it gets a wall; a cell with one open face, or no node in the fluid, is covered in
//! turn, until nothing changes.
//!
//! Source: AMReX, `AMReX_EB2_3D_C.cpp`, for the rules.

use std::collections::BTreeSet;

use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_derived::mesh::outline::{Outline, OutlineCell, OutlinePart};
use hexcast_derived::mesh::{Mesh, SLAB_BYTES};

use super::grid::Grid;

/// Rounding of areas and lengths.
pub(super) const ROUNDING: f64 = 1e-12;
/// Cells with less of the fluid are covered.
pub(super) const LEAST: f64 = 1e-6;

/// What of a cell is fluid.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Kind {
    Covered,
    Whole,
    Cut,
}

/// On which side a node is.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Node {
    Solid,
    Fluid,
    /// Within the fluid, at what is covered.
    Shut,
}

/// How much the boundary lacks.
#[derive(Default)]
struct Lacks {
    /// Cut cells that are covered, and the volume of fluid in them, in cells.
    covered: u64,
    volume: f64,
    /// Cells that are all fluid although a part is not.
    filled: u64,
}

pub(super) struct Boundary<'a> {
    pub(super) dims: [i32; 3],
    pub(super) size: [f64; 3],
    pub(super) outline: &'a Outline,
    pub(super) kinds: Vec<Kind>,
    nodes: Vec<Node>,
    lacks: Lacks,
}

impl<'a> Boundary<'a> {
    /// # Errors
    /// Those of [`Mesh::for_each_slab`].
    pub(super) fn new(mesh: &Mesh, outline: &'a Outline, control: &Control) -> Result<Boundary<'a>> {
        let (lines, dims) = (mesh.lines(), mesh.dims().map(|n| n as i32));
        let mut kinds = Vec::with_capacity(mesh.n_cells() as usize);
        mesh.for_each_slab(SLAB_BYTES, control, |flags| {
            kinds.extend(flags.iter().map(|&flag| if flag == outline.fluid { Kind::Whole } else { Kind::Covered }));
            Ok(())
        })?;
        let size = [0, 1, 2].map(|axis| lines.cell_size(axis, 0));
        let mut found = Boundary { dims, size, outline, kinds, nodes: Vec::new(), lacks: Lacks::default() };
        found.find_nodes();
        let cells = outline.cells.iter().zip(&outline.parts);
        let kinds_of: Vec<Kind> = cells.map(|(cell, part)| found.kind_of(cell, part)).collect();
        for (cell, kind) in outline.cells.iter().zip(kinds_of) {
            found.set(cell.cell as usize, kind);
        }
        found.close();
        Ok(found)
    }

    /// Says what AMReX cannot hold.
    pub(super) fn lacks(&self) -> Option<String> {
        let Lacks { covered, volume, filled } = self.lacks;
        let of = self.outline.cells.len();
        (covered + filled > 0).then(|| {
            format!(
                "of {of} cut cells {covered} are covered, with {volume:.3} cells of the fluid, and {filled} are all fluid: what is thinner than a cell, or divides one, AMReX cannot hold; use smaller cells to have it"
            )
        })
    }

    /// Whether all nodes of some cells are fluid, or none; None where some are.
    pub(super) fn is_all_fluid(&self, grid: Grid) -> Option<bool> {
        let low = [0, 1, 2].map(|axis| grid.low[axis].max(0));
        let high = [0, 1, 2].map(|axis| (grid.high[axis] + 1).min(self.dims[axis]));
        let first = self.node(low) == Node::Fluid;
        let is_same = (low[2]..=high[2]).all(|z| {
            (low[1]..=high[1]).all(|y| (low[0]..=high[0]).all(|x| (self.node([x, y, z]) == Node::Fluid) == first))
        });
        is_same.then_some(first)
    }

    /// The kind of a cut cell, before those beside it are known.
    fn kind_of(&self, cell: &OutlineCell, part: &OutlinePart) -> Kind {
        let is_fluid = cell.corners.map(|flag| flag == self.outline.fluid);
        let bodies = |side: bool| {
            let is_joined = |edge: usize| match side {
                true => part.lengths[edge] > 1.0 - ROUNDING,
                false => part.lengths[edge] < ROUNDING,
            };
            bodies(is_fluid.map(|is| is == side), is_joined)
        };
        let is_divided = bodies(true) > 1 || bodies(false) > 1 || has_two_pairs(is_fluid);
        match is_fluid.iter().filter(|is| **is).count() {
            0 => Kind::Covered,
            _ if is_divided => Kind::Covered,
            8 => Kind::Whole,
            _ if part.fraction < LEAST => Kind::Covered,
            _ => Kind::Cut,
        }
    }

    /// Gives a cell of the outline its kind, and counts what that loses.
    fn set(&mut self, index: usize, kind: Kind) {
        self.kinds[index] = kind;
        let fraction = self.listed(index).map_or(1.0, |at| self.outline.parts[at].fraction);
        if kind == Kind::Covered && fraction >= LEAST {
            self.lacks.covered += 1;
            self.lacks.volume += fraction;
        } else if kind == Kind::Whole && fraction < 1.0 - LEAST {
            self.lacks.filled += 1;
        }
    }

    fn find_nodes(&mut self) {
        let [nx, ny, nz] = self.dims;
        let outline = self.outline;
        let of = |is_fluid: bool| if is_fluid { Node::Fluid } else { Node::Solid };
        let mut nodes = Vec::with_capacity((nx as usize + 1) * (ny as usize + 1) * (nz as usize + 1));
        for z in 0..=nz {
            for y in 0..=ny {
                for x in 0..=nx {
                    // where a cell at the node is cut, that decides below
                    let cell = self.index([x.min(nx - 1), y.min(ny - 1), z.min(nz - 1)]);
                    nodes.push(of(self.kinds[cell] == Kind::Whole));
                }
            }
        }
        self.nodes = nodes;
        for cell in &outline.cells {
            let at = self.place(cell.cell as usize);
            for (corner, &flag) in cell.corners.iter().enumerate() {
                let node = self.node_index(corner_at(at, corner));
                self.nodes[node] = of(flag == outline.fluid);
            }
        }
    }

    /// Shuts nodes at what is covered, and covers cells that have no room left, until nothing changes.
    fn close(&mut self) {
        let mut cells: BTreeSet<usize> = BTreeSet::new();
        self.outline.cells.iter().for_each(|cell| self.add_around(cell.cell as usize, &mut cells));
        while !cells.is_empty() {
            let mut next = BTreeSet::new();
            for &cell in &cells {
                if self.shut(cell) {
                    self.add_around(cell, &mut next);
                }
            }
            for &cell in cells.iter().filter(|&&cell| self.kinds[cell] != Kind::Covered).collect::<Vec<_>>() {
                let kind = self.closed(cell);
                if kind != self.kinds[cell] {
                    self.set(cell, kind);
                    self.add_around(cell, &mut next);
                }
            }
            cells = next;
        }
    }

    /// Shuts the nodes in the fluid at a covered cell, and at covered faces; returns whether there were any.
    fn shut(&mut self, cell: usize) -> bool {
        let at = self.place(cell);
        let areas = self.areas(at);
        let is_covered = self.kinds[cell] == Kind::Covered;
        let is_at = |corner: usize| (0..6).any(|face| areas[face] == 0.0 && corner >> (face / 2) & 1 == face % 2);
        let mut is_some = false;
        for corner in (0..8).filter(|&corner| is_covered || is_at(corner)) {
            let node = self.node_index(corner_at(at, corner));
            if self.nodes[node] == Node::Fluid {
                self.nodes[node] = Node::Shut;
                is_some = true;
            }
        }
        is_some
    }

    /// The kind of a cell that is not covered, by what is around it.
    fn closed(&self, cell: usize) -> Kind {
        let at = self.place(cell);
        let areas = self.areas(at);
        let n_open = areas.iter().filter(|area| **area > 0.0).count();
        let is_closed = (0..3).all(|axis| (areas[2 * axis] - areas[2 * axis + 1]).abs() < ROUNDING);
        let is_open = areas.iter().all(|area| *area == 1.0);
        let has_node = (0..8).any(|corner| self.is_fluid(corner_at(at, corner)));
        match self.kinds[cell] {
            _ if n_open < 2 || !has_node => Kind::Covered,
            _ if is_open => Kind::Whole,
            // two walls that cancel
            _ if is_closed => Kind::Covered,
            kind => kind,
        }
    }

    fn areas(&self, at: [i32; 3]) -> [f64; 6] {
        [0, 1, 2, 3, 4, 5].map(|face| {
            let (axis, side) = (face / 2, (face % 2) as i32);
            self.face(axis, [0, 1, 2].map(|other| at[other] + i32::from(other == axis) * side)).of
        })
    }

    fn add_around(&self, cell: usize, cells: &mut BTreeSet<usize>) {
        let at = self.place(cell);
        let ranges = [0, 1, 2].map(|axis| (at[axis] - 1).max(0)..=(at[axis] + 1).min(self.dims[axis] - 1));
        for z in ranges[2].clone() {
            for y in ranges[1].clone() {
                cells.extend(ranges[0].clone().map(|x| self.index([x, y, z])));
            }
        }
    }

    pub(super) fn listed(&self, cell: usize) -> Option<usize> {
        self.outline.cells.binary_search_by_key(&(cell as u64), |listed| listed.cell).ok()
    }

    pub(super) fn index(&self, at: [i32; 3]) -> usize {
        let [x, y, z] = at.map(|of| of as usize);
        x + self.dims[0] as usize * (y + self.dims[1] as usize * z)
    }

    fn place(&self, cell: usize) -> [i32; 3] {
        let [nx, ny, _] = self.dims.map(|n| n as usize);
        [cell % nx, cell / nx % ny, cell / nx / ny].map(|of| of as i32)
    }

    fn node_index(&self, at: [i32; 3]) -> usize {
        let [x, y, z] = at.map(|of| of as usize);
        let [nx, ny, _] = self.dims.map(|n| n as usize + 1);
        x + nx * (y + ny * z)
    }

    pub(super) fn node(&self, at: [i32; 3]) -> Node {
        self.nodes[self.node_index(at)]
    }

    pub(super) fn is_fluid(&self, at: [i32; 3]) -> bool {
        self.node(at) == Node::Fluid
    }
}

fn corner_at(at: [i32; 3], corner: usize) -> [i32; 3] {
    [0, 1, 2].map(|axis| at[axis] + (corner >> axis & 1) as i32)
}

/// How many bodies some corners of a cell are in, that edges join.
fn bodies(is_in: [bool; 8], is_joined: impl Fn(usize) -> bool) -> usize {
    let mut body: [usize; 8] = std::array::from_fn(|corner| corner);
    for edge in 0..12 {
        let (along, place) = (edge / 4, edge % 4);
        let [first, second] = [[1, 2], [0, 2], [0, 1]][along];
        let low = (place & 1) << first | (place >> 1) << second;
        let high = low | 1 << along;
        if is_in[low] && is_in[high] && is_joined(edge) {
            let (from, to) = (body[high], body[low]);
            body.iter_mut().filter(|of| **of == from).for_each(|of| *of = to);
        }
    }
    let bodies: BTreeSet<usize> = (0..8).filter(|&corner| is_in[corner]).map(|corner| body[corner]).collect();
    bodies.len()
}

/// Whether two corners of a face that are across from each other are in the fluid, and the two others are not.
fn has_two_pairs(is_fluid: [bool; 8]) -> bool {
    (0..6).any(|face| {
        let corners: Vec<bool> =
            (0..8).filter(|corner| corner >> (face / 2) & 1 == face % 2).map(|corner| is_fluid[corner]).collect();
        corners[0] == corners[3] && corners[1] == corners[2] && corners[0] != corners[1]
    })
}
