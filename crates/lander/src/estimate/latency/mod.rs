//! Unknown latency of the camera: the true age of its readings less the stamped age.
//!
//! Old readings make the vehicle oscillate in hover, because its control law damps a
//! past velocity. This oscillation identifies the latency. K observers of the
//! horizontal position each assume a different latency, δ_k = k δ_max/(K - 1):
//!
//! ```text
//! p' = v,  v' = a - b,  b' = 0        a: measured acceleration of the time
//! e  = p_tag(t - age - δ_k) - p
//! p += (1 - θ³) e,  v += 3/2 (1 - θ)² (1 + θ) e/Δ,  b -= (1 - θ)³ e/Δ²,   θ = exp(-Δ/τ)
//! ```
//!
//! This is the polynomial filter of fading memory τ (Morrison 1969); Δ is the time since
//! the previous reading. Biases, levelling errors and the deck's surge are slower than τ,
//! so the filter follows them. It does not follow an oscillation.
//!
//! A deck that sways by A at the angular frequency ω leaves the error (ωτ)³ A in every
//! observer: at a period of 5 s 7 mm per metre with τ = 0.15 s, 5 cm with τ = 0.3 s. If the
//! vehicle follows this deck late, the error resembles that of a latency. It must stay
//! below the noise of the camera, so τ is short. The first estimate takes 5 τ as well.
//!
//! The attitude of the assumed time turns each reading into world axes. At the height h
//! above a tag, a wrong attitude adds a position error of the angle times h. This is
//! usually the larger part of e.
//!
//! Each observer sums the squares of e with a memory of `evidence_s`. The latency is that
//! of the least sum J, refined by the parabola through its neighbours.
//!
//! **Evidence.** With n counted readings, `n (J_k/J - 1)` is the logarithm of the odds of
//! the best latency against δ_k (both axes, normal errors of unknown variance). The
//! estimate changes only if this exceeds `least_evidence`, against the present estimate or
//! against zero. A vehicle at rest gives no evidence, so it keeps the estimate.
//!
//! **Height.** A second bank of observers follows the height, by the range finder, or by the tag where there is no range: an old height
//! makes the vertical control unstable within two seconds, before the horizontal motion tells the latency. A deck that heaves fast, which
//! the vehicle follows late, looks like a latency there. So the height counts only when the relative estimator [diverges], where a
//! latency explains the errors down to the noise, and where they are far greater without it.
//!
//! [diverges]: crate::estimate::relative::Health::diverged
//!
//! **Limits.** The latency is relative to the inertial unit, whose own latency is assumed
//! known. All sensors on the camera's path (a companion computer, a bus) are assumed to
//! have this latency; others are not corrected. The latency cannot be negative.
//!
//! **Range.** The [`RelativeState`] remembers N - 1 steps (0.31 s at 100 Hz). A latency is
//! compared only if this covers a reading at that latency. Before the memory, on the way from
//! the reading's predecessor, the oldest acceleration is held: for 0.03 s of readings that are 0.24 s old
//! and come at 10 Hz. With readings stamped 0.14 s old, the largest identifiable latency is 0.17 s.
//! An estimate beyond this range stays until a latency inside the range fits best.

mod bank;

use self::bank::{Bank, Follow, Sight};
use crate::check::positive;
use crate::estimate::relative::{Reading, RelativeFilter, RelativeState};
use touchdown_flight::error::{SettingsError, within};
use touchdown_flight::kernel::usable_dt;
use touchdown_flight::real::{Real, r};

/// Number of latencies that are compared. With the default range they are 20 ms apart:
/// less than one camera frame of 30 ms, so that the parabola interpolates well.
const HYPOTHESES: usize = 12;

