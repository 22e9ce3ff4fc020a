//! A cell cut flat: which of its corners are in the fluid says how its faces and its surface run from crossing to crossing.
//!
//! Corners in the fluid -> bodies, polygons on faces, loops of the surface, all of them [`Vertex`] after vertex. On a face the surface goes straight from crossing to crossing; where two opposite corners
//! alone are in the fluid, it parts them. So what is on a face depends on its four corners alone, and both cells see the same. The corners of the fluid that edges of the cell join
//! make a body; the surface closes each with loops over the segments on the faces.
//!
//! Corners, edges and faces are numbered as in [`crate::mesh::outline`]; all polygons run against the clock as seen from outside of the fluid.
//!
//! Source: marching cubes, Lorensen and Cline (1987), whose ambiguous faces are all decided alike here.

use crate::cut_cells::edges::{ACROSS, ends_of};

/// A corner of the cell (0 to 7), the crossing of an edge (8 + its number), or where the surface bends on a face (20 + its number), if it does.
pub(in crate::cut_cells) type Vertex = u8;
/// Number of the crossing of the first edge.
pub(in crate::cut_cells) const CROSSING: u8 = 8;
/// Number of the bend on the first face.
pub(in crate::cut_cells) const BEND: u8 = 20;
/// Vertices of a polygon on a face, at most.
const MOST: usize = 6;
/// Of a loop: all crossings, each with a bend.
const MOST_OF_LOOP: usize = 24;

