//! Runs functions of a shader, as naga reads its text, over the numbers of any [`Domain`]: ranges, bits that are formulas, small words.
//!
//! Where a condition is not known both ways are run to the end, and the domain joins what they give. Only what the kernels use is
//! understood; anything else ends the test.

use std::collections::BTreeMap;

use naga::{BinaryOperator as Op, Expression, Function, Handle, Literal, MathFunction, Module, ScalarKind, Statement};
use naga::{SwizzleComponent, Type, TypeInner, UnaryOperator};

/// What numbers are.
pub(super) trait Domain: Clone {
    type Word: Clone;
    type Bool: Clone;
    type Float: Clone;

    fn literal(&self, value: i64) -> Self::Word;
    fn float(&self, value: f64) -> Self::Float;
    fn bool(&self, value: bool) -> Self::Bool;
    fn known(&self, value: &Self::Bool) -> Option<bool>;
    fn known_word(&self, word: &Self::Word) -> Option<u64>;
    fn word_op(&self, op: Op, is_signed: bool, a: &Self::Word, b: &Self::Word) -> Self::Word;
    fn compare(&self, op: Op, is_signed: bool, a: &Self::Word, b: &Self::Word) -> Self::Bool;
    /// The lesser, or the greater, of two words: a, if it is in the order of the comparison.
    fn ended(&self, op: Op, is_signed: bool, a: &Self::Word, b: &Self::Word) -> Self::Word {
        self.choose(&self.compare(op, is_signed, a, b), a, b)
    }
    fn bool_op(&self, op: Op, a: &Self::Bool, b: &Self::Bool) -> Self::Bool;
    fn float_op(&self, op: Op, a: &Self::Float, b: &Self::Float) -> Self::Float;
    fn compare_floats(&self, op: Op, _a: &Self::Float, _b: &Self::Float) -> Self::Bool {
        panic!("{op:?} of floats is not understood")
    }
    fn float_math(&self, fun: MathFunction, arguments: &[Self::Float]) -> Self::Float;
    fn choose(&self, of: &Self::Bool, yes: &Self::Word, no: &Self::Word) -> Self::Word;
    fn choose_bool(&self, of: &Self::Bool, yes: &Self::Bool, no: &Self::Bool) -> Self::Bool;
    fn choose_float(&self, of: &Self::Bool, yes: &Self::Float, no: &Self::Float) -> Self::Float;
    /// The same bits as a number of the other kind.
    fn with_sign(&self, word: &Self::Word, is_signed: bool) -> Self::Word;
    fn word_of_bool(&self, value: &Self::Bool) -> Self::Word;
    fn float_of_word(&self, word: &Self::Word, is_signed: bool) -> Self::Float;
    fn word_of_float(&self, value: &Self::Float, is_signed: bool) -> Self::Word;
    /// Stands in for a function of the shader, whose contract is proved elsewhere.
    fn call(&self, _name: &str, _arguments: &[Value<Self>]) -> Option<Value<Self>> {
        None
    }
}

#[derive(Clone)]
pub(super) enum Value<D: Domain> {
    Word {
        is_signed: bool,
        word: D::Word,
    },
    Bool(D::Bool),
    Float(D::Float),
    /// A vector, a struct or an array.
    Many(Vec<Value<D>>),
    /// An array whose elements are all like this one.
    Every(Box<Value<D>>),
    /// A number of 64 or 96 bits where functions of `wide.wgsl` are contracts.
    Wide(D::Word),
    Pointer(usize, Vec<usize>),
}

impl<D: Domain> Value<D> {
    pub(super) fn word(&self) -> &D::Word {
        match self {
            Value::Word { word, .. } | Value::Wide(word) => word,
            _ => panic!("no word"),
        }
    }

    pub(super) fn truth(&self) -> &D::Bool {
        let Value::Bool(value) = self else { panic!("no bool") };
        value
    }

