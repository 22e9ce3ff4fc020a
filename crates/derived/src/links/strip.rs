//! The links on the rays of a strip: facets are cast, crossings put in order by ray and place, and walked along, in one go.
//!
//! Facets that rays of the strip meet -> links along the rays and against them, plane after plane of cells ([`ByPlane`]).
//!
//! # Theory
//! Most links have one crossing. Where all geometries are decided by rays, the flags before and behind it say all: where only one of them is of the fluid,
//! the link from there meets the facet. Then also q is known: casting in equal cells finds `r = floor(height 2^-F) mod D` for each ray of a row, and the last F bits `l`
//! of all heights of a facet are the same, so that `(r 2^F + l) / (D 2^F)` is the fraction from the lower cell, in 64 bits unless the facet is very large.
//!
//! Other links are walked from crossing to crossing (`links/walk.rs`).
//!
//! Cost: 20 ns a link, about; 40 bytes a crossing of a strip, which are used again for the next.

use std::ops::Range;

use super::Link;
use super::order::ByPlane;
use super::walk::{Between, Scratch, Walk};
use hexcast_core::base::error::Result;
use hexcast_core::base::sort::{by_counts, clear_counts, count_of};
use hexcast_core::stages::crossings::rows::{Height, Rows};
use hexcast_core::stages::crossings::{event, hits};
use hexcast_core::stages::facet::Projected;
use hexcast_core::stages::inside::{Inside, Kind};
use hexcast_core::stages::lattice::Lattice;

/// Lowest bits of a crossing: `rank << 1 | direction`.
const EVENT_BITS: u32 = 9;
/// Crossings of a ray that are sorted by insertion.
const FEW: usize = 16;

/// A crossing of a ray of the strip.
#[derive(Clone, Copy, Default)]
struct Crossing {
    /// `cell << 9 | rank << 1 | direction`.
    event: u32,
    /// Which of the facets that were met.
    met: u32,
    /// [`Height::above_centre`].
    rest: i64,
}

impl Crossing {
    fn key(&self) -> u64 {
        u64::from(self.event) << 32 | u64::from(self.met)
    }

    fn above(&self) -> u32 {
        self.event >> EVENT_BITS
    }
}

/// A facet that rays of the strip may meet.
struct Met {
    /// In the sheared frame.
    facet: u32,
    /// D 2^F, or 0 where that has more than 62 bits, or cells differ in size.
    whole: i64,
    /// The last F bits of heights.
    low: i64,
    /// What links say of it.
    of_geometry: (i32, i16),
}

/// Memory that a core uses for strip after strip.
#[derive(Default)]
pub(super) struct Memory {
    met: Vec<Met>,
    /// Ray of the strip and crossing, facet after facet.
    hits: Vec<(u32, Crossing)>,
    /// First crossing of each ray, then the end.
    offsets: Vec<u32>,
    sorted: Vec<Crossing>,
    events: Vec<[u32; 2]>,
    /// Along the rays, and against them.
    links: [Vec<Link>; 2],
    order: Vec<u32>,
    scratch: Option<Scratch>,
}

/// Takes the hits of a facet.
struct Taken<'a> {
    hits: &'a mut Vec<(u32, Crossing)>,
    /// Of each ray.
    counts: &'a mut [u32],
    first_row: u32,
    n_across: u32,
    tag: u32,
    met: u32,
}

impl Rows for Taken<'_> {
    #[inline(always)]
    fn row(&mut self, j: u32, across: Range<u32>, hits: impl Iterator<Item = (u32, Height)>) {
        let start = (j - self.first_row) * self.n_across + across.start;
        let (tag, met) = (self.tag, self.met);
        let crossing = |(above, height): (u32, Height)| Crossing {
            event: above << EVENT_BITS | tag,
            met,
            rest: height.above_centre(),
        };
        self.hits.extend((start..).zip(hits.map(crossing)));
        self.counts[count_of(start)..][..across.len()].iter_mut().for_each(|count| *count += 1);
    }
}

