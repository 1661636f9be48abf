//! The distribution of the state and its propagation in time.

use super::RelativeFilter;
use super::transition::Transition;
use crate::estimate::gaussian::Gaussian;
use touchdown_flight::real::Real;
use touchdown_flight::space::Vector;

/// Distribution of the vertical states.
pub(super) type Vertical<R> = Gaussian<R, 6, 21>;

/// Distribution of the states of a horizontal axis.
pub(super) type Horizontal<R> = Gaussian<R, 5, 15>;

/// Vertical states: height h, velocity v_q, deck velocity v_p and acceleration
/// a_p, accelerometer bias b, altitude z_q.
pub(super) const H: usize = 0;
pub(super) const VQ: usize = 1;
pub(super) const VP: usize = 2;
pub(super) const AP: usize = 3;
pub(super) const B: usize = 4;
pub(super) const ZQ: usize = 5;

/// Horizontal states of an axis: relative position, velocity, deck velocity,
/// accelerometer bias, deck acceleration.
pub(super) const P: usize = 0;
pub(super) const VX: usize = 1;
pub(super) const VD: usize = 2;
pub(super) const BX: usize = 3;
pub(super) const AD: usize = 4;

/// Vertical and two horizontal distributions, independent of each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Belief<R> {
    pub(super) vertical: Vertical<R>,
    pub(super) horizontal: [Horizontal<R>; 2],
    /// Integral of the vertical velocity, m: the altitude without the steps of
    /// corrections.
    pub(super) climbed: R,
}

impl<R: Real> Belief<R> {
    /// Zeros, for memory that a belief is written to later.
    pub(super) const BLANK: Self = Self {
        vertical: Gaussian::BLANK,
        horizontal: [Gaussian::BLANK; 2],
        climbed: R::ZERO,
    };

    pub(super) fn initial(filter: &RelativeFilter<R>) -> Self {
        let (deck, imu, initial) = (&filter.deck, &filter.imu, &filter.initial);
        let heave_sd = deck.heave_velocity_sd_mps;
        let levelling = filter.gravity_mps2 * imu.attitude_sd_rad;
        let bias = imu.bias_sd_mps2;
        let axis = Gaussian::from_sd([
            initial.position_sd_m,
            initial.velocity_sd_mps,
            deck.horizontal_velocity_sd_mps,
            (bias * bias + levelling * levelling).sqrt(),
            deck.horizontal_acceleration_sd_mps2,
        ]);
        let mut belief = Self {
            vertical: Gaussian::from_sd([
                initial.position_sd_m,
                initial.velocity_sd_mps,
                heave_sd,
                heave_sd * deck.heave_angular_frequency,
                bias,
                filter.barometer.noise_sd_m,
            ]),
            horizontal: [axis; 2],
            climbed: R::ZERO,
        };
        belief.follow(initial.follows_sd_mps);
        belief
    }

    /// A deck with the horizontal velocity of the vehicle, with a standard deviation of the difference on each axis; 0 changes nothing.
    /// What is learned of the vehicle's velocity is then learned of the deck's.
    pub(super) fn follow(&mut self, sd: R) {
        if !(sd > R::ZERO) {
            return;
        }
        for axis in &mut self.horizontal {
            axis.mean[VD] = axis.mean[VX];
            for other in [P, VX, BX, AD] {
                axis.set_covariance(VD, other, axis.covariance(VX, other));
            }
            axis.set_covariance(VD, VD, axis.covariance(VX, VX) + sd * sd);
        }
    }

    /// Sets the height of a distribution whose numbers are independent.
    pub(super) fn know_height(&mut self, height_m: R, sd_m: R) {
        self.vertical.mean[H] = height_m;
        self.vertical.set_covariance(H, H, sd_m * sd_m);
    }

    /// Sets the vehicle's velocity with a standard deviation on each axis, independent of
    /// the other states.
    pub(super) fn know_velocity(&mut self, velocity: Vector<R>, sd: R) {
        let [x, y] = &mut self.horizontal;
        x.mean[VX] = velocity.x;
        y.mean[VX] = velocity.y;
        self.vertical.mean[VQ] = velocity.z;
        for axis in [x, y] {
            axis.set_independent(VX, sd * sd);
        }
        self.vertical.set_independent(VQ, sd * sd);
    }

