//! What of facets lies in the cells of some planes: polygons, in the order of rows and of cells.
//!
//! Facets, planes of a window -> [`Pieces`]. Coordinates are in cells, from the low corner of the cell: 0 to 1, and exactly 0 or 1 in its faces. Both cells of a face
//! get the same numbers for what lies in it, as each is rounded once.
//!
//! What lies before the first cell of a row is a piece, too, of a cell numbered 0: rays along lines pass through it. The cells of a window are numbered from 1.
//!
//! Cost: a split for each plane that a facet crosses; some 150 bytes a piece, which are used again.

use std::ops::Range;

use super::polygon::{FIRST_FACE, MOST, Polygon, Whole};
use hexcast_core::base::sort::{by_number, sort_by_key};
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::window::CellWindow;

/// Where the cells of a window are, in units.
pub(super) struct Grid<'a> {
    pub(super) frame: &'a Frame,
    pub(super) window: CellWindow,
    /// The faces of all cells of the box, along each axis.
    pub(super) faces: [Vec<i32>; 3],
    /// What units are multiplied by where all cells are equal: their size is a power of two.
    pub(super) scale: Option<f64>,
}

impl Grid<'_> {
    pub(super) fn new(frame: &Frame, window: CellWindow) -> Grid<'_> {
        let faces = [0, 1, 2].map(|axis| (0..=frame.dims[axis]).map(|cell| frame.face(axis, cell)).collect());
        let scale = (!frame.is_graded()).then(|| 1.0 / f64::from(1 << frame.fraction_bits));
        Grid { frame, window, faces, scale }
    }

    /// The cell of an axis that a place is in, as a number of the box: -1 before the first, their number behind the last.
    #[inline(always)]
    pub(super) fn cell(&self, axis: usize, place: i32) -> i32 {
        let faces = &self.faces[axis];
        let n = faces.len() as i32 - 1;
        if self.frame.is_graded() {
            return faces.partition_point(|&face| face <= place) as i32 - 1;
        }
        (((i64::from(place) - i64::from(faces[0])) >> self.frame.fraction_bits) as i32).clamp(-1, n)
    }

    /// Cells of the window in some of its planes across z, along each axis, as numbers of the box.
    pub(super) fn cells_of(&self, planes: &Range<u32>) -> [Range<i32>; 3] {
        let [first, end] = [self.window.first, self.window.end].map(|of| of.map(|cell| cell as i32));
        [first[0]..end[0], first[1]..end[1], first[2] + planes.start as i32..first[2] + planes.end as i32]
    }

    /// Number of planes of cells across z.
    pub(super) fn n_planes(&self) -> u32 {
        self.window.end[2] - self.window.first[2]
    }

    /// The planes of the window across z that each facet reaches, counted from the first.
    pub(super) fn planes_of(&self, facet: usize) -> Range<u32> {
        let places = self.frame.facets[facet].map(|corner| corner[2]);
        let [low, high] = [i32::min, i32::max].map(|of| places.into_iter().reduce(of).unwrap_or(0));
        let [first, end] = [self.window.first[2], self.window.end[2]].map(|plane| plane as i32);
        let (low, high) = (self.cell(2, low).max(first), (self.cell(2, high) + 1).min(end));
        if low < high { (low - first) as u32..(high - first) as u32 } else { 0..0 }
    }
}

/// What of a facet lies in a cell.
#[derive(Clone, Copy, Default)]
pub(super) struct Piece {
    /// `cell of the row << 32 | rank << 16 | position`.
    key: u64,
    /// Its first corner.
    start: u32,
    facet: u32,
    n: u8,
    /// Signs of the normal of its facet.
    pub(super) signs: [i8; 3],
    /// What it adds to winding numbers, where volumes alone are measured.
    pub(super) rise: Rise,
}

/// What a piece adds to the winding number of its surface, counted from that at corner 0 of the cell.
#[derive(Clone, Copy, Default)]
pub(super) struct Rise {
    /// To its integral over the cell.
    pub(super) sum: i64,
    /// To that at each corner.
    pub(super) corners: [i8; 8],
    /// Edges of the facet that pass through the cell: bit 0 for that from its first corner to its second.
    pub(super) edges: u8,
}

impl Piece {
    /// Of a facet in a row, without corners yet.
    pub(super) fn new(grid: &Grid, facet: u32, signs: [i8; 3]) -> Piece {
        let Frame { position_of_facet, .. } = grid.frame;
        let position = position_of_facet[facet as usize];
        let key = u64::from(grid.frame.rank_of_facet(facet as usize)) << 16 | u64::from(position);
        Piece { key, facet, signs, ..Piece::default() }
    }

