//! Records of a thrust stand for models in `x = √T`: unbroken rows, their dead time, and fits in free run over them.

use sindy::statistics::regression::{Clusters, least_squares};
use sindy::trajectory::shooting::{OdeModel, Parameter, Record, Refined, Shooting};
use sindy::{Gram, Library, Samples, SavitzkyGolay};
use touchdown_model::Card;
use touchdown_trial::Trial;

use super::search::minimise;
use crate::delayed::delayed;
use crate::error::{Error, Result};
use crate::estimate::{Estimate, term};
use crate::fitted::{FittedCard, range, score};
use crate::prediction::{Columns, Predictor};
use crate::scores::Errors;
use crate::settings::{DeadTime, IdentificationSettings};

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
struct StandRecord {
    time: Vec<f64>,
    throttle: Vec<f64>,
    thrust: Vec<f64>,
    root: Vec<f64>,
    root_rate: Vec<f64>,
    trial: usize,
}

/// The records of all trials on one clock: the throttle is shifted by the dead time.
pub(super) struct StandRecords {
    records: Vec<StandRecord>,
    dead_time_s: f64,
}

impl StandRecords {
    /// The records of `trials`; the dead time is estimated if the settings ask for it or leave that to the form, which
    /// decides `by_default`.
    pub(super) fn of(
        trials: &[Trial],
        settings: &IdentificationSettings,
        by_default: bool,
    ) -> Result<Self> {
        let mut records = unbroken(trials, settings)?;
        let estimate = match settings.thrust.dead_time {
            DeadTime::Auto => by_default,
            DeadTime::None => false,
            DeadTime::Estimate => true,
        };
        let mut dead_time_s = 0.0;
        if estimate {
            dead_time_s = estimate_dead_time(&records, settings)?;
            for r in &mut records {
                r.throttle = delayed(&r.time, &r.throttle, dead_time_s);
            }
        }
        Ok(Self {
            records,
            dead_time_s,
        })
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

    /// Fits a model in free run over pieces of the data; every piece is a group for standard errors.
    pub(super) fn free_run(
        &self,
        model: &OdeModel,
        parameters: &[Parameter],
        settings: &IdentificationSettings,
    ) -> Result<(Refined, Clusters)> {
        let pieces = PIECES.div_ceil(self.records.len());
        let mut records = Vec::new();
        for r in &self.records {
            for span in super::pieces(r.time.len(), pieces) {
                records.push(Record {
                    time: &r.time[span.clone()],
                    inputs: vec![&r.throttle[span.clone()]],
                    measured: &r.thrust[span.clone()],
                    start: vec![&r.root[span]],
                    group: records.len(),
                });
            }
        }
        let r = &self.records[0];
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
        for r in &self.records {
            let columns = Columns {
                throttle: &r.throttle,
                ..Columns::default()
            };
            let (name, start) = (trials[r.trial].name(), r.root[0] * r.root[0]);
            let predicted = predictor.run(name, &r.time, &columns, start)?;
            if let Some(e) = Errors::of(&predicted, &r.thrust) {
                card.scores.push(score(name, true, "free_run", e, "N"));
                errors.push(e);
            }
        }
        if self.dead_time_s > 0.0 {
            // The throttle of the records is shifted already.
            let dead_time = Estimate::bare(self.dead_time_s);
            card.terms.push(term("dead_time", "1", dead_time, "s"));
        }
        let rmse = Errors::pool(&errors).map_or(f64::NAN, |e| e.rmse);
        let rows = self.records.iter().map(|r| r.time.len()).sum();
        Ok(FittedCard::new(card, (rmse, "N"), rows))
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

/// The dead time between throttle and thrust: the shift of the throttle at which the library explains the
/// derivative best.
fn estimate_dead_time(records: &[StandRecord], settings: &IdentificationSettings) -> Result<f64> {
    let library = Library::parse(&settings.thrust.library)?;
    let cost = |dead_time_s: f64| -> Result<f64> {
        let mut samples = Samples::new(&["x", "s", "x_dot"]);
        for r in records {
            let late = delayed(&r.time, &r.throttle, dead_time_s);
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
