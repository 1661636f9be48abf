//! Compiled expressions and their evaluation.

use crate::node::{Binary, Unary, is_true};

/// Rows that one instruction handles before the next takes its turn: small
/// enough for all slots to stay in cache, large enough to spread the overhead.
const CHUNK: usize = 256;

/// Where an instruction reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Operand {
    Input(u32),
    Const(f64),
    Slot(u32),
    /// An output that an earlier instruction has written.
    Output(u32),
}

/// Where an instruction writes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Target {
    Slot(u32),
    Output(u32),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Op {
    Copy(Operand),
    Unary(Unary, Operand),
    Binary(Binary, Operand, Operand),
    Select(Operand, Operand, Operand),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Instruction {
    pub(crate) op: Op,
    /// Never a slot that `op` reads.
    pub(crate) target: Target,
}

/// Several expressions compiled together against an ordered list of inputs.
///
/// Equal parts are computed once, within and across the expressions, and whole
/// powers are built from each other (`x^3` from `x^2`), so that each further
/// monomial of a polynomial library costs about one multiplication per row.
/// Results are those of the expressions as written: nothing is rearranged.
///
/// A program is immutable and can be shared between threads, each with its own
/// [`Scratch`].
#[derive(Clone, Debug)]
pub struct Program {
    pub(crate) inputs: Vec<String>,
    pub(crate) outputs: usize,
    pub(crate) slots: usize,
    pub(crate) code: Vec<Instruction>,
}

/// Working memory of an evaluation. It grows on first use and can then serve any
/// program without further allocation of the same size or less.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    row: Vec<f64>,
    blocks: Vec<Vec<f64>>,
}

impl Scratch {
    /// Empty working memory.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }
}

impl Program {
    /// Number of outputs: one for each expression.
    #[must_use]
    pub fn outputs(&self) -> usize {
        self.outputs
    }

    /// Names of the inputs, in order.
    #[must_use]
    pub fn inputs(&self) -> &[String] {
        &self.inputs
    }

    /// Number of operations per row, constants and inputs not counted.
    #[must_use]
    pub fn operations(&self) -> usize {
        let is_work = |i: &&Instruction| !matches!(i.op, Op::Copy(_));
        self.code.iter().filter(is_work).count()
    }

    /// Evaluates one row: `input[i]` is the value of `inputs()[i]`, `output[k]`
    /// becomes that of the k-th expression.
    ///
    /// # Panics
    /// If `input` does not have one value for each input or `output` one place for
    /// each output.
    pub fn eval_row(&self, input: &[f64], output: &mut [f64], scratch: &mut Scratch) {
        assert_eq!(input.len(), self.inputs.len(), "one value for each input");
        assert_eq!(output.len(), self.outputs, "one place for each output");
        if scratch.row.len() < self.slots {
            scratch.row.resize(self.slots, 0.0);
        }
        let slots = &mut scratch.row;
        for instruction in &self.code {
            let at = |operand| match operand {
                Operand::Input(i) => input[i as usize],
                Operand::Const(value) => value,
                Operand::Slot(s) => slots[s as usize],
                Operand::Output(k) => output[k as usize],
            };
            let value = match instruction.op {
                Op::Copy(a) => at(a),
                Op::Unary(op, a) => op.apply(at(a)),
                Op::Binary(op, a, b) => op.apply(at(a), at(b)),
                Op::Select(condition, a, b) => select(at(condition), at(a), at(b)),
            };
            match instruction.target {
                Target::Slot(s) => slots[s as usize] = value,
                Target::Output(k) => output[k as usize] = value,
            }
        }
    }

    /// Evaluates n rows given as columns: `inputs[i][r]` is row r of input i, and
    /// `output[k*n + r]` becomes row r of the k-th expression. Every row has the same
    /// value as from [`Program::eval_row`], bit for bit (the bits of a NaN excepted).
    ///
    /// n is the columns' common length; without inputs, `output.len() / outputs()`.
    ///
    /// # Panics
    /// If there is not one column for each input, if columns differ in length, or if
    /// `output` does not have n places for each output.
    pub fn eval_block(&self, inputs: &[&[f64]], output: &mut [f64], scratch: &mut Scratch) {
        assert_eq!(inputs.len(), self.inputs.len(), "one column for each input");
        let rows = match inputs.first() {
            Some(column) => column.len(),
            None => output.len() / self.outputs.max(1),
        };
        for (column, name) in inputs.iter().zip(&self.inputs) {
            assert_eq!(column.len(), rows, "rows of column `{name}`");
        }
        assert_eq!(
            output.len(),
            rows * self.outputs,
            "n places for each output"
        );
        if scratch.blocks.len() < self.slots {
            scratch.blocks.resize_with(self.slots, || vec![0.0; CHUNK]);
        }
        pulp::Arch::new().dispatch(Evaluation {
            program: self,
            inputs,
            rows,
            output,
            scratch,
        });
    }

