//! Static maps: √T or T as a polynomial of throttle, with an optional battery term.

use sindy::statistics::regression::least_squares;
use sindy::{Gram, Library, Samples};
use touchdown_model::{Card, Form, Kind};
use touchdown_trial::Trial;

use super::choice::SLOWEST_PERIOD_S;
use super::free_run::HeldOut;
use super::output_error::counts_rows;
use super::plateau::{self, Plateau};
use super::rotor;
use crate::error::{Error, Result};
use crate::estimate::{Estimate, terms};
use crate::fitted::{FittedCard, Origin, method, range, score};
use crate::scores::Errors;
use crate::settings::{IdentificationSettings, ThrustForm, ThrustSettings};
use crate::warning::Warning;

/// Share of the largest thrust by which it must fall at full throttle to be warned of: the noise of a mean of load-cell
/// readings is well below it, half of it would warn of that noise.
const FALLS_FROM: f64 = 0.01;
/// Plateaus from which a trial is a staircase: fewer levels give no polynomial of the second degree with an error.
pub(super) const STAIRCASE: usize = 4;

/// Parts of the steady points that are held out in turn, at most: a table's points one by one.
const PARTS: usize = 20;

/// A static map, fitted: its terms, coefficients and points.
struct StaticMap {
    /// √T or T.
    root: bool,
    degree: usize,
    battery: bool,
    terms: Vec<String>,
    coefficients: Vec<Estimate>,
    points: Vec<Plateau>,
    /// Whether the points are plateaus of a staircase, or single rows.
    by_plateau: bool,
}

/// Errors of the map over some of its points.
struct BranchErrors {
    /// Of what was fitted.
    fitted: Option<Errors>,
    /// Of thrust (N).
    thrust: Option<Errors>,
    /// Mean of measured less fitted.
    bias: f64,
}

/// Fits a static map; with rotor speeds in staircases, the rotor's lag as well.
pub(super) fn fit(
    trials: &[Trial],
    settings: &IdentificationSettings,
    form: ThrustForm,
    origin: &Origin,
) -> Result<FittedCard> {
    let map = StaticMap::fit(trials, settings, form == ThrustForm::StaticSqrt)?;
    let mut card = map.card(&settings.thrust, origin);
    let mut warnings = map.warnings(unsettled(trials, settings, &map)?);
    let shows_lag = |t: &Trial| {
        t.channel("rotor_rpm").is_some() && t.period_s().is_some_and(|p| p < SLOWEST_PERIOD_S)
    };
    let mut lag_s = None;
    if map.root && map.by_plateau && trials.iter().all(shows_lag) {
        match rotor::fit(trials, settings) {
            Ok(lag) => {
                card.terms.extend(lag.terms());
                card.provenance.method.insert("lag".into(), lag.describe());
                lag_s = Some(lag.lag_s);
            }
            Err(e) => warnings.push(Warning::NoRotorLag { why: e.to_string() }),
        }
    }
    let rmse = map.branch(None).fitted.map_or(f64::NAN, |e| e.rmse);
    Ok(FittedCard {
        lag_s,
        warnings,
        ..FittedCard::new(card, (rmse, map.unit()), map.points.len())
    })
}

/// The error of a static map (N) at steady points, each part of which is held out in turn, and its coefficients.
pub(super) fn held_out(
    trials: &[Trial],
    settings: &IdentificationSettings,
    root: bool,
    battery: bool,
) -> Result<(HeldOut, usize)> {
    let thrust = ThrustSettings {
        battery,
        ..settings.thrust.clone()
    };
    let (points, by_plateau) = steady_points(trials, settings)?;
    check_points(&points, trials, &thrust)?;
    let count = points.len().clamp(1, PARTS);
    let parts: Vec<usize> = (0..points.len())
        .map(|i| i * count / points.len())
        .collect();
    let folds: Vec<Vec<f64>> = (0..count)
        .map(|part| {
            let seen = points.iter().zip(&parts).filter(|(_, p)| **p != part);
            let seen: Vec<Plateau> = seen.map(|(point, _)| *point).collect();
            let map = StaticMap::of_points(seen, by_plateau, trials, &thrust, root)?;
            Ok(points.iter().map(|p| map.thrust_n(p)).collect())
        })
        .collect::<Result<_>>()?;
    let measured: Vec<f64> = points.iter().map(|p| p.thrust_n).collect();
    let coefficients = thrust.degree + 1 + usize::from(battery);
    Ok((HeldOut::of(&parts, &measured, &folds), coefficients))
}

