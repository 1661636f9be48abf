//! How the landings of a campaign ended, as tables.

use std::collections::BTreeSet;

use touchdown_campaign::statistics::Share;
use touchdown_campaign::sweep::{CampaignResults, LandingRow, Sweep, counted};
use touchdown_report::{Cell, Table};

use crate::page::{show, spread};

/// `percent (low to high)`.
fn share(share: Option<Share>) -> Cell {
    share.map_or_else(Cell::missing, |s| {
        let percent = |v: f64| show(100.0 * v, 1);
        Cell::text(format!(
            "{} ({}\u{a0}to\u{a0}{})",
            percent(s.share),
            percent(s.ci95[0]),
            percent(s.ci95[1])
        ))
    })
}

/// Shares of outcomes: a row for each point.
pub(super) fn outcomes(results: &CampaignResults) -> Table {
    let mut table = Table::new("Outcomes.")
        .text_column("Point")
        .number_column("Landed", "%")
        .number_column("First", "%")
        .number_column("Hard", "%")
        .number_column("Crashed", "%")
        .number_column("Given up", "%")
        .number_column("Timed out", "%")
        .number_column("Waiting", "s");
    for p in &results.points {
        table = table.row([
            Cell::text(p.of.label()),
            share(p.figures.landed),
            share(p.figures.landed_at_first),
            share(p.figures.hard),
            share(p.figures.crashed),
            share(p.figures.ended("given_up")),
            share(p.figures.ended("timed_out")),
            spread(p.figures.waited_s.summary(), 1),
        ]);
    }
    table.note("In brackets: 95 % interval of the share (Wilson). Hard: landed, with a touch above half of the crash speed. Waiting: until the deck's motion is known and a window to land opens; mean ± standard deviation over the trials that came to wait or to descend.")
}

/// Landings that never began: a row for each point that has some, a column for each reason.
pub(super) fn not_flown(results: &CampaignResults) -> Option<Table> {
    let some = || results.points.iter().filter(|p| p.figures.not_flown > 0);
    let reasons = some().flat_map(|p| p.figures.not_flown_reasons.keys());
    let reasons: BTreeSet<&String> = reasons.collect();
    let mut table = Table::new("Landings that never began, by reason.")
        .text_column("Point")
        .number_column("Not flown", "");
    for reason in &reasons {
        table = table.number_column(reason.replace('_', " "), "");
    }
    for p in some() {
        let of = |reason: &&String| {
            p.figures
                .not_flown_reasons
                .get(*reason)
                .copied()
                .unwrap_or(0)
        };
        let counts = reasons.iter().map(|r| Cell::text(of(r).to_string()));
        let point = [
            Cell::text(p.of.label()),
            Cell::text(format!("{} of {}", p.figures.not_flown, p.figures.trials)),
        ];
        table = table.row(point.into_iter().chain(counts));
    }
    (!reasons.is_empty()).then(|| {
        table.note("The vehicle did not come to hold above the deck, so there was nothing to land. These are in no share, mean or percentile.")
    })
}

/// Go-arounds: a row for each point, a column for each reason; none where there was none.
pub(super) fn go_arounds(results: &CampaignResults) -> Option<Table> {
    let reasons = results.points.iter().flat_map(|p| p.figures.aborts.keys());
    let reasons: BTreeSet<&String> = reasons.collect();
    let mut table = Table::new("Go-arounds by reason.").text_column("Point");
    for reason in &reasons {
        table = table.number_column(reason.replace('_', " "), "");
    }
    for p in &results.points {
        let of = |reason: &&String| p.figures.aborts.get(*reason).copied().unwrap_or(0);
        let counts = reasons.iter().map(|r| Cell::text(of(r).to_string()));
        table = table.row([Cell::text(p.of.label())].into_iter().chain(counts));
    }
    (!reasons.is_empty()).then(|| {
        table.note("A go-around breaks off a descent, or a hover before it. A trial may have several. The limits of each reason stand in the settings below.")
    })
}

/// Why trials did not land: a row for each point where some did not; none where all landed.
pub(super) fn not_landed(
    sweep: &Sweep,
    rows: &[LandingRow],
    results: &CampaignResults,
) -> Option<Table> {
    let mut table = Table::new("Trials that did not land, and how they ended.")
        .text_column("Point")
        .number_column("Not landed", "")
        .text_column("Ended");
    let mut some = false;
    for (p, rows) in results
        .points
        .iter()
        .zip(rows.chunks(sweep.trials() as usize))
    {
        let flown = || rows.iter().filter(|row| row.flown());
        let failed = || flown().filter(|row| !row.landed());
        if failed().next().is_none() {
            continue;
        }
        some = true;
        table = table.row([
            Cell::text(p.of.label()),
            Cell::text(format!("{} of {}", failed().count(), flown().count())),
            Cell::text(counted(failed().map(LandingRow::ending))),
        ]);
    }
    some.then_some(table)
}
