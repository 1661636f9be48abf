//! Figures of a campaign.

use std::collections::BTreeMap;

use touchdown_report::{Color, Figure, Panel, Series};
use touchdown_sim::landing::space::{SpaceTrace, TraceRow};

use super::ended;
use crate::pages::page::shares_below;
use crate::pages::track::{estimated, estimated_deck_mps};
use crate::sweep::{CampaignResults, LandingRow, Sweep, WorstLanding, number, text};

/// More curves than this in one panel are pooled by controller.
const CURVES: usize = 8;
/// The key of controllers.
const CONTROLLER: &str = "control.controller";

/// Cumulative distributions, a curve for each point, or for each controller where points are many.
pub(super) fn distributions(
    sweep: &Sweep,
    rows: &[LandingRow],
    results: &CampaignResults,
) -> Figure {
    let pooled = results.points.len() > CURVES;
    let mut groups: Vec<(String, Vec<&LandingRow>)> = Vec::new();
    for (point, rows) in results
        .points
        .iter()
        .zip(rows.chunks(sweep.trials() as usize))
    {
        let name = if pooled {
            point.of.controller.clone()
        } else {
            point.of.label()
        };
        let place = groups
            .iter()
            .position(|(of, _)| *of == name)
            .unwrap_or_else(|| {
                groups.push((name, Vec::new()));
                groups.len() - 1
            });
        groups[place].1.extend(rows);
    }
    let pool = if pooled {
        " All points of a controller are taken together."
    } else {
        ""
    };
    let mut figure = Figure::new("distributions", "Share of landings below a value")
        .caption(format!("Landings that landed.{pool}"))
        .size(900, 840);
    for (row, (label, name)) in [
        ("T_L (s)", "t_l_s"),
        ("V_L (m/s)", "v_l_mps"),
        ("Lateral (m)", "lateral_m"),
    ]
    .into_iter()
    .enumerate()
    {
        let mut panel = Panel::new(label, "Share (%)").y_range(0.0, 100.0);
        for (i, (group, rows)) in groups.iter().enumerate() {
            let values = rows
                .iter()
                .filter(|r| r.landed())
                .filter_map(|r| r.number(name));
            let (values, shares) = shares_below(values);
            let legend = if row == 0 { group.as_str() } else { "" };
            panel = panel.series(Series::steps(legend, &values, &shares).color(Color::Cycle(i)));
        }
        figure = figure.panel(panel);
    }
    figure
}

/// Shares of success, with a colour each.
const LEVELS: [(f64, &str, Color); 5] = [
    (0.99, "99 % and more", Color::Rgb(0x1B, 0x78, 0x37)),
    (0.95, "95 % to 99 %", Color::Rgb(0x7F, 0xBF, 0x7B)),
    (0.80, "80 % to 95 %", Color::Rgb(0xE6, 0xC2, 0x29)),
    (0.50, "50 % to 80 %", Color::Rgb(0xE0, 0x7B, 0x28)),
    (0.0, "below 50 %", Color::Rgb(0xB0, 0x00, 0x30)),
];

