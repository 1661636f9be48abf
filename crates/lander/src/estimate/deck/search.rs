//! Selection of the harmonics: starts and drops them.
//!
//! The constants were halved and doubled one by one in the example `heave_prediction`
//! (four seeds). Comments give the change of the relative prediction error over 1 s.

use super::harmonics::{Harmonics, MOST};
use super::spectrum::Peak;
use super::{DeckEstimator, DeckEstimatorState, Observed};
use touchdown_flight::real::{Real, r};

/// Least share of the sum of squares that a new harmonic must explain: the first one,
/// and a further one. With the first value doubled, neither of two tones starts. The
/// second value, halved, starts false harmonics on one tone (0.06 to 0.18).
const STARTING_SHARE: [f64; 2] = [0.35, 0.04];
/// Least explained sum of squares of a new harmonic, in variances of its noise. Noise
/// alone exceeds 30 at one of 32 frequencies with a probability of 32 e^-15. Doubled, two
/// tones start later (0.26 to 0.31).
const STARTING_POWER: f64 = 30.0;
/// Least number of observed periods: for the first harmonic, and for a further one. Both
/// are near an optimum: the error rises from 0.02 to 0.04 or more with the first value
/// halved or doubled, and from 0.26 to 0.45 or more with the second.
const STARTING_PERIODS: [f64; 2] = [1.0, 2.0];
/// A motion is weak whose largest peak explains less than this, in variances of its noise. The noise at the frequency of that peak then
/// counts, in place of the mean over all frequencies: decks of 5 to 10 mm at 1 to 2 Hz start only so. In a stronger motion,
/// two tones become three (0.01 to 0.05). Other values were not measured.
const WEAK_POWER: f64 = 100.0;
/// Observed periods of that peak before: a slow motion passes for a fast tone at first. After fewer the mean touch in a sea of 0.5 m is 0.063 m/s
/// in place of 0.058, after 5 and 8 that on the roof of a car is 0.088 and 0.108 m/s in place of 0.07 (all with the noise at the frequency
/// counted also in strong motions).
const WEAK_PERIODS: f64 = 3.0;
/// Relative standard deviation of the frequency of a new harmonic, of the order of the
/// grid's spacing of 13 %. At 0.1: errors of two tones over 2 s change from 0.29 to 0.31.
const STARTING_WIDTH: f64 = 0.15;
/// Variance of the place of a new harmonic, over its power. Halved or doubled: errors
/// change by at most 0.03.
const STARTING_SPREAD: f64 = 0.2;
/// Two harmonics closer than this relative frequency difference are duplicates: those of
/// tones, and those of a broad band. The first value has no effect in the example; the
/// second, doubled, merges harmonics that a sea needs (0.44 to 0.53).
const CLOSENESS: [f64; 2] = [0.02, 0.15];
/// Periods after which an incoherent motion counts as a broad band. Halved: harmonics
/// are added too early to two tones (0.31 to 0.36).
const FILLING: f64 = 3.0;
/// Power of a harmonic that fills a broad band, over the largest power. It hardly matters
/// (changes below 0.003), because the filter soon learns the power.
const FILLING_POWER: f64 = 0.1;
/// Frequency ratio between the harmonics of a broad band, close to the ratio of 1.5 that
/// the search can separate. It must be above 1; doubled, it has no effect.
const SPACING: f64 = 1.45;
/// Share of the distance by which each round of the search moves an anchor to a peak: a
/// time constant of 4 s at 100 Hz. Halved: two tones are found later (0.31 to 0.37).
const PULL: f64 = 0.02;
/// Mean normalised innovation squared below which the harmonics describe the motion
/// completely. Halved to below 1, no fit is complete (0.02 to 0.04); doubled: no effect.
const COMPLETE: f64 = 1.5;
/// Largest decay rate of a coherent motion, 1/s. Halved: 0.31 to 0.36 for two tones.
const COHERENT: f64 = 0.02;
/// A peak within this relative frequency difference belongs to an existing harmonic. It
/// is near an optimum for a sea: 0.44 to 0.49 if halved, to 0.53 if doubled.
const FOLLOWED: f64 = 0.2;
/// Periods after which a harmonic may be dropped. Doubled: 0.44 to 0.45 in a sea.
const SETTLING: f64 = 2.0;

