//! Numbers as the range that holds them. Where a number with a sign may leave its width this is noted: no such number may wrap around.
//! Words without a sign may, and are any word then.
//!
//! Functions of `wide.wgsl` are contracts here, proved by `wide.rs`: exact as long as the result fits the width.

use std::cell::RefCell;

use naga::{BinaryOperator as Op, MathFunction};

use super::interpret::{Domain, Value, signed};

/// Least and greatest number.
pub(super) type Range = (i128, i128);

const WORD: Range = (0, u32::MAX as i128);
const SIGNED: Range = (i32::MIN as i128, i32::MAX as i128);

#[derive(Clone)]
pub(super) struct Ranges<'a> {
    faults: &'a RefCell<Vec<String>>,
    /// Whether sums and products without a sign may not wrap around either.
    is_strict: bool,
}

impl<'a> Ranges<'a> {
    /// Numbers whose faults are noted.
    pub(super) fn new(faults: &'a RefCell<Vec<String>>) -> Self {
        Ranges { faults, is_strict: false }
    }

    /// Numbers of which none may wrap around.
    pub(super) fn strict(faults: &'a RefCell<Vec<String>>) -> Self {
        Ranges { faults, is_strict: true }
    }

    /// A range, if it fits a number with a sign of so many bits; noted if not.
    fn fitting(&self, what: &str, range: Range, bits: u32) -> Range {
        let least = -1i128 << (bits - 1);
        if range.0 >= least && range.1 < -least {
            return range;
        }
        self.note(what, range, bits);
        (least, -least - 1)
    }

    fn note(&self, what: &str, range: Range, bits: u32) {
        self.faults.borrow_mut().push(format!("{what}: {} to {} in {bits} bits", range.0, range.1));
    }
}

pub(super) fn is_within(inner: Range, outer: Range) -> bool {
    inner.0 >= outer.0 && inner.1 <= outer.1
}

fn hull(numbers: &[i128]) -> Range {
    (*numbers.iter().min().expect("numbers"), *numbers.iter().max().expect("numbers"))
}

fn product(a: Range, b: Range) -> Range {
    hull(&[a.0 * b.0, a.0 * b.1, a.1 * b.0, a.1 * b.1])
}

fn shifted_right(a: Range, by: Range) -> Range {
    hull(&[a.0 >> by.0, a.0 >> by.1, a.1 >> by.0, a.1 >> by.1])
}

/// The number that words, lowest first, stand for; only the lowest is not known to be 0.
fn wide(value: &Value<Ranges>) -> Range {
    match value {
        Value::Wide(range) => *range,
        Value::Many(words) => {
            assert!(words[1..].iter().all(|word| *word.word() == (0, 0)), "a wide number made of words");
            *words[0].word()
        }
        _ => panic!("no wide number"),
    }
}

impl<'a> Domain for Ranges<'a> {
    type Word = Range;
    /// Whether it may be false, and true.
    type Bool = [bool; 2];
    type Float = ();

    fn literal(&self, value: i64) -> Range {
        (value.into(), value.into())
    }

    fn bool(&self, value: bool) -> [bool; 2] {
        [!value, value]
    }

    fn known(&self, value: &[bool; 2]) -> Option<bool> {
        (value[0] != value[1]).then_some(value[1])
    }

    fn known_word(&self, word: &Range) -> Option<u64> {
        (word.0 == word.1).then_some(word.0 as u64)
    }

    fn word_op(&self, op: Op, is_signed: bool, a: &Range, b: &Range) -> Range {
        let (a, b) = (*a, *b);
        let exact = match op {
            Op::Add => (a.0 + b.0, a.1 + b.1),
            Op::Subtract => (a.0 - b.1, a.1 - b.0),
            Op::Multiply => product(a, b),
            Op::ShiftLeft if b.1 < 32 => product(a, (1 << b.0, 1 << b.1)),
            Op::ShiftRight if b.1 < 32 => shifted_right(a, b),
            Op::Divide if b.0 > 0 => hull(&[a.0 / b.0, a.0 / b.1, a.1 / b.0, a.1 / b.1]),
            Op::Modulo if a.0 >= 0 && b.0 > 0 => (0, a.1.min(b.1 - 1)),
            Op::And if a.0 >= 0 && b.0 >= 0 => (0, a.1.min(b.1)),
            Op::InclusiveOr | Op::ExclusiveOr if a.0 >= 0 && b.0 >= 0 => {
                (0, ((a.1 | b.1) as u128 + 1).next_power_of_two() as i128 - 1)
            }
            _ if is_signed => SIGNED,
            _ => WORD,
        };
        if is_signed {
            self.fitting(&format!("{op:?} of {a:?} and {b:?}"), exact, 32)
        } else {
            if self.is_strict && matches!(op, Op::Add | Op::Multiply) && !is_within(exact, WORD) {
                self.note(&format!("{op:?} of {a:?} and {b:?}"), exact, 32);
            }
            self.with_sign(&exact, false)
        }
    }

