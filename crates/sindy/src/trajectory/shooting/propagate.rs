//! Simulation of many windows side by side, with their sensitivities.
//!
//! All arrays are rows of `lanes` numbers, one lane per window, so that every operation runs over the
//! windows in vector registers.

use sindy_expr::Scratch;

use super::model::{Compiled, OdeModel};

/// Parts that a step of the data is split into at most: a hole of an hour is no reason to compute for an hour.
const MOST_PARTS: f64 = 100_000.0;

/// A stretch of data to simulate over.
#[derive(Clone, Copy)]
pub(crate) struct Window<'a> {
    pub(crate) time: &'a [f64],
    pub(crate) inputs: &'a [&'a [f64]],
    pub(crate) len: usize,
}

/// Called at every sample with: sample index, outputs (one a lane), their derivatives with respect to
/// the parameters (rows of lanes) and to the start values (rows of lanes).
pub(crate) type Sink<'s> = &'s mut dyn FnMut(usize, &[f64], &[f64], &[f64]);

/// A simulation of windows in lanes.
struct LaneRun<'a> {
    model: &'a OdeModel,
    lanes: usize,
    sensitive: bool,
    /// Input columns of the programs: states, inputs, parameters.
    columns: Vec<Vec<f64>>,
    flow_out: Vec<f64>,
    scratch: Scratch,
}

