//! One pass over a source: rows are cut into segments and chunks that do not depend on how they arrive.

use std::ops::Range;

use rayon::prelude::*;

use super::pass::Pass;
use super::plan::CHUNK;
use super::sums::{Sums, Workspace};
use crate::error::SindyError;

/// Rows of a group that one thread takes at a time, and the next after it; a multiple of [`CHUNK`].
pub(super) const SEGMENT: usize = 8192;

/// Whole segments that a block must still hold for them to be read where they are; fewer are copied.
const BORROW: usize = 4;

/// Segments of a block whose statistics are held at a time.
const WAVE: usize = 64;

/// Copied rows that wait at a time, and pieces of segments that they may be in.
const WAITING_ROWS: usize = 16 * SEGMENT;
const WAITING_PIECES: usize = 256;

/// The segment that is being filled.
struct Open {
    group: usize,
    rows: usize,
    /// Whether its rows are summed as they come, but for those of an unfinished chunk. If not, they are copied.
    summed: bool,
    /// The sums so far; `None` if they go straight to the group's.
    part: Option<Sums>,
    /// Rows that were copied.
    buffer: Vec<Vec<f64>>,
}

pub(super) struct Driver<'a> {
    pass: &'a Pass,
    groups: Vec<Sums>,
    work: Workspace,
    open: Option<Open>,
    /// Copied segments that wait for a thread, with their groups, in order.
    waiting: Vec<(usize, Vec<Vec<f64>>)>,
    waiting_rows: usize,
    /// Rows so far.
    seen: usize,
}

impl<'a> Driver<'a> {
    pub(super) fn new(pass: &'a Pass, groups: usize) -> Self {
        Self {
            pass,
            groups: vec![Sums::zeros(pass); groups],
            work: Workspace::default(),
            open: None,
            waiting: Vec::new(),
            waiting_rows: 0,
            seen: 0,
        }
    }

    pub(super) fn push(&mut self, group: usize, columns: &[&[f64]]) -> Result<(), SindyError> {
        let n = columns.first().map_or(0, |c| c.len());
        if self.open.as_ref().is_some_and(|o| o.group != group) {
            self.close()?;
        }
        let mut at = 0;
        while at < n {
            let Some(open) = &mut self.open else {
                let whole = (n - at) / SEGMENT;
                if whole >= BORROW {
                    let end = at + whole * SEGMENT;
                    self.borrow(group, columns, at..end)?;
                    self.seen += end - at;
                    at = end;
                } else {
                    self.open = Some(self.fresh(group, columns.len()));
                }
                continue;
            };
            let take = (n - at).min(SEGMENT - open.rows);
            open.rows += take;
            if open.summed {
                let sums = open.part.as_mut().unwrap_or(&mut self.groups[group]);
                add_summed(
                    self.pass,
                    sums,
                    &mut open.buffer,
                    columns,
                    at..at + take,
                    &mut self.work,
                )?;
            } else {
                for (to, column) in open.buffer.iter_mut().zip(columns) {
                    to.extend_from_slice(&column[at..at + take]);
                }
            }
            let full = open.rows == SEGMENT;
            at += take;
            self.seen += take;
            if full {
                self.close()?;
            }
        }
        Ok(())
    }

    fn fresh(&self, group: usize, columns: usize) -> Open {
        let first = self.groups[group].is_empty();
        // The pool of threads is asked for only by those who have work for it.
        let summed = self.seen < 2 * SEGMENT || rayon::current_num_threads() == 1;
        Open {
            group,
            rows: 0,
            summed,
            part: (summed && !first).then(|| Sums::zeros(self.pass)),
            buffer: vec![Vec::new(); columns],
        }
    }

    /// Ends the segment that is being filled.
    fn close(&mut self) -> Result<(), SindyError> {
        let Some(mut open) = self.open.take() else {
            return Ok(());
        };
        if open.summed {
            let rest = open.buffer[0].len();
            let sums = open.part.as_mut().unwrap_or(&mut self.groups[open.group]);
            let columns: Vec<&[f64]> = open.buffer.iter().map(Vec::as_slice).collect();
            sums.add_rows(self.pass, &columns, 0..rest, &mut self.work)?;
            sums.settle();
            if let Some(part) = open.part {
                self.groups[open.group].merge(&part);
            }
            return Ok(());
        }
        self.waiting_rows += open.rows;
        self.waiting.push((open.group, open.buffer));
        if self.waiting_rows >= WAITING_ROWS || self.waiting.len() >= WAITING_PIECES {
            self.flush()?;
        }
        Ok(())
    }

    /// Sums the segments that wait.
    fn flush(&mut self) -> Result<(), SindyError> {
        let waiting = std::mem::take(&mut self.waiting);
        self.waiting_rows = 0;
        let pass = self.pass;
        let parts: Vec<Sums> = waiting
            .par_iter()
            .map_init(Workspace::default, |work, (_, buffer)| {
                let columns: Vec<&[f64]> = buffer.iter().map(Vec::as_slice).collect();
                let mut part = Sums::zeros(pass);
                part.add_rows(pass, &columns, 0..columns[0].len(), work)?;
                part.settle();
                Ok(part)
            })
            .collect::<Result<_, SindyError>>()?;
        for ((group, _), part) in waiting.iter().zip(&parts) {
            self.groups[*group].merge(part);
        }
        Ok(())
    }

    /// Sums whole segments of a block where they are.
    fn borrow(
        &mut self,
        group: usize,
        columns: &[&[f64]],
        range: Range<usize>,
    ) -> Result<(), SindyError> {
        self.flush()?;
        let pass = self.pass;
        let segments: Vec<usize> = range.step_by(SEGMENT).collect();
        for wave in segments.chunks(WAVE) {
            let parts: Vec<Sums> = wave
                .par_iter()
                .map_init(Workspace::default, |work, &start| {
                    let mut part = Sums::zeros(pass);
                    part.add_rows(pass, columns, start..start + SEGMENT, work)?;
                    part.settle();
                    Ok(part)
                })
                .collect::<Result<_, SindyError>>()?;
            parts.iter().for_each(|part| self.groups[group].merge(part));
        }
        Ok(())
    }

    pub(super) fn finish(mut self) -> Result<Vec<Sums>, SindyError> {
        self.close()?;
        self.flush()?;
        Ok(self.groups)
    }
}

/// Adds rows of an open segment whose last, unfinished chunk is in `buffer`.
fn add_summed(
    pass: &Pass,
    sums: &mut Sums,
    buffer: &mut [Vec<f64>],
    columns: &[&[f64]],
    range: Range<usize>,
    work: &mut Workspace,
) -> Result<(), SindyError> {
    let mut at = range.start;
    let copy = |from: Range<usize>, buffer: &mut [Vec<f64>]| {
        for (to, column) in buffer.iter_mut().zip(columns) {
            to.extend_from_slice(&column[from.clone()]);
        }
    };
    let held = buffer[0].len();
    if held > 0 {
        let take = (CHUNK - held).min(range.end - at);
        copy(at..at + take, buffer);
        at += take;
        if held + take < CHUNK {
            return Ok(());
        }
        let chunk: Vec<&[f64]> = buffer.iter().map(Vec::as_slice).collect();
        sums.add_rows(pass, &chunk, 0..CHUNK, work)?;
        buffer.iter_mut().for_each(Vec::clear);
    }
    let whole = (range.end - at) / CHUNK * CHUNK;
    sums.add_rows(pass, columns, at..at + whole, work)?;
    copy(at + whole..range.end, buffer);
    Ok(())
}