    fn compare(&self, op: Op, _is_signed: bool, a: &Range, b: &Range) -> [bool; 2] {
        let less = [a.1 >= b.0, a.0 < b.1];
        let greater = [b.1 >= a.0, b.0 < a.1];
        let equal = [a != b || a.0 != a.1, a.0 <= b.1 && b.0 <= a.1];
        let not = |[no, yes]: [bool; 2]| [yes, no];
        match op {
            Op::Less => less,
            Op::Greater => greater,
            Op::LessEqual => not(greater),
            Op::GreaterEqual => not(less),
            Op::Equal => equal,
            Op::NotEqual => not(equal),
            other => panic!("{other:?} is not understood"),
        }
    }

    fn ended(&self, op: Op, _is_signed: bool, a: &Range, b: &Range) -> Range {
        if op == Op::Less { (a.0.min(b.0), a.1.min(b.1)) } else { (a.0.max(b.0), a.1.max(b.1)) }
    }

    fn bool_op(&self, op: Op, a: &[bool; 2], b: &[bool; 2]) -> [bool; 2] {
        let apply = |a: bool, b: bool| match op {
            Op::LogicalAnd | Op::And => a && b,
            Op::LogicalOr | Op::InclusiveOr => a || b,
            Op::Equal => a == b,
            Op::NotEqual => a != b,
            other => panic!("{other:?} is not understood"),
        };
        let mut found = [false; 2];
        for (a, b) in [(false, false), (false, true), (true, false), (true, true)]
            .into_iter()
            .filter(|&(one, other)| a[usize::from(one)] && b[usize::from(other)])
        {
            found[usize::from(apply(a, b))] = true;
        }
        found
    }

    fn choose(&self, of: &[bool; 2], yes: &Range, no: &Range) -> Range {
        match self.known(of) {
            Some(true) => *yes,
            Some(false) => *no,
            None => hull(&[yes.0, yes.1, no.0, no.1]),
        }
    }

    fn choose_bool(&self, of: &[bool; 2], yes: &[bool; 2], no: &[bool; 2]) -> [bool; 2] {
        [0, 1].map(|value| of[1] && yes[value] || of[0] && no[value])
    }

    fn with_sign(&self, word: &Range, is_signed: bool) -> Range {
        let all = if is_signed { SIGNED } else { WORD };
        if is_within(*word, all) { *word } else { all }
    }

    fn word_of_bool(&self, value: &[bool; 2]) -> Range {
        (i128::from(!value[0]), i128::from(value[1]))
    }

    fn call(&self, name: &str, arguments: &[Value<Self>]) -> Option<Value<Self>> {
        let number = |index: usize| wide(&arguments[index]);
        let word = |index: usize| *arguments[index].word();
        let fitting = |range: Range, bits: u32| Some(Value::Wide(self.fitting(name, range, bits)));
        let sum = |sign: i128| {
            let (a, b) = (number(0), product(number(1), (sign, sign)));
            (a.0 + b.0, a.1 + b.1)
        };
        match name {
            "limb" => Some(super::interpret::unsigned(WORD)),
            "widen" => Some(Value::Wide(word(0))),
            "widen96" => Some(Value::Wide(number(0))),
            // of a number that is made of limbs nothing is known
            "is_negative" => Some(Value::Bool(match &arguments[0] {
                Value::Wide((low, high)) => [*high >= 0, *low < 0],
                _ => [true; 2],
            })),
            "multiply_signed" => fitting(product(word(0), word(1)), 64),
            "add64" => fitting(sum(1), 64),
            "sub64" => fitting(sum(-1), 64),
            "negate64" => fitting(product(number(0), (-1, -1)), 64),
            "shift_right64" | "shift_right96" => Some(Value::Wide(shifted_right(number(0), word(1)))),
            "add96" => fitting(sum(1), 96),
            "multiply96" => fitting(product(number(0), word(1)), 96),
            "clamp_to_2_30" => {
                let (low, high) = number(0);
                Some(signed((low.clamp(-1 << 30, 1 << 30), high.clamp(-1 << 30, 1 << 30))))
            }
            _ => None,
        }
    }

    // no float reaches a range that is proved
    fn float(&self, _value: f64) {}
    fn float_op(&self, _op: Op, _a: &(), _b: &()) {}
    fn float_math(&self, _fun: MathFunction, _arguments: &[()]) {}
    fn choose_float(&self, _of: &[bool; 2], _yes: &(), _no: &()) {}
    fn float_of_word(&self, _word: &Range, _is_signed: bool) {}

    fn word_of_float(&self, _value: &(), _is_signed: bool) -> Range {
        panic!("no float reaches a range that is proved")
    }
}
