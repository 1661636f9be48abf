//! The report of `touchdown campaign`.

mod figures;
mod outcomes;

use std::path::Path;

use figures::{distributions, success_map, time_series};
use outcomes::{go_arounds, not_flown, not_landed, outcomes};
use touchdown_campaign::statistics::Share;
use touchdown_campaign::sweep::{
    CampaignResults, Figures, LandingRow, PointFigures, SampleSummary, Sweep, WorstLanding,
};
use touchdown_report::{Callout, Cell, Table};
use touchdown_sim::landing::space::SpaceTrace;

use super::page::{Page, half_interval, how_made, show, spread};
use super::watch::{start_s, watch};
use crate::error::Result;
use touchdown_campaign::settings_file::to_toml;

const SYMBOLS: &str = "A landing has landed when the vehicle stands on the deck with its rotors stopped, by the true state. \
     **First** counts landings in the first descent, also after go-arounds out of a hover. **Lateral** is the distance from the deck's centre at the first touch. \
     T_L, V_L, S_L and lateral are over the landings that landed. Impact speed and tilt are over every touch, crashes included.";

/// The worst landings that are drawn unfolded.
const UNFOLDED: usize = 2;

/// Writes `figures/*.svg`, `figures/*.png` and `report.html` of a campaign into the folder `out`; `worst` are the
/// records of the worst landings.
///
/// # Errors
/// Files that cannot be written, or figures that cannot be drawn.
pub fn campaign(
    sweep: &Sweep,
    rows: &[LandingRow],
    results: &CampaignResults,
    worst: &[SpaceTrace],
    out: &Path,
) -> Result<()> {
    let mut page = Page::new(
        "Campaign of landings",
        "Landings in six degrees of freedom over swept and random settings",
        out,
    );
    page.report
        .fact("Seed", results.seed.to_string())
        .fact("Trials at each point", results.trials.to_string())
        .fact("Trials", results.landings.to_string());
    if let Some(controller) = one_controller(results) {
        page.report.fact("Controller", controller);
    }
    if let Some(autopilot) = results.autopilot {
        page.report.fact("Autopilot in the loop", autopilot.title());
    }
    let (kind, verdict) = verdict(results);
    page.report.verdict(kind, verdict);
    let map = success_map(sweep, results);
    let distributions = distributions(sweep, rows, results);
    let pictures = [figures::outcomes(results), map, Some(distributions)];
    let mut pictures = pictures.into_iter().flatten();
    pictures.next().map_or(Ok(()), |first| page.figure(first))?;
    page.report.section("Points");
    page.text(SYMBOLS);
    if let Some(autopilot) = results.autopilot {
        page.text(format!(
            "{} itself flew every landing, in the loop with the simulated world. Its threads run as the machine lets them, so the \
             figures are not reproducible to the bit: landings repeat to about a hundredth.",
            autopilot.title()
        ));
    }
    page.table(outcomes(results))?;
    let beside = [
        not_flown(results),
        not_landed(sweep, rows, results),
        go_arounds(results),
    ];
    let mut beside = beside.into_iter().flatten();
    beside.try_for_each(|table| page.table(table))?;
    page.table(quantities(results))?;
    for text in drawn(sweep, results) {
        page.text(text);
    }
    pictures.try_for_each(|figure| page.figure(figure))?;
    page.report.section("The worst landings");
    page.text(format!(
        "Crashes stand first, then what did not land, then the hardest touches. {}",
        match results.autopilot {
            None => "Each is flown once more from its seed.",
            Some(_) => "With `software_in_the_loop.record = true` the folder `records` holds the truth of each landing.",
        }
    ));
    page.table(worst_table(results))?;
    if let (Some(first), Some(trace)) = (results.worst.first(), worst.first()) {
        let point = first.landing / sweep.trials();
        let landing = watch(&sweep.scenario(point)?, trace, start_s([trace]))?;
        page.report.scene(figures::watched(first, landing))?;
    }
    let mut worst = results.worst.iter().zip(worst).enumerate();
    let drawn = |(rank, (worst, trace))| time_series(rank + 1, worst, trace);
    for landing in worst.by_ref().take(UNFOLDED) {
        page.figure(drawn(landing))?;
    }
    page.folded_figures("More of the worst landings", worst.map(drawn))?;
    how_made(
        &mut page.report,
        "touchdown campaign sweep.toml --out DIR",
        Some(("sweep.toml", to_toml(sweep.settings())?)),
    )?;
    page.text(format!("SHA-256 of the sweep: `{}`.", results.sweep_sha256));
    page.finish()
}

/// What is drawn, and how many draws were replaced.
fn drawn(sweep: &Sweep, results: &CampaignResults) -> Vec<String> {
    let random: Vec<String> = sweep.drawn().map(|key| format!("`{key}`")).collect();
    let every = (!random.is_empty()).then(|| {
        format!(
            "Every trial has its own random values of {}. Trial k has the same values at every point.",
            random.join(", ")
        )
    });
    let replaced = results.redrawn_texts().into_iter();
    let replaced = replaced.map(|text| format!("{text}."));
    every.into_iter().chain(replaced).collect()
}

