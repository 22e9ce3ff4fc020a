//! Staggered grids: the flags at the points where finite-difference solvers of Maxwell's equations have their fields (Yee 1966).
//!
//! # Theory
//! Components of E lie in the middle of the edges of cells, those of H in the middle of their faces: [`COMPONENTS`]. So the points of a
//! component are the centres of cells of a shifted box: along one axis or two they lie around lines instead of between them. The
//! points lie in the same snapped frame, with the same rule for ties: a point is inside a geometry exactly if a cell with its
//! centre there would be.
//!
//! A sheet has no inside. It is a set of faces: those whose link, from the centre of the cell before to that of the cell behind,
//! crosses its surface. Faces at the ends of the box have a link, too, to the mirror image of the centre. The four edges of a face are
//! conductors where the face is one: their points get its flag.
//!
//! Where edges conduct exactly within a surface, metal is too thin: of a plane wall the last edge lies half a cell before the surface, on average.
//! All edges of a cell of metal conduct, where the job names conductors: then the wall of cells, which lies at the surface on average, is that of the edges.
//!
//! # Practice
//! The highest rank wins, of insides and of sheets; a face within a geometry of a higher rank is not in the sheet.
//! Cost: about that of six meshes without files, and a cast along each axis for sheets; columns of six boxes, and 256 bytes for each face of a sheet.

use std::sync::Arc;

use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::sort::{sort, sort_by_key};
use hexcast_core::cells::columns::{Columns, flag_at};
use hexcast_core::cells::flags::{CellBox, flags_of_box, slabs_of_box};
use hexcast_core::grid::frame::{Frame, MAX_CELLS_PER_AXIS};
use hexcast_core::grid::lines::AXES;
use hexcast_core::grid::rays::Rays;
use hexcast_core::input::job::Rule;
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::cpu::Strips;

/// The components: their names, and along which axes their points lie on lines in place of centres.
pub const COMPONENTS: [(&str, [bool; 3]); 6] = [
    ("Ex", [false, true, true]),
    ("Ey", [true, false, true]),
    ("Ez", [true, true, false]),
    ("Hx", [true, false, false]),
    ("Hy", [false, true, false]),
    ("Hz", [false, false, true]),
];

/// A face of a sheet and its four edges, as lists hold them while they grow and are put in order.
const BYTES_OF_FACE: u64 = 256;
/// Points that are expanded at a time to be counted.
const COUNTED_AT_ONCE: usize = 1 << 20;

/// The flags of a staggered grid.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Staggered {
    /// The points of each component, in the order of [`COMPONENTS`].
    pub points: Vec<Points>,
    /// The faces of sheets: those across x, then y, then z, each x fastest.
    pub sheets: Vec<SheetFace>,
    /// The cell that the first points are those of, counted in the box: 0 but for windows.
    pub origin: [u32; 3],
}

/// A face between two cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct SheetFace {
    /// The axis across it: 0, 1 or 2.
    pub axis: u8,
    /// Its index on x, y and z: that of a line along its axis, of a cell along the others.
    pub face: [u32; 3],
    /// Flag of the sheet.
    pub flag: u8,
}

impl SheetFace {
    /// A face across an axis, 0 to 2, at the lower side of a cell, with a flag.
    pub fn new(axis: u8, face: [u32; 3], flag: u8) -> SheetFace {
        SheetFace { axis, face, flag }
    }
}

/// The flags at the points of a component.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Points {
    /// Such as "Ex".
    pub name: &'static str,
    /// Codes: 0, or rank + 1 of the geometry.
    columns: Columns,
    /// Points that a sheet wins, in order, with its code.
    won: Vec<Coded>,
    flag_of_code: Vec<u8>,
    /// The cells whose edges conduct, of components of E.
    conductors: Option<Conductors>,
}

/// Cells whose edges conduct.
#[derive(Debug, Clone, PartialEq)]
#[doc(hidden)]
pub struct Conductors {
    /// Flags of the cells.
    cells: Arc<Columns>,
    /// The order of flags, the higher wins; None of those that do not conduct.
    order: Vec<Option<u8>>,
    /// The cell behind the first point.
    first: [u32; 3],
}

impl Conductors {
    /// Those of some flags; `flag_of_rank` has the flags of the ranks.
    #[doc(hidden)]
    pub fn new(cells: Columns, flags: &[u8], flag_of_rank: &[u8]) -> Conductors {
        let mut order = vec![None; 256];
        flags.iter().for_each(|flag| order[usize::from(*flag)] = Some(0));
        for (rank, flag) in (0u8..).zip(flag_of_rank) {
            order[usize::from(*flag)] = order[usize::from(*flag)].map(|_| rank);
        }
        Conductors { cells: Arc::new(cells), order, first: [0; 3] }
    }

