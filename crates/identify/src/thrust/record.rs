//! Records of a thrust stand for models in `x = √T`: unbroken rows, their dead time, and fits in free run over them.

use sindy::statistics::regression::{Clusters, least_squares};
use sindy::trajectory::shooting::{OdeModel, Parameter, Record, Refined, Shooting};
use sindy::{Gram, Library, Samples, SavitzkyGolay};
use touchdown_model::Card;
use touchdown_trial::Trial;

use super::free_run::signal::{Between, lagged, unfolded};
use super::free_run::{FOLDS, HeldOut};
use super::output_error::HELD;
use super::search::minimise;
use crate::delayed::delayed;
use crate::error::{Error, Result};
use crate::fitted::{FittedCard, range, score};
use crate::prediction::{Columns, Predictor};
use crate::scores::Errors;
use crate::settings::{DeadTime, IdentificationSettings};
use crate::thrust::unbroken::HOLE_PERIODS;

/// Pieces that the data are split into at least, for standard errors.
/// Student's t is 2.26 then. More pieces are shorter, and the free start of each costs more of them.
const PIECES: usize = 10;
/// Standard deviation of the prior on a piece's start (√N).
/// A free start: √T of a hovering vehicle is 1 to 10 √N, and its noise far below this.
const START_SD: f64 = 0.3;
/// Residuals that a free-run fit takes a second: thrust has no content beyond a few hertz.
/// Twice doubles the time of a fit, and samples are already dense within one lag of the motors.
const RESIDUALS_HZ: f64 = 50.0;
/// Longest step of the integration (s), for slow logs and holes.
/// A third of the usual lag of rotors, where a fourth-order step errs by less than 1e-4.
const LONGEST_STEP_S: f64 = 0.02;
/// Shortest and longest dead time that is searched for (s); a shorter one is none.
const DEAD_TIME_S: [f64; 2] = [1e-3, 0.2];

/// Unbroken rows with throttle and thrust; the root of thrust is smoothed.
#[derive(Clone)]
struct StandRecord {
    time: Vec<f64>,
    /// As it was logged.
    command: Vec<f64>,
    /// After the dead time.
    throttle: Vec<f64>,
    thrust: Vec<f64>,
    root: Vec<f64>,
    root_rate: Vec<f64>,
    trial: usize,
}

/// The records of all trials on one clock: the throttle is shifted by the dead time.
pub(super) struct StandRecords {
    records: Vec<StandRecord>,
    pub(super) dead_time_s: f64,
    /// What the throttle is between its samples, in free run.
    between: Between,
}

/// Rows in free run: times, throttle, and the row of the record for each (none for rows that a held throttle adds).
type FreeRunRows = (Vec<f64>, Vec<f64>, Vec<Option<usize>>);

impl StandRecords {
    /// The records of `trials`, without dead time. What the throttle is between its samples, `seen` tells, or the samples do
    /// where nothing was seen. Regression takes it for straight lines, and so does a model that is not refined in free run.
    pub(super) fn of(
        trials: &[Trial],
        settings: &IdentificationSettings,
        seen: Option<Between>,
    ) -> Result<Self> {
        let records = unbroken(trials, settings)?;
        let lines = !settings.thrust.refine || settings.thrust.dead_time == DeadTime::Regression;
        let by_samples = || Between::of(records.iter().map(|r| r.command.as_slice()));
        let between = match lines {
            true => Between::Linear,
            false => seen.unwrap_or_else(by_samples),
        };
        Ok(Self {
            records,
            dead_time_s: 0.0,
            between,
        })
    }

    /// The same records behind a dead time.
    pub(super) fn delayed_by(&self, dead_time_s: f64) -> Self {
        let shift = |r: &StandRecord| match self.between {
            Between::Held => lagged(&r.time, &r.command, Between::Held, 0.0, dead_time_s),
            Between::Linear => delayed(&r.time, &r.command, dead_time_s),
        };
        let records = self.records.iter().map(|r| StandRecord {
            throttle: shift(r),
            ..r.clone()
        });
        Self {
            records: records.collect(),
            dead_time_s,
            between: self.between,
        }
    }

