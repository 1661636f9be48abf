use super::*;

fn example() -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let i = || (0..30).map(f64::from);
    let t: Vec<f64> = i().map(|i| 0.1 * i + 0.03 * (2.0 * i).sin()).collect();
    let y = t
        .iter()
        .zip(i())
        .map(|(t, i)| (1.7 * t).sin() + 0.2 * (5.0 * t).cos() + 0.1 * (37.0 * i * i).sin())
        .collect();
    (t, y, i().map(|i| 1.0 + 0.5 * i.cos()).collect())
}

const SAMPLES: [usize; 6] = [0, 1, 7, 15, 28, 29];

/// Made with SciPy 1.17.1 on NumPy 2.4.6: `i = arange(30); t = 0.1*i + 0.03*sin(2*i)`,
/// `y = sin(1.7*t) + 0.2*cos(5*t) + 0.1*sin(37*i*i)`, `w = 1 + 0.5*cos(i)`,
/// `s = make_smoothing_spline(t, y, w=w or None, lam=lam)`; `s(t[k])`, `s.derivative()(t[k])`.
#[test]
fn xval_scipy_smoothing_spline() {
    let expected = [
        (
            0.0001,
            false,
            [
                (0.19767843450253214, 0.9125408970037663),
                (0.32180375115887594, 1.1005868223132418),
                (0.7320022846803191, 0.8473559813868605),
                (0.7113377024210021, -2.900374464281186),
                (-1.0367504525646534, -0.5047399518937516),
                (-1.0247545685380453, 0.3760961040038923),
            ],
        ),
        (
            0.0001,
            true,
            [
                (0.19811594447033376, 0.8804812251244303),
                (0.31989452351797226, 1.1093929007568497),
                (0.7327918019849391, 0.8432979972183317),
                (0.7208342490888245, -2.9147532638334375),
                (-1.0286712230496327, -0.46853582040282155),
                (-1.0272616357211666, 0.24880646208491922),
            ],
        ),
        (
            0.01,
            false,
            [
                (0.21316625846255993, 0.9547975366734162),
                (0.3342394000018374, 0.9441329172252189),
                (0.8146153755168035, 0.7483161354872533),
                (0.6609202322362607, -2.010400979177937),
                (-0.9781001489091466, -0.6900233369795528),
                (-1.0726837575910793, -0.6305282461941398),
            ],
        ),
        (
            0.01,
            true,
            [
                (0.20942023775078045, 0.9327840583061624),
                (0.32765839609987985, 0.9213385229998361),
                (0.8066880815494235, 0.7936530426579023),
                (0.6742069098196097, -2.0706122183566635),
                (-0.9714786282842222, -0.7094424831662776),
                (-1.0711428467875936, -0.6732203285336538),
            ],
        ),
        (
            1.0,
            false,
            [
                (0.6226004450858897, 0.1779017034866955),
                (0.6450983550009659, 0.17447865590009917),
                (0.7027724325680694, -0.05507943778542982),
                (0.39180783344574616, -0.8116007773909009),
                (-0.9856239513438987, -1.0906672197528353),
                (-1.1441117192701722, -1.0893168941149294),
            ],
        ),
        (
            1.0,
            true,
            [
                (0.5806210349330088, 0.2351549016927523),
                (0.6103550960378155, 0.23053037775937454),
                (0.6950871260658654, -0.02236428154419417),
                (0.3958047182379439, -0.8175378925923918),
                (-0.9942432395921122, -1.1029689562558318),
                (-1.1545623430990495, -1.1020545096188554),
            ],
        ),
    ];
    let (t, y, w) = example();
    for (lambda, weighted, points) in expected {
        let spline = SmoothingSpline::new(lambda).unwrap();
        let fit = spline
            .fit(&t, &y, weighted.then_some(&w[..]))
            .unwrap()
            .smoothed;
        for (k, (value, slope)) in SAMPLES.into_iter().zip(points) {
            // Rounding through equations of condition 1e3 (SciPy's B-splines and ours).
            assert!((fit.value[k] - value).abs() < 1e-11, "{lambda} {k}");
            assert!((fit.derivative[k] - slope).abs() < 1e-10, "{lambda} {k}");
        }
    }
}