    fn order_of(&self, flag: u8) -> Option<u8> {
        self.order[usize::from(flag)]
    }

    /// Gives points of E along an axis the flags of the conductors at whose cells they are.
    fn put(&self, along: usize, points: &CellBox, flags: &mut [u8]) -> Result<()> {
        let across = [(along + 1) % 3, (along + 2) % 3];
        // with the cells before the first points
        let start =
            [0, 1, 2].map(|axis| (points[axis].start + self.first[axis]).saturating_sub(u32::from(axis != along)));
        let end = [0, 1, 2].map(|axis| (points[axis].end + self.first[axis]).min(self.cells.dims()[axis]));
        let cells = [0, 1, 2].map(|axis| start[axis]..end[axis].max(start[axis]));
        let of_cells = flags_of_box(&*self.cells.for_slab(&cells[self.cells.rays().axis])?, &cells)?;
        let n = [0, 1, 2].map(|axis| cells[axis].len());
        let n_points = [0, 1, 2].map(|axis| points[axis].len());
        for (index, flag) in flags.iter_mut().enumerate().filter(|(_, flag)| self.order_of(**flag).is_none()) {
            let place = [index % n_points[0], index / n_points[0] % n_points[1], index / (n_points[0] * n_points[1])];
            let behind = [0, 1, 2].map(|axis| place[axis] as u32 + points[axis].start + self.first[axis]);
            let around = [[0, 0], [1, 0], [0, 1], [1, 1]].into_iter().filter_map(|before: [u32; 2]| {
                let mut cell = behind;
                for (axis, by) in across.into_iter().zip(before) {
                    cell[axis] = cell[axis].checked_sub(by)?;
                }
                let [x, y, z] = [0, 1, 2].map(|axis| cell[axis].checked_sub(start[axis]).map(|at| at as usize));
                let [x, y, z] = [x?, y?, z?];
                (x < n[0] && y < n[1] && z < n[2]).then(|| of_cells[x + n[0] * (y + n[1] * z)])
            });
            let highest = around.filter_map(|of_cell| Some((self.order_of(of_cell)?, of_cell))).max();
            *flag = highest.map_or(*flag, |(_, of_cell)| of_cell);
        }
        Ok(())
    }
}

/// A point or face with a code.
#[doc(hidden)]
pub type Coded = ([u32; 3], u8);

impl Points {
    /// Number of points on each axis.
    pub fn dims(&self) -> [u32; 3] {
        self.columns.dims()
    }

    /// Flags of the points of a box, x fastest.
    ///
    /// # Errors
    /// `io` where the columns are in a store that fails.
    pub fn flags(&self, points: &CellBox) -> Result<Vec<u8>> {
        let mut codes = flags_of_box(&self.columns, points)?;
        let first = self.won.partition_point(|(point, _)| point[2] < points[2].start);
        let won = self.won[first..].iter().take_while(|(point, _)| point[2] < points[2].end);
        for (point, code) in won.filter(|(point, _)| (0..3).all(|axis| points[axis].contains(&point[axis]))) {
            let [x, y, z] = [0, 1, 2].map(|axis| (point[axis] - points[axis].start) as usize);
            codes[x + points[0].len() * (y + points[1].len() * z)] = *code;
        }
        codes.iter_mut().for_each(|code| *code = self.flag_of_code[usize::from(*code)]);
        let along = COMPONENTS.iter().take(3).position(|(name, _)| *name == self.name);
        if let (Some(conductors), Some(along)) = (&self.conductors, along) {
            conductors.put(along, points, &mut codes)?;
        }
        Ok(codes)
    }

    /// Number of points of each flag, of those before an end on each axis, exclusive.
    ///
    /// # Errors
    /// Those of [`Points::flags`].
    #[doc(hidden)]
    pub fn n_before(&self, end: [u32; 3]) -> Result<[u64; 256]> {
        let mut n_per_flag = self.n_per_flag()?;
        // what lies beyond is a plane or a few
        let mut within = self.dims();
        for axis in 0..3 {
            for at in end[axis]..self.dims()[axis] {
                let mut plane = within.map(|n| 0..n);
                plane[axis] = at..at + 1;
                self.flags(&plane)?.into_iter().for_each(|flag| n_per_flag[usize::from(flag)] -= 1);
            }
            within[axis] = within[axis].min(end[axis]);
        }
        Ok(n_per_flag)
    }

