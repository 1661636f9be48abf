//! Past states in continuous time: `x'(t) = f(x(t), x(t - d), u(t))`.

#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};

use super::input::{Inputs, Interpolation, increasing};
use super::limits::{Run, RunOutcome};
use super::{Model, Simulation, Time};
use crate::error::{SindyError, require, same_size};

/// Steps of the feedback's samples in the shortest delay, at least: splines over them err by their fourth power.
const FINE: f64 = 16.0;
/// Samples beyond a range of time that a spline over it takes in; the influence of a sample falls fourfold a step.
const BESIDE: usize = 6;

/// An input of a model that is not given from outside: what a state was.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Past {
    /// The input's name.
    pub input: String,
    /// The state.
    pub state: String,
    /// How long ago, positive, in the unit of time of the model.
    pub delay: f64,
}

/// The states up to the start of a run.
#[derive(Clone, Debug, PartialEq)]
pub struct History {
    time: Vec<f64>,
    states: Vec<Vec<f64>>,
}

impl History {
    /// The states never were anything but `start`.
    #[must_use]
    pub fn constant(start: &[f64]) -> Self {
        Self {
            time: Vec::new(),
            states: start.iter().map(|v| vec![*v]).collect(),
        }
    }

    /// The states at increasing times, the last of them the start of the run: one column for each state. A cubic
    /// spline goes through them.
    ///
    /// # Errors
    /// Fewer than two times, times that do not increase, columns of another length, values that are not finite.
    pub fn sampled(time: &[f64], states: &[&[f64]]) -> Result<Self, SindyError> {
        Inputs::sampled(time, states, Interpolation::Cubic)?;
        Ok(Self {
            time: time.to_vec(),
            states: states.iter().map(|c| c.to_vec()).collect(),
        })
    }

    /// The states at the start of the run.
    #[must_use]
    pub fn start(&self) -> Vec<f64> {
        let last = |c: &Vec<f64>| c[c.len() - 1];
        self.states.iter().map(last).collect()
    }

    fn inputs(&self) -> Result<Inputs, SindyError> {
        if self.time.is_empty() {
            return Inputs::constant(&self.start());
        }
        let columns: Vec<&[f64]> = self.states.iter().map(Vec::as_slice).collect();
        Inputs::sampled(&self.time, &columns, Interpolation::Cubic)
    }
}

impl Model {
    /// The same model, some inputs of which are what states were. All that takes inputs takes these too, as
    /// measured; [`Model::simulate_past`] makes them itself.
    ///
    /// # Errors
    /// A model in discrete time (see [`crate::trajectory::shift::chain`]); names that are no input, or twice, or no state; a delay
    /// that is not positive and finite.
    pub fn with_past(mut self, past: Vec<Past>) -> Result<Self, SindyError> {
        if !past.is_empty() && self.time != Time::Continuous {
            let expected = "continuous time; in discrete time past states are states of their own";
            return Err(SindyError::setting("past", expected, "discrete time"));
        }
        let known = |names: &[String], name: &String| match names.contains(name) {
            true => Ok(()),
            false => Err(SindyError::UnknownColumn {
                name: name.clone(),
                known: names.join(", "),
            }),
        };
        for (i, p) in past.iter().enumerate() {
            known(&self.inputs, &p.input)?;
            known(&self.states, &p.state)?;
            if past[..i].iter().any(|q| q.input == p.input) {
                let found = format!("`{}` twice", p.input);
                return Err(SindyError::setting("past", "each input once", found));
            }
            require(
                p.delay > 0.0 && p.delay.is_finite(),
                "past",
                "a delay that is positive and finite",
                p.delay,
            )?;
        }
        self.past = past;
        Ok(self)
    }

    /// The inputs that are what states were.
    #[must_use]
    pub fn past(&self) -> &[Past] {
        &self.past
    }

    /// The inputs that come from outside, in the order of the model's inputs.
    #[must_use]
    pub fn outside(&self) -> Vec<String> {
        let outside = |name: &&String| !self.past.iter().any(|p| p.input == **name);
        self.inputs.iter().filter(outside).cloned().collect()
    }

