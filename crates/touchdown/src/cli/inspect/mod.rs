//! `touchdown inspect`.

mod columns;
mod topics;

use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde::Serialize;
use touchdown::Result;
use touchdown_campaign::progress::Progress as _;
use touchdown_log::{Findings, Inspection, Log, Map, Survey, Table};
use touchdown_sim::deck::character::SeriesCharacter;
use touchdown_sim::deck::series::MotionSeries;
use touchdown_sim::deck::slow::LONGEST_PERIOD_S;
use touchdown_trial::Trial;

use super::args::InspectArgs;
use super::context::Context;
use super::identify::{load, show};
use super::output;
use touchdown_terminal::Done;

/// Memory above which channels are made only if they are asked for, in bytes; and the size of a
/// table's file.
const LARGE: u64 = 64_000_000;

/// What one log holds.
struct InspectedLog {
    path: PathBuf,
    content: Content,
    mapped: Option<(Trial, Inspection)>,
    /// Whether that is by a map of the user's.
    by_map: bool,
    findings: Findings,
}

/// What the file holds.
enum Content {
    Table {
        /// Where it is held in memory.
        table: Option<Table>,
        columns: Box<Inspection>,
    },
    Topics(Survey),
}

/// What is printed of a log.
#[derive(Serialize)]
struct LogSummary<'a> {
    log: String,
    /// What is in the file.
    #[serde(flatten)]
    content: ContentSummary<'a>,
    /// Channels as the map makes them, or the columns where they are channels already; null where neither is, or
    /// where the table is too large to be held.
    channels: Option<&'a Inspection>,
    findings: &'a Findings,
}

#[derive(Serialize)]
#[serde(untagged)]
enum ContentSummary<'a> {
    /// Columns as they are in the file.
    Table(&'a Inspection),
    /// Topics as they are in the file.
    Topics {
        #[serde(flatten)]
        survey: &'a Survey,
        /// The built-in map that fits; null where none does.
        recommended_map: Option<&'static str>,
        /// The text of a map to start from.
        suggested_map: String,
    },
}

/// A log that cannot be read.
#[derive(Serialize)]
struct UnreadableLog {
    log: String,
    error: String,
}

#[derive(Serialize)]
#[serde(untagged)]
enum Outcome<'a> {
    Summary(Box<LogSummary<'a>>),
    Unreadable(UnreadableLog),
}

#[derive(Serialize)]
struct Results<'a> {
    logs: &'a [Outcome<'a>],
}

pub(crate) fn run(context: &Context, args: &InspectArgs) -> Result<Done> {
    output::must_not_be_a_file(args.out.as_deref())?;
    let map = load::map(args.map.as_deref())?;
    context.stage("reading", args.logs.len() as u64);
    let mut seen: Vec<Result<InspectedLog>> = args
        .logs
        .par_iter()
        .map(|path| {
            let seen = look(path, map.as_ref());
            context.step();
            seen
        })
        .collect();
    // A map that does not fit a log is wrong; and so is a command none of whose logs can be read.
    let wrong = seen
        .iter()
        .position(|s| s.as_ref().is_err_and(|e| e.exit_status() == 2));
    let none = seen.iter().all(Result::is_err).then_some(0);
    if let Some(at) = wrong.or(none) {
        return seen.swap_remove(at).map(|_| Done::Whole);
    }
    let outcomes: Vec<Outcome<'_>> = args
        .logs
        .iter()
        .zip(&seen)
        .map(|(path, seen)| match seen {
            Ok(seen) => Outcome::Summary(Box::new(LogSummary {
                log: path.display().to_string(),
                content: match &seen.content {
                    Content::Table { columns, .. } => ContentSummary::Table(columns),
                    Content::Topics(survey) => ContentSummary::Topics {
                        survey,
                        recommended_map: survey.recommended_map(),
                        suggested_map: topics::map_text(survey),
                    },
                },
                channels: seen.mapped.as_ref().map(|(_, i)| i),
                findings: &seen.findings,
            })),
            Err(error) => Outcome::Unreadable(UnreadableLog {
                log: path.display().to_string(),
                error: error.to_string(),
            }),
        })
        .collect();
    let results = Results { logs: &outcomes };
    if let Some(folder) = &args.out {
        write(context, args, folder, &results, &seen)?;
    }
    context.finish();
    context.object(&results);
    let mut loss = false;
    for (path, seen) in args.logs.iter().zip(&seen) {
        match seen {
            Ok(seen) => {
                loss |= seen.findings.is_lossy();
                for warning in warnings(seen) {
                    context.warn(&format!("{}: {warning}", path.display()));
                }
                context.say(&text(seen));
            }
            Err(error) => {
                loss = true;
                context.warn(&format!("not read: {error}"));
            }
        }
    }
    Ok(if loss { Done::WithLoss } else { Done::Whole })
}

