//! Problems with known equations: `cargo bench -p sindy --bench field` fits all of them and prints a table, or a
//! line of JSON for each fit. README.md beside this file says what is in it.

#![allow(clippy::print_stdout, missing_docs)]

mod beside;
mod corruption;
mod data;
mod diffusion;
mod problems;
mod pysindy;
mod score;
mod simulate;
mod systems;
mod tables;

use std::error::Error;
use std::fs::File;
use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use rayon::prelude::*;
use sindy::identify::{NoiseSource, Settings};
use sindy::{Dataset, Identify, SindyError};

use corruption::Corruption;
use data::{library, rows, write};
use diffusion::Diffusion;
use problems::{PROBLEMS, Problem};
use score::{Fitted, row, summary};
use systems::{Clock, Task};

type Failure = Box<dyn Error + Send + Sync>;

/// Seeds of each problem.
const SEEDS: u64 = 5;

/// What the command line asks for.
struct Options {
    /// Parts of names, one of which a problem's name or class has to contain.
    only: Vec<String>,
    seeds: Range<u64>,
    json: Option<PathBuf>,
    write: Option<PathBuf>,
    /// The interpreter that has PySINDy.
    python: PathBuf,
}

fn main() -> Result<(), Failure> {
    let options = options()?;
    let is_asked = |name: &str, class: &str| {
        let has = |part: &String| name.contains(part) || class.contains(part.as_str());
        options.only.is_empty() || options.only.iter().any(has)
    };
    let problems = PROBLEMS.iter();
    let chosen: Vec<&Problem> = problems
        .filter(|p| is_asked(&p.name(), p.class()))
        .collect();
    if let Some(folder) = &options.write {
        for problem in chosen {
            write(problem, options.seeds.clone(), folder)?;
        }
        return Ok(());
    }
    let mut tables = tables::all()?;
    tables.retain(|t| is_asked(t.name, tables::CLASS));
    let file = options
        .json
        .as_ref()
        .map(std::fs::File::create)
        .transpose()?;
    let python = match pysindy::available(&options.python) {
        Ok(()) => Some(options.python.as_path()),
        Err(why) => {
            println!("PySINDy is skipped: {why}\n");
            None
        }
    };
    if !chosen.is_empty() {
        report(&chosen, &options, python, file.as_ref())?;
    }
    if !tables.is_empty() {
        let line = |value: &serde_json::Value| line(file.as_ref(), value);
        println!("\n{}", tables::report(&tables, python, line)?);
    }
    Ok(())
}

/// Fits all problems and prints what came of it.
fn report(
    chosen: &[&Problem],
    options: &Options,
    python: Option<&Path>,
    file: Option<&File>,
) -> Result<(), Failure> {
    let ours = ours(chosen, options, file)?;
    let theirs = match python {
        Some(_) => theirs(chosen, options, file)?,
        None => Vec::new(),
    };
    let more = |line: &str| {
        if theirs.is_empty() {
            String::new()
        } else {
            line.into()
        }
    };
    let [names, rule] = score::HEADER;
    println!("{names}{}", more(beside::HEADER[0]));
    println!("{rule}{}", more(beside::HEADER[1]));
    for (p, problem) in chosen.iter().enumerate() {
        let cells = theirs.get(p).map(|t| beside::cells(t.as_ref()));
        println!("{}{}", row(problem, &ours[p]), cells.unwrap_or_default());
    }
    let all: Vec<(&Problem, &Fitted)> = chosen
        .iter()
        .zip(&ours)
        .flat_map(|(p, fits)| fits.iter().map(|f| (*p, f)))
        .collect();
    println!("{}", summary(&all));
    if let Some(table) = diffusion::table(chosen, &ours) {
        println!("\n{table}");
    }
    if !theirs.is_empty() {
        println!("\n{}", beside::report(chosen, &ours, &theirs));
    }
    Ok(())
}

/// The fits of each problem by seed.
fn ours(
    chosen: &[&Problem],
    options: &Options,
    file: Option<&File>,
) -> Result<Vec<Vec<Fitted>>, Failure> {
    let jobs: Vec<(&Problem, u64)> = chosen
        .iter()
        .flat_map(|p| options.seeds.clone().map(move |seed| (*p, seed)))
        .collect();
    let mut done = jobs
        .par_iter()
        .map(|&(problem, seed)| {
            let fitted = fit(problem, seed)?;
            line(file, &fitted.json(&problem.name()))?;
            Ok(fitted)
        })
        .collect::<Result<Vec<_>, Failure>>()?
        .into_iter();
    let seeds = options.seeds.clone().count();
    Ok(chosen
        .iter()
        .map(|_| done.by_ref().take(seeds).collect())
        .collect())
}