    /// Integrates a model with past states by the method of steps: over one shortest delay after the other, the past
    /// being known. `inputs` are those of [`Model::outside`].
    ///
    /// The solution is kept at the requested times and at least 16 times per shortest delay, and joined by
    /// cubic splines: errors are of fourth order in that distance.
    ///
    /// ```
    /// use sindy::model::{History, Inputs, Model, Past, Simulation, Term, Time};
    ///
    /// // x' = -x(t - 1), x = 1 before 0: x = 1 - t up to 1.
    /// let model = Model::new(Time::Continuous, &["x"], &["x_before"], vec![vec![Term::parse("x_before", -1.0)?]])?;
    /// let past = Past { input: "x_before".into(), state: "x".into(), delay: 1.0 };
    /// let model = model.with_past(vec![past])?;
    /// let history = History::constant(&[1.0]);
    /// let run = model.simulate_past(&history, &[0.0, 0.5, 1.0], &Inputs::none(), &Simulation::adaptive())?;
    /// assert!((run.states[0][1] - 0.5).abs() < 1e-9);
    /// # Ok::<(), sindy::SindyError>(())
    /// ```
    ///
    /// Source: A. Bellen, M. Zennaro, *Numerical Methods for Delay Differential Equations* (2003), ch. 3.
    ///
    /// # Errors
    /// Those of [`Model::simulate`]; a history that does not reach back over the longest delay, or does not end where
    /// the run starts.
    pub fn simulate_past(
        &self,
        history: &History,
        time: &[f64],
        inputs: &Inputs,
        how: &Simulation,
    ) -> Result<Run, SindyError> {
        let outside = self.outside();
        same_size("inputs from outside", outside.len(), inputs.len())?;
        same_size(
            "states of the history",
            self.states.len(),
            history.states.len(),
        )?;
        let (Some(&start), Some(&end)) = (time.first(), time.last()) else {
            return Err(SindyError::too_short(1, 0));
        };
        increasing("time", time)?;
        inputs.check_span(start, end)?;
        let delays = || self.past.iter().map(|p| p.delay);
        let (least, most) = (
            delays().fold(f64::INFINITY, f64::min),
            delays().fold(0.0, f64::max),
        );
        if self.past.is_empty() || start == end {
            let all = match self.past.is_empty() {
                true => inputs.clone(),
                false => Inputs::constant(&vec![0.0; self.inputs.len()])?,
            };
            return self.simulate(&history.start(), time, &all, how);
        }
        check_history(history, start, most)?;
        let mut steps = Steps {
            model: self,
            outside,
            inputs,
            before: history.inputs()?,
            reach: history.time.first().copied(),
            start,
            known: Run::new(self.states.len(), 0),
        };
        steps.known.push(start, &history.start());
        let mut run = Run::new(self.states.len(), time.len());
        run.push(start, &history.start());
        let mut from = start;
        while from < end {
            // What comes from before the start is joined to what comes after it at the end of a step only.
            let joints = delays()
                .map(|d| start + d)
                .filter(|t| *t > from + 1e-6 * least);
            let to = joints.fold((from + least).min(end), f64::min);
            let rows = time.partition_point(|t| *t <= from)..time.partition_point(|t| *t <= to);
            let asked = &time[rows];
            let grid = steps.grid(from, to, asked, least / FINE);
            let to = grid[grid.len() - 1];
            let drive = steps.drive(&grid)?;
            let at = steps.last();
            let part = self.simulate(&at, &grid, &drive, how)?;
            run.evaluations += part.evaluations;
            run.steps += part.steps;
            for (k, t) in part.time.iter().enumerate().skip(1) {
                let state: Vec<f64> = part.states.iter().map(|c| c[k]).collect();
                if asked.binary_search_by(|a| a.total_cmp(t)).is_ok() {
                    run.push(*t, &state);
                }
                steps.known.push(*t, &state);
            }
            if part.outcome != RunOutcome::Finished {
                run.outcome = part.outcome;
                break;
            }
            from = to;
        }
        Ok(run)
    }
}