/// Success over two swept keys, where there are two; controllers in panels of their own, other keys pooled.
pub(super) fn success_map(sweep: &Sweep, results: &CampaignResults) -> Option<Figure> {
    let keys: Vec<usize> = (0..sweep.grid().len())
        .filter(|&k| sweep.grid()[k].0 != CONTROLLER)
        .collect();
    let [a, b] = match keys.as_slice() {
        [a, b, ..] => [*a, *b],
        _ if sweep.grid().len() == 2 => [0, 1],
        _ => return None,
    };
    let apart = sweep.grid()[a].0 != CONTROLLER && sweep.grid()[b].0 != CONTROLLER;
    let mut cells: BTreeMap<(String, usize, usize), (u64, u64)> = BTreeMap::new();
    for p in &results.points {
        let places = sweep.places(p.of.point);
        let panel = if apart {
            p.of.controller.clone()
        } else {
            String::new()
        };
        let cell = cells.entry((panel, places[a], places[b])).or_default();
        *cell = (
            cell.0 + p.figures.landed.map_or(0, |s| s.count),
            cell.1 + p.figures.trials,
        );
    }
    let [across, up] = [a, b].map(|k| &sweep.grid()[k]);
    let names: Vec<String> = across
        .1
        .iter()
        .map(|v| text(v).chars().take(24).collect())
        .collect();
    // Numbers stand where they belong, anything else at its place in the list.
    let heights: Option<Vec<f64>> = up.1.iter().map(number).collect();
    let listed: Vec<String> =
        up.1.iter()
            .enumerate()
            .map(|(i, v)| format!("{i}: {}", text(v)))
            .collect();
    let (heights, scale) = heights.map_or_else(
        || {
            (
                (0..up.1.len()).map(|i| i as f64).collect(),
                format!(" ({})", listed.join(", ")),
            )
        },
        |heights: Vec<f64>| (heights, String::new()),
    );
    let (low, high) = heights
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(*v), high.max(*v))
        });
    let margin = if high > low {
        0.7 * (high - low) / heights.len() as f64
    } else {
        1.0
    };
    let last = |key: &str| key.rsplit('.').next().unwrap_or(key).to_string();
    let mut panels: Vec<&String> = cells.keys().map(|(panel, ..)| panel).collect();
    panels.dedup();
    let pooled = if keys.len() > 2 {
        " Other swept keys are taken together."
    } else {
        ""
    };
    let mut figure = Figure::new("success", "Share of landings that landed")
        .caption(format!(
            "Across: `{}`; up: `{}`{scale}.{pooled}",
            across.0, up.0
        ))
        .size(
            900,
            120 + panels.len() as u32 * (90 + 50 * heights.len() as u32),
        );
    for (i, name) in panels.iter().enumerate() {
        let mut panel = Panel::new(last(&across.0), last(&up.0))
            .categories(names.iter().cloned())
            .y_range(low - margin, high + margin);
        if !name.is_empty() {
            panel = panel.title((*name).clone());
        }
        for (level, (least, legend, color)) in LEVELS.iter().enumerate() {
            let below = if level == 0 {
                f64::INFINITY
            } else {
                LEVELS[level - 1].0
            };
            let (x, y): (Vec<f64>, Vec<f64>) = cells
                .iter()
                .filter(|((of, ..), (landed, trials))| {
                    let share = *landed as f64 / *trials as f64;
                    of == *name && share >= *least && share < below
                })
                .map(|((_, x, y), _)| (*x as f64, heights[*y]))
                .unzip();
            let legend = if i == 0 { *legend } else { "" };
            panel = panel.series(Series::points(legend, &x, &y).color(*color).width(9.0));
        }
        figure = figure.panel(panel);
    }
    Some(figure)
}

pub(super) fn time_series(rank: usize, worst: &WorstLanding, trace: &SpaceTrace) -> Figure {
    let rows = &trace.rows;
    let of = |pick: &dyn Fn(&TraceRow) -> f64| rows.iter().map(pick).collect::<Vec<f64>>();
    let time = of(&|r| r.time_s);
    let line = |name: &str, values: &[f64], color: usize| {
        Series::line(name, &time, values).color(Color::Cycle(color))
    };
    let wanted = |k: usize| of(&|r| r.target.map_or(f64::NAN, |t| t[k]));
    let height = Panel::new("Time (s)", "Height z (m)")
        .series(line("true", &of(&|r| r.relative_m[2]), 0))
        .series(line(
            "estimated",
            &of(&|r| estimated(r, r.estimated_m[2])),
            1,
        ))
        .series(Series::dashed("flown to", &time, &wanted(0)).color(Color::BLACK));
    let velocity = Panel::new("Time (s)", "v along the normal (m/s)")
        .series(line("", &of(&|r| r.relative_mps[2]), 0))
        .series(line("", &of(&|r| estimated(r, r.estimated_mps[2])), 1))
        .series(Series::dashed("", &time, &wanted(1)).color(Color::BLACK));
    let lateral = Panel::new("Time (s)", "Forward, port (m)")
        .series(line("forward", &of(&|r| r.relative_m[0]), 2))
        .series(line("port", &of(&|r| r.relative_m[1]), 3));
    let deck = Panel::new("Time (s)", "Deck's heave (m/s)")
        .series(line("true heave velocity", &of(&|r| r.deck_mps[2]), 4))
        .series(line(
            "estimated heave velocity",
            &of(&estimated_deck_mps),
            5,
        ));
    let force = Panel::new("Time (s)", "Force (N)")
        .series(line("ground effect", &of(&|r| r.ground_effect_n), 0))
        .series(line("counted on", &of(&|r| r.counted_ground_effect_n), 1))
        .series(line("feet", &of(&|r| r.feet_n.iter().sum()), 5));
    Figure::new(
        format!("worst-{rank:02}"),
        format!("Landing {}: {}", worst.landing, ended(worst)),
    )
    .caption(format!("{}, trial {}.", worst.of.label(), worst.trial))
    .share_x()
    .size(900, 860)
    .panel(height)
    .panel(velocity)
    .panel(lateral)
    .panel(deck)
    .panel(force)
}
