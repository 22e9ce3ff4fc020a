//! Quotients by a guess in f32 and exact steps: how wrong a guess may be, from the text and the rounding that WGSL allows; and that the
//! steps correct every guess that is no more wrong, whatever the device gives.

use std::cell::Cell;

use hexcast_core::grid::frame::{MIN_FRACTION_BITS, SPAN_BITS};
use hexcast_core::stages::cast::BIN;
use naga::{Expression, Literal, Module};

use super::interpret::{Interpreter, Value};
use super::roundings::Roundings;
use super::small::Small;
use super::{changed, kernel};

/// A guess may be wrong by 2^-16 of itself, as `wide.wgsl` says.
const WRONG_BY: u128 = 1 << 16;

/// How wrong a guess of a quotient of wide numbers is at most, of itself.
fn wrong_by(module: &Module) -> f64 {
    let domain = &Roundings;
    let shader = Interpreter::new(module, domain);
    let float = |name: &str, n_words: usize| {
        shader.call(name, vec![Value::Many(vec![super::interpret::unsigned(()); n_words])])
    };
    let wrong = |value| {
        let Value::Float(wrong) = shader.call("guess", vec![value, float("float64", 2)]) else { panic!("no float") };
        wrong.by
    };
    wrong(float("float96", 3)).max(wrong(float("float64", 2)))
}

#[test]
fn a_guess_is_wrong_by_less_than_2_19() {
    let found = wrong_by(&kernel("intersect"));
    assert!(found < libm::exp2(-19.0) && found > libm::exp2(-22.0), "2^{}", libm::log2(found));
    let wrong = [
        "return f32(a.y) * 4294967296.0 + f32(a.x);",
        "return f32(a.y) * 3.0 * 3.0 * 3.0 * 3.0 * 3.0 * 3.0 + f32(a.x);",
    ];
    let found = wrong_by(&changed("intersect", &[wrong]));
    assert!(found > libm::exp2(-19.0), "2^{}", libm::log2(found));
}

/// All that a device may give for a quotient that is made of the whole number of divisors and a rest, rounded down: it may be wrong by one
/// part of so many.
fn first_guesses([whole, rest, divisor]: [u128; 3], part: u128) -> impl Iterator<Item = u128> {
    let value = whole * divisor + rest;
    let [low, high] = [part - 1, part + 1].map(|times| value * times / (part * divisor));
    low..=high
}

/// The same of a quotient of floats, as far as it makes a difference once rounded down or up.
fn second_guesses(exact: f64, part: u128) -> Vec<f64> {
    let [low, high] = [-1.0, 1.0].map(|sign| exact * (1.0 + sign / part as f64));
    let whole = (low.ceil() as i64..=high.floor() as i64).map(|whole| whole as f64);
    [low, exact, high].into_iter().chain(whole).collect()
}

/// A quotient that is wrong: of a whole number of divisors and a rest, with guesses that may be wrong by one part of so many.
fn first_wrong(module: &Module, name: &str, part: u128, numbers: &[[u128; 3]]) -> Option<String> {
    for &number in numbers {
        let [whole, rest, divisor] = number;
        for first in first_guesses(number, part) {
            for second in 0..5 {
                let n_guessed = Cell::new(0);
                let guess = |value: f64, by: f64| {
                    n_guessed.set(n_guessed.get() + 1);
                    if n_guessed.get() == 1 {
                        return first as f64;
                    }
                    let found = second_guesses(value / by, part);
                    found[second % found.len()]
                };
                let domain = &Small::guessing(&guess);
                // the first guess is made of the size, which is not looked at here
                let value = domain.limbs(whole * divisor + rest, 2);
                let arguments = vec![value, Value::Float(0.0), domain.limbs(divisor, 2)];
                let found = Interpreter::new(module, domain).call(name, arguments);
                let [found_whole, found_rest] = found.parts() else { panic!("no quotient") };
                if (u128::from(*found_whole.word()), domain.number(found_rest)) != (whole, rest) {
                    return Some(format!("{whole} {rest}/{divisor}, guessed {first}"));
                }
                if n_guessed.get() == 1 {
                    break;
                }
            }
        }
    }
    None
}

/// Wholes near both ends of their range, rests and divisors: all rests of the small ones. What follows the first guess depends on how far
/// it is off, the rest and the divisor alone, and a quotient near the end is off by all that a smaller one may be.
fn numbers(below: u128, most_bits: u32) -> Vec<[u128; 3]> {
    let mut found = Vec::new();
    let wholes = [0, 1, 2, 9, 10, below / 3, below - 2, below - 1];
    for divisor in [1, 2, 3, 5, 8, 13] {
        found.extend(wholes.iter().flat_map(|&whole| (0..divisor).map(move |rest| [whole, rest, divisor])));
    }
    for bits in [31, 32, 33, 48, 53, most_bits] {
        for divisor in [(1 << bits) - 1, (1u128 << (bits - 1)) + 1] {
            let rests = [0, 1, divisor / 2, divisor - 2, divisor - 1];
            found.extend(wholes.iter().flat_map(|&whole| rests.map(move |rest| [whole, rest, divisor])));
        }
    }
    found
}

