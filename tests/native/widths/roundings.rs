//! Floats as how wrong they may be: by what part of themselves, under any rounding that WGSL allows. All are 0 or more, so that a sum is
//! no more wrong than its parts and the sum itself.

use naga::{BinaryOperator as Op, MathFunction};

use super::interpret::Domain;

/// The distance of neighbouring f32 is at most so large a part of them.
const ULP: f64 = 1.0 / (1u32 << 23) as f64;
/// In WGSL a quotient may be wrong by so many of them.
const DIVISION_ULP: f64 = 2.5;

#[derive(Clone, Default)]
pub(super) struct Roundings;

/// How wrong a float may be, and what it is where that is known.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wrong {
    pub(super) by: f64,
    value: Option<f64>,
}

impl Wrong {
    /// By so much more at the end.
    fn and(self, by: f64) -> Wrong {
        Wrong { by: (1.0 + self.by) * (1.0 + by) - 1.0, value: None }
    }
}

impl Domain for Roundings {
    /// Words are any.
    type Word = ();
    type Bool = ();
    type Float = Wrong;

    fn float(&self, value: f64) -> Wrong {
        Wrong { by: 0.0, value: Some(value) }
    }

    fn float_of_word(&self, _word: &(), is_signed: bool) -> Wrong {
        assert!(!is_signed, "a float that may be negative");
        Wrong { by: ULP, value: None }
    }

    fn float_op(&self, op: Op, a: &Wrong, b: &Wrong) -> Wrong {
        let is_power_of_two = |value: f64| value > 0.0 && libm::frexp(value).0 == 0.5;
        match op {
            Op::Add => Wrong { by: a.by.max(b.by), value: None }.and(ULP),
            // no bit is lost
            Op::Multiply if b.value.is_some_and(is_power_of_two) => *a,
            Op::Multiply => a.and(b.by).and(ULP),
            // a divisor that is too small by e makes the quotient larger by 1 / (1 - e)
            Op::Divide => a.and(b.by / (1.0 - b.by)).and(DIVISION_ULP * ULP),
            other => panic!("{other:?} is not understood"),
        }
    }

    fn choose_float(&self, _of: &(), yes: &Wrong, no: &Wrong) -> Wrong {
        Wrong { by: yes.by.max(no.by), value: None }
    }

    fn literal(&self, _value: i64) {}
    fn bool(&self, _value: bool) {}
    fn known_word(&self, _word: &()) -> Option<u64> {
        None
    }
    fn known(&self, _value: &()) -> Option<bool> {
        None
    }
    fn word_op(&self, _op: Op, _is_signed: bool, _a: &(), _b: &()) {}
    fn compare(&self, _op: Op, _is_signed: bool, _a: &(), _b: &()) {}
    fn bool_op(&self, _op: Op, _a: &(), _b: &()) {}
    fn choose(&self, _of: &(), _yes: &(), _no: &()) {}
    fn choose_bool(&self, _of: &(), _yes: &(), _no: &()) {}
    fn with_sign(&self, _word: &(), _is_signed: bool) {}
    fn word_of_bool(&self, _value: &()) {}
    fn word_of_float(&self, _value: &Wrong, _is_signed: bool) {}

    fn float_math(&self, fun: MathFunction, _of: &[Wrong]) -> Wrong {
        panic!("{fun:?} is not understood")
    }
}
