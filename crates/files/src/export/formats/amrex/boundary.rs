//! The embedded boundary of a fluid: what AMReX can hold of its cut cells, and what of each cell, face, edge and node of the box, and beyond it, is fluid.
//!
//! Mesh, [`Outline`] with its parts -> [`Boundary`].
//!
//! # Theory
//! A cell has one body of fluid and one surface. Cells with several bodies, where corners on one side are not joined by edges, are covered, as AMReX does. A cell whose corners all are fluid is whole, and one without a corner in it
//! is covered; likewise a face and an edge. All other numbers are exact. Nodes at a covered cell or face have no fluid, so a cell that is whole beside it gets a wall; a cell with one open face, or no node in the fluid, is covered in
//! turn, until nothing changes.
//!
//! *Walls*: areas of faces close with the wall's area vector, by Gauss's theorem; the centre of a wall is that of its projection along the vector, of the same sums, with the volume. Both are exact for a flat wall.
//!
//! *Beyond the box* what is at its side goes on: a cell there has what the face at the side has, past an edge of the box what the edge has, past a corner what the node has.
//!
//! Source: AMReX, `AMReX_EB2_3D_C.cpp`, for the rules; the sums of walls are its own.

use std::collections::BTreeSet;

use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_derived::mesh::outline::{Outline, OutlineCell, OutlinePart};
use hexcast_derived::mesh::{Mesh, SLAB_BYTES};

use super::Grid;

/// Rounding of areas and lengths.
const ROUNDING: f64 = 1e-12;
/// Cells with less of the fluid are covered.
const LEAST: f64 = 1e-6;

/// What of a cell is fluid.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Kind {
    Covered,
    Whole,
    Cut,
}

/// On which side a node is.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Node {
    Solid,
    Fluid,
    /// Within the fluid, at what is covered.
    Shut,
}

/// What is fluid of a cell, face, edge or node: the fraction, and its centre in cells from the middle.
#[derive(Clone, Copy, Default)]
pub(super) struct Part {
    pub(super) of: f64,
    pub(super) centre: [f64; 3],
}

/// The wall in a cell: its area in those of a face, centre in cells from the middle, and normal out of the fluid.
pub(super) struct Wall {
    pub(super) area: f64,
    pub(super) centre: [f64; 3],
    pub(super) normal: [f64; 3],
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
    size: [f64; 3],
    outline: &'a Outline,
    kinds: Vec<Kind>,
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

    /// What is fluid of the place that is a node along some axes, and spans a cell along the others.
    pub(super) fn part(&self, is_nodal: [bool; 3], mut at: [i32; 3]) -> Part {
        let mut spans = is_nodal.map(|is| !is);
        for axis in 0..3 {
            let n = self.dims[axis];
            spans[axis] &= (0..n).contains(&at[axis]);
            at[axis] = at[axis].clamp(0, n);
        }
        match spans {
            [true, true, true] => self.cell(at),
            [false, true, true] => self.face(0, at),
            [true, false, true] => self.face(1, at),
            [true, true, false] => self.face(2, at),
            [true, false, false] => self.edge(0, at),
            [false, true, false] => self.edge(1, at),
            [false, false, true] => self.edge(2, at),
            [false, false, false] => Part { of: f64::from(self.is_fluid(at)), centre: [0.0; 3] },
        }
    }

    /// The wall in a cell: of no area, where there is none.
    pub(super) fn wall(&self, at: [i32; 3]) -> Wall {
        let faces = [0, 1, 2].map(|axis| {
            let is_nodal = [0, 1, 2].map(|other| other == axis);
            [0, 1].map(|side| self.part(is_nodal, [0, 1, 2].map(|other| at[other] + i32::from(other == axis) * side)))
        });
        let vector = faces.map(|[low, high]| low.of - high.of);
        let length = norm(vector);
        if length < ROUNDING {
            return Wall { area: 0.0, centre: [-1.0; 3], normal: [0.0; 3] };
        }
        let volume = self.part([false; 3], at).of;
        let centre = [0, 1, 2].map(|axis| {
            let moment = |across: usize| match faces[across] {
                [low, high] if across == axis => volume - 0.5 * (low.of + high.of),
                [low, high] => low.of * low.centre[axis] - high.of * high.centre[axis],
            };
            let sum: f64 = (0..3).map(|across| moment(across) * vector[across]).sum();
            (sum / (length * length)).clamp(-0.5, 0.5)
        });
        let [dx, dy, dz] = self.size;
        let of_faces = [dy * dz, dx * dz, dx * dy];
        let across = [0, 1, 2].map(|axis| vector[axis] * of_faces[axis]);
        let normal = across.map(|of| of / norm(across));
        let area = norm(across) / norm([0, 1, 2].map(|axis| normal[axis] * of_faces[axis]));
        Wall { area, centre, normal }
    }

    /// The level set at a node: negative in the fluid; as large as the way along a line to the wall, at most a cell.
    pub(super) fn level(&self, at: [i32; 3]) -> f64 {
        let at = [0, 1, 2].map(|axis| at[axis].clamp(0, self.dims[axis]));
        let node = self.node(at);
        if node == Node::Shut {
            return 0.0;
        }
        let smallest = self.size.into_iter().fold(f64::INFINITY, f64::min);
        let mut way = smallest;
        for axis in 0..3 {
            for step in [-1, 0] {
                let mut low = at;
                low[axis] += step;
                if (0..self.dims[axis]).contains(&low[axis]) && self.ends_in_fluid(axis, low).iter().any(|is| !is) {
                    let of = self.edge(axis, low).of;
                    way = way.min(self.size[axis] * if node == Node::Fluid { of } else { 1.0 - of });
                }
            }
        }
        // a node in the fluid is below 0
        let way = way.max(smallest * LEAST);
        if node == Node::Fluid { -way } else { way }
    }

