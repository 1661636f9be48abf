//! Force of the deck on the legs, from the inertial unit.

use touchdown_flight::kernel::{lag_by, lag_share, lag_step};
use touchdown_flight::real::{Real, r};

/// Time constant of the disturbance before contact, s: a few periods of the loop, short
/// against gusts and against the last 0.1 m of a descent. Halved, its noise adds to that of
/// the support; doubled, it lags behind a ground effect that the models do not know.
const FREE_S: f64 = 0.2;
/// Time constant of the support, s: shorter than a first contact, which lasts about 0.05 s.
/// Halved, the noise of single samples counts; doubled, a soft first contact is missed.
const SUPPORT_S: f64 = 0.03;
/// Height above that of contact from which on the legs are free, m: the error of the
/// estimated height, 0.01 m, and what a descent of 0.1 m/s covers in `FREE_S`. Halved, the
/// first contact can count as disturbance; doubled, more of the ground effect counts as support.
const FREE_M: f64 = 0.03;

// Effects of halving and doubling below that have no number are expected from single flights, not measured.

/// Memory of the gusts' force, s: several gusts of 0.3 s. Halved, one gust decides; doubled, a
/// landing in a rising wind still goes by the calm before it.
const GUSTS_S: f64 = 2.0;
/// Standard deviations of that force that are no contact. At 2 the thrust decreased in the
/// air in 3 of 40 landings at 10 m/s; at 4 soft touches take `contact_s` to be seen.
const GUSTS_SD: f64 = 3.0;

/// Estimated force of the deck: the force that thrust and ground effect do not explain,
/// less the same force in the flight just before.
///
/// ```text
/// n = m (a + g) - (T^ + f^) - d,   d: the same without d, filtered while the legs are free
/// ```
///
/// Gusts change d within a touch. Three standard deviations of that force, as it was
/// while the legs were free, are therefore no evidence.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Support<R> {
    /// Disturbance with free legs, N.
    free_n: R,
    /// Support, N.
    force_n: R,
    /// Mean of the unexplained force with free legs, N.
    mean_n: R,
    /// Its variance by gusts, N².
    variance_n2: R,
}

impl<R: Real> Support<R> {
    /// Advances the estimate by `dt` seconds with the unexplained force at a height above
    /// that of contact. A force that is not finite changes nothing.
    pub(super) fn step(&mut self, unexplained_n: R, above_contact_m: R, dt: R) {
        if !unexplained_n.is_finite() {
            return;
        }
        if above_contact_m > r(FREE_M) {
            self.free_n = lag_step(self.free_n, unexplained_n, r(FREE_S), dt);
            let gusts_share = lag_share(r(GUSTS_S), dt);
            self.mean_n = lag_by(self.mean_n, unexplained_n, gusts_share);
            // Of the filtered force, without the noise of single samples.
            let gust_n = self.force_n + self.free_n - self.mean_n;
            self.variance_n2 = lag_by(self.variance_n2, gust_n * gust_n, gusts_share);
        }
        let support_n = unexplained_n - self.free_n;
        self.force_n = lag_step(self.force_n, support_n, r(SUPPORT_S), dt);
    }

    /// The force of the deck on the legs over the weight, less what gusts explain beyond
    /// `least`. Negative values are errors of the models.
    pub(super) fn share(&self, least: R, weight_n: R) -> R {
        let gusts = r::<R>(GUSTS_SD) * self.variance_n2.sqrt() / weight_n;
        self.force_n / weight_n - (gusts - least).max(R::ZERO)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DT: f64 = 0.01;

    #[test]
    fn analytic_the_deck_carries_what_the_flight_before_did_not_explain() {
        let mut support = Support::<f64>::default();
        // A disturbance of 1 N in flight: ten time constants leave 1/22000 of it.
        for _ in 0..200 {
            support.step(1.0, 0.2, DT);
        }
        assert!(support.force_n.abs() < 1e-3, "{}", support.force_n);
        // A NaN changes nothing.
        let before = support;
        support.step(f64::NAN, 0.2, DT);
        assert_eq!(support, before);
        // The deck adds 2 N. After 0.1 s the filter of 0.03 s has seen 1 - exp(-10/3) of it.
        for _ in 0..10 {
            support.step(3.0, 0.0, DT);
        }
        let expected = 2.0 * (1.0 - (-10.0_f64 / 3.0).exp());
        assert!(
            (support.force_n - expected).abs() < 1e-3,
            "{}",
            support.force_n
        );
        // Near the deck the disturbance stays: the force lasts.
        for _ in 0..1000 {
            support.step(3.0, 0.0, DT);
        }
        assert!((support.force_n - 2.0).abs() < 1e-3);
    }
}
