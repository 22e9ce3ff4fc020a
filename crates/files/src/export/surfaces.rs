//! Closed surfaces of some flags: the faces of their cells as triangles, for formats that hold surfaces.
//!
//! Mesh, flags to keep -> [`Surface`], one a flag: the faces between its cells and others, or the outside of the mesh. A face between two kept flags
//! is there for both. Two triangles of a surface meet at each edge, by the numbers of its corners: where cells touch at an edge or a corner alone,
//! each has corners of its own.
//!
//! Around a point lie eight cells. Their faces at the point form rings, each of faces that follow each other across edges; each ring has a corner of
//! its own ([`Rings`]). Where two cells touch along an edge alone, both may have the same corners at its ends; so each gets a corner in the
//! middle of the edge, too, and its faces are polygons there.
//!
//! Cost: O(cells) time; besides a slab the surfaces, about 40 bytes a face, and 24 bytes for each cell of a plane across z.

use std::collections::HashMap;

use super::output::Export;
use hexcast_core::base::error::{Error, Result};
use hexcast_derived::mesh::Mesh;
use hexcast_derived::skin::n_faces;

/// A cell beyond the mesh.
const OUTSIDE: u16 = 256;
/// Bytes of a face: its corner, and the numbers of two triangles.
const FACE_BYTES: u64 = 40;

/// The closed surface of a flag.
pub(super) struct Surface {
    pub(super) flag: u8,
    pub(super) corners: Vec<[f32; 3]>,
    /// Corners of each triangle, counter-clockwise seen from outside.
    pub(super) triangles: Vec<[u32; 3]>,
}

/// What is held of a mesh, and about the most bytes of that.
pub(super) const HELD: (&str, fn(&Mesh) -> u64) = ("surfaces", |mesh| {
    // columns that cannot be read are said when they are written
    n_faces(mesh).unwrap_or(0).saturating_mul(FACE_BYTES)
});

/// Builds the surfaces of the kept flags, ascending, with coordinates relative to the first line of each axis.
///
/// # Errors
/// `lines-too-fine` where lines are equal once they are rounded to f32; `export-too-large` where a surface has more corners than 32 bits count;
/// `cancelled`; `io` where the columns are in a store that fails.
pub(super) async fn surfaces(job: &Export<'_>, keeps: &[bool; 256], from: [f64; 3]) -> Result<Vec<Surface>> {
    let lines = [0, 1, 2].map(|axis| rounded(&job.mesh.lines().list(axis), from[axis]));
    if let Some(axis) = (0..3).find(|axis| lines[*axis].windows(2).any(|pair| pair[0] >= pair[1])) {
        let message = format!("the lines across {} are too close to differ as 32-bit numbers", ["x", "y", "z"][axis]);
        return Err(Error::new("lines-too-fine", message, "use larger cells, or move the model to the origin"));
    }
    let [nx, ny, nz] = job.mesh.dims();
    let plane = nx as usize * ny as usize;
    let mut sweep = Sweep::new([nx as usize, ny as usize, nz as usize], keeps, &lines);
    job.for_each_slab(plane, &mut |flags: &[u8]| flags.chunks_exact(plane).try_for_each(|flags| sweep.push(flags)))
        .await?;
    sweep.push(&[])?;
    Ok(sweep.surfaces.into_iter().flatten().collect())
}

fn rounded(lines: &[f64], from: f64) -> Vec<f32> {
    lines.iter().map(|line| (line - from) as f32).collect()
}

/// The kept cells of one flag around a point, and the number of its first ring.
struct Entry {
    flag: u8,
    cells: u8,
    first: u32,
}

/// The entries of the points between two planes of cells.
#[derive(Default)]
struct Points {
    /// Where those of each point begin.
    starts: Vec<usize>,
    entries: Vec<Entry>,
}

