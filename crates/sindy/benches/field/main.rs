//! Problems with known equations: `cargo bench -p sindy --bench field` fits all of them and prints a table, or a
//! line of JSON for each fit. README.md beside this file says what is in it.

#![allow(clippy::print_stdout, missing_docs)]

mod beside;
mod corruption;
mod problems;
mod pysindy;
mod score;
mod simulate;
mod stiff;
mod systems;

use std::error::Error;
use std::fs::File;
use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::time::Instant;

use rand::SeedableRng;
use rand_pcg::Pcg64;
use rayon::prelude::*;
use serde_json::json;
use sindy::{Dataset, Identify, Library, SindyError, identify::Settings};

use problems::{PROBLEMS, Problem};
use score::{Fitted, row, summary};
use simulate::Rows;
use systems::{Candidates, Clock};

type Failure = Box<dyn Error + Send + Sync>;

/// Seeds of each problem.
const SEEDS: u64 = 5;

/// What the command line asks for.
struct Options {
    /// Parts of names, one of which a problem has to contain.
    only: Vec<String>,
    seeds: Range<u64>,
    json: Option<PathBuf>,
    write: Option<PathBuf>,
    /// The interpreter that has PySINDy.
    python: PathBuf,
}

fn main() -> Result<(), Failure> {
    let options = options()?;
    let wanted = |p: &&Problem| {
        let name = p.name();
        options.only.is_empty() || options.only.iter().any(|part| name.contains(part))
    };
    let chosen: Vec<&Problem> = PROBLEMS.iter().filter(wanted).collect();
    if let Some(folder) = &options.write {
        for problem in chosen {
            write(problem, options.seeds.clone(), folder)?;
        }
        return Ok(());
    }
    let file = options
        .json
        .as_ref()
        .map(std::fs::File::create)
        .transpose()?;
    let ours = ours(&chosen, &options, file.as_ref())?;
    let theirs = match pysindy::available(&options.python) {
        Ok(()) => theirs(&chosen, &options, file.as_ref())?,
        Err(why) => {
            println!("PySINDy is skipped: {why}\n");
            Vec::new()
        }
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
    if !theirs.is_empty() {
        println!("\n{}", beside::report(&chosen, &ours, &theirs));
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

/// A stream of random numbers for each problem and seed (FNV-1a of the name).
fn random(problem: &Problem, seed: u64) -> Pcg64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for byte in problem.name().bytes() {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    }
    Pcg64::seed_from_u64(hash.wrapping_add(seed))
}

/// The spoilt rows of a problem.
fn rows(problem: &Problem, seed: u64) -> Result<Vec<Rows>, SindyError> {
    let mut rng = random(problem, seed);
    let still = vec![0.0; problem.system.states.len()];
    let clean = simulate::simulate(&problem.system, problem.corruption, &still, &mut rng)?;
    let sd = simulate::scatter(&clean);
    let process = 0.01 * problem.corruption.process();
    let mut rows = if process > 0.0 {
        let drive: Vec<f64> = sd.iter().map(|sd| process * sd).collect();
        simulate::simulate(&problem.system, problem.corruption, &drive, &mut rng)?
    } else {
        clean
    };
    for run in &mut rows {
        problem.corruption.apply(&mut run.states, &sd, &mut rng);
    }
    Ok(rows)
}

/// The candidate terms of a problem.
fn library(problem: &Problem) -> Result<Library, SindyError> {
    let system = &problem.system;
    let names: Vec<&str> = system.states.iter().chain(system.inputs).copied().collect();
    let all = match system.candidates {
        Candidates::Degree(degree) => Library::polynomial(&names, degree)?,
        Candidates::Terms(terms) => Library::parse(terms)?,
    };
    let lacking: Vec<usize> = (0..all.len())
        .filter(|&j| problem.without.contains(&all.names()[j].as_str()))
        .collect();
    Ok(all.without(&lacking))
}

fn fit(problem: &Problem, seed: u64) -> Result<Fitted, SindyError> {
    let mut data = Dataset::new(problem.system.states, problem.system.inputs)?;
    for (k, run) in rows(problem, seed)?.into_iter().enumerate() {
        let columns = [run.states, run.inputs].concat();
        data.push(format!("run {k}"), run.time, columns, None)?;
    }
    let settings = Settings {
        discrete: problem.system.clock == Clock::Map,
        ..Settings::default()
    };
    let begun = Instant::now();
    let found = Identify::new(library(problem)?)
        .settings(settings)?
        .run(&data, &mut |_| ());
    Fitted::new(problem, seed, found, begun.elapsed().as_secs_f64())
}

/// The same rows as files, for other programs: in a folder of the problem one for each seed, with one CSV file for each
/// trajectory, and `problem.json`. Returns the problem's folder.
fn write(problem: &Problem, seeds: Range<u64>, folder: &Path) -> Result<PathBuf, Failure> {
    let system = &problem.system;
    let name = problem
        .name()
        .replace(|c: char| !c.is_ascii_alphanumeric(), "_");
    let names: Vec<&str> = [&["t"], system.states, system.inputs].concat();
    let degree = match system.candidates {
        Candidates::Degree(degree) if problem.is_complete() => Some(degree),
        _ => None,
    };
    let about = json!({
        "name": problem.name(),
        "states": system.states,
        "inputs": system.inputs,
        "degree": degree,
        "library": library(problem)?.names(),
        "truth": system.truth,
        "discrete": system.clock == Clock::Map,
        "complete": problem.is_complete(),
    });
    let all = folder.join(name);
    for seed in seeds {
        let folder = all.join(seed.to_string());
        std::fs::create_dir_all(&folder)?;
        for (k, run) in rows(problem, seed)?.iter().enumerate() {
            let mut text = names.join(",") + "\n";
            for row in 0..run.time.len() {
                let values = run.states.iter().chain(&run.inputs).map(|c| c[row]);
                let cells: Vec<String> = std::iter::once(run.time[row])
                    .chain(values)
                    .map(|v| v.to_string())
                    .collect();
                text += &(cells.join(",") + "\n");
            }
            std::fs::write(folder.join(format!("run{k}.csv")), text)?;
        }
        std::fs::write(folder.join("problem.json"), format!("{about}\n"))?;
    }
    Ok(all)
}
