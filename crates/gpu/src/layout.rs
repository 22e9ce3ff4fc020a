//! What the kernels read of a band: its parameters, and the facets that its rays may hit. A test compares the parameters and the
//! constants of `cast::sizes` with what naga reads from the shaders.

use std::ops::Range;

use hexcast_core::base::parallel::*;
use hexcast_core::base::sort::sort_by_key;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::rays::Rays;
use hexcast_core::input::job::Rule;
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::cast::sizes::{BIN, CHOSEN_BYTES, FACET_WORDS, MAX_LAYERS, SEGMENT, layers};

/// The numbers of one band; `Params` in `shaders/shared/params.wgsl`, where each is explained.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[allow(missing_docs)]
pub struct Params {
    pub fraction_bits: u32,
    pub axis: u32,
    pub depth: u32,
    pub n_i: u32,
    pub first_row: u32,
    pub end_row: u32,
    pub n_across: u32,
    pub n_bins: u32,
    pub n_layers: u32,
    pub n_facets: u32,
    pub n_items: u32,
    pub tile_capacity: u32,
    pub place_capacity: u32,
    pub event_capacity: u32,
    pub rule: u32,
    pub n_ranks: u32,
    pub all_deep: u32,
    pub with_facets: u32,
    pub first_facet: u32,
}

impl Params {
    /// Describes a band of ray rows, with no facets and no room yet.
    pub(crate) fn new(cast: &Cast, rows: &Range<u32>) -> Params {
        let Cast { frame, rays, rule } = *cast;
        let n_across = rays.counts[0].div_ceil(BIN);
        Params {
            fraction_bits: if frame.is_graded() { 0 } else { frame.fraction_bits },
            axis: rays.axis as u32,
            depth: rays.depth,
            n_i: rays.counts[0],
            first_row: rows.start,
            end_row: rows.end,
            n_across,
            n_bins: n_across * (rows.end - rows.start).div_ceil(BIN),
            n_layers: 1,
            rule: match rule {
                Rule::Parity => 0,
                Rule::Nonzero => 1,
            },
            n_ranks: frame.ranks.flag_of_rank.len() as u32,
            ..bytemuck::Zeroable::zeroed()
        }
    }

    /// Whether cells differ in size.
    pub(crate) fn is_graded(&self) -> bool {
        self.fraction_bits == 0
    }

    /// Rows of rays of the band's bins.
    pub(crate) fn n_chunks(&self) -> u64 {
        u64::from(self.end_row - self.first_row) * u64::from(self.n_across)
    }

    /// Rays of the band.
    pub fn n_rays(&self) -> u32 {
        (self.end_row - self.first_row) * self.n_i
    }

    /// Counters of the lattice: the layers of all bins.
    pub(crate) fn n_counters(&self) -> u64 {
        u64::from(self.n_bins) * u64::from(self.n_layers)
    }
}

/// A facet whose box holds rays of a band.
#[derive(Debug, Clone, Copy)]
struct Chosen {
    index: u32,
    /// Bins under its box, and items of the walk over them.
    n_bins: u32,
    n_items: u32,
    /// Rays that it hits, nearly: its area over the band, if it is spread evenly over its box, at most those under its box.
    n_rays: f32,
    /// First and last ray under its box along both axes across, counted from the first of the band.
    rays: [[u32; 2]; 2],
}

impl Chosen {
    /// Bins of which it hits a ray, nearly: those that a convex figure of its area and width covers where it lies anywhere, and not more
    /// than it hits rays.
    fn n_tiles(&self) -> f64 {
        let width: f64 = self.rays.iter().map(|[first, last]| f64::from(last - first)).sum();
        let (area, side) = (f64::from(self.n_rays), f64::from(BIN - 1));
        let covered = (area + side * width + side * side) / f64::from(BIN * BIN);
        covered.min(self.n_bins.into()).min(area)
    }
}

const _: () = assert!(size_of::<Chosen>() == CHOSEN_BYTES as usize);

/// The facets that rays of a band may hit, and the layers that part them along the rays.
#[derive(Debug, Default)]
pub(crate) struct BandFacets {
    chosen: Vec<Chosen>,
    /// First cell of each layer but the first.
    boundaries: Vec<u32>,
    /// Bins under all boxes.
    pub(crate) n_box_bins: u64,
    /// Crossings of the band's rays, and facets over a bin of which they hit a ray, nearly.
    pub(crate) n_crossings: u64,
    pub(crate) n_tiles: u64,
}

/// Cells along each side of the map of crowded places.
const MAP: usize = 16;