    /// A deck at rest horizontally, with a standard deviation of its velocity that depends on no other state.
    pub(super) fn rest_deck(&mut self, sd: R) {
        for axis in &mut self.horizontal {
            axis.mean[VD] = R::ZERO;
            axis.set_independent(VD, sd * sd);
        }
    }

    pub(super) fn is_finite(&self) -> bool {
        self.climbed.is_finite()
            && self.vertical.is_finite()
            && self.horizontal.iter().all(Gaussian::is_finite)
    }

    /// Vehicle relative to the deck, m.
    pub(super) fn position(&self) -> Vector<R> {
        let [x, y] = &self.horizontal;
        Vector::new(x.mean[P], y.mean[P], self.vertical.mean[H])
    }

    /// Velocity of the vehicle, m/s.
    pub(super) fn velocity(&self) -> Vector<R> {
        let [x, y] = &self.horizontal;
        Vector::new(x.mean[VX], y.mean[VX], self.vertical.mean[VQ])
    }

    /// Velocity of the deck, m/s.
    pub(super) fn deck_velocity(&self) -> Vector<R> {
        let [x, y] = &self.horizontal;
        Vector::new(x.mean[VD], y.mean[VD], self.vertical.mean[VP])
    }

    /// Horizontal acceleration of the deck, m/s².
    pub(super) fn deck_horizontal_acceleration(&self) -> Vector<R> {
        let [x, y] = &self.horizontal;
        Vector::new(x.mean[AD], y.mean[AD], R::ZERO)
    }

    /// Biases of the acceleration, m/s².
    pub(super) fn bias(&self) -> Vector<R> {
        let [x, y] = &self.horizontal;
        Vector::new(x.mean[BX], y.mean[BX], self.vertical.mean[B])
    }

    /// Propagates over `t` seconds at a measured acceleration (world axes, gravity
    /// removed). A transition that is `known` for that time need not be computed again.
    pub(super) fn propagate(
        &mut self,
        filter: &RelativeFilter<R>,
        known: &mut Option<Transition<R>>,
        acceleration: Vector<R>,
        t: R,
    ) {
        if !(t > R::ZERO) {
            return;
        }
        let transition = Transition::keep(known, filter, t);
        let altitude = self.vertical.mean[ZQ];
        transition.vertical(&mut self.vertical, acceleration.z);
        self.climbed += self.vertical.mean[ZQ] - altitude;
        let [x, y] = &mut self.horizontal;
        transition.horizontal(x, acceleration.x);
        transition.horizontal(y, acceleration.y);
    }
}

#[cfg(test)]
mod tests {
    use super::super::health::Fate;
    use super::super::reading::{GnssVelocity, RangeReading, Reading, TagReading};
    use super::*;
    use touchdown_flight::space::Attitude;

    /// Smallest pivot of Cholesky's factorisation, each relative to its variance.
    fn least_pivot<const N: usize, const T: usize>(g: &Gaussian<f32, N, T>) -> f64 {
        let mut a = [[0.0; N]; N];
        for i in 0..N {
            for j in 0..N {
                a[i][j] = f64::from(g.covariance(i, j));
            }
        }
        let mut least = f64::INFINITY;
        for k in 0..N {
            let variance = f64::from(g.covariance(k, k));
            if variance == 0.0 {
                continue;
            }
            least = least.min(a[k][k] / variance);
            for i in k + 1..N {
                for j in k + 1..N {
                    a[i][j] -= a[i][k] * a[k][j] / a[k][k];
                }
            }
        }
        least
    }

    #[test]
    fn prop_covariance_stays_positive_in_single_precision() {
        let filter = RelativeFilter::<f32>::default();
        let mut belief = Belief::initial(&filter);
        let level = Attitude::LEVEL;
        let mut origin = None;
        for step in 0_u16..20_000 {
            belief.propagate(&filter, &mut None, Vector::ZERO, 0.004);
            let mut take = |reading: Reading<f32>| {
                let (fate, _) = belief.correct(&filter, &reading, level, &mut origin);
                assert!(matches!(fate, Fate::Used(_)), "{fate:?}");
            };
            take(Reading::Range(RangeReading::level(1.0, 0.0)));
            if step.is_multiple_of(8) {
                take(Reading::Tag(TagReading {
                    position_m: Vector::UP,
                    covariance_m2: [[0.0; 3]; 3],
                    age_s: 0.0,
                }));
            }
            if step.is_multiple_of(50) {
                take(Reading::Gnss(GnssVelocity {
                    velocity_mps: Vector::ZERO,
                    age_s: 0.0,
                }));
            }
            let least = [
                least_pivot(&belief.vertical),
                least_pivot(&belief.horizontal[0]),
            ];
            // Position of 10 m known to 2 mm in one reading: 4e-8 is left of the
            // variance, of the order of the rounding; what is left is positive.
            assert!(least[0] > 0.0 && least[1] > 0.0, "{step}: {least:?}");
        }
    }

