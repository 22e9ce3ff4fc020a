//! Numbers as they are, in words of any even number of bits: small enough to try every input. The constants of the text that belong to
//! words of 32 bits are scaled along. A float is exact; what the device may make of it is the caller's choice.

use naga::{BinaryOperator as Op, MathFunction};

use super::interpret::{Domain, Value};

/// What a device may give for a quotient in f32.
pub(super) type Guess<'a> = &'a dyn Fn(f64, f64) -> f64;

#[derive(Clone)]
pub(super) struct Small<'a> {
    bits: u32,
    guess: Option<Guess<'a>>,
}

impl<'a> Small<'a> {
    pub(super) fn words(bits: u32) -> Self {
        assert!(bits <= 32 && bits.is_multiple_of(2));
        Small { bits, guess: None }
    }

    /// Words of 32 bits and a device.
    pub(super) fn guessing(guess: Guess<'a>) -> Self {
        Small { bits: 32, guess: Some(guess) }
    }

    /// Words of a number, lowest first, without a sign.
    pub(super) fn limbs(&self, value: u128, n_words: u32) -> Value<Self> {
        let limb = |word: u32| super::interpret::unsigned((value >> (word * self.bits)) as u64 & self.mask());
        Value::Many((0..n_words).map(limb).collect())
    }

    /// The number of words, without a sign.
    pub(super) fn number(&self, value: &Value<Self>) -> u128 {
        value.parts().iter().rev().fold(0, |sum, word| sum << self.bits | u128::from(*word.word()))
    }

    fn mask(&self) -> u64 {
        (1 << self.bits) - 1
    }

    fn with_value(&self, word: u64) -> i64 {
        let unused = 64 - self.bits;
        (word << unused) as i64 >> unused
    }
}

impl Domain for Small<'_> {
    type Word = u64;
    type Bool = bool;
    type Float = f64;

    fn literal(&self, value: i64) -> u64 {
        let scaled = match value {
            0xffff => (1 << (self.bits / 2)) - 1,
            31 => i64::from(self.bits) - 1,
            32 => i64::from(self.bits),
            16 => i64::from(self.bits) / 2,
            0x4000_0000 | -0x4000_0000 => value >> (32 - self.bits),
            other => other,
        };
        scaled as u64 & self.mask()
    }

    fn float(&self, value: f64) -> f64 {
        if value == 4294967296.0 { libm::exp2(self.bits.into()) } else { value }
    }

    fn bool(&self, value: bool) -> bool {
        value
    }

    fn known(&self, value: &bool) -> Option<bool> {
        Some(*value)
    }

    fn known_word(&self, word: &u64) -> Option<u64> {
        Some(*word)
    }

    fn word_op(&self, op: Op, is_signed: bool, &a: &u64, &b: &u64) -> u64 {
        let result = match op {
            Op::Add => a.wrapping_add(b),
            Op::Subtract => a.wrapping_sub(b),
            Op::Multiply => a.wrapping_mul(b),
            Op::Modulo if !is_signed && b != 0 => a % b,
            Op::And => a & b,
            Op::InclusiveOr => a | b,
            Op::ExclusiveOr => a ^ b,
            Op::ShiftLeft => a << b,
            Op::ShiftRight if is_signed => (self.with_value(a) >> b) as u64,
            Op::ShiftRight => a >> b,
            other => panic!("{other:?} is not understood"),
        };
        result & self.mask()
    }

    fn compare(&self, op: Op, is_signed: bool, &a: &u64, &b: &u64) -> bool {
        let [a, b] = [a, b].map(|word| if is_signed { self.with_value(word) } else { word as i64 });
        compared(op, a, b)
    }

    fn compare_floats(&self, op: Op, a: &f64, b: &f64) -> bool {
        compared(op, *a, *b)
    }

    fn bool_op(&self, op: Op, &a: &bool, &b: &bool) -> bool {
        match op {
            Op::LogicalAnd | Op::And => a && b,
            Op::LogicalOr | Op::InclusiveOr => a || b,
            Op::Equal => a == b,
            Op::NotEqual => a != b,
            other => panic!("{other:?} is not understood"),
        }
    }

    fn float_op(&self, op: Op, a: &f64, b: &f64) -> f64 {
        match op {
            Op::Add => a + b,
            Op::Subtract => a - b,
            Op::Multiply => a * b,
            Op::Divide => a / b,
            other => panic!("{other:?} is not understood"),
        }
    }

    fn float_math(&self, fun: MathFunction, of: &[f64]) -> f64 {
        match fun {
            MathFunction::Min => of[0].min(of[1]),
            MathFunction::Clamp => of[0].clamp(of[1], of[2]),
            MathFunction::Floor => of[0].floor(),
            other => panic!("{other:?} is not understood"),
        }
    }

    fn choose(&self, of: &bool, yes: &u64, no: &u64) -> u64 {
        if *of { *yes } else { *no }
    }

    fn choose_bool(&self, of: &bool, yes: &bool, no: &bool) -> bool {
        if *of { *yes } else { *no }
    }

    fn choose_float(&self, of: &bool, yes: &f64, no: &f64) -> f64 {
        if *of { *yes } else { *no }
    }

    fn with_sign(&self, word: &u64, _is_signed: bool) -> u64 {
        *word
    }

    fn word_of_bool(&self, value: &bool) -> u64 {
        u64::from(*value)
    }

    fn float_of_word(&self, word: &u64, is_signed: bool) -> f64 {
        if is_signed { self.with_value(*word) as f64 } else { *word as f64 }
    }

    fn word_of_float(&self, value: &f64, _is_signed: bool) -> u64 {
        *value as i64 as u64 & self.mask()
    }

    fn call(&self, name: &str, arguments: &[Value<Self>]) -> Option<Value<Self>> {
        match (name, arguments, self.guess) {
            ("guess", [Value::Float(value), Value::Float(divisor)], Some(guess)) => {
                Some(Value::Float(guess(*value, *divisor)))
            }
            _ => None,
        }
    }
}

fn compared<T: PartialOrd>(op: Op, a: T, b: T) -> bool {
    match op {
        Op::Less => a < b,
        Op::LessEqual => a <= b,
        Op::Greater => a > b,
        Op::GreaterEqual => a >= b,
        Op::Equal => a == b,
        Op::NotEqual => a != b,
        other => panic!("{other:?} is not understood"),
    }
}
