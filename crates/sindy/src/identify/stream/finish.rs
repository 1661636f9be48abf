//! From the sums of a pass to a model.

use super::Columns;
use super::clusters::ClusterSums;
use super::kept::Kept;
use super::pass::Passed;
use crate::data::dataset::Dataset;
use crate::error::SindyError;
use crate::identify::inputs;
use crate::identify::known::KnownPart;
use crate::identify::prepare::noise;
use crate::identify::rank::{RANKED, RankedModel};
use crate::identify::regress::{self, Regression, Statistics};
use crate::identify::run::IdentificationRun;
use crate::identify::{Identification, Progress, Settings, Smoothing, check_rows, warnings};
use crate::library::Library;
use crate::model::{Interpolation, Time};
use crate::trajectory::output_error::{Piece, System};

/// Free runs whose errors differ by less than this factor are alike: three times their scatter over [`RANKED`] rows.
const ALIKE: f64 = 1.02;

pub(super) fn of(
    passed: Passed,
    columns: &Columns,
    libraries: Vec<Library>,
    settings: &Settings,
    progress: &mut dyn FnMut(Progress),
) -> Result<Identification, SindyError> {
    let report = passed.report;
    let (statistics, kept) = statistics(passed, &libraries, settings);
    check_rows(
        report.rows - report.missing_rows - report.short_rows,
        &libraries,
    )?;
    let data = dataset(&kept, columns)?;
    let time = match settings.discrete {
        false => Time::Continuous,
        true => Time::Discrete {
            period: report.period,
        },
    };
    let stretches = data.stretches();
    let system = System::new(time, &columns.states, &columns.inputs, &libraries)?;
    let inputs = inputs::choose(&stretches, columns.states.len(), settings.inputs_between);
    let pieces = pieces(&kept, columns, &inputs.between);
    let libraries: Vec<(Library, KnownPart)> = libraries
        .into_iter()
        .map(|library| (library, KnownPart::default()))
        .collect();
    let mut warnings = warnings::of_data(&report, &statistics[0], &libraries, &data.samples()?)?;
    if !settings.discrete {
        let weights = pieces.iter().filter_map(|p| p.weights).flatten();
        warnings.extend(warnings::weights_differ(weights));
    }
    let mut run = IdentificationRun {
        data: &data,
        settings,
        time,
        noise: noise(&stretches, columns.states.len()),
        stretches,
        inputs,
        warnings,
        system,
        signs: vec![Vec::new(); columns.states.len()],
        libraries,
        positions: Vec::new(),
        conserved: None,
        diffusion: None,
        stable: None,
    };
    let mut regressions = Vec::new();
    for statistics in &statistics {
        progress(Progress::Regression {
            smoothing: statistics.smoothing.clone(),
        });
        regressions.extend(solve(statistics, settings)?);
    }
    if settings.discrete {
        run.noise.of_map(&statistics[0], &regressions);
    }
    let rank_one =
        |regression| RankedModel::new(regression, &run.system, &pieces, &run.noise.sigma);
    let mut ranked: Vec<RankedModel> = regressions.into_iter().map(rank_one).collect();
    rank(&mut ranked);
    let clusters = statistics[0].grams[0].iter().filter(|g| g.rows > 0).count();
    let mut found = run.of_regression(&ranked, &statistics, &pieces, None)?;
    found.choice.reason.push_str(&format!(
        "; statistics of all {} rows in one pass, in {clusters} clusters; free runs over {} of them",
        report.rows,
        pieces.iter().map(|p| p.time.len()).sum::<usize>()
    ));
    found.data = report;
    Ok(found)
}

/// Best first: the fewest terms among those that predict alike, then by free run. Models none of which can be run stay
/// in their order, best subsets first.
fn rank(ranked: &mut [RankedModel]) {
    let least = ranked
        .iter()
        .map(|r| r.free_run)
        .fold(f64::INFINITY, f64::min);
    let key = |r: &RankedModel| {
        if !r.free_run.is_finite() {
            (2, 0, 0.0)
        } else if r.free_run <= ALIKE * least {
            (0, r.terms(), r.free_run)
        } else {
            (1, 0, r.free_run)
        }
    };
    ranked.sort_by(|a, b| {
        let (a, b) = (key(a), key(b));
        (a.0, a.1).cmp(&(b.0, b.1)).then(a.2.total_cmp(&b.2))
    });
}