    /// Number of points of each flag.
    ///
    /// # Errors
    /// Those of [`Points::flags`].
    pub fn n_per_flag(&self) -> Result<[u64; 256]> {
        let mut n_per_flag = [0; 256];
        if self.conductors.is_some() {
            for points in slabs_of_box(&self.dims().map(|n| 0..n), COUNTED_AT_ONCE) {
                self.flags(&points)?.into_iter().for_each(|flag| n_per_flag[usize::from(flag)] += 1);
            }
            return Ok(n_per_flag);
        }
        for (code, n) in self.columns.cells_per_flag().into_iter().enumerate().take(self.flag_of_code.len()) {
            n_per_flag[usize::from(self.flag_of_code[code])] += n;
        }
        let under = under(&self.columns, &self.won)?;
        for (under, (_, code)) in under.into_iter().zip(&self.won) {
            n_per_flag[usize::from(self.flag_of_code[usize::from(under)])] -= 1;
            n_per_flag[usize::from(self.flag_of_code[usize::from(*code)])] += 1;
        }
        Ok(n_per_flag)
    }
}

impl Staggered {
    /// Puts sheets into the points of all components; `codes` has rank + 1 at these, `flag_of_rank` the flags of the ranks. `sheets` has the
    /// facets of the geometries that are sheets, in a frame of the whole box; the points are those of some of its cells, the first and the end, exclusive.
    ///
    /// # Errors
    /// `cancelled`; `memory` where the faces of sheets would take more than `max_bytes`; `io` where columns are in a store that fails.
    #[doc(hidden)]
    pub fn new(
        codes: Vec<Columns>,
        flag_of_rank: &[u8],
        (sheets, cells): (&Frame, [[u32; 3]; 2]),
        (max_bytes, control): (u64, &Control),
    ) -> Result<Staggered> {
        let flag_of_code = [&[0], flag_of_rank].concat();
        let (mut faces, mut edges) = (Vec::new(), [const { Vec::new() }; 3]);
        for axis in 0..3 {
            // of two sheets on a face the higher wins
            let crossed = highest(crossed_faces((sheets, cells), axis, (max_bytes / 3, control))?);
            let under = under(&codes[3 + axis], &crossed)?;
            for (&(face, code), _) in crossed.iter().zip(under).filter(|((_, code), under)| under <= code) {
                faces.push(SheetFace { axis: axis as u8, face, flag: flag_of_code[usize::from(code)] });
                for (along, across) in [((axis + 1) % 3, (axis + 2) % 3), ((axis + 2) % 3, (axis + 1) % 3)] {
                    let mut behind = face;
                    behind[across] += 1;
                    edges[along].extend([(face, code), (behind, code)]);
                }
            }
        }
        let mut edges = edges.into_iter().map(highest).collect::<Vec<Vec<Coded>>>().into_iter();
        let points = COMPONENTS.iter().zip(codes).map(|(&(name, _), columns)| {
            let mut won = edges.next().unwrap_or_default();
            let mut under = under(&columns, &won)?.into_iter();
            won.retain(|(_, code)| under.next().is_some_and(|under| under < *code));
            Ok(Points { name, columns, won, flag_of_code: flag_of_code.clone(), conductors: None })
        });
        Ok(Staggered { points: points.collect::<Result<_>>()?, sheets: faces, origin: cells[0] })
    }

    /// Lets all edges of some cells conduct; their first is that of the points.
    #[doc(hidden)]
    pub fn with_conductors(mut self, conductors: &Conductors) -> Staggered {
        self.points.iter_mut().take(3).for_each(|of| of.conductors = Some(conductors.clone()));
        self
    }

    /// Those of some cells of the box alone; these points begin at the cell `first`.
    ///
    /// # Errors
    /// `cancelled`; `memory` where the points would take more than `max_bytes`; `io` where columns are in a store that fails.
    #[doc(hidden)]
    pub fn within(
        self,
        cells: [[u32; 3]; 2],
        first: [u32; 3],
        (max_bytes, control): (u64, &Control),
    ) -> Result<Staggered> {
        let [start, n] = [0, 1].map(|of| [0, 1, 2].map(|axis| cells[of][axis] - [first, cells[0]][of][axis]));
        let moved = |place: [u32; 3]| [0, 1, 2].map(|axis| place[axis].wrapping_sub(start[axis]));
        let mut points = Vec::with_capacity(self.points.len());
        for (mut of, (_, is_moved)) in self.points.into_iter().zip(COMPONENTS) {
            let end = [0, 1, 2].map(|axis| n[axis] + u32::from(is_moved[axis]));
            of.columns = of.columns.cut(
                &[0, 1, 2].map(|axis| start[axis]..start[axis] + end[axis]),
                [1; 3],
                max_bytes,
                control,
            )?;
            if let Some(conductors) = &mut of.conductors {
                conductors.first = start;
            }
            of.won.iter_mut().for_each(|(point, _)| *point = moved(*point));
            of.won.retain(|(point, _)| (0..3).all(|axis| point[axis] < end[axis]));
            points.push(of);
        }
        let mut sheets = self.sheets;
        sheets.iter_mut().for_each(|sheet| sheet.face = moved(sheet.face));
        let is_within = |sheet: &SheetFace| {
            (0..3).all(|axis| sheet.face[axis] < n[axis] + u32::from(axis == usize::from(sheet.axis)))
        };
        sheets.retain(is_within);
        Ok(Staggered { points, sheets, origin: cells[0] })
    }
}

