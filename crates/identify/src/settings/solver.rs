//! Settings of solvers, and of how their fits are chosen.

use serde::{Deserialize, Serialize};
use sindy::{Criterion, SindyError, WeakForm};

/// A sparse solver.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SolverName {
    /// SR3 with ℓ0 over the grid of λ and ν.
    #[default]
    Sr3,
    /// Sequentially thresholded least squares over the grid of thresholds.
    Stlsq,
    /// The best subset of every size, exactly.
    BestSubset,
    /// One term more or less at a time, by the criterion.
    Stepwise,
    /// All terms.
    LeastSquares,
}

/// What fits are chosen by.
#[derive(Clone, Copy, Debug, Default, Deserialize, Eq, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum CriterionName {
    /// The fewest terms whose error on held-out trials is within one standard error of the smallest.
    #[default]
    LeftOut,
    /// Akaike's criterion.
    Aic,
    /// Akaike's criterion, corrected for few rows.
    Aicc,
    /// The Bayesian (Schwarz) criterion.
    Bic,
    /// Bayesian evidence.
    Evidence,
}

impl CriterionName {
    /// The information criterion; none for the error on held-out trials.
    #[must_use]
    pub fn criterion(self) -> Option<Criterion> {
        match self {
            Self::LeftOut => None,
            Self::Aic => Some(Criterion::Aic),
            Self::Aicc => Some(Criterion::Aicc),
            Self::Bic => Some(Criterion::Bic),
            Self::Evidence => Some(Criterion::Evidence),
        }
    }
}

/// Which solver regressions on derivatives use, and how its fit is chosen.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct ChoiceSettings {
    /// The solver.
    pub solver: SolverName,
    /// What its fits are compared by.
    pub criterion: CriterionName,
    /// Folds that trials are dealt into at random; 0 leaves out each trial in turn.
    pub folds: usize,
    /// Seed of the dealing.
    pub seed: u64,
    /// Rows that replace correlated ones in criteria; absent: all rows count.
    pub effective_rows: Option<f64>,
}

impl Default for ChoiceSettings {
    fn default() -> Self {
        Self {
            solver: SolverName::Sr3,
            criterion: CriterionName::LeftOut,
            folds: 0,
            seed: 1,
            effective_rows: None,
        }
    }
}

/// SR3 with ℓ0 on scaled columns.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Sr3Settings {
    /// Thresholds √(2 λ ν) on scaled coefficients, for SR3 and STLSQ.
    pub thresholds: Vec<f64>,
    /// Relaxations ν, relative to the scaled Gram diagonal.
    pub nus: Vec<f64>,
    /// One penalty λ in place of the grid of thresholds.
    pub lambda: Option<f64>,
    /// One ν in place of the grid.
    pub nu: Option<f64>,
}

impl Sr3Settings {
    /// All pairs of λ and ν.
    #[must_use]
    pub fn points(&self) -> Vec<(f64, f64)> {
        let nus = self.nu.map_or_else(|| self.nus.clone(), |nu| vec![nu]);
        let of_nu = |nu: f64| -> Vec<(f64, f64)> {
            match self.lambda {
                Some(lambda) => vec![(lambda, nu)],
                None => self
                    .thresholds
                    .iter()
                    .map(|eta| (eta * eta / (2.0 * nu), nu))
                    .collect(),
            }
        };
        nus.into_iter().flat_map(of_nu).collect()
    }
}

/// Eq. (6) to the letter: unscaled sums over all rows, the sparse vector taken as it is. The paper prints neither
/// λ nor ν; the defaults are PySINDy's.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct PublishedSettings {
    /// Threshold √(2 λ ν) on unscaled coefficients.
    pub threshold: f64,
    /// Relaxation ν.
    pub nu: f64,
}

impl Default for PublishedSettings {
    fn default() -> Self {
        Self {
            threshold: 0.1,
            nu: 1.0,
        }
    }
}

/// The weak form of eq. (9).
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct WeakSettings {
    /// Half-width of a window (s); absent: chosen from the data.
    pub half_width_s: Option<f64>,
    /// Distance of the windows' centres, in half-widths.
    pub spacing: f64,
    /// Power of the test functions.
    pub power: u32,
    /// Generalised in place of ordinary least squares.
    pub generalised: bool,
}

impl Default for WeakSettings {
    fn default() -> Self {
        Self {
            half_width_s: None,
            spacing: 0.125,
            power: 8,
            generalised: false,
        }
    }
}

impl WeakSettings {
    /// The weak form.
    ///
    /// # Errors
    /// A value out of range, by name.
    pub fn build(&self) -> std::result::Result<WeakForm, SindyError> {
        let form = WeakForm::default()
            .spacing(self.spacing)?
            .power(self.power)?
            .generalised(self.generalised);
        match self.half_width_s {
            Some(h) => form.half_width(h),
            None => Ok(form),
        }
    }
}

impl Default for Sr3Settings {
    fn default() -> Self {
        let grid = sindy::Grid::default();
        Self {
            thresholds: grid.thresholds,
            nus: grid.nus,
            lambda: None,
            nu: None,
        }
    }
}
