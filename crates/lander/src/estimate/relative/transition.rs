//! How the distribution of the state moves on in a time: `x ← F x + u`, `P ← F P Fᵀ + Q`.
//!
//! Most elements of F are zero or one. Sums contain the others only, in the order of the dense
//! products, so the results are the same bits. The covariance of the deck's noise is that of an
//! integrator, so it is correct to first order in ω t, and in t over the correlation time of the
//! horizontal acceleration. Everything else is exact.

use super::RelativeFilter;
use super::belief::{Horizontal, Vertical};
use touchdown_flight::real::{Real, r};

/// The transition of all states in a time t, s.
///
/// ```text
/// vertical, h v_q v_p a_p b z_q         horizontal, p v v_d b a_d
/// 1  t  -mv  -ma  -t²/2  0              1  t  -t  -t²/2  -farther
///    1             -t    0                 1       -t
///        vv   va                               1          faster
///        av   aa                                    1
///                   1                                     kept
///    t            -t²/2  1
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Transition<R> {
    t: R,
    /// t²/2.
    half_t2: R,
    /// mv and ma.
    moved: [R; 2],
    /// vv, va, av and aa.
    deck: [R; 4],
    /// kept, faster and farther.
    course: [R; 3],
    /// Noise of hh, h v_q, h v_p, h a_p, h z_q; v_q v_q, v_q z_q; v_p v_p, v_p a_p; a_p a_p; bb; z_q z_q.
    vertical: [R; 12],
    /// Noise of pp, pv, p v_d, p a_d; vv; v_d v_d, v_d a_d; bb; a_d a_d.
    horizontal: [R; 9],
}

