//! `wide.wgsl`: sums, shifts and comparisons for all words of 32 bits, as formulas; products for all small words, whose partial products
//! fit words of 32 bits too.

use std::cell::RefCell;

use naga::Module;

use super::bits::{Bits, Symbolic};
use super::formulas::{FALSE, Formula, Formulas, TRUE};
use super::interpret::{Interpreter, Value, signed, unsigned};
use super::ranges::Ranges;
use super::small::Small;
use super::{changed, kernel};

/// Words of a number, as the shaders have them.
fn words<'a>(bits: &[Formula]) -> Value<Symbolic<'a>> {
    Value::Many(bits.chunks(32).map(|word| unsigned(word.to_vec())).collect())
}

/// All bits of a result, in the order of its parts.
pub(super) fn bits_of(value: &Value<Symbolic>) -> Bits {
    match value {
        Value::Many(parts) => parts.iter().flat_map(bits_of).collect(),
        Value::Bool(bit) => vec![*bit],
        word => word.word().clone(),
    }
}

/// Functions of two numbers and what they have to be; the first that differs.
fn first_wrong_sum(module: &Module) -> Option<String> {
    let formulas = RefCell::new(Formulas::default());
    let domain = &Symbolic::new(&formulas);
    let shader = Interpreter::new(module, domain);
    let call = |name: &str, of: &[&Bits]| bits_of(&shader.call(name, of.iter().map(|bits| words(bits)).collect()));
    let [a, b, a96, b96] = [(0, 2), (1, 2), (0, 3), (1, 3)].map(|(of, n)| domain.input(of, 2, n));
    let low = a[..32].to_vec();
    let extended = |bits: &[Formula], n: usize| [bits, &vec![*bits.last().expect("bits"); n - bits.len()]].concat();
    let zero = vec![FALSE; 64];
    let negative = a96[95];
    let magnitude = domain.chosen(negative, &domain.difference(&[FALSE; 96], &a96), &a96);
    let mut table = vec![
        ("add64".to_string(), call("add64", &[&a, &b]), domain.sum(&a, &b, FALSE).0),
        ("sub64".into(), call("sub64", &[&a, &b]), domain.difference(&a, &b)),
        ("negate64".into(), call("negate64", &[&a]), domain.difference(&zero, &a)),
        ("is_negative".into(), call("is_negative", &[&a]), vec![a[63]]),
        ("widen".into(), bits_of(&shader.call("widen", vec![signed(low.clone())])), extended(&low, 64)),
        ("widen96".into(), call("widen96", &[&a]), extended(&a, 96)),
        ("add96".into(), call("add96", &[&a96, &b96]), domain.sum(&a96, &b96, FALSE).0),
        ("magnitude96".into(), call("magnitude96", &[&a96]), magnitude),
    ];
    for by in 1..32 {
        for (name, number) in [("shift_right64", &a), ("shift_right96", &a96)] {
            let shift = unsigned(Symbolic::number(by, 32));
            let found = bits_of(&shader.call(name, vec![words(number), shift]));
            let sign = *number.last().expect("bits");
            table.push((format!("{name} by {by}"), found, Symbolic::shifted_right(number, by as usize, sign)));
        }
    }
    table.into_iter().find(|(_, found, expected)| found != expected).map(|(name, ..)| name)
}

#[test]
fn sums_and_shifts_are_exact_for_all_words() {
    assert_eq!(first_wrong_sum(&kernel("intersect")), None);
}

#[test]
fn a_wrong_carry_or_shift_is_found() {
    for (name, from, to) in [
        ("add64", "a.y + b.y + u32(low < a.x)", "a.y + b.y + u32(low <= a.x)"),
        ("sub64", "u32(a.x < b.x)", "u32(a.x <= b.x)"),
        ("add96", "z + u32(y_carried < y)", "z"),
        ("shift_right64 by 1", "(32u - bits)), bitcast<u32>", "(31u - bits)), bitcast<u32>"),
    ] {
        assert_eq!(first_wrong_sum(&changed("intersect", &[[from, to]])).as_deref(), Some(name), "{to}");
    }
}

/// Whether q is clamped to the nearest of +-2^30, and a step of the correction of a quotient is one of the divisor.
fn clamp_is_right(module: &Module) -> bool {
    let formulas = RefCell::new(Formulas::default());
    let domain = &Symbolic::new(&formulas);
    let a = domain.input(0, 1, 2);
    let found = bits_of(&Interpreter::new(module, domain).call("clamp_to_2_30", vec![words(&a)]));
    // with the sign turned over, numbers are in the order of those without a sign
    let ordered = |bits: &[Formula]| [&bits[..63], &domain.not(&bits[63..])].concat();
    let limit = |value: i64| Symbolic::number(value as u128, 64);
    let [low, high] = [limit(-1 << 30), limit(1 << 30)];
    let is_low = domain.is_less(&ordered(&a), &ordered(&low));
    let is_high = domain.is_less(&ordered(&high), &ordered(&a));
    let clamped = domain.chosen(is_low, &low, &domain.chosen(is_high, &high, &a));
    found == clamped[..32]
}

#[test]
fn a_clamped_number_is_the_nearest_within_2_30() {
    assert!(clamp_is_right(&kernel("lattice")));
    assert!(!clamp_is_right(&changed("lattice", &[["a.y == bitcast<u32>", "a.y != bitcast<u32>"]])));
}

