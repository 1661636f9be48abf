//! States that are measured at different rates, and rows that lack some of them.

use super::*;

/// The data with NaN where `keep(column, row)` does not hold.
fn thinned(problem: &Problem, of: &Dataset, keep: impl Fn(usize, usize) -> bool) -> Dataset {
    let mut data = Dataset::new(&problem.states, &problem.inputs).unwrap();
    for t in of.trajectories() {
        let mut columns = t.columns.clone();
        for (i, column) in columns.iter_mut().enumerate() {
            for (row, v) in column.iter_mut().enumerate() {
                if !keep(i, row) {
                    *v = f64::NAN;
                }
            }
        }
        data.push("run", t.time.clone(), columns, None).unwrap();
    }
    data
}

type Keep = fn(usize, usize) -> bool;

fn cases() -> [(&'static str, Problem, f64, Keep); 7] {
    [
        ("lorenz 1:5:10", problems::lorenz(), 1.0, |i, r| r % [1, 5, 10][i] == 0),
        ("lorenz 10:1:5", problems::lorenz(), 5.0, |i, r| r % [10, 1, 5][i] == 0),
        ("lv interleaved", problems::lotka_volterra(), 2.0, |i, r| r % 2 == i),
        ("lv 1:20", problems::lotka_volterra(), 2.0, |i, r| r % [1, 20][i] == 0),
        ("vdp 7:3", problems::van_der_pol(), 5.0, |i, r| r % [7, 3][i] == 0),
        ("duffing", problems::duffing(), 2.0, |i, r| i > 1 || r % [1, 8][i] == 0),
        ("rossler", problems::rossler(), 1.0, |i, r| (r * 7919 + i * 31) % 13 > i + 1),
    ]
}

#[test]
fn probe() {
    let l = || problems::lorenz();
    for (name, problem, percent, keep) in [("all", l(), 5.0, (|_, _| true) as Keep), ("10", l(), 5.0, |_, r| r % 10 == 0), ("10:1:1", l(), 5.0, |i, r| r % [10, 1, 1][i] == 0), ("10:1:5", l(), 5.0, |i, r| r % [10, 1, 5][i] == 0), ("10:5:1", l(), 5.0, |i, r| r % [10, 5, 1][i] == 0)] {
        let (mut inside, mut count, mut exacts) = (0, 0, 0);
        let mut errors = Vec::new();
        for seed in 0..20 {
            let data = thinned(&problem, &data_of(&problem, percent, seed), keep);
            let found = Identify::new(problem.library().unwrap()).run(&data, &mut quiet()).unwrap();
            let (error, exact) = against_truth(&problem, &found.model);
            errors.push(error);
            exacts += usize::from(exact);
            if !exact { println!("{name} {seed}: {:.3} {:?}", found.model, found.warnings); continue; }
            let library = problem.library().unwrap();
            for (row, equation) in problem.coefficients().iter().zip(found.model.equations()) {
                for t in equation {
                    let k = library.terms().iter().position(|x| *x == t.expression).unwrap();
                    let e = t.std_error.unwrap();
                    inside += usize::from((t.coefficient - row[k]).abs() < 1.96 * e);
                    count += 1;
                }
            }
        }
        errors.sort_by(f64::total_cmp);
        println!("{name}: {exacts} of 20 exact, {inside} of {count} intervals, median {:.2e} worst {:.2e}", errors[10], errors[19]);
    }
}
