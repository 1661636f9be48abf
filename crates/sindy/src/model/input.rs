//! The inputs `u(t)` of a simulation: constants, samples with interpolation, or expressions of t.

use sindy_expr::{Program, Scratch};

use crate::error::{SindyError, finite, same_size};
use crate::library::{compile, parse};
use crate::numerics::{hermite, spline_slopes};

/// Interpolation of an input between two samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Interpolation {
    /// The value of the sample before (that of a digital actuator). Integration never steps across a
    /// jump.
    ZeroOrderHold,
    /// A straight line between the samples. Integration never steps across a kink.
    Linear,
    /// The twice continuously differentiable cubic spline through the samples, "not a knot" at its ends
    /// (de Boor, *A Practical Guide to Splines*, 1978, ch. IV); the parabola through 3 samples, the line
    /// through 2.
    Cubic,
}

/// Inputs over time, in the order of the model's inputs.
#[derive(Clone, Debug)]
pub struct Inputs {
    kind: InputSignal,
}

#[derive(Clone, Debug)]
enum InputSignal {
    Constant(Vec<f64>),
    Formula(Program),
    Sampled {
        time: Vec<f64>,
        columns: Vec<Vec<f64>>,
        /// For cubic interpolation, the slopes at the samples.
        slopes: Vec<Vec<f64>>,
        /// One for each column.
        how: Vec<Interpolation>,
    },
}

impl Inputs {
    /// For a model without inputs.
    #[must_use]
    pub fn none() -> Self {
        Self {
            kind: InputSignal::Constant(Vec::new()),
        }
    }

    /// Inputs that do not change.
    ///
    /// # Errors
    /// A value that is not finite.
    pub fn constant(values: &[f64]) -> Result<Self, SindyError> {
        finite("inputs", values)?;
        Ok(Self {
            kind: InputSignal::Constant(values.to_vec()),
        })
    }

    /// Inputs as expressions of the time `t`, such as `0.5*sin(2*pi*t)`.
    ///
    /// # Errors
    /// An expression that does not parse or uses a name other than `t`.
    pub fn formulas<S: AsRef<str>>(expressions: &[S]) -> Result<Self, SindyError> {
        let exprs = expressions
            .iter()
            .map(|text| parse(text.as_ref()))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Self {
            kind: InputSignal::Formula(compile(&exprs, &["t"])?),
        })
    }

    /// Inputs from samples: one column per input, each with one value per time. They are known from the
    /// first sample to the last, both included, and nowhere else.
    ///
    /// # Errors
    /// Fewer than 2 samples, time that does not increase, columns of another length, or values that are
    /// not finite.
    pub fn sampled(
        time: &[f64],
        columns: &[&[f64]],
        how: Interpolation,
    ) -> Result<Self, SindyError> {
        Self::sampled_each(time, columns, &vec![how; columns.len()])
    }

    /// The same with an interpolation for each column.
    ///
    /// # Errors
    /// As [`Self::sampled`], and a number of interpolations other than that of columns.
    pub fn sampled_each(
        time: &[f64],
        columns: &[&[f64]],
        how: &[Interpolation],
    ) -> Result<Self, SindyError> {
        same_size("interpolations of inputs", columns.len(), how.len())?;
        if time.len() < 2 {
            return Err(SindyError::too_short(2, time.len()));
        }
        increasing("input time", time)?;
        for (i, column) in columns.iter().enumerate() {
            same_size("rows of an input", time.len(), column.len())?;
            finite(&format!("input {i}"), column)?;
        }
        let slopes = columns.iter().zip(how).map(|(c, how)| match how {
            Interpolation::Cubic => spline_slopes(time, c),
            _ => Vec::new(),
        });
        let slopes = slopes.collect();
        Ok(Self {
            kind: InputSignal::Sampled {
                time: time.to_vec(),
                columns: columns.iter().map(|c| c.to_vec()).collect(),
                slopes,
                how: how.to_vec(),
            },
        })
    }

    /// The number of inputs.
    #[must_use]
    pub fn len(&self) -> usize {
        match &self.kind {
            InputSignal::Constant(values) => values.len(),
            InputSignal::Formula(program) => program.outputs(),
            InputSignal::Sampled { columns, .. } => columns.len(),
        }
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The inputs' values at time `t`; at a jump of a zero-order hold, those after it.
    ///
    /// # Errors
    /// A time outside the samples.
    pub fn at(&self, t: f64) -> Result<Vec<f64>, SindyError> {
        self.check_span(t, t)?;
        let mut out = vec![0.0; self.len()];
        let mut drive = self.drive();
        drive.enter(t, t);
        drive.eval(t, &mut out);
        Ok(out)
    }

    /// That the inputs are known from `start` to `end`.
    pub(super) fn check_span(&self, start: f64, end: f64) -> Result<(), SindyError> {
        if let InputSignal::Sampled { time, .. } = &self.kind
            && let [first, .., last] = time[..]
            && !(first <= start && end <= last)
        {
            let expected = format!("times within those of the inputs, {first} to {last}");
            return Err(SindyError::setting(
                "time",
                expected,
                format!("{start} to {end}"),
            ));
        }
        Ok(())
    }

    /// Times strictly between `start` and `end` where the inputs are not smooth.
    pub(super) fn breaks(&self, start: f64, end: f64) -> &[f64] {
        match &self.kind {
            InputSignal::Sampled { time, how, .. }
                if how.iter().any(|h| *h != Interpolation::Cubic) =>
            {
                let from = time.partition_point(|&t| t <= start);
                let to = time.partition_point(|&t| t < end).max(from);
                &time[from..to]
            }
            _ => &[],
        }
    }

    /// Times strictly between `start` and `end` at which there are samples.
    pub(super) fn samples(&self, start: f64, end: f64) -> &[f64] {
        let InputSignal::Sampled { time, .. } = &self.kind else {
            return &[];
        };
        let from = time.partition_point(|&t| t <= start);
        let to = time.partition_point(|&t| t < end).max(from);
        &time[from..to]
    }

    /// What sampled inputs are between their samples; empty for others.
    pub(super) fn interpolations(&self) -> &[Interpolation] {
        match &self.kind {
            InputSignal::Sampled { how, .. } => how,
            _ => &[],
        }
    }

    pub(super) fn drive(&self) -> Drive<'_> {
        Drive {
            inputs: self,
            index: 0,
            scratch: Scratch::new(),
        }
    }
}

