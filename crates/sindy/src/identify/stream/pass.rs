//! The pass: rows in, sums and kept pieces out.

use super::Columns;
use super::clusters::ClusterSums;
use super::kept::{Kept, KeptPieces};
use super::slopes::{Plan, alike, choose};
use super::sums::{RegressionTarget, Shared, Sums, shared};
use super::window::{Window, WindowStretch};
use crate::data::dataset::{DataReport, FEWEST};
use crate::data::grid::uniform_period;
use crate::data::samples::{BlockSource, passed};
use crate::derivative::savgol::Smoothed;
use crate::error::SindyError;
use crate::identify::Settings;
use crate::library::Library;
use crate::trajectory::shift::{Cut, uneven};

/// Rows that decide how slopes are taken, about a second of work. A record whose noise changes later is smoothed as its
/// beginning asks for.
pub(super) const HEAD: usize = 50_000;
/// Rows that are differentiated at a time, at least.
pub(super) const WINDOW: usize = 32_768;
/// Rows of a block, at least, where there are enough.
const BLOCK: usize = 1024;
/// Clusters at most (standard errors hardly gain from more), and what their sums may take in bytes.
const CLUSTERS: usize = 60;
const MEMORY: usize = 64 << 20;
/// Rows of a piece that is kept.
const PIECE: usize = 2000;

/// Where a pass stands among all rows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Place {
    /// Index of the source.
    pub source: usize,
    /// Rows of the sources before it, as far as they are among the first that decide.
    pub before: usize,
}

/// What a pass leaves.
pub(super) struct Passed {
    pub plan: Plan,
    pub report: DataReport,
    /// One for each way to take slopes.
    pub slopes: Vec<ClusterSums>,
    pub weak: Option<ClusterSums>,
    pub kept: KeptPieces,
}

pub(super) struct Pass<'a> {
    names: &'a Columns,
    settings: &'a Settings,
    shared: Vec<Shared>,
    place: Place,
    report: DataReport,
    /// The trajectory that rows come from, and its rows that were not used up.
    group: Option<usize>,
    open: Window,
    /// Rows of the pass.
    seen: usize,
    /// Whole trajectories that wait for the decision.
    head: Vec<Window>,
    plan: Option<Plan>,
    /// Slopes, one for each of the plan.
    slopes: Vec<Sums>,
    weak: Option<Sums>,
    kept: KeptPieces,
    pieces: usize,
}

impl<'a> Pass<'a> {
    /// A pass whose first rows decide.
    pub(super) fn new(
        names: &'a Columns,
        libraries: &[Library],
        settings: &'a Settings,
    ) -> Result<Self, SindyError> {
        let data: Vec<String> = names.states.iter().chain(&names.inputs).cloned().collect();
        for library in libraries {
            library.compile(&data)?;
        }
        let mut pass = Self {
            names,
            settings,
            shared: shared(libraries),
            place: Place::default(),
            report: DataReport::default(),
            group: None,
            open: Window::new(0, 0),
            seen: 0,
            head: Vec::new(),
            plan: None,
            slopes: Vec::new(),
            weak: None,
            kept: KeptPieces::new(),
            pieces: 0,
        };
        pass.open = pass.fresh();
        Ok(pass)
    }

    /// A pass over the rows at `place`, for which `plan` was decided. It leaves the bits of a pass that decided itself.
    pub(super) fn planned(
        names: &'a Columns,
        libraries: &[Library],
        settings: &'a Settings,
        plan: &Plan,
        place: Place,
    ) -> Result<Self, SindyError> {
        let mut pass = Self::new(names, libraries, settings)?;
        pass.place = place;
        pass.report.period = plan.period;
        pass.report.uniform = plan.uniform;
        pass.make_sums(plan);
        pass.plan = Some(plan.clone());
        Ok(pass)
    }