    pub(super) fn parts(&self) -> &[Value<D>] {
        let Value::Many(parts) = self else { panic!("no vector or struct") };
        parts
    }

    fn real(&self) -> &D::Float {
        let Value::Float(value) = self else { panic!("no float") };
        value
    }
}

pub(super) fn unsigned<D: Domain>(word: D::Word) -> Value<D> {
    Value::Word { is_signed: false, word }
}

pub(super) fn signed<D: Domain>(word: D::Word) -> Value<D> {
    Value::Word { is_signed: true, word }
}

pub(super) struct Interpreter<'a, D: Domain> {
    pub(super) module: &'a Module,
    pub(super) domain: &'a D,
    /// Values of buffers and uniforms, or pointers to them.
    pub(super) globals: BTreeMap<&'static str, Value<D>>,
}

enum Flow<D: Domain> {
    Next,
    Break,
    Continue,
    Return(Option<Value<D>>),
}

#[derive(Clone)]
struct Frame<'a, D: Domain> {
    function: &'a Function,
    arguments: Vec<Value<D>>,
    /// Where on the heap its variables are.
    locals: BTreeMap<usize, usize>,
    values: Vec<Option<Value<D>>>,
}

type Heap<D> = Vec<Value<D>>;

impl<'a, D: Domain> Interpreter<'a, D> {
    pub(super) fn new(module: &'a Module, domain: &'a D) -> Self {
        Interpreter { module, domain, globals: BTreeMap::new() }
    }

    /// The result of a function of values.
    pub(super) fn call(&self, name: &str, arguments: Vec<Value<D>>) -> Value<D> {
        self.call_on(&mut Vec::new(), name, arguments).expect("a result")
    }

    /// The result of a function that may have pointers to a heap.
    pub(super) fn call_on(&self, heap: &mut Heap<D>, name: &str, arguments: Vec<Value<D>>) -> Option<Value<D>> {
        let is_it = |function: &&Function| function.name.as_deref() == Some(name);
        let function = self.module.functions.iter().map(|(_, function)| function).find(is_it);
        let function = function.unwrap_or_else(|| panic!("no function {name}"));
        assert_eq!(function.arguments.len(), arguments.len(), "{name}");
        let values = vec![None; function.expressions.len()];
        let mut frame = Frame { function, arguments, locals: BTreeMap::new(), values };
        for (handle, local) in function.local_variables.iter() {
            let value = match local.init {
                Some(init) => self.value(heap, &frame, init),
                None => self.zero(local.ty),
            };
            frame.locals.insert(handle.index(), heap.len());
            heap.push(value);
        }
        match self.run(heap, &mut frame, &function.body, &[]) {
            Flow::Return(value) => value,
            _ => None,
        }
    }

