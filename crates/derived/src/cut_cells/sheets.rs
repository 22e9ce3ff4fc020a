//! Volumes alone, fast: what pieces add to the integral of a winding number, and cells in which that says all.
//!
//! Facets, planes of a window -> [`Pieces`] with what each adds ([`Rise`]) -> [`Shares`].
//!
//! # Theory
//! The integral of the winding number over a cell is a sum over its pieces and the number at corner 0 (`winding.rs`): so each piece is measured where it is found. A facet that
//! crosses a column from side to side gives closed forms (`across.rs`), and has corners only in cells with several pieces. Where there is one piece, or a sheet of several, the cell has two sides.
//! All others are measured by `cells.rs`.
//!
//! Cost: 40 bytes a cell that a facet crosses from side to side; others as in `pieces.rs`.

use std::ops::Range;

use super::across::Across;
use super::cells::{Scene, Shares, State};
use super::edges::{at_corners, crossings, upper_edge_of};
use super::integrals::*;
use super::pieces::{Grid, Piece, Pieces, Rise, before, slices, slices_but};
use super::polygon::{FIRST_FACE, Polygon, Whole};
use super::winding::{Two, hang_together, is_divided, strips_of};
use hexcast_core::grid::frame::Frame;

/// The face that columns of pieces end at.
const UPPER: usize = 5;

/// Finds the pieces of some facets in some planes of the window across z, each with its rise; it has no corners where it is alone in a cell that its facet crosses from side to side.
pub(super) fn find_sheets(pieces: &mut Pieces, grid: &Grid, facets: &[u32], planes: Range<u32>) {
    pieces.begin();
    let cells = grid.cells_of(&planes);
    let mut memory = [const { [Polygon::EMPTY; 3] }; 4];
    for &facet in facets {
        let Some(whole) = Whole::new(&grid.frame.facets[facet as usize]) else { continue };
        let piece = Piece::new(grid, facet, whole.signs());
        Finder { pieces, grid, cells: &cells, whole: &whole, piece }.find(&mut memory);
    }
    let n_rows = cells[2].len() * cells[1].len();
    pieces.put_in_order(n_rows);
    for row in 0..n_rows {
        let of_row = pieces.places_of_row(row);
        let [y, z] = [row % cells[1].len(), row / cells[1].len()].map(|of| of as i32);
        for at in of_row.clone() {
            let piece = pieces.piece(at);
            let is_in_cell = |other: usize| of_row.contains(&other) && pieces.piece(other).cell() == piece.cell();
            if !piece.has_corners() && (is_in_cell(at.wrapping_sub(1)) || is_in_cell(at + 1)) {
                let x = piece.cell() as i32 - 1;
                give_corners(pieces, grid, [cells[0].start + x, cells[1].start + y, cells[2].start + z], at);
            }
        }
    }
}

/// Gives a piece its corners in a cell.
fn give_corners(pieces: &mut Pieces, grid: &Grid, cell: [i32; 3], at: usize) {
    let piece = *pieces.piece(at);
    let Some(whole) = Whole::new(&grid.frame.facets[piece.facet() as usize]) else { return };
    let mut memory = [Polygon::EMPTY; 3];
    let polygon = whole.polygon();
    let of_cell = [2, 1, 0].map(|axis| (axis, cell[axis]..cell[axis] + 1));
    if let Some(polygon) = clipped(&polygon, &whole, grid, &of_cell, &mut memory) {
        *pieces.piece_mut(at) = pieces.cut(polygon, grid, cell, piece);
    }
}

/// What of a polygon lies in some cells of axes.
fn clipped<'a>(
    polygon: &'a Polygon,
    of: &Whole,
    grid: &Grid,
    cells: &[(usize, Range<i32>)],
    memory: &'a mut [Polygon; 3],
) -> Option<&'a Polygon> {
    let [mut current, mut below, mut above] = memory.each_mut();
    let mut is_whole = true;
    for &(axis, Range { start, end }) in cells {
        let reach = if is_whole { polygon } else { &*current }.reach(axis);
        let [low, high] = reach.map(|place| grid.cell(axis, place));
        if high < start || low >= end {
            return None;
        }
        if low < start {
            let from = if is_whole { polygon } else { &*current };
            from.split(of, (axis, grid.faces[axis][start as usize]), below, above);
            std::mem::swap(&mut current, &mut above);
            is_whole = false;
        }
        if high >= end {
            let from = if is_whole { polygon } else { &*current };
            from.split(of, (axis, grid.faces[axis][end as usize]), below, above);
            std::mem::swap(&mut current, &mut below);
            is_whole = false;
        }
    }
    Some(if is_whole { polygon } else { current })
}

