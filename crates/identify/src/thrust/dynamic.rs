//! Dynamic models in `x = √T`: eq. (7), one lag, and eq. (8), a sparse library.

use sindy::statistics::regression::{Clusters, cluster_errors, least_squares};
use sindy::trajectory::shooting::{OdeModel, Parameter, Record, Refined, Shooting};
use sindy::{Gram, Library, Samples, SavitzkyGolay};
use touchdown_model::{Card, Form, Kind};
use touchdown_trial::Trial;

use super::search::minimise;
use crate::error::{Error, Result};
use crate::estimate::{Estimate, term};
use crate::fitted::{FittedCard, Origin, method, range, score};
use crate::front::Front;
use crate::scores::Errors;
use crate::settings::{DeadTime, IdentificationSettings};
use crate::sparse_fit::sparse_fit;
use crate::unit;
use crate::warning::Warning;

/// Pieces that the data are split into at least, for standard errors.
/// Student's t is 2.26 then. More pieces are shorter, and the free start of each costs more of them.
const PIECES: usize = 10;
/// Standard deviation of the prior on a piece's start (√N).
/// A free start: √T of a hovering vehicle is 1 to 10 √N, and its noise far below this.
const START_SD: f64 = 0.3;
/// Residuals that a free-run fit takes a second: thrust has no content beyond a few hertz.
/// Twice doubles the time of a fit, and samples are already dense within one lag of the motors.
const RESIDUALS_HZ: f64 = 50.0;
/// Shortest lag (s).
/// Below it the integration's step decides; no rotor is as quick.
const SHORTEST_LAG_S: f64 = 2e-3;
/// Longest step of the integration (s), for slow logs and holes.
/// A third of the usual lag of rotors, where a fourth-order step errs by less than 1e-4.
const LONGEST_STEP_S: f64 = 0.02;
/// Least standard deviation of the prior on a coefficient of eq. (8): one that regression puts near zero stays free to
/// grow to the size of a small term.
const LEAST_PRIOR_SD: f64 = 0.1;
/// Longest dead time that is searched for (s), and the shortest that is told from none.
const DEAD_TIME_S: [f64; 2] = [1e-3, 0.2];

/// A trial's rows without gaps in throttle or thrust, in pieces of unbroken data.
struct StandRecord {
    time: Vec<f64>,
    throttle: Vec<f64>,
    thrust: Vec<f64>,
    root: Vec<f64>,
    root_rate: Vec<f64>,
    trial: usize,
}

fn rows(trials: &[Trial], settings: &IdentificationSettings) -> Result<Vec<StandRecord>> {
    let mut out = Vec::new();
    let mut longest = 0;
    for (index, trial) in trials.iter().enumerate() {
        let throttle = super::throttle(trial)?;
        let (time, thrust) = (trial.time_s(), trial.require("thrust_n")?);
        let keep: Vec<usize> = (0..trial.len())
            .filter(|&i| throttle[i].is_finite() && thrust[i].is_finite())
            .collect();
        super::check_moves(trial.name(), [throttle.as_slice()])?;
        let period = trial.period_s().unwrap_or(f64::NAN);
        // A hole of more than ten periods breaks the record.
        for run in keep.chunk_by(|&a, &b| time[b] - time[a] <= 10.0 * period) {
            longest = longest.max(run.len());
            // The derivative window is set in samples of 100 Hz; a faster log takes as long a window in time.
            let faster = (0.01 / period).max(1.0).round() as usize;
            let window = (settings.smoothing.thrust_window - 1) * faster + 1;
            if run.len() <= 2 * window {
                continue;
            }
            let pick = |c: &[f64]| run.iter().map(|&i| c[i]).collect::<Vec<_>>();
            let (time, thrust) = (pick(time), pick(thrust));
            let root: Vec<f64> = thrust.iter().map(|t| t.max(0.0).sqrt()).collect();
            let smooth =
                SavitzkyGolay::new(window, settings.smoothing.degree)?.apply(&time, &root)?;
            out.push(StandRecord {
                throttle: pick(&throttle),
                thrust,
                root: smooth.value,
                root_rate: smooth.derivative,
                time,
                trial: index,
            });
        }
    }
    if out.is_empty() {
        return Err(Error::data(
            trials.first().map_or("no trial", Trial::name),
            format!(
                "unbroken thrust and throttle over more than {} samples",
                2 * settings.smoothing.thrust_window
            ),
            format!("{longest} at most"),
        ));
    }
    Ok(out)
}