    /// Runs statements, then those of `tail`.
    fn run(&self, heap: &mut Heap<D>, frame: &mut Frame<'a, D>, body: &[Statement], tail: &[&[Statement]]) -> Flow<D> {
        for (at, statement) in body.iter().enumerate() {
            match statement {
                Statement::Emit(range) => {
                    for handle in range.clone() {
                        let value = self.compute(heap, frame, handle);
                        frame.values[handle.index()] = Some(value);
                    }
                }
                Statement::Store { pointer, value } => {
                    let (Value::Pointer(place, path), value) =
                        (self.value(heap, frame, *pointer), self.value(heap, frame, *value))
                    else {
                        panic!("no pointer")
                    };
                    *within(&mut heap[place], &path) = value;
                }
                Statement::Call { function, arguments, result } => {
                    let name = self.module.functions[*function].name.clone().expect("functions have names");
                    let arguments: Vec<_> = arguments.iter().map(|&handle| self.value(heap, frame, handle)).collect();
                    let contract = self.domain.call(&name, &arguments);
                    let value = contract.or_else(|| self.call_on(heap, &name, arguments));
                    if let Some(handle) = result {
                        frame.values[handle.index()] = value;
                    }
                }
                Statement::Return { value } => {
                    return Flow::Return(value.map(|handle| self.value(heap, frame, handle)));
                }
                Statement::Break => return Flow::Break,
                Statement::Continue => return Flow::Continue,
                Statement::Block(block) => return self.run(heap, frame, block, &followed(&body[at + 1..], tail)),
                Statement::If { condition, accept, reject } => {
                    let condition = self.value(heap, frame, *condition).truth().clone();
                    let tail = followed(&body[at + 1..], tail);
                    return match self.domain.known(&condition) {
                        Some(true) => self.run(heap, frame, accept, &tail),
                        Some(false) => self.run(heap, frame, reject, &tail),
                        None => self.run_both(heap, frame, &condition, [accept, reject], &tail),
                    };
                }
                Statement::Loop { body, continuing, break_if: None } => loop {
                    match self.run(heap, frame, body, &[]) {
                        Flow::Break => break,
                        Flow::Return(value) => return Flow::Return(value),
                        Flow::Next | Flow::Continue => drop(self.run(heap, frame, continuing, &[])),
                    }
                },
                other => panic!("{other:?} is not understood"),
            }
        }
        match tail.split_first() {
            Some((next, tail)) => self.run(heap, frame, next, tail),
            None => Flow::Next,
        }
    }

    fn run_both(
        &self,
        heap: &mut Heap<D>,
        frame: &mut Frame<'a, D>,
        condition: &D::Bool,
        [accept, reject]: [&[Statement]; 2],
        tail: &[&[Statement]],
    ) -> Flow<D> {
        let (mut other_heap, mut other_frame) = (heap.clone(), frame.clone());
        let yes = self.run(heap, frame, accept, tail);
        let no = self.run(&mut other_heap, &mut other_frame, reject, tail);
        // what the functions that either way called have left is not needed
        let n_kept = heap.len().min(other_heap.len());
        heap.truncate(n_kept);
        for (value, other) in heap.iter_mut().zip(&other_heap) {
            *value = self.choose(condition, value, other);
        }
        match (yes, no) {
            (Flow::Return(Some(yes)), Flow::Return(Some(no))) => Flow::Return(Some(self.choose(condition, &yes, &no))),
            (Flow::Next, Flow::Next) => Flow::Next,
            (Flow::Next | Flow::Return(None), Flow::Next | Flow::Return(None)) => Flow::Return(None),
            _ => panic!("a condition that ends a loop is not known"),
        }
    }

    fn value(&self, heap: &Heap<D>, frame: &Frame<'a, D>, handle: Handle<Expression>) -> Value<D> {
        frame.values[handle.index()].clone().unwrap_or_else(|| self.compute(heap, frame, handle))
    }

    fn compute(&self, heap: &Heap<D>, frame: &Frame<'a, D>, handle: Handle<Expression>) -> Value<D> {
        let value = |handle: Handle<Expression>| self.value(heap, frame, handle);
        match &frame.function.expressions[handle] {
            Expression::FunctionArgument(index) => frame.arguments[*index as usize].clone(),
            Expression::LocalVariable(local) => Value::Pointer(frame.locals[&local.index()], Vec::new()),
            Expression::GlobalVariable(global) => {
                let name = self.module.global_variables[*global].name.as_deref().expect("buffers have names");
                self.globals.get(name).unwrap_or_else(|| panic!("{name} has no value")).clone()
            }
            Expression::Load { pointer } => match value(*pointer) {
                Value::Pointer(place, path) => {
                    path.into_iter().fold(heap[place].clone(), |value, at| self.element(value, at))
                }
                of_buffer => of_buffer,
            },
            Expression::AccessIndex { base, index } => self.element(value(*base), *index as usize),
            Expression::Access { base, index } => match value(*base) {
                Value::Every(element) => *element,
                base => {
                    let index = self.domain.known_word(value(*index).word()).expect("a known index");
                    self.element(base, index as usize)
                }
            },
            other => self.pure(other, &value),
        }
    }

