//! Decimal text to the nearest f32, as `str::parse` does it, without the tables for f64 of which the page would load 12 kB.
//!
//! Text -> digits and a power of ten, `d * 10^e`. Computed in f64 with at most three roundings, 2^-51 in all, it tells the
//! nearest f32 unless it lies that close to a midpoint of two. What does is divided in whole numbers of any size, bit by bit.
//!
//! Source: W. D. Clinger, How to read floating point numbers accurately (1990), for the two ways.
//! Cost: 10 to 20 ns a number the fast way, some microseconds the other.

/// Digits that decide; a midpoint of two f32 has at most 113, of what follows only whether it is zero matters.
const MAX_DIGITS: usize = 128;
/// Powers of ten that are exact in f64.
const POWERS: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20,
    1e21, 1e22,
];

/// Reads the nearest f32; None where the word is no number. Numbers beyond f32 come out infinite.
pub(super) fn parse(word: &[u8]) -> Option<f32> {
    let (is_negative, bare) = match word {
        [b'-', bare @ ..] => (true, bare),
        [b'+', bare @ ..] => (false, bare),
        _ => (false, word),
    };
    let magnitude = match bare {
        _ if bare.eq_ignore_ascii_case(b"inf") || bare.eq_ignore_ascii_case(b"infinity") => f32::INFINITY,
        _ if bare.eq_ignore_ascii_case(b"nan") => f32::NAN,
        _ => Decimal::read(bare)?.nearest(),
    };
    Some(if is_negative { -magnitude } else { magnitude })
}

/// `digits * 10^exponent`; the first digit is not zero.
struct Decimal<'a> {
    /// The text that holds the digits, among them perhaps a point.
    text: &'a [u8],
    /// The number they form, where `n_digits` is at most 19.
    value: u64,
    n_digits: usize,
    exponent: i64,
}

impl Decimal<'_> {
    fn read(text: &[u8]) -> Option<Decimal<'_>> {
        let end = text.iter().position(|byte| matches!(byte, b'e' | b'E')).unwrap_or(text.len());
        let mut exponent = if end < text.len() { power(&text[end + 1..])? } else { 0 };
        let text = &text[..end];
        let (mut n_digits, mut n_all, mut value, mut has_point) = (0, 0, 0u64, false);
        for &byte in text {
            match byte {
                b'0'..=b'9' => {
                    n_all += 1;
                    n_digits += usize::from(n_digits > 0 || byte != b'0');
                    value = value.wrapping_mul(10).wrapping_add(u64::from(byte - b'0'));
                    exponent -= i64::from(has_point);
                }
                b'.' if !has_point => has_point = true,
                _ => return None,
            }
        }
        (n_all > 0).then_some(Decimal { text, value, n_digits, exponent })
    }

    fn nearest(&self) -> f32 {
        let size = self.exponent.unsigned_abs() as usize;
        if self.n_digits <= 19 && size <= 44 {
            let (one, other) = (POWERS[size.min(22)], POWERS[size.saturating_sub(22)]);
            let value = self.value as f64;
            let near = if self.exponent < 0 { value / one / other } else { value * one * other };
            // the bits that f32 has not: near those of a midpoint it is open on which side the number lies
            let from_midpoint = (near.to_bits() & 0x1fff_ffff).abs_diff(0x1000_0000);
            if from_midpoint > 8 && near >= f64::from(f32::MIN_POSITIVE) {
                return near as f32;
            }
        }
        match self.n_digits as i64 + self.exponent {
            _ if self.n_digits == 0 => 0.0,
            // 10^39 and more; less than 10^-46
            40.. => f32::INFINITY,
            ..-45 => 0.0,
            _ => self.divided(),
        }
    }

    /// The nearest f32 to a quotient of whole numbers.
    fn divided(&self) -> f32 {
        let (mut above, mut below) = (Whole(vec![0]), Whole(vec![1]));
        let digits = self.text.iter().filter(|byte| byte.is_ascii_digit()).skip_while(|byte| **byte == b'0');
        for (index, byte) in digits.enumerate() {
            if index < MAX_DIGITS {
                above.multiply_and_add(10, u32::from(byte - b'0'));
            } else if *byte != b'0' {
                above.0[0] |= 1;
            }
        }
        let exponent = self.exponent + self.n_digits.saturating_sub(MAX_DIGITS) as i64;
        let scaled = if exponent < 0 { &mut below } else { &mut above };
        (0..exponent.abs()).for_each(|_| scaled.multiply_and_add(10, 0));
        // above / below = (1 to 2) * 2^shift
        let mut shift = 0i32;
        while above.is_less(&below) {
            above.multiply_and_add(2, 0);
            shift -= 1;
        }
        loop {
            below.multiply_and_add(2, 0);
            if above.is_less(&below) {
                break;
            }
            shift += 1;
        }
        // now above / below = (1/2 to 1) * 2^(shift + 1); 24 bits, fewer below 2^-126, and one more to round by
        let n_bits = (shift + 150).min(24);
        let mut bits = 0u32;
        for _ in 0..=n_bits {
            above.multiply_and_add(2, 0);
            bits <<= 1;
            if !above.is_less(&below) {
                above.subtract(&below);
                bits |= 1;
            }
        }
        let is_odd = bits & 2 != 0;
        let up = bits & 1 == 1 && (is_odd || !above.is_zero());
        // at most 24 bits times a power of two: exact in f64, also where f32 ends
        let power = f64::from_bits(((1024 + shift - n_bits) as u64) << 52);
        (f64::from((bits >> 1) + u32::from(up)) * power) as f32
    }
}

