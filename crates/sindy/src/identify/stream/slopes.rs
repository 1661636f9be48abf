//! How slopes are taken, decided by the first rows.

use serde::{Deserialize, Serialize};

use super::pass::WINDOW;
use crate::data::grid::uniform_period;
use crate::derivative::savgol::{SavitzkyGolay, Smoothed};
use crate::derivative::{Differentiator, FiniteDifference, SavgolSearch, choose_savgol};
use crate::error::SindyError;
use crate::identify::{Settings, Smoothing};
use crate::numerics::upper_median;
use crate::weak::choose_half_width;

/// Rows below which a stretch does not identify its smoothing.
const SMOOTHED: usize = 48;
/// Rows from the end of a window beyond which a spline or a Kalman smoother does not depend on it: their weights fall
/// exponentially, to below rounding over this number of rows.
const REACH: usize = 200;
/// Rows at the ends of a stretch whose slopes by a spline or a Kalman smoother err more, and do not count.
const EDGE: usize = 5;
/// The power of the weak form's test functions, as without streaming.
const POWER: u32 = 8;

/// A stretch: times and states.
pub(super) type Series<'a> = (&'a [f64], Vec<&'a [f64]>);

/// Methods of differentiation as settings write them, and built from that.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Vec<Smoothing>", into = "Vec<Smoothing>")]
struct Methods {
    written: Vec<Smoothing>,
    built: Vec<Differentiator>,
}

impl From<Methods> for Vec<Smoothing> {
    fn from(methods: Methods) -> Self {
        methods.written
    }
}

impl TryFrom<Vec<Smoothing>> for Methods {
    type Error = SindyError;

    fn try_from(written: Vec<Smoothing>) -> Result<Self, SindyError> {
        let build = |one: &Smoothing| {
            let expected = "a method with its strength";
            one.differentiator()?
                .ok_or_else(|| SindyError::setting("smoothing", expected, format!("{one:?}")))
        };
        Ok(Self {
            built: written.iter().map(build).collect::<Result<_, _>>()?,
            written,
        })
    }
}

/// One way to take slopes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Slopes {
    /// For tables.
    pub name: String,
    /// One for each state; none in discrete time.
    methods: Methods,
    /// Rows at each end of a stretch whose slopes err more.
    pub edge: usize,
    /// Rows whose slopes are alike.
    pub window: f64,
}

/// The decisions from the first rows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Plan {
    /// The first smooths the trajectories too.
    pub slopes: Vec<Slopes>,
    /// Half-width of the weak form, where it is asked for.
    pub half_width: Option<f64>,
    /// Rows that windows share.
    pub overlap: usize,
    /// The median step of time.
    pub period: f64,
    pub uniform: bool,
    /// The rows that decided.
    pub head: usize,
    /// By slopes, then library: whether the triangular factor is accumulated. None where no row decided.
    pub triangles: Vec<Option<Vec<bool>>>,
}

impl Plan {
    /// Rows that are differentiated at a time.
    pub(super) fn window(&self) -> usize {
        WINDOW.max(8 * self.overlap)
    }

    /// Whether there is a method for each of so many states.
    pub(super) fn fits(&self, states: usize, discrete: bool) -> bool {
        let methods = if discrete { 0 } else { states };
        self.triangles.len() == self.slopes.len()
            && !self.slopes.is_empty()
            && self.slopes.iter().all(|s| s.methods.built.len() == methods)
    }
}

impl Slopes {
    /// States smoothed, and their slopes; stretches too short for the method are differenced.
    pub(super) fn apply(
        &self,
        time: &[f64],
        states: &[&[f64]],
    ) -> Result<Vec<Smoothed>, SindyError> {
        if self.methods.built.is_empty() {
            let next = |x: &&[f64]| Smoothed {
                value: x.to_vec(),
                // "Slope": the next sample. The last row of a stretch has none and is left out as its edge.
                derivative: x[1..].iter().copied().chain([f64::NAN]).collect(),
            };
            return Ok(states.iter().map(next).collect());
        }
        let pairs = self.methods.built.iter().zip(states);
        pairs
            .map(|(method, x)| match method.apply(time, x) {
                Err(SindyError::TooShort { .. }) => FiniteDifference::new(2)?.apply(time, x),
                other => other,
            })
            .collect()
    }

    fn of(method: Smoothing, states: usize) -> Result<Self, SindyError> {
        let (name, edge) = match method {
            Smoothing::SavitzkyGolay { window, degree } => {
                let name = format!("Savitzky–Golay, window {window}, degree {degree}");
                (name, window / 2)
            }
            Smoothing::FiniteDifference { order } => {
                (format!("finite differences of order {order}"), 0)
            }
            Smoothing::Kalman => ("Kalman smoother by maximum likelihood".into(), EDGE),
            Smoothing::Spline | Smoothing::Automatic | Smoothing::Weak => {
                ("smoothing spline by cross-validation".into(), EDGE)
            }
        };
        Ok(Self {
            name,
            methods: vec![method; states].try_into()?,
            edge,
            window: (2 * edge + 1) as f64,
        })
    }