/// A facet whose pieces are found.
struct Finder<'a> {
    pieces: &'a mut Pieces,
    grid: &'a Grid<'a>,
    cells: &'a [Range<i32>; 3],
    whole: &'a Whole,
    piece: Piece,
}

impl Finder<'_> {
    fn find(&mut self, [within, outer, inner, last]: &mut [[Polygon; 3]; 4]) {
        let Finder { grid, cells: [of_x, of_y, of_z], whole, .. } = *self;
        let polygon = whole.polygon();
        let of_planes = [(2, of_z.clone()), (1, of_y.clone())];
        let Some(polygon) = clipped(&polygon, whole, grid, &of_planes, within) else { return };
        before(polygon, whole, (grid, 0), (of_x.start, last), |polygon| {
            slices(polygon, whole, (grid, 2), (of_z.clone(), outer), |z, polygon| {
                slices(polygon, whole, (grid, 1), (of_y.clone(), inner), |y, polygon| {
                    self.add_cut(polygon, [of_x.start - 1, y, z]);
                });
            });
        });
        let across = Across::new(whole, 1 << grid.frame.fraction_bits);
        let (axis, [u, v]) = (across.axis, across.others);
        let cells = self.cells;
        slices(polygon, whole, (grid, v), (cells[v].clone(), outer), |row, slab| {
            let crossed = self.crossed(&across, row, slab);
            slices_but(slab, whole, (grid, u), (cells[u].clone(), crossed, inner), |column, polygon| {
                slices(polygon, whole, (grid, axis), (cells[axis].clone(), last), |level, polygon| {
                    let mut cell = [0; 3];
                    (cell[u], cell[v], cell[axis]) = (column, row, level);
                    self.add_cut(polygon, cell);
                });
            });
        });
    }

    fn add(&mut self, cell: [i32; 3], piece: Piece) {
        let [x, y, z] = [0, 1, 2].map(|axis| cell[axis] - self.cells[axis].start);
        let ny = self.cells[1].len() as i32;
        self.pieces.add((z * ny + y) as u32, piece.in_cell((x + 1) as u32));
    }

    /// Adds what lies in a cell.
    fn add_cut(&mut self, polygon: &Polygon, cell: [i32; 3]) {
        let mut piece = self.pieces.cut(polygon, self.grid, cell, self.piece);
        piece.rise = rise_of(self.pieces, &piece);
        for &side in polygon.side[..polygon.n].iter().filter(|side| **side < FIRST_FACE) {
            piece.rise.edges |= 1 << ((usize::from(side) + self.whole.first) % 3);
        }
        self.add(cell, piece);
    }

    /// Adds what lies in the columns of a row that the facet crosses from side to side, and returns which these are.
    fn crossed(&mut self, across: &Across, row: i32, slab: &Polygon) -> Range<i32> {
        let Finder { grid, cells, whole, piece, .. } = *self;
        let (axis, [u, v]) = (across.axis, across.others);
        let Some(scale) = grid.scale else { return 0..0 };
        let reach = slab.reach(u).map(|place| grid.cell(u, place));
        let (start, end) = (reach[0].max(cells[u].start), (reach[1] + 1).min(cells[u].end));
        if start >= end {
            return 0..0;
        }
        let low = [grid.faces[u][start as usize], grid.faces[v][row as usize]];
        let columns = across.columns(low, (end - start).into());
        let crossed = start + columns.start as i32..start + columns.end as i32;
        let met = |column: i32| {
            let face = (u, i64::from(grid.faces[u][column as usize]));
            [0, 1].map(|end| whole.on_line([face, (v, grid.faces[v][row as usize + end].into())], axis))
        };
        let (bits, floor) = (grid.frame.fraction_bits, grid.faces[axis][0]);
        let sign = piece.signs[axis];
        let mut near = if crossed.is_empty() { [(0, 0.0); 2] } else { met(crossed.start) };
        for column in crossed.clone() {
            let far = met(column + 1);
            let corners = [near[0], far[0], near[1], far[1]];
            near = far;
            let levels = corners.map(|(place, _)| (place - floor) >> bits);
            let [lowest, highest] = [i32::min, i32::max].map(|of| levels.into_iter().fold(levels[0], of));
            let base = floor + (lowest << bits);
            let heights = corners.map(|(place, part)| (f64::from(place - base) + part) * scale);
            let below = |level: i32| across.below(&heights.map(|height| height - f64::from(level - lowest)));
            let some = lowest.max(cells[axis].start)..(highest + 1).min(cells[axis].end);
            let mut more = below(some.start);
            for level in some {
                let less = below(level + 1);
                let part = fixed(more - less).clamp(0, WHOLE);
                more = less;
                let are_above = [levels.map(|of| of < level), levels.map(|of| of <= level)];
                let is_above = |corner: usize| {
                    let [end, at] = across.corners[corner];
                    are_above[usize::from(end)][usize::from(at)]
                };
                // less behind the facet than before it
                let first = if is_above(0) { sign } else { 0 };
                let at_corners = std::array::from_fn(|corner| if is_above(corner) { first - sign } else { first });
                let sum = part * i64::from(first) + (WHOLE - part) * i64::from(first - sign);
                let mut cell = [0; 3];
                (cell[u], cell[v], cell[axis]) = (column, row, level);
                let mut of_cell = piece;
                of_cell.rise = Rise { sum, corners: at_corners, edges: 0 };
                self.add(cell, of_cell);
            }
        }
        crossed
    }
}

