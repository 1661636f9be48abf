//! Figures of a campaign.

use std::collections::BTreeMap;

use serde_json::Value;
use touchdown_campaign::statistics::Share;
use touchdown_campaign::sweep::{
    CampaignResults, Figures, LandingRow, Sweep, WorstLanding, number, text,
};
use touchdown_report::{Color, Figure, Panel, Scene, Series};
use touchdown_sim::landing::space::SpaceTrace;

use super::ended;
use crate::colors::of_controller;
use crate::page::{share_series, shares_below};
use crate::track::Track;

/// More points than this cannot be named on one axis.
const NAMED: usize = 8;
/// Colours of outcomes: those of the best and the worst level of the map, and one between.
const LANDED: Color = LEVELS[0].2;
const FIRST: Color = LEVELS[1].2;
const CRASHED: Color = LEVELS[4].2;
/// Points that a curve of a worst landing keeps: about one to a pixel, with all peaks. A page holds ten landings of 13
/// curves; twice as many points make it larger by 0.5 MB, half as many show in a zoom by two.
const POINTS: usize = 1200;
/// More curves than this in one panel are pooled by controller.
const CURVES: usize = 8;
/// The key of controllers.
const CONTROLLER: &str = "control.controller";

/// Landings that are drawn as one curve.
struct Group<'a> {
    name: String,
    controller: String,
    rows: Vec<&'a LandingRow>,
}

/// Shares of landings that land and that crash, point by point; none for a single point or for too many.
pub(super) fn outcomes(results: &CampaignResults) -> Option<Figure> {
    let points = &results.points;
    if points.len() < 2 || points.len() > NAMED {
        return None;
    }
    type Pick = fn(&Figures) -> Option<Share>;
    let lines: [(&str, Pick, Color); 3] = [
        ("landed", |f| f.landed, LANDED),
        ("landed in the first descent", |f| f.landed_at_first, FIRST),
        ("crashed", |f| f.crashed, CRASHED),
    ];
    let mut panel = Panel::new("Point", "Share of landings (%)")
        .categories(points.iter().map(|p| p.of.label()))
        .y_range(-4.0, 104.0);
    for (k, (name, pick, color)) in lines.into_iter().enumerate() {
        let at = |place: usize| place as f64 + 0.15 * (k as f64 - 1.0);
        let shares = points.iter().enumerate();
        let shares: Vec<(f64, Share)> = shares
            .filter_map(|(place, p)| Some((at(place), pick(&p.figures)?)))
            .collect();
        panel.series.extend(share_series(name, &shares, color));
    }
    let figure = Figure::new("outcomes", "How landings end, point by point");
    Some(
        figure
            .caption("Lines: 95 % interval of the share (Wilson).")
            .panel(panel),
    )
}

/// Landings in groups: by point, or by controller where points are many.
fn groups<'a>(sweep: &Sweep, rows: &'a [LandingRow], results: &CampaignResults) -> Vec<Group<'a>> {
    let pooled = results.points.len() > CURVES;
    let mut groups: Vec<Group<'a>> = Vec::new();
    let of_points = results
        .points
        .iter()
        .zip(rows.chunks(sweep.trials() as usize));
    for (point, rows) in of_points {
        let name = if pooled {
            point.of.controller.clone()
        } else {
            point.of.label()
        };
        match groups.iter_mut().find(|group| group.name == name) {
            Some(group) => group.rows.extend(rows),
            None => groups.push(Group {
                name,
                controller: point.of.controller.clone(),
                rows: rows.iter().collect(),
            }),
        }
    }
    groups
}