    /// The same in a cell of a row, counted from 1.
    #[inline(always)]
    pub(super) fn in_cell(&self, cell: u32) -> Piece {
        Piece { key: u64::from(cell) << 32 | self.key, ..*self }
    }

    /// Whether its corners are known.
    pub(super) fn has_corners(&self) -> bool {
        self.n > 0
    }

    /// The cell of its row, counted from 1.
    pub(super) fn cell(&self) -> u32 {
        (self.key >> 32) as u32
    }

    pub(super) fn rank(&self) -> u8 {
        (self.key >> 16) as u8
    }

    pub(super) fn position(&self) -> u16 {
        self.key as u16
    }

    /// The facet that it is a part of.
    pub(super) fn facet(&self) -> u32 {
        self.facet
    }
}

/// The pieces of some planes.
#[derive(Default)]
pub(super) struct Pieces {
    corners: Vec<[f64; 3]>,
    /// What each side lies on: that from a corner to the next. 0 for the inside of the cell, else 1 more than the number of a face.
    sides: Vec<u8>,
    found: Vec<(u32, Piece)>,
    firsts: Vec<u32>,
    sorted: Vec<Piece>,
}

impl Pieces {
    /// Finds those of some facets in some planes of the window across z.
    pub(super) fn find(&mut self, grid: &Grid, facets: &[u32], planes: Range<u32>) {
        let Grid { frame, window, .. } = grid;
        self.begin();
        let [nx, ny] = [0, 1].map(|axis| (window.end[axis] - window.first[axis]) as i32);
        let first = window.first.map(|cell| cell as i32);
        let of_planes = first[2] + planes.start as i32..first[2] + planes.end as i32;
        // of planes, of rows and of cells
        let [mut of_z, mut of_y, mut of_x] = [const { [Polygon::EMPTY; 3] }; 3];
        for &facet in facets {
            let Some(whole) = Whole::new(&frame.facets[facet as usize]) else { continue };
            let piece = Piece::new(grid, facet, whole.signs());
            slices(&whole.polygon(), &whole, (grid, 2), (of_planes.clone(), &mut of_z), |z, polygon| {
                slices(polygon, &whole, (grid, 1), (first[1]..first[1] + ny, &mut of_y), |y, polygon| {
                    let row = ((z - of_planes.start) * ny + y - first[1]) as u32;
                    let mut add = |x: i32, polygon: &Polygon| {
                        let piece = piece.in_cell((x - first[0] + 1) as u32);
                        let piece = self.cut(polygon, grid, [x, y, z], piece);
                        self.add(row, piece);
                    };
                    before(polygon, &whole, (grid, 0), (first[0], &mut of_x), |polygon| add(first[0] - 1, polygon));
                    slices(polygon, &whole, (grid, 0), (first[0]..first[0] + nx, &mut of_x), add);
                });
            });
        }
        self.put_in_order(planes.len() * ny as usize);
    }

    /// Forgets all.
    pub(super) fn begin(&mut self) {
        self.corners.clear();
        self.sides.clear();
        self.found.clear();
    }

    /// Adds a piece to a row.
    #[inline(always)]
    pub(super) fn add(&mut self, row: u32, piece: Piece) {
        self.found.push((row, piece));
    }

    /// Puts all that were added in order.
    pub(super) fn put_in_order(&mut self, n_rows: usize) {
        by_number(self.found.iter().copied(), n_rows, &mut self.firsts, &mut self.sorted);
        for row in 0..n_rows {
            let of_row = self.firsts[row] as usize..self.firsts[row + 1] as usize;
            sort_by_key(&mut self.sorted[of_row], |piece| piece.key);
        }
    }

    /// Gives a piece the corners of a polygon in a cell.
    pub(super) fn cut(&mut self, polygon: &Polygon, grid: &Grid, cell: [i32; 3], piece: Piece) -> Piece {
        let start = self.corners.len();
        // along x before the first cell of a window there may be none
        let at = [0, 1, 2].map(|axis| (cell[axis].max(0) as usize).min(grid.faces[axis].len() - 2));
        let low = [0, 1, 2].map(|axis| grid.faces[axis][at[axis]]);
        let size = [0, 1, 2].map(|axis| f64::from(grid.faces[axis][at[axis] + 1] - low[axis]));
        let mut corners = [[0.0; 3]; MOST];
        let mut first = 0;
        for index in 0..polygon.n {
            let (whole, part) = (&polygon.whole[index], &polygon.part[index]);
            for axis in 0..3 {
                let place = f64::from(whole[axis].wrapping_sub(low[axis])) + part[axis];
                corners[index][axis] = grid.scale.map_or_else(|| place / size[axis], |scale| place * scale);
            }
            if corners[index] < corners[first] {
                first = index;
            }
        }
        // from the least corner on: whatever was cut off before
        let sides = polygon.side.map(|side| (side + 1).saturating_sub(FIRST_FACE));
        let at = |index: usize| if first + index < polygon.n { first + index } else { first + index - polygon.n };
        self.corners.extend((0..polygon.n).map(|index| corners[at(index)]));
        self.sides.extend((0..polygon.n).map(|index| sides[at(index)]));
        Piece { start: start as u32, n: polygon.n as u8, ..piece }
    }