/// The statistics of the pass, of those kinds that are asked for, and the pieces that it kept.
fn statistics(
    passed: Passed,
    libraries: &[Library],
    settings: &Settings,
) -> (Vec<Statistics>, Vec<Kept>) {
    let plan = passed.plan;
    let terms: Vec<usize> = libraries.iter().map(Library::len).collect();
    let weak = passed.weak.filter(|w| w.used() > 0).map(|w| Statistics {
        smoothing: format!(
            "weak form, half-width {:.4}",
            plan.half_width.unwrap_or(0.0)
        ),
        grams: w.full(&terms),
        independent: regress::INDEPENDENT_WINDOWS,
        separate: Vec::new(),
    });
    let of_slopes = |(s, sums): (&super::slopes::Slopes, ClusterSums)| Statistics {
        smoothing: s.name.clone(),
        grams: sums.full(&terms),
        independent: 1.0 / s.window,
        separate: Vec::new(),
    };
    let mut all = Vec::new();
    if settings.smoothing != Smoothing::Weak || weak.is_none() {
        all.extend(plan.slopes.iter().zip(passed.slopes).map(of_slopes));
    }
    all.extend(weak);
    (all, passed.kept.pieces)
}

/// Solves all regressions. With more rows than [`Settings::rows`], best subsets are also found with the penalty of
/// [`Settings::rows`] rows. The errors of smoothing do not average out, so with enough rows each of them justifies a term.
fn solve(statistics: &Statistics, settings: &Settings) -> Result<Vec<Regression>, SindyError> {
    let signs = vec![Vec::new(); statistics.grams.len()];
    let mut all = regress::solve(statistics, &signs, settings)?;
    let rows: usize = statistics.grams[0].iter().map(|g| g.rows).sum();
    if rows > settings.rows {
        let fewer = Statistics {
            smoothing: statistics.smoothing.clone(),
            grams: statistics.grams.clone(),
            independent: statistics.independent * settings.rows as f64 / rows as f64,
            separate: Vec::new(),
        };
        let fewer = regress::solve(&fewer, &signs, settings)?.into_iter();
        all.extend(fewer.filter(|r| r.solver == "best_subset").map(|r| {
            let name = format!("{}, penalised as {} rows", r.name, settings.rows);
            Regression { name, ..r }
        }));
    }
    Ok(all)
}

/// The pieces that were kept as a data set.
fn dataset(kept: &[Kept], columns: &Columns) -> Result<Dataset, SindyError> {
    let mut data = Dataset::new(&columns.states, &columns.inputs)?;
    let width = 1 + columns.states.len() + columns.inputs.len();
    for piece in kept {
        data.push(
            "piece",
            piece.columns[0].clone(),
            piece.columns[1..width].to_vec(),
            None,
        )?;
    }
    Ok(data)
}

/// Evenly spread pieces for free runs, of [`RANKED`] rows or somewhat more.
fn pieces<'a>(kept: &'a [Kept], columns: &Columns, between: &[Interpolation]) -> Vec<Piece<'a>> {
    let rows: usize = kept.iter().map(|k| k.columns[0].len()).sum();
    let states = columns.states.len();
    let width = 1 + states + columns.inputs.len();
    let slices = |columns: &'a [Vec<f64>]| columns.iter().map(Vec::as_slice).collect();
    kept.iter()
        .step_by((rows / RANKED).max(1))
        .map(|k| Piece {
            time: &k.columns[0],
            states: slices(&k.columns[1..=states]),
            inputs: slices(&k.columns[1 + states..width]),
            between: between.to_vec(),
            weights: k.columns.get(width).map(Vec::as_slice),
            seen: Vec::new(),
            smooth: k.smooth.clone(),
        })
        .collect()
}