/// Cumulative distributions, a curve for each point, or for each controller where points are many.
pub(super) fn distributions(
    sweep: &Sweep,
    rows: &[LandingRow],
    results: &CampaignResults,
) -> Figure {
    let groups = groups(sweep, rows, results);
    let pool = match results.points.len() {
        0..=CURVES => "",
        _ => " All points of a controller are taken together.",
    };
    // Points of one controller need colours of their own.
    let by_controller = |i: usize| {
        let same = |group: &Group<'_>| group.controller == groups[i].controller;
        let alone = groups.iter().filter(|group| same(group)).count() == 1;
        of_controller(&groups[i].controller).filter(|_| alone)
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
        let mut panel = Panel::new(label, "Share (%)").y_range(0.0, 102.0);
        for (i, group) in groups.iter().enumerate() {
            let landed = group.rows.iter();
            let values = landed.filter(|r| r.landed()).filter_map(|r| r.number(name));
            let (values, shares) = shares_below(values);
            let legend = if row == 0 { group.name.as_str() } else { "" };
            let color = by_controller(i).unwrap_or(Color::Cycle(i));
            panel = panel.series(Series::steps(legend, &values, &shares).color(color));
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

/// The two swept keys that span the map of success; the controller only where there is no other.
fn map_keys(sweep: &Sweep) -> Option<[usize; 2]> {
    let keys: Vec<usize> = (0..sweep.grid().len())
        .filter(|&k| sweep.grid()[k].0 != CONTROLLER)
        .collect();
    match keys.as_slice() {
        [a, b, ..] => Some([*a, *b]),
        _ if sweep.grid().len() == 2 => Some([0, 1]),
        _ => None,
    }
}

/// Landed and flown at each place of a panel.
type Counts = BTreeMap<(String, usize, usize), (u64, u64)>;

fn counts(sweep: &Sweep, results: &CampaignResults, [a, b]: [usize; 2]) -> Counts {
    let apart = [a, b].iter().all(|k| sweep.grid()[*k].0 != CONTROLLER);
    let mut counts = Counts::new();
    for p in &results.points {
        let places = sweep.places(p.of.point);
        let panel = if apart {
            p.of.controller.clone()
        } else {
            String::new()
        };
        let cell = counts.entry((panel, places[a], places[b])).or_default();
        cell.0 += p.figures.landed.map_or(0, |s| s.count);
        cell.1 += p.figures.trials;
    }
    counts
}

/// Heights of the rows of the map: a number stands at its value, anything else at its place in the list, which is returned.
fn row_heights(values: &[toml::Value]) -> (Vec<f64>, String) {
    let numbers: Option<Vec<f64>> = values.iter().map(number).collect();
    let listed = values
        .iter()
        .enumerate()
        .map(|(i, v)| format!("{i}: {}", text(v)));
    match numbers {
        Some(numbers) => (numbers, String::new()),
        None => (
            (0..values.len()).map(|i| i as f64).collect(),
            format!(" ({})", listed.collect::<Vec<_>>().join(", ")),
        ),
    }
}

/// Success over two swept keys, where there are two; controllers in panels of their own, other keys pooled.
pub(super) fn success_map(sweep: &Sweep, results: &CampaignResults) -> Option<Figure> {
    let keys = map_keys(sweep)?;
    let counts = counts(sweep, results, keys);
    let [across, up] = keys.map(|k| &sweep.grid()[k]);
    let names = across
        .1
        .iter()
        .map(|v| text(v).chars().take(24).collect::<String>());
    let names: Vec<String> = names.collect();
    let (heights, scale) = row_heights(&up.1);
    let low = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let high = heights.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let margin = if high > low {
        0.7 * (high - low) / heights.len() as f64
    } else {
        1.0
    };
    let mut panels: Vec<&String> = counts.keys().map(|(panel, ..)| panel).collect();
    panels.dedup();
    let pooled = match sweep
        .grid()
        .iter()
        .filter(|(key, _)| key != CONTROLLER)
        .count()
    {
        0..=2 => "",
        _ => " Other swept keys are taken together.",
    };
    let height_px = 120 + panels.len() as u32 * (90 + 50 * heights.len() as u32);
    let mut figure = Figure::new("success", "Share of landings that landed")
        .caption(format!(
            "Across: `{}`; up: `{}`{scale}.{pooled}",
            across.0, up.0
        ))
        .size(900, height_px);
    for (i, name) in panels.iter().enumerate() {
        let mut panel = Panel::new(last_part(&across.0), last_part(&up.0))
            .categories(names.iter().cloned())
            .y_range(low - margin, high + margin);
        if !name.is_empty() {
            panel = panel.title((*name).clone());
        }
        let mut below = f64::INFINITY;
        for (least, legend, color) in LEVELS {
            let of_level = counts.iter().filter(|((of, ..), (landed, trials))| {
                let share = *landed as f64 / *trials as f64;
                of == *name && (least..below).contains(&share)
            });
            let (x, y): (Vec<f64>, Vec<f64>) = of_level
                .map(|((_, x, y), _)| (*x as f64, heights[*y]))
                .unzip();
            let legend = if i == 0 { legend } else { "" };
            panel = panel.series(Series::points(legend, &x, &y).color(color).width(9.0));
            below = least;
        }
        figure = figure.panel(panel);
    }
    Some(figure)
}

/// The last part of a dotted key.
fn last_part(key: &str) -> &str {
    key.rsplit('.').next().unwrap_or(key)
}

/// The worst landing to watch.
pub(super) fn watched(worst: &WorstLanding, landing: Value) -> Scene {
    Scene::new(
        "worst-watch",
        format!("The worst landing, {}: {}", worst.landing, ended(worst)),
    )
    .caption(
        "At most its last 20 s. The orange disc is the strength of the ground effect, the yellow bars are the forces on the feet.",
    )
    .landing(worst.of.label(), landing)
}

/// One of the worst landings over time.
pub(super) fn time_series(rank: usize, worst: &WorstLanding, trace: &SpaceTrace) -> Figure {
    let track = Track::of(trace);
    Figure::new(
        format!("worst-{rank:02}"),
        format!("Landing {}: {}", worst.landing, ended(worst)),
    )
    .caption(format!(
        "{}, trial {}. Height z and velocity v are relative to the deck, along its normal.",
        worst.of.label(),
        worst.trial
    ))
    .share_x()
    .size(900, 960)
    .panel(track.height())
    .panel(track.velocity())
    .panel(track.lateral())
    .panel(track.deck())
    .panel(track.ground_effect())
    .panel(track.feet())
    .thinned(POINTS)
}
