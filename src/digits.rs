//! Numbers as text: the fewest decimal digits that read back as the same f64, as the standard library writes them.
//!
//! With r / s the number and half the gaps to its neighbours over s too, digits come one by one, exactly, until what is left
//! lies within a gap. Natively the standard library writes, faster; its tables and code would be a twenty-fifth of what a
//! browser loads.
//!
//! Source: G. L. Steele and J. L. White, How to print floating-point numbers accurately (1990), free-format algorithm.

/// A number that is written like an f64: `{}`, `{:?}` or `{:e}`.
pub(crate) struct Number(pub(crate) f64);

#[cfg(not(target_arch = "wasm32"))]
mod by_std {
    use std::fmt;

    use crate::digits::Number;

    impl fmt::Display for Number {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            fmt::Display::fmt(&self.0, f)
        }
    }

    impl fmt::Debug for Number {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            fmt::Debug::fmt(&self.0, f)
        }
    }

    impl fmt::LowerExp for Number {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            fmt::LowerExp::fmt(&self.0, f)
        }
    }
}

#[cfg(target_arch = "wasm32")]
mod by_us {
    use std::fmt;

    use crate::digits::{Form, Number, text};

    impl fmt::Display for Number {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str(&text(self.0, Form::Plain))
        }
    }

    impl fmt::Debug for Number {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str(&text(self.0, Form::Point))
        }
    }

    impl fmt::LowerExp for Number {
        fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str(&text(self.0, Form::Exponent))
        }
    }
}

/// How a number is written: 1200, 1200.0 (or with an exponent where it is very large or small), 1.2e3.
#[cfg(any(target_arch = "wasm32", test))]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    Plain,
    Point,
    Exponent,
}

#[cfg(any(target_arch = "wasm32", test))]
fn text(value: f64, form: Form) -> String {
    let mut out = String::new();
    if value.is_nan() {
        return "NaN".into();
    }
    if value.is_sign_negative() {
        out.push('-');
    }
    let size = value.abs();
    if size == f64::INFINITY {
        return out + "inf";
    }
    let (digits, point) = if size == 0.0 { ("0".into(), 1) } else { digits(size) };
    if form == Form::Exponent || form == Form::Point && size != 0.0 && !(1e-4..1e16).contains(&size) {
        let (first, rest) = digits.split_at(1);
        let dot = if rest.is_empty() { "" } else { "." };
        return format!("{out}{first}{dot}{rest}e{}", point - 1);
    }
    let zeros = |n: i32| "0".repeat(n.max(0) as usize);
    if point <= 0 {
        return out + "0." + &zeros(-point) + &digits;
    }
    let (whole, part) = digits.split_at(digits.len().min(point as usize));
    out = out + whole + &zeros(point - digits.len() as i32);
    match (part, form) {
        ("", Form::Point) => out + ".0",
        ("", _) => out,
        _ => out + "." + part,
    }
}

/// Digits of a positive number, and how many of them stand before the point.
#[cfg(any(target_arch = "wasm32", test))]
fn digits(value: f64) -> (String, i32) {
    let (exponent, fraction) = ((value.to_bits() >> 52) as u32, value.to_bits() & ((1 << 52) - 1));
    let mantissa = if exponent == 0 { fraction } else { fraction | 1 << 52 };
    let power = exponent.max(1) as i32 - 1075;
    // the gap below a power of two is half the gap above it
    let is_edge = u32::from(fraction == 0 && exponent > 1);
    let (shift, unshift) = (power.max(0) as u32, (-power).max(0) as u32);
    let (mut rest, mut scale) = (Big::new(mantissa, shift + 1 + is_edge), Big::new(1, unshift + 1 + is_edge));
    let (mut below, mut above) = (Big::new(1, shift), Big::new(1, shift + is_edge));
    // the edge of a gap reads back as the number if that is even
    let is_even = mantissa.is_multiple_of(2);
    let reaches = |sum: Big, limit: &Big| sum > *limit || is_even && sum == *limit;
    let mut point = 0;
    while reaches(rest.plus(&above), &scale) {
        scale.times_ten();
        point += 1;
    }
    loop {
        let mut next = rest.plus(&above);
        next.times_ten();
        if reaches(next, &scale) {
            break;
        }
        [&mut rest, &mut below, &mut above].into_iter().for_each(Big::times_ten);
        point -= 1;
    }
    let mut digits = Vec::new();
    loop {
        [&mut rest, &mut below, &mut above].into_iter().for_each(Big::times_ten);
        let mut digit = b'0';
        while rest >= scale {
            rest.subtract(&scale);
            digit += 1;
        }
        let (is_low, is_high) = (reaches(below, &rest), reaches(rest.plus(&above), &scale));
        let is_up = is_high && (!is_low || rest.plus(&rest) >= scale);
        digits.push(digit + u8::from(is_up));
        if is_low || is_high {
            break;
        }
    }
    // nine and one more
    while digits.last() > Some(&b'9') {
        digits.pop();
        match digits.last_mut() {
            Some(last) => *last += 1,
            None => {
                digits.push(b'1');
                point += 1;
            }
        }
    }
    (digits.into_iter().map(char::from).collect(), point)
}

