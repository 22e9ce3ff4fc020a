//! Numbers as text: the fewest decimal digits that read back as the same f64, in the forms of the standard library.
//!
//! zmij finds the digits, on every target, so that files are the same. Of two texts that are equally near it takes the even
//! one, the standard library the larger; that one's tables and code would be a twenty-fifth of what a browser loads.

use std::fmt;

/// A number that is written like an f64: `{}`, `{:?}` or `{:e}`.
pub(crate) struct Number(pub(crate) f64);

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

/// How a number is written: 1200, 1200.0 (or with an exponent where it is very large or small), 1.2e3.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    Plain,
    Point,
    Exponent,
}

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
fn digits(value: f64) -> (String, i32) {
    let mut buffer = zmij::Buffer::new();
    let text = buffer.format_finite(value);
    let (number, exponent) = text.split_once('e').unwrap_or((text, "0"));
    let (whole, part) = number.split_once('.').unwrap_or((number, ""));
    let all = [whole, part].concat();
    let digits = all.trim_start_matches('0');
    let point = (whole.len() + digits.len()) as i32 - all.len() as i32 + exponent.parse().unwrap_or(0);
    (digits.trim_end_matches('0').into(), point)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The form of the standard library, and the same number, which may end in another digit where two are equally near.
    #[track_caller]
    fn expect_as_std(value: f64) {
        let number = Number(value);
        let ours = [format!("{number}"), format!("{number:?}"), format!("{number:e}")];
        for (ours, std) in ours.iter().zip([format!("{value}"), format!("{value:?}"), format!("{value:e}")]) {
            assert_eq!(ours.len(), std.len(), "{ours}, {std}");
            let n_different = ours.bytes().zip(std.bytes()).filter(|(one, other)| one != other).count();
            assert!(n_different <= 1, "{ours}, {std}");
            if value.is_finite() {
                assert_eq!(ours.parse::<f64>().unwrap().to_bits(), value.to_bits(), "{ours}");
            } else {
                assert_eq!(*ours, std);
            }
        }
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
