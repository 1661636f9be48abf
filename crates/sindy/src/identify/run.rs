//! One identification, from slopes to the accepted model.

use rayon::prelude::*;

use super::conserve::Conserved;
use super::follow::FollowedModel;
use super::inputs;
use super::prepare::{self, Noise, Slopes};
use super::rank::{BETTER, RANKED, RankedModel, by_free_run};
use super::regress::{self, Statistics};
use super::stable::StableCandidates;
use super::{Identification, Method, NoiseSource, Progress, Settings, Smoothing, warnings};
use crate::data::dataset::{Dataset, Stretch};
use crate::error::SindyError;
use crate::identify::known::KnownPart;
use crate::library::Library;
use crate::model::Term;
use crate::model::Time;
use crate::solve::sign::Sign;
use crate::trajectory::output_error::{Piece, System, free_run};

/// A model follows the data if it leaves no state more than this times its noise, which is estimated as if it were white.
/// Above it the residual itself is tested ([`super::follow`]). Twice the value accepts models that lack a term without a
/// test, and values below 1 test most true ones.
pub(super) const FOLLOWS: f64 = 1.5;
/// A sum of autocorrelations above which residuals count as correlated: they hold half the information of independent
/// ones. At twice the value, standard errors up to twice too small pass without a warning.
pub(super) const CORRELATED: f64 = 2.0;

/// One identification under way.
#[derive(Clone)]
pub(super) struct IdentificationRun<'a> {
    pub data: &'a Dataset,
    pub settings: &'a Settings,
    /// Candidate terms and known part of each equation.
    pub libraries: Vec<(Library, KnownPart)>,
    /// Signs of the candidates of each equation; none where none is given. Under invariants one, without signs, for all.
    pub signs: Vec<Vec<Sign>>,
    /// What is looked for under invariants: the candidates of `system` are its fields then.
    pub conserved: Option<Conserved>,
    /// Terms that the squared diffusion of each state may have; `None` where disturbances are taken to be constant.
    pub diffusion: Option<Library>,
    /// What the search for a stable model knows of its candidates.
    pub stable: Option<StableCandidates>,
    /// Indices of the positions whose velocity is not measured. Their velocities are the last states.
    pub positions: Vec<usize>,
    pub system: System,
    pub time: Time,
    pub stretches: Vec<Stretch<'a>>,
    pub noise: Noise,
    pub inputs: inputs::Choice,
    pub warnings: Vec<String>,
}

