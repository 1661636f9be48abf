//! Operations, what they compute, and the nodes of an expression.

use std::sync::Arc;

/// Index of a node inside its arena; children come before parents.
pub(crate) type Id = u32;

/// Largest magnitude of a constant exponent that is evaluated by multiplications.
pub(crate) const MAX_WHOLE_EXPONENT: i32 = 64;

/// One node. Constants are kept as bits so that equality and hashing are exact.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Node {
    Const(u64),
    Var(Arc<str>),
    Unary(Unary, Id),
    Binary(Binary, Id, Id),
    If(Id, Id, Id),
}

impl Node {
    /// A constant; every NaN becomes the same NaN, so that equal text is equal.
    pub(crate) fn constant(value: f64) -> Self {
        let value = if value.is_nan() { f64::NAN } else { value };
        Self::Const(value.to_bits())
    }

    pub(crate) fn as_const(&self) -> Option<f64> {
        match self {
            Self::Const(bits) => Some(f64::from_bits(*bits)),
            _ => None,
        }
    }

    /// Children, left to right; unused places are `None`.
    pub(crate) fn children(&self) -> [Option<Id>; 3] {
        match *self {
            Self::Const(_) | Self::Var(_) => [None, None, None],
            Self::Unary(_, a) => [Some(a), None, None],
            Self::Binary(_, a, b) => [Some(a), Some(b), None],
            Self::If(c, a, b) => [Some(c), Some(a), Some(b)],
        }
    }

    /// The same node with every child renamed.
    pub(crate) fn map(&self, mut rename: impl FnMut(Id) -> Id) -> Self {
        match self {
            Self::Const(_) | Self::Var(_) => self.clone(),
            Self::Unary(op, a) => Self::Unary(*op, rename(*a)),
            Self::Binary(op, a, b) => Self::Binary(*op, rename(*a), rename(*b)),
            Self::If(c, a, b) => Self::If(rename(*c), rename(*a), rename(*b)),
        }
    }
}

/// The value of a constant exponent, if it is a small whole number.
pub(crate) fn whole_exponent(value: f64) -> Option<i32> {
    let limit = f64::from(MAX_WHOLE_EXPONENT);
    (value.trunc() == value && value.abs() <= limit).then_some(value as i32)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Unary {
    Neg,
    Not,
    Sqrt,
    Exp,
    Log,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Tanh,
    Abs,
    Sign,
    Floor,
    IsNan,
}

impl Unary {
    pub(crate) const FUNCTIONS: [Self; 14] = [
        Self::Sqrt,
        Self::Exp,
        Self::Log,
        Self::Sin,
        Self::Cos,
        Self::Tan,
        Self::Asin,
        Self::Acos,
        Self::Atan,
        Self::Tanh,
        Self::Abs,
        Self::Sign,
        Self::Floor,
        Self::IsNan,
    ];

    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Neg => "-",
            Self::Not => "not",
            Self::Sqrt => "sqrt",
            Self::Exp => "exp",
            Self::Log => "log",
            Self::Sin => "sin",
            Self::Cos => "cos",
            Self::Tan => "tan",
            Self::Asin => "asin",
            Self::Acos => "acos",
            Self::Atan => "atan",
            Self::Tanh => "tanh",
            Self::Abs => "abs",
            Self::Sign => "sign",
            Self::Floor => "floor",
            Self::IsNan => "isnan",
        }
    }

    #[inline(always)]
    pub(crate) fn apply(self, x: f64) -> f64 {
        match self {
            Self::Neg => -x,
            Self::Not => truth(!is_true(x)),
            Self::Sqrt => x.sqrt(),
            Self::Exp => x.exp(),
            Self::Log => x.ln(),
            Self::Sin => x.sin(),
            Self::Cos => x.cos(),
            Self::Tan => x.tan(),
            Self::Asin => x.asin(),
            Self::Acos => x.acos(),
            Self::Atan => x.atan(),
            Self::Tanh => x.tanh(),
            Self::Abs => x.abs(),
            Self::Sign => {
                if x > 0.0 {
                    1.0
                } else if x < 0.0 {
                    -1.0
                } else {
                    x
                }
            }
            Self::Floor => x.floor(),
            Self::IsNan => truth(x.is_nan()),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Binary {
    Add,
    Sub,
    Mul,
    Div,
    Pow,
    Lt,
    Le,
    Gt,
    Ge,
    Eq,
    Ne,
    And,
    Or,
    Min,
    Max,
    Hypot,
    Atan2,
}

impl Binary {
    pub(crate) const FUNCTIONS: [Self; 4] = [Self::Min, Self::Max, Self::Hypot, Self::Atan2];

    /// The operator as written, or the function's name.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Add => "+",
            Self::Sub => "-",
            Self::Mul => "*",
            Self::Div => "/",
            Self::Pow => "^",
            Self::Lt => "<",
            Self::Le => "<=",
            Self::Gt => ">",
            Self::Ge => ">=",
            Self::Eq => "==",
            Self::Ne => "!=",
            Self::And => "and",
            Self::Or => "or",
            Self::Min => "min",
            Self::Max => "max",
            Self::Hypot => "hypot",
            Self::Atan2 => "atan2",
        }
    }

    /// Equal results, bit for bit, with the operands exchanged.
    pub(crate) fn commutes(self) -> bool {
        matches!(
            self,
            Self::Add | Self::Mul | Self::Eq | Self::Ne | Self::And | Self::Or
        )
    }

    #[inline(always)]
    pub(crate) fn apply(self, a: f64, b: f64) -> f64 {
        match self {
            Self::Add => a + b,
            Self::Sub => a - b,
            Self::Mul => a * b,
            Self::Div => a / b,
            Self::Pow => a.powf(b),
            Self::Lt => truth(a < b),
            Self::Le => truth(a <= b),
            Self::Gt => truth(a > b),
            Self::Ge => truth(a >= b),
            Self::Eq => truth(a == b),
            Self::Ne => truth((a < b) | (a > b)),
            Self::And => truth(is_true(a) & is_true(b)),
            Self::Or => truth(is_true(a) | is_true(b)),
            Self::Min => {
                if (a < b) | a.is_nan() {
                    a
                } else {
                    b
                }
            }
            Self::Max => {
                if (a > b) | a.is_nan() {
                    a
                } else {
                    b
                }
            }
            Self::Hypot => a.hypot(b),
            Self::Atan2 => a.atan2(b),
        }
    }
}

/// x^n by multiplications, in the order that compiled programs use.
pub(crate) fn whole_power(x: f64, n: i32) -> f64 {
    match n {
        ..0 => 1.0 / whole_power(x, -n),
        0 => 1.0,
        1 => x,
        _ if n % 2 == 0 => {
            let half = whole_power(x, n / 2);
            half * half
        }
        _ => whole_power(x, n - 1) * x,
    }
}

/// a^b as a program computes it when b is a constant.
pub(crate) fn constant_power(a: f64, b: f64) -> f64 {
    whole_exponent(b).map_or_else(|| a.powf(b), |n| whole_power(a, n))
}

#[inline(always)]
pub(crate) fn is_true(x: f64) -> bool {
    (x < 0.0) | (x > 0.0)
}

#[inline(always)]
fn truth(condition: bool) -> f64 {
    if condition { 1.0 } else { 0.0 }
}
