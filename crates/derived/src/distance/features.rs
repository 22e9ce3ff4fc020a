//! The edges and corners that facets share.
//!
//! Corners of facets -> [`Features`]. Corners are one where their coordinates are the same; edges where both their corners are. What only lies close, or touches within an
//! edge, stays apart, and has more to look at for it.
//!
//! Cost: two sorts, and some 60 bytes a facet.

use hexcast_core::base::parallel::*;
use hexcast_core::base::sort::par_sort;

use super::facet::Facet;

/// No group, or one that belongs to another facet.
const NONE: u32 = u32::MAX;

/// A corner of a facet, or its edge from that to the next: three times the facet and its number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place(u32);

impl Place {
    pub(super) fn facet(self) -> usize {
        self.0 as usize / 3
    }

    pub(super) fn number(self) -> usize {
        self.0 as usize % 3
    }
}

/// Places that are one.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Groups {
    places: Vec<Place>,
    /// The first of each group in `places`, then the end.
    firsts: Vec<u32>,
    /// Of each place its group, where it is the first of it.
    of_first: Vec<u32>,
}

impl Groups {
    /// Puts places of the same key together.
    fn new<K: Ord + Copy + Send>(mut keys: Vec<(K, Place)>) -> Groups {
        par_sort(&mut keys);
        let (mut firsts, mut of_first) = (Vec::new(), vec![NONE; keys.len()]);
        let mut start = 0;
        for group in keys.chunk_by(|one, other| one.0 == other.0) {
            of_first[group[0].1.0 as usize] = firsts.len() as u32;
            firsts.push(start);
            start += group.len() as u32;
        }
        firsts.push(start);
        Groups { places: keys.into_iter().map(|(_, place)| place).collect(), firsts, of_first }
    }

    fn group(&self, group: u32) -> &[Place] {
        &self.places[self.firsts[group as usize] as usize..self.firsts[group as usize + 1] as usize]
    }

    /// The places that are one with a facet's corner or edge, if this is the first of them: so each group is met once.
    pub(super) fn begun_at(&self, facet: usize, number: usize) -> Option<&[Place]> {
        let group = self.of_first[3 * facet + number];
        (group != NONE).then(|| self.group(group))
    }
}

/// What facets share.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Features {
    pub(super) corners: Groups,
    /// Those with two corners.
    pub(super) edges: Groups,
}

impl Features {
    /// Bytes that those of so many facets take, while they are made: of each corner its coordinates, and eight numbers of 32 bits.
    pub(super) fn n_bytes(n_facets: u64) -> u64 {
        3 * n_facets * (size_of::<([u64; 3], Place)>() as u64 + 32)
    }

    pub(super) fn new(facets: &[Facet]) -> Features {
        let places = 0..3 * facets.len() as u32;
        let corner = |place: u32| {
            let Place(at) = Place(place);
            // both zeros are one
            let key = facets[at as usize / 3].corners[at as usize % 3].map(|coordinate| (coordinate + 0.0).to_bits());
            (key, Place(place))
        };
        let corners = Groups::new(places.clone().into_par_iter().map(corner).collect());
        let mut of_place = vec![0; places.len()];
        for group in 0..corners.firsts.len() as u32 - 1 {
            corners.group(group).iter().for_each(|place| of_place[place.0 as usize] = group);
        }
        let edge = |place: u32| {
            let [one, other] = [place, place / 3 * 3 + (place + 1) % 3].map(|at| of_place[at as usize]);
            ([one.min(other), one.max(other)], Place(place))
        };
        let mut edges = Groups::new(places.into_par_iter().map(edge).collect());
        for place in 0..of_place.len() {
            if of_place[place] == of_place[place / 3 * 3 + (place + 1) % 3] {
                edges.of_first[place] = NONE;
            }
        }
        Features { corners, edges }
    }
}
