//! Boxes of what lengths, areas and volumes in cells follow from their coordinates.

use super::models::{self, Facets};

/// A box, what it is made of, and how it counts where it overlaps others.
pub(super) struct Cuboid {
    pub(super) ends: [[f64; 2]; 3],
    pub(super) priority: i32,
    pub(super) is_inverted: bool,
    pub(super) is_metal: bool,
    /// Relative permittivity.
    pub(super) eps: f64,
}

/// The ends of a box between places, which has a length along each axis.
pub(super) fn ends_between(mut place: impl FnMut() -> f64) -> [[f64; 2]; 3] {
    let mut ends = [[0.0; 2]; 3];
    for end in &mut ends {
        while end[0] == end[1] {
            *end = [place(), place()];
        }
        end.sort_by(f64::total_cmp);
    }
    ends
}

impl Cuboid {
    pub(super) fn facets(&self) -> Facets {
        let [low, high] = [0, 1].map(|end| self.ends.map(|ends| ends[end] as f32));
        models::cuboid(low, high)
    }

    fn holds(&self, point: [f64; 3]) -> bool {
        (0..3).all(|axis| (self.ends[axis][0]..self.ends[axis][1]).contains(&point[axis])) != self.is_inverted
    }
}

/// What holds a point: its index, the number of boxes for the background.
pub(super) fn holder(cuboids: &[Cuboid], point: [f64; 3]) -> usize {
    let within = cuboids.iter().enumerate().filter(|(_, of)| of.holds(point));
    within.max_by_key(|(index, of)| (of.priority, *index)).map_or(cuboids.len(), |(index, _)| index)
}

/// Middles of the stretches of a cell along an axis between the faces of boxes, and which part of it they are.
pub(super) fn stretches(cuboids: &[Cuboid], axis: usize, [low, high]: [f64; 2]) -> Vec<(f64, f64)> {
    let inner = cuboids.iter().flat_map(|of| of.ends[axis]).filter(|place| (low..high).contains(place));
    let mut places: Vec<f64> = inner.chain([low, high]).collect();
    places.sort_by(f64::total_cmp);
    places.dedup();
    places.windows(2).map(|two| (0.5 * (two[0] + two[1]), (two[1] - two[0]) / (high - low))).collect()
}
