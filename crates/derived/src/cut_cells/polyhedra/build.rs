//! The bodies of a fluid in the cells of a mesh, and their faces, before some are joined.
//!
//! Lines, [`Outline`], whole cells -> [`Build`]: bodies by cell, faces between them and around them, points that all cells at them share.

use std::collections::{HashMap, HashSet};

use super::cell::{BEND, CROSSING, Vertex, bodies, ends, loops, on_face, polygons};
use super::closed::{Behind, Face};
use super::planar;
use crate::cut_cells::edges::ACROSS;
use crate::mesh::outline::{Outline, OutlineCell};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::grid::lines::Lines;

/// A crossing so near to an end of its edge, in edges, lies in it.
pub const SNAP: f64 = 0.05;
/// What is not there: of a cell its body, of a point its number.
pub(super) const NONE: u32 = u32::MAX;

/// The fluid in a cell.
#[derive(Clone, Copy)]
struct Inside<'a> {
    outline: Option<&'a OutlineCell>,
    /// Its corners in the fluid.
    corners: u8,
    /// Which body each corner is in, counted from that of the cell.
    bodies: [u8; 8],
    first: u32,
}

/// Where the surface is flat although it bends.
#[derive(Default)]
pub(super) struct Flat {
    /// Faces by the corner of the mesh at their low end, and the axis across.
    faces: HashSet<(u64, u8)>,
    /// Cells, by index.
    peaks: HashSet<u64>,
}

impl Flat {
    pub(super) fn is_empty(&self) -> bool {
        self.faces.is_empty() && self.peaks.is_empty()
    }

    pub(super) fn extend(&mut self, more: Flat) {
        self.faces.extend(more.faces);
        self.peaks.extend(more.peaks);
    }
}

/// So many cells around a wrong one change with what mends it, and so many are made to see these whole.
const CORE: u32 = 2;
const REACH: u32 = 5;

/// The surroundings of some cells.
pub(super) struct Near {
    /// Indices of cells, ascending.
    cells: Vec<u64>,
    /// Those of them that are seen whole, with all that they may be joined with.
    core: HashSet<u64>,
}

impl Near {
    pub(super) fn new(of: &[[u32; 3]], dims: [u32; 3]) -> Near {
        let within = |reach: u32| -> HashSet<u64> {
            let mut all = HashSet::new();
            for cell in of {
                let [x, y, z] =
                    [0, 1, 2].map(|axis| cell[axis].saturating_sub(reach)..(cell[axis] + reach + 1).min(dims[axis]));
                for (z, y) in z.flat_map(|z| y.clone().map(move |y| (z, y))) {
                    let row = u64::from(dims[0]) * (u64::from(y) + u64::from(dims[1]) * u64::from(z));
                    all.extend(x.clone().map(|x| row + u64::from(x)));
                }
            }
            all
        };
        let mut cells: Vec<u64> = within(REACH).into_iter().collect();
        cells.sort_unstable();
        Near { cells, core: within(CORE) }
    }
}

/// A polyhedron before it is joined with others.
pub(super) struct Body {
    pub(super) cell: [u32; 3],
}

pub(super) struct Build<'a> {
    pub(super) lines: [Vec<f64>; 3],
    pub(super) dims: [u32; 3],
    outline: &'a Outline,
    flat: &'a Flat,
    /// The only cells that are made; None for all.
    near: Option<&'a Near>,
    /// Of each cell its first body, or none.
    pub(super) first: Vec<u32>,
    /// Of each cell its place in the outline, or none.
    pub(super) cut: Vec<u32>,
    pub(super) bodies: Vec<Body>,
    /// Of each point of the mesh lines, x fastest, its number, or none.
    nodes: Vec<u32>,
    crossings: HashMap<(u64, u8), u32>,
    /// By the corner of the mesh at their low end, and the axis across.
    bends: HashMap<(u64, u8), u32>,
    pub(super) points: Vec<[f64; 3]>,
    pub(super) faces: Vec<Face>,
    pub(super) corners: Vec<u32>,
    polygon: Vec<u32>,
}