/// How many landings landed and crashed, and where most and fewest landed.
fn verdict(results: &CampaignResults) -> (Callout, String) {
    let total = |pick: fn(&Figures) -> Option<Share>| -> u64 {
        let points = results.points.iter();
        points
            .filter_map(|p| pick(&p.figures))
            .map(|s| s.count)
            .sum()
    };
    let (landed, crashed) = (total(|f| f.landed), total(|f| f.crashed));
    let not_flown: u64 = results.points.iter().map(|p| p.figures.not_flown).sum();
    let flown = results.landings - not_flown;
    if flown == 0 {
        let none = format!("None of {not_flown} trials began.");
        return (Callout::Failure, none);
    }
    let kind = match (landed == results.landings, crashed) {
        (true, _) => Callout::Success,
        (false, 0) => Callout::Warning,
        (false, _) => Callout::Failure,
    };
    let all = format!(
        "{}{}; {}.",
        match landed {
            0 => format!("None of {flown} trials lands"),
            _ if landed == flown => format!("All {landed} trials land"),
            _ => format!("{landed} of {flown} trials land"),
        },
        match total(|f| f.landed_at_first) {
            _ if landed == 0 => String::new(),
            first if first == landed => ", all in the first descent".to_string(),
            first => format!(", {first} of them in the first descent"),
        },
        match crashed {
            0 => "none crashes".to_string(),
            1 => "one crashes".to_string(),
            _ => format!("{crashed} crash"),
        }
    );
    let all = match not_flown {
        0 => all,
        _ => format!("{all} Another {not_flown} never began."),
    };
    let share = |p: &&PointFigures| p.figures.landed.map_or(0.0, |s| s.share);
    let by_share = |a: &&PointFigures, b: &&PointFigures| share(a).total_cmp(&share(b));
    let [best, worst] = [
        results.points.iter().rev().max_by(by_share),
        results.points.iter().min_by(by_share),
    ];
    let shown = |p: &PointFigures| format!("`{}` ({} %)", p.of.label(), show(100.0 * share(&p), 1));
    match best.zip(worst) {
        Some((best, worst)) if share(&best) > share(&worst) => {
            let interval = |p: &PointFigures| p.figures.landed.map_or([0.0, 1.0], |s| s.ci95);
            let doubt = match interval(best)[0] <= interval(worst)[1] {
                true => ", but their 95 % intervals overlap",
                false => "",
            };
            (
                kind,
                format!(
                    "{all} Most land with {}, fewest with {}{doubt}.",
                    shown(best),
                    shown(worst)
                ),
            )
        }
        _ => (kind, all),
    }
}

/// The controller of all points, where it is one.
fn one_controller(results: &CampaignResults) -> Option<String> {
    let mut all = results.points.iter().map(|p| &p.of.controller);
    let first = all.next()?;
    all.all(|other| other == first).then(|| first.clone())
}

type Pick = fn(&PointFigures) -> &SampleSummary;

fn quantities(results: &CampaignResults) -> Table {
    let mut table = Table::new("Figures of the landings.")
        .text_column("Point")
        .text_column("Quantity")
        .number_column("Landings", "")
        .number_column("Mean", "")
        .number_column("CI", "")
        .number_column("50 %", "")
        .number_column("95 %", "")
        .number_column("99 %", "")
        .number_column("Worst", "");
    let picks: [(&str, Pick, usize); 6] = [
        ("T_L (s)", |p| &p.figures.t_l_s, 2),
        ("V_L (m/s)", |p| &p.figures.v_l_mps, 3),
        ("S_L (m)", |p| &p.figures.s_l_m, 3),
        ("lateral (m)", |p| &p.figures.lateral_m, 3),
        ("impact speed (m/s)", |p| &p.figures.impact_mps, 3),
        ("impact tilt (rad)", |p| &p.figures.impact_tilt_rad, 3),
    ];
    for p in &results.points {
        for (i, (name, pick, decimals)) in picks.into_iter().enumerate() {
            let of = pick(p);
            let one = |value: Option<f64>| {
                value.map_or_else(Cell::missing, |v| Cell::number(v, decimals))
            };
            table = table.row([
                Cell::text(if i == 0 { p.of.label() } else { String::new() }),
                Cell::text(name),
                Cell::text(of.count.to_string()),
                spread(of.summary(), decimals),
                half_interval(of.summary(), decimals),
                one(of.p50),
                one(of.p95),
                one(of.p99),
                one(of.max),
            ]);
        }
    }
    table.note("Mean ± standard deviation; CI: half the 95 % interval of the mean (Student's t); percentages: percentiles.")
}

fn worst_table(results: &CampaignResults) -> Table {
    let mut table = Table::new("The worst landings.")
        .number_column("Landing", "")
        .text_column("Point")
        .number_column("Trial", "")
        .text_column("Outcome")
        .number_column("V_L", "m/s")
        .number_column("Hardest touch", "m/s")
        .number_column("Lateral", "m");
    for worst in &results.worst {
        let one = |value: Option<f64>| value.map_or_else(Cell::missing, |v| Cell::number(v, 3));
        table = table.row([
            Cell::text(worst.landing.to_string()),
            Cell::text(worst.of.label()),
            Cell::text(worst.trial.to_string()),
            Cell::text(ended(worst)),
            one(worst.v_l_mps),
            one(worst.impact_mps),
            one(worst.lateral_m),
        ]);
    }
    table
}

fn ended(worst: &WorstLanding) -> String {
    let outcome = worst.outcome.replace('_', " ");
    worst.why.as_ref().map_or(outcome.clone(), |why| {
        format!("{outcome} ({})", why.replace('_', " "))
    })
}
