//! What the frame promises all that is proved here: corners and centres within 2^26 units, of which two cells are to spare; and that cells,
//! ranks and rays fit the words that they are packed in.

use std::cell::RefCell;

use hexcast::geometry::Geometry;
use hexcast::gpu::{DEEP, LINKED};
use hexcast::lines::Lines;
use hexcast_core::grid::frame::{Frame, MAX_CELLS_PER_AXIS, SPAN_BITS};
use hexcast_core::stages::crossings::event;

use super::bits::Symbolic;
use super::formulas::Formulas;
use super::interpret::{Interpreter, unsigned};
use super::kernels::hull;
use super::wide::bits_of;
use super::{changed, kernel};
use crate::soups::Random;

/// Units between the least and the greatest of corners and centres, and the fraction bits, of facets that reach beyond a domain.
fn spanned(random: &mut Random) -> (i128, u32) {
    let bits = random.below(17);
    let cells = 1 + random.below(1 << bits) as u32;
    let size = [1.0, 0.1, 0.3, 1e-3, 7.7e5][random.below(5) as usize];
    // half a cell more or less is a power of two now and then
    let far = (1u64 << random.below(16)) as f64 * [1.0, 0.5, 1.5, 0.999_999_9][random.below(4) as usize];
    let [low, high] = [-far * size, (f64::from(cells) + far) * size].map(|end| end as f32);
    let lines = Lines::new([0.0; 3], [size; 3], [cells, 1, 1]).expect("lines");
    let facet = [[low, 0.0, 0.0], [high, 0.0, 0.0], [low, size as f32, 0.0]];
    let frame = Frame::new(&[Geometry::new("g", 1, vec![facet]).unwrap()], &lines).expect("a frame");
    let centres = [0, i128::from(cells - 1) << frame.fraction_bits];
    let places = frame.facets[0].iter().map(|corner| i128::from(corner[0])).chain(centres);
    let [least, greatest] = [places.clone().min(), places.max()].map(|place| place.expect("places"));
    (greatest - least, frame.fraction_bits)
}

#[test]
fn corners_and_centres_lie_within_the_span() {
    let mut random = Random::new(26);
    let (mut n_half, mut widest) = (0, i128::MIN);
    for _ in 0..20_000 {
        let (span, fraction_bits) = spanned(&mut random);
        let hull = hull(SPAN_BITS, fraction_bits);
        assert!(span <= hull, "{span} of {hull} units with {fraction_bits} fraction bits");
        n_half += usize::from(2 * span > hull);
        widest = widest.max(span - hull);
    }
    // they fill it, so that no number of bits fewer would do
    assert!(n_half > 10_000 && widest >= -1, "{n_half}, {widest}");
}

#[test]
fn cells_ranks_and_rays_fit_their_words() {
    // a crossing beyond the last cell; a domain that is longer by one cell, of which the cells of a sheet are made
    let last = MAX_CELLS_PER_AXIS + 1;
    assert!(last < 1 << 18);
    // 27 bits, so that a row of 8 rays has 30, and none is like the word that stands for no crossing
    assert!(event(last, 255, true) < 1 << 27);
    assert_eq!(event(last, 255, true) >> 9, last);
    // a run
    assert!(u64::from(last) << 8 < 1 << 27);
    // up to 8 odd rays beside a place of 27 bits, below the mark of a segment that is linked
    let (most_odd, most_place) = (8u64 << 27, (1 << 27) - 1);
    assert!(most_odd + most_place < u64::from(LINKED));
    // the counts of runs of 8 rays, each at most 8 in 4 bits, are less than the mark of a deep row
    assert!((0..8).map(|ray| 8 << (4 * ray)).sum::<u32>() < DEEP);
}

/// Whether sums of the scans stay at the greatest number instead of wrapping around.
fn sums_saturate(module: &naga::Module) -> bool {
    let formulas = RefCell::new(Formulas::default());
    let domain = &Symbolic::new(&formulas);
    let [a, b] = [0, 1].map(|number| domain.input(number, 2, 1));
    let arguments = vec![unsigned(a.clone()), unsigned(b.clone())];
    let found = bits_of(&Interpreter::new(module, domain).call("add_saturating", arguments));
    let (sum, carry) = domain.sum(&a, &b, 0);
    found == domain.chosen(carry, &[1; 32], &sum)
}

#[test]
fn sums_of_scans_saturate() {
    assert!(sums_saturate(&kernel("scan_reduce")));
    assert!(!sums_saturate(&changed("scan_reduce", &[["0xffffffffu - a", "0xfffffffeu - a"]])));
}
