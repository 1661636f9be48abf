//! What is in a log.

use std::path::Path;

use serde::Serialize;
use touchdown_log::{Findings, Inspection, Log, Map, Survey};
use touchdown_trial::Trial;

use crate::plot::{Plot, Series, Style};
use crate::request::Result;

/// Size of a table's file above which its channels are not shown without a map, in bytes: it would be held in memory as a whole.
const LARGE: u64 = 64_000_000;

/// What a log holds.
#[derive(Debug, Serialize)]
pub(crate) struct Inspected {
    /// Columns of a table.
    table: Option<Inspection>,
    /// Topics of a log that has them.
    topics: Option<Survey>,
    /// The built-in map that fits.
    recommended_map: Option<&'static str>,
    /// A map to start from.
    suggested_map: Option<String>,
    /// What a person has to add to that map before it can be used.
    suggested_map_lacks: Option<&'static str>,
    /// Channels by the map, by the built-in map, or where columns are channels already.
    channels: Option<Inspection>,
    /// The channels over time.
    preview: Vec<Plot>,
    findings: Findings,
}

pub(crate) fn inspect(path: &Path, map: Option<&str>) -> Result<Inspected> {
    let map = map.map(parse_map).transpose()?;
    match Log::open(path)? {
        Some(log) => of_topics(&log, map.as_ref()),
        None => of_table(path, map.as_ref()),
    }
}

/// A map that a person has written.
pub(crate) fn parse_map(text: &str) -> Result<Map> {
    let map = Map::parse("the map", text)?;
    map.check_names()?;
    Ok(map)
}

fn of_topics(log: &Log, map: Option<&Map>) -> Result<Inspected> {
    let (survey, mut findings) = log.survey()?;
    let recommended = survey.recommended_map();
    let mut trial = None;
    if map.is_some() || recommended.is_some() {
        match log.trial(map) {
            Ok((read, applied)) => {
                // Both passes report the losses.
                let mut seen = std::mem::replace(&mut findings, applied).warnings;
                seen.retain(|warning| !findings.warnings.contains(warning));
                findings.warnings.splice(0..0, seen);
                trial = Some(read);
            }
            Err(error) if map.is_some() => return Err(error.into()),
            Err(error) => findings
                .warnings
                .push(format!("not usable without a map: {error}")),
        }
    } else {
        findings.warnings.extend(survey.lacks());
    }
    let built_in = recommended.and_then(Map::built_in_text);
    Ok(Inspected {
        table: None,
        recommended_map: recommended,
        suggested_map: Some(built_in.map_or_else(|| survey.suggested_map(), str::to_owned)),
        suggested_map_lacks: None,
        topics: Some(survey),
        channels: trial.as_ref().map(touchdown_log::inspect_trial),
        preview: trial.as_ref().map(preview).unwrap_or_default(),
        findings: with_loss(findings),
    })
}

fn of_table(path: &Path, map: Option<&Map>) -> Result<Inspected> {
    if let Some(map) = map {
        let (columns, trial, findings) = touchdown_log::inspect_mapped(path, map)?;
        return Ok(with_channels(columns, &trial, findings));
    }
    if std::fs::metadata(path).is_ok_and(|file| file.len() > LARGE) {
        let (columns, mut findings) = touchdown_log::inspect_file(path)?;
        findings.warnings.push(format!(
            "a table of more than {} MB: medians are those of a random sample; channels are shown with a map",
            LARGE / 1_000_000
        ));
        return Ok(table_alone(columns, findings));
    }
    let (table, mut findings) = touchdown_log::read_table(path)?;
    let columns = touchdown_log::inspect(&table, None);
    if let Ok(map) = Map::identity_for(&table) {
        match touchdown_log::apply(&table, &map) {
            Ok((trial, applied)) => {
                return Ok(with_channels(columns, &trial, findings.then(applied)));
            }
            Err(error) => findings
                .warnings
                .push(format!("not usable without a map: {error}")),
        }
    }
    Ok(table_alone(columns, findings))
}

fn with_channels(columns: Inspection, trial: &Trial, findings: Findings) -> Inspected {
    Inspected {
        channels: Some(touchdown_log::inspect_trial(trial)),
        preview: preview(trial),
        ..table_alone(columns, findings)
    }
}

fn table_alone(columns: Inspection, findings: Findings) -> Inspected {
    Inspected {
        suggested_map_lacks: columns.suggested_map.as_deref().and_then(lacks),
        suggested_map: columns.suggested_map.clone(),
        table: Some(columns),
        topics: None,
        recommended_map: None,
        channels: None,
        preview: Vec::new(),
        findings: with_loss(findings),
    }
}

/// A map without a time needs the time between two rows, or the choice between its lines in s and ms.
fn lacks(map: &str) -> Option<&'static str> {
    let lines = map.lines().filter(|line| line.starts_with("# time_s = "));
    let text = if lines.count() > 1 {
        "the time may be in s or ms. Of the lines that begin with `# time_s`, remove the # of the one that is true."
    } else {
        "no column looks like the time. In the line that begins with `# time_s`, remove the # and put the seconds from one row to \
         the next in the place of 0.01."
    };
    parse_map(map).is_err().then_some(text)
}

/// What was lost is a warning as well.
fn with_loss(mut findings: Findings) -> Findings {
    let loss = findings.loss();
    findings.warnings.extend(loss);
    findings
}

/// Every channel over time.
fn preview(trial: &Trial) -> Vec<Plot> {
    let plot = |(name, values): (&str, &[f64])| Plot {
        title: name.to_owned(),
        x: "Time (s)".to_string(),
        y: touchdown_trial::unit_of(name).symbol().to_string(),
        series: vec![Series::new(name, Style::Line, trial.time_s(), values)],
        ..Plot::default()
    };
    trial.channels().map(plot).collect()
}
