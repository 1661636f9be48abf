//! What became of landings: a row for each, and why none landed.

use std::collections::BTreeMap;

use touchdown_campaign::csv;
use touchdown_campaign::sweep::{CampaignResults, LandingRow, Sweep};
use touchdown_reproduce::experiments::landing::MethodLandings;
use touchdown_sim::landing::vertical::{Landing, Outcome};

/// Columns of [`vertical`].
const COLUMNS: [&str; 7] = [
    "controller",
    "trial",
    "outcome",
    "t_l_s",
    "v_l_mps",
    "s_l_m",
    "final_height_m",
];

/// Vertical landings as CSV, a row for each; S_L is that of landings that landed.
pub(super) fn vertical(methods: &[MethodLandings]) -> String {
    let cell = |v: Option<f64>| v.map_or_else(String::new, |v| v.to_string());
    let mut out = String::new();
    csv::line(&mut out, COLUMNS);
    for m in methods {
        for l in &m.landings {
            let cells = [
                m.method.name().to_string(),
                l.trial_index.to_string(),
                l.outcome.name().to_string(),
                cell(l.t_l_s),
                cell(l.v_l_mps),
                cell(l.t_l_s.is_some().then_some(l.s_l_m)),
                l.final_height_m.to_string(),
            ];
            csv::line(&mut out, cells);
        }
    }
    out
}

/// Why no landing of a method landed, if none did.
pub(super) fn why_none_landed(m: &MethodLandings) -> Option<String> {
    if m.figures.landed > 0 {
        return None;
    }
    let hover = m.figures.hover_height_m.map_or_else(String::new, |h| {
        format!(
            "; landings that timed out hovered at {:.3} m on average",
            h.mean
        )
    });
    Some(format!(
        "none of {} landings by {} landed: {}{hover}",
        m.figures.trials,
        m.method.name(),
        counted(m.landings.iter().map(reason_of_vertical))
    ))
}

/// How a vertical landing ended, in words.
fn reason_of_vertical(landing: &Landing) -> String {
    match landing.outcome {
        Outcome::Crashed => "crashed (speed)".to_string(),
        other => other.name().replace('_', " "),
    }
}

/// Why no landing of a campaign's point landed, a line for each such point.
pub(crate) fn points_without_landing(
    sweep: &Sweep,
    rows: &[LandingRow],
    results: &CampaignResults,
) -> Vec<String> {
    let mut lines = Vec::new();
    for (point, of_point) in results
        .points
        .iter()
        .zip(rows.chunks(sweep.trials() as usize))
    {
        if !of_point.iter().any(LandingRow::landed) {
            lines.push(format!(
                "none of {} landings at {} landed: {}",
                of_point.len(),
                point.of.label(),
                counted(of_point.iter().map(reason))
            ));
        }
    }
    lines
}

/// How many landings of a campaign's point never began, and why, a line for each such point.
pub(crate) fn not_flown(
    sweep: &Sweep,
    rows: &[LandingRow],
    results: &CampaignResults,
) -> Vec<String> {
    let of_points = rows.chunks(sweep.trials() as usize);
    let of_points = results.points.iter().zip(of_points);
    let some = of_points.filter(|(point, _)| point.figures.not_flown > 0);
    some.map(|(point, rows)| {
        format!(
            "{} of {} landings at {} never began and are in no share: {}",
            point.figures.not_flown,
            rows.len(),
            point.of.label(),
            counted(rows.iter().filter(|row| !row.flown()).map(reason))
        )
    })
    .collect()
}

/// How a landing in space ended, in words.
fn reason(row: &LandingRow) -> String {
    let outcome = match &row.why {
        Some(why) => format!("{} ({why})", row.outcome),
        None => row.outcome.clone(),
    };
    outcome.replace('_', " ")
}

/// How often each reason stands there, the most frequent one first.
fn counted(reasons: impl Iterator<Item = String>) -> String {
    let mut counts = BTreeMap::<String, usize>::new();
    for reason in reasons {
        *counts.entry(reason).or_default() += 1;
    }
    let mut counts: Vec<(String, usize)> = counts.into_iter().collect();
    counts.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let parts = counts
        .iter()
        .map(|(reason, count)| format!("{count} {reason}"));
    parts.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_the_most_frequent_reason_comes_first() {
        let reasons = ["crashed", "timed out", "timed out", "given up (battery)"];
        assert_eq!(
            counted(reasons.map(String::from).into_iter()),
            "2 timed out, 1 crashed, 1 given up (battery)"
        );
    }
}
