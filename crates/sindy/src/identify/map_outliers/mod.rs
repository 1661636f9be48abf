//! Gross errors in single rows of a map.
//!
//! Neighbours in time do not predict each other here, the map does. It is estimated from the rows that agree with each other
//! ([`robust`]). A row is set aside if its error is more than noise: beyond the level of a test, beside the scale of all errors and
//! beside that of its neighbours in state and inputs. What a missing term does, and noise that depends on the state, is seen by
//! neighbours as well. Nothing is said of a row that is predicted from further away than the rows that count lie: by
//! `φᵀ (ΦᵀΦ)⁻¹ φ` of its candidates. And nothing of states that are held over several rows, where the rows that agree with each other
//! are those in which nothing happens.
//!
//! Source: F. R. Hampel, "The influence curve and its role in robust estimation", J. Am. Stat. Assoc. 69 (1974).

mod robust;

use statrs::distribution::{ContinuousCDF as _, StudentsT};

use self::robust::{MEDIAN, Prediction, Steps};
use super::known::KnownPart;
use crate::data::dataset::{Dataset, FEWEST, Stretch};
use crate::error::SindyError;
use crate::library::Library;
use crate::model::Model;
use crate::numerics::upper_median;

/// Steps for each candidate, at least: the half that counts then determines the map with some steps to spare.
const FOR_EACH: usize = 4;
/// Neighbours whose errors give the local scale, and what their median is worth: 0.37 as much as a standard deviation.
const AROUND: usize = 50;
const DEGREES: f64 = 0.37 * AROUND as f64;
/// Level of the test for all rows together: of clean maps one in a hundred loses a row.
const LEVEL: f64 = 0.01;
/// A larger share of rows is something else: a second regime, or a term that lacks.
const SHARE: f64 = 0.1;
/// A state that keeps its value over a larger share of steps is held, as one that is sampled more slowly than the rows.
const HELD: f64 = 0.25;
/// Places that a warning names, for each state.
const NAMED: usize = 3;

/// A row that is none of its map.
struct Outlier {
    stretch: usize,
    row: usize,
    state: usize,
    /// Its error over that of its neighbours.
    distance: f64,
}

/// The stretches without their outliers.
pub(super) struct WithoutOutliers<'a> {
    pub stretches: Vec<Stretch<'a>>,
    /// One for each state that has outliers.
    pub warnings: Vec<String>,
}

/// The stretches without rows that are gross errors; `None` where there are none.
pub(super) fn set_aside<'a>(
    data: &Dataset,
    stretches: &[Stretch<'a>],
    libraries: &[Library],
    known: &[KnownPart],
) -> Result<Option<WithoutOutliers<'a>>, SindyError> {
    let steps = Steps::of(data, stretches);
    let most = libraries.iter().map(Library::len).max().unwrap_or(0);
    let few = steps.points.len() < FOR_EACH * (most + 1) || steps.points.len() <= AROUND;
    if few || steps.are_held(data.states().len()) {
        return Ok(None);
    }
    let Some(predictions) = steps.predictions(data, libraries, known)? else {
        return Ok(None);
    };
    let found = steps.outliers(&predictions);
    if found.is_empty() || found.len() as f64 > SHARE * steps.points.len() as f64 {
        return Ok(None);
    }
    let mut kept = Vec::new();
    for (index, stretch) in stretches.iter().enumerate() {
        let own = found.iter().filter(|o| o.stretch == index);
        let mut from = 0;
        for end in own.map(|o| o.row).chain([stretch.time.len()]) {
            if end >= from + FEWEST {
                kept.push(stretch.part(from..end));
            }
            from = end + 1;
        }
    }
    Ok(Some(WithoutOutliers {
        stretches: kept,
        warnings: warnings(data, stretches, &found),
    }))
}

