//! The result of every armed interval.

use std::fmt;

use serde::Serialize;
use statrs::distribution::{ContinuousCDF as _, StudentsT};

use super::armed_interval::ArmedInterval;
use super::coverage::CURVE_NEAR_RADII;
use super::ground::GroundEffect;
use super::model::{Curve, Segment};
use super::phases::{Phase, Phases};
use super::resampling::correlation_inflation;
use super::rest::{ENDS_S, REST_MPS};
use super::segments::HOVER_FORCE;
use super::{Flight, FlightSettings};
use crate::estimate::Estimate;
use crate::fitted::range;

/// Shortest steady hover (s). Its ends are excluded, as those of hovers at rest are.
/// Its ends take 0.7 s: shorter hovers leave no rows.
const STEADY_S: f64 = 1.0;
/// Fewest rows near the ground, and far from it, that a mean is taken of.
/// The least count with a variance.
const FEWEST: usize = 3;
/// Extra lift is that above so many rotor radii, which vehicles with legs reach too, and below [`CURVE_NEAR_RADII`].
/// Half would ask for heights that vehicles with legs never reach.
const NEAREST_RADII: f64 = 1.25;

/// Hover out of ground effect in one run, in stretches of a second or more, less their ends.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SteadyHover {
    /// Mean throttle, where one was logged.
    pub throttle: Option<f64>,
    /// Mean speed of the rotors (1/min), where it was logged in place of a throttle.
    pub rotor_rpm: Option<f64>,
    /// From (s).
    pub from_s: f64,
    /// To (s).
    pub to_s: f64,
    /// How long of that it hovered (s).
    pub hovered_s: f64,
    /// Least and greatest height (m); absent where heights are not known.
    pub heights_m: Option<[f64; 2]>,
}

impl fmt::Display for SteadyHover {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.throttle, self.rotor_rpm) {
            (Some(throttle), _) => write!(f, "hover at throttle {throttle:.3}")?,
            (None, Some(rpm)) => write!(f, "hover at {rpm:.0} turns a minute")?,
            (None, None) => write!(f, "hover")?,
        }
        write!(f, " ({:.1} s)", self.hovered_s)
    }
}

/// Mean lift near the ground less that far from it, as a share of thrust.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ExtraLift {
    /// Least and greatest height near the ground (m).
    pub near_m: [f64; 2],
    /// Least and greatest height far from it (m).
    pub far_m: [f64; 2],
    /// How much more thrust there is near the ground than far from it.
    #[serde(flatten)]
    pub share: Estimate,
}

impl ExtraLift {
    /// Without its interval.
    fn words(&self) -> String {
        let ([a, b], [c, d]) = (self.near_m, self.far_m);
        format!(
            "extra lift {:.1} % at {a:.3} to {b:.3} m over {c:.3} to {d:.3} m",
            100.0 * self.share.value
        )
    }
}

impl fmt::Display for ExtraLift {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [lo, hi] = self.share.ci95.map(|v| 100.0 * v);
        write!(f, "{}, 95 % interval {lo:.1} to {hi:.1} %", self.words())
    }
}

/// One armed interval.
#[derive(Clone, Debug, Serialize)]
pub struct ArmedIntervalResult {
    /// The log.
    pub log: String,
    /// Its number in the log, from 1.
    pub number: usize,
    /// Motors on and off, stand before.
    #[serde(flatten)]
    pub run: ArmedInterval,
    /// Number of rows used; zero for an unused interval.
    pub rows_used: usize,
    /// Specific force at the throttle of hover, in gravities.
    pub thrust_scale: Option<f64>,
    /// Constant error of the height, as logged less true (m), as far as the run differs from the others.
    pub height_error_m: Option<f64>,
    /// Hover out of ground effect, where there was some.
    pub hover: Option<SteadyHover>,
    /// Extra lift as measured in this run, where it has heights for it. Motors, drift and scale are the model's; the
    /// interval is that of the run's own noise.
    pub extra_lift: Option<ExtraLift>,
}

