//! Tables and figures of landings.

use touchdown_flight::reference::Exponential;
use touchdown_report::{Cell, Color, Figure, Panel, Series, Table};
use touchdown_sim::landing::vertical::Landing;

use super::page::{PUBLISHED, half_interval, method_color, spread};
use crate::campaign::LandingFigures;
use crate::experiments::landing::MethodLandings;
use crate::results::PublishedFigures;
use crate::settings::LandSettings;

/// The symbols of landings, each defined once.
pub(super) const SYMBOLS: &str = "Height `z` is that of the vehicle above the deck, `v = dz/dt` its relative velocity. A trial has landed when z \
     first falls to the landed height; `T_L` is the time of that, `V_L` the relative speed |v| then, `S_L = ∫|v| dt` until \
     then. A trial that has not landed by the timeout has none of them: it has a hover height, the mean z over its last 5 s.";

/// Mean, spread, interval and count of every method.
pub(super) fn figures_table(caption: impl Into<String>, methods: &[MethodLandings]) -> Table {
    let mut table = Table::new(caption)
        .text_column("Method")
        .number_column("Landed", "")
        .number_column("T_L", "s")
        .number_column("CI", "s")
        .number_column("V_L", "m/s")
        .number_column("CI", "m/s")
        .number_column("S_L", "m")
        .number_column("CI", "m")
        .number_column("Hover", "m");
    for m in methods {
        let f = &m.figures;
        table = table.row([
            m.method.name().into(),
            landed(f),
            spread(f.t_l_s, 2),
            half_interval(f.t_l_s, 2),
            spread(f.v_l_mps, 3),
            half_interval(f.v_l_mps, 3),
            spread(f.s_l_m, 3),
            half_interval(f.s_l_m, 3),
            spread(f.hover_height_m, 3),
        ]);
    }
    table.note("Mean ± standard deviation over the trials that landed (hover height: those that did not). CI: half the 95 % interval of the mean (Student's t).")
}

/// `landed of trials`.
pub(super) fn landed(f: &LandingFigures) -> Cell {
    Cell::text(format!("{} of {}", f.landed, f.trials))
}

/// Heights of all recorded landings, for comparison with the reference of eq. (13).
pub(super) fn heights(
    id: &str,
    title: &str,
    caption: String,
    methods: &[MethodLandings],
    land: &LandSettings,
) -> Figure {
    let end = longest(methods);
    let reference = reference(land, end);
    let mut panel = Panel::new("Time (s)", "Height above the deck z (m)").x_range(0.0, end);
    for m in methods {
        for (i, landing) in traced(m).enumerate() {
            let Some(trace) = &landing.trace else {
                continue;
            };
            let name = if i == 0 { m.method.name() } else { "" };
            panel = panel.series(
                Series::line(name, &trace.time_s, &trace.height_m)
                    .color(method_color(m.method))
                    .width(1.1),
            );
        }
    }
    panel = panel
        .series(Series::dashed("reference", &reference[0], &reference[1]).color(Color::BLACK))
        .series(Series::horizontal("landed", land.scenario.landed_height_m));
    Figure::new(id, title)
        .caption(caption)
        .size(900, 440)
        .panel(panel)
}

/// One landing of each method: relative height and relative velocity, landing marked.
pub(super) fn height_and_velocity(
    id: &str,
    title: &str,
    caption: String,
    methods: &[MethodLandings],
    land: &LandSettings,
) -> Figure {
    let end = longest(methods);
    let mut height = Panel::new("Time (s)", "Height z (m)").x_range(0.0, end);
    let mut velocity = Panel::new("Time (s)", "Relative velocity v (m/s)").x_range(0.0, end);
    let mut marks = [Vec::new(), Vec::new(), Vec::new()];
    for m in methods {
        let Some((landing, trace)) = traced(m).find_map(|l| Some((l, l.trace.as_ref()?))) else {
            continue;
        };
        let (name, color) = (m.method.name(), method_color(m.method));
        height = height.series(Series::line(name, &trace.time_s, &trace.height_m).color(color));
        velocity = velocity
            .series(Series::line("", &trace.time_s, &trace.relative_velocity_mps).color(color));
        if let (Some(t), Some(v)) = (landing.t_l_s, landing.v_l_mps) {
            marks[0].push(t);
            marks[1].push(land.scenario.landed_height_m);
            marks[2].push(-v);
        }
    }
    let mark = |name: &str, values: &[f64]| {
        Series::points(name, &marks[0], values)
            .color(Color::BLACK)
            .width(2.6)
    };
    height = height
        .series(mark("landing", &marks[1]))
        .series(Series::horizontal("", land.scenario.landed_height_m));
    velocity = velocity
        .series(mark("", &marks[2]))
        .series(Series::horizontal("", 0.0));
    Figure::new(id, title)
        .caption(caption)
        .share_x()
        .size(900, 620)
        .panel(height)
        .panel(velocity)
}

/// One set of landings in a figure of distributions.
pub(super) struct Cloud<'a> {
    pub(super) name: &'a str,
    pub(super) methods: &'a [MethodLandings],
    pub(super) color: Color,
}