/// Memory of the observers of the height over that of the others: heave is faster than sway.
const HEIGHT_MEMORY: f64 = 0.8;
/// Least time between two readings of the height, s: every fourth one of a range finder at 50 Hz. Twice as many find a latency no sooner.
const HEIGHT_SPACING_S: f64 = 0.07;
/// Time without a range from which on the tag's height is followed, s.
const RANGE_GONE_S: f64 = 0.3;

/// Time after a divergence for which heights may tell a latency, s: two swings of a vertical control that gets them 0.2 s late.
const DOUBTED_S: f64 = 2.0;
/// Least number of heights that tell a latency.
const LEAST_HEIGHTS: f64 = 8.0;
/// Least ratio of the mean squared errors of the believed latency and of the best one by the height, so that only a violent swing counts.
/// The effects of halving and doubling were not measured.
const LEAST_RATIO: f64 = 2.5;
/// Greatest error of the height that a latency explains, over the reading's noise: more is the deck's heave.
const CLEAR: f64 = 2.5;

/// What tells a latency.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Clue {
    /// The horizontal position of a tag.
    Place,
    /// The height.
    Height,
}

/// Estimator of an unknown latency; see the [module](self).
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct LatencyEstimator<R> {
    /// Largest latency that is considered, s.
    pub greatest_s: R,
    /// Memory τ of the observers, s.
    pub memory_s: R,
    /// Memory of the sums of squared errors, s.
    pub evidence_s: R,
    /// Logarithm of the odds above which the estimate changes.
    pub least_evidence: R,
}

/// State of a [`LatencyEstimator`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatencyState<R> {
    places: Bank<R>,
    heights: Bank<R>,
    /// Time since the last range, s.
    range_age_s: R,
    /// Time since the estimate of the relative motion diverged, s.
    doubted_s: R,
    latency_s: R,
}

impl<R: Real> LatencyState<R> {
    /// The estimated latency, s.
    pub fn latency_s(&self) -> R {
        self.latency_s
    }

    /// Time since the estimate of the relative motion has diverged, as of the last reading of the height, s.
    pub(crate) fn doubted_s(&self) -> R {
        self.doubted_s
    }

    /// Whether no range tells the height.
    pub(crate) fn is_range_gone(&self) -> bool {
        self.range_age_s > r(RANGE_GONE_S)
    }
}

impl<R: Real> Default for LatencyEstimator<R> {
    /// Up to 0.22 s in steps of 20 ms, memory 0.15 s, evidence of 6 s, odds of e²⁰. The
    /// odds are this high because errors of successive readings are correlated.
    fn default() -> Self {
        Self {
            greatest_s: r(0.22),
            memory_s: r(0.15),
            evidence_s: r(6.0),
            least_evidence: r(20.0),
        }
    }
}

