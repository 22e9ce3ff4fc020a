//! Crossings: where the rays of a bin row cross the facets of its bins.
//!
//! Facets, rays, a lattice -> [`Crossings`]. A crossing is one u32, `cell << 9 | rank << 1 | direction`: the first cell
//! whose centre counts as above the facet (0 for crossings below the domain, the number of cells of the ray for those
//! beyond it), the rank of the geometry, and 0 where the ray enters, 1 where it leaves.
//!
//! A ray hits a facet iff all three `q >= 0` (see `facet`). Its height there is `Z = height / D` units, so the first cell
//! above is `floor(Z / 2^F) + 1`, or `floor(Z / 2^F)` if the centre lies exactly on the facet and the tie rule puts it above.
//! The rays of a row need no division: quotient and remainder of height / (D 2^F) advance by a constant step.
//!
//! Where cells differ in size, `crossings/graded.rs` casts the rays. Its twin is `shaders/intersect_graded.wgsl`.
//!
//! Source: the paper, Eq. 16-19. Twins: `shaders/intersect.wgsl` with `map.wgsl`, `shaders/intersect_deep.wgsl`.
//! Cost: O(rows of facets + crossings) time; 4 bytes a crossing, 8 with its facet, and 4 a ray.

use std::ops::Range;

use crate::base::sort::{by_number, sort};
use crate::grid::frame::Frame;
use crate::grid::rays::Rays;
use crate::stages::crossings::rows::{Height, List, Rows};
use crate::stages::facet::Projected;
use crate::stages::lattice::Lattice;

mod graded;
pub mod places;
pub mod rows;

/// Crossings of consecutive rays, in no order within a ray.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Crossings {
    /// Index of the first ray.
    pub first_ray: u64,
    /// First entry of `events` of each ray, then the end: rays + 1 entries.
    pub offsets: Vec<u32>,
    /// `cell << 9 | rank << 1 | direction`, ray after ray.
    pub events: Vec<u32>,
    /// The facet of each crossing, as an index of the frame; empty unless asked for.
    pub facets: Vec<u32>,
}

/// Where a ray passes through the surface of a geometry.
#[derive(Debug, Clone, Copy)]
pub struct Passage {
    /// The first cell above.
    pub cell: u32,
    /// Position of the geometry.
    pub position: u16,
    /// 1 where the ray enters, -1 where it leaves.
    pub step: i32,
}

impl Crossings {
    /// Calls `each` with the index of every ray and its crossings, sorted by cell.
    pub fn for_each_ray(&self, mut each: impl FnMut(u64, &[u32])) {
        let mut events = Vec::new();
        for (ray, ends) in (self.first_ray..).zip(self.offsets.windows(2)) {
            events.clear();
            events.extend_from_slice(&self.events[ends[0] as usize..ends[1] as usize]);
            events.sort_unstable();
            each(ray, &events);
        }
    }

    /// Calls `each` with the index of every ray and its passages through surfaces, sorted by cell. Needs the facets where geometries share ranks.
    pub fn for_each_passage(&self, frame: &Frame, mut each: impl FnMut(u64, &[Passage])) {
        let mut passages = Vec::new();
        for (ray, ends) in (self.first_ray..).zip(self.offsets.windows(2)) {
            passages.clear();
            passages.extend((ends[0] as usize..ends[1] as usize).map(|at| {
                let event = self.events[at];
                let position = match frame.ranks.are_positions() {
                    true => (event >> 1 & 0xff) as u16,
                    false => frame.position_of_facet[self.facets[at] as usize],
                };
                Passage { cell: event >> 9, position, step: 1 - 2 * (event & 1) as i32 }
            }));
            passages.sort_unstable_by_key(|of| (of.cell, of.position));
            each(ray, &passages);
        }
    }

    /// The crossings of a ray with their facets, or 0 without, in order.
    pub fn of_ray(&self, ray: usize) -> Vec<[u32; 2]> {
        let places = self.offsets[ray] as usize..self.offsets[ray + 1] as usize;
        let both = |place| [self.events[place], self.facets.get(place).copied().unwrap_or(0)];
        let mut crossings: Vec<[u32; 2]> = places.map(both).collect();
        sort(&mut crossings);
        crossings
    }

