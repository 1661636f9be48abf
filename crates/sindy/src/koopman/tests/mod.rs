//! Tests of DMDc and EDMDc.

use proptest::prelude::*;

mod comparison;

use super::*;
use crate::{Block, BlockSource, Library, Samples};

/// Three states and one input with a deterministic disturbance of 0.01.
fn linear(n: usize, phase: f64) -> Vec<Vec<f64>> {
    let mut columns = vec![Vec::new(); 4];
    let mut x = [1.0, -0.5, 0.2 + phase];
    for k in (0..n).map(|k| k as f64) {
        let u = (0.31 * k + phase).sin() + 0.5 * (1.7 * k).cos();
        for (i, column) in columns[..3].iter_mut().enumerate() {
            column.push(x[i] + 0.01 * (12.9898 * k + 78.233 * i as f64 + phase).sin());
        }
        columns[3].push(u);
        x = [
            0.9 * x[0] + 0.2 * x[1],
            -0.2 * x[0] + 0.9 * x[1] + 0.1 * x[2] + 0.1 * u,
            0.7 * x[2] + 0.5 * u,
        ];
    }
    columns
}

pub(super) fn samples(names: &[&str], groups: Vec<Vec<Vec<f64>>>) -> Samples {
    let mut samples = Samples::new(names);
    for group in groups {
        samples.push_group(group).unwrap();
    }
    samples
}

const NAMES: [&str; 4] = ["a", "b", "c", "u"];

fn dmdc(rank: Rank, ridge: f64, groups: Vec<Vec<Vec<f64>>>) -> DmdcModel {
    let method = Dmdc::new(rank, ridge).unwrap();
    let samples = samples(&NAMES, groups);
    method.fit(&samples, &NAMES[..3], &["u"], 0.5).unwrap()
}

fn close(found: impl IntoIterator<Item = f64>, expected: &[f64], tolerance: f64) {
    let found: Vec<f64> = found.into_iter().collect();
    assert_eq!(found.len(), expected.len());
    for (f, e) in found.iter().zip(expected) {
        assert!((f - e).abs() < tolerance, "{found:?} {expected:?}");
    }
}

// Made with PyDMD 2025.8 (NumPy, double precision) on the same 60 samples:
// d = DMDc(svd_rank=-1, svd_rank_omega=-1 or 3); d.fit(X, U[None, :-1]); d.eigs, d.B.
#[test]
fn xval_dmdc_of_pydmd() {
    let re_im = |m: &DmdcModel| -> Vec<f64> {
        let e = m.system.eigenvalues().unwrap();
        e.iter().flat_map(|e| [e.re, e.im]).collect()
    };
    let full = dmdc(Rank::Full, 0.0, vec![linear(60, 0.0)]);
    // Condition number below 10: a few hundred roundings.
    let eigs = [
        0.900_213_170_504_038_5,
        0.199_820_840_231_108_3,
        0.900_213_170_504_038_5,
        -0.199_820_840_231_108_3,
        0.700_948_242_578_322_8,
        0.0,
    ];
    close(re_im(&full), &eigs, 1e-12);
    let b = [
        1.980_743_338_726_225e-4,
        0.100_026_064_196_399_33,
        0.500_471_292_325_127_7,
    ];
    close(full.system.b.iter().copied(), &b, 1e-12);
    // ln|λ| / period and arg λ / period of the values above.
    let slow = full.system.continuous_eigenvalues().unwrap();
    let (re, im): (f64, f64) = (eigs[0], eigs[1]);
    close([slow[0].re], &[re.hypot(im).ln() / 0.5], 1e-11);
    close([slow[0].im], &[im.atan2(re) / 0.5], 1e-11);

    let three = dmdc(Rank::Given(3), 0.0, vec![linear(60, 0.0)]);
    assert_eq!(three.system.rank, 3);
    let eigs = [
        0.819_659_738_412_184_3,
        0.090_348_138_154_305_9,
        0.819_659_738_412_184_3,
        -0.090_348_138_154_305_9,
        0.444_668_969_838_609_7,
        0.0,
    ];
    close(re_im(&three), &eigs, 1e-12);
    let b = [
        -0.178_988_082_367_527_8,
        -0.161_514_930_668_293_9,
        0.562_285_254_499_526_9,
    ];
    close(three.system.b.iter().copied(), &b, 1e-12);
}