    /// What depends on nothing but other expressions.
    fn pure(&self, expression: &Expression, value: &dyn Fn(Handle<Expression>) -> Value<D>) -> Value<D> {
        match expression {
            Expression::Literal(literal) => self.literal(literal),
            Expression::Constant(constant) => self.constant(self.module.constants[*constant].init),
            Expression::ZeroValue(ty) => self.zero(*ty),
            Expression::Splat { size, value: of } => Value::Many(vec![value(*of); *size as usize]),
            Expression::Swizzle { size, vector, pattern } => {
                let vector = value(*vector);
                let component = |of: &SwizzleComponent| self.element(vector.clone(), *of as usize);
                Value::Many(pattern[..*size as usize].iter().map(component).collect())
            }
            Expression::Compose { ty, components } => {
                let parts = components.iter().map(|&part| value(part));
                match self.module.types[*ty].inner {
                    // vectors may be made of shorter ones
                    TypeInner::Vector { .. } => Value::Many(parts.flat_map(flat).collect()),
                    _ => Value::Many(parts.collect()),
                }
            }
            Expression::Unary { op, expr } => self.unary(*op, &value(*expr)),
            Expression::Binary { op, left, right } => self.binary(*op, &value(*left), &value(*right)),
            Expression::Select { condition, accept, reject } => {
                let choose = |of: &[&Value<D>]| self.choose(of[0].truth(), of[1], of[2]);
                each(&[&value(*condition), &value(*accept), &value(*reject)], &choose)
            }
            Expression::Math { fun, arg, arg1, arg2, .. } => {
                let arguments: Vec<_> = [Some(*arg), *arg1, *arg2].into_iter().flatten().map(value).collect();
                each(&arguments.iter().collect::<Vec<_>>(), &|of| self.math(*fun, of))
            }
            Expression::As { expr, kind, convert } => {
                each(&[&value(*expr)], &|of| self.converted(of[0], *kind, convert.is_none()))
            }
            other => panic!("{other:?} is not understood"),
        }
    }
}

mod operators;

/// The parts of a vector, or the one part of a number.
fn flat<D: Domain>(value: Value<D>) -> Vec<Value<D>> {
    match value {
        Value::Many(parts) => parts,
        one => vec![one],
    }
}

/// Applies a function to the elements of vectors, and to numbers along with them.
fn each<D: Domain>(values: &[&Value<D>], apply: &dyn Fn(&[&Value<D>]) -> Value<D>) -> Value<D> {
    let n = values.iter().filter_map(|value| if let Value::Many(parts) = value { Some(parts.len()) } else { None });
    let is_number = |value: &&&Value<D>| !matches!(value, Value::Many(_));
    match n.max() {
        // a bool chooses between whole vectors, or structs
        Some(n) if values.iter().filter(is_number).count() == 0 || !matches!(values[0], Value::Bool(_)) => {
            let of = |at: usize| {
                let part = |value: &&'_ Value<D>| match value {
                    Value::Many(parts) => parts[at].clone(),
                    number => (*number).clone(),
                };
                let parts: Vec<_> = values.iter().map(part).collect();
                each(&parts.iter().collect::<Vec<_>>(), apply)
            };
            Value::Many((0..n).map(of).collect())
        }
        _ => apply(values),
    }
}

fn within<'v, D: Domain>(value: &'v mut Value<D>, path: &[usize]) -> &'v mut Value<D> {
    path.iter().fold(value, |value, &at| match value {
        Value::Many(parts) => &mut parts[at],
        _ => panic!("no part {at}"),
    })
}

/// The rest of a block before what follows it.
fn followed<'s>(rest: &'s [Statement], tail: &[&'s [Statement]]) -> Vec<&'s [Statement]> {
    [&[rest], tail].concat()
}