fn look(path: &Path, map: Option<&Map>) -> Result<InspectedLog> {
    if let Some(log) = Log::open(path)? {
        return look_at_topics(path, &log, map);
    }
    if let Some(map) = map {
        return look_by_map(path, map);
    }
    if std::fs::metadata(path).is_ok_and(|file| file.len() > LARGE) {
        return look_at_large(path);
    }
    let (table, mut findings) = touchdown_log::read_table(path)?;
    let mut columns = touchdown_log::inspect(&table, None);
    let applied = match Map::identity_for(&table).map(|map| touchdown_log::apply(&table, &map)) {
        Ok(Ok(applied)) => Some(applied),
        // Columns can be shown that make no trial.
        Ok(Err(e)) => {
            columns
                .warnings
                .push(format!("not usable without a map: {e}"));
            None
        }
        Err(_) => None,
    };
    let mapped = applied.map(|(trial, applied)| {
        findings = std::mem::take(&mut findings).then(applied);
        let channels = touchdown_log::inspect_trial(&trial);
        (trial, channels)
    });
    Ok(InspectedLog {
        path: path.to_owned(),
        content: Content::Table {
            table: Some(table),
            columns: Box::new(columns),
        },
        mapped,
        by_map: false,
        findings,
    })
}

/// What a table holds, and its channels by a map.
fn look_by_map(path: &Path, map: &Map) -> Result<InspectedLog> {
    let (columns, trial, findings) = touchdown_log::inspect_mapped(path, map)?;
    let channels = touchdown_log::inspect_trial(&trial);
    Ok(InspectedLog {
        path: path.to_owned(),
        content: Content::Table {
            table: None,
            columns: Box::new(columns),
        },
        mapped: Some((trial, channels)),
        by_map: true,
        findings,
    })
}

/// What a table holds that is not held in memory as a whole.
fn look_at_large(path: &Path) -> Result<InspectedLog> {
    let (columns, mut findings) = touchdown_log::inspect_file(path)?;
    findings.warnings.push(format!(
        "a table of more than {} MB: medians are those of a random sample; use --map for channels and plots",
        LARGE / 1_000_000
    ));
    Ok(InspectedLog {
        path: path.to_owned(),
        content: Content::Table {
            table: None,
            columns: Box::new(columns),
        },
        mapped: None,
        by_map: false,
        findings,
    })
}

fn look_at_topics(path: &Path, log: &Log, map: Option<&Map>) -> Result<InspectedLog> {
    let (survey, mut findings) = log.survey()?;
    let mut mapped = None;
    if map.is_none() {
        findings.warnings.extend(survey.lacks());
    }
    let built_in = Map::built_in(&survey);
    let large = built_in
        .filter(|_| map.is_none())
        .and_then(|map| too_large(&survey, map));
    if let Some(text) = large {
        findings.warnings.push(text);
    } else if map.is_some() || built_in.is_some() {
        // A pass of its own: only now is it known that the columns fit into memory.
        match log.trial(map) {
            Ok((trial, applied)) => {
                // Both passes report the losses.
                let mut told = std::mem::replace(&mut findings, applied).warnings;
                told.retain(|warning| !findings.warnings.contains(warning));
                findings.warnings.splice(0..0, told);
                let channels = touchdown_log::inspect_trial(&trial);
                mapped = Some((trial, channels));
            }
            Err(error) if map.is_some() => return Err(error.into()),
            Err(error) => findings
                .warnings
                .push(format!("not usable without a map: {error}")),
        }
    }
    Ok(InspectedLog {
        path: path.to_owned(),
        content: Content::Topics(survey),
        mapped,
        by_map: map.is_some(),
        findings,
    })
}

/// Why the channels of a log are not made only to be shown.
fn too_large(survey: &Survey, map: &Map) -> Option<String> {
    let (rows, channels) = (survey.rows_by(map), map.channels().count());
    let bytes = (size_of::<f64>() * rows * channels) as u64;
    (bytes > LARGE).then(|| {
        format!(
            "{rows} rows of up to {channels} channels may take {} MB of memory: channels are shown with --map {} only",
            bytes / 1_000_000,
            survey.recommended_map().unwrap_or_default()
        )
    })
}

fn warnings(seen: &InspectedLog) -> Vec<String> {
    let mut all = match &seen.content {
        Content::Table { columns, .. } => columns.warnings.clone(),
        Content::Topics(_) => Vec::new(),
    };
    if let Some((_, channels)) = &seen.mapped {
        all.extend(channels.warnings.iter().cloned());
    }
    all.extend(seen.findings.warnings.iter().cloned());
    all.extend(seen.findings.loss());
    all
}