impl<'a> IdentificationRun<'a> {
    pub(super) fn go(
        mut self,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<Identification, SindyError> {
        progress(Progress::Smoothing);
        let (slopes, statistics) = self.regressions(progress)?;
        self.warnings.extend(warnings::of_data(
            &self.data.report(),
            &statistics[0],
            &self.libraries,
            &self.data.samples()?,
        )?);
        let statistics = match &self.conserved {
            Some(conserved) => statistics
                .into_iter()
                .map(|of| conserved.join(of))
                .collect::<Result<_, _>>()?,
            None => statistics,
        };
        let yardstick = self.yardstick(&slopes);
        let ranked = self.rank(&statistics, &yardstick)?;
        self.conclude(&slopes, &statistics, (&ranked, &yardstick), progress)
    }

    /// The identification of equations whose coefficients are nearly known: output error from there, regression where that is
    /// not accepted.
    pub(super) fn refine(
        self,
        slopes: &Slopes,
        coefficients: &[Vec<f64>],
        progress: &mut dyn FnMut(Progress),
    ) -> Result<Identification, SindyError> {
        let mut statistics = Vec::new();
        self.add(slopes, &self.stretches, &mut statistics, progress)?;
        let start = regress::from_coefficients(&statistics[0], coefficients);
        let yardstick = self.yardstick(slopes);
        let ranked = [RankedModel::new(
            start,
            &self.system,
            &yardstick,
            &self.noise.sigma,
        )];
        self.conclude(slopes, &statistics, (&ranked, &yardstick), progress)
    }

    /// Output error from the best of the ranked models, or the best of them.
    fn conclude(
        mut self,
        slopes: &Slopes,
        statistics: &[Statistics],
        (ranked, yardstick): (&[RankedModel], &[Piece<'_>]),
        progress: &mut dyn FnMut(Progress),
    ) -> Result<Identification, SindyError> {
        let followed = self.follow(ranked, slopes, &statistics[0], progress);
        match &followed {
            Some(followed) if self.accepts(followed, ranked, &statistics[0], yardstick) => {
                self.of_output_error(ranked, followed, &statistics[0])
            }
            _ => self.of_regression(ranked, statistics, yardstick, followed.as_ref()),
        }
    }

    /// A system of other candidates and known terms, which is otherwise that of this run; `None` where a term does not compile.
    pub(super) fn system_of_terms(
        &self,
        inputs: &[String],
        libraries: &[Library],
        known: &[Vec<Term>],
    ) -> Option<System> {
        let states = self.data.states();
        let measured = (states, states.len() - self.positions.len());
        let system = System::with_known(self.time, measured, inputs, libraries, known).ok()?;
        let system = system.stiff(self.system.is_stiff());
        Some(system.with_diffusion_of(&self.system))
    }

    /// The pieces that all models are ranked on.
    fn yardstick(&self, slopes: &Slopes) -> Vec<Piece<'a>> {
        let rows = self.settings.rows.min(RANKED);
        let states = self.data.states().len();
        prepare::pieces(&self.stretches, states, slopes, &self.inputs.between, rows)
    }

    /// Every regression on every statistics, best first.
    fn rank(
        &mut self,
        statistics: &[Statistics],
        yardstick: &[Piece<'_>],
    ) -> Result<Vec<RankedModel>, SindyError> {
        let mut regressions = Vec::new();
        for statistics in statistics {
            regressions.extend(regress::solve(statistics, &self.signs, self.settings)?);
        }
        if self.settings.discrete {
            self.noise.of_map(&statistics[0], &regressions);
        }
        let rank =
            |regression| RankedModel::new(regression, &self.system, yardstick, &self.noise.sigma);
        let mut ranked: Vec<RankedModel> = regressions.into_par_iter().map(rank).collect();
        if !ranked.iter().any(|r| r.free_run.is_finite()) {
            // Criteria keep too many terms where data hardly distinguish them.
            for statistics in statistics {
                ranked.extend(
                    regress::sparse(statistics, &self.signs)?
                        .into_iter()
                        .map(rank),
                );
            }
        }
        by_free_run(&mut ranked);
        Ok(ranked)
    }

    /// Whether the model by output error replaces the best regression: if it follows whole trajectories to within the
    /// noise, or else if its free run is better. Of a map, if noise of the measurement is likelier.
    fn accepts(
        &self,
        followed: &FollowedModel,
        ranked: &[RankedModel],
        statistics: &Statistics,
        yardstick: &[Piece<'_>],
    ) -> bool {
        // These were tested as they were fitted, or are what was asked for.
        if followed.fit.disturbance.is_some() || self.settings.noise == NoiseSource::Measurement {
            return true;
        }
        let within = self.misfit(&followed.fit) <= FOLLOWS || followed.is_in_noise();
        let follows = followed.longest == usize::MAX && within;
        if self.settings.method == Method::OutputError {
            return true;
        }
        if self.settings.discrete {
            return self.is_measured_map(followed, ranked, statistics);
        }
        if follows {
            return true;
        }
        let coefficients = &followed.fit.coefficients;
        let free_run = free_run(&self.system, yardstick, coefficients, &self.noise.sigma);
        free_run < BETTER * ranked[0].free_run
    }

    /// Slopes by every method that is asked for; those of the first smooth the trajectories too.
    fn regressions(
        &self,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<(Slopes, Vec<Statistics>), SindyError> {
        let n = self.data.states().len();
        let smoothing = &self.settings.smoothing;
        let mut statistics = Vec::new();
        if self.settings.discrete {
            let slopes = prepare::raw(&self.stretches, n);
            self.add(&slopes, &self.stretches, &mut statistics, progress)?;
            return Ok((slopes, statistics));
        }
        if let Some(method) = smoothing.differentiator()? {
            let slopes = prepare::with(&self.stretches, n, method)?;
            self.add(&slopes, &self.stretches, &mut statistics, progress)?;
            return Ok((slopes, statistics));
        }
        if *smoothing == Smoothing::Automatic && self.system.is_stiff() {
            return self.stiff_regressions(progress);
        }
        // If most of the data rest, the moving part is fitted first, with its own smoothing.
        let moving = prepare::moving(&self.stretches, n, &self.noise);
        let mut first = None;
        for (index, part) in moving.iter().chain([&self.stretches]).enumerate() {
            // By name a regression finds its statistics again.
            let place = match moving.is_some() && index == 0 {
                true => ", of what moves",
                false => "",
            };
            let uniform = prepare::is_uniform(self.data, part);
            let both: &[f64] = match *smoothing == Smoothing::Automatic && uniform {
                true => &[1.0, 2.0],
                false => &[1.0],
            };
            for wider in both {
                let mut filters = prepare::filters(part, n, uniform, *wider)?;
                if let Some(filters) = &mut filters {
                    prepare::as_positions(filters, &self.positions);
                }
                let mut slopes = prepare::by(filters.as_deref(), part, n)?;
                slopes.name.push_str(place);
                if *smoothing != Smoothing::Weak {
                    self.add(&slopes, part, &mut statistics, progress)?;
                }
                if first.is_none() {
                    first = Some(prepare::by(filters.as_deref(), &self.stretches, n)?);
                }
            }
            if matches!(smoothing, Smoothing::Automatic | Smoothing::Weak) {
                progress(Progress::Regression {
                    smoothing: "weak form".into(),
                });
                let folds = self.settings.folds;
                let weak = regress::of_weak_form(self.data, part, &self.libraries, folds)?;
                statistics.extend(weak.map(|mut weak| {
                    weak.smoothing.push_str(place);
                    weak
                }));
            }
        }
        match first {
            Some(slopes) if !statistics.is_empty() => Ok((slopes, statistics)),
            _ => Err(SindyError::setting(
                "smoothing",
                "stretches that hold a window of the weak form",
                "shorter ones",
            )),
        }
    }

    /// Adds the statistics of slopes.
    pub(super) fn add(
        &self,
        slopes: &Slopes,
        stretches: &[Stretch<'_>],
        statistics: &mut Vec<Statistics>,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<(), SindyError> {
        progress(Progress::Regression {
            smoothing: slopes.name.clone(),
        });
        let folds = self.settings.folds;
        statistics.push(regress::of_slopes(
            self.data,
            stretches,
            &self.libraries,
            slopes,
            folds,
        )?);
        Ok(())
    }
}
