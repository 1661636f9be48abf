//! Methods of differentiation from their description.

use serde::Deserialize;
use sindy::derivative::{
    Cutoff, Ends, FiniteDifference, KalmanSmoother, Motion, SavgolSearch, SmoothingSpline,
    Spectral, choose_savgol,
};
use sindy::{Dataset, Differentiator, SavitzkyGolay, SindyError};

/// Degree of a Savitzky–Golay filter of which only the window is given.
const DEGREE: usize = 3;

/// A method of differentiation as the Python side describes it. What is not given follows from the data.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(crate) enum Description {
    /// A Savitzky–Golay filter, and a smoothing spline where times are not uniform or a stretch is too short to choose from.
    Automatic {},
    FiniteDifference {
        order: usize,
    },
    SavitzkyGolay {
        window: Option<usize>,
        degree: Option<usize>,
    },
    Spline {
        lam: Option<f64>,
    },
    Kalman {
        motion: MotionName,
        ratio: Option<f64>,
    },
    Spectral {
        cutoff: CutoffName,
        ends: EndsName,
    },
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum MotionName {
    ConstantVelocity,
    ConstantAcceleration,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum CutoffName {
    None,
    CrossValidated,
    Frequency(f64),
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum EndsName {
    Periodic,
    Reflected,
}

impl Description {
    /// What differentiates state `i` of the data.
    ///
    /// # Errors
    /// A setting outside its range, or data from which nothing can be chosen.
    pub(crate) fn of(self, data: &Dataset, i: usize) -> Result<Differentiator, SindyError> {
        Ok(match self {
            Self::Automatic {} => automatic(data, i)?,
            Self::FiniteDifference { order } => FiniteDifference::new(order)?.into(),
            Self::SavitzkyGolay {
                window: Some(window),
                degree,
            } => SavitzkyGolay::new(window, degree.unwrap_or(DEGREE))?.into(),
            Self::SavitzkyGolay {
                window: None,
                degree,
            } => chosen(data, i, degree)?,
            Self::Spline { lam: Some(lam) } => SmoothingSpline::new(lam)?.into(),
            Self::Spline { lam: None } => SmoothingSpline::cross_validated().into(),
            Self::Kalman { motion, ratio } => {
                let motion = match motion {
                    MotionName::ConstantVelocity => Motion::ConstantVelocity,
                    MotionName::ConstantAcceleration => Motion::ConstantAcceleration,
                };
                match ratio {
                    Some(ratio) => KalmanSmoother::new(motion, ratio)?.into(),
                    None => KalmanSmoother::maximum_likelihood(motion).into(),
                }
            }
            Self::Spectral { cutoff, ends } => {
                let cutoff = match cutoff {
                    CutoffName::None => Cutoff::None,
                    CutoffName::CrossValidated => Cutoff::CrossValidated,
                    CutoffName::Frequency(frequency) => Cutoff::Frequency(frequency),
                };
                let ends = match ends {
                    EndsName::Periodic => Ends::Periodic,
                    EndsName::Reflected => Ends::Reflected,
                };
                Spectral::new(ends, cutoff)?.into()
            }
        })
    }
}

fn automatic(data: &Dataset, i: usize) -> Result<Differentiator, SindyError> {
    let spline = || SmoothingSpline::cross_validated().into();
    if !data.report().uniform {
        return Ok(spline());
    }
    match chosen(data, i, None) {
        Err(SindyError::TooShort { .. }) => Ok(spline()),
        found => found,
    }
}

/// The Savitzky–Golay filter whose slope has the least error by the data, among those of a degree if one is given.
fn chosen(data: &Dataset, i: usize, degree: Option<usize>) -> Result<Differentiator, SindyError> {
    let stretches = data.stretches();
    let series: Vec<(&[f64], &[f64])> = stretches.iter().map(|s| (s.time, s.columns[i])).collect();
    let search = match degree {
        Some(degree) => SavgolSearch::default().degrees(&[degree])?,
        None => SavgolSearch::default(),
    };
    Ok(choose_savgol(&series, &search)?.filter.into())
}
