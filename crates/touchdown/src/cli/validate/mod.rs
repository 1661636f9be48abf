//! `touchdown validate`.

mod flights;

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::Serialize;
use touchdown::{Error, Result};
use touchdown_campaign::progress::Progress as _;
use touchdown_identify::flights::judge::IntervalFactors;
use touchdown_identify::rig::GroundTrial;
use touchdown_identify::scores::Errors;
use touchdown_identify::validation::{FreeRun, judge_ground, judge_thrust};
use touchdown_model::{Card, Kind, export};

use super::args::identify::ValidateArgs;
use super::context::Context;
use super::identify::flights::is_flight;
use super::identify::ground::{prepare, thrust_card};
use super::identify::{load, show};
use super::output;
use flights::Flights;
use touchdown_terminal::Done;

/// A card and where it lies.
pub(super) struct CardFile {
    path: PathBuf,
    card: Card,
}

/// The results of the command.
#[derive(Serialize)]
struct Results<'a> {
    /// A card on a log.
    results: &'a [Row],
    /// A card on all unseen logs.
    unseen: Vec<Pooled>,
    /// What a user should know.
    warnings: &'a [String],
}

/// One card on one log.
#[derive(Serialize)]
struct Row {
    card: String,
    form: String,
    log: String,
    /// Whether the card was fitted to this very log.
    seen: Option<bool>,
    unit: &'static str,
    /// Against the measurement.
    measured: Option<Errors>,
    /// Against the truth, where the log is of the virtual rig.
    truth: Option<Errors>,
    /// The measurement against the truth.
    noise_floor: Option<Errors>,
    /// The reason why there are no errors.
    error: Option<String>,
    /// Scale and height offset of each armed interval of a flight.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    armed_intervals: Vec<IntervalFactors>,
}

/// One card on all unseen logs.
#[derive(Serialize)]
struct Pooled {
    card: String,
    form: String,
    logs: usize,
    unit: &'static str,
    measured: Option<Errors>,
    truth: Option<Errors>,
    noise_floor: Option<Errors>,
}

pub(crate) fn run(context: &Context, args: &ValidateArgs) -> Result<Done> {
    let (cards, logs) = split(args)?;
    output::must_not_be_a_file(args.out.as_deref())?;
    let ground = cards.iter().find(|c| c.card.kind == Kind::GroundEffect);
    let free_air = match (&args.thrust, ground) {
        (Some(path), _) => Some(thrust_card(path)?),
        (None, Some(card)) => {
            return Err(Error::Arguments(format!(
                "{} is a ground-effect card: expected --thrust with the card of the free-air thrust, found none",
                card.path.display()
            )));
        }
        (None, None) => None,
    };
    let map = load::map(args.map.as_deref())?;
    let logs = load::all_logs(context, &logs, map.as_ref())?;
    let mut warnings: Vec<String> = logs
        .iter()
        .flat_map(|l| {
            let name = l.path.display().to_string();
            l.warnings()
                .into_iter()
                .map(move |w| format!("{name}: {w}"))
        })
        .collect();
    let checked = cards.iter().map(|c| (c, export::check(&c.card)));
    warnings.extend(checked.filter_map(|(c, check)| {
        let error = check.err()?;
        Some(format!("{}: does not fly: {error}", c.path.display()))
    }));
    let flights = Flights::of(args, map.as_ref());
    let mut prepared: Vec<Option<GroundTrial>> = Vec::new();
    for log in &logs {
        prepared.push(match (&free_air, ground) {
            (Some(card), Some(_)) if !is_flight(log) => {
                let (mut trials, gaps) = prepare(std::slice::from_ref(log), card)?;
                warnings.extend(gaps);
                trials.pop()
            }
            _ => None,
        });
    }
    context.stage("free runs", (cards.len() * logs.len()) as u64);
    let pairs: Vec<(usize, usize)> = (0..cards.len())
        .flat_map(|c| (0..logs.len()).map(move |l| (c, l)))
        .collect();
    let mut judged: Vec<Result<FreeRun>> = pairs
        .par_iter()
        .map(|&(c, l)| {
            let (card, trial) = (&cards[c].card, &logs[l].trial);
            let judged = match (card.kind, &prepared[l]) {
                _ if is_flight(&logs[l]) => flights.judge(card, free_air.as_ref(), trial),
                (Kind::GroundEffect, Some(prepared)) => Ok(judge_ground(card, prepared, trial)?),
                _ => Ok(judge_thrust(card, trial)?),
            };
            context.step();
            judged
        })
        .collect();
    if judged.iter().all(Result::is_err) {
        // There is at least one card and one log.
        return judged.swap_remove(0).map(|_| Done::Whole);
    }
    let found = FreeRuns {
        cards,
        logs,
        pairs,
        judged,
    };
    finish(context, args, &found, warnings)
}

/// All free runs.
struct FreeRuns {
    cards: Vec<CardFile>,
    logs: Vec<load::Log>,
    /// Card and log of every run, by their places in the lists.
    pairs: Vec<(usize, usize)>,
    judged: Vec<Result<FreeRun>>,
}