impl<R: Real> Transition<R> {
    /// The transition in a time that `known` has or gets.
    pub(super) fn keep<'a>(
        known: &'a mut Option<Self>,
        filter: &RelativeFilter<R>,
        t: R,
    ) -> &'a Self {
        if known.as_ref().is_some_and(|known| known.t != t) {
            *known = None;
        }
        known.get_or_insert_with(|| Self::new(filter, t))
    }

    #[inline(never)]
    fn new(filter: &RelativeFilter<R>, t: R) -> Self {
        let (one, half, third) = (R::ONE, r::<R>(0.5), r::<R>(1.0 / 3.0));
        let (t2, t3) = (t * t, t * t * t);
        let deck = &filter.deck;
        let w = deck.heave_angular_frequency;
        // v_p'' + 2 σ v_p' + ω² v_p = 0, σ = ζ ω, ω_d² = ω² - σ².
        let sigma = deck.heave_damping_ratio * w;
        let wd = (w * w - sigma * sigma).max(R::ZERO).sqrt();
        let (sine, cosine) = (wd * t).sin_cos();
        let sine = if (wd * t) * (wd * t) < R::EPSILON {
            t
        } else {
            sine / wd
        };
        let e = (-(sigma * t)).exp();
        let (vv, va) = (e * (cosine + sigma * sine), e * sine);
        let aa = e * (cosine - sigma * sine);
        let moved_a = (one - vv) / (w * w);
        let moved_v = va + r::<R>(2.0) * sigma * moved_a;
        let qa = filter.imu.noise_density * filter.imu.noise_density;
        let qb = filter.imu.bias_walk * filter.imu.bias_walk;
        // Stationary: var v_p = q/(4 ζ ω³).
        let sd = deck.heave_velocity_sd_mps;
        let qd = r::<R>(4.0) * sigma * w * w * sd * sd;
        let drift = filter.barometer.drift * filter.barometer.drift;
        let vertical = [
            qa * t3 * third + qd * t3 * t2 * r(0.05),
            qa * t2 * half,
            -(qd * t2 * t2 * r(0.125)),
            -(qd * t3 * r(1.0 / 6.0)),
            qa * t3 * third,
            qa * t,
            qa * t2 * half,
            qd * t3 * third,
            qd * t2 * half,
            qd * t,
            qb * t,
            qa * t3 * third + drift * t,
        ];
        let (course, horizontal) = Self::course(filter, t);
        Self {
            t,
            half_t2: half * t2,
            moved: [moved_v, moved_a],
            deck: [vv, va, -(w * w) * va, aa],
            course,
            vertical,
            horizontal,
        }
    }

    /// The horizontal part.
    fn course(filter: &RelativeFilter<R>, t: R) -> ([R; 3], [R; 9]) {
        let (one, zero, half, third) = (R::ONE, R::ZERO, r::<R>(0.5), r::<R>(1.0 / 3.0));
        let (t2, t3) = (t * t, t * t * t);
        let deck = &filter.deck;
        let qa = filter.imu.noise_density * filter.imu.noise_density;
        let qb = filter.imu.bias_walk * filter.imu.bias_walk;
        let qw = deck.horizontal_velocity_walk * deck.horizontal_velocity_walk;
        let (mut pp, mut p_vd, mut vd_vd) = ((qa + qw) * t3 * third, -(qw * t2 * half), qw * t);
        // a_d' = -a_d/τ + w, of stationary variance q τ/2; a deck that does not accelerate has none.
        let (mut course, mut accelerating) = ([zero; 3], [zero; 3]);
        let sd = deck.horizontal_acceleration_sd_mps2;
        if sd > zero {
            let tau = deck.horizontal_acceleration_s;
            let kept = (-(t / tau)).exp();
            let faster = tau * (one - kept);
            course = [kept, faster, tau * (t - faster)];
            let qj = r::<R>(2.0) * sd * sd / tau;
            pp += qj * t3 * t2 * r(0.05);
            p_vd -= qj * t2 * t2 * r(0.125);
            vd_vd += qj * t3 * third;
            accelerating = [-(qj * t3 * r(1.0 / 6.0)), qj * t2 * half, qj * t];
        }
        let [p_ad, vd_ad, ad_ad] = accelerating;
        let noise = [
            pp,
            qa * t2 * half,
            p_vd,
            p_ad,
            qa * t,
            vd_vd,
            vd_ad,
            qb * t,
            ad_ad,
        ];
        (course, noise)
    }

    /// Moves the vertical states on, at a measured acceleration.
    #[inline(never)]
    #[rustfmt::skip]
    pub(super) fn vertical(&self, g: &mut Vertical<R>, acceleration: R) {
        let (t, s, zero) = (self.t, self.half_t2, R::ZERO);
        let ([mv, ma], [vv, va, av, aa]) = (self.moved, self.deck);
        let [q_hh, q_hv, q_hd, q_ha, q_hz, q_vv, q_vz, q_dd, q_da, q_aa, q_bb, q_zz] = self.vertical;
        let (faster, higher) = (acceleration * t, acceleration * (t * t) * r(0.5));
        // Columns of F Fᵀ, on which rows and columns of P are summed.
        let of_h = |q: R, h: R, v: R, d: R, a: R, b: R| q + h + t * v - mv * d - ma * a - s * b;
        let of_v = |q: R, v: R, b: R| q + v - t * b;
        let of_d = |q: R, d: R, a: R| q + vv * d + va * a;
        let of_a = |q: R, d: R, a: R| q + av * d + aa * a;
        let of_z = |q: R, v: R, b: R, z: R| q + t * v - s * b + z;

        let [h, v, d, a, b, z] = g.mean;
        g.mean = [
            of_h(higher, h, v, d, a, b), of_v(faster, v, b), of_d(zero, d, a), of_a(zero, d, a), b,
            of_z(higher, v, b, z),
        ];

        let [
            hh, hv, hd, ha, hb, hz,
                vv_, vd, v_a, vb, vz,
                    dd, da, db, dz,
                        aa_, ab, az,
                            bb, bz,
                                zz,
        ] = g.covariance;
        // Rows of F P.
        let h_h = of_h(zero, hh, hv, hd, ha, hb);
        let h_v = of_h(zero, hv, vv_, vd, v_a, vb);
        let h_d = of_h(zero, hd, vd, dd, da, db);
        let h_a = of_h(zero, ha, v_a, da, aa_, ab);
        let h_b = of_h(zero, hb, vb, db, ab, bb);
        let h_z = of_h(zero, hz, vz, dz, az, bz);
        let (v_v, v_d) = (of_v(zero, vv_, vb), of_v(zero, vd, db));
        let (v_aa, v_b, v_z) = (of_v(zero, v_a, ab), of_v(zero, vb, bb), of_v(zero, vz, bz));
        let (d_v, d_d, d_a) = (of_d(zero, vd, v_a), of_d(zero, dd, da), of_d(zero, da, aa_));
        let (d_b, d_z) = (of_d(zero, db, ab), of_d(zero, dz, az));
        let (a_v, a_d, a_a) = (of_a(zero, vd, v_a), of_a(zero, dd, da), of_a(zero, da, aa_));
        let (a_b, a_z) = (of_a(zero, db, ab), of_a(zero, dz, az));
        let (z_v, z_b) = (of_z(zero, vv_, vb, vz), of_z(zero, vb, bb, bz));
        let z_z = of_z(zero, vz, bz, zz);
        g.covariance = [
            of_h(q_hh, h_h, h_v, h_d, h_a, h_b), of_v(q_hv, h_v, h_b), of_d(q_hd, h_d, h_a),
            of_a(q_ha, h_d, h_a), h_b, of_z(q_hz, h_v, h_b, h_z),
            of_v(q_vv, v_v, v_b), of_d(zero, v_d, v_aa), of_a(zero, v_d, v_aa), v_b,
            of_z(q_vz, v_v, v_b, v_z),
            of_d(q_dd, d_d, d_a), of_a(q_da, d_d, d_a), d_b, of_z(zero, d_v, d_b, d_z),
            of_a(q_aa, a_d, a_a), a_b, of_z(zero, a_v, a_b, a_z),
            q_bb + bb, of_z(zero, vb, bb, bz),
            of_z(q_zz, z_v, z_b, z_z),
        ];
    }

    /// Moves the states of a horizontal axis on, at a measured acceleration.
    #[inline(never)]
    #[rustfmt::skip]
    pub(super) fn horizontal(&self, g: &mut Horizontal<R>, acceleration: R) {
        let (t, s, zero) = (self.t, self.half_t2, R::ZERO);
        let [kept, faster, farther] = self.course;
        let [q_pp, q_pv, q_pd, q_pa, q_vv, q_dd, q_da, q_bb, q_aa] = self.horizontal;
        // Columns of F Fᵀ, on which rows and columns of P are summed.
        let of_p = |q: R, p: R, v: R, d: R, b: R, a: R| {
            q + p + t * v - t * d - s * b - farther * a
        };
        let of_v = |q: R, v: R, b: R| q + v - t * b;
        let of_d = |q: R, d: R, a: R| q + d + faster * a;

        let [p, v, d, b, a] = g.mean;
        let (quicker, away) = (acceleration * t, acceleration * (t * t) * r(0.5));
        g.mean = [
            of_p(away, p, v, d, b, a), of_v(quicker, v, b), of_d(zero, d, a), b, kept * a,
        ];

        let [
            pp, pv, pd, pb, pa,
                vv, vd, vb, va,
                    dd, db, da,
                        bb, ba,
                            aa,
        ] = g.covariance;
        // Rows of F P.
        let (p_p, p_v) = (of_p(zero, pp, pv, pd, pb, pa), of_p(zero, pv, vv, vd, vb, va));
        let (p_d, p_b) = (of_p(zero, pd, vd, dd, db, da), of_p(zero, pb, vb, db, bb, ba));
        let p_a = of_p(zero, pa, va, da, ba, aa);
        let (v_v, v_d) = (of_v(zero, vv, vb), of_v(zero, vd, db));
        let (v_b, v_a) = (of_v(zero, vb, bb), of_v(zero, va, ba));
        let (d_d, d_b, d_a) = (of_d(zero, dd, da), of_d(zero, db, ba), of_d(zero, da, aa));
        g.covariance = [
            of_p(q_pp, p_p, p_v, p_d, p_b, p_a), of_v(q_pv, p_v, p_b), of_d(q_pd, p_d, p_a),
            p_b, q_pa + kept * p_a,
            of_v(q_vv, v_v, v_b), of_d(zero, v_d, v_a), v_b, kept * v_a,
            of_d(q_dd, d_d, d_a), d_b, q_da + kept * d_a,
            q_bb + bb, kept * ba,
            q_aa + kept * (kept * aa),
        ];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::gaussian::Gaussian;

    type Dense<const N: usize> = [[f64; N]; N];

    /// Some symmetric matrix without a zero.
    fn symmetric<const T: usize>() -> [f64; T] {
        core::array::from_fn(|k| 0.3 + (1.7 * k as f64).sin())
    }

    fn dense<const N: usize, const T: usize>(g: &Gaussian<f64, N, T>) -> Dense<N> {
        core::array::from_fn(|i| core::array::from_fn(|j| g.covariance(i, j)))
    }

    /// `F P Fᵀ + Q` and `F x + u` by all products, against what was found.
    fn compare<const N: usize>(
        f: &Dense<N>,
        [before, found]: [&Dense<N>; 2],
        q: impl Fn(usize, usize) -> f64,
        [x, u, moved]: [&[f64; N]; 3],
    ) {
        for i in 0..N {
            let mean: f64 = (0..N).map(|k| f[i][k] * x[k]).sum::<f64>() + u[i];
            // Some roundings of sums of numbers of order one.
            assert!((moved[i] - mean).abs() < 1e-13, "{i}");
            for j in 0..N {
                let mut sum = q(i.min(j), i.max(j));
                for (k, row) in before.iter().enumerate() {
                    sum += row
                        .iter()
                        .zip(&f[j])
                        .map(|(p, b)| f[i][k] * p * b)
                        .sum::<f64>();
                }
                assert!(
                    (found[i][j] - sum).abs() < 1e-13,
                    "{i} {j}: {} {sum}",
                    found[i][j]
                );
            }
        }
    }

    #[test]
    fn analytic_sparse_products_are_the_dense_ones() {
        let mut filter = RelativeFilter::<f64>::default();
        filter.deck.horizontal_acceleration_sd_mps2 = 0.7;
        filter.imu.noise_density = 0.4;
        filter.imu.bias_walk = 0.3;
        let (t, a) = (0.37, 1.3);
        let of = Transition::new(&filter, t);
        let s = of.half_t2;

        let ([mv, ma], [vv, va, av, aa]) = (of.moved, of.deck);
        let f = [
            [1.0, t, -mv, -ma, -s, 0.0],
            [0.0, 1.0, 0.0, 0.0, -t, 0.0],
            [0.0, 0.0, vv, va, 0.0, 0.0],
            [0.0, 0.0, av, aa, 0.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
            [0.0, t, 0.0, 0.0, -s, 1.0],
        ];
        let mut g = Vertical::<f64>::from_sd([1.0; 6]);
        (g.mean, g.covariance) = ([0.3, -1.2, 0.8, 0.5, 0.1, 2.0], symmetric());
        let (x, before) = (g.mean, dense(&g));
        of.vertical(&mut g, a);
        let places = [
            (0, 0),
            (0, 1),
            (0, 2),
            (0, 3),
            (0, 5),
            (1, 1),
            (1, 5),
            (2, 2),
            (2, 3),
            (3, 3),
            (4, 4),
            (5, 5),
        ];
        let noise = |i, j| {
            places
                .iter()
                .position(|&at| at == (i, j))
                .map_or(0.0, |k| of.vertical[k])
        };
        let u = [a * s, a * t, 0.0, 0.0, 0.0, a * s];
        compare(&f, [&before, &dense(&g)], noise, [&x, &u, &g.mean]);

        let [kept, faster, farther] = of.course;
        let f = [
            [1.0, t, -t, -s, -farther],
            [0.0, 1.0, 0.0, -t, 0.0],
            [0.0, 0.0, 1.0, 0.0, faster],
            [0.0, 0.0, 0.0, 1.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, kept],
        ];
        let mut g = Horizontal::<f64>::from_sd([1.0; 5]);
        (g.mean, g.covariance) = ([0.3, -1.2, 0.8, 0.1, 0.5], symmetric());
        let (x, before) = (g.mean, dense(&g));
        of.horizontal(&mut g, a);
        let places = [
            (0, 0),
            (0, 1),
            (0, 2),
            (0, 4),
            (1, 1),
            (2, 2),
            (2, 4),
            (3, 3),
            (4, 4),
        ];
        let noise = |i, j| {
            places
                .iter()
                .position(|&at| at == (i, j))
                .map_or(0.0, |k| of.horizontal[k])
        };
        let u = [a * s, a * t, 0.0, 0.0, 0.0];
        compare(&f, [&before, &dense(&g)], noise, [&x, &u, &g.mean]);
    }
}