impl BandFacets {
    /// Chooses the facets whose boxes hold rays of some rows, and layers for crossings as crowded as their areas say, or `least_layers`.
    pub(crate) fn new(cast: &Cast, rows: &Range<u32>, least_layers: u32) -> BandFacets {
        let Cast { frame, rays, .. } = *cast;
        let ends = [0..rays.counts[0], rows.clone()];
        let choose = |index| choose(index, (frame, rays), &ends);
        let chosen: Vec<Chosen> = on_all_cores(|| (0..frame.facets.len()).into_par_iter().filter_map(choose).collect());
        let most = most_crossings(&chosen, &ends);
        let n_box_bins = chosen.iter().map(|facet| u64::from(facet.n_bins)).sum();
        let n_crossings = chosen.iter().map(|facet| f64::from(facet.n_rays)).sum::<f64>() as u64;
        let n_tiles = chosen.iter().map(Chosen::n_tiles).sum::<f64>() as u64;
        let mut facets = BandFacets { chosen, boundaries: Vec::new(), n_box_bins, n_crossings, n_tiles };
        facets.part(cast, layers(f64::from(most)).max(least_layers));
        facets
    }

    /// Parts the facets into so many layers or fewer, about as crowded as each other.
    pub(crate) fn part(&mut self, cast: &Cast, n_layers: u32) {
        self.boundaries.clear();
        if n_layers == 1 {
            return;
        }
        // some thousand facets tell enough
        let some = self.chosen.iter().step_by(self.chosen.len() / 4096 + 1);
        let mut lowest: Vec<(u32, f32)> =
            some.map(|facet| (lowest_cell(cast, facet.index), facet.n_rays.max(1e-6))).collect();
        sort_by_key(&mut lowest, |&(cell, _)| cell);
        let share = lowest.iter().map(|(_, weight)| weight).sum::<f32>() / n_layers as f32;
        let mut before = 0.0;
        for (cell, weight) in lowest {
            let is_due = before >= share * (self.boundaries.len() + 1) as f32;
            if is_due && cell > self.boundaries.last().copied().unwrap_or(0) {
                self.boundaries.push(cell);
            }
            before += weight;
        }
        self.boundaries.truncate(n_layers.min(MAX_LAYERS) as usize - 1);
    }

    /// Number of facets.
    pub(crate) fn len(&self) -> usize {
        self.chosen.len()
    }

    /// Index in the frame of a facet.
    pub(crate) fn index(&self, facet: usize) -> u32 {
        self.chosen.get(facet).map_or(u32::MAX, |chosen| chosen.index)
    }

    /// Number of layers.
    pub(crate) fn n_layers(&self) -> u32 {
        self.boundaries.len() as u32 + 1
    }

    /// The first cell after each layer, for the uniform `layer_ends`.
    pub(crate) fn layer_ends(&self) -> [u32; MAX_LAYERS as usize] {
        std::array::from_fn(|layer| self.boundaries.get(layer).copied().unwrap_or(u32::MAX))
    }

    /// Packs some of the facets for the buffers `corners` and `item_offsets`: four words an axis, in the order (across, across, along),
    /// which are its places of the three corners and rank, layer, or nothing; and the items before each facet and of all.
    pub(crate) fn pack(&self, cast: &Cast, range: Range<usize>) -> (Vec<i32>, Vec<u32>) {
        let chosen = &self.chosen[range];
        let mut words = vec![0; chosen.len() * FACET_WORDS];
        let of_facet = |(words, &Chosen { index, .. }): (&mut [i32], &Chosen)| {
            let corners = cast.frame.facets[index as usize].map(|corner| cast.rays.project(corner));
            for axis in 0..3 {
                words[4 * axis..4 * axis + 3].copy_from_slice(&corners.map(|corner| corner[axis]));
            }
            words[3] = i32::from(cast.frame.rank_of_facet(index as usize));
            let lowest = lowest_cell(cast, index);
            words[7] = self.boundaries.partition_point(|&cell| cell <= lowest) as i32;
        };
        on_all_cores(|| words.par_chunks_mut(FACET_WORDS).zip(chosen).for_each(of_facet));
        let mut offsets = Vec::with_capacity(chosen.len() + 1);
        let mut before = 0;
        for facet in chosen {
            offsets.push(before);
            before += facet.n_items;
        }
        offsets.push(before);
        (words, offsets)
    }

    /// Ranges of facets that are packed together: at most so many facets, and items.
    pub(crate) fn batches(&self, most_facets: usize, most_items: u64) -> Vec<Range<usize>> {
        let mut batches = Vec::new();
        let (mut start, mut items) = (0, 0);
        for (index, facet) in self.chosen.iter().enumerate() {
            items += u64::from(facet.n_items);
            if index > start && (index - start == most_facets || items > most_items) {
                batches.push(start..index);
                (start, items) = (index, u64::from(facet.n_items));
            }
        }
        batches.push(start..self.chosen.len());
        batches
    }
}

