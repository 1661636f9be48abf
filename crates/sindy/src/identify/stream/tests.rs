use super::Columns;
use crate::identify::{Identification, Identify, Method, Settings, Smoothing};
use crate::problems::{self, Problem, Record};
use crate::{Dataset, Library, Outcome, OwnedBlock, SindyError, Stream};

/// The rows of the records in blocks of `size`.
fn source(
    problem: &Problem,
    records: &[Record],
    size: usize,
) -> Stream<std::vec::IntoIter<Result<OwnedBlock, SindyError>>> {
    let names = std::iter::once("t").chain(problem.states.iter().chain(&problem.inputs).copied());
    let names: Vec<&str> = names.collect();
    let mut blocks = Vec::new();
    for (group, r) in records.iter().enumerate() {
        for start in (0..r.time.len()).step_by(size) {
            let rows = start..r.time.len().min(start + size);
            let all = std::iter::once(&r.time).chain(&r.states).chain(&r.inputs);
            let columns = all.map(|c| c[rows.clone()].to_vec()).collect();
            blocks.push(Ok(OwnedBlock { group, columns }));
        }
    }
    Stream::new(&names, records.len(), blocks)
}

fn library(problem: &Problem) -> Library {
    let names: Vec<&str> = problem
        .states
        .iter()
        .chain(&problem.inputs)
        .copied()
        .collect();
    Library::polynomial(&names, 3).unwrap()
}

fn streamed(
    problem: &Problem,
    records: &[Record],
    size: usize,
    settings: &Settings,
) -> Identification {
    let columns = Columns::new("t", &problem.states, &problem.inputs).unwrap();
    let identify = Identify::new(library(problem))
        .settings(settings.clone())
        .unwrap();
    identify
        .run_stream(&source(problem, records, size), &columns, &mut |_| ())
        .unwrap()
}

fn in_memory(problem: &Problem, records: &[Record], settings: &Settings) -> Identification {
    let mut data = Dataset::new(&problem.states, &problem.inputs).unwrap();
    for r in records {
        let columns = r.states.iter().chain(&r.inputs).cloned().collect();
        data.push("run", r.time.clone(), columns, None).unwrap();
    }
    let identify = Identify::new(library(problem))
        .settings(settings.clone())
        .unwrap();
    identify.run(&data, &mut |_| ()).unwrap()
}

/// Terms, coefficients and standard errors of all equations.
fn terms(found: &Identification) -> Vec<(String, f64, Option<f64>)> {
    let all = found.model.equations().iter().flatten();
    all.map(|t| (t.expression.to_string(), t.coefficient, t.std_error))
        .collect()
}

/// A damped oscillation that is pushed again and again, so that it never dies down; so many rows.
pub(super) fn long_run(rows: usize, noise: f64) -> (Problem, Record) {
    let problem = problems::damped_oscillator();
    let (a, b) = (-0.1, 2.0); // x' = a x + b y, y' = -b x + a y, of the linear problem
    let mut record = Record {
        time: Vec::new(),
        states: vec![Vec::new(); 2],
        inputs: Vec::new(),
        derivatives: Vec::new(),
    };
    let mut random = 1_u64;
    let mut jitter = || {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        noise * ((random >> 40) as f64 / f64::from(1 << 23) - 1.0)
    };
    for i in 0..rows {
        let (since, t) = (0.01 * (i % 2000) as f64, 0.01 * i as f64);
        // A gap of a second before each push: a stretch of its own.
        let t = t + (i / 2000) as f64;
        let size = (a * since).exp() * (2.0 + (i / 2000 % 3) as f64);
        record.time.push(t);
        record.states[0].push(size * (b * since).sin() + jitter());
        record.states[1].push(size * (b * since).cos() + jitter());
    }
    (
        Problem {
            states: vec!["x", "y"],
            inputs: vec![],
            ..problem
        },
        record,
    )
}

#[test]
fn prop_windows_give_the_regression_of_whole_trajectories() {
    // 130 stretches over four windows and more.
    let (problem, record) = long_run(260_000, 1e-3);
    for smoothing in [
        Smoothing::FiniteDifference { order: 4 },
        Smoothing::SavitzkyGolay {
            window: 31,
            degree: 3,
        },
    ] {
        let settings = Settings {
            method: Method::Regression,
            smoothing,
            ..Settings::default()
        };
        let records = [record.clone()];
        let (whole, found) = (
            in_memory(&problem, &records, &settings),
            streamed(&problem, &records, 7001, &settings),
        );
        let (whole, found_terms) = (terms(&whole), terms(&found));
        assert_eq!(whole.len(), 4, "{whole:?}");
        for (a, b) in whole.iter().zip(&found_terms) {
            // The same rows, summed in another order.
            assert!(
                a.0 == b.0 && (a.1 - b.1).abs() < 1e-9,
                "{whole:?} {found_terms:?}"
            );
        }
        assert_eq!(
            (found.data.rows, found.data.stretches, found.data.holes),
            (260_000, 130, 129)
        );
        assert_eq!(found.outcome, Outcome::Converged);
        let fewer = |c: &&crate::identify::Candidate| c.name.contains("penalised as 50000 rows");
        assert_eq!(found.candidates.iter().filter(fewer).count(), 1);
    }
}