impl fmt::Display for ArmedIntervalResult {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (on, off) = self.run.span(" s");
        write!(
            f,
            "{}, run {}: motors on {on}, off {off}",
            self.log, self.number
        )?;
        if let Some(stood_m) = self.run.stood_m {
            write!(f, ", stands at {stood_m:.3} m")?;
        }
        match &self.hover {
            Some(hover) => write!(f, "; {hover}")?,
            None => write!(f, "; no steady hover out of ground effect")?,
        }
        match &self.extra_lift {
            // All flights together give the confidence interval.
            Some(lift) => write!(f, "; {}", lift.words()),
            None => Ok(()),
        }
    }
}

impl GroundEffect {
    /// Height (in R) and ratio of thrusts minus one, as measured, of every row that counts, run by run: the curve at rest,
    /// and what the whole model leaves of the measured force.
    #[must_use]
    pub fn measured_ratios(&self) -> Vec<Vec<[f64; 2]>> {
        let values = self.fit.values();
        let of_run = |((piece, run), bias): ((&Segment, Vec<f64>), f64)| {
            let of_row = |(&i, modelled): (&usize, f64)| {
                let z = piece.height[i] + bias;
                [z, values.at_rest(z) + piece.force[i] / modelled - 1.0]
            };
            piece.rows.iter().zip(run).map(of_row).collect()
        };
        let biases = self.fit.locals.iter().map(|l| l.bias);
        let runs = self.pieces.iter().zip(self.fit.predict(&self.pieces));
        runs.zip(biases).map(of_run).collect()
    }

    /// Extra lift by the fitted curve up to two rotor radii, relative to that out of ground effect; none where there is no
    /// curve.
    pub(super) fn extra_lift_of_curve(&self, settings: &FlightSettings) -> Option<ExtraLift> {
        if self.fit.shape.curve == Curve::Free {
            return None;
        }
        let r = self.rotor_radius_m;
        let [lo, hi] = self.heights_m;
        let near_m = [lo.max(NEAREST_RADII * r), CURVE_NEAR_RADII * r];
        let far_m = [settings.reference_radii * r, hi];
        let share = self.extra_lift(near_m, far_m)?;
        (near_m[0] < near_m[1] && far_m[0] < far_m[1]).then_some(ExtraLift {
            near_m,
            far_m,
            share,
        })
    }

    /// All armed intervals.
    pub(super) fn runs(
        &self,
        flights: &[Flight],
        settings: &FlightSettings,
    ) -> Vec<ArmedIntervalResult> {
        let ratios = if self.fit.shape.curve == Curve::Free {
            Vec::new()
        } else {
            self.measured_ratios()
        };
        let inflation = correlation_inflation(&self.fit, &self.pieces);
        let mut out = Vec::new();
        for (index, (flight, phases)) in flights.iter().zip(&self.phases).enumerate() {
            for (number, run) in phases.runs.iter().enumerate() {
                let ours = |p: &Segment| p.flight == index && p.run == number;
                let place = self.pieces.iter().position(ours);
                let local = place.map(|i| self.fit.locals[i]);
                let error_m = local.map(|l| -l.bias * self.rotor_radius_m);
                out.push(ArmedIntervalResult {
                    log: flight.name.clone(),
                    number: number + 1,
                    run: run.clone(),
                    rows_used: place.map_or(0, |i| self.pieces[i].rows.len()),
                    thrust_scale: local.map(|l| l.scale),
                    height_error_m: error_m.filter(|e| e.is_finite()),
                    hover: steady_hover(flight, phases, run, settings),
                    extra_lift: place
                        .and_then(|i| ratios.get(i))
                        .and_then(|rows| self.measured_lift(rows, inflation, settings)),
                });
            }
        }
        out
    }

