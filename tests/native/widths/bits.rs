//! Words of 32 bits of which each bit is a formula of the bits of the input: what holds of them holds of every input.

use std::cell::RefCell;

use naga::{BinaryOperator as Op, MathFunction};

use super::formulas::{FALSE, Formula, Formulas, TRUE};
use super::interpret::Domain;

/// Bits, the lowest first.
pub(super) type Bits = Vec<Formula>;

#[derive(Clone)]
pub(super) struct Symbolic<'a>(&'a RefCell<Formulas>);

impl<'a> Symbolic<'a> {
    pub(super) fn new(formulas: &'a RefCell<Formulas>) -> Self {
        Symbolic(formulas)
    }

    fn formulas(&self) -> std::cell::RefMut<'a, Formulas> {
        self.0.borrow_mut()
    }

    /// An input of so many words, one of `n_inputs`: the bits of the same place of all are neighbours, so that sums stay small.
    pub(super) fn input(&self, number: u32, n_inputs: u32, n_words: u32) -> Bits {
        (0..32 * n_words).map(|bit| self.formulas().variable(bit * n_inputs + number)).collect()
    }

    /// A number of any width.
    pub(super) fn number(value: u128, n_bits: usize) -> Bits {
        (0..n_bits).map(|bit| (value >> bit & 1) as Formula).collect()
    }

    pub(super) fn known(bits: &[Formula]) -> Option<u64> {
        let is_known = bits.iter().all(|&bit| bit <= TRUE);
        is_known.then(|| bits.iter().rev().fold(0, |value, &bit| value << 1 | u64::from(bit)))
    }

    /// a + b + carry: as many bits as a and b have, and the carry.
    pub(super) fn sum(&self, a: &[Formula], b: &[Formula], mut carry: Formula) -> (Bits, Formula) {
        assert_eq!(a.len(), b.len());
        let mut formulas = self.formulas();
        let mut bits = Bits::new();
        for (&a, &b) in a.iter().zip(b) {
            let odd = formulas.xor(a, b);
            bits.push(formulas.xor(odd, carry));
            carry = formulas.choose(odd, carry, a);
        }
        (bits, carry)
    }

    pub(super) fn not(&self, a: &[Formula]) -> Bits {
        a.iter().map(|&bit| self.formulas().not(bit)).collect()
    }

    pub(super) fn difference(&self, a: &[Formula], b: &[Formula]) -> Bits {
        self.sum(a, &self.not(b), TRUE).0
    }

    /// a < b of numbers without a sign.
    pub(super) fn is_less(&self, a: &[Formula], b: &[Formula]) -> Formula {
        let carry = self.sum(a, &self.not(b), TRUE).1;
        self.formulas().not(carry)
    }

    pub(super) fn is_equal(&self, a: &[Formula], b: &[Formula]) -> Formula {
        let mut formulas = self.formulas();
        a.iter().zip(b).fold(TRUE, |all, (&a, &b)| {
            let differ = formulas.xor(a, b);
            let equal = formulas.not(differ);
            formulas.and(all, equal)
        })
    }

    pub(super) fn chosen(&self, of: Formula, yes: &[Formula], no: &[Formula]) -> Bits {
        yes.iter().zip(no).map(|(&yes, &no)| self.formulas().choose(of, yes, no)).collect()
    }

    pub(super) fn or(&self, a: Formula, b: Formula) -> Formula {
        self.formulas().or(a, b)
    }

    pub(super) fn and(&self, a: Formula, b: Formula) -> Formula {
        self.formulas().and(a, b)
    }

    /// a << n, with as many bits.
    pub(super) fn shifted_left(a: &[Formula], n: usize) -> Bits {
        (0..a.len()).map(|bit| if bit < n { FALSE } else { a[bit - n] }).collect()
    }

    /// a >> n, filled with a bit.
    pub(super) fn shifted_right(a: &[Formula], n: usize, fill: Formula) -> Bits {
        (0..a.len()).map(|bit| a.get(bit + n).copied().unwrap_or(fill)).collect()
    }

    /// The product by a number that is known.
    pub(super) fn product(&self, a: &[Formula], by: u64) -> Bits {
        let places = (0..64).filter(|place| by >> place & 1 == 1);
        places.fold(vec![FALSE; a.len()], |sum, place| self.sum(&sum, &Self::shifted_left(a, place), FALSE).0)
    }
}

