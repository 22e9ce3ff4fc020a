//! Where along their rays crossings lie, for what is measured within cells.

use std::ops::Range;

use super::by_ray;
use super::rows::{Height, List};
use crate::grid::frame::Frame;
use crate::grid::rays::Rays;
use crate::stages::facet::Projected;

/// Lowest bits of a crossing: `rank << 1 | direction`.
pub(crate) const EVENT_BITS: u32 = 9;

/// Crossings of consecutive rays: the first of each ray, then the end, and the crossings in no order within a ray. A crossing is
/// `place << 9 | rank << 1 | direction`.
pub(crate) type Places = (Vec<u32>, Vec<u64>);

/// Casts some rows of rays against facets: at least all that they hit. `place` makes 55 bits, in order, of a place along a ray in
/// units, known to 2^-50 of itself.
pub(crate) fn places(
    (frame, rays): (&Frame, &Rays),
    facets: &[u32],
    rows: Range<u32>,
    place: impl Fn(f64) -> u64 + Copy,
) -> Places {
    let first = rows.start;
    let window: [Range<u32>; 2] = [0..rays.counts[0], rows];
    let mut hits = Vec::new();
    for &facet in facets {
        let Some(projected) = Projected::new(&frame.facets[facet as usize], frame, rays) else { continue };
        let event = u64::from(super::event(0, frame.rank_of_facet(facet as usize), projected.exits));
        let hit =
            |i, j, _, height: Height| ((j - first) * rays.counts[0] + i, place(height.place()) << EVENT_BITS | event);
        super::hits(&projected, (frame, rays), &window, &mut List { hit, hits: &mut hits });
    }
    by_ray(&hits, window[0].len() * window[1].len())
}
