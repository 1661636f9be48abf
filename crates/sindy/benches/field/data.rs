//! The rows and the library of a problem, for the fit and as files for other programs.

use std::ops::Range;
use std::path::{Path, PathBuf};

use rand::SeedableRng;
use rand_pcg::Pcg64;
use serde_json::{Value, json};
use sindy::{Library, SindyError};

use crate::Failure;
use crate::corruption::Corruption;
use crate::problems::Problem;
use crate::simulate::{self, Rows};
use crate::systems::{Candidates, Clock};

/// A stream of random numbers for each problem and seed (FNV-1a of the name).
fn random(problem: &Problem, seed: u64) -> Pcg64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for byte in problem.name().bytes() {
        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
    }
    Pcg64::seed_from_u64(hash.wrapping_add(seed))
}

/// The spoilt rows of a problem.
pub(crate) fn rows(problem: &Problem, seed: u64) -> Result<Vec<Rows>, SindyError> {
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
        run.states.truncate(problem.system.measured().len());
    }
    Ok(rows)
}

/// The candidate terms of a problem.
pub(crate) fn library(problem: &Problem) -> Result<Library, SindyError> {
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

/// The same rows as files, for other programs: in a folder of the problem one for each seed, with one CSV file for each
/// trajectory, and `problem.json`. Returns the problem's folder.
pub(crate) fn write(
    problem: &Problem,
    seeds: Range<u64>,
    folder: &Path,
) -> Result<PathBuf, Failure> {
    let system = &problem.system;
    let name = problem
        .name()
        .replace(|c: char| !c.is_ascii_alphanumeric(), "_");
    let names: Vec<&str> = [&["t"], system.measured(), system.inputs].concat();
    let degree = match system.candidates {
        Candidates::Degree(degree) if problem.is_complete() => Some(degree),
        _ => None,
    };
    let about = json!({
        "name": problem.name(),
        "states": system.states,
        "measured": system.measured(),
        "inputs": system.inputs,
        "degree": degree,
        "library": library(problem)?.names(),
        "truth": &system.truth[system.scored()..],
        "rates": matches!(problem.corruption, Corruption::Rates(_)),
        "discrete": system.clock == Clock::Map,
        "complete": problem.is_complete(),
    });
    let all = folder.join(name);
    for seed in seeds {
        let runs = rows(problem, seed)?;
        let runs: Vec<&Rows> = runs.iter().collect();
        write_runs(&all.join(seed.to_string()), &names, &runs, &about)?;
    }
    Ok(all)
}

/// One CSV file for each trajectory, and `problem.json`.
pub(crate) fn write_runs(
    folder: &Path,
    names: &[&str],
    runs: &[&Rows],
    about: &Value,
) -> std::io::Result<()> {
    std::fs::create_dir_all(folder)?;
    for (k, run) in runs.iter().enumerate() {
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
    std::fs::write(folder.join("problem.json"), format!("{about}\n"))
}
