//! Columns of several topics, interpolated at the stamps of one of them.

use super::extract::{Series, Values};
use super::join::{self, Stamps};
use super::resets;
use super::survey::Survey;
use super::trial::no_field;
use crate::map::rows::Rows;
use crate::map::{Join, Map, Rule};
use crate::{Findings, LogError};
use sindy_expr::nearest;
use std::collections::BTreeMap;
use std::rc::Rc;
use touchdown_trial::TIME_CHANNEL;

/// One row for each message of a clock.
pub(super) struct Joined<'a> {
    path: &'a str,
    sha256: &'a str,
    survey: &'a Survey,
    clock_s: Rc<Vec<f64>>,
    sources: Vec<Source>,
    stamps: Vec<Stamps>,
    /// Names and their sources.
    names: Vec<(String, usize)>,
}

/// Source of a column's values.
struct Source {
    values: Values,
    /// The stamps of the values; `None` for the clock's own columns.
    stamps: Option<usize>,
}

impl<'a> Joined<'a> {
    /// Joins the extracted columns by the rules of the map.
    pub(super) fn new(
        file: (&'a str, &'a str),
        survey: &'a Survey,
        map: &Map,
        clock: &str,
        mut series: BTreeMap<String, Series>,
        findings: &mut Findings,
    ) -> Self {
        let mut joined = Self {
            path: file.0,
            sha256: file.1,
            survey,
            clock_s: Rc::default(),
            sources: Vec::new(),
            stamps: Vec::new(),
            names: Vec::new(),
        };
        let mut wanted: BTreeMap<String, Vec<(String, String)>> = BTreeMap::new();
        wanted.entry(clock.to_owned()).or_default();
        for name in map.names() {
            if let Some((topic, field)) = survey.resolve(name) {
                let names = wanted.entry(topic).or_default();
                names.push((field, name.to_owned()));
            }
        }
        // Columns that no expression uses are dropped first, to free their memory.
        series.retain(|key, _| wanted.contains_key(key));
        let resets = resets::align(&mut series, clock);
        if resets > 0 {
            findings.warnings.push(format!(
                "{clock}: {resets} times the clock was set back; the log continues there with shifted time, by one shift for all topics"
            ));
        }
        for (key, names) in wanted {
            let mut series = series.remove(&key).unwrap_or_default();
            let is_clock = key == clock;
            let is = |name: &str| {
                survey
                    .topic_like(name)
                    .is_some_and(|topic| topic.key == key)
            };
            let said = map.topic(&is);
            let offset_s = said.map_or(0.0, |topic| topic.offset_s);
            if offset_s != 0.0 {
                series.time_s.iter_mut().for_each(|t| *t += offset_s);
            }
            let repairs = join::repair(&mut series, is_clock);
            warn(findings, &key, &series, repairs);
            let field = |name: &str| {
                let (topic, field) = survey.resolve(name)?;
                (topic == key).then_some(field)
            };
            // The limit follows from all messages, also from those that `valid` excludes. The clock's
            // own columns are not interpolated.
            let limit_s = match said.and_then(|topic| topic.limit_s) {
                Some(limit_s) => limit_s,
                None if is_clock => 0.0,
                None => join::usual_limit_s(&series.time_s),
            };
            let valid = said.map_or(&[][..], |topic| &topic.valid);
            match series.keep(valid, &field) {
                Ok(left_out) => {
                    // Rows that the trial loses are reported.
                    if is_clock && left_out > 0 {
                        findings.warnings.push(format!(
                            "{key}: {left_out} messages that `valid` excludes make no row"
                        ));
                    }
                }
                Err(fault) => findings.warnings.push(not_valid(survey, &key, fault)),
            }
            let how = said.map_or(Join::Linear, |topic| topic.join);
            joined.add((how, limit_s), is_clock, series, names);
        }
        joined
    }