/// Reads the number behind an e; None where it is none. What f32 cannot reach is cut off.
fn power(text: &[u8]) -> Option<i64> {
    let (sign, digits) = match text {
        [b'-', digits @ ..] => (-1, digits),
        [b'+', digits @ ..] => (1, digits),
        _ => (1, text),
    };
    if digits.is_empty() || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let add = |power: i64, digit: &u8| (10 * power + i64::from(digit - b'0')).min(1 << 40);
    Some(sign * digits.iter().fold(0, add))
}

/// A whole number of any size, lowest 32 bits first; no zeros at the high end.
struct Whole(Vec<u32>);

impl Whole {
    fn multiply_and_add(&mut self, factor: u32, mut carry: u32) {
        for limb in &mut self.0 {
            let product = u64::from(*limb) * u64::from(factor) + u64::from(carry);
            (*limb, carry) = (product as u32, (product >> 32) as u32);
        }
        if carry > 0 {
            self.0.push(carry);
        }
    }

    fn is_less(&self, other: &Whole) -> bool {
        let (mine, others) = (&self.0, &other.0);
        mine.len() < others.len() || mine.len() == others.len() && mine.iter().rev().lt(others.iter().rev())
    }

    /// Subtracts a number that is not greater.
    fn subtract(&mut self, other: &Whole) {
        let mut borrow = false;
        for (index, limb) in self.0.iter_mut().enumerate() {
            let taken = u64::from(other.0.get(index).copied().unwrap_or(0)) + u64::from(borrow);
            borrow = u64::from(*limb) < taken;
            *limb = u64::from(*limb).wrapping_sub(taken) as u32;
        }
        while self.0.last() == Some(&0) {
            self.0.pop();
        }
    }

    fn is_zero(&self) -> bool {
        self.0.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn expect_as_std(word: &str) {
        let (ours, std) = (parse(word.as_bytes()), word.parse::<f32>().ok());
        assert_eq!(ours.map(f32::to_bits), std.map(f32::to_bits), "{word}: {ours:?}, {std:?}");
    }

    #[test]
    fn words_are_read_as_std_reads_them() {
        let plain =
            ["0", "-0", "+1", "1.", ".5", "-.5e1", "00012", "1e5", "1E+05", "1e-5", "0e999999999999999999999", "0.1"];
        let limits = [
            "3.4028235e38",
            "3.4028236e38",
            "3.4028235677973366e38",
            "3.5e38",
            "1e39",
            "1e999999999999999999999",
            "1e-999",
        ];
        let least = [
            "1.4e-45",
            "7.006492321624085e-46",
            "7.0064923216240854e-46",
            "7.1e-46",
            "1.17549435e-38",
            "1.1754942e-38",
        ];
        // midpoints, and one digit beside them
        let ties = ["16777217", "16777219", "16777217.0000000000000000000000001", "16777216.9999999999999999999999999"];
        let names = ["inf", "-INF", "Infinity", "nan", "+inf", "in", "infinit", "nan(ind)"];
        let wrong =
            ["", "-", "+", ".", "e5", ".e5", "1e", "1e+", "1.2.3", "1 ", " 1", "0x1", "1_0", "--1", "1e5.0", "1,5"];
        [&plain[..], &limits, &least, &ties, &names, &wrong].concat().into_iter().for_each(expect_as_std);
        let long = "123456789".repeat(40);
        for word in [long.clone(), format!("0.{long}"), format!("0.{}{long}", "0".repeat(40)), format!("{long}e-350")] {
            expect_as_std(&word);
        }
    }

    /// The exact decimal text of the midpoint between an f32 and the next.
    fn midpoint(bits: u32) -> String {
        let [low, high] = [bits, bits + 1].map(|bits| f64::from(f32::from_bits(bits)));
        format!("{:.200}", (low + high) / 2.0)
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(2000) })]

        #[test]
        fn numbers_are_read_as_std_reads_them(
            whole in "[0-9]{0,22}", part in "[0-9]{0,22}", exponent in -60i32..60, bits in 0u32..0x7f7f_ffff, digits in 0usize..20,
        ) {
            expect_as_std(&format!("{whole}.{part}e{exponent}"));
            expect_as_std(&format!("{whole}{part}"));
            expect_as_std(&format!("{:.digits$e}", f32::from_bits(bits)));
            expect_as_std(&midpoint(bits));
            expect_as_std(&midpoint(bits).replacen("00000000", "00000001", 1));
        }

        #[test]
        fn any_word_is_read_as_std_reads_it(word in "[-+.eEinfa0-9]{0,12}") {
            expect_as_std(&word);
        }
    }
}
