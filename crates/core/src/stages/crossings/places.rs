//! Where along their rays crossings lie, for what is measured within cells.
//!
//! Facets, rays of a window -> [`Places`]: the crossings of each ray, in order. The first of each ray stand in slots: the first slots of all rays one after another,
//! then the second ones. A network sorts the slots of several rays at once. Further crossings go to a list.
//!
//! A crossing is `place << 9 | rank << 1 | direction`, of fewer than 60 bits. Slots hold the f64 of these bits and of bit 62: positive numbers are in the order of their bits, and
//! processors have instructions for the less and the greater of two f64.
//!
//! Cost: O(rows of facets + crossings) time; 65 bytes a ray, which are used again.

use std::ops::Range;

use super::rows::{Height, Rows};
use crate::base::network::{self, SLOTS};
use crate::grid::frame::Frame;
use crate::grid::rays::Rays;
use crate::stages::facet::Projected;

/// Lowest bits of a crossing: `rank << 1 | direction`.
const EVENT_BITS: u32 = 9;
/// What makes a positive number of the bits of a crossing, which are fewer than 60.
const NUMBER: u64 = 1 << 62;

/// The crossings of the rays of a window.
#[derive(Default)]
pub struct Places {
    /// Slots from one of a ray to its next: rays, and some more.
    stride: usize,
    slots: Vec<f64>,
    /// Crossings of each ray; [`SLOTS`] + 1 where there are more than slots.
    counts: Vec<u8>,
    /// Ray and crossing, of rays whose slots are all in use.
    further: Vec<(u32, f64)>,
    /// The crossings of a ray that has more than slots.
    many: Vec<f64>,
}

/// Places of a row that are computed at once.
const AT_ONCE: usize = 8;
/// Rays whose slots are sorted at once.
const LANES: usize = 4;

/// Place of a crossing.
#[inline(always)]
pub fn place_of(crossing: u64) -> u64 {
    crossing >> EVENT_BITS
}

/// Rank and direction of a crossing.
#[inline(always)]
pub fn event_of(crossing: u64) -> u32 {
    (crossing & ((1 << EVENT_BITS) - 1)) as u32
}

/// Takes the hits of a facet.
struct Taken<'a, F> {
    places: &'a mut Places,
    /// First ray of the window along each axis, and rays of a row.
    first: [u32; 2],
    n_across: u32,
    event: u64,
    place: F,
}

impl<F: Fn(f64) -> u64> Rows for Taken<'_, F> {
    #[inline(always)]
    fn row(&mut self, j: u32, across: Range<u32>, hits: impl Iterator<Item = (u32, Height)>) {
        let start = ((j - self.first[1]) * self.n_across + across.start - self.first[0]) as usize;
        let rays = start..start + across.len();
        let Places { stride, slots, counts, further, .. } = &mut *self.places;
        let (event, mut hits) = (self.event, hits.map(|(_, height)| height));
        for first in rays.clone().step_by(AT_ONCE) {
            let rays = first..(first + AT_ONCE).min(rays.end);
            let (mut parts, mut of_facet) = ([[0.0; AT_ONCE]; 2], Height::default());
            for lane in 0..rays.len() {
                let Some(height) = hits.next() else { return };
                let [below, rest] = height.parts();
                (parts[0][lane], parts[1][lane], of_facet) = (below, rest, height);
            }
            let mut numbers = [0.0; AT_ONCE];
            for lane in 0..AT_ONCE {
                let at = of_facet.place_of([parts[0][lane], parts[1][lane]]);
                numbers[lane] = f64::from_bits(NUMBER + ((self.place)(at) << EVENT_BITS | event));
            }
            for ((number, count), ray) in numbers.into_iter().zip(&mut counts[rays.clone()]).zip(rays) {
                let slot = usize::from(*count);
                if slot < SLOTS {
                    slots[slot * *stride + ray] = number;
                    *count += 1;
                } else {
                    *count = SLOTS as u8 + 1;
                    further.push((ray as u32, number));
                }
            }
        }
    }
}