#[test]
fn prop_the_size_of_blocks_does_not_matter() {
    let (problem, record) = long_run(70_000, 1e-2);
    let settings = Settings::default();
    let records = [record];
    let one = streamed(&problem, &records, 70_000, &settings);
    for size in [1_111, 40_000] {
        let other = streamed(&problem, &records, size, &settings);
        assert_eq!(one.data, other.data);
        assert_eq!(terms(&one), terms(&other), "{size}");
    }
}

#[test]
fn analytic_supports_of_noisy_problems_with_nothing_set() {
    for (problem, percent, tolerance, extra) in [
        // Errors of regression on slopes or in weak form at this noise, with room for another seed.
        (problems::lorenz(), 1.0, 5e-3, 0),
        (problems::lotka_volterra(), 1.0, 1e-2, 0),
        (problems::duffing(), 0.5, 3e-2, 1),
    ] {
        let records = problem.noisy(percent, 3).unwrap();
        let found = streamed(&problem, &records, 997, &Settings::default());
        for (equation, truth) in found.model.equations().iter().zip(&problem.truth) {
            let largest = truth.iter().fold(0.0_f64, |m, (_, c)| m.max(c.abs()));
            // Regression may take a term of no account along; the output error, which a stream lacks, would not.
            let size = |t: &&crate::model::Term| t.coefficient.abs() > 1e-3 * largest;
            let counted = equation.iter().filter(size).count();
            assert!(
                counted == truth.len() && equation.len() <= truth.len() + extra,
                "{}",
                found.model
            );
            for (name, value) in truth {
                let own = equation.iter().find(|t| t.expression.to_string() == *name);
                let own = own.unwrap_or_else(|| panic!("{name}: {}", found.model));
                let error = (own.coefficient - value).abs();
                assert!(error < tolerance * largest, "{name}: {}", found.model);
                assert!(own.std_error.is_some_and(|e| e > 0.0 && e < 0.1 * largest));
            }
        }
        for equation in &found.equations {
            assert!(equation.front.iter().all(|p| p.proven));
            assert_eq!(equation.front.iter().filter(|p| p.chosen).count(), 1);
        }
    }
}

#[test]
fn analytic_standard_errors_cover_the_truth() {
    let (problem, record) = long_run(200_000, 0.05);
    let settings = Settings {
        smoothing: Smoothing::Weak,
        ..Settings::default()
    };
    let found = streamed(&problem, &[record], 10_000, &settings);
    let terms = terms(&found);
    assert_eq!(terms.len(), 4, "{}", found.model);
    for ((name, value, error), truth) in terms.iter().zip([-0.1, 2.0, -2.0, -0.1]) {
        let error = error.unwrap();
        // Four terms within four standard errors: one in 4000 draws is not.
        assert!(
            (value - truth).abs() < 4.0 * error && error < 5e-3,
            "{name}: {value} ± {error}"
        );
    }
}

#[test]
fn analytic_weights_and_discrete_time() {
    // x' = 0.9 x, with rows of weight 0 that say otherwise.
    let mut x = vec![1.0];
    for i in 1..3000 {
        x.push(if i % 50 == 0 { 1.0 } else { 0.9 * x[i - 1] });
    }
    let weights: Vec<f64> = (0..3000)
        .map(|i| f64::from(u8::from((i + 1) % 50 != 0)))
        .collect();
    let time: Vec<f64> = (0..3000).map(f64::from).collect();
    let blocks = (0..30).map(|k| {
        let part = |c: &Vec<f64>| c[100 * k..100 * k + 100].to_vec();
        Ok(OwnedBlock {
            group: 0,
            columns: vec![part(&weights), part(&x), part(&time)],
        })
    });
    let source = Stream::new(&["w", "x", "t"], 1, blocks);
    let columns = Columns::new("t", &["x"], &[]).unwrap().weights("w");
    let settings = Settings {
        discrete: true,
        ..Settings::default()
    };
    let identify = Identify::new(Library::polynomial(&["x"], 3).unwrap());
    let found = identify
        .settings(settings)
        .unwrap()
        .run_stream(&source, &columns, &mut |_| ())
        .unwrap();
    let terms = terms(&found);
    assert_eq!(terms.len(), 1, "{}", found.model);
    assert!(
        terms[0].0 == "x" && (terms[0].1 - 0.9).abs() < 1e-12,
        "{terms:?}"
    );
}