impl StaticMap {
    /// Least squares over the steady points, each counted once.
    fn fit(trials: &[Trial], settings: &IdentificationSettings, root: bool) -> Result<Self> {
        let (points, by_plateau) = steady_points(trials, settings)?;
        check_points(&points, trials, &settings.thrust)?;
        Self::of_points(points, by_plateau, trials, &settings.thrust, root)
    }

    fn of_points(
        points: Vec<Plateau>,
        by_plateau: bool,
        trials: &[Trial],
        settings: &ThrustSettings,
        root: bool,
    ) -> Result<Self> {
        let (degree, battery) = (settings.degree, settings.battery);
        let mut terms: Vec<String> = vec!["1".into(), "s".into()];
        terms.extend((2..=degree).map(|k| format!("s^{k}")));
        if battery {
            terms.push("s*u".into());
        }
        let mut samples = Samples::new(&["s", "u", "y"]);
        for p in &points {
            let u = match p.battery_v {
                Some(u) => u,
                None if battery => {
                    return Err(Error::data(
                        trials[0].name(),
                        "a channel `battery_v` (settings ask for a battery term)",
                        "none, or a gap",
                    ));
                }
                None => 0.0,
            };
            samples.push_group(vec![vec![p.throttle], vec![u], vec![target(root, p)]])?;
        }
        let library = Library::parse(&terms)?;
        let grams = Gram::accumulate(&library, "y", &samples)?;
        let all = vec![true; terms.len()];
        let coefficients = least_squares(&Gram::total(&grams), &all);
        let coefficients = Estimate::of_few_groups(&grams, &coefficients, &all);
        Ok(Self {
            root,
            degree,
            battery,
            terms,
            coefficients,
            points,
            by_plateau,
        })
    }