impl<R: Real> LatencyEstimator<R> {
    /// Checks the settings.
    ///
    /// # Errors
    /// Times must be positive and the largest latency at most 0.25 s.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let greatest_s = self.greatest_s;
        within(
            "latency.greatest_s",
            greatest_s,
            greatest_s > R::ZERO && greatest_s <= r(0.25),
            "a time above 0 and up to 0.25 s",
        )?;
        positive("latency.memory_s", self.memory_s)?;
        positive("latency.evidence_s", self.evidence_s)?;
        positive("latency.least_evidence", self.least_evidence)
    }

    /// The state before any reading: zero latency.
    #[must_use]
    pub fn initial(&self) -> LatencyState<R> {
        LatencyState {
            places: Bank::new(r(f64::INFINITY)),
            heights: Bank::new(r(f64::INFINITY)),
            range_age_s: r(f64::INFINITY),
            doubted_s: r(f64::INFINITY),
            latency_s: R::ZERO,
        }
    }

    /// Advances by `dt` seconds with the readings that have arrived. Their ages are the
    /// stamped ones. `relative` must have been stepped by the same IMU sample.
    pub fn step<const N: usize, const M: usize>(
        &self,
        state: &mut LatencyState<R>,
        filter: &RelativeFilter<R>,
        relative: &RelativeState<R, N, M>,
        readings: &[Reading<R>],
        dt: R,
    ) {
        let dt = usable_dt(dt);
        state.places.age(dt);
        state.heights.age(dt);
        state.range_age_s += dt;
        state.doubted_s += dt;
        // The work of a step stays bounded: another range comes soon.
        let tagged = readings
            .iter()
            .any(|reading| matches!(reading, Reading::Tag(_)));
        for reading in readings.iter().filter(|reading| reading.is_finite()) {
            match reading {
                Reading::Tag(tag) => {
                    // The mean squared error of two axes is at least the detector's own noise.
                    let own = filter.tag.noise_sd_m * filter.tag.noise_sd_m;
                    let mut sight = Sight {
                        arm_m: filter.tag.position_m + filter.tag.attitude.rotate(tag.position_m),
                        age_s: tag.age_s,
                        noise_m2: own + own,
                    };
                    self.find(state, filter, relative, sight, Clue::Place);
                    if state.range_age_s > r(RANGE_GONE_S) {
                        sight.noise_m2 = tag.covariance_m2[2][2] + own;
                        self.find(state, filter, relative, sight, Clue::Height);
                    }
                }
                Reading::Range(range) if filter.range.reaches(range.distance_m) => {
                    state.range_age_s = R::ZERO;
                    let model = &filter.range;
                    let own = model.noise_sd_m + model.noise_share * range.distance_m;
                    let sight = Sight {
                        arm_m: model.position_m + model.direction * range.distance_m,
                        age_s: range.age_s,
                        noise_m2: own * own + model.quantum_m * model.quantum_m * r(1.0 / 12.0),
                    };
                    if !tagged {
                        self.find(state, filter, relative, sight, Clue::Height);
                    }
                }
                _ => {}
            }
        }
    }

    fn latency(&self, k: usize) -> R {
        self.greatest_s * (R::from_count(k) / R::from_count(HYPOTHESES - 1))
    }

    /// Follows the horizontal position of a tag, or the height of a reading.
    #[inline(never)]
    fn find<const N: usize, const M: usize>(
        &self,
        state: &mut LatencyState<R>,
        filter: &RelativeFilter<R>,
        relative: &RelativeState<R, N, M>,
        sight: Sight<R>,
        clue: Clue,
    ) {
        let (bank, follow): (_, Follow<R>) = match clue {
            Clue::Place => {
                let follow = Follow {
                    memory_s: self.memory_s,
                    spacing_s: R::ZERO,
                    axes: |place| [place.x, place.y],
                };
                (&mut state.places, follow)
            }
            Clue::Height => {
                let follow = Follow {
                    memory_s: r::<R>(HEIGHT_MEMORY) * self.memory_s,
                    spacing_s: r(HEIGHT_SPACING_S),
                    axes: |place| [place.z, R::ZERO],
                };
                if filter.has_diverged(relative) {
                    state.doubted_s = R::ZERO;
                }
                (&mut state.heights, follow)
            }
        };
        let counts = bank.compare(self, &follow, filter, relative, sight);
        let by_height = clue == Clue::Height;
        if !counts || (by_height && state.doubted_s > r(DOUBTED_S)) {
            return;
        }
        let believed = state.latency_s / self.latency(1);
        let Some(verdict) = bank.verdict(&follow, sight.noise_m2, believed) else {
            return;
        };
        let evidence = match clue {
            Clue::Place => verdict.against_none.max(verdict.against_believed),
            Clue::Height => verdict.against_believed,
        };
        let clear = !by_height
            || (verdict.counted >= r(LEAST_HEIGHTS)
                && verdict.ratio > r(LEAST_RATIO)
                && verdict.least_m2 < r::<R>(CLEAR * CLEAR) * sight.noise_m2);
        if clear && evidence > self.least_evidence {
            state.latency_s = verdict.place * self.latency(1);
        }
    }
}
