//! Rows of discrete time: each one period after the one before.

use crate::data::dataset::{Dataset, FEWEST, Stretch};
use crate::error::SindyError;
use crate::trajectory::shift::{Cut, uneven};

/// The stretches cut where a row is not the next one, and a warning if there are such gaps.
///
/// # Errors
/// Steps that are neither one period nor a gap (as for [`next`](crate::trajectory::shift::next)), or a trajectory all of whose steps
/// are gaps: the first of them, with trajectory and row.
pub(super) fn one_period<'a>(
    data: &Dataset,
    stretches: &[Stretch<'a>],
    period: f64,
) -> Result<(Vec<Stretch<'a>>, Option<String>), SindyError> {
    let refuse = |s: &Stretch<'_>, (row, step): (usize, f64)| {
        let trajectory = &data.trajectories()[s.trajectory];
        let row = trajectory.time.partition_point(|t| *t < s.time[row]);
        let name = &trajectory.name;
        Err(uneven(
            period,
            step,
            &format!("row {row} of trajectory `{name}`"),
        ))
    };
    let cuts: Vec<Cut> = stretches.iter().map(|s| Cut::new(s.time, period)).collect();
    let mut out = Vec::new();
    let (mut gaps, mut short) = (0, 0);
    for (s, cut) in stretches.iter().zip(&cuts) {
        if let Some(first) = cut.uneven {
            return refuse(s, first);
        }
        let own = stretches.iter().zip(&cuts);
        let regular = own
            .filter(|(o, _)| o.trajectory == s.trajectory)
            .any(|(_, c)| c.regular);
        if let Some(first) = cut.first_gap.filter(|_| !regular) {
            return refuse(s, first);
        }
        gaps += cut.gaps;
        for range in &cut.ranges {
            if range.len() < FEWEST {
                short += range.len();
                continue;
            }
            out.push(s.part(range.clone()));
        }
    }
    let warning = (gaps > 0).then(|| {
        format!(
            "{gaps} steps of more than one period ({period}) split the trajectories into {} stretches, {short} rows in \
             those too short to use",
            out.len()
        )
    });
    Ok((out, warning))
}