    /// Takes the rows of a source; with `head` only until the first rows have decided.
    pub(super) fn take(&mut self, source: &dyn BlockSource, head: bool) -> Result<(), SindyError> {
        let places = self.names.places(source.names())?;
        let mut result = Ok(());
        source.for_each_block(&mut |block| {
            if result.is_ok() && !(head && self.is_decided()) {
                let rows: Vec<&[f64]> = places.iter().map(|&p| block.columns[p]).collect();
                result = self.push(block.group, &rows);
            }
        });
        passed(source)?;
        result
    }

    /// Rows so far.
    pub(super) fn seen(&self) -> usize {
        self.seen
    }

    /// Whether the first rows have decided.
    pub(super) fn is_decided(&self) -> bool {
        self.plan.is_some()
    }

    /// Ends the open trajectory: the next rows are those of another source.
    pub(super) fn next_source(&mut self) -> Result<(), SindyError> {
        self.close()?;
        self.group = None;
        Ok(())
    }

    /// States and inputs.
    fn data(&self) -> usize {
        self.names.states.len() + self.names.inputs.len()
    }

    fn fresh(&self) -> Window {
        let weights = usize::from(self.names.weights.is_some());
        Window::new(1 + self.data() + weights, self.seen)
    }

    /// Takes rows: time, states, inputs, weights.
    pub(super) fn push(&mut self, group: usize, columns: &[&[f64]]) -> Result<(), SindyError> {
        self.check(columns)?;
        if self.group != Some(group) {
            self.close()?;
            self.group = Some(group);
            self.report.trajectories += 1;
            self.open = self.fresh();
        }
        let n = columns[0].len();
        let mut start = 0;
        while start < n {
            // Whatever the size of the blocks: a decision by as many rows, and windows as long.
            let room = match &self.plan {
                None => HEAD - self.head.iter().map(Window::len).sum::<usize>(),
                Some(plan) if self.open.continued => plan.window(),
                // A trajectory that begins among the rows that decide waits for the last of them.
                Some(plan) => {
                    let first = self.place.before + self.open.first;
                    plan.window().max(HEAD.saturating_sub(first))
                }
            };
            let rows = start..n.min(start + room - self.open.len());
            start = rows.end;
            self.seen += rows.len();
            self.open.extend(columns, rows);
            if self.open.len() < room {
                continue;
            }
            match self.plan {
                None => self.begin(true)?,
                Some(_) => self.advance()?,
            }
        }
        Ok(())
    }

    fn check(&self, columns: &[&[f64]]) -> Result<(), SindyError> {
        let names = std::iter::once(&self.names.time)
            .chain(&self.names.states)
            .chain(&self.names.inputs);
        for (name, column) in names.zip(columns) {
            if let Some(row) = column.iter().position(|v| v.is_infinite()) {
                return Err(SindyError::NotFinite {
                    what: format!("column `{name}`"),
                    index: self.seen + row,
                });
            }
        }
        if let Some(name) = &self.names.weights
            && let Some(row) = columns[1 + self.data()]
                .iter()
                .position(|w| !(w.is_finite() && *w >= 0.0))
        {
            return Err(SindyError::setting(
                "weights",
                format!("column `{name}` finite, not negative"),
                format!(
                    "{} at row {}",
                    columns[1 + self.data()][row],
                    self.seen + row
                ),
            ));
        }
        Ok(())
    }

    /// Uses the rows of the open trajectory if they fill a window.
    fn advance(&mut self) -> Result<(), SindyError> {
        let Some(plan) = &self.plan else {
            return Ok(());
        };
        let overlap = plan.overlap;
        if self.open.len() >= plan.window() {
            let window = std::mem::replace(&mut self.open, Window::new(0, 0));
            self.open = self.process(window, true)?;
            self.open.advance(overlap);
        }
        Ok(())
    }

    /// Ends the open trajectory.
    fn close(&mut self) -> Result<(), SindyError> {
        let window = std::mem::replace(&mut self.open, Window::new(0, 0));
        if self.group.is_none() {
            return Ok(());
        }
        if self.plan.is_some() {
            self.process(window, false)?;
        } else {
            self.head.push(window);
        }
        Ok(())
    }

