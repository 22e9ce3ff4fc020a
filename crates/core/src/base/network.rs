//! Sorting networks: eight slots, in several lanes at once, with the processor's instructions for so many numbers.

/// Slots that are sorted.
pub(crate) const SLOTS: usize = 8;

/// The slots of some lanes, sorted. The first slots of all lanes stand one after another, `stride` further the second ones. Of each lane so many
/// are in use, of all lanes at most `most`; `empty` makes what stands in the others, which is greater than any.
#[inline(always)]
pub(crate) fn sorted<K: Copy + PartialOrd, const LANES: usize>(
    (slots, stride): (&[K], usize),
    counts: &[u8; LANES],
    most: u8,
    empty: impl Fn(usize) -> K,
) -> [[K; LANES]; SLOTS] {
    let mut sorted: [[K; LANES]; SLOTS] = std::array::from_fn(|slot| [empty(slot); LANES]);
    let n_slots = slots_of(most);
    for slot in 0..n_slots {
        let keys: [K; LANES] = slots[slot * stride..][..LANES].try_into().expect("lanes");
        for lane in 0..LANES {
            sorted[slot][lane] = if counts[lane] > slot as u8 { keys[lane] } else { empty(slot) };
        }
    }
    match n_slots {
        2 => order(&mut sorted, 0, 1),
        4 => sort_4(&mut sorted),
        _ => sort_8(&mut sorted),
    }
    sorted
}

/// How many slots are sorted where at most so many are in use.
#[inline(always)]
pub(crate) fn slots_of(most: u8) -> usize {
    match most {
        0..=2 => 2,
        3 | 4 => 4,
        _ => SLOTS,
    }
}

/// Puts two slots in order, in all lanes.
#[inline(always)]
fn order<K: Copy + PartialOrd, const LANES: usize>(slots: &mut [[K; LANES]; SLOTS], a: usize, b: usize) {
    let (low, high) = (slots[a], slots[b]);
    for lane in 0..LANES {
        let is_in_order = low[lane] < high[lane];
        slots[a][lane] = if is_in_order { low[lane] } else { high[lane] };
        slots[b][lane] = if is_in_order { high[lane] } else { low[lane] };
    }
}

/// Sorts the first four slots with the network of five comparisons.
#[inline(always)]
fn sort_4<K: Copy + PartialOrd, const LANES: usize>(slots: &mut [[K; LANES]; SLOTS]) {
    order(slots, 0, 1);
    order(slots, 2, 3);
    order(slots, 0, 2);
    order(slots, 1, 3);
    order(slots, 1, 2);
}

/// Sorts all eight slots with Batcher's odd-even merge network.
#[inline(always)]
fn sort_8<K: Copy + PartialOrd, const LANES: usize>(slots: &mut [[K; LANES]; SLOTS]) {
    sort_4(slots);
    order(slots, 4, 5);
    order(slots, 6, 7);
    order(slots, 4, 6);
    order(slots, 5, 7);
    order(slots, 5, 6);
    order(slots, 0, 4);
    order(slots, 1, 5);
    order(slots, 2, 6);
    order(slots, 3, 7);
    order(slots, 2, 4);
    order(slots, 3, 5);
    order(slots, 1, 2);
    order(slots, 3, 4);
    order(slots, 5, 6);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_orders_of_zeros_and_ones_are_sorted() {
        // a network that sorts these sorts everything (Knuth, The Art of Computer Programming 3, 5.3.4, theorem Z)
        const LANES: usize = 4;
        for first in (0u32..256).step_by(LANES) {
            for most in 0..=SLOTS as u8 {
                let of_lane = |lane: usize, slot: usize| (first + lane as u32) >> slot & 1;
                let slots: Vec<u32> = (0..SLOTS * LANES).map(|at| of_lane(at % LANES, at / LANES)).collect();
                let counts: [u8; LANES] = std::array::from_fn(|lane| most.saturating_sub(lane as u8));
                let found = sorted((&slots, LANES), &counts, most, |slot| 2 + slot as u32);
                for (lane, &count) in counts.iter().enumerate() {
                    let keys = found.map(|slot| slot[lane]);
                    let mut expected: Vec<u32> = (0..usize::from(count)).map(|slot| of_lane(lane, slot)).collect();
                    expected.sort_unstable();
                    assert_eq!(keys[..usize::from(count)], expected);
                    assert!(keys[usize::from(count)..].iter().all(|&key| key > 1));
                }
            }
        }
    }
}