/// The corners of each face, against the clock as seen from outside of the cell.
const FACES: [[u8; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

/// Vertices on a face of a cell.
#[derive(Clone, Copy, Default)]
pub(in crate::cut_cells) struct OnFace {
    vertices: [Vertex; MOST],
    n: usize,
}

impl OnFace {
    fn push(&mut self, vertex: Vertex) {
        self.vertices[self.n] = vertex;
        self.n += 1;
    }

    pub(in crate::cut_cells) fn vertices(&self) -> &[Vertex] {
        &self.vertices[..self.n]
    }

    /// One of its corners that is in the fluid.
    pub(super) fn corner(&self) -> usize {
        self.vertices().iter().find(|vertex| **vertex < CROSSING).map_or(0, |vertex| usize::from(*vertex))
    }
}

/// The edge between two corners.
fn edge(one: u8, other: u8) -> u8 {
    let low = one.min(other);
    match one ^ other {
        1 => low >> 1 & 3,
        2 => 4 + (low & 1 | low >> 1 & 2),
        _ => 8 + (low & 3),
    }
}

/// The polygons of the fluid on a face: none, one or two.
pub(in crate::cut_cells) fn polygons(fluid: u8, face: usize) -> impl Iterator<Item = OnFace> {
    let corners = FACES[face];
    let is_fluid = move |at: usize| fluid >> corners[at % 4] & 1 == 1;
    let is_whole = (0..4).all(is_fluid);
    // a polygon begins where a corner of the fluid follows another
    (0..4).filter(move |&at| if is_whole { at == 0 } else { is_fluid(at) && !is_fluid(at + 3) }).map(move |start| {
        let mut polygon = OnFace::default();
        if !is_whole {
            polygon.push(CROSSING + edge(corners[(start + 3) % 4], corners[start]));
        }
        let mut at = start;
        while at < start + 4 && is_fluid(at) {
            polygon.push(corners[at % 4]);
            at += 1;
        }
        if !is_whole {
            polygon.push(CROSSING + edge(corners[(at + 3) % 4], corners[at % 4]));
            polygon.push(BEND + face as u8);
        }
        polygon
    })
}

/// The bodies of the fluid in a cell: how many, and which each corner is in.
pub(in crate::cut_cells) fn bodies(fluid: u8) -> (u8, [u8; 8]) {
    let (mut n, mut of, mut left) = (0, [0; 8], fluid);
    while left != 0 {
        let mut body = left & left.wrapping_neg();
        loop {
            let along = |step: u32, low: u8| (body & low) << step | body >> step & low;
            let more = (body | along(1, 0x55) | along(2, 0x33) | along(4, 0x0f)) & fluid;
            if more == body {
                break;
            }
            body = more;
        }
        (0..8).filter(|corner| body >> corner & 1 == 1).for_each(|corner| of[corner] = n);
        left &= !body;
        n += 1;
    }
    (n, of)
}

/// The loops of the surface in a cell, each with a corner of the body that it closes: crossings, and between two of them the bend of their face.
pub(in crate::cut_cells) fn loops(fluid: u8, mut each: impl FnMut(usize, &[Vertex])) {
    // of each crossing the next, and the face on which it is
    let (mut next, mut on) = ([u8::MAX; 12], [0; 12]);
    for face in 0..6 {
        for polygon in polygons(fluid, face) {
            if let [first, .., last, _] = *polygon.vertices()
                && first >= CROSSING
            {
                let first = usize::from(first - CROSSING);
                (next[first], on[first]) = (last - CROSSING, face as u8);
            }
        }
    }
    for start in 0..12u8 {
        if next[usize::from(start)] == u8::MAX {
            continue;
        }
        let (mut vertices, mut n, mut at) = ([0; MOST_OF_LOOP], 0, start);
        while next[usize::from(at)] != u8::MAX {
            (vertices[n], vertices[n + 1], n) = (CROSSING + at, BEND + on[usize::from(at)], n + 2);
            at = std::mem::replace(&mut next[usize::from(at)], u8::MAX);
        }
        each(corner_of(fluid, start), &vertices[..n]);
    }
}

/// A place on a face, given along its two axes.
pub(in crate::cut_cells) fn on_face(face: u8, at: [f64; 2]) -> [f64; 3] {
    let mut place = [f64::from(face % 2); 3];
    let [first, second] = ACROSS[usize::from(face / 2)];
    [place[first], place[second]] = at;
    place
}

/// The end of an edge that is in the fluid.
fn corner_of(fluid: u8, edge: u8) -> usize {
    let [low, high] = ends(edge);
    usize::from(if fluid >> low & 1 == 1 { low } else { high })
}

/// The corners at the ends of an edge.
pub(in crate::cut_cells) fn ends(edge: u8) -> [u8; 2] {
    ends_of(edge.into()).map(|corner| corner as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_cell_is_closed() {
        for fluid in 0..=u8::MAX {
            // each segment is passed once each way, by polygons of one body
            let (n, of) = bodies(fluid);
            let mut segments: Vec<(Vertex, Vertex, u8)> = Vec::new();
            let mut add = |vertices: &[Vertex], body: u8| {
                for (at, &vertex) in vertices.iter().enumerate() {
                    segments.push((vertex, vertices[(at + 1) % vertices.len()], body));
                }
            };
            for face in 0..6 {
                polygons(fluid, face).for_each(|polygon| add(polygon.vertices(), of[polygon.corner()]));
            }
            loops(fluid, |corner, vertices| {
                assert!(vertices.len() >= 6);
                add(vertices, of[corner]);
            });
            let mut back: Vec<_> = segments.iter().map(|&(from, to, body)| (to, from, body)).collect();
            segments.sort_unstable();
            back.sort_unstable();
            assert_eq!(segments, back, "{fluid:08b}");
            assert!(segments.windows(2).all(|two| two[0] != two[1]), "{fluid:08b}");
            let used: std::collections::BTreeSet<u8> = segments.iter().map(|of| of.2).collect();
            assert_eq!(used.len(), usize::from(n), "{fluid:08b}");
        }
    }

    #[test]
    fn edges_are_those_of_their_ends() {
        for number in 0..12 {
            let [low, high] = ends(number);
            assert_eq!(edge(low, high), number);
            assert_eq!(edge(high, low), number);
            assert_eq!([low, high].map(usize::from), ends_of(number.into()));
        }
    }
}