    /// Mean ratio of a run's rows near the ground less that of those far from it; neighbouring rows say `inflation` times
    /// less than as many independent ones.
    fn measured_lift(
        &self,
        rows: &[[f64; 2]],
        inflation: f64,
        settings: &FlightSettings,
    ) -> Option<ExtraLift> {
        let values = self.fit.values();
        let part = |keep: &dyn Fn(f64) -> bool| -> Option<HeightBand> {
            let of: Vec<[f64; 2]> = rows.iter().copied().filter(|[z, _]| keep(*z)).collect();
            let n = of.len() as f64;
            Some(HeightBand {
                heights_m: range(of.iter().map(|[z, _]| z * self.rotor_radius_m))?,
                count: n,
                mean: of.iter().map(|[_, y]| y).sum::<f64>() / n,
                squares: of
                    .iter()
                    .map(|[z, y]| (y - values.at_rest(*z)).powi(2))
                    .sum(),
            })
            .filter(|_| of.len() >= FEWEST)
        };
        let near = part(&|z| (NEAREST_RADII..CURVE_NEAR_RADII).contains(&z))?;
        let far = part(&|z| z > settings.reference_radii)?;
        let count = near.count + far.count;
        let freedom = count / inflation - 2.0;
        let student = StudentsT::new(0.0, 1.0, freedom).ok()?.inverse_cdf(0.975);
        let variance = (near.squares + far.squares) / (count - 2.0) * inflation;
        let std_error = (variance * (1.0 / near.count + 1.0 / far.count)).sqrt();
        let value = near.mean - far.mean;
        let half = student * std_error;
        (value.is_finite() && half.is_finite()).then_some(ExtraLift {
            near_m: near.heights_m,
            far_m: far.heights_m,
            share: Estimate {
                value,
                std_error,
                ci95: [value - half, value + half],
            },
        })
    }
}

/// Rows of a run at some heights.
struct HeightBand {
    heights_m: [f64; 2],
    count: f64,
    mean: f64,
    /// Sum of squares about the model.
    squares: f64,
}

/// Steady hover of a run above what is in ground effect, where that is known: slow climb, or a force of about gravity where
/// no climb is known.
fn steady_hover(
    flight: &Flight,
    phases: &Phases,
    run: &ArmedInterval,
    settings: &FlightSettings,
) -> Option<SteadyHover> {
    let far_m = settings
        .rotor_radius_m
        .map(|r| r * settings.reference_radii);
    let steady = |i: usize| {
        let far = match (far_m, flight.height_m.get(i)) {
            (Some(far), Some(z)) => *z > far,
            _ => true,
        };
        let slow = match (flight.climb_mps.get(i), flight.force.get(i)) {
            (Some(v), _) => v.abs() < REST_MPS,
            (None, Some(f)) => (f - 1.0).abs() < HOVER_FORCE,
            (None, None) => false,
        };
        far && slow && phases.rows[i] == Phase::Airborne
    };
    let [a, b] = run.rows;
    let rows: Vec<usize> = (a..=b).filter(|&i| steady(i)).collect();
    let time = |i: usize| flight.time_s[i];
    let used: Vec<usize> = rows
        .chunk_by(|i, j| i + 1 == *j)
        .filter(|s| time(s[s.len() - 1]) - time(s[0]) >= STEADY_S)
        .flat_map(|s| {
            let [from_s, to_s] = [time(s[0]) + ENDS_S, time(s[s.len() - 1]) - ENDS_S];
            s.iter()
                .copied()
                .filter(move |&i| (from_s..=to_s).contains(&time(i)))
        })
        .collect();
    let count = used.len() as f64;
    let by_speed = flight.throttle_is_speed;
    let mean = |c: &[f64]| used.iter().map(|&i| c[i]).sum::<f64>() / count;
    Some(SteadyHover {
        from_s: time(*used.first()?),
        to_s: time(*used.last()?),
        throttle: (!by_speed).then(|| mean(&flight.throttle)),
        rotor_rpm: by_speed.then(|| mean(&flight.rotor_rpm)),
        hovered_s: count * flight.step_s(),
        heights_m: range(used.iter().filter_map(|&i| flight.height_m.get(i).copied())),
    })
}
