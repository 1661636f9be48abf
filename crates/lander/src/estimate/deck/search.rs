//! Which harmonics there are: starts and drops them.

use super::harmonics::{Harmonics, MOST};
use super::spectrum::Peak;
use super::{DeckEstimator, DeckEstimatorState, Observed};
use touchdown_flight::real::{Real, r};

/// Share of the readings' spread that a harmonic must explain to be started: the
/// first, and a further one.
const STARTING_SHARE: [f64; 2] = [0.35, 0.04];
/// What it must explain, in variances of its noise: noise alone exceeds 30 at one of
/// 32 frequencies with a probability of 32 e^-15.
const STARTING_POWER: f64 = 30.0;
/// Periods that must have been seen: of the first, and of a further one.
const STARTING_PERIODS: [f64; 2] = [1.0, 2.0];
/// Relative uncertainty of a frequency that the search has found.
const STARTING_WIDTH: f64 = 0.12;
/// Variance of its place, over its power.
const STARTING_SPREAD: f64 = 0.2;
/// Harmonics whose frequencies are closer than this, relatively, are one: tones, and
/// those of a broad band.
const CLOSENESS: [f64; 2] = [0.02, 0.15];
/// Periods after which a motion that no tones describe counts as a broad band.
const FILLING: f64 = 3.0;
/// Power of a harmonic that fills a broad band, over the largest one's.
const FILLING_POWER: f64 = 0.1;
/// Ratio of the frequencies of a broad band's harmonics.
const SPACING: f64 = 1.45;
/// Share of the way that an anchor moves to a peak in a round of the search.
const DRAWN: f64 = 0.02;
/// Mean normalised innovation squared below which nothing is missing.
const COMPLETE: f64 = 1.5;
/// Rate of forgetting below which harmonics are kept when another is found, 1/s.
const COHERENT: f64 = 0.02;
/// A peak as close to a harmonic as this, relatively, is that harmonic.
const FOLLOWED: f64 = 0.2;
/// Periods after which a harmonic may be dropped.
const SETTLING: f64 = 2.0;

impl<R: Real> DeckEstimator<R> {
    /// Starts harmonics where peaks stand out and drops those that have vanished.
    pub(super) fn revise(&self, state: &mut DeckEstimatorState<R>) {
        let peaks = state.spectrum.peaks();
        let found = self.standing_out(&peaks);
        let harmonics = &state.harmonics;
        let settled = |w: R| state.since_start_s * w > r(SETTLING * core::f64::consts::TAU);
        let moved = found > 0
            && peaks[0].is_some_and(|peak| {
                let w = peak.angular_frequency;
                settled(w) && !follows(harmonics, w)
            });
        // A coherent motion of which nothing is left is left alone.
        let full = state.harmonics.count() >= usize::from(self.harmonics);
        let coherent = state.harmonics.count() > 0 && state.learner.rate() <= r(COHERENT);
        let content = coherent && (full || state.nis < r(COMPLETE));
        if found > state.started && !content || moved {
            self.start(state, &peaks[..found]);
            return;
        }
        for peak in peaks.iter().flatten() {
            draw(&mut state.harmonics, peak.angular_frequency);
        }
        if let Some(k) = self.lost(state) {
            state.harmonics.remove(k);
            state.started = state.started.min(state.harmonics.count());
            state.learner.forget_predictions();
            return;
        }
        self.fill(state);
    }

    /// How many of the peaks are more than noise and the line shape of others.
    fn standing_out(&self, peaks: &[Option<Peak<R>>; MOST]) -> usize {
        let noise = self.measurement_sd * self.measurement_sd;
        // Further peaks are told apart from the slowest one.
        let mut periods = r::<R>(f64::INFINITY);
        let most = usize::from(self.harmonics);
        let stands_out = |(k, peak): &(usize, &Option<Peak<R>>)| {
            peak.is_some_and(|peak| {
                let further = usize::from(*k > 0);
                periods = periods.min(peak.periods);
                peak.share >= r(STARTING_SHARE[further])
                    && peak.explained >= noise * r(STARTING_POWER)
                    && periods >= r(STARTING_PERIODS[further])
            })
        };
        peaks
            .iter()
            .take(most)
            .enumerate()
            .take_while(stands_out)
            .count()
    }