impl<R: Real> DeckEstimator<R> {
    /// Starts harmonics where peaks stand out and drops those that have vanished.
    #[inline(never)]
    pub(super) fn revise(&self, state: &mut DeckEstimatorState<R>) {
        let peaks = state.spectrum.peaks(self.observed);
        let significant = self.significant_peaks(&peaks);
        let harmonics = &state.harmonics;
        let settled = |w: R| state.since_start_s * w > r(SETTLING * core::f64::consts::TAU);
        let moved = significant > 0
            && peaks[0].is_some_and(|peak| {
                let w = peak.angular_frequency;
                settled(w) && !follows(harmonics, w)
            });
        // Harmonics that describe a coherent motion completely are kept.
        let full = state.harmonics.count() >= usize::from(self.harmonics);
        let coherent = state.harmonics.count() > 0 && state.learner.rate() <= r(COHERENT);
        let complete = coherent && (full || state.nis < r(COMPLETE));
        if significant > state.started && !complete || moved {
            self.start(state, &peaks, significant);
            return;
        }
        for peak in peaks.iter().flatten() {
            pull_nearest(&mut state.harmonics, peak.angular_frequency);
        }
        if let Some(k) = self.superfluous(state) {
            state.harmonics.remove(k);
            state.started = state.started.min(state.harmonics.count());
            state.learner.forget_predictions();
            return;
        }
        self.fill(state);
    }

    /// Number of leading peaks that exceed the noise.
    fn significant_peaks(&self, peaks: &[Option<Peak<R>>; MOST]) -> usize {
        let noise = self.measurement_sd * self.measurement_sd;
        let weak = peaks[0].filter(|first| {
            first.periods >= r(WEAK_PERIODS) && first.explained < noise * r(WEAK_POWER)
        });
        let noise = weak.map_or(noise, |first| noise * first.noise);
        // Separating peaks takes periods of the slowest one.
        let mut periods = r::<R>(f64::INFINITY);
        let most = usize::from(self.harmonics);
        let is_significant = |(k, peak): &(usize, &Option<Peak<R>>)| {
            peak.is_some_and(|peak| {
                let further = *k > 0;
                periods = periods.min(peak.periods);
                peak.share >= either(STARTING_SHARE, further)
                    && peak.explained >= noise * r(STARTING_POWER)
                    && periods >= either(STARTING_PERIODS, further)
            })
        };
        peaks
            .iter()
            .take(most)
            .enumerate()
            .take_while(is_significant)
            .count()
    }

    /// A harmonic that is not significant, that duplicates another one, or whose
    /// frequency is at the edge of the band.
    fn superfluous(&self, state: &DeckEstimatorState<R>) -> Option<usize> {
        let harmonics = &state.harmonics;
        let [lowest, highest] = self.band();
        let incoherent = state.learner.rate() > r(COHERENT);
        let closeness = either(CLOSENESS, incoherent);
        let count = harmonics.count();
        (0..count).filter(|_| count > 1).find(|&k| {
            let w = harmonics.frequency(k);
            let settled = state.since_start_s * w > r(SETTLING * core::f64::consts::TAU);
            let unknown = harmonics.power_variance(k);
            let vanished =
                !incoherent && harmonics.power(k) < unknown && harmonics.mean_power(k) < unknown;
            let doubled = (0..count).any(|other| {
                other != k
                    && close(w, harmonics.frequency(other), closeness)
                    && harmonics.mean_power(k) <= harmonics.mean_power(other)
            });
            settled && (vanished || doubled || w <= lowest || w >= highest)
        })
    }

