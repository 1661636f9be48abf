//! The model that is refined: expressions, compiled with their derivatives.

use sindy_expr::{Expr, Program};

use crate::error::{SindyError, same_size};
use crate::library::{compile, parse};

/// `x' = f(x, u, θ)`, `y = g(x, u, θ)` as expressions over named states, inputs and parameters.
#[derive(Clone, Debug)]
pub struct OdeModel {
    pub(crate) states: Vec<String>,
    pub(crate) inputs: Vec<String>,
    pub(crate) parameters: Vec<String>,
    pub(crate) flow: Compiled,
    pub(crate) output: Compiled,
    pub(crate) max_step: f64,
}

/// Functions of (states, inputs, parameters) with those of their derivatives that are not zero.
#[derive(Clone, Debug)]
pub(crate) struct Compiled {
    /// Outputs: the values first, then the entries named in `by_state` and `by_parameter`.
    pub(crate) program: Program,
    /// (row of the function, state, column of the program's output).
    pub(crate) by_state: Vec<(usize, usize, usize)>,
    /// (row of the function, parameter, column of the program's output).
    pub(crate) by_parameter: Vec<(usize, usize, usize)>,
    /// The values alone, for runs without sensitivities.
    pub(crate) values: Program,
}

impl Compiled {
    fn new(exprs: &[Expr], names: &[&str], n: usize, m: usize) -> Result<Self, SindyError> {
        let mut all = exprs.to_vec();
        let (mut by_state, mut by_parameter) = (Vec::new(), Vec::new());
        let zero = Expr::constant(0.0);
        for (row, expr) in exprs.iter().enumerate() {
            for (index, name) in names.iter().enumerate() {
                if (n..n + m).contains(&index) {
                    continue;
                }
                let d = expr.derivative(name);
                if d == zero {
                    continue;
                }
                if index < n {
                    by_state.push((row, index, all.len()));
                } else {
                    by_parameter.push((row, index - n - m, all.len()));
                }
                all.push(d);
            }
        }
        Ok(Self {
            program: compile(&all, names)?,
            by_state,
            by_parameter,
            values: compile(exprs, names)?,
        })
    }
}

impl OdeModel {
    /// Parses and compiles a model: one right-hand side per state, one output.
    ///
    /// # Errors
    /// An expression that does not parse, an unknown name, or a wrong number of right-hand sides.
    pub fn new(
        states: &[&str],
        inputs: &[&str],
        parameters: &[&str],
        rhs: &[&str],
        output: &str,
    ) -> Result<Self, SindyError> {
        same_size("right-hand sides (one per state)", states.len(), rhs.len())?;
        let names: Vec<&str> = [states, inputs, parameters].concat();
        let rhs = rhs
            .iter()
            .map(|t| parse(t))
            .collect::<Result<Vec<_>, _>>()?;
        let (n, m) = (states.len(), inputs.len());
        let own = |v: &[&str]| v.iter().map(ToString::to_string).collect();
        Ok(Self {
            states: own(states),
            inputs: own(inputs),
            parameters: own(parameters),
            flow: Compiled::new(&rhs, &names, n, m)?,
            output: Compiled::new(&[parse(output)?], &names, n, m)?,
            max_step: f64::INFINITY,
        })
    }

    /// The same model, integrated in steps of at most `max_step` (the data's time unit). Without it a step of the data
    /// is one step of the integration, which is unstable where the data are slow, or have a hole, compared with the
    /// model's fastest time constant: take half of that.
    ///
    /// # Errors
    /// A step that is not above 0.
    pub fn with_max_step(self, max_step: f64) -> Result<Self, SindyError> {
        if max_step > 0.0 {
            return Ok(Self { max_step, ..self });
        }
        Err(SindyError::setting(
            "max_step",
            "a number above 0",
            max_step,
        ))
    }

    /// The parameters' names, in order.
    #[must_use]
    pub fn parameters(&self) -> &[String] {
        &self.parameters
    }

    /// The inputs' names, in order.
    #[must_use]
    pub fn inputs(&self) -> &[String] {
        &self.inputs
    }

    /// Simulates the output over a whole record from one start: fourth-order Runge–Kutta on the
    /// record's own time grid (finer where [`Self::with_max_step`] says so), inputs interpolated linearly. A run that blows up continues as NaN.
    ///
    /// # Errors
    /// Parameters, start or inputs that do not fit the model, or inputs of unequal length.
    pub fn free_run(
        &self,
        parameters: &[f64],
        start: &[f64],
        time: &[f64],
        inputs: &[&[f64]],
    ) -> Result<Vec<f64>, SindyError> {
        same_size("parameters", self.parameters.len(), parameters.len())?;
        same_size("start values", self.states.len(), start.len())?;
        same_size("inputs", self.inputs.len(), inputs.len())?;
        for column in inputs {
            same_size("rows of an input", time.len(), column.len())?;
        }
        let mut out = Vec::with_capacity(time.len());
        let window = [super::propagate::Window {
            time,
            inputs,
            len: time.len(),
        }];
        super::propagate::run(
            self,
            parameters,
            &window,
            start,
            false,
            &mut |_, y, _, _| {
                out.push(y[0]);
            },
        );
        Ok(out)
    }
}