    /// Unit of what is fitted.
    fn unit(&self) -> &'static str {
        if self.root { "√N" } else { "N" }
    }

    /// The fitted value at a point.
    fn at(&self, p: &Plateau) -> f64 {
        let s = p.throttle;
        let xi = |k: usize| self.coefficients[k].value;
        let mut y = (0..=self.degree)
            .map(|k| xi(k) * s.powi(k as i32))
            .sum::<f64>();
        if self.battery {
            y += xi(self.degree + 1) * s * p.battery_v.unwrap_or(f64::NAN);
        }
        y
    }

    /// The fitted thrust (N) at a point.
    fn thrust_n(&self, p: &Plateau) -> f64 {
        let y = self.at(p);
        if self.root { y * y.abs() } else { y }
    }

    /// Errors over all points, or over those that were reached on the way up (`false`) or down.
    fn branch(&self, descending: Option<bool>) -> BranchErrors {
        let chosen: Vec<&Plateau> = self
            .points
            .iter()
            .filter(|p| descending.is_none_or(|d| p.descending == d))
            .collect();
        let fitted: Vec<f64> = chosen.iter().map(|p| self.at(p)).collect();
        let wanted: Vec<f64> = chosen.iter().map(|p| target(self.root, p)).collect();
        let thrust: Vec<f64> = chosen.iter().map(|p| self.thrust_n(p)).collect();
        let measured: Vec<f64> = chosen.iter().map(|p| p.thrust_n).collect();
        let bias = wanted.iter().zip(&fitted).map(|(w, f)| w - f).sum::<f64>()
            / wanted.len().max(1) as f64;
        BranchErrors {
            fitted: Errors::of(&fitted, &wanted),
            thrust: Errors::of(&thrust, &measured),
            bias,
        }
    }

    fn card(&self, settings: &ThrustSettings, origin: &Origin) -> Card {
        let (of, name, form, equation) = if self.root {
            let equation = "√T = x(s), T [N], s throttle in [0, 1]";
            ("x", "thrust-static-sqrt", Form::StaticSqrt, equation)
        } else {
            let equation = "T = T(s) [N], s throttle in [0, 1]";
            ("T", "thrust-static", Form::StaticThrust, equation)
        };
        let mut card = origin.card(name, Kind::Thrust, form, equation);
        if self.battery {
            card.equation.push_str(", u battery voltage [V]");
        }
        card.terms = terms(of, &self.terms, &self.coefficients);
        if let Some(r) = range(self.points.iter().map(|p| p.throttle)) {
            card.validity.inputs.insert("s".into(), r);
        }
        if self.battery
            && let Some(r) = range(self.points.iter().filter_map(|p| p.battery_v))
        {
            card.validity.inputs.insert("u".into(), r);
        }
        if let Some(r) = range(self.points.iter().map(|p| p.thrust_n)) {
            card.validity.output = Some(r);
        }
        for (label, branch) in [
            ("all points", None),
            ("ascending", Some(false)),
            ("descending", Some(true)),
        ] {
            let errors = self.branch(branch);
            if let (Some(e), Some(n)) = (errors.fitted, errors.thrust) {
                card.scores
                    .push(score(label, true, "static", e, self.unit()));
                if self.root {
                    card.scores.push(score(label, true, "static", n, "N"));
                }
            }
        }
        card.provenance.method = method(&[
            (
                "fit",
                "least squares, each point once; standard errors robust to unequal noise".into(),
            ),
            ("points", self.describe_points(settings)),
        ]);
        card
    }

    /// Where the points come from.
    fn describe_points(&self, settings: &ThrustSettings) -> String {
        let (count, least_n) = (self.points.len(), least_n(&self.points, settings));
        if self.by_plateau {
            let settle_s = settings.settle_s;
            format!(
                "{count} plateaus, medians from {settle_s} s after each step, thrust above {least_n} N"
            )
        } else {
            format!("{count} rows with thrust above {least_n} N")
        }
    }

    /// Rows that are not at rest say why they lie off the curve, and nothing of the supply.
    fn warnings(&self, unsettled: Option<Warning>) -> Vec<Warning> {
        let supply = unsettled.is_none().then(|| supply_limit(&self.points));
        unsettled
            .into_iter()
            .chain(supply.flatten())
            .chain(self.hysteresis())
            .collect()
    }

    /// Whether ascending and descending points differ by more than twice the standard error of that difference.
    fn hysteresis(&self) -> Option<Warning> {
        let of = |down| self.points.iter().filter(|p| p.descending == down).count() as f64;
        let counts = [of(false), of(true)];
        if counts.contains(&0.0) {
            return None;
        }
        let residuals = [false, true].map(|down| self.branch(Some(down)).bias);
        let rmse = self.branch(None).fitted.map_or(f64::NAN, |e| e.rmse);
        let [up, down] = residuals;
        let error = rmse * (1.0 / counts[1] + 1.0 / counts[0]).sqrt();
        ((up - down).abs() > 2.0 * error).then(|| Warning::Hysteresis {
            residuals,
            unit: self.unit(),
        })
    }
}

/// A warning of rows that count as steady points while the thrust still settles.
fn unsettled(
    trials: &[Trial],
    settings: &IdentificationSettings,
    map: &StaticMap,
) -> Result<Option<Warning>> {
    let settle_s = settings.thrust.settle_s;
    let timed = trials.iter().filter(|t| !map.by_plateau && !counts_rows(t));
    let held: Vec<Option<f64>> = timed
        .map(|trial| plateau::unsettled(trial, settle_s))
        .collect::<Result<_>>()?;
    let shortest_s = held.into_iter().flatten().min_by(f64::total_cmp);
    Ok(shortest_s.map(|held_s| Warning::UnsettledRows { held_s, settle_s }))
}

/// What is fitted of a point.
fn target(root: bool, p: &Plateau) -> f64 {
    if root {
        p.thrust_n.max(0.0).sqrt()
    } else {
        p.thrust_n
    }
}