fn finish(
    context: &Context,
    args: &ValidateArgs,
    found: &FreeRuns,
    mut warnings: Vec<String>,
) -> Result<Done> {
    let (cards, logs) = (&found.cards, &found.logs);
    let mut rows = Vec::new();
    for (&(c, l), judged) in found.pairs.iter().zip(&found.judged) {
        let (given, log) = (&cards[c], &logs[l]);
        let inputs = &given.card.provenance.inputs;
        // A card without input files does not state its training logs.
        let seen = (!inputs.is_empty()).then(|| inputs.iter().any(|i| i.sha256 == log.sha256()));
        let (card, path) = (given.path.display(), log.path.display());
        if seen == Some(true) {
            warnings.push(format!(
                "{path} is among the logs that {card} was fitted to: its errors there are not those on unseen data; use other logs"
            ));
        }
        let ok = judged.as_ref().ok();
        match judged {
            Ok(j) => warnings.extend(j.warnings.iter().map(|w| format!("{card} on {path}: {w}"))),
            Err(e) => warnings.push(format!("{card} on {path}: not judged: {e}")),
        }
        rows.push(Row {
            card: card.to_string(),
            form: show::form(&given.card),
            log: path.to_string(),
            seen,
            unit: "N",
            measured: ok.map(|j| j.measured),
            truth: ok.and_then(|j| j.truth),
            noise_floor: ok.and_then(|j| j.noise_floor),
            error: judged.as_ref().err().map(ToString::to_string),
            armed_intervals: ok.map_or_else(Vec::new, |j| j.intervals.clone()),
        });
    }
    for warning in &warnings {
        context.warn(warning);
    }
    let results = Results {
        unseen: pool(cards, &rows),
        results: &rows,
        warnings: &warnings,
    };
    let (header, table) = table(&results);
    if let Some(folder) = &args.out {
        write(context, args, folder, &results, found, (&header, &table))?;
    }
    context.finish();
    context.object(&results);
    context.say(&show::text_table(&header, &table));
    let factors = flights::factors(&results);
    if !factors.is_empty() {
        context.say(&show::text_table(
            &flights::HEADER.map(String::from),
            &factors,
        ));
    }
    let loss = logs.iter().any(|l| l.findings.is_lossy()) || rows.iter().any(|r| r.error.is_some());
    Ok(if loss { Done::WithLoss } else { Done::Whole })
}

/// Cards end in `.toml`; all other files are logs.
fn split(args: &ValidateArgs) -> Result<(Vec<CardFile>, Vec<PathBuf>)> {
    let is_card = |p: &&PathBuf| {
        p.extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("toml"))
    };
    let cards: Vec<CardFile> = args
        .files
        .iter()
        .filter(is_card)
        .map(|path| {
            Ok(CardFile {
                path: path.clone(),
                card: Card::read(path)?,
            })
        })
        .collect::<Result<_>>()?;
    let logs: Vec<PathBuf> = args.files.iter().filter(|p| !is_card(p)).cloned().collect();
    for (what, none) in [
        ("a model card (.toml)", cards.is_empty()),
        ("a log", logs.is_empty()),
    ] {
        if none {
            return Err(Error::Arguments(format!(
                "expected {what} among the files, found none"
            )));
        }
    }
    Ok((cards, logs))
}

/// The errors of every card over its unseen logs; `rows` contains a card's logs side by side.
fn pool(cards: &[CardFile], rows: &[Row]) -> Vec<Pooled> {
    let logs = rows.len() / cards.len().max(1);
    cards
        .iter()
        .zip(rows.chunks(logs.max(1)))
        .map(|(given, of_card)| {
            let unseen: Vec<&Row> = of_card
                .iter()
                .filter(|r| r.seen != Some(true) && r.error.is_none())
                .collect();
            let pool = |f: fn(&Row) -> Option<Errors>| -> Option<Errors> {
                // Where the truth is known of some logs only, there is no pooled figure.
                let all: Option<Vec<Errors>> = unseen.iter().map(|r| f(r)).collect();
                Errors::pool(&all?)
            };
            Pooled {
                card: given.path.display().to_string(),
                form: show::form(&given.card),
                logs: unseen.len(),
                unit: "N",
                measured: pool(|r| r.measured),
                truth: pool(|r| r.truth),
                noise_floor: pool(|r| r.noise_floor),
            }
        })
        .collect()
}

/// The names of the cards and of the logs in tables.
fn names_in_tables(results: &Results<'_>) -> [impl Fn(&str) -> String + use<>; 2] {
    let of = |path: fn(&Row) -> &String| {
        let paths = results.results.iter().map(path);
        load::names_of(paths.cloned().collect())
    };
    [of(|r| &r.card), of(|r| &r.log)]
}

