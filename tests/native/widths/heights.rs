//! Heights of tiles in `map.wgsl`: 32 bits after the point, rounded down. Steps from ray to ray are exact sums of 64 bits, and what is too
//! near to a centre is marked; both for all numbers, as formulas.

use std::cell::RefCell;

use hexcast_core::stages::cast::BIN;
use naga::Module;

use super::bits::{Bits, Symbolic};
use super::formulas::{FALSE, Formulas, TRUE};
use super::interpret::{Interpreter, Value, unsigned};
use super::wide::bits_of;
use super::{changed, kernel};

/// A height, or a step: cells and fraction, as the shader has them; here the fraction is the lower half.
fn height<'a>(bits: &Bits) -> Value<Symbolic<'a>> {
    Value::Many(vec![unsigned(bits[32..].to_vec()), unsigned(bits[..32].to_vec())])
}

/// The bits of a height, the fraction first.
fn bits_of_height(value: &Value<Symbolic>) -> Bits {
    let [cells, fraction] = value.parts() else { panic!("no height") };
    [bits_of(fraction), bits_of(cells)].concat()
}

/// Whether the height at the first ray of each row is the first and as many steps.
fn rows_are_exact(module: &Module) -> bool {
    let formulas = RefCell::new(Formulas::default());
    let domain = &Symbolic::new(&formulas);
    let shader = Interpreter::new(module, domain);
    let [first, step] = [0, 1].map(|number| domain.input(number, 2, 2));
    (0..BIN).all(|row| {
        let row_value = unsigned(Symbolic::number(row.into(), 32));
        let found = shader.call("height_of_row", vec![height(&first), height(&step), row_value]);
        bits_of_height(&found) == domain.sum(&first, &domain.product(&step, row.into()), FALSE).0
    })
}

#[test]
fn rows_are_exact_sums_of_64_bits() {
    assert!(rows_are_exact(&kernel("map")));
    assert!(!rows_are_exact(&changed("map", &[["* row + (low >> 16u)", "* row"]])));
    assert!(!rows_are_exact(&changed("map", &[["(high >> 16u) + u32(fraction < first.fraction)", "(high >> 16u)"]])));
}

/// What is wrong with the crossing of one ray of a row.
///
/// A tile has its height and its two steps rounded down, each by less than 2^-32: at most 7 rays and 7 rows on, a height is less than 15
/// such units too low. So its cells are right unless its fraction is one of the last 15; and whether a centre lies at the height itself
/// is certain unless the fraction is 0. A tile says so by a margin of 16, or 17 where a centre at the height would lie above the
/// facet; if its numbers are exact, by a margin of 0.
fn wrong_crossing(module: &Module, depth: u32, ray: u32) -> Option<&'static str> {
    let formulas = RefCell::new(Formulas::default());
    let domain = &Symbolic::new(&formulas);
    let mut shader = Interpreter::new(module, domain);
    let any = || unsigned(vec![FALSE; 32]);
    let params = (0..17).map(|at| if at == 2 { unsigned(Symbolic::number(depth.into(), 32)) } else { any() });
    shader.globals.insert("params", Value::Many(params.collect()));
    let [now, step] = [0, 1].map(|number| domain.input(number, 2, 2));
    let other = |number: u32| formulas.borrow_mut().variable(1000 + number);
    let (is_exact, tie_is_above, was_undecided) = (other(0), other(1), other(2));
    let hits: Bits = (0..32).map(|bit| if bit < 8 { other(10 + bit) } else { FALSE }).collect();
    let label: Bits = (0..32).map(|bit| if bit < 9 { other(20 + bit) } else { FALSE }).collect();
    let is_inexact = domain.not(&[is_exact])[0];
    let mut margin = vec![FALSE; 32];
    (margin[0], margin[4]) = (domain.and(is_inexact, tie_is_above), is_inexact);
    let mut tie_is_below = vec![FALSE; 32];
    tie_is_below[0] = domain.not(&[tie_is_above])[0];
    let [step_cells, step_fraction] = [step[32..].to_vec(), step[..32].to_vec()];
    let slope = [hits.clone(), step_cells, step_fraction, margin, tie_is_below, label.clone()].map(unsigned);
    let undecided: Bits = (0..32).map(|bit| if bit == 0 { was_undecided } else { FALSE }).collect();
    let mut heap = vec![height(&now), unsigned(undecided)];
    let pointers = [0, 1].map(|place| Value::Pointer(place, Vec::new()));
    let [of_height, of_undecided] = pointers;
    let ray_value = unsigned(Symbolic::number(ray.into(), 32));
    let arguments = vec![ray_value, Value::Many(slope.to_vec()), of_height, of_undecided];
    let event = bits_of(&shader.call_on(&mut heap, "cross", arguments).expect("a crossing"));
    if bits_of_height(&heap[0]) != domain.sum(&now, &step, FALSE).0 {
        return Some("the next height");
    }
    let (cells, fraction) = (&now[32..], &now[..32]);
    let is_last = domain.not(&[domain.is_less(fraction, &Symbolic::number((1 << 32) - 16, 32))])[0];
    let is_zero = domain.is_equal(fraction, &[FALSE; 32]);
    let is_on_centre = domain.and(is_zero, tie_is_above);
    let is_near = domain.and(is_inexact, domain.or(is_last, is_on_centre));
    let is_undecided = domain.or(was_undecided, domain.and(hits[ray as usize], is_near));
    if bits_of(&heap[1])[0] != is_undecided {
        return Some("what is marked");
    }
    // cells with their sign turned over are in the order of numbers without one
    let above = domain.chosen(is_on_centre, cells, &domain.sum(cells, &Symbolic::number(1, 32), FALSE).0);
    let end = Symbolic::number(depth.into(), 32);
    let is_beyond = domain.is_less(&end, &above);
    let clamped = domain.chosen(above[31], &[FALSE; 32], &domain.chosen(is_beyond, &end, &above));
    let packed: Bits = [&label[..9], &clamped[..23]].concat();
    let expected = domain.chosen(hits[ray as usize], &packed, &[TRUE; 32]);
    (event != expected).then_some("the crossing")
}

#[test]
fn crossings_are_right_or_marked() {
    let module = kernel("map");
    for depth in [1, 1000, 262_142] {
        for ray in [0, 7] {
            assert_eq!(wrong_crossing(&module, depth, ray), None, "{depth} cells");
        }
    }
    // 1 of the height itself, and 1 of each step: less than the 16 that are marked
    let too_low = |bin: u32| 1 + 2 * (bin - 1);
    assert!(too_low(BIN) < 16 && too_low(BIN + 1) > 16);
}

#[test]
fn a_wrong_crossing_is_found() {
    for (from, to, what) in [
        ("h.fraction + 16u < slope.margin", "h.fraction + 8u < slope.margin", "what is marked"),
        ("h.fraction + 16u < slope.margin", "h.fraction + 17u < slope.margin", "what is marked"),
        ("u32(fraction < h.fraction)", "u32(fraction <= h.fraction)", "the next height"),
        ("(h.fraction | slope.tie_is_below) == 0u", "h.fraction == 0u", "the crossing"),
    ] {
        assert_eq!(wrong_crossing(&changed("map", &[[from, to]]), 1000, 3), Some(what), "{to}");
    }
}
