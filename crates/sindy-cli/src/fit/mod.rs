//! `sindy fit`.

pub(crate) mod args;
mod figure;
mod load;
mod object;
mod score;
pub(crate) mod settings;
mod show;
mod terms;

use sindy::Identify;
use sindy::identify::Progress;

use crate::Done;
use crate::args::Between;
use crate::context::Context;
use crate::error::{Error, Result};
use crate::{drawing, output};
use args::FitArgs;
use object::FitObject;

pub(crate) fn run(context: &Context, args: &FitArgs) -> Result<Done> {
    for path in args.model.iter().chain(&args.figure) {
        output::check(path)?;
    }
    if let Some(path) = &args.figure {
        drawing::check(path)?;
    }
    let settings = settings::of(args)?;
    let libraries = terms::libraries(args, &settings)?;
    context.busy("reading");
    let train = load::train(args)?;
    // Bad test data are told before the time of a fit is spent.
    let test = load::test(args)?;

    let identify = Identify::per_equation(libraries)
        .settings(settings.identify)
        .map_err(Error::refused("settings"))?;
    let found = identify
        .run(&train.data, &mut |progress| context.busy(&stage(&progress)))
        .map_err(Error::refused(files(args)))?;
    let mut warnings = train.warnings.clone();
    warnings.extend(found.warnings.iter().cloned());

    context.busy("judging");
    let between = Between::Linear;
    let test = match &test {
        Some(test) => {
            warnings.extend(test.warnings.iter().cloned());
            let score = score::of(&found.model, &test.trajectories, between, &mut warnings)?;
            Some(score)
        }
        None => None,
    };
    let (test, judged) = match test {
        Some(test) => (Some(test.object.clone()), Some(test)),
        None => (None, None),
    };
    let lossy = train.lossy();
    let trajectories = args.figure.as_ref().map(|_| train.trajectories());
    let object = FitObject::new(&found, train.files, test, warnings);
    if let (Some(path), Some(trajectories)) = (&args.figure, trajectories) {
        let fitted = score::of(&found.model, &trajectories, between, &mut Vec::new())?;
        figure::write(path, &found.model, &object, &fitted, judged.as_ref())?;
    }
    if let Some(path) = &args.model {
        let text = found.model.to_json().map_err(Error::refused("the model"))?;
        output::write(path, text.as_bytes())?;
    }
    context.finish();
    context.say(&show::text(&found.model, &object));
    for warning in &object.warnings {
        context.warn(warning);
    }
    context.object(&object)?;
    Ok(if lossy { Done::WithLoss } else { Done::Whole })
}

/// What the fit is of, for messages.
fn files(args: &FitArgs) -> String {
    let names: Vec<String> = args.train.iter().map(|p| p.display().to_string()).collect();
    names.join(", ")
}

fn stage(progress: &Progress) -> String {
    match progress {
        Progress::Smoothing => "smoothing".to_owned(),
        Progress::Regression { smoothing } => format!("regression: {smoothing}"),
        Progress::OutputError {
            start,
            step,
            terms,
            misfit,
        } => format!(
            "output error, start {}, step {step}: {terms} terms leave {misfit:.2} times the noise",
            start + 1
        ),
        _ => "fitting".to_owned(),
    }
}
