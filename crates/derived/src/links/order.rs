//! The order of links: those of strips by planes of cells, then those of each plane by cell and direction.
//!
//! Cost: two passes of counting sorts over the links of a plane, and each link moved twice.

use super::Link;
use super::field::place;
use hexcast_core::base::sort::{by_number, sort_nearly_by_key};

/// Links of a direction on some rays, plane after plane, and in each plane in the order of rays.
pub(super) struct ByPlane {
    /// The first plane that has any.
    first: u32,
    /// First entry of `links` of each plane from there on, then the end.
    offsets: Vec<u32>,
    pub(super) links: Vec<Link>,
}

impl ByPlane {
    /// Sorts the links of some rays by plane; the list is used again.
    pub(super) fn new(links: &[Link], order: &mut Vec<u32>) -> ByPlane {
        let planes = || links.iter().map(|link| link.cell[2]);
        let (first, last) = (planes().min().unwrap_or(0), planes().max().unwrap_or(0));
        let mut offsets = Vec::new();
        let numbers = planes().map(|plane| plane - first).zip(0u32..);
        let order = by_number(numbers, (last - first) as usize + 1, &mut offsets, order);
        ByPlane { first, offsets, links: order.iter().map(|&at| links[at as usize]).collect() }
    }

    fn of_plane(&self, z: u32) -> &[Link] {
        let Some(plane) = z.checked_sub(self.first).map(|plane| plane as usize) else { return &[] };
        match self.offsets.get(plane..plane + 2) {
            Some(ends) => &self.links[ends[0] as usize..ends[1] as usize],
            None => &[],
        }
    }
}

/// Memory that a core uses for plane after plane.
#[derive(Default)]
pub(super) struct Memory {
    links: Vec<Link>,
    /// Of each x, then of each y, where its links begin.
    firsts: Vec<u32>,
    /// y of links by x, and which they are.
    by_x: Vec<(u32, u32)>,
    order: Vec<u32>,
}

/// The links of a plane in the order of cells, then of directions: those of parts, which come in the order of directions.
pub(super) fn in_order<'a>(
    parts: impl Iterator<Item = &'a ByPlane>,
    z: u32,
    dims: [u32; 3],
    memory: &mut Memory,
) -> Vec<Link> {
    let Memory { links, firsts, by_x, order } = memory;
    links.clear();
    parts.for_each(|part| links.extend_from_slice(part.of_plane(z)));
    // to count along long sides would take longer
    if links.len() < (dims[0] + dims[1]) as usize / 4 {
        let mut links = links.clone();
        sort_nearly_by_key(&mut links, |link| place(link.cell, link.direction, dims));
        return links;
    }
    let xs = links.iter().zip(0u32..).map(|(link, at)| (link.cell[0], (link.cell[1], at)));
    let by_x = by_number(xs, dims[0] as usize, firsts, by_x);
    let order = by_number(by_x.iter().copied(), dims[1] as usize, firsts, order);
    order.iter().map(|&at| links[at as usize]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_of_planes_are_in_the_order_of_cells_and_directions() {
        let mut state = 1u32;
        let mut random = |below: u32| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) % below
        };
        // many links of small planes are counted, few of wide ones compared
        for (dims, n) in [([7, 5, 4], 400), ([900, 800, 3], 90), ([1, 1, 1], 0)] {
            let mut found: Vec<Link> = (0..n)
                .map(|_| Link { cell: dims.map(&mut random), direction: random(19) as u8, ..Link::default() })
                .collect();
            let key = |link: &Link| place(link.cell, link.direction, dims);
            found.sort_by_key(key);
            found.dedup_by_key(|link| key(link));
            // each direction in two parts, in no order
            let mut parts = Vec::new();
            for direction in 0..19 {
                let mut of_direction: Vec<Link> =
                    found.iter().filter(|link| link.direction == direction).copied().collect();
                of_direction.sort_by_key(|link| [link.cell[1], link.cell[0], link.cell[2]]);
                let half = of_direction.len() / 2;
                let mut order = Vec::new();
                let (one, other) = of_direction.split_at(half);
                parts.extend([one, other].map(|links| ByPlane::new(links, &mut order)));
            }
            let mut memory = Memory::default();
            let ordered: Vec<Link> = (0..dims[2]).flat_map(|z| in_order(parts.iter(), z, dims, &mut memory)).collect();
            assert_eq!(ordered, found, "{dims:?}");
        }
    }
}