    /// Rows from the end of a window beyond which slopes do not feel it.
    fn reach(&self) -> usize {
        let local = |m: &Differentiator| {
            matches!(
                m,
                Differentiator::SavitzkyGolay(_) | Differentiator::FiniteDifference(_)
            )
        };
        match self.methods.built.iter().all(local) {
            true => self.edge.max(8),
            false => REACH,
        }
    }
}

/// Savitzky–Golay filters with windows from the data, for each factor in `wider` once.
fn filters(
    head: &[Series<'_>],
    states: usize,
    wider: &[f64],
) -> Result<Option<Vec<Slopes>>, SindyError> {
    let longest = head.iter().map(|s| s.0.len()).max().unwrap_or(0);
    let long = |s: &&Series<'_>| s.0.len() >= SMOOTHED.max(longest / 10);
    let mut chosen = Vec::new();
    for i in 0..states {
        let series: Vec<(&[f64], &[f64])> =
            head.iter().filter(long).map(|s| (s.0, s.1[i])).collect();
        if series.is_empty() {
            return Ok(None);
        }
        chosen.push(choose_savgol(&series, &SavgolSearch::default())?.filter);
    }
    let most = (longest.max(SMOOTHED) - 1) / 2 * 2 - 1;
    let of = |factor: &f64| -> Result<Slopes, SindyError> {
        let filters: Vec<SavitzkyGolay> = chosen
            .iter()
            .map(|f| {
                let window = (f.window() as f64 * factor / 2.0) as usize * 2 + 1;
                let least = f.degree() / 2 * 2 + 3;
                SavitzkyGolay::new(window.clamp(least, most.max(least)), f.degree())
            })
            .collect::<Result<_, _>>()?;
        let widest = filters.iter().map(SavitzkyGolay::window).max().unwrap_or(1);
        let text: Vec<String> = filters
            .iter()
            .map(|f| format!("{}/{}", f.window(), f.degree()))
            .collect();
        let written = filters.iter().map(|f| Smoothing::SavitzkyGolay {
            window: f.window(),
            degree: f.degree(),
        });
        Ok(Slopes {
            name: format!("Savitzky–Golay, window/degree {}", text.join(", ")),
            methods: written.collect::<Vec<_>>().try_into()?,
            edge: widest / 2,
            window: widest as f64,
        })
    };
    wider.iter().map(of).collect::<Result<_, _>>().map(Some)
}

/// Decides by the stretches of the first rows; `most` rows are a window of the weak form at most.
pub(super) fn choose(
    head: &[Series<'_>],
    settings: &Settings,
    most: usize,
) -> Result<Plan, SindyError> {
    let states = head.first().map_or(0, |s| s.1.len());
    let mut steps: Vec<f64> = Vec::new();
    let mut periods = Vec::new();
    for (time, _) in head {
        steps.extend(time.windows(2).map(|w| w[1] - w[0]));
        periods.push(uniform_period(time));
    }
    let period = upper_median(&mut steps).unwrap_or(f64::NAN);
    let uniform = periods.iter().all(|p| alike(*p, period));
    let mut plan = Plan {
        slopes: Vec::new(),
        half_width: None,
        overlap: 0,
        period,
        uniform,
        head: 0,
        triangles: Vec::new(),
    };
    if settings.discrete {
        plan.slopes.push(Slopes {
            name: "none (discrete time)".into(),
            methods: Vec::new().try_into()?,
            edge: 0,
            window: 1.0,
        });
    } else if settings.smoothing.differentiator()?.is_some() {
        plan.slopes.push(Slopes::of(settings.smoothing, states)?);
    } else {
        let wider: &[f64] = match settings.smoothing {
            Smoothing::Automatic => &[1.0, 2.0],
            _ => &[1.0],
        };
        let found = match uniform {
            true => filters(head, states, wider)?,
            false => None,
        };
        plan.slopes = match found {
            Some(slopes) => slopes,
            None => vec![Slopes::of(Smoothing::Spline, states)?],
        };
        let series: Vec<(&[f64], &[f64])> = head
            .iter()
            .filter(|s| s.0.len() >= SMOOTHED)
            .flat_map(|s| s.1.iter().map(|x| (s.0, *x)))
            .collect();
        if !series.is_empty() {
            let widest = period * most as f64 / 2.0;
            plan.half_width = Some(choose_half_width(&series, POWER)?.min(widest));
        }
    }
    plan.overlap = plan.slopes.iter().map(Slopes::reach).max().unwrap_or(1);
    Ok(plan)
}

/// Whether a stretch has this period.
pub(super) fn alike(found: Option<f64>, period: f64) -> bool {
    found.is_some_and(|p| (p / period - 1.0).abs() < 1e-3)
}