/// The table of errors, in newtons: a row a card and log, then a row a card over all unseen logs.
fn table(results: &Results<'_>) -> (Vec<String>, Vec<Vec<String>>) {
    let truth = results.results.iter().any(|r| r.truth.is_some());
    let mut header: Vec<String> = ["card", "form", "log", "seen", "MAE N", "RMSE N", "worst N"]
        .map(String::from)
        .into();
    if truth {
        header.extend(["MAE to truth N", "worst to truth N", "noise MAE N"].map(String::from));
    }
    let [card, log] = names_in_tables(results);
    let figures = |m: Option<Errors>, t: Option<Errors>, n: Option<Errors>| {
        let show = |e: Option<f64>| e.map_or_else(|| "–".to_string(), show::digits);
        let mut out = vec![
            show(m.map(|e| e.mae)),
            show(m.map(|e| e.rmse)),
            show(m.map(|e| e.worst)),
        ];
        if truth {
            out.extend([
                show(t.map(|e| e.mae)),
                show(t.map(|e| e.worst)),
                show(n.map(|e| e.mae)),
            ]);
        }
        out
    };
    let mut rows: Vec<Vec<String>> = Vec::new();
    for r in results.results {
        let seen = match r.seen {
            Some(true) => "yes",
            Some(false) => "no",
            None => "unknown",
        }
        .to_string();
        let mut row = vec![card(&r.card), r.form.clone(), log(&r.log), seen];
        row.extend(figures(r.measured, r.truth, r.noise_floor));
        rows.push(row);
    }
    for p in results.unseen.iter().filter(|p| p.logs > 1) {
        let all = format!("all {} unseen", p.logs);
        let mut row = vec![card(&p.card), p.form.clone(), all, "no".to_string()];
        row.extend(figures(p.measured, p.truth, p.noise_floor));
        rows.push(row);
    }
    (header, rows)
}

fn write(
    context: &Context,
    args: &ValidateArgs,
    folder: &Path,
    results: &Results<'_>,
    found: &FreeRuns,
    (header, table): (&[String], &[Vec<String>]),
) -> Result<()> {
    let FreeRuns {
        cards,
        logs,
        pairs,
        judged,
    } = found;
    context.stage("drawing", logs.len() as u64);
    let names = load::names(&logs.iter().map(|l| l.path.clone()).collect::<Vec<_>>());
    let labels = load::names(&cards.iter().map(|c| c.path.clone()).collect::<Vec<_>>());
    let drawn: Vec<touchdown_pages::validate::Drawn<'_>> = pairs
        .iter()
        .zip(judged)
        .filter_map(|(&(c, l), judged)| {
            let judged = judged.as_ref().ok()?;
            Some(touchdown_pages::validate::Drawn {
                card: &labels[c],
                kind: cards[c].card.kind,
                form: cards[c].card.form,
                log: &names[l],
                time_s: &judged.time_s,
                measured_n: &judged.measured_n,
                truth_n: judged.truth_n.as_deref(),
                predicted_n: &judged.predicted_n,
            })
        })
        .collect();
    let figures = touchdown_pages::validate::figures(&drawn, &names, context)?;
    let command = command(args, folder);
    let pooled = results.unseen.iter().filter(|p| p.logs > 1).count();
    let (rows, pooled_rows) = table.split_at(table.len() - pooled);
    let [card, _] = names_in_tables(results);
    let of_cards = results.unseen.iter().zip(cards);
    let errors: Vec<touchdown_pages::validate::UnseenError> = of_cards
        .map(|(pooled, given)| touchdown_pages::validate::UnseenError {
            card: card(&given.path.display().to_string()),
            kind: given.card.kind,
            logs: pooled.logs,
            mae_n: pooled.measured.map(|e| e.mae),
            noise_mae_n: pooled.noise_floor.map(|e| e.mae),
        })
        .collect();
    let overview = touchdown_pages::validate::Overview {
        command: &command,
        header,
        rows,
        pooled_rows,
        cards: &errors,
        warnings: results.warnings,
        factors_header: &flights::HEADER,
        factors: &flights::factors(results),
    };
    let report = touchdown_pages::validate::report(&overview, &figures)?;
    output::results_folder(context, folder)?;
    output::write(
        &folder.join("summary.csv"),
        show::csv(header, table).as_bytes(),
    )?;
    touchdown_pages::page::write(folder, &figures, &report)?;
    output::results(folder, results)
}

/// The command that judges the same again.
fn command(args: &ValidateArgs, folder: &Path) -> String {
    let mut command = "touchdown validate".to_string();
    let mut add = |option: &str, path: &Path| {
        command.push_str(&format!(
            " {option}{}",
            load::word(&path.display().to_string())
        ));
    };
    for path in &args.files {
        add("", path);
    }
    for (option, path) in [("--map ", &args.map), ("--thrust ", &args.thrust)] {
        if let Some(path) = path {
            add(option, path);
        }
    }
    for (option, value) in [
        ("--scale ", args.scale),
        ("--height-offset ", args.height_offset),
    ] {
        if let Some(value) = value {
            add(option, Path::new(&value.to_string()));
        }
    }
    add("--out ", folder);
    command
}