/// The stretches without rows of no weight: in discrete time nothing may be bridged, the bridge would be the next sample.
pub(super) fn with_weight<'a>(stretches: &[Stretch<'a>]) -> Vec<Stretch<'a>> {
    let mut out = Vec::new();
    for s in stretches {
        let Some(weights) = s.weights else {
            out.push(s.clone());
            continue;
        };
        let mut from = 0;
        while from < weights.len() {
            let length = weights[from..].iter().take_while(|w| **w > 0.0).count();
            let rows = from..from + length;
            if length >= FEWEST {
                out.push(Stretch {
                    trajectory: s.trajectory,
                    time: &s.time[rows.clone()],
                    columns: s.columns.iter().map(|c| &c[rows.clone()]).collect(),
                    weights: Some(&weights[rows]),
                    seen: Vec::new(),
                });
            }
            from += length + 1;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use crate::{Dataset, Identify, Library, identify::Settings};

    /// `x[k+1] = 0.9 x[k] + 0.1` at these times (whole numbers are samples).
    fn run(times: &[&[f64]]) -> Result<crate::identify::Identification, String> {
        let mut data = Dataset::new(&["x"], &[]).unwrap();
        for (k, time) in times.iter().enumerate() {
            let x = time
                .iter()
                .map(|t| 1.0 - (1.0 + k as f64) * 0.9_f64.powf(*t))
                .collect();
            data.push(format!("run {k}"), time.to_vec(), vec![x], None)
                .unwrap();
        }
        Identify::new(Library::polynomial(&["x"], 2).unwrap())
            .settings(Settings {
                discrete: true,
                ..Settings::default()
            })
            .unwrap()
            .run(&data, &mut |_| ())
            .map_err(|e| e.to_string())
    }

    #[test]
    fn analytic_rows_left_out_of_a_map_are_gaps_not_steps() {
        let all: Vec<f64> = (0..40).map(f64::from).collect();
        let holes: Vec<f64> = all
            .iter()
            .copied()
            .filter(|t| ![10.0, 20.0, 21.0, 38.0].contains(t))
            .collect();
        let found = run(&[&all, &holes]).unwrap();
        let text = format!("{:.6}", found.model);
        // No noise: coefficients to rounding. Pairs across a hole would be off by a tenth.
        assert!(text.contains("0.100000 + 0.900000*x"), "{text}");
        let said = found
            .warnings
            .iter()
            .find(|w| w.contains("period"))
            .unwrap();
        assert!(
            said.starts_with("3 steps") && said.contains("1 rows"),
            "{said}"
        );
        assert!(
            !run(&[&all])
                .unwrap()
                .warnings
                .iter()
                .any(|w| w.contains("period"))
        );
    }

    #[test]
    fn analytic_rows_without_weight_are_no_next_samples() {
        // The logistic map; every tenth row is something else and has no weight.
        let time: Vec<f64> = (0..400).map(f64::from).collect();
        let mut x = vec![0.3];
        while x.len() < time.len() {
            let last = x[x.len() - 1];
            x.push(3.7 * last * (1.0 - last));
        }
        let mut weights = vec![1.0; time.len()];
        for k in (5..400).step_by(10) {
            (x[k], weights[k]) = (7.0, 0.0);
        }
        let mut data = Dataset::new(&["x"], &[]).unwrap();
        data.push("map", time, vec![x], Some(weights)).unwrap();
        let found = Identify::new(Library::polynomial(&["x"], 3).unwrap())
            .settings(Settings {
                discrete: true,
                ..Settings::default()
            })
            .unwrap()
            .run(&data, &mut |_| ())
            .unwrap();
        assert_eq!(
            format!("{:.4}", found.model).trim(),
            "x[k+1] = 3.700*x - 3.700*x^2"
        );
    }

    #[test]
    fn prop_uneven_rows_of_a_map_are_refused_by_trajectory_and_row() {
        let all: Vec<f64> = (0..40).map(f64::from).collect();
        let mut off = all.clone();
        off[17] += 0.25;
        let error = run(&[&all, &off]).unwrap_err();
        for part in [
            "steps of 1 ",
            "a step of 1.25 before",
            "row 17 of trajectory `run 1`",
        ] {
            assert!(error.contains(part), "{error}");
        }
        let every_other: Vec<f64> = (0..15).map(|i| 2.0 * f64::from(i)).collect();
        let error = run(&[&all, &every_other]).unwrap_err();
        assert!(
            error.contains("a step of 2 before row 1 of trajectory `run 1`"),
            "{error}"
        );
    }

    /// A Hénon map that noise drives, with candidates of degree 3 but for those that lack.
    fn henon(seed: u64, lacks: &[&str]) -> crate::identify::Identification {
        use rand::SeedableRng;
        use rand_distr::{Distribution, StandardNormal};
        let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
        let mut columns = vec![Vec::new(), Vec::new()];
        let (mut x, mut y) = (0.1, 0.1);
        for _ in 0..500 {
            columns[0].push(x);
            columns[1].push(y);
            let [a, b]: [f64; 2] = std::array::from_fn(|_| StandardNormal.sample(&mut rng));
            (x, y) = (1.0 - 1.4 * x * x + y + 0.003 * a, 0.3 * x + 0.001 * b);
        }
        let mut data = Dataset::new(&["x", "y"], &[]).unwrap();
        let time = (0..500).map(f64::from).collect();
        data.push("map", time, columns, None).unwrap();
        let all = Library::polynomial(&["x", "y"], 3).unwrap();
        let without: Vec<usize> = (0..all.len())
            .filter(|&j| lacks.contains(&all.names()[j].as_str()))
            .collect();
        let settings = Settings {
            discrete: true,
            ..Settings::default()
        };
        let identify = Identify::new(all.without(&without));
        let identify = identify.settings(settings).unwrap();
        identify.run(&data, &mut |_| ()).unwrap()
    }

    #[test]
    fn analytic_chaotic_maps_are_exact_without_doubt_and_lacking_terms_are_warned_of() {
        let found: Vec<_> = (0..6).map(|seed| henon(seed, &[])).collect();
        for found in &found {
            let terms: Vec<Vec<String>> = found
                .model
                .equations()
                .iter()
                .map(|e| e.iter().map(|t| t.expression.to_string()).collect())
                .collect();
            assert_eq!(terms, [vec!["1", "y", "x^2"], vec!["x"]], "{}", found.model);
        }
        // A level of 1 %: two of six are warned of in 0.15 % of draws.
        let warned = found.iter().filter(|f| !f.warnings.is_empty()).count();
        assert!(warned < 2, "{warned}");
        let lacking = henon(0, &["x^2"]);
        let said = lacking.warnings.join("; ");
        assert!(said.contains("not in the library"), "{said}");
    }
}