    /// Decides how slopes are taken, and uses the rows that have waited for it.
    fn begin(&mut self, open: bool) -> Result<(), SindyError> {
        let head = std::mem::take(&mut self.head);
        let states = self.names.states.len();
        let mut series = Vec::new();
        let mut rows = 0;
        for window in head.iter().chain(open.then_some(&self.open)) {
            rows += window.len();
            let window = window.bridged(states, self.data(), self.settings.discrete);
            for part in window.parts(self.data(), 0, false, &mut DataReport::default())? {
                let column = |c: &'_ Vec<f64>| c[part.rows.clone()].to_vec();
                let all: Vec<Vec<f64>> = window.columns[..=states].iter().map(column).collect();
                series.push(all);
            }
        }
        if series.is_empty() {
            return Err(match rows < FEWEST {
                true => SindyError::too_short(FEWEST, rows),
                false => SindyError::Source {
                    reason: format!(
                        "expected rows in succession that hold all states (in a stream states have one rate, in memory they need \
                         not), found none among {rows}"
                    ),
                },
            });
        }
        let series: Vec<(&[f64], Vec<&[f64]>)> = series
            .iter()
            .map(|s| (s[0].as_slice(), s[1..].iter().map(Vec::as_slice).collect()))
            .collect();
        let mut plan = choose(&series, self.settings, WINDOW / 8)?;
        plan.head = rows;
        plan.triangles = vec![None; plan.slopes.len()];
        self.report.period = plan.period;
        self.report.uniform = plan.uniform;
        self.make_sums(&plan);
        self.plan = Some(plan);
        for window in head {
            self.process(window, false)?;
        }
        if open {
            self.advance()?;
        }
        self.flush(0)?;
        if let Some(plan) = &mut self.plan {
            plan.triangles = self.slopes.iter().map(Sums::triangles).collect();
        }
        Ok(())
    }

    fn make_sums(&mut self, plan: &Plan) {
        let names = self.names;
        let data: Vec<String> = names.states.iter().chain(&names.inputs).cloned().collect();
        let (slopes, weak) = empty(plan, &self.shared, self.settings);
        for (sums, triangles) in slopes.into_iter().zip(&plan.triangles) {
            let kind = RegressionTarget::Slopes {
                weighted: names.weights.is_some(),
            };
            let sums = Sums::new(kind, &self.shared, &data, sums, triangles.as_deref());
            self.slopes.push(sums);
        }
        if let (Some(half_width), Some(sums)) = (plan.half_width, weak) {
            let kind = RegressionTarget::Weak(half_width, names.states.clone());
            self.weak = Some(Sums::new(kind, &self.shared, &data, sums, None));
        }
    }

    /// Uses the rows of a window, and gives it back.
    fn process(&mut self, window: Window, more: bool) -> Result<Window, SindyError> {
        let Some(plan) = self.plan.take() else {
            return Ok(window);
        };
        let states = self.names.states.len();
        let usable = window.bridged(states, self.data(), self.settings.discrete);
        let parts = usable.parts(self.data(), plan.overlap, more, &mut self.report)?;
        for part in &parts {
            let columns: Vec<&[f64]> = usable
                .columns
                .iter()
                .map(|c| &c[part.rows.clone()])
                .collect();
            let uniform = alike(uniform_period(columns[0]), plan.period);
            self.report.uniform &= uniform;
            for (k, slopes) in plan.slopes.iter().enumerate() {
                let smooth = slopes.apply(columns[0], &columns[1..=states])?;
                if k == 0 {
                    self.keep(&columns, &smooth, part);
                }
                let mut all: Vec<&[f64]> = smooth.iter().map(|s| s.value.as_slice()).collect();
                all.extend(&columns[1 + states..=self.data()]);
                all.extend(smooth.iter().map(|s| s.derivative.as_slice()));
                all.extend(&columns[1 + self.data()..]);
                let mut rows = part.inner(slopes.edge);
                if self.settings.discrete && part.ends {
                    // The last row has no next one.
                    rows.end = rows.end.min(part.rows.end - 1).max(rows.start);
                }
                let from = part.rows.start;
                let rows = rows.start - from..rows.end - from;
                if !self.settings.discrete {
                    self.slopes[k].add(&all, rows)?;
                    continue;
                }
                let cut = Cut::new(columns[0], plan.period);
                if let Some((row, step)) = cut.uneven {
                    let at = format!("time {}", columns[0][row]);
                    return Err(uneven(plan.period, step, &at));
                }
                for piece in &cut.ranges {
                    // The row before a gap has no next one either.
                    let next = usize::from(piece.end < columns[0].len());
                    let end = (piece.end - next).min(rows.end);
                    if piece.start.max(rows.start) < end {
                        self.slopes[k].add(&all, piece.start.max(rows.start)..end)?;
                    }
                }
            }
            if let Some(weak) = &mut self.weak {
                let from = part.rows.start;
                let data = self.names.states.len() + self.names.inputs.len();
                weak.add(
                    &columns[..=data],
                    part.own.start - from..part.own.end - from,
                )?;
            }
        }
        drop(usable);
        self.plan = Some(plan);
        self.flush(WINDOW)?;
        Ok(window)
    }

