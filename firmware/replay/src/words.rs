//! Words of a recording: how a target reads inputs, writes results and counts a call.

use touchdown_flight::{Attitude, Vector};

/// The target's side of a replay.
pub trait Port {
    /// The next word of the recording; none at its end.
    fn word(&mut self) -> Option<u32>;
    /// Writes a word of the results.
    fn write(&mut self, word: u32);
    /// A measured call begins.
    fn begin(&mut self) {}
    /// The measured call has ended.
    fn end(&mut self) {}
}

/// Reads values from words.
pub trait Reader: Port {
    /// The next number.
    fn number(&mut self) -> Option<f32> {
        self.word().map(f32::from_bits)
    }

    /// The next N numbers.
    fn numbers<const N: usize>(&mut self) -> Option<[f32; N]> {
        let mut numbers = [0.0; N];
        for number in &mut numbers {
            *number = self.number()?;
        }
        Some(numbers)
    }

    /// The next vector.
    fn vector(&mut self) -> Option<Vector<f32>> {
        let [x, y, z] = self.numbers()?;
        Some(Vector::new(x, y, z))
    }
}

impl<P: Port> Reader for P {}

/// Writes values as words.
pub trait Writer: Port {
    /// Writes a number. All NaN are one word, because their bits differ between processors.
    fn put(&mut self, number: f32) {
        let word = if number.is_nan() {
            f32::NAN.to_bits()
        } else {
            number.to_bits()
        };
        self.write(word);
    }

    /// Writes a vector.
    fn put_vector(&mut self, vector: Vector<f32>) {
        for number in vector.to_array() {
            self.put(number);
        }
    }

    /// Writes an attitude.
    fn put_attitude(&mut self, attitude: Attitude<f32>) {
        for number in attitude.to_quaternion() {
            self.put(number);
        }
    }
}

impl<P: Port> Writer for P {}