/// As above with `lam=None`: SciPy's own cross-validation.
#[test]
fn xval_scipy_cross_validation() {
    let expected = [
        (0.1952786205118995, 1.0174288686367225),
        (0.3278005184585895, 1.0887206610909477),
        (0.7471573869497488, 0.7443032855365933),
        (0.7207598145181559, -2.6324058318446126),
        (-1.0142638595802307, -0.5021432942311982),
        (-1.0407664148849562, -0.0222769901500916),
    ];
    let (t, y, _) = example();
    let fit = SmoothingSpline::cross_validated()
        .fit(&t, &y, None)
        .unwrap()
        .smoothed;
    for (k, (value, slope)) in SAMPLES.into_iter().zip(expected) {
        // SciPy's search stops when λ is known to 1e-5, of some 7e-4: a percent of it.
        assert!((fit.value[k] - value).abs() < 1e-3, "{k} {}", fit.value[k]);
        assert!(
            (fit.derivative[k] - slope).abs() < 1e-2,
            "{k} {}",
            fit.derivative[k]
        );
    }
}

#[test]
fn analytic_a_line_passes_and_infinite_smoothing_is_the_weighted_line() {
    let t: Vec<f64> = (0..20).map(|i| 0.1 * f64::from(i * i)).collect();
    let line: Vec<f64> = t.iter().map(|t| 2.0 - 3.0 * t).collect();
    let fit = SmoothingSpline::new(1.0)
        .unwrap()
        .fit(&t, &line, None)
        .unwrap();
    for i in 0..20 {
        // Rounding of values up to 100.
        assert!((fit.smoothed.value[i] - line[i]).abs() < 1e-11);
        assert!((fit.smoothed.derivative[i] + 3.0).abs() < 1e-11);
    }
    // λ of 1e9 mean periods cubed: the smoothest bend is damped by 1e-6 or so, leaving tr H = 2.
    let y: Vec<f64> = t.iter().map(|t| t.sin()).collect();
    let fit = SmoothingSpline::new(1e12)
        .unwrap()
        .fit(&t, &y, None)
        .unwrap();
    assert!((fit.degrees_of_freedom - 2.0).abs() < 1e-4);
}

#[test]
fn prop_cross_validation_finds_the_noise() {
    use crate::derivative::tests::signals::{gauss, lorenz};
    let (t, x, dx) = lorenz(3000, 0.004);
    let y: Vec<f64> = x
        .iter()
        .zip(gauss(3, 3000))
        .map(|(x, e)| x + 0.4 * e)
        .collect();
    let fit = SmoothingSpline::cross_validated()
        .fit(&t, &y, None)
        .unwrap();
    // Scatter of a standard deviation over 3000 samples is 1.3 %; GCV adds a little.
    assert!((fit.noise / 0.4 - 1.0).abs() < 0.06, "{}", fit.noise);
    let rms = |a: &[f64], b: &[f64]| {
        (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / 3000.0).sqrt()
    };
    // The noise is cut to below a third; plain differences would err by 0.4 / (√2 0.004) = 70.
    assert!(rms(&fit.smoothed.value, &x) < 0.14);
    assert!(rms(&fit.smoothed.derivative, &dx) < 5.0);
}

#[test]
fn prop_bad_input_is_named() {
    let s = SmoothingSpline::cross_validated();
    let t = [0.0, 1.0, 2.0, 3.0, 4.0];
    assert!(SmoothingSpline::new(0.0).is_err() && SmoothingSpline::new(f64::NAN).is_err());
    assert!(matches!(
        s.fit(&t, &t, Some(&[1.0; 4])),
        Err(SindyError::Shape { .. })
    ));
    assert!(matches!(
        s.fit(&t, &t, Some(&[1.0, 0.0, 1.0, 1.0, 1.0])),
        Err(SindyError::Setting { key: "weights", .. })
    ));
    assert!(matches!(
        s.fit(&t[..3], &t[..3], None),
        Err(SindyError::TooShort { .. })
    ));
    // A constant leaves nothing to validate: still numbers, not NaN.
    let flat = s.fit(&t, &[2.0; 5], None).unwrap();
    assert!(flat.smoothed.derivative.iter().all(|d| *d == 0.0));
    assert_eq!(flat.noise, 0.0);
}