impl<'a> Build<'a> {
    pub(super) fn new(
        lines: &Lines,
        outline: &'a Outline,
        is_whole: &[bool],
        flat: &'a Flat,
        near: Option<&'a Near>,
    ) -> Result<Build<'a>> {
        let dims = lines.dims();
        let n_cells = lines.n_cells();
        let n_nodes: u64 = dims.iter().map(|&n| u64::from(n) + 1).product();
        if n_nodes > i32::MAX as u64 || is_whole.len() as u64 != n_cells {
            let message = format!(
                "a box of {n_cells} cells, of which {} are given: cut cells take up to {}",
                is_whole.len(),
                i32::MAX
            );
            return Err(Error::new("export-too-large", message, "use larger cells"));
        }
        let (mut first, mut cut) = (vec![NONE; n_cells as usize], vec![NONE; n_cells as usize]);
        outline.cells.iter().enumerate().for_each(|(index, of)| cut[of.cell as usize] = index as u32);
        let mut all = Vec::new();
        let mut put = |index: usize| {
            let n = match outline.cells.get(cut[index] as usize) {
                Some(of) => bodies(of.in_fluid(outline.fluid)).0,
                None => u8::from(is_whole[index]),
            };
            if n > 0 {
                first[index] = all.len() as u32;
            }
            all.extend((0..n).map(|_| Body { cell: cell_at(index, dims) }));
        };
        match near {
            Some(near) => near.cells.iter().for_each(|&index| put(index as usize)),
            None => (0..n_cells as usize).for_each(put),
        }
        Ok(Build {
            lines: [0, 1, 2].map(|axis| lines.list(axis)),
            dims,
            outline,
            flat,
            near,
            first,
            cut,
            bodies: all,
            nodes: vec![NONE; n_nodes as usize],
            crossings: HashMap::new(),
            bends: HashMap::new(),
            points: Vec::new(),
            faces: Vec::new(),
            corners: Vec::new(),
            polygon: Vec::new(),
        })
    }

    /// Adds the faces of all cells.
    ///
    /// # Errors
    /// `export-too-large`; `cancelled`.
    pub(super) async fn add_all(&mut self, control: &Control) -> Result<()> {
        match self.near {
            Some(near) => near.cells.iter().for_each(|&index| self.add(cell_at(index as usize, self.dims))),
            None => {
                let [nx, ny, nz] = self.dims;
                for z in 0..nz {
                    control.rest().await?;
                    (0..ny).for_each(|y| (0..nx).for_each(|x| self.add([x, y, z])));
                    self.check_size()?;
                }
            }
        }
        self.check_size()
    }

    /// Whether the cell of a body is seen whole.
    pub(super) fn is_core(&self, body: &Body) -> bool {
        self.near.is_none_or(|near| near.core.contains(&(self.index(body.cell) as u64)))
    }

    fn check_size(&self) -> Result<()> {
        let greatest = self.corners.len().max(self.points.len());
        if greatest <= i32::MAX as usize {
            return Ok(());
        }
        let message = format!("{greatest} corners of faces or more: OpenFOAM numbers up to {}", i32::MAX);
        Err(Error::new("export-too-large", message, "use larger cells"))
    }

    /// Index of a cell, x fastest.
    pub(super) fn index(&self, cell: [u32; 3]) -> usize {
        let ([x, y, z], [nx, ny, _]) = (cell.map(|at| at as usize), self.dims.map(|n| n as usize));
        x + nx * (y + ny * z)
    }

    /// What of the fluid is in a cell.
    fn inside(&self, cell: [u32; 3]) -> Option<Inside<'a>> {
        let index = self.index(cell);
        let first = self.first[index];
        if first == NONE {
            return None;
        }
        let outline = self.outline.cells.get(self.cut[index] as usize);
        let corners = outline.map_or(0xff, |of| of.in_fluid(self.outline.fluid));
        Some(Inside { outline, corners, bodies: bodies(corners).1, first })
    }

    /// Adds the faces of a cell above it, those of the surface, and those at the sides of the box.
    fn add(&mut self, cell: [u32; 3]) {
        let Some(inside) = self.inside(cell) else { return };
        for face in 0..6 {
            let (axis, is_above) = (face / 2, face % 2 == 1);
            let is_side = cell[axis] + 1 == self.dims[axis] && is_above || cell[axis] == 0 && !is_above;
            if !is_side && !is_above {
                continue;
            }
            let mut next = cell;
            next[axis] += u32::from(!is_side);
            let beside = if is_side { None } else { self.inside(next) };
            for polygon in polygons(inside.corners, face) {
                let corner = polygon.corner();
                let behind = match beside {
                    _ if is_side => Behind::Side(face as u8, cell),
                    Some(of) => Behind::Cell(of.first + u32::from(of.bodies[corner ^ 1 << axis])),
                    // the check of closed cells finds what cannot be
                    None => continue,
                };
                let owner = inside.first + u32::from(inside.bodies[corner]);
                self.begin();
                polygon.vertices().iter().for_each(|&vertex| self.push((cell, inside.outline), vertex));
                self.finish(owner, behind);
            }
        }
        let Some(outline) = inside.outline else { return };
        loops(inside.corners, |corner, vertices| {
            let owner = inside.first + u32::from(inside.bodies[corner]);
            self.begin();
            // what is behind the surface at each crossing
            let mut walls = Vec::new();
            for &vertex in vertices {
                self.push((cell, Some(outline)), vertex);
                if let Some(&point) = self.polygon.last().filter(|_| vertex < BEND) {
                    walls.push((point, wall(outline, inside.corners, vertex - CROSSING)));
                }
            }
            let ring = std::mem::take(&mut self.polygon);
            for polygon in self.flat(&ring, (cell, outline)) {
                let behind = match self.side_of(&polygon) {
                    Some(side) => Behind::Side(side, cell),
                    None => surface(&walls, &polygon),
                };
                self.polygon = polygon;
                self.finish(owner, behind);
            }
        });
    }

    /// The flat polygons of a loop: those between its points, or between them and the corner of the surface in the cell.
    fn flat(&mut self, ring: &[u32], (cell, outline): ([u32; 3], &OutlineCell)) -> Vec<Vec<u32>> {
        let mut flat = Vec::new();
        if !outline.peak[0].is_nan() && !self.flat.peaks.contains(&outline.cell) {
            let peak = match corner_near(outline.peak, [0, 1, 2]) {
                Some(corner) => self.node(cell, corner),
                None => self.inner(cell, outline.peak),
            };
            if !ring.contains(&peak) {
                flat.extend((0..ring.len()).map(|at| vec![ring[at], ring[(at + 1) % ring.len()], peak]));
                return flat;
            }
        }
        let size = (0..3).map(|axis| self.size(cell, axis)).fold(f64::INFINITY, f64::min);
        planar::split(ring, &self.points, 1e-6 * size, |polygon| flat.push(polygon.to_vec()));
        flat
    }

    pub(super) fn size(&self, cell: [u32; 3], axis: usize) -> f64 {
        let at = cell[axis] as usize;
        self.lines[axis][at + 1] - self.lines[axis][at]
    }

    /// The side of the box that all points lie in.
    fn side_of(&self, polygon: &[u32]) -> Option<u8> {
        let place = |side: u8| {
            self.lines[usize::from(side / 2)]
                [if side.is_multiple_of(2) { 0 } else { self.dims[usize::from(side / 2)] as usize }]
        };
        (0..6).find(|&side| polygon.iter().all(|&at| self.points[at as usize][usize::from(side / 2)] == place(side)))
    }

    fn begin(&mut self) {
        self.polygon.clear();
    }

    /// Adds a vertex of a cell to the polygon, unless it is the same point as that before, or there is none.
    fn push(&mut self, (cell, outline): ([u32; 3], Option<&OutlineCell>), vertex: Vertex) {
        let point = if vertex < CROSSING {
            self.node(cell, vertex)
        } else if vertex >= BEND {
            let face = vertex - BEND;
            let Some(at) = outline.and_then(|of| self.bend_of(cell, of, face)) else { return };
            self.bend(cell, face, at)
        } else {
            let edge = vertex - CROSSING;
            let [low, high] = ends(edge);
            let at = outline.map_or(f64::NAN, |of| of.crossings[usize::from(edge)]);
            if at < SNAP {
                self.node(cell, low)
            } else if at > 1.0 - SNAP {
                self.node(cell, high)
            } else {
                self.crossing(cell, edge, at)
            }
        };
        if self.polygon.last() != Some(&point) {
            self.polygon.push(point);
        }
    }

    fn place(&self, cell: [u32; 3], corner: u8) -> (u64, [usize; 3]) {
        let at = [0, 1, 2].map(|axis| cell[axis] as usize + usize::from(corner >> axis & 1));
        let [nx, ny, _] = self.dims.map(|n| n as usize + 1);
        ((at[0] + nx * (at[1] + ny * at[2])) as u64, at)
    }

    fn node(&mut self, cell: [u32; 3], corner: u8) -> u32 {
        let (node, at) = self.place(cell, corner);
        let known = self.nodes[node as usize];
        if known != NONE {
            return known;
        }
        self.nodes[node as usize] = self.points.len() as u32;
        self.points.push([0, 1, 2].map(|axis| self.lines[axis][at[axis]]));
        self.nodes[node as usize]
    }

    fn crossing(&mut self, cell: [u32; 3], edge: u8, at: f64) -> u32 {
        let (node, low) = self.place(cell, ends(edge)[0]);
        if let Some(&known) = self.crossings.get(&(node, edge / 4)) {
            return known;
        }
        let number = self.points.len() as u32;
        let mut point = [0, 1, 2].map(|axis| self.lines[axis][low[axis]]);
        let axis = usize::from(edge / 4);
        point[axis] += at * (self.lines[axis][low[axis] + 1] - point[axis]);
        self.points.push(point);
        self.crossings.insert((node, edge / 4), number);
        number
    }

    /// What a face is known by.
    fn key(&self, cell: [u32; 3], face: u8) -> (u64, u8) {
        let axis = face / 2;
        (self.place(cell, (face % 2) << axis).0, axis)
    }

    /// Where the surface of a cell bends on a face, if it does.
    fn bend_of(&self, cell: [u32; 3], of: &OutlineCell, face: u8) -> Option<[f64; 2]> {
        let at = of.bends[usize::from(face)];
        (!at[0].is_nan() && !self.flat.faces.contains(&self.key(cell, face))).then_some(at)
    }

    /// The bends and peaks of some cells.
    pub(super) fn bent(&self, cells: Vec<[u32; 3]>) -> Flat {
        let mut more = Flat::default();
        for cell in cells {
            let Some(of) = self.outline.cells.get(self.cut[self.index(cell)] as usize) else { continue };
            if !of.peak[0].is_nan() && !self.flat.peaks.contains(&of.cell) {
                more.peaks.insert(of.cell);
            }
            for face in (0..6).filter(|&face| self.bend_of(cell, of, face).is_some()) {
                more.faces.insert(self.key(cell, face));
                // a peak is one of bends on both sides
                let axis = usize::from(face / 2);
                let next = if face % 2 == 1 { cell[axis].checked_add(1) } else { cell[axis].checked_sub(1) };
                if let Some(next) = next.filter(|&next| next < self.dims[axis]) {
                    let mut beside = cell;
                    beside[axis] = next;
                    more.peaks.insert(self.index(beside) as u64);
                }
            }
        }
        more
    }

    /// Where the surface bends on a face of a cell.
    fn bend(&mut self, cell: [u32; 3], face: u8, at: [f64; 2]) -> u32 {
        let at = on_face(face, at);
        if let Some(corner) = corner_near(at, ACROSS[usize::from(face / 2)]) {
            return self.node(cell, corner);
        }
        let key = self.key(cell, face);
        if let Some(&known) = self.bends.get(&key) {
            return known;
        }
        let number = self.inner(cell, at);
        self.bends.insert(key, number);
        number
    }

    /// A point in a cell, given its place there.
    fn inner(&mut self, cell: [u32; 3], at: [f64; 3]) -> u32 {
        let place = |axis: usize| {
            let (low, at) = (cell[axis] as usize, at[axis]);
            // exactly on a face
            if at == 1.0 { self.lines[axis][low + 1] } else { self.lines[axis][low] + at * self.size(cell, axis) }
        };
        let point = [0, 1, 2].map(place);
        self.points.push(point);
        self.points.len() as u32 - 1
    }

    /// Ends the polygon: a face, several where it comes back to a point, as to a corner in which the surface bends, and none where it has no area.
    fn finish(&mut self, owner: u32, behind: Behind) {
        let polygon = std::mem::take(&mut self.polygon);
        planar::pinched(&polygon, |ring| {
            if ring.len() > 2 {
                let (start, n) = (self.corners.len() as u32, ring.len() as u32);
                self.corners.extend_from_slice(ring);
                self.faces.push(Face { start, n, owner, behind });
            }
        });
        self.polygon = polygon;
    }
}