/// Simulates `windows` from `starts` (rows of lanes) to the end of the longest; a shorter window stands
/// still after its last sample.
pub(crate) fn run(
    model: &OdeModel,
    parameters: &[f64],
    windows: &[Window<'_>],
    starts: &[f64],
    sensitive: bool,
    sink: Sink<'_>,
) {
    let lanes = windows.len();
    let (n, m, p) = (model.states.len(), model.inputs.len(), parameters.len());
    let steps = windows.iter().map(|w| w.len).max().unwrap_or(0);
    let mut columns = vec![vec![0.0; lanes]; n + m];
    columns.extend(parameters.iter().map(|&v| vec![v; lanes]));
    let flow_columns = model
        .flow
        .program
        .outputs()
        .max(model.output.program.outputs());
    let mut run = LaneRun {
        model,
        lanes,
        sensitive,
        columns,
        flow_out: vec![0.0; flow_columns * lanes],
        scratch: Scratch::default(),
    };
    // Rows: n states, then n x p parameter sensitivities, then n x n start sensitivities.
    let rows = if sensitive { n * (1 + p + n) } else { n };
    let mut z = vec![0.0; rows * lanes];
    z[..n * lanes].copy_from_slice(starts);
    if sensitive {
        for i in 0..n {
            let row = n + n * p + i * n + i;
            z[row * lanes..(row + 1) * lanes].fill(1.0);
        }
    }
    let mut stages = Stages {
        k: vec![vec![0.0; rows * lanes]; 4],
        at: vec![0.0; rows * lanes],
    };
    let mut dt = vec![0.0; lanes];
    let mut dy_p = vec![0.0; p * lanes];
    let mut dy_0 = vec![0.0; n * lanes];
    for step in 0..steps {
        run.set_inputs(windows, step, 0.0);
        run.output(&z, &mut dy_p, &mut dy_0);
        sink(step, &run.flow_out[..lanes], &dy_p, &dy_0);
        if step + 1 == steps || n == 0 {
            continue;
        }
        for (dt, w) in dt.iter_mut().zip(windows) {
            *dt = if step + 1 < w.len {
                w.time[step + 1] - w.time[step]
            } else {
                0.0
            };
        }
        // A hole in the data, or slow sampling, is crossed in steps that the model can take.
        let longest = dt.iter().copied().fold(0.0, f64::max);
        let parts = (longest / model.max_step).ceil().clamp(1.0, MOST_PARTS);
        dt.iter_mut().for_each(|dt| *dt /= parts);
        for part in 0..parts as usize {
            let at_fraction = |share: f64| (part as f64 + share) / parts;
            if part > 0 {
                run.set_inputs(windows, step, at_fraction(0.0));
            }
            run.runge_kutta(&mut z, &dt, &mut stages, |run, share| {
                run.set_inputs(windows, step, at_fraction(share));
            });
        }
    }
}

/// The slopes of a Runge–Kutta step, and the point at which the next is taken.
struct Stages {
    k: Vec<Vec<f64>>,
    at: Vec<f64>,
}

/// `at = z + share * dt * k`, lane by lane.
fn advance(at: &mut [f64], z: &[f64], k: &[f64], dt: &[f64], share: f64) {
    let rows = z.chunks_exact(dt.len()).zip(k.chunks_exact(dt.len()));
    for (at, (z, k)) in at.chunks_exact_mut(dt.len()).zip(rows) {
        for lane in 0..dt.len() {
            at[lane] = z[lane] + share * dt[lane] * k[lane];
        }
    }
}

impl LaneRun<'_> {
    /// One step of the fourth-order Runge–Kutta method; the inputs are those of the step's start.
    fn runge_kutta(
        &mut self,
        z: &mut [f64],
        dt: &[f64],
        Stages { k, at }: &mut Stages,
        set_inputs: impl Fn(&mut Self, f64),
    ) {
        self.derivative(z, &mut k[0]);
        set_inputs(self, 0.5);
        for (stage, share) in [(1, 0.5), (2, 0.5), (3, 1.0)] {
            if stage == 3 {
                set_inputs(self, 1.0);
            }
            let (done, rest) = k.split_at_mut(stage);
            advance(at, z, &done[stage - 1], dt, share);
            self.derivative(at, &mut rest[0]);
        }
        for (row, z) in z.chunks_exact_mut(dt.len()).enumerate() {
            for (lane, z) in z.iter_mut().enumerate() {
                let i = row * dt.len() + lane;
                *z += dt[lane] / 6.0 * (k[0][i] + 2.0 * (k[1][i] + k[2][i]) + k[3][i]);
            }
        }
    }

    /// Sets the input columns to the data between samples `step` and `step + 1`.
    fn set_inputs(&mut self, windows: &[Window<'_>], step: usize, fraction: f64) {
        let n = self.model.states.len();
        for (lane, w) in windows.iter().enumerate() {
            let (a, b) = (step.min(w.len - 1), (step + 1).min(w.len - 1));
            for (j, input) in w.inputs.iter().enumerate() {
                self.columns[n + j][lane] = if fraction == 0.0 {
                    input[a]
                } else {
                    (1.0 - fraction) * input[a] + fraction * input[b]
                };
            }
        }
    }

    /// Evaluates a compiled function at the states of `z`; the result is in `flow_out`.
    fn evaluate(&mut self, which: fn(&OdeModel) -> &Compiled, z: &[f64]) {
        let n = self.model.states.len();
        for (column, row) in self.columns[..n].iter_mut().zip(z.chunks_exact(self.lanes)) {
            column.copy_from_slice(row);
        }
        let compiled = which(self.model);
        let program = if self.sensitive {
            &compiled.program
        } else {
            &compiled.values
        };
        let columns: Vec<&[f64]> = self.columns.iter().map(Vec::as_slice).collect();
        let out = &mut self.flow_out[..program.outputs() * self.lanes];
        program.eval_block(&columns, out, &mut self.scratch);
    }

    /// `dz` of states and sensitivities: `S' = ∂f/∂x S + ∂f/∂θ`.
    fn derivative(&mut self, z: &[f64], dz: &mut [f64]) {
        self.evaluate(|m| &m.flow, z);
        let (n, p, lanes) = (
            self.model.states.len(),
            self.model.parameters.len(),
            self.lanes,
        );
        dz[..n * lanes].copy_from_slice(&self.flow_out[..n * lanes]);
        if !self.sensitive {
            return;
        }
        dz[n * lanes..].fill(0.0);
        let flow = &self.model.flow;
        for &(row, state, column) in &flow.by_state {
            let j = &self.flow_out[column * lanes..(column + 1) * lanes];
            for (width, base) in [(p, n), (n, n + n * p)] {
                for c in 0..width {
                    let from = (base + state * width + c) * lanes;
                    let to = (base + row * width + c) * lanes;
                    for lane in 0..lanes {
                        dz[to + lane] += j[lane] * z[from + lane];
                    }
                }
            }
        }
        for &(row, parameter, column) in &flow.by_parameter {
            let to = (n + row * p + parameter) * lanes;
            let j = &self.flow_out[column * lanes..(column + 1) * lanes];
            for lane in 0..lanes {
                dz[to + lane] += j[lane];
            }
        }
    }

    /// The output (in `flow_out`) and, with sensitivities, its derivatives.
    fn output(&mut self, z: &[f64], dy_p: &mut [f64], dy_0: &mut [f64]) {
        self.evaluate(|m| &m.output, z);
        if !self.sensitive {
            return;
        }
        let (n, p, lanes) = (
            self.model.states.len(),
            self.model.parameters.len(),
            self.lanes,
        );
        dy_p.fill(0.0);
        dy_0.fill(0.0);
        let output = &self.model.output;
        for &(_, state, column) in &output.by_state {
            let j = &self.flow_out[column * lanes..(column + 1) * lanes];
            for (width, base, dy) in [(p, n, &mut *dy_p), (n, n + n * p, &mut *dy_0)] {
                for c in 0..width {
                    let from = (base + state * width + c) * lanes;
                    for lane in 0..lanes {
                        dy[c * lanes + lane] += j[lane] * z[from + lane];
                    }
                }
            }
        }
        for &(_, parameter, column) in &output.by_parameter {
            let j = &self.flow_out[column * lanes..(column + 1) * lanes];
            for lane in 0..lanes {
                dy_p[parameter * lanes + lane] += j[lane];
            }
        }
    }
}
