//! Problems that no setting was tuned on: `cargo bench -p sindy --bench field` fits all of them and prints a table, or a
//! line of JSON for each fit. README.md beside this file says what is in it.

#![allow(clippy::print_stdout, missing_docs)]

mod corruption;
mod problems;
mod score;
mod simulate;
mod systems;

use std::error::Error;
use std::io::Write;
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

/// Seeds of each problem.
const SEEDS: u64 = 5;

/// What the command line asks for.
struct Options {
    /// Parts of names, one of which a problem has to contain.
    only: Vec<String>,
    seeds: std::ops::Range<u64>,
    json: Option<PathBuf>,
    write: Option<PathBuf>,
}

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let options = options()?;
    let wanted = |p: &&Problem| {
        let name = p.name();
        options.only.is_empty() || options.only.iter().any(|part| name.contains(part))
    };
    let chosen: Vec<&Problem> = PROBLEMS.iter().filter(wanted).collect();
    if let Some(folder) = &options.write {
        for problem in chosen {
            for seed in options.seeds.clone() {
                write(problem, seed, folder)?;
            }
        }
        return Ok(());
    }
    let jobs: Vec<(usize, u64)> = (0..chosen.len())
        .flat_map(|p| options.seeds.clone().map(move |seed| (p, seed)))
        .collect();
    let file = options
        .json
        .as_ref()
        .map(std::fs::File::create)
        .transpose()?;
    let done = jobs
        .par_iter()
        .map(|&(p, seed)| {
            let fitted = fit(chosen[p], seed)?;
            if let Some(mut file) = file.as_ref() {
                // One write: lines of several threads do not mix.
                file.write_all(format!("{}\n", fitted.json(&chosen[p].name())).as_bytes())?;
            }
            Ok((p, fitted))
        })
        .collect::<Result<Vec<_>, Box<dyn Error + Send + Sync>>>()?;
    println!("{}", score::HEADER);
    for (p, problem) in chosen.iter().enumerate() {
        let own: Vec<&Fitted> = done.iter().filter(|d| d.0 == p).map(|d| &d.1).collect();
        println!("{}", row(problem, &own));
    }
    let all: Vec<(&Problem, &Fitted)> = done.iter().map(|(p, f)| (chosen[*p], f)).collect();
    println!("{}", summary(&all));
    Ok(())
}

fn options() -> Result<Options, Box<dyn Error + Send + Sync>> {
    let mut out = Options {
        only: Vec::new(),
        seeds: 0..SEEDS,
        json: None,
        write: None,
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
            other => {
                return Err(format!(
                    "unknown option {other}; known: --only --seeds --json --write"
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

/// The same rows as files, for other programs: a folder with one CSV file for each trajectory, and `problem.json`.
fn write(problem: &Problem, seed: u64, folder: &Path) -> Result<(), Box<dyn Error + Send + Sync>> {
    let name = problem
        .name()
        .replace(|c: char| !c.is_ascii_alphanumeric(), "_");
    let folder = folder.join(name).join(seed.to_string());
    std::fs::create_dir_all(&folder)?;
    let names: Vec<&str> = [&["t"], problem.system.states, problem.system.inputs].concat();
    for (k, run) in rows(problem, seed)?.iter().enumerate() {
        let mut text = names.join(",") + "\n";
        for row in 0..run.time.len() {
            let values = run.states.iter().chain(&run.inputs).map(|c| c[row]);
            let all: Vec<String> = std::iter::once(run.time[row])
                .chain(values)
                .map(|v| v.to_string())
                .collect();
            text += &(all.join(",") + "\n");
        }
        std::fs::write(folder.join(format!("run{k}.csv")), text)?;
    }
    let about = json!({
        "name": problem.name(),
        "states": problem.system.states,
        "inputs": problem.system.inputs,
        "library": library(problem)?.names(),
        "truth": problem.system.truth,
        "discrete": problem.system.clock == Clock::Map,
        "complete": problem.is_complete(),
    });
    std::fs::write(folder.join("problem.json"), about.to_string() + "\n")?;
    Ok(())
}