    /// Greatest measured thrust (N).
    fn greatest_n(&self) -> f64 {
        let thrusts = self.records.iter().flat_map(|r| &r.thrust);
        thrusts.copied().fold(0.0, f64::max)
    }

    /// Time between rows (s).
    pub(super) fn period_s(&self) -> f64 {
        let r = &self.records[0];
        (r.time[r.time.len() - 1] - r.time[0]) / (r.time.len() - 1) as f64
    }

    /// The rows of a record in free run; lines between them are the delayed throttle.
    fn rows(&self, r: &StandRecord) -> FreeRunRows {
        match self.between {
            Between::Held => unfolded(&r.time, &r.command, self.dead_time_s),
            Between::Linear => {
                let rows = (0..r.time.len()).map(Some).collect();
                (r.time.clone(), r.throttle.clone(), rows)
            }
        }
    }

    /// The columns `x`, `s` and `x_dot` for regression.
    pub(super) fn samples(&self) -> Result<Samples> {
        let mut samples = Samples::new(&["x", "s", "x_dot"]);
        // Groups are the folds of the cross-validation, so a single record is cut into pieces.
        let pieces = if self.records.len() == 1 { PIECES } else { 1 };
        for r in &self.records {
            for span in super::pieces(r.time.len(), pieces) {
                let columns = [&r.root, &r.throttle, &r.root_rate];
                samples.push_group(columns.map(|c| c[span.clone()].to_vec()).into())?;
            }
        }
        Ok(samples)
    }

