//! Several numbers side by side in a vector of the processor.
//!
//! Which vectors there are is found out when the program runs (AVX-512, AVX2, else
//! one number at a time): [`pulp`] dispatches, and everything below is inlined into
//! what it calls. No products are contracted with sums, so that results do not
//! depend on the processor.

use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use pulp::Simd;
use pulp::bytemuck::{cast_slice, cast_slice_mut, pod_read_unaligned};

use crate::number::{MOST_LANES, Number, Operand};

/// As many numbers as a vector of `S` holds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lanes<S: Simd> {
    simd: S,
    of: S::f64s,
}

/// A truth for each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Truths<S: Simd> {
    simd: S,
    of: S::m64s,
}

impl<S: Simd> Lanes<S> {
    /// The same value in each lane.
    #[inline(always)]
    pub(crate) fn splat(simd: S, value: f64) -> Self {
        Self {
            simd,
            of: simd.splat_f64s(value),
        }
    }

    #[inline(always)]
    fn slice(&self) -> &[f64] {
        cast_slice(std::slice::from_ref(&self.of))
    }

    #[inline(always)]
    fn slice_mut(&mut self) -> &mut [f64] {
        cast_slice_mut(std::slice::from_mut(&mut self.of))
    }
}

macro_rules! operation {
    ($name:ident, $method:ident, $simd:ident) => {
        impl<S: Simd> $name for Lanes<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self {
                    simd: self.simd,
                    of: self.simd.$simd(self.of, other.of),
                }
            }
        }
    };
}

operation!(Add, add, add_f64s);
operation!(Sub, sub, sub_f64s);
operation!(Mul, mul, mul_f64s);
operation!(Div, div, div_f64s);

macro_rules! operation_with_constant {
    ($name:ident, $method:ident, $simd:ident) => {
        impl<S: Simd> $name<f64> for Lanes<S> {
            type Output = Self;

            #[inline(always)]
            fn $method(self, other: f64) -> Self {
                Self {
                    simd: self.simd,
                    of: self.simd.$simd(self.of, self.simd.splat_f64s(other)),
                }
            }
        }

        impl<S: Simd> $name<Lanes<S>> for f64 {
            type Output = Lanes<S>;

            #[inline(always)]
            fn $method(self, other: Lanes<S>) -> Lanes<S> {
                Lanes {
                    simd: other.simd,
                    of: other.simd.$simd(other.simd.splat_f64s(self), other.of),
                }
            }
        }
    };
}

operation_with_constant!(Add, add, add_f64s);
operation_with_constant!(Sub, sub, sub_f64s);
operation_with_constant!(Mul, mul, mul_f64s);
operation_with_constant!(Div, div, div_f64s);

impl<S: Simd> Operand<Self> for Lanes<S> {
    #[inline(always)]
    fn lanes_of(self, _: Self) -> Self {
        self
    }
}

impl<S: Simd> Operand<Lanes<S>> for f64 {
    #[inline(always)]
    fn lanes_of(self, like: Lanes<S>) -> Lanes<S> {
        Lanes::splat(like.simd, self)
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;

    #[inline(always)]
    fn neg(self) -> Self {
        Self {
            simd: self.simd,
            of: self.simd.neg_f64s(self.of),
        }
    }
}

impl<S: Simd> BitAnd for Truths<S> {
    type Output = Self;

    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        Self {
            simd: self.simd,
            of: self.simd.and_m64s(self.of, other.of),
        }
    }
}

impl<S: Simd> BitOr for Truths<S> {
    type Output = Self;

    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        Self {
            simd: self.simd,
            of: self.simd.or_m64s(self.of, other.of),
        }
    }
}

impl<S: Simd> Not for Truths<S> {
    type Output = Self;

    #[inline(always)]
    fn not(self) -> Self {
        Self {
            simd: self.simd,
            of: self.simd.not_m64s(self.of),
        }
    }
}

impl<S: Simd> Number for Lanes<S> {
    type Truth = Truths<S>;

    const COUNT: usize = S::F64_LANES;

    #[inline(always)]
    fn splat(self, value: f64) -> Self {
        Self::splat(self.simd, value)
    }

    #[inline(always)]
    fn sqrt(self) -> Self {
        Self {
            simd: self.simd,
            of: self.simd.sqrt_f64s(self.of),
        }
    }

    #[inline(always)]
    fn abs(self) -> Self {
        Self {
            simd: self.simd,
            of: self.simd.abs_f64s(self.of),
        }
    }

    #[inline(always)]
    fn less_than(self, other: Self) -> Truths<S> {
        Truths {
            simd: self.simd,
            of: self.simd.less_than_f64s(self.of, other.of),
        }
    }

    #[inline(always)]
    fn blend(truth: Truths<S>, yes: Self, no: Self) -> Self {
        Self {
            simd: truth.simd,
            of: truth.simd.select_f64s(truth.of, yes.of, no.of),
        }
    }

    #[inline(always)]
    fn any(truth: Truths<S>) -> bool {
        truth.simd.first_true_m64s(truth.of) < S::F64_LANES
    }

    #[inline(always)]
    fn get(self, lane: usize) -> f64 {
        self.slice()[lane]
    }

    #[inline(always)]
    fn of_lanes(mut self, values: &[f64; MOST_LANES]) -> Self {
        self.of = pod_read_unaligned(cast_slice(&values[..S::F64_LANES]));
        self
    }

    #[inline(always)]
    fn with(mut self, lane: usize, value: f64) -> Self {
        self.slice_mut()[lane] = value;
        self
    }

    #[inline(always)]
    fn each(mut self, f: impl Fn(f64) -> f64) -> Self {
        for value in self.slice_mut() {
            *value = f(*value);
        }
        self
    }

    #[inline(always)]
    fn look_up<const K: usize>(self, f: impl Fn(f64) -> [f64; K]) -> [Self; K] {
        let mut found = [self; K];
        for (lane, &value) in self.slice().iter().enumerate() {
            let row = f(value);
            for k in 0..K {
                found[k].slice_mut()[lane] = row[k];
            }
        }
        found
    }

    #[inline(always)]
    fn gather<const K: usize>(self, rows: &[[f64; K]]) -> [Self; K] {
        let last = rows.len() - 1;
        let mut turned = [[0.0; MOST_LANES]; K];
        for (lane, &value) in self.slice().iter().enumerate() {
            let row = &rows[(value as usize).min(last)];
            for k in 0..K {
                turned[k][lane] = row[k];
            }
        }
        let mut found = [self; K];
        for k in 0..K {
            found[k].of = pod_read_unaligned(cast_slice(&turned[k][..S::F64_LANES]));
        }
        found
    }
}