impl Places {
    /// Casts the rays of a window, ranges of rays along both axes across, against facets: at least all that they hit. `place` makes 48 bits, in order, of a place along a
    /// ray in units, known to 2^-50 of itself.
    pub fn cast(
        &mut self,
        (frame, rays): (&Frame, &Rays),
        facets: &[u32],
        window: &[Range<u32>; 2],
        place: impl Fn(f64) -> u64 + Copy,
    ) {
        let n_rays = (window[0].len() * window[1].len()).next_multiple_of(LANES);
        // the slots of a ray do not fall on the same lines of the cache
        self.stride = n_rays + 24;
        self.slots.resize(self.slots.len().max(SLOTS * self.stride), 0.0);
        self.counts.clear();
        self.counts.resize(n_rays, 0);
        self.further.clear();
        for &facet in facets {
            let Some(projected) = Projected::new(&frame.facets[facet as usize], frame, rays) else { continue };
            let event = u64::from(super::event(0, frame.rank_of_facet(facet as usize), projected.exits));
            let (first, n_across) = ([window[0].start, window[1].start], window[0].len() as u32);
            let mut taken = Taken { places: &mut *self, first, n_across, event, place };
            super::hits(&projected, (frame, rays), window, &mut taken);
        }
        self.finish();
    }

    /// Puts what was cast in order.
    fn finish(&mut self) {
        for first in (0..self.counts.len()).step_by(LANES) {
            self.sort(first);
        }
        self.further.sort_unstable_by(|one, other| one.0.cmp(&other.0).then(one.1.total_cmp(&other.1)));
    }

    /// The crossings of a ray of the window, counted row after row, in order.
    #[inline(always)]
    pub fn of_ray(&mut self, ray: u32) -> impl Iterator<Item = u64> {
        let n = usize::from(self.counts[ray as usize]);
        let (numbers, stride, n) = if n <= SLOTS {
            (&self.slots[ray as usize..], self.stride, n)
        } else {
            let further = self.further.partition_point(|(of, _)| *of < ray);
            let of_ray = self.further[further..].iter().take_while(|(of, _)| *of == ray).map(|(_, number)| *number);
            self.many.clear();
            self.many.extend((0..SLOTS).map(|slot| self.slots[slot * self.stride + ray as usize]));
            self.many.extend(of_ray);
            self.many.sort_unstable_by(f64::total_cmp);
            (&self.many[..], 1, self.many.len())
        };
        (0..n).map(move |slot| numbers[slot * stride].to_bits() - NUMBER)
    }

    /// Sorts the slots of some rays.
    #[inline(always)]
    fn sort(&mut self, first: usize) {
        let counts: [u8; LANES] = self.counts[first..first + LANES].try_into().expect("lanes");
        let most = counts.into_iter().max().unwrap_or(0);
        if most < 2 {
            return;
        }
        let sorted = network::sorted((&self.slots[first..], self.stride), &counts, most, |_| f64::INFINITY);
        for (slot, numbers) in sorted[..network::slots_of(most)].iter().enumerate() {
            self.slots[slot * self.stride + first..][..LANES].copy_from_slice(numbers);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_crossings_of_rays_come_in_order_also_of_many() {
        let mut state = 1u64;
        let mut random = |below: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % below
        };
        for most in [1, 3, 8, 9, 40] {
            let n_rays = 12;
            let mut expected: Vec<Vec<u64>> = (0..n_rays)
                .map(|_| (0..random(most + 1)).map(|_| random(1 << 30) << 27 | random(1 << 27)).collect())
                .collect();
            let mut places = Places { stride: n_rays + 24, ..Places::default() };
            places.slots = vec![3.0; SLOTS * places.stride];
            places.counts = vec![0; n_rays];
            for (ray, crossings) in expected.iter().enumerate() {
                for crossing in crossings {
                    let height = Height::default();
                    let event = crossing & 0x1ff;
                    let place = |_| crossing >> EVENT_BITS;
                    let mut taken = Taken { places: &mut places, first: [0; 2], n_across: n_rays as u32, event, place };
                    taken.row(0, ray as u32..ray as u32 + 1, std::iter::once((0, height)));
                }
            }
            places.finish();
            for (ray, crossings) in expected.iter_mut().enumerate() {
                crossings.sort_unstable();
                let found: Vec<u64> = places.of_ray(ray as u32).collect();
                assert_eq!(&found, crossings);
                assert!(found.iter().all(|&of| place_of(of) << EVENT_BITS | u64::from(event_of(of)) == of));
            }
        }
    }
}
