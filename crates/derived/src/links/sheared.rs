//! The frame in which the links of a direction are stretches of rays along an axis.
//!
//! # Theory
//! Let z be the last axis that a direction (a, b, 1) leads along. The shear `x' = x - a z, y' = y - b z, z' = z` maps the direction onto z.
//! It maps centres of cells onto centres of a wider box, and corners onto integers, one or two bits longer (`facet.rs` has the widths).
//!
//! The tie rule stays as it is. A centre stands for P - (e1, e2, e3), e1 >> e2 >> e3, so the first component of a plane's normal n that is
//! not 0 decides. In the sheared frame n is `n_x' = n_x, n_y' = n_y, n_z' = n_z + a n_x + b n_y`. The first that is not 0 has
//! the same place and the same sign: where n_x = n_y = 0, n_z' is n_z. So every crossing is that of the box's own rule.

use std::borrow::Cow;

use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::rays::Rays;
use hexcast_core::input::job::Rule;
use hexcast_core::stages::cast::Cast;

/// A sheared frame and its rays, of all cells of a box or of some.
pub(super) struct Sheared<'a> {
    pub(super) frame: Cow<'a, Frame>,
    /// Of each facet its index in the box's own frame; None where it is the same.
    indices: Option<Vec<u32>>,
    pub(super) rays: Rays,
    /// Whether rays run against the direction that was asked for.
    pub(super) is_backward: bool,
    /// Cells along each axis from one cell of a ray to the next.
    step: [i64; 3],
    /// The cell of the box at the first place of the first ray, which may lie beyond it.
    first: [i64; 3],
    dims: [u32; 3],
}

impl Sheared<'_> {
    /// Shears a frame of equal cells; along an axis it stays as it is, and its cells may differ in size. Rays go through all of some cells, the first and the end,
    /// exclusive, and through others.
    pub(super) fn new(frame: &Frame, direction: [i8; 3], [first, end]: [[u32; 3]; 2]) -> Sheared<'_> {
        let axis = (0..3).rev().find(|&axis| direction[axis] != 0).unwrap_or(2);
        let is_backward = direction[axis] < 0;
        let step = direction.map(|step| if is_backward { -i64::from(step) } else { i64::from(step) });
        let (dims, depth) = (frame.dims, frame.dims[axis]);
        let across = |other: usize| other != axis && step[other] != 0;
        let shift = [0, 1, 2].map(|of| if across(of) && step[of] > 0 { i64::from(depth) - 1 } else { 0 });
        let mut sheared = Cow::Borrowed(frame);
        if (0..3).any(across) {
            let moved = |corner: &[i32; 3]| {
                let of = |other: usize| {
                    let by = if other == axis { 0 } else { step[other] as i32 * corner[axis] };
                    corner[other] - by + ((shift[other] as i32) << frame.fraction_bits)
                };
                [of(0), of(1), of(2)]
            };
            sheared = Cow::Owned(Frame {
                facets: frame.facets.iter().map(|facet| [0, 1, 2].map(|corner| moved(&facet[corner]))).collect(),
                dims: [0, 1, 2].map(|of| if across(of) { dims[of] + depth - 1 } else { dims[of] }),
                position_of_facet: frame.position_of_facet.clone(),
                ranks: frame.ranks.clone(),
                centres: None,
                ..*frame
            });
        }
        let (mut indices, mut places) = (None, [[0; 3], sheared.dims]);
        if [first, end] != [[0; 3], dims] {
            // where the places of these cells begin and end
            for of in 0..3 {
                let by =
                    [first[axis], end[axis] - 1].map(|along| if across(of) { step[of] * i64::from(along) } else { 0 });
                let least = i64::from(first[of]) - by[0].max(by[1]) + shift[of];
                let most = i64::from(end[of]) - by[0].min(by[1]) + shift[of];
                (places[0][of], places[1][of]) = (least as u32, most as u32);
            }
            let (window, of_facets) = sheared.window_along(axis, places);
            (sheared, indices) = (Cow::Owned(window), Some(of_facets));
        }
        let rays = Rays::new(axis, sheared.dims);
        let first = [0, 1, 2].map(|of| {
            let by = if across(of) { step[of] * i64::from(places[0][axis]) } else { 0 };
            i64::from(places[0][of]) + by - shift[of]
        });
        Sheared { frame: sheared, indices, rays, is_backward, step, first, dims }
    }

    pub(super) fn cast(&self, rule: Rule) -> Cast<'_> {
        Cast { frame: &self.frame, rays: &self.rays, rule }
    }

    /// A cell of the box by its place on a ray; None beyond the box.
    pub(super) fn cell(&self, across: [u32; 2], along: u32) -> Option<[u32; 3]> {
        let place = self.rays.cell([across[0], across[1], along]);
        let mut cell = [0; 3];
        for of in 0..3 {
            let by = if of == self.rays.axis { 0 } else { self.step[of] * i64::from(along) };
            cell[of] = u32::try_from(i64::from(place[of]) + by + self.first[of]).ok()?;
            if cell[of] >= self.dims[of] {
                return None;
            }
        }
        Some(cell)
    }

    /// Where a ray begins: the cell of its first place, which may lie beyond the box.
    pub(super) fn begin(&self, across: [u32; 2]) -> [i64; 3] {
        let place = self.rays.cell([across[0], across[1], 0]);
        [0, 1, 2].map(|of| i64::from(place[of]) + self.first[of])
    }

    /// The two cells of the box between which a place on a ray lies, by where the ray begins and the number of its cells below; None where one is beyond the
    /// box.
    #[inline(always)]
    pub(super) fn cells_beside(&self, begin: [i64; 3], above: u32) -> Option<[[u32; 3]; 2]> {
        let mut cells = [[0; 3]; 2];
        for of in 0..3 {
            let high = begin[of] + self.step[of] * i64::from(above);
            let low = high - self.step[of];
            let is_in = |at: i64| (at as u64) < u64::from(self.dims[of]);
            if !is_in(low) || !is_in(high) {
                return None;
            }
            (cells[0][of], cells[1][of]) = (low as u32, high as u32);
        }
        Some(cells)
    }

    /// The index of a facet in the box's own frame.
    pub(super) fn index(&self, facet: u32) -> u32 {
        self.indices.as_ref().map_or(facet, |indices| indices[facet as usize])
    }
}
