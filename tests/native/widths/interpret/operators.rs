//! Operators, conversions and parts of values.

use super::*;

impl<'a, D: Domain> Interpreter<'a, D> {
    pub(super) fn choose(&self, of: &D::Bool, yes: &Value<D>, no: &Value<D>) -> Value<D> {
        match (yes, no) {
            (Value::Word { is_signed, word: yes }, Value::Word { word: no, .. }) => {
                Value::Word { is_signed: *is_signed, word: self.domain.choose(of, yes, no) }
            }
            (Value::Wide(yes), Value::Wide(no)) => Value::Wide(self.domain.choose(of, yes, no)),
            (Value::Bool(yes), Value::Bool(no)) => Value::Bool(self.domain.choose_bool(of, yes, no)),
            (Value::Float(yes), Value::Float(no)) => Value::Float(self.domain.choose_float(of, yes, no)),
            (Value::Many(yes), Value::Many(no)) => {
                assert_eq!(yes.len(), no.len());
                Value::Many(yes.iter().zip(no).map(|(yes, no)| self.choose(of, yes, no)).collect())
            }
            // variables of a path that ends before their first value
            (Value::Pointer(..), _) | (Value::Many(_), Value::Wide(_)) | (Value::Wide(_), Value::Many(_)) => no.clone(),
            _ => panic!("values of different kinds"),
        }
    }

    pub(super) fn element(&self, value: Value<D>, at: usize) -> Value<D> {
        match value {
            Value::Many(mut parts) => parts.swap_remove(at),
            Value::Every(element) => *element,
            Value::Pointer(place, mut path) => {
                path.push(at);
                Value::Pointer(place, path)
            }
            // a limb of a number of which only the range is known
            Value::Wide(_) => self.domain.call("limb", &[]).expect("wide numbers have limbs"),
            _ => panic!("no part {at}"),
        }
    }

    pub(super) fn literal(&self, literal: &Literal) -> Value<D> {
        match *literal {
            Literal::U32(value) => unsigned(self.domain.literal(value.into())),
            Literal::I32(value) => signed(self.domain.literal(value.into())),
            Literal::Bool(value) => Value::Bool(self.domain.bool(value)),
            Literal::F32(value) => Value::Float(self.domain.float(value.into())),
            other => panic!("{other:?} is not understood"),
        }
    }

    pub(super) fn constant(&self, handle: Handle<Expression>) -> Value<D> {
        self.pure(&self.module.global_expressions[handle], &|handle| self.constant(handle))
    }

    pub(super) fn zero(&self, ty: Handle<Type>) -> Value<D> {
        let of_kind = |kind: ScalarKind| match kind {
            ScalarKind::Sint => signed(self.domain.literal(0)),
            ScalarKind::Uint => unsigned(self.domain.literal(0)),
            ScalarKind::Float => Value::Float(self.domain.float(0.0)),
            ScalarKind::Bool => Value::Bool(self.domain.bool(false)),
            other => panic!("{other:?} is not understood"),
        };
        match &self.module.types[ty].inner {
            TypeInner::Scalar(scalar) => of_kind(scalar.kind),
            TypeInner::Vector { size, scalar } => Value::Many(vec![of_kind(scalar.kind); *size as usize]),
            TypeInner::Struct { members, .. } => Value::Many(members.iter().map(|part| self.zero(part.ty)).collect()),
            other => panic!("{other:?} is not understood"),
        }
    }

    pub(super) fn unary(&self, op: UnaryOperator, value: &Value<D>) -> Value<D> {
        each(&[value], &|of| match (op, of[0]) {
            (UnaryOperator::LogicalNot, Value::Bool(value)) => {
                Value::Bool(self.domain.bool_op(Op::NotEqual, value, &self.domain.bool(true)))
            }
            (UnaryOperator::Negate, Value::Float(value)) => {
                Value::Float(self.domain.float_op(Op::Subtract, &self.domain.float(0.0), value))
            }
            (UnaryOperator::Negate, Value::Word { is_signed, word }) => {
                let word = self.domain.word_op(Op::Subtract, *is_signed, &self.domain.literal(0), word);
                Value::Word { is_signed: *is_signed, word }
            }
            (UnaryOperator::BitwiseNot, Value::Word { is_signed, word }) => {
                let ones = self.domain.with_sign(&self.domain.literal(-1), *is_signed);
                Value::Word {
                    is_signed: *is_signed,
                    word: self.domain.word_op(Op::ExclusiveOr, *is_signed, &ones, word),
                }
            }
            _ => panic!("{op:?} is not understood"),
        })
    }