    /// The pieces of a row, in the order of cells, then of ranks and positions.
    pub(super) fn of_row(&self, row: usize) -> &[Piece] {
        &self.sorted[self.firsts[row] as usize..self.firsts[row + 1] as usize]
    }

    /// One of all pieces in their order.
    pub(super) fn piece(&self, at: usize) -> &Piece {
        &self.sorted[at]
    }

    /// One that is changed.
    pub(super) fn piece_mut(&mut self, at: usize) -> &mut Piece {
        &mut self.sorted[at]
    }

    /// How many cells they lie in.
    pub(super) fn n_cells(&self) -> usize {
        let rows = self.firsts.windows(2).map(|of| &self.sorted[of[0] as usize..of[1] as usize]);
        rows.map(|of_row| of_row.chunk_by(|one, other| one.cell() == other.cell()).count()).sum()
    }

    /// Where the pieces of a row are among all.
    pub(super) fn places_of_row(&self, row: usize) -> Range<usize> {
        self.firsts[row] as usize..self.firsts[row + 1] as usize
    }

    /// The corners of a piece.
    #[inline(always)]
    pub(super) fn corners(&self, piece: &Piece) -> &[[f64; 3]] {
        &self.corners[piece.start as usize..][..usize::from(piece.n)]
    }

    /// What the sides of a piece lie on: from each corner to the next. 0 for the inside of the cell, else 1 more than the number of a face: below and above along
    /// x, then y, then z.
    #[inline(always)]
    pub(super) fn sides(&self, piece: &Piece) -> &[u8] {
        &self.sides[piece.start as usize..][..usize::from(piece.n)]
    }
}

/// Calls `each` with the cells of an axis that a polygon reaches, of some, and with what lies in each; in memory that is used again.
#[inline(always)]
pub(super) fn slices(
    polygon: &Polygon,
    of: &Whole,
    along: (&Grid, usize),
    (cells, memory): (Range<i32>, &mut [Polygon; 3]),
    each: impl FnMut(i32, &Polygon),
) {
    slices_but(polygon, of, along, (cells, 0..0, memory), each);
}

/// The same but for a range of cells.
#[inline(always)]
pub(super) fn slices_but(
    polygon: &Polygon,
    of: &Whole,
    (grid, axis): (&Grid, usize),
    (cells, but, [within, rest, next]): (Range<i32>, Range<i32>, &mut [Polygon; 3]),
    mut each: impl FnMut(i32, &Polygon),
) {
    let [low, high] = polygon.reach(axis).map(|place| grid.cell(axis, place));
    if high < cells.start || low >= cells.end {
        return;
    }
    if low == high {
        if !but.contains(&low) {
            each(low, polygon);
        }
        return;
    }
    let faces = &grid.faces[axis];
    let (mut rest, mut next) = (rest, next);
    let mut is_first = true;
    if low < cells.start {
        polygon.split(of, (axis, faces[cells.start as usize]), within, rest);
        is_first = false;
    }
    let mut cell = low.max(cells.start);
    while cell < high {
        let current = if is_first { polygon } else { &*rest };
        let is_left_out = but.contains(&cell);
        let end = if is_left_out { but.end } else { cell + 1 };
        if end > high {
            return;
        }
        current.split(of, (axis, faces[end as usize]), within, next);
        if !is_left_out {
            each(cell, within);
        }
        cell = end;
        if cell >= cells.end {
            return;
        }
        std::mem::swap(&mut rest, &mut next);
        is_first = false;
    }
    if !but.contains(&cell) {
        each(cell, if is_first { polygon } else { rest });
    }
}

/// Calls `each` with what of a polygon lies before a cell.
pub(super) fn before(
    polygon: &Polygon,
    of: &Whole,
    (grid, axis): (&Grid, usize),
    (first, [below, above, _]): (i32, &mut [Polygon; 3]),
    each: impl FnOnce(&Polygon),
) {
    let [low, high] = polygon.reach(axis).map(|place| grid.cell(axis, place));
    if low >= first {
        return;
    }
    if high < first {
        return each(polygon);
    }
    polygon.split(of, (axis, grid.faces[axis][first as usize]), below, above);
    each(below);
}
