//! Choice among a map's alternative expressions.

use super::define::Definitions;
use super::{Map, Rule};
use crate::Place;
use sindy_expr::Expr;
use std::collections::BTreeSet;

/// A map without alternatives and definitions: all of its expressions are evaluated, and all of their
/// names exist.
pub(crate) struct Resolved {
    pub(crate) map: Map,
    /// Optional channels that cannot be evaluated, and the name that is missing.
    pub(crate) left_out: Vec<(String, String)>,
}

impl Resolved {
    /// The omitted channels, one sentence each.
    pub(crate) fn warnings(&self) -> Vec<String> {
        let sentence = |(channel, cause): &(String, String)| {
            format!("{channel}: omitted, because there is no {cause}")
        };
        self.left_out.iter().map(sentence).collect()
    }
}

impl Map {
    /// Chooses the first expression of each channel and definition whose names are all known. It
    /// substitutes definitions and parameters such as `param.THR_MDL_FAC`.
    ///
    /// If no expression can be used, an optional channel is omitted. Any other channel keeps its
    /// first expression, whose evaluation then reports the error. All alternatives of `valid` are
    /// kept, because only the topic's reader knows its fields.
    pub(crate) fn resolve(
        &self,
        known: &dyn Fn(&str) -> bool,
        constant: &dyn Fn(&str) -> Option<f64>,
    ) -> Resolved {
        let mut defined = Definitions::default();
        // It includes definitions that cannot be used; each of them is represented by its missing
        // name.
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
        // An error names the missing name, not the definition.
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