/// A step of the correction is one divisor up where the rest is negative, one down where it is no less than the divisor.
fn correction_is_right(module: &Module) -> bool {
    let formulas = RefCell::new(Formulas::default());
    let domain = &Symbolic::new(&formulas);
    let (rest, mut divisor) = (domain.input(0, 2, 2), domain.input(1, 2, 2));
    divisor[63] = FALSE;
    let whole: Bits = (0..32).map(|bit| formulas.borrow_mut().variable(1000 + bit)).collect();
    let of = Value::Many(vec![unsigned(whole.clone()), words(&rest)]);
    let found = bits_of(&Interpreter::new(module, domain).call("corrected", vec![of, words(&divisor)]));
    let less = domain.difference(&rest, &divisor);
    let (is_low, is_high) = (rest[63], domain.is_less(&divisor, &[&rest[..63], &[FALSE]].concat()));
    let is_high = domain.or(is_high, domain.is_equal(&rest, &divisor));
    let is_high = domain.and(is_high, domain.not(&[is_low])[0]);
    let up = domain.chosen(is_low, &domain.sum(&rest, &divisor, FALSE).0, &rest);
    let one = Symbolic::number(1, 32);
    let down = domain.chosen(is_low, &domain.difference(&whole, &one), &whole);
    let wholes = domain.chosen(is_high, &domain.sum(&whole, &one, FALSE).0, &down);
    found == [wholes, domain.chosen(is_high, &less, &up)].concat()
}

#[test]
fn a_step_of_a_correction_is_one_divisor() {
    assert!(correction_is_right(&kernel("intersect")));
    let wrong = ["u32(is_high) - u32(is_low)", "u32(is_low) - u32(is_high)"];
    assert!(!correction_is_right(&changed("intersect", &[wrong])));
}

/// The first product that is wrong of all words of so many bits.
fn first_wrong_product(module: &Module, bits: u32) -> Option<String> {
    let domain = &Small::words(bits);
    let shader = Interpreter::new(module, domain);
    let span = 1u128 << bits;
    let with_sign = |value: u128, n_words: u32| {
        let unused = 128 - n_words * bits;
        (value << unused) as i128 >> unused
    };
    let wrapped = |value: i128, n_words: u32| value as u128 & ((1 << (n_words * bits)) - 1);
    let check = |name: &str, a: u128, a_words: u32, b: u128, is_signed: bool, n_words: u32| {
        let a_value = if a_words == 1 { unsigned(a as u64) } else { domain.limbs(a, a_words) };
        let a_value = if a_words == 1 && is_signed { signed(a as u64) } else { a_value };
        let b_value = if is_signed { signed(b as u64) } else { unsigned(b as u64) };
        let found = domain.number(&shader.call(name, vec![a_value, b_value]));
        let [a, b] = [(a, a_words), (b, 1)]
            .map(|(value, n_words)| if is_signed { with_sign(value, n_words) } else { value as i128 });
        (found != wrapped(a * b, n_words)).then(|| format!("{name} of {a} and {b}"))
    };
    // words of 64 bits: their number grows with the square
    let n_double = if bits <= 4 { span * span } else { 0 };
    let single = (0..span).flat_map(|a| (0..span).map(move |b| (a, b)));
    let double = (0..n_double).flat_map(|a| (0..span).map(move |b| (a, b)));
    single
        .flat_map(|(a, b)| {
            [("multiply_unsigned", false), ("multiply_signed", true)]
                .map(|(name, is_signed)| check(name, a, 1, b, is_signed, 2))
        })
        .chain(double.flat_map(|(a, b)| {
            [("multiply96", true, 3), ("times64", false, 2), ("times64_signed", true, 2)]
                .map(|(name, is_signed, n_words)| check(name, a, 2, b, is_signed, n_words))
        }))
        .flatten()
        .next()
}

#[test]
fn products_are_exact_for_all_small_words() {
    let module = kernel("intersect");
    for bits in [2, 4, 6, 8] {
        assert_eq!(first_wrong_product(&module, bits), None, "words of {bits} bits");
    }
}

#[test]
fn a_wrong_product_is_found() {
    for (from, to) in [
        ("let middle = a1 * b0 + (low >> 16u);", "let middle = a1 * b0;"),
        ("product.z -= bu;", ""),
        ("select(0u, au, b < 0)", "select(0u, au, a < 0)"),
        ("vec2<u32>(0u, a.y * b)", "vec2<u32>(0u, a.x * b)"),
    ] {
        assert!(first_wrong_product(&changed("intersect", &[[from, to]]), 4).is_some(), "{from}");
    }
}

/// Sums and products within the product of two words that may not fit a word.
fn partial_products_that_wrap(module: &Module) -> Vec<String> {
    let faults = RefCell::new(Vec::new());
    let domain = &Ranges::strict(&faults);
    let any = || unsigned((0, u32::MAX.into()));
    Interpreter::new(module, domain).call("multiply_unsigned", vec![any(), any()]);
    faults.into_inner()
}

#[test]
fn no_partial_product_wraps_around() {
    assert_eq!(partial_products_that_wrap(&kernel("intersect")), Vec::<String>::new());
    let wrong = ["let cross = a0 * b1 + (middle & 0xffffu);", "let cross = a0 * b1 + middle;"];
    assert_eq!(partial_products_that_wrap(&changed("intersect", &[wrong])).len(), 1);
}

#[test]
fn formulas_know_equal_functions() {
    let mut formulas = Formulas::default();
    let [a, b, c] = [0, 1, 2].map(|variable| formulas.variable(variable));
    let (ab, bc) = (formulas.xor(a, b), formulas.xor(b, c));
    assert_eq!(formulas.xor(ab, c), formulas.xor(a, bc));
    let (both, either) = (formulas.and(a, b), formulas.or(a, b));
    let neither = formulas.not(either);
    let same = formulas.or(both, neither);
    assert_eq!(formulas.not(ab), same);
    assert_ne!(both, either);
    let not_a = formulas.not(a);
    assert_eq!((formulas.or(a, not_a), formulas.and(a, not_a)), (TRUE, FALSE));
}