#[test]
fn a_quotient_corrects_every_guess_that_is_wrong_by_2_16() {
    let module = kernel("intersect");
    assert_eq!(first_wrong(&module, "quotient", WRONG_BY, &numbers(1 << 19, 57)), None);
    // the second step is to spare, the second guess is not
    let one_step = changed(
        "intersect",
        &[[
            "let one = corrected(Quotient(first + bitcast<u32>(more), rest), divisor);\nreturn corrected(one, divisor);",
            "return corrected(Quotient(first + bitcast<u32>(more), rest), divisor);",
        ]],
    );
    assert_eq!(first_wrong(&one_step, "quotient", WRONG_BY, &numbers(1 << 19, 57)), None);
    let no_guess = changed(
        "intersect",
        &[
            ["rest = sub64(rest, times64_signed(divisor, more));", ""],
            ["Quotient(first + bitcast<u32>(more), rest)", "Quotient(first, rest)"],
        ],
    );
    assert!(first_wrong(&no_guess, "quotient", WRONG_BY, &numbers(1 << 19, 57)).is_some());
    assert!(first_wrong(&module, "quotient", WRONG_BY, &numbers(1 << 19, 62)).is_some(), "a divisor of 62 bits fits");
    assert!(
        first_wrong(&module, "quotient", 2, &numbers(1 << 19, 57)).is_some(),
        "a guess that is wrong by a half will do"
    );
}

#[test]
fn a_small_quotient_needs_one_step() {
    let module = kernel("intersect");
    assert_eq!(first_wrong(&module, "small_quotient", WRONG_BY, &numbers(1 << 16, 57)), None);
    let step = "let one = corrected(Quotient(first, sub64(value, times64(divisor, first))), divisor);\nreturn corrected(one, divisor);";
    let one_step = changed(
        "intersect",
        &[[step, "return corrected(Quotient(first, sub64(value, times64(divisor, first))), divisor);"]],
    );
    assert_eq!(first_wrong(&one_step, "small_quotient", WRONG_BY, &numbers(1 << 16, 57)), None);
    let no_step = changed("intersect", &[[step, "return Quotient(first, sub64(value, times64(divisor, first)));"]]);
    assert!(first_wrong(&no_step, "small_quotient", WRONG_BY, &numbers(1 << 16, 57)).is_some());
    assert!(first_wrong(&one_step, "small_quotient", WRONG_BY, &numbers(1 << 19, 57)).is_some());
}

/// Quotients of all small numbers, rounded down, and their 32 bits after the point, rounded down.
fn first_wrong_fraction(module: &Module) -> Option<String> {
    let guess = |value: f64, by: f64| value / by;
    let domain = &Small::guessing(&guess);
    let shader = Interpreter::new(module, domain);
    for divisor in 1..=24i128 {
        for value in -60..=60i128 {
            let found = shader.call("fixed", vec![domain.limbs(value as u128, 3), domain.limbs(divisor as u128, 2)]);
            let [cells, fraction, is_exact] = found.parts() else { panic!("not fixed") };
            let cells = i128::from(*cells.word() as u32 as i32);
            let exact = (value << 32).div_euclid(divisor);
            let is_right = (cells << 32 | i128::from(*fraction.word())) == exact
                && *is_exact.truth() == ((value << 32).rem_euclid(divisor) == 0);
            if !is_right {
                return Some(format!("{value} / {divisor}"));
            }
        }
    }
    None
}

#[test]
fn quotients_of_negative_numbers_are_rounded_down() {
    assert_eq!(first_wrong_fraction(&kernel("intersect")), None);
    for (from, to) in [
        ("select(~q.whole, 0u - q.whole, is_whole)", "~q.whole"),
        ("(high.whole << 16u) | low.whole", "(high.whole << 16u) + high.whole"),
        ("(low.rest.x | low.rest.y) == 0u", "low.rest.y == 0u"),
    ] {
        assert!(first_wrong_fraction(&changed("intersect", &[[from, to]])).is_some(), "{to}");
    }
}

/// The cells of a step from which a tile is too steep, from the text.
fn steepest(module: &Module) -> f64 {
    let is_steep = module.functions.iter().find(|(_, function)| function.name.as_deref() == Some("is_steep"));
    let expressions = &is_steep.expect("is_steep").1.expressions;
    let mut floats = expressions.iter().filter_map(|(_, expression)| match expression {
        Expression::Literal(Literal::F32(value)) => Some(f64::from(*value)),
        _ => None,
    });
    let found = floats.next().expect("a number of cells");
    assert!(floats.next().is_none(), "one number");
    found
}

/// Whether heights within a bin are quotients that `quotient` can do, and steps fit 16 bits.
fn heights_fit(steepest: f64, bin: u32) -> bool {
    // both sides of the comparison are in f32
    let step = steepest * (1.0 + 1.0 / WRONG_BY as f64) + 1.0;
    let cells = f64::from(1u32 << (SPAN_BITS - MIN_FRACTION_BITS));
    let height = cells + 2.0 * f64::from(bin - 1) * step + 1.0;
    height < libm::exp2(19.0) && step < libm::exp2(15.0)
}

#[test]
fn heights_of_tiles_that_are_not_steep_have_quotients_below_2_19() {
    assert!(heights_fit(steepest(&kernel("intersect")), BIN));
    assert!(!heights_fit(steepest(&changed("intersect", &[["16000.0", "20000.0"]])), BIN));
    assert!(!heights_fit(16000.0, 2 * BIN));
}

/// The first guess is off by less than 9 divisors, or 10 with what it was rounded by: a rest that fits 64 bits with its sign, as the
/// divisor has at most 57.
#[test]
fn the_rest_of_a_guess_fits_64_bits() {
    let most_off = (1u128 << 19) / WRONG_BY + 2;
    assert_eq!(most_off, 10);
    assert!(most_off * (1 << 57) < 1 << 63);
    assert!(most_off * (1 << 60) > 1 << 63);
}
