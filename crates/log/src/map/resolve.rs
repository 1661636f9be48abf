//! Which of a map's expressions can be taken.

use super::{Map, Rule};
#[cfg(feature = "flight-logs")]
use crate::Place;
use sindy_expr::Expr;
use std::collections::BTreeSet;

/// A map without alternatives: what is left is all to be evaluated.
pub(crate) struct Resolved {
    pub(crate) map: Map,
    /// Optional channels that cannot be made, and a name that they miss.
    pub(crate) left_out: Vec<(String, String)>,
}

impl Resolved {
    /// What was left out, one sentence each.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let sentence = |(channel, cause): &(String, String)| {
            format!("{channel}: left out, for there is no {cause}")
        };
        self.left_out.iter().map(sentence).collect()
    }
}

impl Map {
    /// Takes the first expression of each channel and definition whose names are all known, and
    /// puts in the numbers that names such as `param.THR_MDL_FAC` stand for. Where none can be
    /// taken an optional channel is left out, and the first expression of any other stays, to
    /// be told as an error when it is evaluated.
    pub(crate) fn resolve(
        &self,
        known: &dyn Fn(&str) -> bool,
        constant: &dyn Fn(&str) -> Option<f64>,
    ) -> Resolved {
        let mut defined: BTreeSet<&str> = BTreeSet::new();
        let missing = |rule: &Rule, defined: &BTreeSet<&str>| {
            let names = rule.expr.variables();
            let lacks =
                |name: &&str| !known(name) && constant(name).is_none() && !defined.contains(name);
            names.into_iter().find(lacks).map(str::to_owned)
        };
        let mut map = self.clone();
        map.defines = Vec::new();
        let mut causes: Vec<(&str, String)> = Vec::new();
        for group in groups(&self.defines) {
            let taken = group.iter().find(|rule| missing(rule, &defined).is_none());
            if let Some(rule) = taken {
                defined.insert(&rule.channel);
                map.defines.push(filled(rule, constant));
            } else if let Some(cause) = group.first().and_then(|rule| missing(rule, &defined)) {
                // What a definition misses is missed by those who use it.
                let deeper = causes.iter().find(|(name, _)| *name == cause);
                let cause = deeper.map_or(cause, |(_, cause)| cause.clone());
                causes.push((&group[0].channel, cause));
            }
        }
        map.channels = Vec::new();
        let mut left_out = Vec::new();
        for group in groups(&self.channels) {
            let taken = group.iter().find(|rule| missing(rule, &defined).is_none());
            match taken {
                Some(rule) => map.channels.push(filled(rule, constant)),
                None if self.optional.contains(&group[0].channel) => {
                    let cause = missing(&group[0], &defined).unwrap_or_default();
                    let deeper = causes.iter().find(|(name, _)| *name == cause);
                    let cause = deeper.map_or(cause, |(_, cause)| cause.clone());
                    left_out.push((group[0].channel.clone(), cause));
                }
                None => {
                    // The error shall name what is not there, and not the definition.
                    let mut rule = filled(&group[0], constant);
                    for (name, cause) in &causes {
                        rule.expr = rule.expr.substitute(name, &Expr::variable(cause));
                    }
                    map.channels.push(rule);
                }
            }
        }
        map.keep = self.keep.as_ref().map(|rule| filled(rule, constant));
        Resolved { map, left_out }
    }

    /// The names that its expressions use, those of definitions left out.
    #[cfg(feature = "flight-logs")]
    pub(crate) fn inputs(&self) -> BTreeSet<&str> {
        let valid = self.topics.iter().flat_map(|topic| &topic.valid);
        let rules = self.defines.iter().chain(&self.channels).chain(&self.keep);
        let rules = rules.chain(valid);
        let names: BTreeSet<&str> = rules.flat_map(|rule| rule.expr.variables()).collect();
        let own = |name: &&str| !self.defines.iter().any(|rule| rule.channel == **name);
        names.into_iter().filter(own).collect()
    }

    /// The names that any of its expressions uses, taken or not.
    #[cfg(feature = "flight-logs")]
    pub(crate) fn names(&self) -> BTreeSet<&str> {
        let valid = self.topics.iter().flat_map(|topic| &topic.valid);
        let rules = self.defines.iter().chain(&self.channels).chain(&self.keep);
        let rules = rules.chain(valid);
        rules.flat_map(|rule| rule.expr.variables()).collect()
    }

    /// The topics that may be the clock, and where the map says so.
    #[cfg(feature = "flight-logs")]
    pub(crate) fn clocks(&self) -> Option<(&Place, &[String])> {
        self.clocks
            .as_ref()
            .map(|(place, names)| (place, names.as_slice()))
    }

    /// What is said of a topic; `is` tells whether a name is the topic's.
    #[cfg(feature = "flight-logs")]
    pub(crate) fn topic(&self, is: &dyn Fn(&str) -> bool) -> Option<&super::Topic> {
        self.topics.iter().find(|known| is(&known.name))
    }
}

/// Rules of one name.
fn groups(rules: &[Rule]) -> impl Iterator<Item = &[Rule]> {
    rules.chunk_by(|a, b| a.channel == b.channel)
}

fn filled(rule: &Rule, constant: &dyn Fn(&str) -> Option<f64>) -> Rule {
    let mut rule = rule.clone();
    let names: Vec<String> = rule
        .expr
        .variables()
        .into_iter()
        .map(str::to_owned)
        .collect();
    for name in names {
        if let Some(value) = constant(&name) {
            rule.expr = rule.expr.substitute(&name, &Expr::constant(value));
        }
    }
    rule
}