impl Domain for Symbolic<'_> {
    type Word = Bits;
    type Bool = Formula;
    type Float = ();

    fn literal(&self, value: i64) -> Bits {
        Self::number(value as u128, 32)
    }

    fn bool(&self, value: bool) -> Formula {
        Formula::from(value)
    }

    fn known(&self, value: &Formula) -> Option<bool> {
        (*value <= TRUE).then_some(*value == TRUE)
    }

    fn known_word(&self, word: &Bits) -> Option<u64> {
        Self::known(word)
    }

    fn word_op(&self, op: Op, is_signed: bool, a: &Bits, b: &Bits) -> Bits {
        let shift = || Self::known(b).expect("a known shift") as usize;
        let bitwise = |of: fn(&mut Formulas, Formula, Formula) -> Formula| {
            a.iter().zip(b).map(|(&a, &b)| of(&mut self.formulas(), a, b)).collect()
        };
        match op {
            Op::Add => self.sum(a, b, FALSE).0,
            Op::Subtract => self.difference(a, b),
            Op::Multiply => match (Self::known(a), Self::known(b)) {
                (_, Some(by)) => self.product(a, by),
                (Some(by), _) => self.product(b, by),
                _ => panic!("a product of two inputs has no small formula"),
            },
            // by a power of two
            Op::Modulo => {
                let by = Self::known(b).filter(|by| by.is_power_of_two()).expect("a power of two");
                self.word_op(Op::And, false, a, &self.literal(by as i64 - 1))
            }
            Op::And => bitwise(Formulas::and),
            Op::InclusiveOr => bitwise(Formulas::or),
            Op::ExclusiveOr => bitwise(Formulas::xor),
            Op::ShiftLeft => Self::shifted_left(a, shift()),
            Op::ShiftRight => Self::shifted_right(a, shift(), if is_signed { a[31] } else { FALSE }),
            other => panic!("{other:?} is not understood"),
        }
    }

    fn compare(&self, op: Op, is_signed: bool, a: &Bits, b: &Bits) -> Formula {
        // with the sign turned over, numbers with a sign are in the order of those without
        let ordered = |word: &Bits| {
            let mut word = word.clone();
            if is_signed {
                word[31] = self.formulas().not(word[31]);
            }
            word
        };
        let (a, b) = (&ordered(a), &ordered(b));
        let not = |formula| self.formulas().not(formula);
        match op {
            Op::Equal => self.is_equal(a, b),
            Op::NotEqual => not(self.is_equal(a, b)),
            Op::Less => self.is_less(a, b),
            Op::GreaterEqual => not(self.is_less(a, b)),
            Op::Greater => self.is_less(b, a),
            Op::LessEqual => not(self.is_less(b, a)),
            other => panic!("{other:?} is not understood"),
        }
    }

    fn bool_op(&self, op: Op, a: &Formula, b: &Formula) -> Formula {
        let mut formulas = self.formulas();
        match op {
            Op::LogicalAnd | Op::And => formulas.and(*a, *b),
            Op::LogicalOr | Op::InclusiveOr => formulas.or(*a, *b),
            Op::NotEqual => formulas.xor(*a, *b),
            Op::Equal => {
                let differ = formulas.xor(*a, *b);
                formulas.not(differ)
            }
            other => panic!("{other:?} is not understood"),
        }
    }

    fn choose(&self, of: &Formula, yes: &Bits, no: &Bits) -> Bits {
        self.chosen(*of, yes, no)
    }

    fn choose_bool(&self, of: &Formula, yes: &Formula, no: &Formula) -> Formula {
        self.formulas().choose(*of, *yes, *no)
    }

    fn with_sign(&self, word: &Bits, _is_signed: bool) -> Bits {
        word.clone()
    }

    fn word_of_bool(&self, value: &Formula) -> Bits {
        let mut word = vec![FALSE; 32];
        word[0] = *value;
        word
    }

    // formulas know nothing of floats
    fn float(&self, _value: f64) {}
    fn float_op(&self, _op: Op, _a: &(), _b: &()) {}
    fn float_math(&self, _fun: MathFunction, _arguments: &[()]) {}
    fn choose_float(&self, _of: &Formula, _yes: &(), _no: &()) {}
    fn float_of_word(&self, _word: &Bits, _is_signed: bool) {}

    fn word_of_float(&self, _value: &(), _is_signed: bool) -> Bits {
        panic!("formulas know nothing of floats")
    }
}