    /// Drops the first rays.
    pub fn without_first(self, n_rays: usize) -> Crossings {
        if n_rays == 0 {
            return self;
        }
        let start = self.offsets[n_rays];
        Crossings {
            first_ray: self.first_ray + n_rays as u64,
            offsets: self.offsets[n_rays..].iter().map(|offset| offset - start).collect(),
            events: self.events[start as usize..].to_vec(),
            facets: self.facets.get(start as usize..).unwrap_or_default().to_vec(),
        }
    }
}

/// Packs a crossing.
#[inline(always)]
pub fn event(cell: u32, rank: u8, exits: bool) -> u32 {
    cell << 9 | u32::from(rank) << 1 | u32::from(exits)
}

/// Casts the rays of one bin row of a lattice; with their facets, if asked.
pub fn crossings(frame: &Frame, rays: &Rays, lattice: &Lattice, row: u32, with_facets: bool) -> Crossings {
    let first = row * lattice.bin[1];
    let window = [0..rays.counts[0], first..(first + lattice.bin[1]).min(rays.counts[1])];
    let bin_of = |column: u32| {
        let start = column * lattice.bin[0];
        let across = start..(start + lattice.bin[0]).min(rays.counts[0]);
        (lattice.bin_facets(column, row), [across, window[1].clone()])
    };
    crossings_of_bins((frame, rays), (0..lattice.n_across).map(bin_of), &window, with_facets)
}

/// Casts the rays of a window, ranges of rays along both axes across, against some facets; at least all that these rays hit.
/// The window is one row or less, or whole rows.
pub fn crossings_of_window(
    frame: &Frame,
    rays: &Rays,
    facets: &[u32],
    window: &[Range<u32>; 2],
    with_facets: bool,
) -> Crossings {
    crossings_of_bins((frame, rays), [(facets, window.clone())].into_iter(), window, with_facets)
}

/// The facets of a bin, and its rays.
type Bin<'a> = (&'a [u32], [Range<u32>; 2]);

fn crossings_of_bins<'a>(
    onto: (&Frame, &Rays),
    bins: impl Iterator<Item = Bin<'a>>,
    window: &[Range<u32>; 2],
    with_facets: bool,
) -> Crossings {
    let n_rays = window[0].len() * window[1].len();
    let mut offsets = Vec::new();
    let (events, facets) = if with_facets {
        let hits = cast(onto, bins, window, |event, facet| [event, facet]);
        let mut both = Vec::new();
        by_number(hits.iter().copied(), n_rays, &mut offsets, &mut both);
        (both.iter().map(|both| both[0]).collect(), both.iter().map(|both| both[1]).collect())
    } else {
        let hits = cast(onto, bins, window, |event, _| event);
        let mut events = Vec::new();
        by_number(hits.iter().copied(), n_rays, &mut offsets, &mut events);
        (events, Vec::new())
    };
    let first_ray = u64::from(window[1].start) * u64::from(onto.1.counts[0]) + u64::from(window[0].start);
    Crossings { first_ray, offsets, events, facets }
}

/// Ray of the window, and `of(crossing, facet)`, for all hits of facets with the rays of bins of the window.
#[inline(always)]
fn cast<'a, T>(
    (frame, rays): (&Frame, &Rays),
    bins: impl Iterator<Item = Bin<'a>>,
    window: &[Range<u32>; 2],
    of: impl Fn(u32, u32) -> T + Copy,
) -> Vec<(u32, T)> {
    let n_across = window[0].end - window[0].start;
    let mut hits = Vec::new();
    for (facets, bin) in bins {
        for &facet in facets {
            let Some(projected) = Projected::new(&frame.facets[facet as usize], frame, rays) else { continue };
            let tag = event(0, frame.rank_of_facet(facet as usize), projected.exits);
            let hit =
                |i, j, cell, _| ((j - window[1].start) * n_across + i - window[0].start, of(cell << 9 | tag, facet));
            self::hits(&projected, (frame, rays), &bin, &mut List { hit, hits: &mut hits });
        }
    }
    hits
}