    /// A harmonic that cannot be told from zero or from another, or has left the band.
    fn lost(&self, state: &DeckEstimatorState<R>) -> Option<usize> {
        let harmonics = &state.harmonics;
        let [lowest, highest] = self.band();
        let incoherent = state.learner.rate() > r(COHERENT);
        let closeness = CLOSENESS[usize::from(incoherent)];
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

    /// A motion that tones do not describe has a broad band: one harmonic more at
    /// its upper side, where the sharpest changes are.
    fn fill(&self, state: &mut DeckEstimatorState<R>) {
        let harmonics = &mut state.harmonics;
        let count = harmonics.count();
        if count == 0 || count >= usize::from(self.harmonics) {
            return;
        }
        let seen = state.since_start_s * harmonics.frequency(0);
        let incoherent = state.learner.rate() > r(COHERENT);
        if !incoherent || seen < r(FILLING * core::f64::consts::TAU) {
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

    /// Starts harmonics at the peaks that are not followed yet; all anew where those
    /// that are there do not describe the motion or leave no room.
    fn start(&self, state: &mut DeckEstimatorState<R>, peaks: &[Option<Peak<R>>]) {
        // Alone the offset has followed the motion: it starts at what is left of the
        // last reading.
        let (mut offset, mut variance) = (R::ZERO, self.offset_variance());
        if let (Observed::Displacement, Some(peak)) = (self.observed, peaks[0]) {
            let (c, s) = place_of(&peak);
            offset = state.last - c;
            variance[0] = c * c + s * s;
        }
        let harmonics = &mut state.harmonics;
        let new = |harmonics: &Harmonics<R>| {
            let all = peaks.iter().flatten();
            all.filter(|peak| !follows(harmonics, peak.angular_frequency))
                .count()
        };
        let room = harmonics.count() + new(harmonics) <= usize::from(self.harmonics);
        if !room || state.learner.rate() > r(COHERENT) {
            *harmonics = Harmonics::new(offset, variance);
        }
        let anew = harmonics.count() == 0;
        for peak in peaks.iter().flatten() {
            if !anew && follows(harmonics, peak.angular_frequency) {
                continue;
            }
            let w = peak.angular_frequency;
            let (c, s) = place_of(peak);
            let (power, width) = (c * c + s * s, w * r(STARTING_WIDTH));
            if anew {
                let place = r::<R>(STARTING_SPREAD) * power;
                harmonics.add([c, s, w], [place, place, width * width]);
            } else {
                // What the others leave of it is not known.
                harmonics.add([R::ZERO, R::ZERO, w], [power, power, width * width]);
            }
        }
        state.started = peaks.len();
        state.learner.begin_again();
        state.since_start_s = R::ZERO;
    }
}

/// Place and quadrature now: velocity C cos - S sin is that of c = S/ω, s = -C/ω.
fn place_of<R: Real>(peak: &Peak<R>) -> (R, R) {
    let w = peak.angular_frequency;
    (peak.s / w, -peak.c / w)
}

/// Draws the harmonic next to a peak towards it.
fn draw<R: Real>(harmonics: &mut Harmonics<R>, w: R) {
    let far = |k: usize| (harmonics.anchor(k) - w).abs();
    let nearest = (0..harmonics.count()).reduce(|a, b| if far(b) < far(a) { b } else { a });
    if let Some(k) = nearest
        && close(harmonics.anchor(k), w, FOLLOWED)
    {
        harmonics.draw(k, w, r(DRAWN));
    }
}

/// A harmonic is near the frequency.
fn follows<R: Real>(harmonics: &Harmonics<R>, w: R) -> bool {
    (0..harmonics.count()).any(|k| close(harmonics.frequency(k), w, FOLLOWED))
}

/// Two frequencies are within a share of each other.
fn close<R: Real>(a: R, b: R, share: f64) -> bool {
    (a - b).abs() < r::<R>(share) * a.max(b)
}