    pub(super) fn binary(&self, op: Op, left: &Value<D>, right: &Value<D>) -> Value<D> {
        let is_comparison =
            matches!(op, Op::Equal | Op::NotEqual | Op::Less | Op::LessEqual | Op::Greater | Op::GreaterEqual);
        each_number(left, right, &|left, right| match (left, right) {
            (Value::Word { is_signed, word: a }, Value::Word { word: b, .. }) if is_comparison => {
                Value::Bool(self.domain.compare(op, *is_signed, a, b))
            }
            (Value::Word { is_signed, word: a }, Value::Word { word: b, .. }) => {
                Value::Word { is_signed: *is_signed, word: self.domain.word_op(op, *is_signed, a, b) }
            }
            (Value::Float(a), Value::Float(b)) if is_comparison => Value::Bool(self.domain.compare_floats(op, a, b)),
            (Value::Bool(a), Value::Bool(b)) => Value::Bool(self.domain.bool_op(op, a, b)),
            (Value::Float(a), Value::Float(b)) => Value::Float(self.domain.float_op(op, a, b)),
            _ => panic!("{op:?} is not understood"),
        })
    }

    pub(super) fn math(&self, fun: MathFunction, of: &[&Value<D>]) -> Value<D> {
        if let Value::Float(_) = of[0] {
            let arguments: Vec<D::Float> = of.iter().map(|value| value.real().clone()).collect();
            return Value::Float(self.domain.float_math(fun, &arguments));
        }
        let Value::Word { is_signed, .. } = *of[0] else { panic!("{fun:?} is not understood") };
        let word = |index: usize| of[index].word().clone();
        let ended = |op: Op, a: D::Word, b: D::Word| self.domain.ended(op, is_signed, &a, &b);
        let word = match fun {
            MathFunction::Min => ended(Op::Less, word(0), word(1)),
            MathFunction::Max => ended(Op::Greater, word(0), word(1)),
            MathFunction::Clamp => ended(Op::Less, ended(Op::Greater, word(0), word(1)), word(2)),
            MathFunction::Abs => {
                let negative = self.domain.word_op(Op::Subtract, true, &self.domain.literal(0), &word(0));
                ended(Op::Greater, word(0), negative)
            }
            MathFunction::CountOneBits => {
                let bits = (0..32).map(|bit| {
                    let shifted = self.domain.word_op(Op::ShiftRight, false, &word(0), &self.domain.literal(bit));
                    self.domain.word_op(Op::And, false, &shifted, &self.domain.literal(1))
                });
                bits.reduce(|sum, bit| self.domain.word_op(Op::Add, false, &sum, &bit)).expect("bits")
            }
            other => panic!("{other:?} is not understood"),
        };
        Value::Word { is_signed, word }
    }

    pub(super) fn converted(&self, value: &Value<D>, kind: ScalarKind, is_bitcast: bool) -> Value<D> {
        let to_signed = kind == ScalarKind::Sint;
        match (value, kind) {
            (Value::Word { is_signed, word }, ScalarKind::Sint | ScalarKind::Uint) => {
                let word = if *is_signed == to_signed { word.clone() } else { self.domain.with_sign(word, to_signed) };
                Value::Word { is_signed: to_signed, word }
            }
            (Value::Bool(value), ScalarKind::Sint | ScalarKind::Uint) => {
                Value::Word { is_signed: to_signed, word: self.domain.word_of_bool(value) }
            }
            (Value::Bool(_), ScalarKind::Bool) => value.clone(),
            (Value::Word { is_signed, word }, ScalarKind::Float) if !is_bitcast => {
                Value::Float(self.domain.float_of_word(word, *is_signed))
            }
            (Value::Float(value), ScalarKind::Sint | ScalarKind::Uint) if !is_bitcast => {
                Value::Word { is_signed: to_signed, word: self.domain.word_of_float(value, to_signed) }
            }
            _ => panic!("a conversion to {kind:?} is not understood"),
        }
    }
}

type Operator<'f, D> = &'f dyn Fn(&Value<D>, &Value<D>) -> Value<D>;

/// Applies an operator to two numbers, two vectors, or each part of one and a number.
fn each_number<D: Domain>(left: &Value<D>, right: &Value<D>, apply: Operator<D>) -> Value<D> {
    match (left, right) {
        (Value::Many(left), Value::Many(right)) => {
            assert_eq!(left.len(), right.len());
            Value::Many(left.iter().zip(right).map(|(left, right)| apply(left, right)).collect())
        }
        (Value::Many(left), right) => Value::Many(left.iter().map(|left| apply(left, right)).collect()),
        (left, Value::Many(right)) => Value::Many(right.iter().map(|right| apply(left, right)).collect()),
        _ => apply(left, right),
    }
}
