//! Makes a trial of a log.

use super::joined::Joined;
use super::log::{Gathered, Log};
use super::survey::Survey;
use crate::map::apply::apply_resolved;
use crate::map::evaluate::is_known;
use crate::map::resolve::Resolved;
use crate::map::{Map, Rule};
use crate::{Findings, LogError, limits};
use sindy_expr::nearest;
use std::collections::{BTreeMap, BTreeSet};
use touchdown_trial::{TIME_CHANNEL, Trial};

/// Memory of a trial above which a warning states it, in bytes: an hour of ten channels at 350 Hz.
const LARGE: usize = 100_000_000;
/// Largest number of names in an error, so that it fits on a screen.
const LISTED: usize = 40;

impl Log {
    /// Makes the trial of the log, by the map or by the built-in one that fits: one row for each
    /// message of the map's clock.
    ///
    /// Only the columns that the map names are held in memory, and the trial.
    ///
    /// # Errors
    /// [`LogError::NeedsMap`] where there is no map, [`LogError::UnknownColumn`] where there is no
    /// such topic or field, [`LogError::MapValue`] for a clock that is none, and those of
    /// [`survey`](Self::survey) and [`apply`](crate::apply).
    pub fn trial(&self, map: Option<&Map>) -> Result<(Trial, Findings), LogError> {
        let maps: Vec<&Map> = match map {
            Some(map) => vec![map],
            None => Map::built_in_for(self.format()).collect(),
        };
        let names: BTreeSet<&str> = maps.iter().flat_map(|map| map.names()).collect();
        let clocks = maps.iter().filter_map(|map| map.clocks());
        let mut gathered = self.gather(
            names.into_iter(),
            clocks.flat_map(|(_, clocks)| clocks.iter().map(String::as_str)),
        )?;
        let (mut notes, mut mapped_by) = (Vec::new(), None);
        let map = match map {
            Some(map) => map,
            None => {
                let Some(found) = Map::built_in(&gathered.survey) else {
                    let (survey, _) = self.survey()?;
                    let topics = survey.topics.iter().map(|topic| topic.key.clone());
                    return Err(LogError::NeedsMap {
                        path: self.path().to_owned(),
                        columns: topics.take(LISTED).collect(),
                        suggested: survey.suggested_map(),
                    });
                };
                mapped_by = Some(format!("mapped by {}", found.path()));
                found
            }
        };
        let survey = &gathered.survey;
        let resolved = survey.resolved(map);
        for rule in resolved.map.channels.iter().chain(&resolved.map.keep) {
            let names = rule.expr.variables();
            if let Some(name) = names.into_iter().find(|name| !survey.knows(map, name)) {
                return Err(no_field(survey, rule, name));
            }
        }
        let mut told = Findings::default();
        let clock = clock(&resolved.map, survey, &mut told)?;
        if !gathered.series.contains_key(&clock) {
            // The map uses only stamps and names no clock.
            gathered = self.gather(std::iter::empty(), std::iter::once(clock.as_str()))?;
        }
        let Gathered {
            survey,
            series,
            findings,
            sha256,
        } = gathered;
        let rows = series.get(&clock).map_or(0, |series| series.time_s.len());
        // Twice, because the channels are picked from what was evaluated.
        limits::values(rows, 2 * resolved.map.channels.len(), self.bytes()?)
            .map_err(|excess| LogError::excess(self.path(), excess))?;
        let mut findings = findings.then(told);
        let file = (self.path(), sha256.as_str());
        let mut rows = Joined::new(file, &survey, &resolved.map, &clock, series, &mut findings);
        let (trial, applied) = apply_resolved(&mut rows, &resolved.map, &map.optional)?;
        drop(rows);
        let mut findings = findings.then(applied);
        notes.extend(resolved.warnings());
        let bytes = size_of::<f64>() * trial.len() * (1 + trial.channels().len());
        if bytes > LARGE {
            notes.push(format!(
                "{} rows of {} channels take {} MB of memory",
                trial.len(),
                trial.channels().len(),
                bytes / 1_000_000
            ));
        }
        findings.notes.extend(mapped_by);
        findings.warnings.splice(0..0, notes);
        Ok((trial, findings))
    }
}

impl Survey {
    /// Whether the log has a value of this name for expressions.
    pub(super) fn knows(&self, map: &Map, name: &str) -> bool {
        is_known(map, name) || name == TIME_CHANNEL || self.resolve(name).is_some()
    }

    /// The map with only those expressions that the log supports.
    pub(super) fn resolved(&self, map: &Map) -> Resolved {
        map.resolve(&|name| self.knows(map, name), &|name| self.parameter(name))
    }
}

/// The topic whose messages are the rows: the first clock of the map that the log has. If the map
/// names no clock, it is the used topic with most messages.
fn clock(map: &Map, survey: &Survey, findings: &mut Findings) -> Result<String, LogError> {
    let Some((place, clocks)) = map.clocks() else {
        let names = map.names().into_iter();
        let used: BTreeMap<String, String> =
            names.filter_map(|name| survey.resolve(name)).collect();
        let most = survey
            .topics
            .iter()
            .filter(|topic| used.is_empty() || used.contains_key(&topic.key))
            .max_by_key(|topic| topic.messages);
        let key = most.map(|topic| topic.key.clone()).unwrap_or_default();
        let text = format!("the map names no clock; the rows are the messages of {key}");
        findings.warnings.push(text);
        return Ok(key);
    };
    let found = clocks.iter().find_map(|name| survey.topic_like(name));
    found.map(|topic| topic.key.clone()).ok_or_else(|| {
        let keys: Vec<&str> = survey.topics.iter().map(|t| t.key.as_str()).collect();
        let near = clocks
            .first()
            .and_then(|name| nearest(name, keys.iter().copied()));
        LogError::MapValue {
            at: Box::new(place.clone()),
            expected: match near {
                Some(near) => format!("a topic of {} (did you mean {near:?}?)", survey.path),
                None => format!("a topic of {}, one of {}", survey.path, keys.join(", ")),
            },
            found: clocks.join(", "),
        }
    })
}

/// The error of a missing topic, field or parameter.
pub(super) fn no_field(survey: &Survey, rule: &Rule, name: &str) -> LogError {
    let topic = name.match_indices('.').rev();
    let mut topics = topic.filter_map(|(dot, _)| survey.topic_like(&name[..dot]));
    let available: Vec<String> = if name.starts_with("param.") {
        let names = survey.parameters.keys();
        names
            .map(|parameter| format!("param.{parameter}"))
            .collect()
    } else if let Some(topic) = topics.next() {
        let fields = topic.fields.iter();
        fields
            .map(|field| format!("{}.{}", topic.key, field.name))
            .collect()
    } else {
        survey
            .topics
            .iter()
            .map(|topic| topic.key.clone())
            .collect()
    };
    LogError::UnknownColumn {
        at: Box::new(rule.place.clone()),
        table: survey.path.clone(),
        found: name.to_owned(),
        nearest: nearest(name, available.iter().map(String::as_str)).map(str::to_owned),
        available: available.into_iter().take(LISTED).collect(),
    }
}