/// Goes through a mesh plane by plane.
struct Sweep<'a> {
    n: [usize; 3],
    keeps: &'a [bool; 256],
    lines: &'a [Vec<f32>; 3],
    rings: Vec<Rings>,
    /// How many planes of cells have come.
    z: usize,
    /// The cells under those that are `below` the points `high`, and the cells above these.
    under: Vec<u8>,
    below: Vec<u8>,
    above: Vec<u8>,
    /// Points below the cells `below`, and those above them.
    low: Points,
    high: Points,
    surfaces: Vec<Option<Surface>>,
    /// Corners in the middle of edges that one face has taken, by flag, inner cell and edge.
    middles: HashMap<(u8, [usize; 3], [usize; 3]), u32>,
}

impl<'a> Sweep<'a> {
    fn new(n: [usize; 3], keeps: &'a [bool; 256], lines: &'a [Vec<f32>; 3]) -> Sweep<'a> {
        let rings = (0..=255).map(Rings::of).collect();
        let surfaces = std::iter::repeat_with(|| None).take(256).collect();
        let (low, high) = (Points::default(), Points::default());
        let [under, below, above] = [const { Vec::new() }; 3];
        Sweep { n, keeps, lines, rings, z: 0, under, below, above, low, high, surfaces, middles: HashMap::new() }
    }

    /// The flag of a cell of the three planes; coordinates are counted from 1, so that 0 is outside.
    fn flag(&self, [x, y, z]: [usize; 3]) -> u16 {
        let plane = match z + 1 - self.z {
            0 => &self.under,
            1 => &self.below,
            _ => &self.above,
        };
        if x == 0 || y == 0 || x > self.n[0] || y > self.n[1] || plane.is_empty() {
            return OUTSIDE;
        }
        plane[x - 1 + self.n[0] * (y - 1)].into()
    }

    /// Takes the next plane of cells; none after the last.
    fn push(&mut self, flags: &[u8]) -> Result<()> {
        std::mem::swap(&mut self.under, &mut self.below);
        std::mem::swap(&mut self.below, &mut self.above);
        self.above.clear();
        self.above.extend_from_slice(flags);
        std::mem::swap(&mut self.low, &mut self.high);
        self.number_points()?;
        // cells of `below` have all their points now
        self.sides()?;
        self.z += 1;
        Ok(())
    }

    /// Numbers the corners at the points between the planes.
    fn number_points(&mut self) -> Result<()> {
        let mut points = std::mem::take(&mut self.high);
        points.starts.clear();
        points.entries.clear();
        for y in 0..=self.n[1] {
            for x in 0..=self.n[0] {
                points.starts.push(points.entries.len());
                let around: [u16; 8] =
                    std::array::from_fn(|bit| self.flag([x + (bit & 1), y + (bit >> 1 & 1), self.z + (bit >> 2)]));
                if around[1..].iter().all(|flag| *flag == around[0]) {
                    continue;
                }
                for (bit, flag) in around.iter().enumerate() {
                    let Ok(flag) = u8::try_from(*flag) else { continue };
                    if !self.keeps[usize::from(flag)] || around[..bit].contains(&u16::from(flag)) {
                        continue;
                    }
                    let cells =
                        (0..8).filter(|bit| around[*bit] == u16::from(flag)).fold(0, |cells, bit| cells | 1 << bit);
                    let place = [self.lines[0][x], self.lines[1][y], self.lines[2][self.z]];
                    let n = self.rings[usize::from(cells)].n;
                    let first = self.surface(flag).add(place, n.into())?;
                    points.entries.push(Entry { flag, cells, first });
                }
            }
        }
        points.starts.push(points.entries.len());
        self.high = points;
        Ok(())
    }

    fn surface(&mut self, flag: u8) -> &mut Surface {
        self.surfaces[usize::from(flag)].get_or_insert_with(|| Surface {
            flag,
            corners: Vec::new(),
            triangles: Vec::new(),
        })
    }

    /// Adds the faces between the planes, and those around the cells of `below`.
    fn sides(&mut self) -> Result<()> {
        for y in 1..=self.n[1] + 1 {
            for x in 1..=self.n[0] + 1 {
                // a face belongs to the upper of its cells; cells of `above` have only those below them
                for (axis, upper) in [(0, [x, y, self.z]), (1, [x, y, self.z]), (2, [x, y, self.z + 1])] {
                    let mut lower = upper;
                    lower[axis] -= 1;
                    let flags = [self.flag(lower), self.flag(upper)];
                    if flags[0] == flags[1] {
                        continue;
                    }
                    for (flag, inner) in flags.into_iter().zip([lower, upper]) {
                        if let Some(flag) = u8::try_from(flag).ok().filter(|flag| self.keeps[usize::from(*flag)]) {
                            self.face(flag, axis, upper, inner)?;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Adds a face of a flag below `upper`, across an axis; `inner` is the cell of the flag.
    fn face(&mut self, flag: u8, axis: usize, upper: [usize; 3], inner: [usize; 3]) -> Result<()> {
        let across = [(axis + 1) % 3, (axis + 2) % 3];
        let mut polygon: Vec<u32> = Vec::with_capacity(8);
        let mut first_middle = None;
        // counter-clockwise seen from above
        let corners = [[0, 0], [1, 0], [1, 1], [0, 1]];
        for (at, corner) in corners.iter().enumerate() {
            // lines are counted from 0, and a cell has the number of the line above it
            let mut point = upper.map(|cell| cell - 1);
            (0..2).for_each(|of| point[across[of]] += corner[of]);
            polygon.push(self.corner(flag, point, 4 * axis + (1 - corner[0]) + 2 * (1 - corner[1])));
            let next = corners[(at + 1) % 4];
            // the edge to the next corner runs along one axis, and the face lies on one side of it along the other
            let along = usize::from(corner[0] == next[0]);
            let beside = 1 - along;
            let mut start = point;
            start[across[along]] = upper[across[along]] - 1;
            if let Some(middle) = self.middle(flag, inner, start, across[along], (axis, across[beside]))? {
                first_middle = first_middle.or(Some(polygon.len()));
                polygon.push(middle);
            }
        }
        if inner == upper {
            polygon.reverse();
            first_middle = first_middle.map(|at| polygon.len() - 1 - at);
        }
        // corners beside a middle are on one line with it: from there on no triangle is flat
        polygon.rotate_left(first_middle.unwrap_or(0));
        let surface = self.surface(flag);
        surface.triangles.extend((1..polygon.len() - 1).map(|at| [polygon[0], polygon[at], polygon[at + 1]]));
        Ok(())
    }

    /// The number of a corner at a point, of the ring that a face is in.
    fn corner(&self, flag: u8, [x, y, z]: [usize; 3], face: usize) -> u32 {
        let points = if z == self.z { &self.high } else { &self.low };
        let at = x + (self.n[0] + 1) * y;
        let entries = &points.entries[points.starts[at]..points.starts[at + 1]];
        // a point of a face has cells of the flag
        entries
            .iter()
            .find(|entry| entry.flag == flag)
            .map_or(0, |entry| entry.first + u32::from(self.rings[usize::from(entry.cells)].of_face[face]))
    }

    /// The corner in the middle of an edge of a face, where two cells of the flag touch along the edge alone. The edge begins at a point, and runs along
    /// an axis, which `sides` lie across.
    fn middle(
        &mut self,
        flag: u8,
        inner: [usize; 3],
        start: [usize; 3],
        along: usize,
        sides: (usize, usize),
    ) -> Result<Option<u32>> {
        let cell = |of_first: usize, of_second: usize| {
            // the cell beyond the lines of the edge
            let mut cell = start;
            cell[along] += 1;
            cell[sides.0] += of_first;
            cell[sides.1] += of_second;
            cell
        };
        let has = |of: [usize; 2]| self.flag(cell(of[0], of[1])) == u16::from(flag);
        let is_diagonal = match [has([0, 0]), has([1, 1]), has([0, 1]), has([1, 0])] {
            [a, b, c, d] => a == b && c == d && a != c,
        };
        if !is_diagonal {
            return Ok(None);
        }
        let mut edge = start;
        edge[along] = 2 * start[along] + 1;
        edge[sides.0] *= 2;
        edge[sides.1] *= 2;
        // both faces of the inner cell at the edge have it
        if let Some(middle) = self.middles.remove(&(flag, inner, edge)) {
            return Ok(Some(middle));
        }
        let mut place = [0, 1, 2].map(|axis| self.lines[axis][start[axis]]);
        place[along] = place[along].midpoint(self.lines[along][start[along] + 1]);
        let middle = self.surface(flag).add(place, 1)?;
        self.middles.insert((flag, inner, edge), middle);
        Ok(Some(middle))
    }
}

impl Surface {
    /// Adds a corner so many times; returns the number of the first.
    fn add(&mut self, place: [f32; 3], n: usize) -> Result<u32> {
        let first = u32::try_from(self.corners.len()).ok().filter(|first| first.checked_add(n as u32).is_some());
        let Some(first) = first else {
            let message = format!("the surface of flag {} has more than {} corners", self.flag, u32::MAX);
            return Err(Error::new("export-too-large", message, "export fewer flags, or mesh with larger cells"));
        };
        self.corners.extend(std::iter::repeat_n(place, n));
        Ok(first)
    }
}

/// How the faces at a point follow each other, of some of the eight cells around it.
struct Rings {
    /// How many rings there are.
    n: u8,
    /// The ring of each face: those across x, y and z, of each the four quarters around the point.
    of_face: [u8; 12],
}

impl Rings {
    /// Those of cells with these bits: x + 2 y + 4 z, each 0 below the point and 1 above.
    fn of(cells: u8) -> Rings {
        let has = |place: [usize; 3]| cells >> (place[0] + 2 * place[1] + 4 * place[2]) & 1 == 1;
        // each face by itself at first
        let mut ring: [usize; 12] = std::array::from_fn(|face| face);
        let mut join = |a: usize, b: usize| {
            let (old, new) = (ring[a], ring[b]);
            ring.iter_mut().filter(|of| **of == old).for_each(|of| *of = new);
        };
        for along in 0..3 {
            let [p, q] = [(along + 1) % 3, (along + 2) % 3];
            for up in 0..2 {
                let place = |[of_p, of_q]: [usize; 2]| {
                    let mut place = [up; 3];
                    (place[p], place[q]) = (of_p, of_q);
                    place
                };
                // the cells around the edge, and the faces from each to the next
                let around = [[0, 0], [1, 0], [1, 1], [0, 1]];
                let face = |at: usize| {
                    let (from, to) = (around[at % 4], around[(at + 1) % 4]);
                    let axis = if from[0] == to[0] { q } else { p };
                    let of = place(from);
                    4 * axis + of[(axis + 1) % 3] + 2 * of[(axis + 2) % 3]
                };
                let is_face = |at: usize| has(place(around[at % 4])) != has(place(around[(at + 1) % 4]));
                let faces: Vec<usize> = (0..4).filter(|at| is_face(*at)).collect();
                match faces[..] {
                    [a, b] => join(face(a), face(b)),
                    // two cells touch here: the faces of each follow each other
                    [_, _, _, _] => {
                        (0..4).filter(|at| has(place(around[*at]))).for_each(|at| join(face(at + 3), face(at)))
                    }
                    _ => {}
                }
            }
        }
        let mut numbers: Vec<usize> = Vec::new();
        let of_face = std::array::from_fn(|face| {
            let (axis, quarter) = (face / 4, face % 4);
            let mut place = [0; 3];
            (place[(axis + 1) % 3], place[(axis + 2) % 3]) = (quarter & 1, quarter >> 1);
            let lower = has(place);
            place[axis] = 1;
            if lower == has(place) {
                return 0;
            }
            let number = numbers.iter().position(|known| *known == ring[face]).unwrap_or_else(|| {
                numbers.push(ring[face]);
                numbers.len() - 1
            });
            number as u8
        });
        Rings { n: numbers.len() as u8, of_face }
    }
}
