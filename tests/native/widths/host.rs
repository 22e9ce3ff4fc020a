//! The host's quotients and steps for the widest facets there are: no overflow, which the build checks, and the cells of quotients in 128
//! bits.

use hexcast_core::grid::frame::{Frame, MIN_FRACTION_BITS, Ranks, SPAN_BITS, SnappedFacet};
use hexcast_core::grid::rays::Rays;
use hexcast_core::stages::crossings::crossings_of_window;

use super::kernels::hull;

/// A frame whose facets have corners at the ends of the span or in its middle.
fn widest(fraction_bits: u32) -> Frame {
    let span = hull(SPAN_BITS, fraction_bits) as i32;
    let cells = (span >> fraction_bits) as u32 + 1;
    let ends = [0, span, span / 2];
    // from one end of the first axis to the other, with seven choices of three places on the other two
    let facet = |choice: usize| {
        let place = |of: usize| ends[choice / 3usize.pow(of as u32) % 3];
        [[0, 0, place(6)], [span, place(0), place(1)], [place(2), place(3), place(4)]]
            .map(|[x, y, z]: [i32; 3]| [x, (y + place(5)).min(span), z])
    };
    let facets: Vec<SnappedFacet> = (0..3usize.pow(7)).map(facet).collect();
    let ranks = Ranks { geometry_at: vec![0], rank_at: vec![0], flag_of_rank: vec![1] };
    let position_of_facet = vec![0; facets.len()];
    Frame { fraction_bits, centres: None, dims: [cells; 3], position_of_facet, facets, ranks }
}

/// The first cell above a facet at a ray, and whether the facet goes through a centre there.
fn cell_above(facet: &SnappedFacet, rays: &Rays, ray: [u32; 2], fraction_bits: u32) -> (i128, bool) {
    let [[x0, y0, z0], [x1, y1, z1], [x2, y2, z2]] = facet.map(|corner| rays.project(corner).map(i128::from));
    let area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0);
    let slope_x = (z1 - z0) * (y2 - y0) - (z2 - z0) * (y1 - y0);
    let slope_y = (x1 - x0) * (z2 - z0) - (x2 - x0) * (z1 - z0);
    let [x, y] = ray.map(|index| i128::from(index) << fraction_bits);
    let height = (z0 * area + slope_x * (x - x0) + slope_y * (y - y0)) * area.signum();
    let of_cell = area.abs() << fraction_bits;
    (height.div_euclid(of_cell) + 1, height.rem_euclid(of_cell) == 0)
}

#[test]
fn the_widest_facets_have_the_cells_of_quotients_in_128_bits() {
    let mut n_crossings = 0;
    for fraction_bits in [MIN_FRACTION_BITS, 16, 23] {
        let frame = widest(fraction_bits);
        let rays = Rays::new(2, frame.dims);
        let n = rays.counts[0];
        let windows = [0, n / 3, n / 2, n - 3].map(|start| start..start + 3);
        for facet in 0..frame.facets.len() {
            for window in windows.iter().flat_map(|i| windows.iter().map(|j| [i.clone(), j.start..j.start + 1])) {
                let found = crossings_of_window(&frame, &rays, &[facet as u32], &window, false);
                for (ends, i) in found.offsets.windows(2).zip(window[0].clone()) {
                    for event in &found.events[ends[0] as usize..ends[1] as usize] {
                        let ray = [i, window[1].start];
                        let (above, is_at_centre) = cell_above(&frame.facets[facet], &rays, ray, fraction_bits);
                        let cell = i128::from(event >> 9);
                        let depth = i128::from(rays.depth);
                        let is_right =
                            cell == above.clamp(0, depth) || is_at_centre && cell == (above - 1).clamp(0, depth);
                        assert!(is_right, "{:?} at {ray:?}: {cell}, {above}", frame.facets[facet]);
                        n_crossings += 1;
                    }
                }
            }
        }
    }
    assert!(n_crossings > 10_000, "{n_crossings}");
}
