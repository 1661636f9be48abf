//! Figures of the landings at sea.

use touchdown_report::{Color, Figure, Panel, Series};
use touchdown_sim::landing::space::{Case, SpaceTrace, TraceRow};

use super::words;
use crate::experiments::sea::SeaExperiment;
use crate::experiments::sea::SeaMethod;
use crate::pages::page::shares_below;
use crate::pages::track::{estimated, estimated_deck_mps};
use crate::statistics::Share;
use crate::sweep::Figures;

fn color(how: SeaMethod) -> Color {
    Color::Cycle(match how {
        SeaMethod::Planned => 0,
        SeaMethod::StraightDown => 1,
        SeaMethod::Published => 2,
    })
}

/// What a case is called on an axis.
fn short(case: Case) -> &'static str {
    match case {
        Case::TagLost => "tag lost",
        Case::RangeMissing => "range",
        Case::LateUnknown => "unstamped",
        Case::Nan => "NaN",
        other => other.name(),
    }
}

/// Shares that land, at the first attempt and at all, with their intervals.
pub(super) fn success(sea: &SeaExperiment) -> Figure {
    let cases: Vec<Case> = Case::DECKS.into_iter().chain(Case::FAULTS).collect();
    type Pick = fn(&Figures) -> Option<Share>;
    let panels: [(&str, Pick); 2] = [
        ("At the first attempt (%)", |f| f.landed_at_first),
        ("At any attempt (%)", |f| f.landed),
    ];
    let mut figure = Figure::new("sea-success", "Share of landings that land")
        .caption("Points: share of the trials; lines: its 95 % interval (Wilson). Faults stand above the paper's deck.")
        .size(900, 640);
    for (row, (label, pick)) in panels.into_iter().enumerate() {
        let mut panel = Panel::new("Deck or fault", label)
            .categories(cases.iter().map(|case| short(*case)))
            .y_range(-4.0, 104.0);
        for (k, how) in SeaMethod::ALL.into_iter().enumerate() {
            let (mut x, mut y, mut at, mut interval) = (vec![], vec![], vec![], vec![]);
            for (place, case) in cases.iter().enumerate() {
                if let Some(share) = sea.of(*case, how).and_then(|l| pick(&l.figures)) {
                    let [low, high] = share.ci95;
                    let here = place as f64 + 0.22 * (k as f64 - 1.0);
                    x.push(here);
                    y.push(100.0 * share.share);
                    at.extend([here, here, f64::NAN]);
                    interval.extend([100.0 * low, 100.0 * high, f64::NAN]);
                }
            }
            let name = if row == 0 {
                words(how.name())
            } else {
                String::new()
            };
            panel = panel
                .series(Series::line("", &at, &interval).color(color(how)))
                .series(Series::points(name, &x, &y).color(color(how)).width(4.0));
        }
        figure = figure.panel(panel);
    }
    figure
}

/// Cumulative distributions of V_L, a panel for each deck.
pub(super) fn impact(sea: &SeaExperiment) -> Figure {
    let mut figure = Figure::new("sea-impact", "Share of landings that touch below a speed")
        .caption("V_L of the landings that landed.")
        .size(900, 900)
        .share_x();
    for (row, deck) in Case::DECKS.into_iter().enumerate() {
        let mut panel = Panel::new("V_L (m/s)", "Share (%)")
            .title(deck.name())
            .y_range(0.0, 104.0);
        for how in SeaMethod::ALL {
            let Some(l) = sea.of(deck, how) else { continue };
            let landed = l.rows.iter().filter(|r| r.landed());
            let (values, shares) = shares_below(landed.filter_map(|r| r.number("v_l_mps")));
            let name = if row == 0 {
                words(how.name())
            } else {
                String::new()
            };
            panel = panel.series(Series::steps(name, &values, &shares).color(color(how)));
        }
        figure = figure.panel(panel);
    }
    figure
}

/// One landing over the heaving deck.
pub(super) fn track(trace: &SpaceTrace) -> Figure {
    let rows = &trace.rows;
    let of = |pick: &dyn Fn(&TraceRow) -> f64| rows.iter().map(pick).collect::<Vec<f64>>();
    let time = of(&|r| r.time_s);
    let line = |name: &str, values: &[f64], color: usize| {
        Series::line(name, &time, values).color(Color::Cycle(color))
    };
    let altitude = Panel::new("Time (s)", "Altitude (m)")
        .series(line("vehicle", &of(&|r| r.position_m[2]), 0))
        .series(line("deck", &of(&|r| r.deck_m[2]), 5));
    let height = Panel::new("Time (s)", "Height z (m)")
        .series(line("true", &of(&|r| r.relative_m[2]), 0))
        .series(line(
            "estimated",
            &of(&|r| estimated(r, r.estimated_m[2])),
            1,
        ))
        .series(
            Series::dashed(
                "flown to",
                &time,
                &of(&|r| r.target.map_or(f64::NAN, |t| t[0])),
            )
            .color(Color::BLACK),
        );
    // Forecasts stand where they are for; before a harmonic is known they are zero.
    let known_deck = |r: &TraceRow, value: f64| {
        if r.forecast_deck_mps == 0.0 {
            f64::NAN
        } else {
            value
        }
    };
    let ahead = of(&|r| r.time_s + TraceRow::FORECAST_S);
    let end = time.last().copied().unwrap_or(0.0);
    let shown = ahead.iter().filter(|t| **t <= end).count();
    let bound = |sign: f64| {
        of(&|r| known_deck(r, r.forecast_deck_mps + sign * 2.0 * r.forecast_deck_sd_mps))
    };
    let (low, high) = (bound(-1.0), bound(1.0));
    let middle = of(&|r| known_deck(r, r.forecast_deck_mps));
    let deck = Panel::new("Time (s)", "Deck's heave (m/s)")
        .series(
            Series::band(
                "forecast ± 2 sd",
                &ahead[..shown],
                &low[..shown],
                &high[..shown],
            )
            .color(Color::Cycle(3)),
        )
        .series(line("true heave", &of(&|r| r.deck_mps[2]), 5))
        .series(line("estimated heave", &of(&estimated_deck_mps), 1))
        .series(
            Series::dashed("forecast 1 s before", &ahead[..shown], &middle[..shown])
                .color(Color::Cycle(3)),
        );
    let force = Panel::new("Time (s)", "Ground effect (N)")
        .series(line("true force", &of(&|r| r.ground_effect_n), 0))
        .series(line("counted on", &of(&|r| r.counted_ground_effect_n), 1));
    Figure::new("sea-track", "One landing on the heaving deck")
        .caption("Trial 0 of `heave`, as `planned`: what is true, what the landing computer believes and what it expected a second before.")
        .share_x()
        .size(900, 820)
        .panel(altitude)
        .panel(height)
        .panel(deck)
        .panel(force)
}
