//! Memory that starts where a vector register's worth does.

use std::ops::{Deref, DerefMut};

/// The widest register, in numbers: a column that starts elsewhere costs two reads a register.
const UNIT: usize = 8;

/// A growing array of numbers whose first stands at a multiple of 64 bytes.
#[derive(Clone, Debug, Default)]
pub(super) struct Aligned {
    values: Vec<f64>,
    start: usize,
    len: usize,
}

impl Aligned {
    /// Makes it `len` numbers long; their values are not defined.
    pub(super) fn set_len(&mut self, len: usize) {
        if self.values.len() < len + UNIT {
            self.values.resize(len + UNIT, 0.0);
            // Where the start cannot be known, any is right.
            self.start = self.values.as_ptr().align_offset(8 * UNIT) % UNIT;
        }
        self.len = len;
    }
}

impl Deref for Aligned {
    type Target = [f64];

    fn deref(&self) -> &[f64] {
        &self.values[self.start..self.start + self.len]
    }
}

impl DerefMut for Aligned {
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.values[self.start..self.start + self.len]
    }
}
