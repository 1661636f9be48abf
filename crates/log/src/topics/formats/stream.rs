//! Bytes of a file in order, through a sliding window.

use crate::topics::LogFormat;
use crate::topics::sink::ReadError;
use std::io::{self, Read};

/// Bytes that are read at once.
const BLOCK: usize = 1 << 18;

/// A window onto an input that slides forward.
pub(crate) struct Stream<'r> {
    input: &'r mut dyn Read,
    buffer: Vec<u8>,
    start: usize,
    end: usize,
    position: u64,
    ended: bool,
}

impl<'r> Stream<'r> {
    pub(crate) fn new(input: &'r mut dyn Read) -> Self {
        Self {
            input,
            buffer: vec![0; BLOCK],
            start: 0,
            end: 0,
            position: 0,
            ended: false,
        }
    }

    /// Skips the first bytes of this format.
    pub(super) fn begin(&mut self, magic: &[u8], format: LogFormat) -> Result<(), ReadError> {
        if self.peek(magic.len())? != Some(magic) {
            return Err(ReadError::broken(format, "without its first bytes"));
        }
        self.advance(magic.len());
        Ok(())
    }

    /// Offset in the file of the window's first byte.
    pub(crate) fn position(&self) -> u64 {
        self.position
    }

    /// The window as far as it is filled.
    pub(crate) fn window(&self) -> &[u8] {
        &self.buffer[self.start..self.end]
    }

    /// Tries to fill the window with `length` bytes, and returns its size. Memory grows with the bytes
    /// of the file, not with the requested length.
    pub(crate) fn fill(&mut self, length: usize) -> io::Result<usize> {
        while self.end - self.start < length && !self.ended {
            if self.buffer.len() - self.end < BLOCK / 2 {
                self.buffer.copy_within(self.start..self.end, 0);
                self.end -= self.start;
                self.start = 0;
                if self.buffer.len() - self.end < BLOCK / 2 {
                    self.buffer.resize(2 * self.buffer.len(), 0);
                }
            }
            match self.input.read(&mut self.buffer[self.end..]) {
                Ok(0) => self.ended = true,
                Ok(read) => self.end += read,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(self.end - self.start)
    }

    /// The first `length` bytes of the window, or `None` if the file ends before.
    #[inline]
    pub(crate) fn peek(&mut self, length: usize) -> io::Result<Option<&[u8]>> {
        if self.end - self.start < length && self.fill(length)? < length {
            return Ok(None);
        }
        Ok(Some(&self.buffer[self.start..self.start + length]))
    }

    /// Slides the window forward by bytes inside it.
    #[inline]
    pub(crate) fn advance(&mut self, length: usize) {
        let length = length.min(self.end - self.start);
        self.start += length;
        self.position += length as u64;
    }

    /// Slides the window forward by any number of bytes; returns how many the file contained.
    pub(crate) fn skip(&mut self, length: u64) -> io::Result<u64> {
        let mut left = length;
        while left > 0 {
            let there = self.fill(1)?;
            if there == 0 {
                break;
            }
            let step = usize::try_from(left).unwrap_or(usize::MAX).min(there);
            self.advance(step);
            left -= step as u64;
        }
        Ok(length - left)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives one byte at a time.
    struct Slow<'a>(&'a [u8]);

    impl Read for Slow<'_> {
        fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
            let one = into.len().min(1);
            self.0.read(&mut into[..one])
        }
    }

    #[test]
    fn analytic_a_window_slides_and_ends() {
        let bytes: Vec<u8> = (0..200).collect();
        let mut slow = Slow(&bytes);
        let mut stream = Stream::new(&mut slow);
        assert_eq!(stream.peek(3).unwrap(), Some(&[0, 1, 2][..]));
        stream.advance(2);
        assert_eq!(stream.skip(100).unwrap(), 100);
        assert_eq!(stream.position(), 102);
        assert_eq!(stream.peek(1).unwrap(), Some(&[102][..]));
        assert!(stream.peek(usize::MAX / 2).unwrap().is_none());
        assert_eq!(stream.window().len(), 98);
        assert_eq!(stream.skip(1000).unwrap(), 98);
        assert!(stream.peek(1).unwrap().is_none());
    }
}
