//! Cells whose closed box a facet touches: a box of cells is halved until nothing of it is touched or one cell is left.
//!
//! A box and a facet are apart exactly if a plane separates them that is a face of the box, the facet's own, or parallel to an edge
//! of both: 13 directions, in whole numbers of less than 2^83.

use std::ops::Range;

use super::ray::{Facet, n_below, normal};

/// Calls `found` for every cell of a box that a facet touches; `faces` are those of the cells of each axis, one more than these.
pub(super) fn touched(facet: &Facet, faces: [&[i32]; 3], cells: &[Range<u32>; 3], mut found: impl FnMut([u32; 3])) {
    let near = [0, 1, 2].map(|axis| {
        let [p, q, r] = facet.map(|corner| i64::from(corner[axis]));
        let first = n_below(faces[axis], p.min(q).min(r)).saturating_sub(1) as u32;
        let end = n_below(faces[axis], p.max(q).max(r) + 1) as u32;
        first.max(cells[axis].start)..end.min(cells[axis].end)
    });
    let mut boxes = if near.iter().any(Range::is_empty) { Vec::new() } else { vec![near] };
    let slabs = slabs(facet);
    while let Some(cells) = boxes.pop() {
        let ends = [0, 1, 2].map(|axis| [cells[axis].start, cells[axis].end].map(|face| faces[axis][face as usize]));
        if slabs.iter().any(|slab| is_apart(slab, ends)) {
            continue;
        }
        let longest = (0..3).max_by_key(|&axis| cells[axis].len()).unwrap_or(0);
        if cells[longest].len() == 1 {
            found([0, 1, 2].map(|axis: usize| cells[axis].start));
            continue;
        }
        let middle = cells[longest].start + cells[longest].len() as u32 / 2;
        for half in [cells[longest].start..middle, middle..cells[longest].end] {
            let mut cells = cells.clone();
            cells[longest] = half;
            boxes.push(cells);
        }
    }
}

/// The directions, and how far the facet reaches along each.
fn slabs(facet: &Facet) -> Vec<([i128; 3], [i128; 2])> {
    let corners = facet.map(|corner| corner.map(i64::from));
    let mut directions = vec![normal(&corners), [1, 0, 0], [0, 1, 0], [0, 0, 1]];
    for (from, to) in [(0, 1), (1, 2), (2, 0)] {
        let [x, y, z] = [0, 1, 2].map(|axis: usize| corners[to][axis] - corners[from][axis]);
        directions.extend([[0, -z, y], [z, 0, -x], [-y, x, 0]]);
    }
    let slab = |direction: [i64; 3]| {
        let direction = direction.map(i128::from);
        let [p, q, r] = corners.map(|at| (0..3).map(|axis| direction[axis] * i128::from(at[axis])).sum::<i128>());
        (direction, [p.min(q).min(r), p.max(q).max(r)])
    };
    directions.into_iter().map(slab).collect()
}

fn is_apart((direction, [low, high]): &([i128; 3], [i128; 2]), ends: [[i32; 2]; 3]) -> bool {
    let (mut least, mut most) = (0, 0);
    for axis in 0..3 {
        let [one, other] = ends[axis].map(|end| direction[axis] * i128::from(end));
        (least, most) = (least + one.min(other), most + one.max(other));
    }
    most < *low || *high < least
}