/// Evaluates inputs along a run.
#[derive(Debug)]
pub(super) struct Drive<'i> {
    inputs: &'i Inputs,
    /// The interval between two samples that holds the time.
    index: usize,
    scratch: Scratch,
}

impl Drive<'_> {
    /// Announces evaluations within `[start, end]`, which has no break inside: at its ends the inputs
    /// are the limits from inside.
    pub(super) fn enter(&mut self, start: f64, end: f64) {
        if let InputSignal::Sampled { time, how, .. } = &self.inputs.kind {
            let middle = start + 0.5 * (end - start);
            // The last sample of a hold has no interval after it.
            let alone = how.contains(&Interpolation::ZeroOrderHold)
                && start == end
                && end == time[time.len() - 1];
            self.index = if alone {
                time.len() - 1
            } else {
                interval(time, middle)
            };
        }
    }

    pub(super) fn eval(&mut self, t: f64, out: &mut [f64]) {
        match &self.inputs.kind {
            InputSignal::Constant(values) => out.copy_from_slice(values),
            InputSignal::Formula(program) => program.eval_row(&[t], out, &mut self.scratch),
            InputSignal::Sampled {
                time,
                columns,
                slopes,
                how,
            } => {
                // Splines have no breaks, so that a run's step may leave the interval.
                if how.iter().all(|h| *h == Interpolation::Cubic)
                    && !(time[self.index] <= t && t <= time[self.index + 1])
                {
                    self.index = interval(time, t);
                }
                let i = self.index;
                // Only of a hold is the last sample alone asked for.
                let next = (i + 1).min(time.len() - 1);
                let h = time[next] - time[i];
                let s = if next > i { (t - time[i]) / h } else { 0.0 };
                for (k, (out, column)) in out.iter_mut().zip(columns).enumerate() {
                    let (a, b) = (column[i], column[next]);
                    *out = match how[k] {
                        Interpolation::ZeroOrderHold => a,
                        Interpolation::Linear => a + s * (b - a),
                        Interpolation::Cubic => {
                            hermite(a, b, h * slopes[k][i], h * slopes[k][next], s)
                        }
                    };
                }
            }
        }
    }
}

/// Index i with `time[i] <= t < time[i+1]`, the last interval for the last time.
fn interval(time: &[f64], t: f64) -> usize {
    time.partition_point(|&knot| knot <= t)
        .saturating_sub(1)
        .min(time.len() - 2)
}

/// Requires finite, strictly increasing times.
pub(super) fn increasing(what: &str, time: &[f64]) -> Result<(), SindyError> {
    finite(what, time)?;
    match time.windows(2).position(|w| w[1] <= w[0]) {
        None => Ok(()),
        Some(i) => Err(SindyError::TimeNotIncreasing { index: i + 1 }),
    }
}
