//! Gross errors in single samples of the states, before anything is fitted.

use crate::data::dataset::Dataset;
use crate::data::dataset::sampling::pick;
use crate::derivative::spikes;
use crate::error::SindyError;

/// Places that a warning names, for each state: enough to find them in a file.
const NAMED: usize = 3;

/// The data with the states' spikes replaced by the values that their neighbours predict, at weight 0, and the warnings
/// about it; `None` where there are none. Inputs are left alone: theirs may be meant.
pub(super) fn set_aside(data: &Dataset) -> Result<Option<(Dataset, Vec<String>)>, SindyError> {
    let mut values = Vec::new();
    let mut warnings = Vec::new();
    for (i, state) in data.states().iter().enumerate() {
        let before = values.len();
        let mut places = Vec::new();
        for (index, trajectory) in data.trajectories().iter().enumerate() {
            for range in trajectory.ranges() {
                let own = trajectory.measured_rows(i, range);
                let time = pick(&trajectory.time[range.clone()], own.as_deref());
                let column = pick(&trajectory.columns[i][range.clone()], own.as_deref());
                for spike in spikes(&time, &column)? {
                    let row = range.start + own.as_ref().map_or(spike.row, |own| own[spike.row]);
                    values.push((index, row, i, spike.value));
                    if places.len() < NAMED {
                        places.push(format!(
                            "{} at time {} ({:.2e} times the noise)",
                            trajectory.name, trajectory.time[row], spike.distance
                        ));
                    }
                }
            }
        }
        let count = values.len() - before;
        if count > 0 {
            let more = if count > NAMED { ", …" } else { "" };
            warnings.push(format!(
                "{count} of {} values of {state} are taken for outliers, which single samples far off their neighbours \
                 are, and have no weight: {}{more} (`outliers = false` in the settings keeps them)",
                data.report().rows,
                places.join(", "),
            ));
        }
    }
    Ok((!values.is_empty()).then(|| (data.mended(&values), warnings)))
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};

    use crate::identify::tests::{against_truth, data_of, quiet};
    use crate::identify::{Identify, Method, Settings};
    use crate::{Dataset, problems};

    #[test]
    fn analytic_one_percent_of_gross_errors_does_no_harm() {
        for (problem, percent) in [
            (problems::lorenz(), 1.0),
            (problems::lotka_volterra(), 5.0),
            (problems::van_der_pol(), 0.0),
        ] {
            let clean = data_of(&problem, percent, 5);
            let mut random = rand_pcg::Pcg64::seed_from_u64(9);
            let mut spoilt = Dataset::new(&problem.states, &problem.inputs).unwrap();
            let mut wrong = 0;
            for t in clean.trajectories() {
                let mut columns = t.columns.clone();
                for column in columns.iter_mut().take(problem.states.len()) {
                    for v in column.iter_mut() {
                        if random.random_range(0.0..1.0) < 0.01 {
                            *v += random.random_range(5.0..100.0);
                            wrong += 1;
                        }
                    }
                }
                spoilt
                    .push("run", t.time.clone(), columns, t.weights.clone())
                    .unwrap();
            }
            let library = problem.library().unwrap();
            let identify = Identify::new(library);
            let without = identify.run(&clean, &mut quiet()).unwrap();
            assert!(!without.warnings.iter().any(|w| w.contains("outliers")));
            let found = identify.run(&spoilt, &mut quiet()).unwrap();
            let ((error, exact), (before, _)) = (
                against_truth(&problem, &found.model),
                against_truth(&problem, &without.model),
            );
            // A hundredth of the rows less changes estimates by a part of their own error; and the floor for data without noise.
            assert!(
                exact && error < 1.5 * before + 2e-5,
                "{}: {error}, {before} without outliers ({wrong} of them): {} {:?}",
                problem.name,
                found.model,
                found.warnings
            );
            let said = found
                .warnings
                .iter()
                .filter(|w| w.contains("taken for outliers"))
                .count();
            assert_eq!(said, problem.states.len(), "{:?}", found.warnings);
        }
    }

    #[test]
    fn analytic_lines_through_lost_rows_are_no_outliers() {
        // Without noise a straight line is far off the signal.
        let problem = problems::van_der_pol();
        let clean = data_of(&problem, 0.0, 1);
        let mut data = Dataset::new(&problem.states, &problem.inputs).unwrap();
        for t in clean.trajectories() {
            let mut columns = t.columns.clone();
            for column in &mut columns {
                (30..t.time.len())
                    .step_by(41)
                    .for_each(|row| column[row] = f64::NAN);
            }
            data.push("run", t.time.clone(), columns, None).unwrap();
        }
        let identify = Identify::new(problem.library().unwrap());
        let said = identify.run(&data, &mut quiet()).unwrap().warnings;
        assert!(!said.iter().any(|w| w.contains("outliers")), "{said:?}");
        assert!(said.iter().any(|w| w.contains("straight lines")));
    }

    #[test]
    fn prop_outliers_are_kept_where_that_is_asked_for() {
        let problem = problems::lotka_volterra();
        let clean = data_of(&problem, 1.0, 2);
        let mut data = Dataset::new(&problem.states, &problem.inputs).unwrap();
        for t in clean.trajectories() {
            let mut columns = t.columns.clone();
            columns[0][200] += 30.0;
            data.push("run", t.time.clone(), columns, None).unwrap();
        }
        let run = |outliers: bool| {
            let settings = Settings {
                outliers,
                method: Method::Regression,
                ..Settings::default()
            };
            let identify = Identify::new(problem.library().unwrap());
            let found = identify
                .settings(settings)
                .unwrap()
                .run(&data, &mut quiet());
            found.unwrap().warnings.join("; ")
        };
        let said = run(true);
        assert!(
            said.contains("1 of 5000 values of x") && said.contains("run at time 2"),
            "{said}"
        );
        assert!(!run(false).contains("outliers"));
    }
}