/// More levels than the degree, and more points than terms.
fn check_points(points: &[Plateau], trials: &[Trial], settings: &ThrustSettings) -> Result<()> {
    let degree = settings.degree;
    let terms = degree + 1 + usize::from(settings.battery);
    let mut levels: Vec<f64> = points.iter().map(|p| p.throttle).collect();
    levels.sort_by(f64::total_cmp);
    levels.dedup();
    if points.len() > terms && levels.len() > degree {
        return Ok(());
    }
    Err(Error::data(
        trials.first().map_or("no trial", Trial::name),
        format!("more than {degree} levels of throttle and more points than the {terms} terms"),
        format!(
            "{} points at {} levels with thrust above {} N",
            points.len(),
            levels.len(),
            least_n(points, settings)
        ),
    ))
}

/// Whether thrust falls towards the highest throttles, as it does where the supply gives no more.
fn supply_limit(points: &[Plateau]) -> Option<Warning> {
    let most = points
        .iter()
        .max_by(|a, b| a.thrust_n.total_cmp(&b.thrust_n))?;
    let throttles = points.iter().map(|p| p.throttle);
    let top = throttles.fold(f64::NEG_INFINITY, f64::max);
    let at_top = points.iter().filter(|p| p.throttle == top);
    let top_n = plateau::median(at_top.map(|p| p.thrust_n))?;
    (most.throttle < top && top_n < (1.0 - FALLS_FROM) * most.thrust_n).then_some(
        Warning::SupplyLimit {
            most_n: most.thrust_n,
            at: most.throttle,
            top_n,
            top,
        },
    )
}

/// Plateaus of all trials, or the rows of trials that are no staircases; and whether all are plateaus.
///
/// # Errors
/// A missing channel.
pub fn steady_points(
    trials: &[Trial],
    settings: &IdentificationSettings,
) -> Result<(Vec<Plateau>, bool)> {
    let mut points = Vec::new();
    let mut by_plateau = true;
    for trial in trials {
        let found = plateau::find(trial, settings.thrust.settle_s)?;
        if found.len() >= STAIRCASE {
            points.extend(found);
        } else {
            by_plateau = false;
            points.extend(plateau::rows(trial)?);
        }
    }
    let least_n = least_n(&points, &settings.thrust);
    points.retain(|p| p.thrust_n > least_n);
    Ok((points, by_plateau))
}

/// Thrust below which points are not used (N).
fn least_n(points: &[Plateau], settings: &ThrustSettings) -> f64 {
    settings.least_thrust_n(points.iter().map(|p| p.thrust_n).fold(0.0, f64::max))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_intervals_of_a_bench_table_of_ten_points_cover_the_truth() {
        // √T = 0.2 + 3 s - 0.5 s², with normal errors of 0.05 √N at ten levels.
        let truth = [0.2, 3.0, -0.5];
        let settings = IdentificationSettings::default();
        assert_eq!(settings.thrust.degree, 2);
        let mut state = 1_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005);
            state = state.wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        const TABLES: usize = 1000;
        let mut covered = [0; 3];
        for _ in 0..TABLES {
            let throttle: Vec<f64> = (1..=10).map(|k| 0.1 * f64::from(k)).collect();
            let thrust = throttle.iter().map(|s| {
                // The sum of twelve uniform numbers has a variance of 1.
                let normal: f64 = (0..12).map(|_| uniform()).sum::<f64>() - 6.0;
                let root = truth[0] + truth[1] * s + truth[2] * s * s + 0.05 * normal;
                root * root
            });
            let thrust = thrust.collect();
            let trial = Trial::new("table", (0..10).map(f64::from).collect()).unwrap();
            let trial = trial.with_channel("throttle", throttle).unwrap();
            let trial = trial.with_channel("thrust_n", thrust).unwrap();
            let map = StaticMap::fit(&[trial], &settings, true).unwrap();
            for (k, estimate) in map.coefficients.iter().enumerate() {
                let [low, high] = estimate.ci95;
                covered[k] += usize::from((low..=high).contains(&truth[k]));
            }
        }
        // A thousand tables know a coverage of 0.95 to 0.007; three times that below. With few points the degrees of
        // freedom are rather too few, so that intervals may be wide, up to 0.99. Errors that do not know of the leverage
        // of the first and the last level cover 0.86 of the constants.
        for (k, covered) in covered.into_iter().enumerate() {
            let share = covered as f64 / TABLES as f64;
            assert!((0.929..0.99).contains(&share), "{k}: {share}");
        }
    }
}