    /// Sums rows where more than `most` of them wait.
    fn flush(&mut self, most: usize) -> Result<(), SindyError> {
        for sums in self.slopes.iter_mut().chain(&mut self.weak) {
            if sums.waiting() > most {
                sums.flush()?;
            }
        }
        Ok(())
    }

    /// Keeps evenly spread pieces.
    fn keep(&mut self, columns: &[&[f64]], smooth: &[Smoothed], part: &WindowStretch) {
        let from = part.rows.start;
        let own = part.own.start - from..part.own.end - from;
        for start in own.clone().step_by(PIECE) {
            let rows = start..own.end.min(start + PIECE);
            if rows.len() < FEWEST {
                continue;
            }
            let index = self.pieces;
            self.pieces += 1;
            if !self.kept.wants(self.place.source, index) {
                continue;
            }
            let smooth = smooth.iter().map(|s| s.value[rows.clone()].to_vec());
            let piece = Kept {
                source: self.place.source,
                index,
                columns: columns.iter().map(|c| c[rows.clone()].to_vec()).collect(),
                smooth: smooth.collect(),
            };
            self.kept.push(piece, self.settings.rows);
        }
    }

    /// Ends the pass.
    pub(super) fn end(mut self) -> Result<Passed, SindyError> {
        self.close()?;
        if self.plan.is_none() {
            self.begin(false)?;
        }
        self.flush(0)?;
        Ok(Passed {
            plan: self.plan.ok_or(SindyError::too_short(FEWEST, 0))?,
            report: self.report,
            slopes: self.slopes.into_iter().map(|s| s.clusters).collect(),
            weak: self.weak.map(|w| w.clusters),
            kept: self.kept,
        })
    }
}

/// Sums of no rows: for each way to take slopes, and for the weak form.
pub(super) fn empty(
    plan: &Plan,
    shared: &[Shared],
    settings: &Settings,
) -> (Vec<ClusterSums>, Option<ClusterSums>) {
    let folds = settings.folds;
    let kinds = plan.slopes.len() + usize::from(plan.half_width.is_some());
    let squares = |s: &Shared| s.states.len() * s.library.len() * s.library.len();
    let size: usize = 8 * kinds * shared.iter().map(squares).sum::<usize>();
    let clusters = (MEMORY / size.max(1)).min(CLUSTERS) / folds * folds;
    let clusters = clusters.max(folds);
    let mut terms = vec![0; shared.iter().map(|s| s.states.len()).sum()];
    for one in shared {
        one.states
            .iter()
            .for_each(|&i| terms[i] = one.library.len());
    }
    // Blocks longer than what correlates their rows, if there are rows enough for that.
    let sums = |alike: f64| {
        let block = ((4.0 * alike) as usize)
            .max(BLOCK)
            .min(plan.head / (2 * folds))
            .max(20);
        ClusterSums::new(&terms, clusters, block)
    };
    let slopes = plan.slopes.iter().map(|s| sums(s.window)).collect();
    let weak = plan.half_width.map(|h| sums(2.0 * h / plan.period));
    (slopes, weak)
}