fn samples(rows: &[StandRecord]) -> Result<Samples> {
    let mut samples = Samples::new(&["x", "s", "x_dot"]);
    // Groups are what is left out in turn: a single record is cut in pieces.
    let pieces = if rows.len() == 1 { PIECES } else { 1 };
    for r in rows {
        let size = r.time.len().div_ceil(pieces);
        for start in (0..r.time.len()).step_by(size) {
            let span = start..(start + size).min(r.time.len());
            let columns = [&r.root, &r.throttle, &r.root_rate];
            samples.push_group(columns.map(|c| c[span.clone()].to_vec()).into())?;
        }
    }
    Ok(samples)
}

/// The dead time between throttle and thrust: the shift of the throttle at which the library explains the
/// derivative best.
fn estimate_dead_time(rows: &[StandRecord], settings: &IdentificationSettings) -> Result<f64> {
    let library = Library::parse(&settings.thrust.library)?;
    let cost = |dead_time_s: f64| -> Result<f64> {
        let mut samples = Samples::new(&["x", "s", "x_dot"]);
        for r in rows {
            let late = super::delayed(&r.time, &r.throttle, dead_time_s);
            samples.push_group(vec![r.root.clone(), late, r.root_rate.clone()])?;
        }
        let gram = Gram::total(&Gram::accumulate(&library, "x_dot", &samples)?);
        Ok(gram.residual_sum(&least_squares(&gram, &vec![true; library.len()])))
    };
    let none = cost(0.0)?;
    let [least, most] = DEAD_TIME_S;
    let best = minimise(least, most, |d| cost(d).unwrap_or(f64::INFINITY));
    Ok(if cost(best)? < none { best } else { 0.0 })
}

/// Shifts the throttle of all rows by the dead time that the settings ask for, and returns it.
fn align(
    rows: &mut [StandRecord],
    settings: &IdentificationSettings,
    by_default: bool,
) -> Result<f64> {
    let wanted = match settings.thrust.dead_time {
        DeadTime::Auto => by_default,
        DeadTime::None => false,
        DeadTime::Estimate => true,
    };
    if !wanted {
        return Ok(0.0);
    }
    let dead_time_s = estimate_dead_time(rows, settings)?;
    for r in rows {
        r.throttle = super::delayed(&r.time, &r.throttle, dead_time_s);
    }
    Ok(dead_time_s)
}

/// Fits a model in free run over pieces of the data; every piece is a group for standard errors.
fn free_run(
    rows: &[StandRecord],
    model: &OdeModel,
    parameters: &[Parameter],
    settings: &IdentificationSettings,
) -> Result<(Refined, Clusters)> {
    let pieces = PIECES.div_ceil(rows.len());
    let mut records = Vec::new();
    for r in rows {
        let size = r.time.len().div_ceil(pieces);
        for start in (0..r.time.len()).step_by(size) {
            let span = start..(start + size).min(r.time.len());
            records.push(Record {
                time: &r.time[span.clone()],
                inputs: vec![&r.throttle[span.clone()]],
                measured: &r.thrust[span.clone()],
                start: vec![&r.root[span]],
                group: records.len(),
            });
        }
    }
    let r = &rows[0];
    let period = (r.time[r.time.len() - 1] - r.time[0]) / (r.time.len() - 1) as f64;
    let shooting = Shooting {
        window: f64::INFINITY,
        stride: 1.0,
        every: ((1.0 / (RESIDUALS_HZ * period)).round() as usize).max(1),
        start_sd: START_SD,
        noise_sd: settings.shooting.noise_n,
        max_iterations: settings.shooting.max_iterations,
    };
    let model = model.clone().with_max_step(LONGEST_STEP_S)?;
    let clusters = Clusters {
        groups: records.len(),
        coefficients: parameters.len(),
    };
    Ok((shooting.refine(&model, &records, parameters)?, clusters))
}