/// Passes on the hits of a facet with the rays of a window.
#[inline(always)]
pub fn hits(facet: &Projected, (frame, rays): (&Frame, &Rays), window: &[Range<u32>; 2], rows: &mut impl Rows) {
    if frame.is_graded() {
        graded::hits(facet, (frame, rays), window, rows);
    } else {
        RowCaster::new(facet, frame.fraction_bits, rays.depth).hits(window, rows);
    }
}

/// Quotient, rounded down, and remainder by a positive number. Euclid's, but compiled where it is used also where all code is
/// compiled for size.
#[inline(always)]
fn divided(value: i64, by: i64) -> (i64, i64) {
    let (quotient, rest) = (value / by, value % by);
    if rest < 0 { (quotient - 1, rest + by) } else { (quotient, rest) }
}

/// Casts rows of rays at a facet.
struct RowCaster<'a> {
    facet: &'a Projected,
    fraction_bits: u32,
    depth: i64,
    /// Step of height / 2^F from ray to ray along a row, as quotient and remainder by D.
    step: (i64, i64),
    /// Whether heights can be multiples of 2^F at all: their low F bits are the same at every ray.
    on_unit: bool,
}

impl<'a> RowCaster<'a> {
    fn new(facet: &'a Projected, fraction_bits: u32, depth: u32) -> RowCaster<'a> {
        let step = divided(facet.slope[0], facet.area);
        let on_unit = facet.height & ((1 << fraction_bits) - 1) == 0;
        RowCaster { facet, fraction_bits, depth: i64::from(depth), step, on_unit }
    }

    /// Passes on the hits with the rays of a window.
    #[inline(always)]
    fn hits(&self, window: &[Range<u32>; 2], rows: &mut impl Rows) {
        let [across, down] = self.facet.rays;
        let tie_is_above = self.facet.tie_is_above && self.on_unit;
        let (unit, depth, area, step) = (f64::from(1u32 << self.fraction_bits), self.depth, self.facet.area, self.step);
        let limits = [window[0].start.max(across[0]), window[0].end.min(across[1] + 1)];
        let limits = limits.map(|i| i64::from(i) - i64::from(across[0]));
        for j in window[1].start.max(down[0])..window[1].end.min(down[1] + 1) {
            let dj = i64::from(j - down[0]);
            let Some([start, end]) = self.hit_range(dj, limits) else { continue };
            let (mut cell, mut rest) = self.cell_below(start, dj);
            let hit_rays = across[0] + start as u32..across[0] + end as u32;
            let mut next = move || {
                let below = (cell, rest);
                // without a branch, which nothing would predict: all bits where there is no carry
                let over = rest + step.1 - area;
                let no_carry = over >> 63;
                cell += step.0 + 1 + no_carry;
                rest = over + (area & no_carry);
                below
            };
            let height = |(below, rest): (i64, i64), is_at_centre| Height { below, rest, area, unit, is_at_centre };
            // at the row's ends, where the facet is highest and lowest, or past them
            let ends = [cell, cell + (end - start) * step.0, cell + (end - start) * (step.0 + 1)];
            if !tie_is_above && ends.into_iter().all(|cell| 0 <= cell && cell < depth) {
                rows.row(
                    j,
                    hit_rays,
                    (start..end).map(|_| {
                        let below = next();
                        (below.0 as u32 + 1, height(below, false))
                    }),
                );
            } else {
                rows.row(
                    j,
                    hit_rays,
                    (start..end).map(|_| {
                        let below = next();
                        let is_at_centre = below.1 == 0 && tie_is_above;
                        let above = below.0 + i64::from(!is_at_centre);
                        (above.clamp(0, depth) as u32, height(below, is_at_centre))
                    }),
                );
            }
        }
    }

    /// The rays [start, end) of a row that lie inside all three edges, of those within the limits.
    #[inline(always)]
    fn hit_range(&self, dj: i64, [mut start, mut end]: [i64; 2]) -> Option<[i64; 2]> {
        for edge in 0..3 {
            let q = self.facet.q[edge] + self.facet.b[edge] * dj;
            let a = self.facet.a[edge];
            // q + a di >= 0
            if a > 0 {
                start = start.max(-divided(q, a).0);
            } else if a < 0 {
                end = end.min(divided(q, -a).0 + 1);
            } else if q < 0 {
                return None;
            }
        }
        (start < end).then_some([start, end])
    }

    /// Quotient and remainder of the height over D 2^F at a ray of the facet's box.
    #[inline(always)]
    fn cell_below(&self, di: i64, dj: i64) -> (i64, i64) {
        let [x, y] = [i128::from(self.facet.slope[0]), i128::from(self.facet.slope[1])];
        let height = (self.facet.height >> self.fraction_bits) + x * i128::from(di) + y * i128::from(dj);
        match i64::try_from(height) {
            Ok(height) => divided(height, self.facet.area),
            Err(_) => {
                let area = i128::from(self.facet.area);
                (height.div_euclid(area) as i64, height.rem_euclid(area) as i64)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::lines::Lines;
    use crate::input::geometry::Geometry;
    use crate::stages::lattice;

    /// Cells of the crossings of every z ray of a facet over a 4 x 4 x 4 domain of unit cells.
    fn cells(facet: [[f32; 3]; 3], bin: [u32; 2]) -> Vec<Vec<u32>> {
        let lines = Lines::new([0.0; 3], [1.0; 3], [4; 3]).unwrap();
        let frame = Frame::new(&[Geometry::new("f", 1, vec![facet]).unwrap()], &lines).unwrap();
        let rays = Rays::new(2, lines.dims());
        let rows = Lattice::n_rows(&rays, bin);
        let lattice = lattice::lattice(&frame, &rays, bin, 0..rows);
        let mut cells = Vec::new();
        for row in 0..rows {
            let c = crossings(&frame, &rays, &lattice, row, false);
            for ray in c.offsets.windows(2) {
                cells.push(c.events[ray[0] as usize..ray[1] as usize].iter().map(|e| e >> 9).collect());
            }
        }
        cells
    }

    #[test]
    fn a_flat_facet_at_height_2_toggles_cell_2() {
        let cells = cells([[-1.0, -1.0, 2.0], [20.0, -1.0, 2.0], [-1.0, 20.0, 2.0]], [4, 4]);
        assert_eq!(cells, vec![vec![2]; 16]);
    }

    #[test]
    fn a_centre_on_a_face_belongs_below_it() {
        // (low, high]: a crossing exactly at the centre of cell 1 first affects cell 2
        let cells = cells([[-1.0, -1.0, 1.5], [20.0, -1.0, 1.5], [-1.0, 20.0, 1.5]], [4, 4]);
        assert_eq!(cells, vec![vec![2]; 16]);
    }

    #[test]
    fn crossings_outside_the_domain_are_clamped_to_its_ends() {
        let low = cells([[-1.0, -1.0, -9.0], [20.0, -1.0, -9.0], [-1.0, 20.0, -9.0]], [4, 4]);
        assert_eq!(low, vec![vec![0]; 16]);
        let high = cells([[-1.0, -1.0, 9.0], [20.0, -1.0, 9.0], [-1.0, 20.0, 9.0]], [4, 4]);
        assert_eq!(high, vec![vec![4]; 16]);
    }

    #[test]
    fn the_bin_size_changes_nothing() {
        let facet = [[0.1, 0.2, -1.0], [3.9, 1.3, 5.5], [1.2, 3.7, 2.25]];
        let whole = cells(facet, [4, 4]);
        assert_eq!(whole.iter().flatten().count(), 6);
        for bin in [[1, 1], [2, 1], [1, 3], [3, 2], [64, 64]] {
            assert_eq!(cells(facet, bin), whole, "{bin:?}");
        }
    }
}