/// A whole number below 2^1280, its highest word first so that it sorts; the largest that occurs has 1140 bits.
#[cfg(any(target_arch = "wasm32", test))]
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Big([u32; 40]);

#[cfg(any(target_arch = "wasm32", test))]
impl Big {
    /// `value * 2^shift`
    fn new(value: u64, shift: u32) -> Big {
        let mut words = [0; 40];
        let (place, value) = (39 - (shift / 32) as usize, u128::from(value) << (shift % 32));
        for word in 0..3 {
            // the lowest word of a large shift has no room above it for more
            words[place - word] = (value >> (32 * word)) as u32;
        }
        Big(words)
    }

    fn times_ten(&mut self) {
        let mut carry = 0;
        for word in self.0.iter_mut().rev() {
            let product = u64::from(*word) * 10 + carry;
            (*word, carry) = (product as u32, product >> 32);
        }
    }

    fn plus(&self, other: &Big) -> Big {
        let (mut sum, mut carry) = (*self, 0);
        for (word, other) in sum.0.iter_mut().zip(other.0).rev() {
            let total = u64::from(*word) + u64::from(other) + carry;
            (*word, carry) = (total as u32, total >> 32);
        }
        sum
    }

    /// Subtracts a number that is not larger.
    fn subtract(&mut self, other: &Big) {
        let mut borrow = false;
        for (word, other) in self.0.iter_mut().zip(other.0).rev() {
            let (less, once) = word.overflowing_sub(other);
            let (less, twice) = less.overflowing_sub(borrow.into());
            (*word, borrow) = (less, once || twice);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[track_caller]
    fn expect_as_std(value: f64) {
        let forms = [Form::Plain, Form::Point, Form::Exponent].map(|form| text(value, form));
        assert_eq!(forms, [format!("{value}"), format!("{value:?}"), format!("{value:e}")]);
        let number = Number(value);
        assert_eq!(forms, [format!("{number}"), format!("{number:?}"), format!("{number:e}")]);
    }

    #[test]
    fn edges_are_written_as_std_writes_them() {
        for value in [0.0, 1.0, 9.5, 0.1, 1e-4, 9.999e-5, 1e16, 123456789012345680.0, 1e15, 5e-324, f64::MAX, 0.3, 1e23]
        {
            expect_as_std(value);
            expect_as_std(-value);
        }
        for value in
            [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MIN_POSITIVE, 9007199254740993.0, 2f64.powi(-1022)]
        {
            expect_as_std(value);
        }
        for power in -1074..1024 {
            let value = 2f64.powi(power);
            expect_as_std(value);
            expect_as_std(value.next_up());
            expect_as_std(value.next_down());
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(3000) })]

        #[test]
        fn any_number_is_written_as_std_writes_it(bits: u64, decimals in -1_000_000i64..1_000_000, power in 0i32..12) {
            expect_as_std(f64::from_bits(bits));
            expect_as_std(decimals as f64 / 10f64.powi(power));
        }
    }
}