/// What a piece adds.
fn rise_of(pieces: &Pieces, piece: &Piece) -> Rise {
    let (mut losses, mut sum) = ([0; 12], [fixed(below_polygon(pieces.corners(piece)).0[0])]);
    crossings(pieces, piece, |crossing| {
        losses[usize::from(crossing.edge)] += i32::from(crossing.sign);
        if usize::from(crossing.edge) == upper_edge_of(UPPER) {
            add(&mut sum, [crossing.at], crossing.sign.into());
        }
    });
    if pieces.sides(piece).contains(&(UPPER as u8 + 1)) {
        for strip in strips_of(pieces, piece, UPPER) {
            add(&mut sum, [below_segment(strip.from, strip.to)[0]], strip.times);
        }
    }
    let corners = at_corners(0, &losses).map(|number| number as i8);
    Rise { sum: sum[0].wrapping_add(i64::from(corners[7]).wrapping_mul(WHOLE)), corners, edges: 0 }
}

/// Measures a cell that one surface has one sheet in, given the state at its low corner; false where it may have more.
pub(super) fn measure_sheet(
    scene: &Scene,
    (frame, pieces): (&Frame, &Pieces),
    of_cell: &[Piece],
    state: &State,
    shares: &mut Shares,
) -> bool {
    if of_cell.len() > 1 && !are_sheet(frame, pieces, of_cell) {
        return false;
    }
    let rank = of_cell[0].rank();
    let mut rise = of_cell[0].rise;
    for piece in &of_cell[1..] {
        rise.sum = rise.sum.wrapping_add(piece.rise.sum);
        rise.corners.iter_mut().zip(piece.rise.corners).for_each(|(sum, more)| *sum += more);
    }
    let low = rise.corners.iter().fold(0, |low, &at| low.min(at));
    let high = rise.corners.iter().fold(0, |high, &at| high.max(at));
    let low = if low == high && rise.sum < 0 { -1 } else { low };
    let two = Two::new((rank, state.winding(rank)), low.into(), &scene.insides);
    let rest = state.winner_without(rank);
    let own = if rest > Some(rank) { 0 } else { two.inside(rise.sum, WHOLE).clamp(0, WHOLE) };
    shares.set([(scene.flag(Some(rank)), own), (scene.flag(rest), WHOLE - own)]);
    true
}

/// Pieces of which it is found out whether they are one sheet.
const MOST_OF_SHEET: usize = 12;

/// Whether the pieces of a cell are one sheet: those of one surface that meet two by two in edges of their facets, hang together, and are on different sides where they do not meet.
fn are_sheet(frame: &Frame, pieces: &Pieces, of_cell: &[Piece]) -> bool {
    let n = of_cell.len();
    if n > MOST_OF_SHEET || of_cell[0].position() != of_cell[n - 1].position() {
        return false;
    }
    let edges = |at: usize| {
        let (facet, edges) = (&frame.facets[of_cell[at].facet() as usize], of_cell[at].rise.edges);
        (0..3).filter(move |edge| edges >> edge & 1 == 1).map(move |edge| [facet[edge], facet[(edge + 1) % 3]])
    };
    let mut beside = [0u32; MOST_OF_SHEET];
    for at in 0..n {
        for [from, to] in edges(at) {
            let mut n_others = 0;
            for other in (0..n).filter(|&other| other != at) {
                let n_common = edges(other).filter(|edge| *edge == [to, from]).count();
                n_others += n_common;
                beside[at] |= u32::from(n_common > 0) << other;
            }
            if n_others != 1 {
                return false;
            }
        }
    }
    hang_together(&beside[..n])
        && (0..n).all(|one| {
            let are_apart = |other: usize| is_divided(pieces, [&of_cell[one], &of_cell[other]]);
            (0..one).all(|other| beside[one] >> other & 1 == 1 || are_apart(other))
        })
}