fn check_history(history: &History, start: f64, most: f64) -> Result<(), SindyError> {
    let (Some(first), Some(last)) = (history.time.first(), history.time.last()) else {
        return Ok(());
    };
    // Times carry rounding.
    let slack = 1e-6 * most;
    if *first > start - most + slack || (last - start).abs() > slack {
        return Err(SindyError::setting(
            "history",
            format!("times from {} to {start}", start - most),
            format!("{first} to {last}"),
        ));
    }
    Ok(())
}

/// A run under way.
struct Steps<'a> {
    model: &'a Model,
    outside: Vec<String>,
    inputs: &'a Inputs,
    /// The states before the start.
    before: Inputs,
    /// The first time of the history, if it has any.
    reach: Option<f64>,
    start: f64,
    /// The solution so far.
    known: Run,
}

impl Steps<'_> {
    fn last(&self) -> Vec<f64> {
        let last = |c: &Vec<f64>| c[c.len() - 1];
        self.known.states.iter().map(last).collect()
    }

    /// Times from `from` to `to`: those that are asked for, those of the inputs' samples, and others between, none
    /// further apart than `step`.
    fn grid(&self, from: f64, to: f64, asked: &[f64], step: f64) -> Vec<f64> {
        let others = self.inputs.samples(from, to).iter().copied().chain([to]);
        let mut all: Vec<(f64, bool)> = others.map(|t| (t, false)).collect();
        all.extend(asked.iter().map(|t| (*t, true)));
        all.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut grid = vec![from];
        let mut kept = true;
        for (t, asked) in all {
            let last = grid[grid.len() - 1];
            // Times that differ by rounding only would spoil the splines; those that are asked for stay.
            if t - last <= 1e-6 * step {
                if !asked {
                    continue;
                }
                if !kept {
                    grid.pop();
                }
            } else {
                let parts = ((t - last) / step).ceil().max(1.0);
                grid.extend((1..parts as usize).map(|k| last + (t - last) * k as f64 / parts));
            }
            grid.push(t);
            kept = asked;
        }
        grid
    }

    /// All inputs of the model over a grid.
    fn drive(&self, grid: &[f64]) -> Result<Inputs, SindyError> {
        let given = self.inputs.interpolations();
        let mut columns = Vec::new();
        let mut between = Vec::new();
        for name in self.model.inputs() {
            if let Some(past) = self.model.past.iter().find(|p| p.input == *name) {
                columns.push(self.was(past, grid)?);
                between.push(Interpolation::Cubic);
            } else {
                let k = self
                    .outside
                    .iter()
                    .position(|n| n == name)
                    .unwrap_or_default();
                let values = grid.iter().map(|t| Ok(self.inputs.at(*t)?[k]));
                columns.push(values.collect::<Result<_, SindyError>>()?);
                between.push(given.get(k).copied().unwrap_or(Interpolation::Cubic));
            }
        }
        let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
        Inputs::sampled_each(grid, &columns, &between)
    }

    /// A past state over a grid, which lies before or after the start as a whole.
    fn was(&self, past: &Past, grid: &[f64]) -> Result<Vec<f64>, SindyError> {
        let state = self.model.states.iter().position(|s| *s == past.state);
        let state = state.unwrap_or_default();
        let (from, to) = (grid[0] - past.delay, grid[grid.len() - 1] - past.delay);
        if 0.5 * (from + to) < self.start {
            let reach = self.reach.unwrap_or(f64::NEG_INFINITY);
            let at =
                |t: &f64| Ok(self.before.at((t - past.delay).clamp(reach, self.start))?[state]);
            return grid.iter().map(at).collect();
        }
        let time = &self.known.time;
        let first = time.partition_point(|t| *t < from).saturating_sub(BESIDE);
        let last = (time.partition_point(|t| *t <= to) + BESIDE).min(time.len());
        let time = &time[first..last];
        let column = &self.known.states[state][first..last];
        let inputs = Inputs::sampled(time, &[column], Interpolation::Cubic)?;
        let (first, last) = (time[0], time[time.len() - 1]);
        let at = |t: &f64| Ok(inputs.at((t - past.delay).clamp(first, last))?[0]);
        grid.iter().map(at).collect()
    }
}