    /// Adds a harmonic above the others if tones do not describe the motion: the motion
    /// then has a broad band, and its upper side changes fastest.
    fn fill(&self, state: &mut DeckEstimatorState<R>) {
        let harmonics = &mut state.harmonics;
        let count = harmonics.count();
        if count == 0 || count >= usize::from(self.harmonics) {
            return;
        }
        let phase = state.since_start_s * harmonics.frequency(0);
        let incoherent = state.learner.rate() > r(COHERENT);
        if !incoherent || phase < r(FILLING * core::f64::consts::TAU) {
            return;
        }
        let [_, highest] = self.band();
        let (mut top, mut power) = (R::ZERO, R::ZERO);
        for k in 0..count {
            top = top.max(harmonics.frequency(k));
            power = power.max(harmonics.mean_power(k));
        }
        let w = top * r(SPACING);
        if w < highest {
            let place = power * r(FILLING_POWER);
            let width = w * r(STARTING_WIDTH);
            harmonics.add([R::ZERO, R::ZERO, w], [place, place, width * width]);
            harmonics.set_mean_power(count, place);
            state.learner.forget_predictions();
        }
    }

    /// Starts harmonics at the peaks that no harmonic follows yet. If the present
    /// harmonics do not describe the motion or leave no room, all start again.
    #[inline(never)]
    fn start(
        &self,
        state: &mut DeckEstimatorState<R>,
        peaks: &[Option<Peak<R>>; MOST],
        count: usize,
    ) {
        // Without harmonics the offset has followed the motion. It restarts at the last
        // reading less the new harmonic.
        let (mut offset, mut variance) = (R::ZERO, self.offset_variance());
        let first = peaks[0].filter(|_| count > 0);
        if let (Observed::Displacement, Some(peak)) = (self.observed, first) {
            let (c, s) = place_of(&peak);
            offset = state.last - c;
            variance[0] = c * c + s * s;
        }
        let harmonics = &mut state.harmonics;
        let new = |harmonics: &Harmonics<R>| {
            let all = peaks.iter().take(count).flatten();
            all.filter(|peak| !follows(harmonics, peak.angular_frequency))
                .count()
        };
        let room = harmonics.count() + new(harmonics) <= usize::from(self.harmonics);
        if !room || state.learner.rate() > r(COHERENT) {
            harmonics.reset(offset, variance);
        }
        let restart = harmonics.count() == 0;
        for peak in peaks.iter().take(count).flatten() {
            if !restart && follows(harmonics, peak.angular_frequency) {
                continue;
            }
            let w = peak.angular_frequency;
            let (c, s) = place_of(peak);
            let (power, width) = (c * c + s * s, w * r(STARTING_WIDTH));
            if restart {
                let place = r::<R>(STARTING_SPREAD) * power;
                harmonics.add([c, s, w], [place, place, width * width]);
            } else {
                // The other harmonics explain an unknown part of this peak.
                harmonics.add([R::ZERO, R::ZERO, w], [power, power, width * width]);
            }
        }
        state.started = count;
        state.learner.restart();
        state.since_start_s = R::ZERO;
    }
}

/// One of two constants. Chosen after the conversion, which then is none at run time.
#[inline(always)]
fn either<R: Real>([first, second]: [f64; 2], takes_second: bool) -> R {
    if takes_second { r(second) } else { r(first) }
}

/// Place c = S/ω and quadrature s = -C/ω of the velocity C cos - S sin.
fn place_of<R: Real>(peak: &Peak<R>) -> (R, R) {
    let w = peak.angular_frequency;
    (peak.s / w, -peak.c / w)
}

/// Pulls the anchor that is nearest to a peak towards it.
fn pull_nearest<R: Real>(harmonics: &mut Harmonics<R>, w: R) {
    let far = |k: usize| (harmonics.anchor(k) - w).abs();
    let nearest = (0..harmonics.count()).reduce(|a, b| if far(b) < far(a) { b } else { a });
    if let Some(k) = nearest
        && close(harmonics.anchor(k), w, r(FOLLOWED))
    {
        harmonics.pull(k, w, r(PULL));
    }
}

/// Whether a harmonic is near the frequency.
fn follows<R: Real>(harmonics: &Harmonics<R>, w: R) -> bool {
    (0..harmonics.count()).any(|k| close(harmonics.frequency(k), w, r(FOLLOWED)))
}

/// Whether two frequencies differ by less than a share of the larger one.
fn close<R: Real>(a: R, b: R, share: R) -> bool {
    (a - b).abs() < share * a.max(b)
}
