//! Which of a map's expressions can be taken.

use super::define::Definitions;
use super::{Map, Rule};
use crate::Place;
use sindy_expr::Expr;
use std::collections::BTreeSet;

/// A map without alternatives and definitions: what is left is all to be evaluated, and names
/// only what is there.
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
    /// puts in the numbers that names such as `param.THR_MDL_FAC` stand for, and the definitions.
    /// Where none can be taken an optional channel is left out, and the first expression of any
    /// other stays, to be told as an error when it is evaluated. Of what tells which messages
    /// count all alternatives stay: which of them a topic bears out is for its reader.
    pub(crate) fn resolve(
        &self,
        known: &dyn Fn(&str) -> bool,
        constant: &dyn Fn(&str) -> Option<f64>,
    ) -> Resolved {
        let mut defined = Definitions::default();
        // With those that miss something, for which stands what they miss.
        let mut all = Definitions::default();
        let missing = |rule: &Rule, defined: &Definitions| {
            let names = rule.expr.variables();
            let lacks =
                |name: &&str| !known(name) && constant(name).is_none() && !defined.contains(name);
            names.into_iter().find(lacks).map(str::to_owned)
        };
        let put_in = |rule: &Rule, by: &Definitions| {
            let mut rule = rule.clone();
            rule.expr = by.expand(&filled(&rule.expr, constant));
            rule
        };
        // An error shall name what is not there, and not the definition.
        let put_in_or_tell =
            |rule: &Rule, defined: &Definitions, all: &Definitions| match missing(rule, defined) {
                None => put_in(rule, defined),
                Some(_) => put_in(rule, all),
            };
        for group in groups(&self.defines) {
            let name = &group[0].channel;
            let taken = group.iter().find(|rule| missing(rule, &defined).is_none());
            if let Some(rule) = taken {
                let expr = put_in(rule, &defined).expr;
                defined.insert(name, expr.clone());
                all.insert(name, expr);
            } else if let Some(cause) = missing(&group[0], &defined) {
                let deeper = all.expand(&Expr::variable(&cause));
                all.insert(name, deeper);
            }
        }
        let mut map = self.clone();
        map.defines = Vec::new();
        map.channels = Vec::new();
        let mut left_out = Vec::new();
        for group in groups(&self.channels) {
            let taken = group.iter().find(|rule| missing(rule, &defined).is_none());
            if taken.is_none() && self.optional.contains(&group[0].channel) {
                let cause = missing(&group[0], &defined).unwrap_or_default();
                let deeper = all.expand(&Expr::variable(&cause));
                let cause = deeper.variables().first().copied().unwrap_or_default();
                left_out.push((group[0].channel.clone(), cause.to_owned()));
                continue;
            }
            let rule = taken.unwrap_or(&group[0]);
            map.channels.push(put_in_or_tell(rule, &defined, &all));
        }
        let last = |rule: &Rule| put_in_or_tell(rule, &defined, &all);
        map.keep = self.keep.as_ref().map(last);
        for topic in &mut map.topics {
            topic.valid = topic.valid.iter().map(last).collect();
        }
        Resolved { map, left_out }
    }

    /// The names that any of its expressions uses.
    pub(crate) fn names(&self) -> BTreeSet<&str> {
        let valid = self.topics.iter().flat_map(|topic| &topic.valid);
        let rules = self.defines.iter().chain(&self.channels).chain(&self.keep);
        let rules = rules.chain(valid);
        rules.flat_map(|rule| rule.expr.variables()).collect()
    }

    /// The topics that may be the clock, and their place in the map.
    pub(crate) fn clocks(&self) -> Option<(&Place, &[String])> {
        self.clocks
            .as_ref()
            .map(|(place, names)| (place, names.as_slice()))
    }

    /// The map's settings of a topic; `is` states whether a name is the topic's.
    pub(crate) fn topic(&self, is: &dyn Fn(&str) -> bool) -> Option<&super::Topic> {
        self.topics.iter().find(|known| is(&known.name))
    }
}

/// Rules of one name.
fn groups(rules: &[Rule]) -> impl Iterator<Item = &[Rule]> {
    rules.chunk_by(|a, b| a.channel == b.channel)
}

fn filled(expr: &Expr, constant: &dyn Fn(&str) -> Option<f64>) -> Expr {
    let names = expr.variables().into_iter();
    let numbers = names.filter_map(|name| Some((name, constant(name)?)));
    numbers.fold(expr.clone(), |filled, (name, value)| {
        filled.substitute(name, &Expr::constant(value))
    })
}