/// The first cell in which a facet may have a crossing: its lowest corner is not below the centre of that cell.
fn lowest_cell(cast: &Cast, index: u32) -> u32 {
    let [a, b, c] = cast.frame.facets[index as usize].map(|corner| corner[cast.rays.axis]);
    cast.frame.n_below(cast.rays.axis, a.min(b).min(c), true).saturating_sub(1)
}

/// Crossings of a ray where rays are most crowded, nearly: the rays of each facet are spread evenly over its box.
fn most_crossings(chosen: &[Chosen], ends: &[Range<u32>; 2]) -> f32 {
    let cell = ends.clone().map(|side| (side.len() as f32 / MAP as f32).max(1.0));
    let mut crowd = [0.0; MAP * MAP];
    for facet in chosen {
        let [columns, rows] = [0, 1].map(|side| {
            let [first, last] = facet.rays[side].map(|ray| ray as f32);
            let [first, end] = [first, last + 1.0].map(|ray| ray / cell[side]);
            (first as usize..(end.ceil() as usize).min(MAP)).map(move |at| {
                let share = (end.min(at as f32 + 1.0) - first.max(at as f32)) / (end - first);
                (at, share)
            })
        });
        for (row, down) in rows {
            for (column, across) in columns.clone() {
                crowd[row * MAP + column] += facet.n_rays * down * across;
            }
        }
    }
    crowd.into_iter().fold(0.0, f32::max) / (cell[0] * cell[1])
}

fn choose(index: usize, (frame, rays): (&Frame, &Rays), ends: &[Range<u32>; 2]) -> Option<Chosen> {
    // without `map` of arrays, which is a call for each number: this runs for every facet and band
    let [a, b, c] = frame.facets[index];
    let corners = [rays.project(a), rays.project(b), rays.project(c)];
    let mut under = [[0; 2]; 2];
    // of the rays under its box, those of the band; and the rays in a square of a unit
    let (mut share, mut density) = (1.0, 1.0);
    for side in 0..2 {
        let [a, b, c] = [corners[0][side], corners[1][side], corners[2][side]];
        let [low, high] = [a.min(b).min(c), a.max(b).max(c)];
        let [start, end] = rays_between(frame, rays.across[side], [low, high]);
        let [first, last] = [start.max(ends[side].start as i32), (end.min(ends[side].end as i32)) - 1];
        if first > last {
            return None;
        }
        share *= (last - first + 1) as f32 / (end - start) as f32;
        density *= match frame.is_graded() {
            false => 1.0 / (1 << frame.fraction_bits) as f32,
            true => (end - start) as f32 / (high - low).max(1) as f32,
        };
        // bins, too, are counted from the first ray of the band
        under[side] = [first as u32 - ends[side].start, last as u32 - ends[side].start];
    }
    let bins = |[first, last]: [u32; 2]| last / BIN - first / BIN + 1;
    let (columns, rows) = (bins(under[0]), bins(under[1]));
    let at = |corner: usize, side: usize| corners[corner][side] as f32;
    let [to_b, to_c] = [[at(1, 0) - at(0, 0), at(1, 1) - at(0, 1)], [at(2, 0) - at(0, 0), at(2, 1) - at(0, 1)]];
    let area = share * density * 0.5 * (to_b[0] * to_c[1] - to_c[0] * to_b[1]).abs();
    let n_under = |[first, last]: [u32; 2]| (last - first + 1) as f32;
    Some(Chosen {
        index: index as u32,
        n_bins: columns * rows,
        n_items: columns.div_ceil(SEGMENT) * rows,
        n_rays: area.min(n_under(under[0]) * n_under(under[1])),
        rays: under,
    })
}

/// The rays within a stretch of an axis across them, first and end, exclusive: those of equal cells also beyond the box.
fn rays_between(frame: &Frame, axis: usize, [low, high]: [i32; 2]) -> [i32; 2] {
    if frame.is_graded() {
        return [(low, false), (high, true)].map(|(place, with_at)| frame.n_below(axis, place, with_at) as i32);
    }
    let (bits, unit) = (frame.fraction_bits, 1 << frame.fraction_bits);
    [(low + unit - 1) >> bits, (high >> bits) + 1]
}

/// Centres of cells that differ in size, as `shaders/shared/graded.wgsl` reads them; none of equal cells.
pub(crate) fn centres(cast: &Cast) -> Vec<i32> {
    let Some(places) = &cast.frame.centres else { return Vec::new() };
    let [first, second] = cast.rays.across;
    [first, cast.rays.axis, second].map(|axis| &places.centres[axis][..]).concat()
}