impl Walk<'_> {
    /// The links on the rays of a row of bins, each as wide as the box; `starts` has the first facet of each position.
    pub(super) fn links(
        &self,
        lattice: &Lattice,
        row: u32,
        starts: &[usize],
        memory: &mut Memory,
    ) -> Result<[ByPlane; 2]> {
        let rays = &self.sheared.rays;
        let first = row * lattice.bin[1];
        let rows = first..(first + lattice.bin[1]).min(rays.counts[1]);
        self.cast(lattice.bin_facets(0, row), &rows, starts, memory);
        let Memory { met, hits, offsets, sorted, events, links, scratch, .. } = memory;
        by_counts(hits.iter().copied(), offsets, sorted);
        links.iter_mut().for_each(Vec::clear);
        let kinds = self.field.kinds;
        let mut inside = Inside::new(kinds, self.field.rule);
        let mut before = inside.clone();
        let scratch = scratch.get_or_insert_with(|| Scratch::new(&inside));
        for (ray, ends) in (0..).zip(offsets.windows(2)) {
            if ends[0] == ends[1] {
                continue;
            }
            let of_ray = &mut sorted[ends[0] as usize..ends[1] as usize];
            sort(of_ray);
            inside.begin(kinds);
            let across = [ray % rays.counts[0], rows.start + ray / rays.counts[0]];
            let begin = self.sheared.begin(across);
            let mut flag = self.flag(&inside);
            for of_link in of_ray.chunk_by(|one, other| one.above() == other.above()) {
                let above = of_link[0].above();
                if let [crossing] = of_link
                    && self.field.is_plain
                    && met[crossing.met as usize].whole > 0
                {
                    inside.pass(crossing.event, false);
                    let behind = self.flag(&inside);
                    self.single(begin, crossing, &met[crossing.met as usize], [flag, behind], links);
                    flag = behind;
                    continue;
                }
                before.clone_from(&inside);
                for crossing in of_link.iter().filter(|crossing| self.kind(crossing.event) != Kind::Apart) {
                    inside.pass(crossing.event, false);
                }
                flag = self.flag(&inside);
                events.clear();
                events.extend(of_link.iter().map(|crossing| [crossing.event, met[crossing.met as usize].facet]));
                let between = Between { across, above, events, before: &before, after: &inside, starts };
                self.links_between(between, scratch, links)?;
            }
        }
        let [along, against] = links;
        let mut by_plane = |links: &[Link]| ByPlane::new(links, &mut memory.order);
        Ok([by_plane(along), by_plane(against)])
    }

    /// Casts rows of rays at facets.
    fn cast(&self, facets: &[u32], rows: &Range<u32>, starts: &[usize], memory: &mut Memory) {
        let (frame, rays) = (&*self.sheared.frame, &self.sheared.rays);
        let window = [0..rays.counts[0], rows.clone()];
        let Memory { met, hits: found, offsets, .. } = memory;
        met.clear();
        found.clear();
        clear_counts(window[0].len() * rows.len(), offsets);
        let bits = frame.fraction_bits;
        for &facet in facets {
            let Some(projected) = Projected::new(&frame.facets[facet as usize], frame, rays) else { continue };
            let tag = event(0, frame.rank_of_facet(facet as usize), projected.exits);
            let is_narrow = !frame.is_graded() && projected.area >> (62 - bits) == 0;
            let mut taken = Taken {
                hits: found,
                counts: offsets,
                first_row: rows.start,
                n_across: rays.counts[0],
                tag,
                met: met.len() as u32,
            };
            hits(&projected, (frame, rays), &window, &mut taken);
            met.push(Met {
                facet,
                whole: if is_narrow { projected.area << bits } else { 0 },
                low: (projected.height & ((1 << bits) - 1)) as i64,
                of_geometry: self.field.facet_of_geometry(self.sheared.index(facet), starts),
            });
        }
    }

    /// The link with a single crossing, between the flags on its sides.
    #[inline(always)]
    fn single(
        &self,
        begin: [i64; 3],
        crossing: &Crossing,
        met: &Met,
        [flag, behind]: [u8; 2],
        links: &mut [Vec<Link>; 2],
    ) {
        let is_fluid = |flag: u8| self.is_fluid[usize::from(flag)];
        let above = crossing.above();
        if is_fluid(flag) == is_fluid(behind) || above == 0 || above >= self.sheared.rays.depth {
            return;
        }
        let Some(cells) = self.sheared.cells_beside(begin, above) else { return };
        let is_backward = is_fluid(behind);
        let side = usize::from(is_backward);
        let Some(cell) = self.field.window.place(cells[side]) else { return };
        let from_low = (crossing.rest << self.sheared.frame.fraction_bits) + met.low;
        let fraction = if is_backward { met.whole - from_low } else { from_low };
        let (facet, geometry) = met.of_geometry;
        links[side].push(Link {
            cell,
            q: ((fraction as f64 / met.whole as f64) as f32).max(f32::MIN_POSITIVE),
            facet,
            geometry,
            direction: self.directions[side],
            flag: if is_backward { flag } else { behind },
        });
    }

    fn flag(&self, inside: &Inside) -> u8 {
        inside.flag(&self.field.frame.ranks.flag_of_rank)
    }
}

/// Sorts the crossings of a ray by place, rank, direction and facet.
#[inline(always)]
fn sort(of_ray: &mut [Crossing]) {
    if of_ray.len() > FEW {
        of_ray.sort_unstable_by_key(Crossing::key);
        return;
    }
    for at in 1..of_ray.len() {
        let (crossing, mut to) = (of_ray[at], at);
        while to > 0 && of_ray[to - 1].key() > crossing.key() {
            of_ray[to] = of_ray[to - 1];
            to -= 1;
        }
        of_ray[to] = crossing;
    }
}
