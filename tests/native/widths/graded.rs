//! Cells that differ in size: all is counted in units, so that quotients are longer, and centres are searched.

use hexcast_core::grid::frame::{MAX_CELLS_PER_AXIS, SPAN_BITS};
use naga::{Expression, Literal, Module};

use super::interpret::{Interpreter, Value, signed, unsigned};
use super::kernels::{Prover, on_all_frames, part};
use super::small::Small;
use super::{changed, kernel};

const NAME: &str = "intersect_graded";

/// q of a facet at any ray, and its height.
fn check_facet(prover: &Prover, module: &Module) {
    let f = prover.facet();
    let number = |name: &str| part(module, "Facet", &f, name).clone();
    let [a, b] = ["edge_a", "edge_b"].map(|name| prover.shader.call(name, vec![f.clone()]));
    let none = signed((0, 0));
    let walk = Value::Many(vec![none.clone(), none, unsigned((0, 0)), number("x"), number("y"), a, b]);
    let places = |n: usize| Value::Many(vec![signed(prover.places); n]);
    let [across, down] =
        ["edges_across", "edges_down"].map(|name| prover.shader.call(name, vec![walk.clone(), places(3)]));
    prover.shader.call("is_inside", vec![across, down]);
    // base and corners are places, and so is where the height is taken: steps from corner to row to ray are parts of that sum
    prover.shader.call("plane_at", vec![f, places(2), signed(prover.places)]);
}

#[test]
fn no_number_of_a_facet_in_units_wraps_around() {
    assert_eq!(on_all_frames(&kernel(NAME), SPAN_BITS, check_facet), Vec::<String>::new());
    // 31 bits are too many
    let faults = on_all_frames(&kernel(NAME), 31, check_facet);
    assert!(faults.iter().any(|fault| fault.contains("in 96 bits")), "{faults:?}");
}

/// A height in units that is wrong, with guesses of quotients that are wrong by 2^-16.
fn first_wrong_height(module: &Module) -> Option<String> {
    let wholes =
        [0, 1, 8191, 8192, 8193, (1 << 19) - 1, 1 << 19, (1 << 25) + 12_345, (1 << SPAN_BITS) - 1, 1 << SPAN_BITS];
    let divisors = [1, 2, 3, 5, 13, (1 << 31) - 1, 1 << 32, (1 << 33) + 1, (1 << 48) + 7, (1 << 53) - 1, (1 << 54) - 1];
    for off in [-1.0, 0.0, 1.0] {
        let guess = |value: f64, by: f64| value / by * (1.0 + off / 65_536.0);
        let domain = &Small::guessing(&guess);
        let shader = Interpreter::new(module, domain);
        for (whole, divisor) in wholes.iter().flat_map(|&whole| divisors.iter().map(move |&divisor| (whole, divisor))) {
            for rest in [0, 1, divisor / 2, divisor - 1].into_iter().filter(|&rest| rest < divisor) {
                let value: u128 = whole * divisor + rest;
                let found = shader.call("units", vec![domain.limbs(value, 3), domain.limbs(divisor, 2)]);
                let [found_whole, found_rest] = found.parts() else { panic!("no quotient") };
                if (u128::from(*found_whole.word()), domain.number(found_rest)) != (whole, rest) {
                    return Some(format!("{whole} {rest}/{divisor}, guesses off by {off}"));
                }
            }
        }
    }
    None
}

#[test]
fn heights_in_units_are_exact_whatever_is_guessed() {
    assert_eq!(first_wrong_height(&kernel(NAME)), None);
    for [from, to] in [
        ["(high.whole << 13u) | q.whole", "(high.whole << 13u) + high.whole"],
        ["(high.rest.x << 13u) | low", "high.rest.x << 13u"],
        ["high.rest.x >> 19u", "high.rest.x >> 18u"],
        ["float64(high.rest) * 8192.0", "float64(high.rest) * 4096.0"],
    ] {
        assert!(first_wrong_height(&changed(NAME, &[[from, to]])).is_some(), "{to}");
    }
}

/// A search that is wrong, among up to so many centres.
fn first_wrong_search(module: &Module, most: usize) -> Option<String> {
    let guess = |value: f64, by: f64| value / by;
    let domain = &Small::guessing(&guess);
    for n in 0..=most {
        let mut shader = Interpreter::new(module, domain);
        // one more, which no search may find
        let centres = (0..=n as u64).map(|at| signed(3 * at));
        shader.globals.insert("centres", Value::Many(centres.collect()));
        for (start, place) in (0..=n.min(3)).flat_map(|start| (0..3 * n as u64 + 2).map(move |place| (start, place))) {
            let found = shader.call("first_from", vec![unsigned(start as u64), unsigned(n as u64), signed(place)]);
            let expected = (start as u64..n as u64).find(|at| 3 * at >= place).unwrap_or(n as u64);
            if *found.word() != expected {
                return Some(format!("{place} among {start}..{n}: {}", found.word()));
            }
        }
    }
    None
}

/// Halvings of a search, three a loop, by the constant of the text.
fn halvings(module: &Module) -> u32 {
    let (_, loops) = module
        .constants
        .iter()
        .find(|(_, constant)| constant.name.as_deref() == Some("SEARCH_LOOPS"))
        .expect("it is there");
    let Expression::Literal(Literal::U32(loops)) = module.global_expressions[loops.init] else { panic!("no number") };
    3 * loops
}

#[test]
fn a_search_ends_at_the_first_centre_that_is_not_below() {
    let module = kernel(NAME);
    assert_eq!(first_wrong_search(&module, 40), None);
    assert!(
        first_wrong_search(&changed(NAME, &[["centres[middle] < place", "centres[middle] <= place"]]), 40).is_some()
    );
    // fewer than 2^k are none after k halvings; points of staggered grids are two more than cells may be
    assert!(MAX_CELLS_PER_AXIS < 1 << halvings(&module));
    let two = changed(NAME, &[["SEARCH_LOOPS: u32 = 6u", "SEARCH_LOOPS: u32 = 2u"]]);
    assert_eq!(first_wrong_search(&two, 63), None);
    assert!(first_wrong_search(&two, 64).is_some());
}