/// A log as text: how much it is, then its topics or columns, its channels, or a map to start
/// from.
fn text(seen: &InspectedLog) -> String {
    let path = seen.path.display();
    let mut out = match &seen.content {
        Content::Table { columns, .. } => {
            format!("{path}: {} rows{}", columns.rows, columns::time(columns))
        }
        Content::Topics(survey) => format!("{path}: {}", topics::about(survey)),
    };
    if let Content::Topics(survey) = &seen.content {
        let (header, rows) = topics::table(survey);
        out.push_str(&format!("\n{}\n", show::text_table(&header, &rows)));
    }
    if let Some((_, channels)) = &seen.mapped {
        out.push_str(&format!(
            "\n{} rows in use{}",
            channels.rows,
            columns::time(channels)
        ));
    }
    if let Some((title, shown)) = shown(seen) {
        let (header, rows) = columns::table(title, shown);
        out.push('\n');
        out.push_str(&show::text_table(&header, &rows));
    }
    if let Some(motion) = deck_motion(seen) {
        out.push_str(&format!("\n\nMotion of the deck: {motion}"));
    }
    if let Some(map) = suggested_map(seen) {
        out.push_str(&format!("\n\nA map to start from:\n{map}"));
    }
    out.push('\n');
    out
}

/// What a measured motion of the deck is, by `deck_height_m`, without slow heave.
fn deck_motion(seen: &InspectedLog) -> Option<SeriesCharacter> {
    let (trial, _) = seen.mapped.as_ref()?;
    let heave_m = trial.channel("deck_height_m")?;
    let series = MotionSeries::of_heave(trial.time_s(), heave_m).ok()?;
    Some(series.without_slow_heave(LONGEST_PERIOD_S).0.character())
}

/// The channels, or else the columns of a table.
fn shown(seen: &InspectedLog) -> Option<(&'static str, &Inspection)> {
    match (&seen.mapped, &seen.content) {
        (Some((_, channels)), _) => Some(("channels", channels)),
        (None, Content::Table { columns, .. }) => Some(("columns", columns.as_ref())),
        (None, Content::Topics(_)) => None,
    }
}

/// A map to start from, where none was used.
fn suggested_map(seen: &InspectedLog) -> Option<String> {
    match (&seen.mapped, &seen.content) {
        _ if seen.by_map => None,
        (_, Content::Table { columns, .. }) => columns.suggested_map.clone(),
        (Some(_), Content::Topics(_)) => None,
        (None, Content::Topics(survey)) => Some(topics::map_text(survey)),
    }
}

fn write(
    context: &Context,
    args: &InspectArgs,
    folder: &Path,
    results: &Results<'_>,
    seen: &[Result<InspectedLog>],
) -> Result<()> {
    context.stage("drawing", seen.len() as u64);
    let names = load::names(&args.logs);
    let mut sections = Vec::new();
    for (index, (name, seen)) in names.iter().zip(seen).enumerate() {
        let Ok(seen) = seen else { continue };
        let (header, rows) = match shown(seen) {
            Some((title, shown)) => columns::table(title.trim_end_matches('s'), shown),
            None => Default::default(),
        };
        let figures = match (&seen.mapped, &seen.content) {
            (Some((trial, _)), _) => touchdown_pages::inspect::of_trial(index, name, trial),
            (
                None,
                Content::Table {
                    table: Some(table),
                    columns,
                },
            ) => touchdown_pages::inspect::of_table(index, name, table, columns.time.as_ref()),
            (None, _) => Vec::new(),
        };
        sections.push(touchdown_pages::inspect::Section {
            title: seen.path.display().to_string(),
            about: text(seen).lines().next().unwrap_or_default().to_string(),
            topics: match &seen.content {
                Content::Table { .. } => None,
                Content::Topics(survey) => Some(topics::table(survey)),
            },
            header,
            rows,
            warnings: warnings(seen),
            suggested_map: suggested_map(seen),
            figures,
        });
        context.step();
    }
    let mut command = "touchdown inspect".to_string();
    for path in &args.logs {
        command.push_str(&format!(" {}", load::word(&path.display().to_string())));
    }
    if let Some(map) = &args.map {
        command.push_str(&format!(
            " --map {}",
            load::word(&map.display().to_string())
        ));
    }
    command.push_str(&format!(
        " --out {}",
        load::word(&folder.display().to_string())
    ));
    let report = touchdown_pages::inspect::report(&command, &sections)?;
    output::results_folder(context, folder)?;
    touchdown_pages::page::write(folder, sections.iter().flat_map(|s| &s.figures), &report)?;
    output::results(folder, results)
}
