//! The terms that are tried.

use std::f64::consts::TAU;

use sindy_expr::Expr;

use crate::library::parse;
use crate::trajectory::output_error::Piece;

/// Waves in time, at most, by their number over the longest stretch.
const WAVES: usize = 24;
/// The name of time where no column of the data has it.
pub(super) const TIME: &str = "t";
/// Time constants of lags, in steps: those of an actuator that is sampled often enough to be seen.
const LAGS: [f64; 3] = [2.0, 6.0, 20.0];

/// Terms that are tried, and columns beside those of the data that some of them need.
pub(super) struct Others {
    /// Of states and inputs.
    pub shapes: Vec<Expr>,
    /// Of the columns.
    pub of_columns: Vec<Expr>,
    pub columns: Vec<Column>,
}

/// A column that is computed.
pub(super) struct Column {
    pub name: String,
    rule: Rule,
}

enum Rule {
    /// Time since a start.
    Since(f64),
    /// `y' = (u - y)/constant` for an input.
    Lag { input: usize, constant: f64 },
}

impl Column {
    /// Its values in the rows of a piece.
    pub(super) fn values(&self, piece: &Piece<'_>) -> Vec<f64> {
        match self.rule {
            Rule::Since(start) => piece.time.iter().map(|t| t - start).collect(),
            Rule::Lag { input, constant } => {
                let u = piece.inputs[input];
                let mut value = u.first().copied().unwrap_or(0.0);
                let steps = piece.time.windows(2).zip(u);
                let follow = |(times, u): (&[f64], &f64)| {
                    value += (1.0 - (-(times[1] - times[0]) / constant).exp()) * (u - value);
                    value
                };
                u.iter().take(1).copied().chain(steps.map(follow)).collect()
            }
        }
    }
}

impl Others {
    /// Shapes of variables of these standard deviations.
    pub(super) fn shapes(names: &[String], sizes: &[f64]) -> Self {
        Self {
            shapes: shapes(names, sizes),
            of_columns: Vec::new(),
            columns: Vec::new(),
        }
    }

    /// Time since a start, and waves of whole numbers over a span.
    pub(super) fn add_waves(&mut self, start: f64, span: f64) {
        let both = |k: usize| {
            let omega = rounded(TAU * k as f64 / span, 2);
            [
                format!("cos({omega}*{TIME})"),
                format!("sin({omega}*{TIME})"),
            ]
        };
        let waves = (1..=WAVES).flat_map(both);
        self.of_columns.push(Expr::variable(TIME));
        self.of_columns.extend(waves.filter_map(|w| parse(&w).ok()));
        self.columns.push(Column {
            name: TIME.to_owned(),
            rule: Rule::Since(start),
        });
    }

    /// Inputs of these standard deviations as slow actuators would follow them, of which rows are a step apart.
    pub(super) fn add_lags(&mut self, inputs: &[String], sizes: &[f64], step: f64) {
        let mut lags = Vec::new();
        for (input, name) in inputs.iter().enumerate().filter(|(i, _)| sizes[*i] > 0.0) {
            for steps in LAGS {
                let constant = rounded(steps * step, 1);
                let name = format!("{name} after a lag of {constant}");
                lags.push(Expr::variable(&name));
                self.columns.push(Column {
                    name,
                    rule: Rule::Lag { input, constant },
                });
            }
        }
        // First, where not all waves have room.
        lags.append(&mut self.of_columns);
        self.of_columns = lags;
    }
}

/// Shapes of one variable, and products of two and three, the simplest first. Kinks are where a variable is 0, and saturations
/// begin at its standard deviation.
fn shapes(names: &[String], sizes: &[f64]) -> Vec<Expr> {
    let moving: Vec<(String, f64)> = names
        .iter()
        .zip(sizes)
        .filter(|(_, size)| **size > 0.0 && size.is_finite())
        .map(|(name, size)| (Expr::variable(name).to_string(), rounded(*size, 1)))
        .collect();
    let mut texts = Vec::new();
    for (s, size) in &moving {
        texts.extend([
            s.clone(),
            format!("{s}^2"),
            format!("{s}^3"),
            format!("{s}*abs({s})"),
            format!("tanh({}*{s})", rounded(4.0 / size, 1)),
            format!("{s}/({size} + abs({s}))"),
            format!("abs({s})"),
            format!("{s}^4"),
            format!("{s}^5"),
        ]);
    }
    let others = |i: usize| moving[i + 1..].iter().map(move |b| (i, b));
    let pairs = || (0..moving.len()).flat_map(others);
    texts.extend(pairs().map(|(i, (r, _))| format!("{}*{r}", moving[i].0)));
    for (i, (r, other)) in pairs() {
        let (s, size) = &moving[i];
        texts.extend([
            format!("{s}^2*{r}"),
            format!("{s}*{r}^2"),
            format!("{s}*abs({r})"),
            format!("{r}*abs({s})"),
            format!("{s}*{r}/({size} + abs({s}))"),
            format!("{s}*{r}/({other} + abs({r}))"),
            format!("{s}^3*{r}"),
            format!("{s}^2*{r}^2"),
            format!("{s}*{r}^3"),
        ]);
    }
    for (i, (a, _)) in moving.iter().enumerate() {
        for (j, (b, _)) in moving.iter().enumerate().skip(i + 1) {
            let last = moving.iter().skip(j + 1);
            texts.extend(last.map(|(c, _)| format!("{a}*{b}*{c}")));
        }
    }
    // All are well formed: names are quoted where they must be.
    texts.iter().filter_map(|text| parse(text).ok()).collect()
}

/// To so many digits behind the first, which are enough for a shape.
fn rounded(value: f64, digits: usize) -> f64 {
    format!("{value:.digits$e}").parse().unwrap_or(value)
}