/// Rows that a model leaves, of those that it was fitted to: far off what it predicts from the row before.
pub(super) fn left(
    data: &Dataset,
    stretches: &[Stretch<'_>],
    model: &Model,
) -> Result<usize, SindyError> {
    let steps = Steps::of(data, stretches);
    if steps.points.len() <= AROUND || steps.are_held(data.states().len()) {
        return Ok(0);
    }
    let mut of: Vec<Prediction> = data
        .states()
        .iter()
        .map(|_| Prediction::default())
        .collect();
    for s in stretches {
        let last = s.time.len().saturating_sub(1);
        let columns: Vec<&[f64]> = s.columns.iter().map(|c| &c[..last]).collect();
        let next = model.predict(&columns)?;
        for (i, of) in of.iter_mut().enumerate() {
            let errors = (0..last).map(|k| s.columns[i][k + 1] - next[i][k]);
            of.errors.extend(errors);
            of.inside.resize(of.errors.len(), true);
        }
    }
    Ok(steps.outliers(&of).len())
}

fn warnings(data: &Dataset, stretches: &[Stretch<'_>], found: &[Outlier]) -> Vec<String> {
    let mut out = Vec::new();
    for (i, state) in data.states().iter().enumerate() {
        let own: Vec<&Outlier> = found.iter().filter(|o| o.state == i).collect();
        let place = |o: &&Outlier| {
            let stretch = &stretches[o.stretch];
            let name = &data.trajectories()[stretch.trajectory].name;
            let (time, distance) = (stretch.time[o.row], o.distance);
            format!("{name} at time {time} ({distance:.2e} times the noise)")
        };
        let places: Vec<String> = own.iter().take(NAMED).map(place).collect();
        let more = if own.len() > NAMED { ", …" } else { "" };
        if !own.is_empty() {
            out.push(format!(
                "{} of {} values of {state} are taken for outliers, which single rows far off what the row before predicts are, and \
                 have no weight: {}{more} (`outliers = false` in the settings keeps them)",
                own.len(),
                data.report().rows,
                places.join(", ")
            ));
        }
    }
    out
}

impl Steps {
    /// Whether one of the states that move is held over several rows.
    fn are_held(&self, states: usize) -> bool {
        let keeps = |i: usize| {
            let pairs = self.points.iter().zip(&self.next);
            pairs.filter(|(own, next)| own[i] == next[i]).count()
        };
        let most = HELD * self.points.len() as f64;
        (0..states).any(|i| self.spread[i] > 0.0 && keeps(i) as f64 > most)
    }

    /// Rows beyond the level, in the order of time.
    fn outliers(&self, of: &[Prediction]) -> Vec<Outlier> {
        let tests = (of.len() * self.points.len()) as f64;
        let far = StudentsT::new(0.0, 1.0, DEGREES)
            .map_or(f64::INFINITY, |t| t.inverse_cdf(1.0 - 0.5 * LEVEL / tests));
        let scales: Vec<f64> = (0..of.len())
            .map(|i| self.scale(&of[i].errors, i))
            .collect();
        let worst = |k: usize, inside: bool| {
            let errors = of.iter().zip(&scales).enumerate();
            let beyond = errors
                .filter(|(_, (p, s))| p.inside[k] == inside && p.errors[k].abs() > far * **s)
                .map(|(i, (p, s))| (i, p.errors[k].abs() / self.local(k, &p.errors, *s)));
            let most = beyond.max_by(|a, b| a.1.total_cmp(&b.1));
            most.filter(|(_, distance)| *distance > far)
        };
        let mut found: Vec<Outlier> = Vec::new();
        for k in 0..self.points.len() {
            let (stretch, row) = self.place[k];
            let last = found.last();
            let follows_one = last.is_some_and(|o| o.stretch == stretch && o.row + 1 == row);
            let outlier = match follows_one {
                false => worst(k, true),
                // A row that is none of the map predicts nothing. The next one is none either where it lies outside and predicts
                // what does not follow.
                true if k + 1 < self.points.len() && self.follows(k + 1) => worst(k + 1, false),
                true => None,
            };
            if let Some((state, distance)) = outlier {
                found.push(Outlier {
                    stretch,
                    row,
                    state,
                    distance,
                });
            }
        }
        found
    }

    /// The scale of the errors around a step, at least that of all.
    fn local(&self, step: usize, errors: &[f64], scale: f64) -> f64 {
        let nearest = self.nearest(step, AROUND);
        let mut sizes: Vec<f64> = nearest.iter().map(|&j| errors[j].abs()).collect();
        let median = upper_median(&mut sizes).unwrap_or(f64::INFINITY);
        (MEDIAN * median).max(scale)
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt, SeedableRng};
    use rand_distr::{Distribution, StandardNormal};

    use crate::identify::{Identification, Settings};
    use crate::{Dataset, Identify, Library};

    /// A map with an input that settles on a cycle after a start far away; one row in `every` is off.
    fn fitted(seed: u64, every: usize, outliers: bool) -> (Identification, usize) {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(seed);
        let mut data = Dataset::new(&["x"], &["u"]).unwrap();
        let mut spoilt = 0;
        for start in [2.0, -1.6] {
            let mut columns = vec![Vec::new(), Vec::new()];
            let mut x = start;
            for k in 0..300 {
                let u = (0.3 * f64::from(k)).sin() + 0.8 * (0.83 * f64::from(k)).sin();
                let noise: f64 = StandardNormal.sample(&mut rng);
                let off = k > 0 && rng.random_range(0..every) == 0;
                spoilt += usize::from(off);
                let wrong = if off { rng.random_range(1.0..4.0) } else { 0.0 };
                columns[0].push(x + 0.005 * noise + wrong);
                columns[1].push(u);
                x = 0.6 * x - 0.1 * x.powi(3) + 0.3 * u;
            }
            let time = (0..300).map(f64::from).collect();
            data.push("run", time, columns, None).unwrap();
        }
        let settings = Settings {
            discrete: true,
            outliers,
            ..Settings::default()
        };
        let identify = Identify::new(Library::polynomial(&["x", "u"], 3).unwrap());
        let identify = identify.settings(settings).unwrap();
        (identify.run(&data, &mut |_| ()).unwrap(), spoilt)
    }

    fn terms(found: &Identification) -> Vec<String> {
        let equation = found.model.equations()[0].iter();
        equation.map(|t| t.expression.to_string()).collect()
    }

    #[test]
    fn analytic_rows_that_are_off_have_no_weight_in_a_map() {
        for seed in 0..3 {
            let (found, spoilt) = fitted(seed, 40, true);
            assert_eq!(terms(&found), ["x", "u", "x^3"], "{}", found.model);
            let said = found.warnings.join("; ");
            let count: usize = said.split(' ').next().unwrap().parse().unwrap();
            // A row that follows one that is off is not predicted: some of those that are off are neighbours.
            assert!(count <= spoilt && count + 3 >= spoilt, "{spoilt}: {said}");
            let (kept, _) = fitted(seed, 40, false);
            assert_ne!(terms(&kept), ["x", "u", "x^3"], "{}", kept.model);
        }
    }

    /// A lag of a motor whose scale gives a new value in every fourth row, as its command does in some.
    #[test]
    fn regress_states_that_are_held_have_no_outliers() {
        let mut rng = rand_pcg::Pcg64::seed_from_u64(1);
        let mut data = Dataset::new(&["x"], &["u"]).unwrap();
        let (mut x, mut u, mut shown) = (0.0, 0.0, 0.0);
        let mut columns = vec![Vec::new(), Vec::new()];
        for k in 0..800 {
            if k % 40 == 0 {
                u = rng.random_range(0.0..1.0);
            }
            if k % 4 == 0 {
                shown = x;
            }
            columns[0].push(shown);
            columns[1].push(u);
            x += 0.2 * (u - x);
        }
        let time = (0..800).map(f64::from).collect();
        data.push("run", time, columns, None).unwrap();
        let settings = Settings {
            discrete: true,
            ..Settings::default()
        };
        let identify = Identify::new(Library::polynomial(&["x", "u"], 2).unwrap());
        let identify = identify.settings(settings).unwrap();
        let found = identify.run(&data, &mut |_| ()).unwrap();
        let said = found.warnings.join("; ");
        assert!(!said.contains("outliers"), "{said}");
        assert!(terms(&found).contains(&"u".to_string()), "{}", found.model);
    }

    #[test]
    fn analytic_a_clean_map_keeps_all_rows() {
        for seed in 0..6 {
            let (found, _) = fitted(seed, usize::MAX, true);
            let said = found.warnings.join("; ");
            // A level of 1 % for each of them.
            assert!(!said.contains("outliers"), "{said}");
        }
    }
}
