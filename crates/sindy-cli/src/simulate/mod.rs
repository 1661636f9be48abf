//! `sindy simulate`.

pub(crate) mod args;
pub(crate) mod figure;
pub(crate) mod object;
pub(crate) mod setup;

use sindy::model::{History, Limits, Run, RunOutcome, Simulation, Time};
use sindy::{Model, SindyError};

use crate::drawing;
use crate::error::{Error, Result};
use crate::output;
use args::SimulateArgs;
use object::{RunObject, SimulateObject};
use setup::RunTask;
use touchdown_terminal::Done;
use touchdown_terminal::Terminal;

/// A run, and what it is compared with.
pub(crate) struct Simulated {
    pub(crate) task: RunTask,
    pub(crate) run: Run,
}

pub(crate) fn run(terminal: &Terminal, args: &SimulateArgs) -> Result<Done> {
    output::check(
        args.output.iter().chain(&args.figure),
        std::iter::once(&args.model)
            .chain(&args.data)
            .chain(&args.inputs_from),
    )?;
    if let Some(path) = &args.figure {
        drawing::check(path)?;
    }
    let to_stdout = args.output.as_deref().is_some_and(|p| p.as_os_str() == "-");
    if to_stdout && terminal.wants_json() {
        return Err(Error::Arguments(
            "--output - and --json both want standard output; name a file for the runs".to_owned(),
        ));
    }
    let model = read_model(args)?;
    let setup = setup::of(&model, args)?;
    let how = args
        .fixed_step
        .map_or_else(Simulation::adaptive, Simulation::fixed);
    let mut simulated = Vec::with_capacity(setup.tasks.len());
    for task in setup.tasks {
        terminal.busy(&format!("running {}", task.name));
        let run = simulate(&model, &task, &how)?;
        simulated.push(Simulated { task, run });
    }
    terminal.finish();
    let mut warnings = setup.warnings;
    warnings.extend(
        simulated
            .iter()
            .filter_map(|s| ended_early(&s.task.name, &s.run)),
    );
    let runs: Vec<RunObject> = simulated.iter().map(|s| RunObject::of(&model, s)).collect();

    if to_stdout {
        terminal.print(&object::csv(&model, &simulated));
    } else if let Some(path) = &args.output {
        output::write(path, object::csv(&model, &simulated).as_bytes())?;
    }
    if let Some(path) = &args.figure {
        figure::write(path, &model, &simulated, &runs)?;
    }
    let text = object::text(&model, &runs);
    if to_stdout {
        terminal.aside(&text);
    } else {
        terminal.say(&text);
    }
    for warning in &warnings {
        terminal.warn(warning);
    }
    terminal.object(&SimulateObject { runs, warnings });
    Ok(if setup.lossy {
        Done::WithLoss
    } else {
        Done::Whole
    })
}

fn read_model(args: &SimulateArgs) -> Result<Model> {
    let text = touchdown_files::read_text(&args.model).map_err(Error::unread(&args.model))?;
    Model::from_json(&text).map_err(Error::refused(args.model.display().to_string()))
}

/// The run of a task.
pub(crate) fn simulate(model: &Model, task: &RunTask, how: &Simulation) -> Result<Run> {
    let run = match model.time() {
        Time::Continuous if !model.past().is_empty() => {
            history(task).and_then(|h| model.simulate_past(&h, &task.time, &task.inputs, how))
        }
        Time::Continuous => model.simulate(&task.start, &task.time, &task.inputs, how),
        Time::Discrete { .. } => iterate(model, task),
    };
    run.map_err(Error::refused(task.name.clone()))
}

/// The states up to the start: as measured, or constant.
fn history(task: &RunTask) -> std::result::Result<History, SindyError> {
    let Some(before) = &task.before else {
        return Ok(History::constant(&task.start));
    };
    let mut states = before.states.clone();
    for (column, start) in states.iter_mut().zip(&task.start) {
        if let Some(last) = column.last_mut() {
            *last = *start;
        }
    }
    let states: Vec<&[f64]> = states.iter().map(Vec::as_slice).collect();
    History::sampled(&before.time, &states)
}

fn iterate(model: &Model, task: &RunTask) -> std::result::Result<Run, SindyError> {
    let steps = task.time.len() - 1;
    let mut columns = vec![Vec::with_capacity(steps); model.inputs().len()];
    if !columns.is_empty() {
        for &t in &task.time[..steps] {
            for (column, value) in columns.iter_mut().zip(task.inputs.at(t)?) {
                column.push(value);
            }
        }
    }
    let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let mut run = model.iterate(&task.start, steps, &columns, &Limits::default())?;
    // The model counts from zero.
    run.time = task.time[..run.time.len()].to_vec();
    Ok(run)
}

/// A warning about the end of a run.
fn ended_early(name: &str, run: &Run) -> Option<String> {
    let how = match &run.outcome {
        RunOutcome::Finished => return None,
        RunOutcome::BlewUp { time } => format!("blew up at time {time}"),
        RunOutcome::OutOfRange { time, state } => {
            format!("left the range of `{state}` at time {time}")
        }
        RunOutcome::StepTooSmall { time } => {
            format!("stopped at time {time}: no step is small enough")
        }
        RunOutcome::StepLimit { time } => format!("stopped at time {time}: too many steps"),
        _ => "ended early".to_owned(),
    };
    Some(format!("{name}: the run {how}"))
}
