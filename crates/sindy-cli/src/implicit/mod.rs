//! `sindy implicit`.

pub(crate) mod args;
mod object;
mod show;

use sindy::Library;
use sindy::identify::{Progress, Settings};
use sindy::implicit::IdentifyImplicit;
use touchdown_terminal::{Done, Terminal};

use crate::error::{Error, Result};
use crate::fit::args::check_columns;
use crate::fit::load::{check_rows, dataset};
use crate::output;
use crate::trajectories::{self, WantedColumns};
use args::ImplicitArgs;
use object::ImplicitObject;

pub(crate) fn run(terminal: &Terminal, args: &ImplicitArgs) -> Result<Done> {
    check_columns(
        &args.states,
        &args.inputs,
        args.weights.as_ref(),
        &args.table,
    )?;
    output::check(args.model.iter(), args.data.iter())?;
    let identify = identify(args)?;
    terminal.busy("reading");
    let states = args.states.iter().map(|n| (n.as_str(), "--states"));
    let inputs = args.inputs.iter().map(|n| (n.as_str(), "--inputs"));
    let wanted = WantedColumns {
        columns: states.chain(inputs).collect(),
        weights: args.weights.as_deref(),
        table: &args.table,
    };
    let (mut all, mut files) = (Vec::new(), Vec::new());
    for path in &args.data {
        let (trajectories, report) = trajectories::read(path, &wanted)?;
        all.extend(trajectories);
        files.push(report);
    }
    let data = dataset(all, &args.states, &args.inputs, &files)?;
    check_rows(&data, &files)?;
    let names: Vec<String> = args.data.iter().map(|p| p.display().to_string()).collect();
    let found = identify
        .run(&data, &mut |progress| terminal.busy(&stage(&progress)))
        .map_err(Error::refused(names.join(", ")))?;
    let object = ImplicitObject::new(&found, files);
    if let Some(path) = &args.model {
        let text = found.model.to_json().map_err(Error::refused("the model"))?;
        output::write(path, text.as_bytes())?;
    }
    terminal.finish();
    terminal.say(&show::text(&object));
    for warning in &object.warnings {
        terminal.warn(warning);
    }
    terminal.object(&object);
    Ok(Done::with_loss(object.data.files.iter().any(|f| f.lossy)))
}

/// The identification with the arguments' candidates.
fn identify(args: &ImplicitArgs) -> Result<IdentifyImplicit> {
    let variables = [&args.states[..], &args.inputs].concat();
    let library = |texts: &[String], why: &'static str| {
        Library::specifications(texts, &variables).map_err(Error::refused(why))
    };
    let above = library(&args.library, "--library")?;
    let below = library(&args.denominator, "--denominator")?;
    let settings = Settings {
        known: args.known.clone(),
        ..Settings::default()
    };
    IdentifyImplicit::new(above, below)
        .and_then(|identify| identify.settings(settings))
        .map_err(Error::refused("candidates"))
}

/// The present stage.
fn stage(progress: &Progress) -> String {
    match progress {
        Progress::Smoothing => "smoothing".to_owned(),
        Progress::Regression { smoothing } => format!("regression: {smoothing}"),
        Progress::Relations { number, total } => {
            format!("relation {number} of {total} by its trajectories")
        }
        _ => "output error".to_owned(),
    }
}