    #[inline(always)]
    fn chunks(&self, inputs: &[&[f64]], rows: usize, output: &mut [f64], scratch: &mut Scratch) {
        for start in (0..rows).step_by(CHUNK) {
            let chunk = start..rows.min(start + CHUNK);
            for instruction in &self.code {
                let mut slot = Vec::new();
                let (before, place, after) = match instruction.target {
                    Target::Slot(s) => {
                        slot = std::mem::take(&mut scratch.blocks[s as usize]);
                        (&*output, &mut slot[..chunk.len()], &[][..])
                    }
                    Target::Output(k) => {
                        let base = k as usize * rows + chunk.start;
                        let (before, rest) = output.split_at_mut(base);
                        let (place, after) = rest.split_at_mut(chunk.len());
                        (&*before, place, &*after)
                    }
                };
                let view = View {
                    inputs,
                    slots: &scratch.blocks,
                    chunk: chunk.clone(),
                    rows,
                    before,
                    after,
                };
                run(instruction.op, &view, place);
                if let Target::Slot(s) = instruction.target {
                    scratch.blocks[s as usize] = slot;
                }
            }
        }
    }
}

/// An evaluation in whatever vector instructions the processor has: the same operations on the same values, and
/// so the same bits.
struct Evaluation<'a> {
    program: &'a Program,
    inputs: &'a [&'a [f64]],
    rows: usize,
    output: &'a mut [f64],
    scratch: &'a mut Scratch,
}

impl pulp::WithSimd for Evaluation<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let Self {
            program,
            inputs,
            rows,
            output,
            scratch,
        } = self;
        program.chunks(inputs, rows, output, scratch);
    }
}

#[inline(always)]
fn select(condition: f64, a: f64, b: f64) -> f64 {
    if is_true(condition) { a } else { b }
}

/// Data that the operands of one chunk refer to.
struct View<'a> {
    inputs: &'a [&'a [f64]],
    slots: &'a [Vec<f64>],
    chunk: std::ops::Range<usize>,
    /// Rows of an output.
    rows: usize,
    /// The outputs before and after the place that is written.
    before: &'a [f64],
    after: &'a [f64],
}

/// A chunk of values, or one value for all rows.
#[derive(Clone, Copy)]
enum Values<'a> {
    Each(&'a [f64]),
    All(f64),
}

impl Values<'_> {
    #[inline(always)]
    fn at(self, row: usize) -> f64 {
        match self {
            Self::Each(values) => values[row],
            Self::All(value) => value,
        }
    }
}

impl View<'_> {
    #[inline(always)]
    fn values(&self, operand: Operand) -> Values<'_> {
        match operand {
            Operand::Input(i) => Values::Each(&self.inputs[i as usize][self.chunk.clone()]),
            Operand::Const(value) => Values::All(value),
            Operand::Slot(s) => Values::Each(&self.slots[s as usize][..self.chunk.len()]),
            Operand::Output(k) => {
                let base = k as usize * self.rows + self.chunk.start;
                let len = self.chunk.len();
                Values::Each(match base.checked_sub(self.before.len() + len) {
                    Some(base) => &self.after[base..base + len],
                    None => &self.before[base..base + len],
                })
            }
        }
    }
}

#[inline(always)]
fn run(op: Op, view: &View<'_>, to: &mut [f64]) {
    // One loop for each operation, so that each can be vectorised.
    macro_rules! each_unary {
        ($op:expr, $a:expr, $($name:ident)*) => {
            match $op { $(Unary::$name => map1(to, $a, |x| Unary::$name.apply(x)),)* }
        };
    }
    macro_rules! each_binary {
        ($op:expr, $a:expr, $b:expr, $($name:ident)*) => {
            match $op { $(Binary::$name => map2(to, $a, $b, |x, y| Binary::$name.apply(x, y)),)* }
        };
    }
    match op {
        Op::Copy(a) => map1(to, view.values(a), |x| x),
        Op::Unary(op, a) => each_unary!(op, view.values(a),
            Neg Not Sqrt Exp Log Sin Cos Tan Asin Acos Atan Tanh Abs Sign Floor IsNan),
        Op::Binary(op, a, b) => each_binary!(op, view.values(a), view.values(b),
            Add Sub Mul Div Pow Lt Le Gt Ge Eq Ne And Or Min Max Hypot Atan2),
        Op::Select(condition, a, b) => {
            let [condition, a, b] = [condition, a, b].map(|operand| view.values(operand));
            for (row, to) in to.iter_mut().enumerate() {
                *to = select(condition.at(row), a.at(row), b.at(row));
            }
        }
    }
}

#[inline(always)]
fn map1(to: &mut [f64], a: Values<'_>, f: impl Fn(f64) -> f64) {
    match a {
        Values::Each(a) => {
            for (to, &a) in to.iter_mut().zip(a) {
                *to = f(a);
            }
        }
        Values::All(a) => to.fill(f(a)),
    }
}

#[inline(always)]
fn map2(to: &mut [f64], a: Values<'_>, b: Values<'_>, f: impl Fn(f64, f64) -> f64) {
    match (a, b) {
        (Values::Each(a), Values::Each(b)) => {
            for ((to, &a), &b) in to.iter_mut().zip(a).zip(b) {
                *to = f(a, b);
            }
        }
        (Values::Each(a), Values::All(b)) => {
            for (to, &a) in to.iter_mut().zip(a) {
                *to = f(a, b);
            }
        }
        (Values::All(a), Values::Each(b)) => {
            for (to, &b) in to.iter_mut().zip(b) {
                *to = f(a, b);
            }
        }
        (Values::All(a), Values::All(b)) => to.fill(f(a, b)),
    }
}