    /// Fits a model in free run over pieces of the data, without those of a fold; every piece is a group for standard
    /// errors.
    pub(super) fn free_run(
        &self,
        model: &OdeModel,
        parameters: &[Parameter],
        settings: &IdentificationSettings,
        without: Option<usize>,
    ) -> Result<(Refined, Clusters)> {
        let every = ((1.0 / (RESIDUALS_HZ * self.period_s())).round() as usize).max(1);
        let mut pieces = Vec::new();
        for r in &self.records {
            let (time, throttle, rows) = self.rows(r);
            // The place of each row of the record among those in free run.
            let place: Vec<usize> = (0..rows.len()).filter(|&j| rows[j].is_some()).collect();
            for span in self.spans(r) {
                let first = span.start;
                let thinned = |i: usize| match (i - first).is_multiple_of(every) {
                    true => r.thrust[i],
                    false => f64::NAN,
                };
                let span = place[span.start]..place[span.end - 1] + 1;
                let column = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
                    let rows = rows[span.clone()].iter();
                    rows.map(|row| row.map_or(f64::NAN, of)).collect()
                };
                pieces.push([
                    time[span.clone()].to_vec(),
                    throttle[span.clone()].to_vec(),
                    column(&thinned),
                    column(&|i| r.root[i]),
                ]);
            }
        }
        let kept = pieces.iter().enumerate();
        let kept = kept.filter(|(piece, _)| without.is_none_or(|fold| piece % FOLDS != fold));
        let records: Vec<Record<'_>> = kept
            .enumerate()
            .map(|(group, (_, [time, throttle, measured, root]))| Record {
                time,
                inputs: vec![throttle],
                measured,
                start: vec![root],
                group,
            })
            .collect();
        let shooting = Shooting {
            window: f64::INFINITY,
            stride: 1.0,
            every: 1,
            start_sd: START_SD,
            noise_sd: settings.shooting.noise_sd_n(self.greatest_n()),
            max_iterations: settings.shooting.max_iterations,
        };
        let model = model.clone().with_max_step(LONGEST_STEP_S)?;
        let clusters = Clusters {
            groups: records.len(),
            coefficients: parameters.len(),
        };
        Ok((shooting.refine(&model, &records, parameters)?, clusters))
    }

    /// The pieces of a record.
    fn spans(&self, r: &StandRecord) -> impl Iterator<Item = std::ops::Range<usize>> + use<> {
        super::pieces(r.time.len(), PIECES.div_ceil(self.records.len()))
    }

    /// The error on folds of models with the parameters that were fitted without them, each record in one run.
    pub(super) fn held_out(&self, model: &OdeModel, folds: &[Vec<f64>]) -> Result<HeldOut> {
        let model = model.clone().with_max_step(LONGEST_STEP_S)?;
        let (mut pieces, mut measured) = (Vec::new(), Vec::new());
        let mut predicted = vec![Vec::new(); folds.len()];
        let mut piece = 0;
        for r in &self.records {
            for span in self.spans(r) {
                pieces.extend(span.map(|_| piece));
                piece += 1;
            }
            measured.extend_from_slice(&r.thrust);
            let (time, throttle, rows) = self.rows(r);
            for (out, parameters) in predicted.iter_mut().zip(folds) {
                let all = model.free_run(parameters, &[r.root[0]], &time, &[&throttle])?;
                let pairs = all.into_iter().zip(&rows);
                out.extend(pairs.filter_map(|(v, row)| row.map(|_| v)));
            }
        }
        Ok(HeldOut::of(&pieces, &measured, &predicted))
    }

    /// A card that was fitted to these records, with its validity, scores in free run and dead time.
    pub(super) fn finish(&self, mut card: Card, trials: &[Trial]) -> Result<FittedCard> {
        type Column = fn(&StandRecord) -> &[f64];
        let range_of = |column: Column| {
            let records = self.records.iter();
            range(records.flat_map(|r| column(r).iter().copied()))
        };
        let columns: [(&str, Column); 2] = [("s", |r| &r.throttle), ("x", |r| &r.root)];
        for (symbol, column) in columns {
            if let Some(r) = range_of(column) {
                card.validity.inputs.insert(symbol.into(), r);
            }
        }
        card.validity.output = range_of(|r| &r.thrust);
        let predictor = Predictor::new(&card)?;
        let mut errors = Vec::new();
        let mut most_n = 0.0_f64;
        for r in &self.records {
            let (time, throttle, rows) = self.rows(r);
            let columns = Columns {
                throttle: &throttle,
                ..Columns::default()
            };
            let (name, start) = (trials[r.trial].name(), r.root[0] * r.root[0]);
            let all = predictor.run(name, &time, &columns, start)?;
            let pairs = all.into_iter().zip(rows);
            let predicted: Vec<f64> = pairs.filter_map(|(v, row)| row.map(|_| v)).collect();
            let size = |v: &f64| {
                if v.is_finite() {
                    v.abs()
                } else {
                    f64::INFINITY
                }
            };
            most_n = predicted.iter().map(size).fold(most_n, f64::max);
            if let Some(e) = Errors::of(&predicted, &r.thrust) {
                card.scores.push(score(name, true, "free_run", e, "N"));
                errors.push(e);
            }
        }
        if self.between == Between::Held {
            card.constants.insert(HELD.into(), 1.0);
        }
        let largest = card.validity.output.map_or(0.0, |[_, most]| most);
        let rmse = Errors::pool(&errors).map_or(f64::NAN, |e| e.rmse);
        let rows = self.records.iter().map(|r| r.time.len()).sum();
        let mut fitted = FittedCard::new(card, (rmse, "N"), rows);
        fitted.judge_divergence(most_n, largest, "N");
        Ok(fitted)
    }
}

/// The rows of all trials, in pieces without gaps in throttle or thrust.
fn unbroken(trials: &[Trial], settings: &IdentificationSettings) -> Result<Vec<StandRecord>> {
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
        for run in keep.chunk_by(|&a, &b| time[b] - time[a] <= HOLE_PERIODS * period) {
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
                command: pick(&throttle),
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

/// The dead time between throttle and thrust by regression: the shift of the throttle at which the library explains the
/// derivative best. Smoothing and noise bias it; free run is the better judge.
pub(super) fn dead_time_by_regression(
    records: &StandRecords,
    settings: &IdentificationSettings,
) -> Result<f64> {
    let library = Library::parse(&settings.thrust.library)?;
    let cost = |dead_time_s: f64| -> Result<f64> {
        let mut samples = Samples::new(&["x", "s", "x_dot"]);
        for r in &records.records {
            let late = delayed(&r.time, &r.command, dead_time_s);
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