    #[test]
    fn analytic_deck_prior_is_stationary() {
        // Without readings the spread of the deck's velocity and acceleration stays.
        let mut filter = RelativeFilter::<f64>::default();
        filter.deck.heave_velocity_sd_mps = 0.2;
        filter.deck.heave_angular_frequency = 3.0;
        filter.deck.heave_damping_ratio = 1.0;
        let mut belief = Belief::initial(&filter);
        for _ in 0..5000 {
            belief.propagate(&filter, &mut None, Vector::ZERO, 1e-3);
        }
        // The noise is right to order ω t = 0.003, the variance to twice that.
        let sd = [belief.vertical.sd(VP) / 0.2, belief.vertical.sd(AP) / 0.6];
        assert!(sd.iter().all(|sd| (sd - 1.0).abs() < 6e-3), "{sd:?}");
    }

    #[test]
    fn analytic_noise_of_two_steps_is_that_of_one() {
        // Exact for integrators; a slow deck is one to order ω t = 1e-4.
        let mut filter = RelativeFilter::<f64>::default();
        filter.imu.bias_walk = 0.0;
        filter.deck.heave_angular_frequency = 1e-3;
        filter.deck.heave_velocity_sd_mps = 1e4;
        filter.deck.horizontal_velocity_walk = 0.3;
        let start = Belief {
            vertical: Gaussian::from_sd([0.0; 6]),
            horizontal: [Gaussian::from_sd([0.0; 5]); 2],
            climbed: 0.0,
        };
        let (mut one, mut two) = (start, start);
        one.propagate(&filter, &mut None, Vector::ZERO, 0.1);
        two.propagate(&filter, &mut None, Vector::ZERO, 0.03);
        two.propagate(&filter, &mut None, Vector::ZERO, 0.07);
        let compare = |a: f64, b: f64, variances: f64| {
            assert!((a - b).abs() <= 1e-3 * variances.sqrt(), "{a} {b}");
        };
        let (a, b) = (&one.vertical, &two.vertical);
        for i in 0..6 {
            for j in 0..6 {
                let variances = a.covariance(i, i) * a.covariance(j, j);
                compare(a.covariance(i, j), b.covariance(i, j), variances);
            }
        }
        let (a, b) = (&one.horizontal[0], &two.horizontal[0]);
        for i in 0..4 {
            for j in 0..4 {
                let variances = a.covariance(i, i) * a.covariance(j, j);
                compare(a.covariance(i, j), b.covariance(i, j), variances);
            }
        }
    }

    #[test]
    fn analytic_deck_transition_is_exact() {
        // From (v, a) = (0.3, -0.5), ω = 3, over 0.7 s in one step: the closed form
        // of the oscillator, damped critically and less, and its integral by
        // Simpson's rule.
        for damping in [1.0, 0.4, 0.01] {
            let mut filter = RelativeFilter::<f64>::default();
            filter.deck.heave_damping_ratio = damping;
            let mut belief = Belief::initial(&filter);
            belief.vertical.mean[VP] = 0.3;
            belief.vertical.mean[AP] = -0.5;
            belief.propagate(&filter, &mut None, Vector::ZERO, 0.7);
            let sigma = 3.0 * damping;
            let wd = (9.0 - sigma * sigma).sqrt();
            let v = |t: f64| {
                let slope = -0.5 + sigma * 0.3;
                let sine = if wd > 0.0 { (wd * t).sin() / wd } else { t };
                (0.3 * (wd * t).cos() + slope * sine) * (-sigma * t).exp()
            };
            let n = 200;
            let h = 0.7 / f64::from(n);
            let mut integral = v(0.0) + v(0.7);
            for k in 1..n {
                integral += v(f64::from(k) * h) * if k % 2 == 1 { 4.0 } else { 2.0 };
            }
            // Rounding; Simpson's error (ω h)⁴/180 of 0.1.
            assert!((belief.vertical.mean[VP] - v(0.7)).abs() < 1e-15);
            assert!((belief.vertical.mean[H] + integral * h / 3.0).abs() < 1e-10);
        }
    }
}