/// Every trial's T_L and V_L as points, side by side, with the mean and its interval.
pub(super) fn distribution(
    id: &str,
    title: &str,
    caption: String,
    clouds: &[Cloud<'_>],
    published: &dyn Fn(&str) -> Option<PublishedFigures>,
) -> Option<Figure> {
    // A method that seldom lands would stretch the axis of time for the sake of a few points.
    let often = |m: &MethodLandings| 2 * m.figures.landed >= m.figures.trials;
    let mut names: Vec<&str> = Vec::new();
    for m in clouds.iter().flat_map(|c| c.methods).filter(|m| often(m)) {
        if !names.contains(&m.method.name()) {
            names.push(m.method.name());
        }
    }
    if names.is_empty() {
        return None;
    }
    type Pick = fn(&Landing) -> Option<f64>;
    type Printed = fn(&PublishedFigures) -> Option<f64>;
    let quantities: [(&str, Pick, Printed); 2] = [
        ("T_L (s)", |l| l.t_l_s, |p| p.t_l_s),
        ("V_L (m/s)", |l| l.v_l_mps, |p| p.v_l_mps),
    ];
    let width = 0.8 / clouds.len() as f64;
    let mut figure = Figure::new(id, title).caption(caption).size(900, 620);
    for (row, (label, pick, printed)) in quantities.into_iter().enumerate() {
        let mut panel = Panel::new("Method", label).categories(names.iter().copied());
        let first = |name: &str| {
            if row == 0 {
                name.to_string()
            } else {
                String::new()
            }
        };
        for (c, cloud) in clouds.iter().enumerate() {
            let (mut points, mut means) = (
                [Vec::new(), Vec::new()],
                [Vec::new(), Vec::new(), Vec::new()],
            );
            for m in cloud.methods.iter().filter(|m| often(m)) {
                let place = names
                    .iter()
                    .position(|n| *n == m.method.name())
                    .unwrap_or(0) as f64;
                let center = place + (c as f64 - 0.5 * (clouds.len() - 1) as f64) * width;
                let values: Vec<f64> = m.landings.iter().filter_map(pick).collect();
                for (i, v) in values.iter().enumerate() {
                    // The golden ratio spreads points evenly, and the same way every time.
                    let spread = (0.618_034 * i as f64).fract() - 0.5;
                    points[0].push(center - 0.05 + 0.5 * width * spread);
                    points[1].push(*v);
                }
                if let Some(s) = crate::statistics::Summary::of(&values) {
                    means[0].push(center + 0.33 * width);
                    means[1].push(s.mean);
                    means[2].push(s.ci95.map_or(0.0, |[low, high]| 0.5 * (high - low)));
                }
            }
            let [x, y] = points;
            panel = panel.series(
                Series::points(first(cloud.name), &x, &y)
                    .color(cloud.color)
                    .width(1.3),
            );
            let name = if c + 1 == clouds.len() {
                first("mean, 95 % interval")
            } else {
                String::new()
            };
            panel = panel.series(
                Series::error_bars(name, &means[0], &means[1], &means[2])
                    .color(Color::BLACK)
                    .width(2.0),
            );
        }
        let (x, y): (Vec<f64>, Vec<f64>) = names
            .iter()
            .enumerate()
            .filter_map(|(i, n)| Some((i as f64, printed(&published(n)?)?)))
            .unzip();
        if !x.is_empty() {
            panel = panel.series(
                Series::points(first("paper's mean"), &x, &y)
                    .color(PUBLISHED)
                    .width(3.4),
            );
        }
        let highest = panel
            .series
            .iter()
            .flat_map(|s| &s.y)
            .fold(0.0_f64, |a, b| a.max(*b));
        figure = figure.panel(panel.y_range(0.0, 1.08 * highest));
    }
    Some(figure)
}

fn traced(m: &MethodLandings) -> impl Iterator<Item = &Landing> {
    m.landings.iter().filter(|l| l.trace.is_some())
}

/// Until when there is something to see: a little after the last landing, and long enough to see a hover.
fn longest(methods: &[MethodLandings]) -> f64 {
    let often = |m: &&MethodLandings| 2 * m.figures.landed >= m.figures.trials;
    let last = methods
        .iter()
        .filter(often)
        .flat_map(|m| traced(m).filter_map(|l| l.t_l_s))
        .fold(0.0_f64, f64::max);
    let hovers = methods.iter().any(|m| !often(&m));
    (1.1 * last).ceil().max(if hovers { 12.0 } else { 1.0 })
}

fn reference(land: &LandSettings, end: f64) -> [Vec<f64>; 2] {
    let curve = Exponential {
        c_per_s: land.control.c_per_s,
        start_height_m: land.scenario.start_height_m,
        end_height_m: land.control.end_height_m,
    };
    let time: Vec<f64> = (0..=300).map(|i| end * f64::from(i) / 300.0).collect();
    let height = time.iter().map(|t| curve.at(*t).height_m).collect();
    [time, height]
}