/// Refuses boxes whose points the exact arithmetic cannot index.
///
/// # Errors
/// `too-many-cells`.
#[doc(hidden)]
pub fn check_dims(dims: [u32; 3], what: &str) -> Result<()> {
    let most = MAX_CELLS_PER_AXIS - 2;
    let Some(axis) = (0..3).find(|&axis| dims[axis] > most) else { return Ok(()) };
    let message =
        format!("{} cells along {}: at most {most} fit where fields have points on lines", dims[axis], AXES[axis]);
    Err(Error::new("too-many-cells", message, format!("use larger cells, or leave out {what}")))
}

/// The faces across an axis of some cells whose links cross a facet, and its rank + 1.
///
/// # Errors
/// `cancelled`; `memory` where the faces would take more than `max_bytes`.
#[doc(hidden)]
pub fn crossed_faces(
    (sheets, [first, mut end]): (&Frame, [[u32; 3]; 2]),
    axis: usize,
    (max_bytes, control): (u64, &Control),
) -> Result<Vec<Coded>> {
    let n_faces = end[axis] - first[axis] + 1;
    let mut frame = sheets.clone().with_mirrored_ends(axis);
    // with the centre before the first of these cells, and that behind the last
    end[axis] += 2;
    if [first, end] != [[0; 3], frame.dims] {
        frame = frame.window_along(axis, [first, end]).0;
    }
    let rays = Rays::new(axis, frame.dims);
    // crossings are the same under either rule
    let mut strips = Strips::new(&Cast { frame: &frame, rays: &rays, rule: Rule::Parity }, None);
    let (mut found, n_across) = (Vec::new(), u64::from(rays.counts[0]));
    while let Some(crossings) = strips.crossings(false, control)? {
        for some in &crossings {
            some.for_each_ray(|ray, events| {
                // the first centre above is behind the face, and one more is before the first
                let behind = events.iter().map(|event| (event >> 9, (event >> 1) as u8 + 1));
                let within = behind.filter(|(centre, _)| (1..=n_faces).contains(centre));
                let across = [(ray % n_across) as u32, (ray / n_across) as u32];
                found.extend(within.map(|(centre, code)| (rays.cell([across[0], across[1], centre - 1]), code)));
            });
        }
        check_bytes(found.len(), max_bytes)?;
    }
    Ok(found)
}

/// Refuses more faces than memory holds, with the points at their edges.
fn check_bytes(n_faces: usize, max_bytes: u64) -> Result<()> {
    let n_bytes = BYTES_OF_FACE * n_faces as u64;
    if n_bytes <= max_bytes {
        return Ok(());
    }
    let message =
        format!("{n_faces} faces of sheets or more take {n_bytes} bytes: {max_bytes} are left of the memory allowed");
    Err(Error::new("memory", message, "allow more with max_memory (--max-memory), or use larger cells"))
}

/// In order, x fastest, each once with its highest code.
#[doc(hidden)]
pub fn highest(mut found: Vec<Coded>) -> Vec<Coded> {
    sort_by_key(&mut found, |&([x, y, z], code)| (z, y, x, u8::MAX - code));
    found.dedup_by_key(|(place, _)| *place);
    found
}

/// What columns have at some places.
///
/// # Errors
/// `io` where they are in a store that fails.
#[doc(hidden)]
pub fn under(columns: &Columns, places: &[Coded]) -> Result<Vec<u8>> {
    let rays = columns.rays();
    let ray_of = |[across, down]: [u32; 2]| u64::from(across) + u64::from(rays.counts[0]) * u64::from(down);
    // ray after ray, so that each is read once
    let mut order: Vec<(u64, u32)> = Vec::with_capacity(places.len());
    order.extend((0u32..).zip(places).map(|(index, (place, _))| (ray_of(rays.across.map(|axis| place[axis])), index)));
    sort(&mut order);
    let mut codes = vec![0; places.len()];
    for of_ray in order.chunk_by(|one, other| one.0 == other.0) {
        let runs = columns.ray(of_ray[0].0)?;
        for &(_, index) in of_ray {
            codes[index as usize] = flag_at(&runs, places[index as usize].0[rays.axis]);
        }
    }
    Ok(codes)
}