    fn add(
        &mut self,
        (how, limit_s): (Join, f64),
        is_clock: bool,
        series: Series,
        mut names: Vec<(String, String)>,
    ) {
        let time_s = Rc::new(series.time_s);
        let mut whole = None;
        for (field, values) in series.fields.into_iter().zip(series.columns) {
            let place = self.sources.len();
            let before = names.len();
            names.retain(|(known, name)| {
                if *known == field {
                    self.names.push((name.clone(), place));
                }
                *known != field
            });
            if names.len() == before {
                continue;
            }
            if is_clock {
                let stamps = None;
                self.sources.push(Source { values, stamps });
                continue;
            }
            // Gaps are bridged like the time between messages. The last value of a command is held.
            let (values, stamps) = if how != Join::Linear || values.is_finite() {
                let stamps = *whole.get_or_insert_with(|| {
                    let time_s = Rc::clone(&time_s);
                    self.stamps.push(Stamps::new(time_s, how, limit_s));
                    self.stamps.len() - 1
                });
                (values, stamps)
            } else {
                let rows = 0..values.len();
                let known: Vec<usize> = rows.filter(|&row| values.get(row).is_finite()).collect();
                let time_s = known.iter().map(|&row| time_s[row]).collect();
                self.stamps.push(Stamps::new(Rc::new(time_s), how, limit_s));
                (values.pick(&known), self.stamps.len() - 1)
            };
            let stamps = Some(stamps);
            self.sources.push(Source { values, stamps });
        }
        if is_clock {
            self.clock_s = time_s;
        }
    }
}

impl Rows for Joined<'_> {
    fn path(&self) -> &str {
        self.path
    }

    fn sha256(&self) -> &str {
        self.sha256
    }

    fn len(&self) -> usize {
        self.clock_s.len()
    }

    fn row_number(&self, row: usize) -> usize {
        row
    }

    fn place(&self, name: &str) -> Option<usize> {
        let named = self.names.iter().find(|(known, _)| known == name);
        let place = named.map(|&(_, place)| place);
        // The stamps themselves come after all sources.
        place.or((name == TIME_CHANNEL).then_some(self.sources.len()))
    }

    fn fill(&mut self, place: usize, first: usize, into: &mut [f64]) {
        let clock_s = &self.clock_s[first..first + into.len()];
        let Some(source) = self.sources.get(place) else {
            into.copy_from_slice(clock_s);
            return;
        };
        match source.stamps {
            None => {
                let rows = first..first + into.len();
                let values = rows.map(|row| source.values.get(row));
                into.iter_mut()
                    .zip(values)
                    .for_each(|(to, value)| *to = value);
            }
            Some(stamps) => {
                let stamps = &mut self.stamps[stamps];
                stamps.locate(first, clock_s);
                stamps.join(&source.values, into);
            }
        }
    }

    fn lacks(&self, rule: &Rule, name: &str) -> LogError {
        no_field(self.survey, rule, name)
    }
}

/// The warning that a rule of the map names what no message of the topic has.
fn not_valid(survey: &Survey, key: &str, (rule, name): (&Rule, &str)) -> String {
    let fields = survey.topic(key).map_or(&[][..], |topic| &topic.fields);
    let names: Vec<String> = fields.iter().map(|f| format!("{key}.{}", f.name)).collect();
    let near = nearest(name, names.iter().map(String::as_str));
    let near = near.map_or_else(String::new, |near| format!(" (did you mean {near:?}?)"));
    format!(
        "{}: {name:?} is neither a field of {key} nor a parameter{near}; all its messages are used",
        rule.place
    )
}

fn warn(findings: &mut Findings, key: &str, series: &Series, repairs: join::Repairs) {
    for (count, what) in [
        (series.absent, "messages without a stamp were dropped"),
        (repairs.dropped, "messages out of order were dropped"),
        (
            repairs.resets,
            "times the clock was set back; the log continues there with shifted time",
        ),
    ] {
        if count > 0 {
            findings.warnings.push(format!("{key}: {count} {what}"));
        }
    }
}