    /// Whether both ends of an edge are in the fluid.
    pub(super) fn ends_in_fluid(&self, along: usize, at: [i32; 3]) -> [bool; 2] {
        [0, 1].map(|end| {
            let place = |axis: usize| at[axis] + i32::from(axis == along) * end;
            self.is_fluid([0, 1, 2].map(|axis| place(axis).clamp(0, self.dims[axis])))
        })
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
        let vector = [0, 1, 2].map(|axis| areas[2 * axis] - areas[2 * axis + 1]);
        let is_open = areas.iter().all(|area| *area == 1.0);
        let has_node = (0..8).any(|corner| self.is_fluid(corner_at(at, corner)));
        match self.kinds[cell] {
            _ if n_open < 2 || !has_node => Kind::Covered,
            _ if is_open => Kind::Whole,
            // two walls that cancel
            _ if norm(vector) < ROUNDING => Kind::Covered,
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

    fn cell(&self, at: [i32; 3]) -> Part {
        let index = self.index(at);
        match (self.kinds[index], self.listed(index)) {
            (Kind::Covered, _) => Part::default(),
            (Kind::Cut, Some(listed)) => {
                let centre = self.outline.parts[listed].centre.map(|of| of - 0.5);
                Part { of: self.outline.parts[listed].fraction, centre }
            }
            _ => Part { of: 1.0, centre: [0.0; 3] },
        }
    }

    /// A face across an axis, which counts nodes of that axis.
    fn face(&self, across: usize, at: [i32; 3]) -> Part {
        let behind = |side: i32| [0, 1, 2].map(|axis| at[axis] - i32::from(axis == across) * (1 - side));
        let cells = [0, 1].map(|side| {
            let place = behind(side);
            (0..self.dims[across]).contains(&place[across]).then(|| self.index(place))
        });
        let is = |kind: Kind| cells.iter().flatten().any(|&cell| self.kinds[cell] == kind);
        let mut others = (0..3).filter(|&axis| axis != across);
        let axes = [others.next().unwrap_or(0), others.next().unwrap_or(0)];
        let n_fluid = (0..4).filter(|corner| {
            let step = |axis: usize| {
                i32::from(axes[0] == axis && corner & 1 == 1) + i32::from(axes[1] == axis && corner & 2 == 2)
            };
            self.is_fluid([0, 1, 2].map(|axis| at[axis] + step(axis)))
        });
        let whole = Part { of: 1.0, centre: [0.0; 3] };
        match n_fluid.count() {
            0 => return Part::default(),
            _ if is(Kind::Covered) => return Part::default(),
            4 => return whole,
            _ if is(Kind::Whole) => return whole,
            _ => {}
        }
        for (side, cell) in cells.into_iter().enumerate() {
            if let Some(listed) = cell.and_then(|cell| self.listed(cell)) {
                let (face, part) = (2 * across + 1 - side, &self.outline.parts[listed]);
                let mut centre = [0.0; 3];
                axes.iter().zip(part.face_centres[face]).for_each(|(&axis, of)| centre[axis] = of - 0.5);
                return match part.areas[face] {
                    area if area < ROUNDING => Part::default(),
                    area if area > 1.0 - ROUNDING => whole,
                    of => Part { of, centre },
                };
            }
        }
        whole
    }

    /// An edge along an axis, which counts nodes of the others.
    fn edge(&self, along: usize, at: [i32; 3]) -> Part {
        let length = match self.ends_in_fluid(along, at) {
            [true, true] => return Part { of: 1.0, centre: [0.0; 3] },
            [false, false] => return Part::default(),
            [is_low, _] => (is_low, self.length(along, at)),
        };
        let mut centre = [0.0; 3];
        let (is_low, of) = length;
        centre[along] = if is_low { 0.5 * of - 0.5 } else { 0.5 - 0.5 * of };
        Part { of, centre }
    }

    /// The length of an edge in the fluid, as a cut cell at it has it; else all.
    fn length(&self, along: usize, at: [i32; 3]) -> f64 {
        let mut others = (0..3).filter(|&axis| axis != along);
        let axes = [others.next().unwrap_or(0), others.next().unwrap_or(0)];
        for place in 0..4usize {
            let mut cell = at;
            axes.iter().enumerate().for_each(|(bit, &axis)| cell[axis] -= (place >> bit & 1) as i32);
            if (0..3).all(|axis| (0..self.dims[axis]).contains(&cell[axis])) {
                if let Some(listed) = self.listed(self.index(cell)) {
                    return self.outline.parts[listed].lengths[4 * along + place];
                }
            }
        }
        1.0
    }

    fn listed(&self, cell: usize) -> Option<usize> {
        self.outline.cells.binary_search_by_key(&(cell as u64), |listed| listed.cell).ok()
    }

    fn index(&self, at: [i32; 3]) -> usize {
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

    fn node(&self, at: [i32; 3]) -> Node {
        self.nodes[self.node_index(at)]
    }

    fn is_fluid(&self, at: [i32; 3]) -> bool {
        self.node(at) == Node::Fluid
    }
}

fn norm(of: [f64; 3]) -> f64 {
    of.iter().map(|of| of * of).sum::<f64>().sqrt()
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
