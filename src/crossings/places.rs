//! Where along their rays crossings lie, for what is measured within cells.

use std::ops::Range;

use super::{RowCaster, by_ray, graded};
use crate::facet::Projected;
use crate::frame::Frame;
use crate::lattice::Lattice;
use crate::rays::Rays;

/// A crossing: `rank << 1 | direction`, and its place along the ray in units, to 2^-50 of itself.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Place {
    pub(crate) event: u32,
    pub(crate) at: f64,
}

/// Crossings of consecutive rays: the first of each ray, then the end, and the crossings in no order within a ray.
pub(crate) type Places = (Vec<u32>, Vec<Place>);

/// Casts the rays of one bin row of a lattice whose bins are as wide as the box.
pub(crate) fn places(frame: &Frame, rays: &Rays, lattice: &Lattice, row: u32) -> Places {
    let first = row * lattice.bin[1];
    let window: [Range<u32>; 2] = [0..rays.counts[0], first..(first + lattice.bin[1]).min(rays.counts[1])];
    let mut hits = Vec::new();
    for &facet in lattice.bin_facets(0, row) {
        let Some(projected) = Projected::new(&frame.facets[facet as usize], frame, rays) else { continue };
        let event = super::event(0, frame.rank_of_facet[facet as usize], projected.exits);
        let hit = |i, j, _, at| ((j - first) * rays.counts[0] + i, Place { event, at });
        if frame.is_graded() {
            graded::hits(&projected, (frame, rays), &window, hit, &mut hits);
        } else {
            RowCaster::new(&projected, frame.fraction_bits, rays.depth).hits(&window, hit, &mut hits);
        }
    }
    by_ray(&hits, window[0].len() * window[1].len())
}