#[test]
fn prop_rows_without_weight_are_bridged_or_missing() {
    let (problem, mut record) = long_run(60_000, 1e-3);
    let mut weights = vec![2.0; 60_000];
    // Single spikes, and in every stretch a longer run of nonsense.
    for i in (90..60_000).step_by(200) {
        let rows = if i % 2000 == 490 { i..i + 10 } else { i..i + 1 };
        for k in rows {
            record.states[0][k] = 1e6;
            weights[k] = 0.0;
        }
    }
    let blocks = (0..60).map(|k| {
        let part = |c: &Vec<f64>| c[1000 * k..1000 * k + 1000].to_vec();
        let [x, y] = [&record.states[0], &record.states[1]];
        Ok(OwnedBlock {
            group: 0,
            columns: [&record.time, x, y, &weights].map(part).to_vec(),
        })
    });
    let source = Stream::new(&["t", "x", "y", "w"], 1, blocks);
    let columns = Columns::new("t", &["x", "y"], &[]).unwrap().weights("w");
    let found = Identify::new(library(&problem))
        .run_stream(&source, &columns, &mut |_| ())
        .unwrap();
    assert_eq!((found.data.missing_rows, found.data.stretches), (300, 60));
    for ((name, value, _), truth) in terms(&found).iter().zip([-0.1, 2.0, -2.0, -0.1]) {
        // Noise of 1e-3 on 60 000 rows, and straight lines through curves of that order.
        assert!((value - truth).abs() < 5e-3, "{name}: {}", found.model);
    }
    assert_eq!(found.model.terms(), 4, "{}", found.model);
}

#[test]
fn prop_gaps_are_counted_across_windows() {
    let (problem, mut record) = long_run(100_000, 1e-3);
    for i in (17..100_000).step_by(1000) {
        record.states[0][i] = f64::NAN;
    }
    let found = streamed(&problem, &[record], 3000, &Settings::default());
    assert_eq!(found.data.missing_rows, 100);
    assert_eq!((found.data.holes, found.data.stretches), (49, 150));
    assert!(
        found.warnings[0].contains("150 stretches"),
        "{:?}",
        found.warnings
    );
    assert_eq!(found.model.terms(), 4, "{}", found.model);
}

#[test]
fn prop_collinear_terms_are_named() {
    let (problem, mut record) = long_run(20_000, 1e-3);
    let twin = record.states[0].clone();
    record.inputs = vec![twin];
    let problem = Problem {
        inputs: vec!["u"],
        ..problem
    };
    let found = streamed(&problem, &[record], 3000, &Settings::default());
    let warning = found.warnings.iter().find(|w| w.contains("collinear"));
    assert!(
        warning.is_some_and(|w| w.contains('x') && w.contains('u')),
        "{:?}",
        found.warnings
    );
}

#[test]
fn prop_bad_input_is_one_clear_error() {
    type Case<'a> = (Vec<Vec<f64>>, &'a str);
    let ramp = |n: usize| (0..n).map(|i| 0.1 * i as f64).collect::<Vec<f64>>();
    let mut back = ramp(200);
    back[150] = 0.0;
    let mut infinite = ramp(200);
    infinite[120] = f64::INFINITY;
    let cases: Vec<Case<'_>> = vec![
        (vec![vec![], vec![]], "too few samples"),
        (vec![ramp(2), ramp(2)], "too few samples"),
        (vec![ramp(3), ramp(3)], "usable rows"),
        (
            vec![back, ramp(200)],
            "time does not increase at sample 150",
        ),
        (vec![ramp(200), infinite], "column `x`: sample 120"),
        (
            vec![ramp(50), vec![f64::NAN; 50]],
            "rows in succession that hold all states",
        ),
    ];
    let identify = Identify::new(Library::polynomial(&["x"], 3).unwrap());
    let columns = Columns::new("t", &["x"], &[]).unwrap();
    for (rows, says) in cases {
        let blocks = (0..rows[0].len().div_ceil(40)).map(|k| {
            let part = |c: &Vec<f64>| c[40 * k..c.len().min(40 * k + 40)].to_vec();
            Ok(OwnedBlock {
                group: 0,
                columns: rows.iter().map(part).collect(),
            })
        });
        let source = Stream::new(&["t", "x"], 1, blocks);
        let error = identify
            .run_stream(&source, &columns, &mut |_| ())
            .unwrap_err()
            .to_string();
        assert!(error.contains(says), "{says}: {error}");
    }
    let none = || Stream::new(&["t", "x"], 1, Vec::new());
    for columns in [
        Columns::new("s", &["x"], &[]).unwrap(),
        Columns::new("t", &["y"], &[]).unwrap(),
        columns.clone().weights("w"),
    ] {
        assert!(matches!(
            identify.run_stream(&none(), &columns, &mut |_| ()),
            Err(SindyError::UnknownColumn { .. })
        ));
    }
    assert!(Columns::new("x", &["x"], &[]).is_err());
    let followed = Settings {
        method: Method::OutputError,
        ..Settings::default()
    };
    let error = identify
        .settings(followed)
        .unwrap()
        .run_stream(&none(), &columns, &mut |_| ())
        .unwrap_err();
    assert!(error.to_string().contains("`method`"), "{error}");
}
