//! What became of landings: a row for each, and why some did not land.

use touchdown_campaign::csv;
use touchdown_campaign::statistics::Summary;
use touchdown_campaign::sweep::{CampaignResults, LandingRow, Sweep, counted};
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

/// Why landings of a method did not land, if some did not.
pub(super) fn why_not_landed(m: &MethodLandings) -> Option<String> {
    let (all, landed) = (m.figures.trials, m.figures.landed);
    let by = m.method.name();
    let what = match all - landed {
        0 => return None,
        missing if landed > 0 => format!("{missing} of {all} landings by {by} did not land"),
        _ => format!("none of {all} landings by {by} landed"),
    };
    let others = m.landings.iter().filter(|l| l.outcome != Outcome::Landed);
    Some(format!(
        "{what}: {}{}",
        counted(others.map(reason_of_vertical)),
        at_timeout(&m.landings)
    ))
}

/// At which heights vertical landings timed out, those in a hover apart from the others; nothing where none timed out.
fn at_timeout(landings: &[Landing]) -> String {
    let timed_out = || landings.iter().filter(|l| l.outcome == Outcome::TimedOut);
    let hovering = timed_out().filter_map(|l| l.hover_height_m).collect();
    let moving = timed_out().filter(|l| l.hover_height_m.is_none());
    let moving = moving.map(|l| l.final_height_m).collect();
    let part = |heights_m: Vec<f64>, what: &str| {
        let mean_m = Summary::of(&heights_m)?.mean;
        let count = heights_m.len();
        Some(format!("{count} {what} {mean_m:.3} m on average"))
    };
    let parts = [
        part(hovering, "hovered at"),
        part(moving, "were still moving when their time was up, at"),
    ];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    match parts.is_empty() {
        true => String::new(),
        false => format!("; of those that timed out {}", parts.join(", and ")),
    }
}

/// How a vertical landing ended, in words.
fn reason_of_vertical(landing: &Landing) -> String {
    match landing.outcome {
        Outcome::Crashed => "crashed (speed)".to_string(),
        other => other.name().replace('_', " "),
    }
}

/// Points of a campaign that have a line for their failures, at most.
const MOST_POINTS: usize = 12;

/// Why landings of a campaign did not land, a line for each such point, the one with the fewest landings first.
pub(crate) fn failures(
    sweep: &Sweep,
    rows: &[LandingRow],
    results: &CampaignResults,
) -> Vec<String> {
    let of_points = rows.chunks(sweep.trials() as usize);
    let mut failed: Vec<(usize, String)> = Vec::new();
    for (point, rows) in results.points.iter().zip(of_points) {
        let flown = || rows.iter().filter(|row| row.flown());
        let landed = flown().filter(|row| row.landed()).count();
        let all = flown().count();
        if landed == all {
            continue;
        }
        let label = point.of.label();
        let of = match landed {
            0 => format!("none of {all} landings at {label} landed"),
            _ => format!("{} of {all} landings at {label} did not land", all - landed),
        };
        let why = counted(flown().filter(|row| !row.landed()).map(LandingRow::ending));
        failed.push((landed, format!("{of}: {why}")));
    }
    failed.sort_by_key(|(landed, _)| *landed);
    let more = failed.len().saturating_sub(MOST_POINTS);
    let mut lines: Vec<String> = failed.into_iter().map(|(_, line)| line).collect();
    lines.truncate(MOST_POINTS);
    if more > 0 {
        lines.push(format!(
            "and failures at {more} more points; the report has all"
        ));
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
            counted(
                rows.iter()
                    .filter(|row| !row.flown())
                    .map(LandingRow::ending)
            )
        )
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_heights_at_the_timeout_are_those_of_hovers_and_of_descents() {
        let landing = |outcome, final_height_m, hover_height_m| Landing {
            trial_index: 0,
            outcome,
            t_l_s: None,
            v_l_mps: None,
            s_l_m: 0.0,
            final_height_m,
            hover_height_m,
            trace: None,
        };
        let crashed = landing(Outcome::Crashed, 0.1, None);
        let hovering = landing(Outcome::TimedOut, 0.3, Some(0.15));
        let [high, low] = [0.5, 0.4].map(|m| landing(Outcome::TimedOut, m, None));
        assert_eq!(at_timeout(std::slice::from_ref(&crashed)), "");
        let moving = "2 were still moving when their time was up, at 0.450 m on average";
        assert_eq!(
            at_timeout(&[high.clone(), low.clone()]),
            format!("; of those that timed out {moving}")
        );
        assert_eq!(
            at_timeout(&[high, crashed, hovering, low]),
            format!("; of those that timed out 1 hovered at 0.150 m on average, and {moving}")
        );
    }
}