// Made with NumPy: the pairs of both trajectories side by side, Z = [X; U], u, s, vt = svd(Z), then
// Y vt[:3].T diag(1/s) u[:,:3].T, and Y vt.T diag(s / (s^2 + 0.01 s[0]^2)) u.T for the ridge.
#[test]
fn xval_dmdc_of_numpy_with_rank_and_ridge_over_two_trajectories() {
    let groups = || vec![linear(60, 0.0), linear(60, 1.0)];
    let three = dmdc(Rank::Given(3), 0.0, groups());
    assert_eq!((three.system.pairs, three.system.skipped), (118, 0));
    let s = [
        12.661_537_316_776_336,
        8.816_271_297_392_205,
        4.316_352_492_846_986,
        3.001_074_264_592_450_6,
    ];
    close(three.system.singular_values.iter().copied(), &s, 1e-12);
    let row = |m: &DmdcModel| -> Vec<f64> {
        m.system
            .a
            .row(0)
            .iter()
            .chain(m.system.b.row(0).iter())
            .copied()
            .collect()
    };
    let expected = [
        0.755_357_658_267_893_3,
        -0.021_997_089_121_704_5,
        0.218_399_525_880_840_4,
        -0.238_348_544_513_482_3,
    ];
    close(row(&three), &expected, 1e-12);
    let ridge = dmdc(Rank::Full, 0.01, groups());
    let expected = [
        0.829_657_120_744_122_3,
        0.183_893_108_503_482,
        0.016_961_120_419_512_8,
        -0.037_337_153_115_336,
    ];
    close(row(&ridge), &expected, 1e-12);
}