/// The cell of an index.
fn cell_at(index: usize, dims: [u32; 3]) -> [u32; 3] {
    let [nx, ny, _] = dims.map(|n| n as usize);
    [index % nx, index / nx % ny, index / (nx * ny)].map(|at| at as u32)
}

/// The corner of a cell that a place is so near to that it lies in it.
fn corner_near<const N: usize>(at: [f64; 3], axes: [usize; N]) -> Option<u8> {
    let is_near = |axis: &usize| at[*axis] < SNAP || at[*axis] > 1.0 - SNAP;
    axes.iter().all(is_near).then(|| (0..3).fold(0, |corner, axis| corner | u8::from(at[axis] > 0.5) << axis))
}

/// What is behind the surface where it crosses an edge: the flag, and whose facet it is.
fn wall(of: &OutlineCell, fluid: u8, edge: u8) -> (u8, u32) {
    let [low, high] = ends(edge);
    let behind = if fluid >> low & 1 == 1 { high } else { low };
    (of.corners[usize::from(behind)], of.walls[usize::from(edge)])
}

/// What is behind a polygon of a loop: that which most of its crossings have, of several the least; where it has none, those of the loop.
fn surface(walls: &[(u32, (u8, u32))], polygon: &[u32]) -> Behind {
    let own = walls.iter().filter(|(point, _)| polygon.contains(point));
    let mut all: Vec<(u8, u32)> = own.map(|(_, wall)| *wall).collect();
    if all.is_empty() {
        all.extend(walls.iter().map(|(_, wall)| *wall));
    }
    all.sort_unstable();
    let n_of = |one: &(u8, u32)| all.iter().filter(|other| *other == one).count();
    let (flag, wall) = all.iter().rev().max_by_key(|one| n_of(one)).copied().unwrap_or_default();
    Behind::Surface(flag, wall)
}
