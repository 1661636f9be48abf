//! `sindy fit`.

pub(crate) mod args;
pub(crate) mod figure;
pub(crate) mod load;
pub(crate) mod object;
mod score;
pub(crate) mod settings;
pub(crate) mod show;
mod size;
mod spikes;
mod stream;
mod terms;

use std::path::Path;

use sindy::identify::Progress;
use sindy::{Identification, Identify};

use crate::error::{Error, Result};
use crate::trajectories::{FileReport, Trajectory, past, rates, velocities};
use crate::{drawing, output};
use args::FitArgs;
use load::Train;
use object::FitObject;
pub(crate) use stream::MergeArgs;
use stream::PartialFit;
use touchdown_terminal::Done;
use touchdown_terminal::Terminal;

pub(crate) fn run(terminal: &Terminal, args: &FitArgs) -> Result<Done> {
    args.check()?;
    let read = args.train.iter().chain(&args.test).chain(&args.terms);
    let written = args.model.iter().chain(&args.figure).chain(&args.partial);
    output::check(written, read.chain(&args.settings))?;
    if let Some(path) = &args.figure {
        drawing::check(path)?;
    }
    let settings = settings::of(args)?;
    let train = match args.stream {
        true => None,
        false => {
            if let Some(hint) = size::hint(&args.train, &args.table.columns) {
                terminal.warn(&hint);
            }
            terminal.busy("reading");
            Some(load::train(terminal, args)?)
        }
    };
    let inputs = train.as_ref().map_or(&args.inputs, |t| &t.inputs);
    let libraries = terms::libraries(args, inputs, &settings)?;
    // Bad test data are refused before the time of a fit is spent.
    let test = load::test(terminal, args)?;
    let steps = settings.identify.iterations;
    let positions = settings.identify.second_order.clone();
    let outliers = settings.identify.outliers;
    let identify = Identify::per_equation(libraries)
        .settings(settings.identify)
        .map_err(Error::refused("settings"))?;
    if let Some(path) = &args.partial {
        return stream::write(terminal, args, &identify, path);
    }
    let fitted = fit(terminal, args, train, (&identify, &positions), steps)?;
    let mut warnings = fitted.warnings();
    let Fitted {
        found,
        files,
        trajectories,
    } = fitted;
    terminal.busy("judging");
    let between = &found.inputs_between;
    let judged = match test {
        Some(test) => {
            warnings.extend(test.warnings);
            let have = [&args.states[..], &args.inputs].concat();
            let states = args.states.len();
            let seen = match args.discrete || !args.past.is_empty() {
                true => test.trajectories,
                false => rates::filled(test.trajectories, states, &have, &mut warnings)?,
            };
            let (seen, have) = velocities::add(seen, states, have, &positions)?;
            let seen = past::select(seen, &have, &columns(&found.model))?;
            let seen = spikes::mended(seen, &found.model, outliers, &mut warnings);
            Some(score::of(&found.model, &seen, between, &mut warnings)?)
        }
        None => None,
    };
    let test = judged.as_ref().map(|judged| judged.object.clone());
    let object = FitObject::new(&found, files, test, warnings);
    if let Some(path) = &args.figure {
        let fitted = trajectories.map(|all| {
            let all = spikes::mended(all, &found.model, outliers, &mut Vec::new());
            score::of(&found.model, &all, between, &mut Vec::new())
        });
        let (fitted, judged) = (fitted.transpose()?, judged.as_ref());
        figure::write(path, &found.model, &object, fitted.as_ref(), judged)?;
    }
    conclude(terminal, &found.model, &object, args.model.as_deref())
}

/// `sindy merge`.
pub(crate) fn merge(terminal: &Terminal, args: &MergeArgs) -> Result<Done> {
    output::check(args.model.iter().chain(&args.figure), args.partials.iter())?;
    if let Some(path) = &args.figure {
        drawing::check(path)?;
    }
    let sums = PartialFit::merged(terminal, &args.partials)?;
    let fitted = sums.fit(&args.partials, &mut |progress| {
        // Without output error there are no steps to count.
        terminal.busy(&stage(&progress, 0, None));
    })?;
    let warnings = fitted.warnings();
    let Fitted { found, files, .. } = fitted;
    let object = FitObject::new(&found, files, None, warnings);
    if let Some(path) = &args.figure {
        figure::write(path, &found.model, &object, None, None)?;
    }
    conclude(terminal, &found.model, &object, args.model.as_deref())
}

