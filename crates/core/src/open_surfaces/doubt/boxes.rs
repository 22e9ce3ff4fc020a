//! Boxes of the cells of a set, plane after plane of cells.
//!
//! Rows of rays -> [`plane`]s -> [`Boxes`], the largest of which are kept. See [`crate::open_surfaces::doubt`] for which boxes.

use super::sweep::Sweep;
use crate::base::sort::sort_by_key;
use crate::cells::columns::CellRun;
use crate::grid::rays::Rays;

/// A box of cells: its first cell and its end, exclusive.
pub type Corners = [[u32; 3]; 2];

/// First and end of some cells along x, y and z, in the order in which they are sorted: by rows first.
pub(super) type Sorted = [[u32; 2]; 3];

/// Boxes of planes, which come in their order.
pub(super) struct Boxes {
    most: usize,
    finished: Vec<Sorted>,
    growing: Growing,
}

/// What may go on in the next plane, in the order of its cells.
enum Growing {
    /// Boxes that end with a plane of z.
    Boxes(Vec<Sorted>),
    /// For each row along x its cells in planes of y.
    Rows(Vec<([u32; 2], Sweep)>),
}

/// The cells of a row of rays, in order: plates of a plane of z, or, of rays along z, boxes of rows that are as long as can be.
pub(super) fn plane(rays: &Rays, of_row: &[CellRun]) -> Vec<Sorted> {
    let n = u64::from(rays.counts[0]);
    let row = of_row.first().map_or(0, |run| (run.ray / n) as u32);
    let places = of_row.iter().map(|run| ((run.ray % n) as u32, [run.start, run.end]));
    let mut rows = Vec::new();
    match rays.axis {
        0 => rows.extend(places.map(|(y, x)| [x, [y, y + 1], [row, row + 1]])),
        1 => Sweep::all(places, |y, x| rows.push([x, y, [row, row + 1]])),
        _ => Sweep::all(places, |z, x| rows.push([x, [row, row + 1], z])),
    }
    // those of a plane of z touch along y, those of a plane of y along z
    joined(if rays.axis < 2 { [0, 2, 1] } else { [0, 1, 2] }, rows)
}

impl Boxes {
    /// Keeps at most so many, the largest.
    pub(super) fn new(axis: usize, most: usize) -> Boxes {
        let growing = if axis < 2 { Growing::Boxes(Vec::new()) } else { Growing::Rows(Vec::new()) };
        Boxes { most, finished: Vec::new(), growing }
    }

    /// Adds the next plane that has cells.
    pub(super) fn add(&mut self, plane: Vec<Sorted>) {
        match &mut self.growing {
            Growing::Boxes(below) => {
                *below = stacked(std::mem::take(below), plane, &mut self.finished);
            }
            Growing::Rows(rows) => {
                *rows = swept(std::mem::take(rows), &plane, &mut self.finished);
            }
        }
        if self.finished.len() > 4096 && self.finished.len() / 2 > self.most {
            self.keep_largest();
        }
    }

    fn keep_largest(&mut self) {
        if self.finished.len() > self.most {
            sort_by_key(&mut self.finished, largest_first);
            self.finished.truncate(self.most);
        }
    }

    /// The largest, the largest first.
    pub(super) fn finish(mut self) -> Vec<Corners> {
        match std::mem::replace(&mut self.growing, Growing::Boxes(Vec::new())) {
            Growing::Boxes(below) => self.finished.extend(below),
            Growing::Rows(rows) => {
                swept(rows, &[], &mut self.finished);
            }
        }
        self.keep_largest();
        sort_by_key(&mut self.finished, largest_first);
        self.finished.iter().map(|[x, y, z]| [0, 1].map(|end: usize| [x[end], y[end], z[end]])).collect()
    }
}

/// Of equal ones the first in the order of the cells.
fn largest_first([x, y, z]: &Sorted) -> (u64, u32, u32, u32) {
    let n: u64 = [x, y, z].into_iter().map(|[first, end]| u64::from(end - first)).product();
    (u64::MAX - n, z[0], y[0], x[0])
}

/// Joins the plates of a plane of z to the boxes that end below it, which are those of the next; both are in order.
fn stacked(below: Vec<Sorted>, mut plane: Vec<Sorted>, finished: &mut Vec<Sorted>) -> Vec<Sorted> {
    let mut below = below.into_iter().peekable();
    for plate in &mut plane {
        while let Some(other) = below.next_if(|of| of[..2] < plate[..2]) {
            finished.push(other);
        }
        match below.next_if(|of| of[..2] == plate[..2]) {
            Some(same) if same[2][1] == plate[2][0] => plate[2][0] = same[2][0],
            Some(other) => finished.push(other),
            None => {}
        }
    }
    finished.extend(below);
    plane
}

/// Goes on to a plane of y, or without one to the end; rows and plane are in order.
fn swept(rows: Vec<([u32; 2], Sweep)>, plane: &[Sorted], finished: &mut Vec<Sorted>) -> Vec<([u32; 2], Sweep)> {
    let mut before = rows.into_iter().peekable();
    let mut next = Vec::new();
    let mut ended = Vec::new();
    let mut groups = plane.chunk_by(|one, next| one[0] == next[0]).peekable();
    loop {
        // the rows that end, and those that begin or go on, in one order
        let x = match (before.peek(), groups.peek()) {
            (Some((x, _)), Some(group)) if *x < group[0][0] => *x,
            (_, Some(group)) => group[0][0],
            (Some((x, _)), None) => *x,
            (None, None) => break,
        };
        let mut sweep = before.next_if(|(of, _)| *of == x).map(|(_, sweep)| sweep).unwrap_or_default();
        let mut found = |z, y| ended.push([x, y, z]);
        match groups.next_if(|group| group[0][0] == x) {
            Some(group) => {
                let own: Vec<[u32; 2]> = group.iter().map(|[_, _, z]| *z).collect();
                sweep.step(group[0][1][0], &own, &mut found);
                next.push((x, sweep));
            }
            None => sweep.finish(&mut found),
        }
        finished.append(&mut joined([0, 1, 2], std::mem::take(&mut ended)));
    }
    next
}

/// Joins boxes that differ in nothing but the last of three axes, and touch there; the result is in the order of the axes.
fn joined(axes: [usize; 3], mut boxes: Vec<Sorted>) -> Vec<Sorted> {
    let [first, second, last] = axes;
    sort_by_key(&mut boxes, |of| (packed([of[first], of[second]]), of[last][0]));
    boxes.dedup_by(|next, before| {
        let touches =
            next[first] == before[first] && next[second] == before[second] && next[last][0] == before[last][1];
        if touches {
            before[last][1] = next[last][1];
        }
        touches
    });
    boxes
}

/// Two pairs as one number, in the same order: it is compared at once.
fn packed(pairs: [[u32; 2]; 2]) -> u128 {
    pairs.as_flattened().iter().fold(0, |number, part| number << 32 | u128::from(*part))
}