// PyDMD's compute_rank(X, 0), and the same formula in NumPy, give 3 for these 20 columns of 3 directions.
#[test]
fn xval_optimal_threshold_of_pydmd() {
    let names: Vec<String> = (0..20).map(|i| format!("x{i}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let column = |i: usize| -> Vec<f64> {
        let w = |j: usize| (1.0 + (i * (j + 1)) as f64 * 0.7).sin();
        let noise = |k: f64| 12.9898 * k * (1 + i) as f64 + 78.233 * (i * i) as f64;
        let value = |k: f64| {
            w(0) * (0.05 * k).sin()
                + w(1) * (0.11 * k).cos()
                + w(2) * (-0.01 * k).exp()
                + 0.02 * noise(k).sin()
        };
        (0..200).map(|k| value(f64::from(k))).collect()
    };
    let data = samples(&names, vec![(0..20).map(column).collect()]);
    let method = Dmdc::new(Rank::OptimalThreshold, 0.0).unwrap();
    let model = method.fit(&data, &names, &[], 1.0).unwrap();
    assert_eq!(model.system.rank, 3);
    close(
        [
            model.system.singular_values[0],
            model.system.singular_values[19],
        ],
        &[35.219_446_959_552_57, 0.190_883_969_983_1],
        // Sines of arguments near 50000 carry errors near 1e-11.
        1e-9,
    );
}

fn forced(n: usize, phase: f64) -> Vec<Vec<f64>> {
    let mut columns = vec![Vec::new(); 3];
    let (mut x, mut y) = (0.5 + 0.3 * phase, -0.4);
    for k in 0..n {
        let u = (0.31 * k as f64 + phase).sin();
        for (column, value) in columns.iter_mut().zip([x, y, u]) {
            column.push(value);
        }
        let force = (1.0 - x * x) * y - x + 0.5 * u * (1.0 + 0.2 * x);
        (x, y) = (x + 0.1 * y, y + 0.1 * force);
    }
    columns
}

// Made with NumPy: lstsq over the lifted pairs of both trajectories, eigvals, and 20 steps by a loop.
#[test]
fn xval_edmdc_of_numpy() {
    // Terms with inputs may stand anywhere.
    let library = Library::parse(&["1", "x", "u", "y", "x^2", "x*y", "sin(y)", "x*u"]).unwrap();
    let data = samples(&["x", "y", "u"], vec![forced(200, 0.0), forced(200, 1.0)]);
    let method = Edmdc::new(library, Rank::Full, 0.0).unwrap();
    let model = method.fit(&data, &["x", "y"], &["u"], 0.1).unwrap();
    assert_eq!(model.system.pairs, 398);
    let a = [
        -1.010_066_664_923_01e-2,
        -0.116_164_538_540_347_08,
        1.055_581_077_588_82,
        -1.033_414_032_683_083e-3,
        -9.601_201_680_880_371e-3,
        -0.162_081_153_646_663_42,
    ];
    // y and sin(y) are nearly alike: condition number of order 100 and more.
    close(model.system.a.row(2).iter().copied(), &a, 1e-10);
    let b = [0.065_187_550_579_415, -0.004_168_259_629_85];
    close(model.system.b.row(2).iter().copied(), &b, 1e-10);
    let e = model.system.eigenvalues().unwrap();
    let expected = [1.0, 0.975_918_787_617_795, 0.190_652_639_741_519_58];
    close([e[0].re, e[1].re, e[1].im], &expected, 1e-10);

    let u: Vec<f64> = (0..20).map(|k| (0.2 * f64::from(k)).sin()).collect();
    for (lifting, expected) in [
        (
            Lifting::Once,
            [0.251_086_104_492_183_3, -0.332_418_223_773_676_9],
        ),
        (
            Lifting::EveryStep,
            [0.317_812_058_199_046_1, -0.303_379_283_498_303_5],
        ),
    ] {
        let run = model.simulate(&[0.3, 0.2], 20, &[&u], lifting).unwrap();
        assert_eq!(run.outcome, RunOutcome::Finished);
        close(run.states.iter().map(|c| c[20]), &expected, 1e-9);
        let one = model.predict(&[0.3, 0.2], &[u[0]]).unwrap();
        close(run.states.iter().map(|c| c[1]), &one, 1e-15);
    }
}

// Made with NumPy: lstsq of x on [1, exp(-x), x y, y] over the first 199 samples.
#[test]
fn xval_projection_of_a_state_that_is_no_observable() {
    let library = Library::parse(&["1", "exp(-x)", "x*y", "y"]).unwrap();
    let data = samples(&["x", "y", "u"], vec![forced(200, 0.0)]);
    let method = Edmdc::new(library, Rank::Full, 0.0).unwrap();
    let model = method.fit(&data, &["x", "y"], &[], 0.1).unwrap();
    let expected = [
        1.059_556_010_630_555,
        -0.468_833_450_246_033,
        0.005_981_062_237_604_6,
        0.007_874_292_619_603_1,
    ];
    close(model.c().row(0).iter().copied(), &expected, 1e-11);
    assert_eq!(model.c().row(1).iter().copied().sum::<f64>(), 1.0);
}

#[test]
fn analytic_a_nonlinear_system_with_a_finite_koopman_form() {
    // x' = μ x, y' = λ (y - x^2) (Brunton et al. 2016): eigenvalues μ, λ and 2 μ over x, y, x^2.
    let (mu, lambda, dt): (f64, f64, f64) = (-0.1, -1.0, 0.2);
    // y = c x^2 + d e^{λt} with c = λ / (λ - 2 μ).
    let c = lambda / (lambda - 2.0 * mu);
    let group = |x0: f64, d: f64| -> Vec<Vec<f64>> {
        let time = (0..40).map(|k| dt * f64::from(k));
        let rows = time.map(|t| (x0 * (mu * t).exp(), (lambda * t).exp()));
        let (x, y) = rows.map(|(x, e)| (x, c * x * x + d * e)).unzip();
        vec![x, y]
    };
    let data = samples(&["x", "y"], vec![group(1.0, 0.5), group(-2.0, 1.0)]);
    let library = Library::parse(&["x", "y", "x^2"]).unwrap();
    let method = Edmdc::new(library, Rank::Full, 0.0).unwrap();
    let model = method.fit(&data, &["x", "y"], &[], dt).unwrap();
    let found = model.system.continuous_eigenvalues().unwrap();
    // Rounding, divided by the period.
    close(found.iter().map(|e| e.re), &[mu, 2.0 * mu, lambda], 1e-10);
    assert!(model.system.residual_rms.iter().all(|r| *r < 1e-13));
}

#[test]
fn prop_pairs_never_cross_groups_nor_unusable_rows() {
    let mut broken = linear(600, 0.0);
    broken[1][300] = f64::NAN;
    broken[3][400] = f64::INFINITY;
    broken[0][500] = 1e200;
    let part = |from: usize, to: usize| -> Vec<Vec<f64>> {
        broken.iter().map(|c| c[from..to].to_vec()).collect()
    };
    // An unusable input ends no pair: row 400 still follows row 399.
    let mut parts = vec![part(0, 300), part(301, 401), part(401, 500), part(501, 600)];
    parts[1][3][99] = 0.0;
    let whole = dmdc(Rank::Full, 0.0, vec![broken.clone(), linear(50, 2.0)]);
    parts.push(linear(50, 2.0));
    let apart = dmdc(Rank::Full, 0.0, parts);
    assert_eq!(
        (whole.system.pairs, whole.system.skipped),
        (299 + 99 + 98 + 98 + 49, 3)
    );
    assert_eq!(apart.system.pairs, whole.system.pairs);
    // The same pairs in the same order.
    assert_eq!(
        (whole.system.a, whole.system.b),
        (apart.system.a, apart.system.b)
    );
}

/// One group in blocks of given lengths.
struct Pieces(Vec<String>, Vec<Vec<f64>>, usize);

impl BlockSource for Pieces {
    fn names(&self) -> &[String] {
        &self.0
    }
    fn groups(&self) -> usize {
        1
    }
    fn for_each_block(&self, visit: &mut dyn FnMut(Block<'_>)) {
        let n = self.1[0].len();
        for start in (0..n).step_by(self.2) {
            let end = n.min(start + self.2);
            let columns: Vec<&[f64]> = self.1.iter().map(|c| &c[start..end]).collect();
            visit(Block {
                group: 0,
                columns: &columns,
            });
        }
    }
}

proptest! {
    #[test]
    fn prop_blocks_do_not_matter(length in 1_usize..400, n in 2_usize..700) {
        let method = Dmdc::new(Rank::Full, 0.0).unwrap();
        let pieces = Pieces(NAMES.map(String::from).to_vec(), linear(n, 0.3), length);
        let one = method.fit(&pieces, &NAMES[..3], &["u"], 0.5).unwrap();
        prop_assert_eq!(one, dmdc(Rank::Full, 0.0, vec![linear(n, 0.3)]));
    }

    #[test]
    fn prop_any_numbers_give_a_finite_fit_or_an_error(
        values in prop::collection::vec(prop::num::f64::ANY, 0..60),
    ) {
        let data = samples(&["x", "y"], vec![vec![values.clone(), values]]);
        for rank in [Rank::Full, Rank::Given(1), Rank::OptimalThreshold] {
            let method = Dmdc::new(rank, 0.0).unwrap();
            match method.fit(&data, &["x"], &["y"], 1.0) {
                Ok(model) => {
                    prop_assert!(model.system.rank <= 1, "two equal columns");
                    prop_assert!(model.system.a[(0, 0)].is_finite() && model.system.b[(0, 0)].is_finite());
                }
                Err(e) => prop_assert_eq!(e, SindyError::TooShort { needed: 2, found: 1 }),
            }
        }
    }
}

#[test]
fn prop_bad_input_is_a_clear_error_and_growth_an_outcome() {
    let data = samples(&NAMES, vec![linear(20, 0.0)]);
    let method = Dmdc::new(Rank::Full, 0.0).unwrap();
    let fit = |states: &[&str], inputs: &[&str], period: f64| {
        method.fit(&data, states, inputs, period).map(|_| ())
    };
    for (states, inputs, period, word) in [
        (&[] as &[&str], &["u"] as &[&str], 1.0, "`states`"),
        (&["a", "a"], &[], 1.0, "each name once"),
        (&["a", "q"], &[], 1.0, "q"),
        (&["a"], &["q"], 1.0, "q"),
        (&["a"], &[], 0.0, "`period`"),
        (&["a"], &[], f64::NAN, "`period`"),
    ] {
        let error = fit(states, inputs, period).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
    assert!(Dmdc::new(Rank::Given(0), 0.0).is_err() && Dmdc::new(Rank::Full, -1.0).is_err());
    let three = Dmdc::new(Rank::Given(3), 0.0).unwrap();
    assert!(three.fit(&data, &["a"], &["u"], 1.0).is_err());
    let library = Library::parse(&["u", "a*u"]).unwrap();
    assert!(Edmdc::new(library.clone(), Rank::Given(3), 0.0).is_err());
    let edmdc = Edmdc::new(library, Rank::Full, 0.0).unwrap();
    assert!(edmdc.fit(&data, &["a"], &["u"], 1.0).is_err());

    // x doubles: 2^499 exceeds 10^150.
    let x: Vec<f64> = (0..20).map(|k| 2.0_f64.powi(k)).collect();
    let model = method
        .fit(&samples(&["x"], vec![vec![x]]), &["x"], &[], 1.0)
        .unwrap();
    let run = model.simulate(&[1.0], 600, &[]).unwrap();
    assert_eq!(run.outcome, RunOutcome::BlewUp { time: 499.0 });
    assert!(model.predict(&[1.0, 2.0], &[]).is_err() && model.predict(&[f64::NAN], &[]).is_err());
    assert!(model.simulate(&[1.0], 2, &[&[1.0, 2.0]]).is_err());
    let zeros = samples(&["x"], vec![vec![vec![0.0; 9]]]);
    let nothing = method.fit(&zeros, &["x"], &[], 1.0).unwrap();
    assert_eq!((nothing.system.rank, nothing.system.a[(0, 0)]), (0, 0.0));
}