/// PySINDy's fits of the same rows; none of problems that lack a true term, where no choice of terms is right.
fn theirs(
    chosen: &[&Problem],
    options: &Options,
    file: Option<&File>,
) -> Result<Vec<Option<pysindy::Fits>>, Failure> {
    let folder = tempfile::tempdir()?;
    chosen
        .par_iter()
        .map(|problem| {
            if !problem.is_complete() {
                return Ok(None);
            }
            let data = write(problem, options.seeds.clone(), folder.path())?;
            let fits = pysindy::fits(&options.python, &data, problem, options.seeds.clone())?;
            std::fs::remove_dir_all(data)?;
            for value in fits.json(&problem.name()) {
                line(file, &value)?;
            }
            Ok(Some(fits))
        })
        .collect()
}

/// One write for each line: those of several threads do not mix.
fn line(file: Option<&File>, value: &serde_json::Value) -> std::io::Result<()> {
    match file {
        Some(mut file) => file.write_all(format!("{value}\n").as_bytes()),
        None => Ok(()),
    }
}

fn options() -> Result<Options, Failure> {
    let mut out = Options {
        only: Vec::new(),
        seeds: 0..SEEDS,
        json: None,
        write: None,
        python: "python3".into(),
    };
    let mut arguments = std::env::args().skip(1);
    while let Some(name) = arguments.next() {
        // `cargo bench` adds it.
        if name == "--bench" {
            continue;
        }
        let value = arguments.next().ok_or(format!("{name} needs a value"))?;
        match name.as_str() {
            "--only" => out.only.push(value),
            "--seeds" => {
                let (from, to) = value.split_once("..").ok_or("--seeds FROM..TO")?;
                out.seeds = from.parse()?..to.parse()?;
            }
            "--json" => out.json = Some(value.into()),
            "--write" => out.write = Some(value.into()),
            "--python" => out.python = value.into(),
            other => {
                return Err(format!(
                    "unknown option {other}; known: --only --seeds --json --write --python"
                )
                .into());
            }
        }
    }
    Ok(out)
}

/// The defaults, and what a problem says of itself: that it is a map, that velocities are not measured, that a diffusion is looked for.
fn settings(problem: &Problem) -> Settings {
    let system = &problem.system;
    let names = |of: &[&str]| of.iter().map(ToString::to_string).collect();
    Settings {
        discrete: system.clock == Clock::Map,
        second_order: match system.task {
            Task::Positions => names(system.measured()),
            _ => Vec::new(),
        },
        noise: match (system.task, problem.corruption) {
            (Task::Diffusion(_), Corruption::None) => NoiseSource::Process,
            (Task::Diffusion(_), _) => NoiseSource::Both,
            _ => NoiseSource::Automatic,
        },
        diffusion: match system.task {
            Task::Diffusion(_) => vec![diffusion::CANDIDATES.into()],
            _ => Vec::new(),
        },
        ..Settings::default()
    }
}

fn fit(problem: &Problem, seed: u64) -> Result<Fitted, SindyError> {
    let system = &problem.system;
    let mut data = Dataset::new(system.measured(), system.inputs)?;
    for (k, run) in rows(problem, seed)?.into_iter().enumerate() {
        let columns = [run.states, run.inputs].concat();
        data.push(format!("run {k}"), run.time, columns, None)?;
    }
    let identify = |settings| -> Result<_, SindyError> {
        let identify = Identify::new(library(problem)?).settings(settings)?;
        Ok(identify.run(&data, &mut |_| ()))
    };
    let settings = settings(problem);
    let begun = Instant::now();
    let found = identify(settings.clone())?;
    let mut fitted = Fitted::new(problem, seed, &found, begun.elapsed().as_secs_f64())?;
    if let (Task::Diffusion(_), Some(truth), Ok(found)) =
        (system.task, simulate::diffusions(system)?, &found)
    {
        let constant = identify(Settings {
            diffusion: Vec::new(),
            ..settings
        })?;
        fitted.diffusion = Some(Diffusion::new(&truth, found, constant)?);
    }
    Ok(fitted)
}