/// Eq. (7): `x' = (c0 s + c1 - x)/T_m`, started from regression, fitted in free run.
///
/// # Errors
/// Missing channels or too few unbroken data.
pub fn first_order(
    trials: &[Trial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<FittedCard> {
    let mut rows = rows(trials, settings)?;
    let dead_time_s = align(&mut rows, settings, false)?;
    let library = Library::parse(&["1", "x", "s"])?;
    let gram = Gram::total(&Gram::accumulate(&library, "x_dot", &samples(&rows)?)?);
    let xi = least_squares(&gram, &[true; 3]);
    let t_m = if xi[1] < 0.0 { -1.0 / xi[1] } else { 0.1 };
    let t_m = t_m.clamp(2.0 * SHORTEST_LAG_S, 0.9 * settings.thrust.max_lag_s);
    // Where the regression makes no sense, start from the range of the data.
    let (c0, c1) = if xi[2] > 0.0 {
        (xi[2] * t_m, xi[0] * t_m)
    } else {
        (5.0, 0.0)
    };
    let model = OdeModel::new(
        &["x"],
        &["s"],
        &["c0", "c1", "T_m"],
        &["(c0*s + c1 - x)/T_m"],
        "x*abs(x)",
    )?;
    let parameters = [
        Parameter::free(c0),
        Parameter::free(c1),
        Parameter::free(t_m).within(SHORTEST_LAG_S, settings.thrust.max_lag_s),
    ];
    let (refined, clusters) = free_run(&rows, &model, &parameters, settings)?;
    let mut card = origin.card(
        "thrust-first-order",
        Kind::Thrust,
        Form::FirstOrder,
        "x' = (c0 s + c1 - x)/T_m, x = √T [√N], s throttle in [0, 1]",
    );
    for ((name, unit), (value, error)) in [("c0", "√N"), ("c1", "√N"), ("T_m", "s")]
        .into_iter()
        .zip(refined.parameters.iter().zip(&refined.std_errors))
    {
        let estimate = Estimate::clustered(*value, *error, clusters);
        card.terms.push(term(name, "1", estimate, unit));
    }
    card.provenance.method = method(&[
        (
            "fit",
            "least squares in free run over long stretches, each with its own start; began at regression on derivatives"
                .into(),
        ),
        (
            "outcome",
            format!("{:?} after {} steps", refined.outcome, refined.iterations),
        ),
    ]);
    finish(
        card,
        trials,
        &rows,
        dead_time_s,
        Some(refined.parameters[2]),
        Vec::new(),
    )
}

/// The coefficients of a sparse fit of eq. (8), by term of the library.
struct Coefficients {
    /// Places of the terms in the library.
    support: Vec<usize>,
    values: Vec<f64>,
    std_errors: Vec<f64>,
    clusters: Clusters,
}

impl Coefficients {
    /// Those of a regression on derivatives.
    fn of_regression(grams: &[Gram], fit: &sindy::Fit) -> Self {
        let support: Vec<usize> = (0..fit.support.len()).filter(|&j| fit.support[j]).collect();
        let errors = cluster_errors(grams, &fit.coefficients, &fit.support);
        let error = |&j: &usize| errors.as_ref().map_or(f64::NAN, |e| e[j]);
        Self {
            values: support.iter().map(|&j| fit.coefficients[j]).collect(),
            std_errors: support.iter().map(error).collect(),
            clusters: Clusters {
                groups: grams.iter().filter(|g| g.rows > 0).count(),
                coefficients: support.len(),
            },
            support,
        }
    }

    /// The same terms fitted in free run, and how that ended.
    fn refined(
        self,
        library: &Library,
        rows: &[StandRecord],
        settings: &IdentificationSettings,
    ) -> Result<(Self, String)> {
        let names: Vec<String> = (0..self.support.len()).map(|k| format!("c{k}")).collect();
        let rhs: Vec<String> = self
            .support
            .iter()
            .zip(&names)
            .map(|(&j, n)| format!("{n}*({})", library.names()[j]))
            .collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let model = OdeModel::new(&["x"], &["s"], &names, &[&rhs.join(" + ")], "x*abs(x)")?;
        // The library is nearly collinear. A prior of the coefficients' own size keeps the search from wandering along
        // directions that the data do not identify.
        let parameters: Vec<Parameter> = self
            .values
            .iter()
            .map(|&v| Parameter::free(v).prior(v.abs().max(LEAST_PRIOR_SD)))
            .collect();
        let (refined, clusters) = free_run(rows, &model, &parameters, settings)?;
        let note = format!(
            "free run over long stretches, each with its own start: {:?} after {} steps",
            refined.outcome, refined.iterations
        );
        let refined = Self {
            values: refined.parameters,
            std_errors: refined.std_errors,
            clusters,
            ..self
        };
        Ok((refined, note))
    }

    fn card(&self, library: &Library, origin: &Origin) -> Card {
        let mut card = origin.card(
            "thrust-library",
            Kind::Thrust,
            Form::Library,
            "x' = Θ(x, s) ξ, x = √T [√N], s throttle in [0, 1]",
        );
        for (k, &j) in self.support.iter().enumerate() {
            let name = &library.names()[j];
            let estimate = Estimate::clustered(self.values[k], self.std_errors[k], self.clusters);
            let unit = unit::of_coefficient("x'", name);
            card.terms.push(term("x'", name, estimate, &unit));
        }
        card
    }
}

/// Eq. (8): `x' = Θ(x, s) ξ` by Savitzky–Golay derivatives and SR3 with λ and ν chosen by
/// cross-validation; then, if the settings ask for it, refined in free run.
///
/// # Errors
/// Missing channels or too few unbroken data.
pub fn library(
    trials: &[Trial],
    settings: &IdentificationSettings,
    origin: &Origin,
) -> Result<FittedCard> {
    let mut rows = rows(trials, settings)?;
    let dead_time_s = align(&mut rows, settings, true)?;
    let library = Library::parse(&settings.thrust.library)?;
    let grams = Gram::accumulate(&library, "x_dot", &samples(&rows)?)?;
    let sparse = sparse_fit(&grams, settings)?;
    let front = Front::of(("x'", "√N/s"), &library, &grams, &sparse, settings)?;
    let mut coefficients = Coefficients::of_regression(&grams, &sparse.fit);
    let mut notes = vec![(
        "derivative",
        format!(
            "Savitzky–Golay, window {} at 100 Hz, degree {}",
            settings.smoothing.thrust_window, settings.smoothing.degree
        ),
    )];
    notes.extend(sparse.notes.iter().cloned());
    if settings.thrust.refine {
        let (refined, note) = coefficients.refined(&library, &rows, settings)?;
        coefficients = refined;
        notes.push(("refinement", note));
    }
    let mut card = coefficients.card(&library, origin);
    card.provenance.method = method(&notes);
    let terms = library.len();
    let warnings = if coefficients.support.len() == terms {
        vec![Warning::NoTermEliminated { terms }]
    } else {
        Vec::new()
    };
    let fitted = finish(card, trials, &rows, dead_time_s, None, warnings)?;
    Ok(FittedCard { front, ..fitted })
}

/// Validity, scores in free run and the dead time of a card that was fitted to `rows`.
fn finish(
    mut card: Card,
    trials: &[Trial],
    rows: &[StandRecord],
    dead_time_s: f64,
    lag_s: Option<f64>,
    warnings: Vec<Warning>,
) -> Result<FittedCard> {
    type Column = fn(&StandRecord) -> &[f64];
    let columns: [(&str, Column); 2] = [("s", |r| &r.throttle), ("x", |r| &r.root)];
    for (symbol, column) in columns {
        if let Some(r) = range(rows.iter().flat_map(|r| column(r).iter().copied())) {
            card.validity.inputs.insert(symbol.into(), r);
        }
    }
    card.validity.output = range(rows.iter().flat_map(|r| r.thrust.iter().copied()));
    let mut scores = Vec::new();
    for (index, trial) in trials.iter().enumerate() {
        for r in rows.iter().filter(|r| r.trial == index) {
            let columns = crate::prediction::Columns {
                throttle: &r.throttle,
                ..Default::default()
            };
            let start = r.root[0] * r.root[0];
            let predicted = crate::prediction::Predictor::new(&card)?.run(
                trial.name(),
                &r.time,
                &columns,
                start,
            )?;
            if let Some(e) = Errors::of(&predicted, &r.thrust) {
                card.scores
                    .push(score(trial.name(), true, "free_run", e, "N"));
                scores.push(e);
            }
        }
    }
    if dead_time_s > 0.0 {
        // The throttle of the rows is shifted already.
        card.terms
            .push(term("dead_time", "1", Estimate::bare(dead_time_s), "s"));
    }
    Ok(FittedCard {
        card,
        rmse: Errors::pool(&scores).map_or(f64::NAN, |e| e.rmse),
        rmse_unit: "N",
        rows_used: rows.iter().map(|r| r.time.len()).sum(),
        lag_s,
        front: None,
        warnings,
    })
}