/// Writes the model and prints the result.
fn conclude(
    terminal: &Terminal,
    model: &sindy::Model,
    object: &FitObject,
    path: Option<&Path>,
) -> Result<Done> {
    if let Some(path) = path {
        let text = model.to_json().map_err(Error::refused("the model"))?;
        output::write(path, text.as_bytes())?;
    }
    terminal.finish();
    terminal.say(&show::text(model, object));
    for warning in &object.warnings {
        terminal.warn(warning);
    }
    terminal.object(object);
    Ok(Done::with_loss(object.data.files.iter().any(|f| f.lossy)))
}

/// A fit with the files and trajectories of its data.
struct Fitted {
    found: Identification,
    files: Vec<FileReport>,
    /// The training trajectories, where they are needed again and in memory.
    trajectories: Option<Vec<Trajectory>>,
}

impl Fitted {
    /// The warnings of the files, then those of the fit.
    fn warnings(&self) -> Vec<String> {
        let files = self.files.iter().flat_map(|f| &f.warnings);
        files.chain(&self.found.warnings).cloned().collect()
    }
}

/// Fits, with the data in memory or in one pass.
fn fit(
    terminal: &Terminal,
    args: &FitArgs,
    train: Option<Train>,
    (identify, positions): (&Identify, &[String]),
    steps: usize,
) -> Result<Fitted> {
    let Some(train) = train else {
        return stream::fit(terminal, args, identify, &mut |progress| {
            terminal.busy(&stage(&progress, steps, None));
        });
    };
    let report = train.data.report();
    let rows = report.rows;
    let mut found = identify
        .run(&train.data, &mut |progress| {
            terminal.busy(&stage(&progress, steps, Some(rows)));
        })
        .inspect_err(|_| load::warn(terminal, &train.files))
        .map_err(Error::refused_data(files(args)))?;
    if !args.past.is_empty() {
        found.model = past::model(&found.model, &args.inputs, report.period)?;
    }
    let mut trajectories = None;
    if args.figure.is_some() {
        let (mut all, states) = (train.trajectories(), args.states.len());
        if !args.discrete && args.past.is_empty() {
            all = rates::filled(all, states, &train.data.names(), &mut Vec::new())?;
        }
        let (all, have) = velocities::add(all, states, train.data.names(), positions)?;
        trajectories = Some(past::select(all, &have, &columns(&found.model))?);
    }
    Ok(Fitted {
        found,
        trajectories,
        files: train.files,
    })
}

/// The columns of a table that goes with a model: states, then inputs.
fn columns(model: &sindy::Model) -> Vec<String> {
    [model.states(), model.inputs()].concat()
}

/// A name of the data, for messages.
fn files(args: &FitArgs) -> String {
    let names: Vec<String> = args.train.iter().map(|p| p.display().to_string()).collect();
    names.join(", ")
}

/// The present stage, of `rows` rows, with at most so many steps of the output error from each start.
fn stage(progress: &Progress, steps: usize, rows: Option<usize>) -> String {
    let of = rows.map_or_else(String::new, |rows| format!(" of {rows} rows"));
    match progress {
        Progress::Smoothing => format!("smoothing{of}"),
        Progress::Regression { smoothing } => format!("regression{of}: {smoothing}"),
        Progress::OutputError {
            start,
            step,
            terms,
            misfit,
        } => format!(
            "output error, start {}, step {step} of at most {steps}: {terms} terms leave {} times the noise",
            start + 1,
            sindy::identify::ratio(*misfit)
        ),
        Progress::AllRows { step } => format!("output error{of}, step {step} of at most {steps}"),
        _ => "fitting".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_progress_says_totals_where_they_are_known() {
        let smoothing = "splines".to_owned();
        let said = stage(&Progress::Regression { smoothing }, 60, Some(1_000_000));
        assert_eq!(said, "regression of 1000000 rows: splines");
        let step = Progress::OutputError {
            start: 1,
            step: 4,
            terms: 7,
            misfit: 1.0,
        };
        let said = stage(&step, 60, None);
        assert!(
            said.starts_with("output error, start 2, step 4 of at most 60: 7 terms"),
            "{said}"
        );
        assert_eq!(stage(&Progress::Smoothing, 60, None), "smoothing");
    }
}
