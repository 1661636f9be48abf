//! From a log to a trial.

use super::log::Log;
use super::survey::Survey;
use crate::apply::{apply_resolved, is_known};
use crate::map::{Map, Rule};
use crate::suggest::nearest;
use crate::{Findings, LogError};
use touchdown_trial::{TIME_CHANNEL, Trial, TrialError};

/// Names that an error lists at most.
const LISTED: usize = 40;

impl Log {
    /// Makes the trial of the log, by the map or by the built-in one that fits.
    ///
    /// # Errors
    /// [`LogError::NeedsMap`] where there is neither, and those of [`survey`](Self::survey),
    /// [`table`](Self::table) and [`apply`](crate::apply).
    pub fn trial(&self, map: Option<&Map>) -> Result<(Trial, Findings), LogError> {
        let (survey, _) = self.outline()?;
        let mut notes = Vec::new();
        let built_in;
        let map = match map {
            Some(map) => map,
            None => {
                let Some(found) = Map::built_in(&survey) else {
                    let (survey, _) = self.survey()?;
                    let topics = survey.topics.iter().map(|topic| topic.key.clone());
                    return Err(LogError::NeedsMap {
                        path: self.path().to_owned(),
                        columns: topics.take(LISTED).collect(),
                        suggested: survey.suggested_map(),
                    });
                };
                built_in = found;
                notes.push(format!("mapped by {}", built_in.path()));
                &built_in
            }
        };
        let known = |name: &str| {
            is_known(map, name) || name == TIME_CHANNEL || survey.resolve(name).is_some()
        };
        let resolved = map.resolve(&known, &|name| survey.parameter(name));
        let rules = resolved.map.defines.iter().chain(&resolved.map.channels);
        for rule in rules.chain(&resolved.map.keep) {
            let own = |name: &str| resolved.map.defines.iter().any(|rule| rule.channel == name);
            if let Some(name) = rule
                .expr
                .variables()
                .into_iter()
                .find(|n| !known(n) && !own(n))
            {
                return Err(no_field(&survey, rule, name));
            }
        }
        let (table, read) = self.table(&resolved.map, &survey)?;
        let (trial, applied) = apply_resolved(&table, &resolved.map)?;
        let mut findings = read.then(applied);
        notes.extend(resolved.warnings());
        let empty = |values: &[f64]| values.iter().all(|value| value.is_nan());
        let (trial, empty) = without(trial, |name, values| {
            map.optional.iter().any(|known| known == name) && empty(values)
        })
        .map_err(|source| LogError::Trial {
            path: self.path().to_owned(),
            source,
        })?;
        notes.extend(
            empty
                .iter()
                .map(|name| format!("{name}: left out, for it has no value")),
        );
        findings.warnings.splice(0..0, notes);
        Ok((trial, findings))
    }
}

/// The trial without some channels, and their names.
fn without(
    trial: Trial,
    drop: impl Fn(&str, &[f64]) -> bool,
) -> Result<(Trial, Vec<String>), TrialError> {
    if !trial.channels().any(|(name, values)| drop(name, values)) {
        return Ok((trial, Vec::new()));
    }
    let mut dropped = Vec::new();
    let mut left = Trial::new(trial.name(), trial.time_s().to_vec())?;
    for (name, values) in trial.channels() {
        if drop(name, values) {
            dropped.push(name.to_owned());
        } else {
            left.insert(name, values.to_vec())?;
        }
    }
    Ok((left.with_provenance(trial.provenance().clone()), dropped))
}

/// There is no such topic, or no such field in it, or no such parameter.
fn no_field(survey: &Survey, rule: &Rule, name: &str) -> LogError {
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
        nearest: nearest(name, available.iter().map(String::as_str)),
        available: available.into_iter().take(LISTED).collect(),
    }
}
