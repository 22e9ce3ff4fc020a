//! Areas that are small beside their edges are enlarged, and the faces behind these edges give what that takes.
//!
//! A face lacks what it has less than a part of its longest edge's fraction. It takes that from the face on the other side of this edge, as far as that has
//! more than it needs itself; where several take from one, each gets the same share. So the numbers of a face depend on those of faces at most two away, in no order: windows have those of the box.

use hexcast_core::base::sort::{sort_by, sort_by_key};

use super::places::{Grid, Outside, edges_of_face};

/// The faces that became larger, by axis: the number of each, and whether others gave all that it lacked.
pub(super) type Enlarged = [Vec<(u64, bool)>; 3];

/// Keeps every face at least `stable` times as large as its longest edge is long, in fractions.
pub(super) fn enlarged(outside: &mut [Outside; 6], cells: [u32; 3], stable: f64) -> Enlarged {
    let mut enlarged = Enlarged::default();
    if stable <= 0.0 {
        return enlarged;
    }
    for axis in 0..3 {
        let faces = Faces { outside, axis, grid: Grid::of_part(cells, 3 + axis), cells, stable };
        // who takes what, by who gives
        let mut taken: Vec<(Option<u64>, u64, f64)> = Vec::new();
        for &(face, area) in faces.outside[3 + axis].all() {
            let lack = faces.least(face) - area;
            if area > 0.0 && lack > 0.0 {
                taken.push((faces.giver(face, lack), face, lack));
            }
        }
        sort_by_key(&mut taken, |&(giver, face, _)| (giver, face));
        let mut other = Vec::with_capacity(2 * taken.len());
        for of_giver in taken.chunk_by(|one, other| one.0 == other.0) {
            let all: f64 = of_giver.iter().map(|(.., lack)| lack).sum();
            let spare = of_giver[0].0.map_or(0.0, |giver| (faces.area(giver) - faces.least(giver)).max(0.0));
            if let Some(giver) = of_giver[0].0 {
                other.push((giver, faces.area(giver) - all.min(spare)));
            }
            other.extend(of_giver.iter().map(|&(_, face, _)| (face, faces.least(face))));
            enlarged[axis].extend(of_giver.iter().map(|&(_, face, _)| (face, all <= spare)));
        }
        sort_by_key(&mut other, |(face, _)| *face);
        outside[3 + axis].set(other);
    }
    enlarged
}

/// The faces across an axis.
struct Faces<'a> {
    outside: &'a [Outside; 6],
    axis: usize,
    grid: Grid,
    cells: [u32; 3],
    stable: f64,
}

impl Faces<'_> {
    /// What is not listed lies beside cells without metal, where it is asked for: behind an edge that is outside metal.
    fn area(&self, face: u64) -> f64 {
        self.outside[3 + self.axis].get(face).unwrap_or(1.0)
    }

    /// The edges of a face: the axis along each, its place, and its fraction.
    fn edges(&self, face: u64) -> [(usize, [u32; 3], f64); 4] {
        edges_of_face(self.axis, self.grid.place(face)).map(|(along, place)| {
            let index = Grid::of_part(self.cells, along).index(place);
            (along, place, self.outside[along].get(index).unwrap_or(1.0))
        })
    }

    /// The least area of a face.
    fn least(&self, face: u64) -> f64 {
        self.stable * self.edges(face).into_iter().map(|(.., length)| length).fold(0.0, f64::max)
    }

    /// The face behind the longest edge of a face that has one with enough to spare for what it lacks, or, if there is none, with something to spare.
    fn giver(&self, face: u64, lack: f64) -> Option<u64> {
        let place = self.grid.place(face);
        let mut edges = self.edges(face);
        sort_by(&mut edges, |one, other| one.2 > other.2 || (one.2 == other.2 && (one.0, one.1) < (other.0, other.1)));
        let behind = edges.into_iter().filter(|(.., length)| *length > 0.0).filter_map(|(along, edge, _)| {
            let across = 3 - self.axis - along;
            let mut giver = place;
            // an edge on the lower side has the place of its face
            giver[across] = if edge == place { place[across].checked_sub(1)? } else { place[across] + 1 };
            (giver[across] < self.cells[across]).then(|| self.grid.index(giver))
        });
        let spare = behind.map(|giver| (giver, self.area(giver) - self.least(giver))).collect::<Vec<(u64, f64)>>();
        let has_enough = spare.iter().find(|(_, spare)| *spare >= lack);
        has_enough.or_else(|| spare.iter().find(|(_, spare)| *spare > 0.0)).map(|(giver, _)| *giver)
    }
}
