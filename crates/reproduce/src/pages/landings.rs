//! Tables and figures of landings.

use touchdown_campaign::statistics::Summary;
use touchdown_campaign::vertical::landings::LandingFigures;
use touchdown_flight::reference::Exponential;
use touchdown_report::{Callout, Cell, Color, Figure, Panel, Series, Table};
use touchdown_sim::landing::vertical::{Landing, Outcome};

use crate::experiments::landing::MethodLandings;
use crate::experiments::results::PublishedFigures;
use crate::settings::LandSettings;
use touchdown_pages::colors::{PUBLISHED, REFERENCE, of_method};
use touchdown_pages::page::{half_interval, show, spread};

/// What counts as landed.
pub(super) const SYMBOLS: &str = "Height `z` is that of the vehicle above the deck, and `v = dz/dt` is its relative velocity. A trial has landed when \
     `z` first reaches the landed height at no more than the crash speed; above half of that speed the landing is hard.";

/// Which method lands soonest and softest, and which do not always land.
pub(super) fn verdict(methods: &[MethodLandings]) -> (Callout, String) {
    let best = |pick: fn(&LandingFigures) -> Option<Summary>| {
        let means = methods.iter().filter(|m| lands_often(m));
        means
            .filter_map(|m| Some((m.method.name(), pick(&m.figures)?.mean)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
    };
    let missed: Vec<String> = methods
        .iter()
        .filter(|m| m.figures.landed < m.figures.trials)
        .map(|m| {
            format!(
                "`{}` lands in {} of {} trials",
                m.method.name(),
                m.figures.landed,
                m.figures.trials
            )
        })
        .collect();
    let missed = match missed.as_slice() {
        [] => "Every trial lands.".to_string(),
        missed => format!("{}.", missed.join(", ")),
    };
    let (Some((soon, t_l_s)), Some((soft, v_l_mps))) = (best(|f| f.t_l_s), best(|f| f.v_l_mps))
    else {
        return (
            Callout::Failure,
            format!("No method lands in half of its trials: {missed}"),
        );
    };
    let [t_l_s, v_l_mps] = [show(t_l_s, 2), show(v_l_mps, 3)];
    let lands = if methods.len() == 1 {
        format!("`{soon}` lands in {t_l_s} s at {v_l_mps} m/s.")
    } else if soon == soft {
        format!("`{soon}` lands soonest ({t_l_s} s) and softest ({v_l_mps} m/s).")
    } else {
        format!("`{soon}` lands soonest ({t_l_s} s), `{soft}` softest ({v_l_mps} m/s).")
    };
    let all = methods.iter().all(|m| m.figures.landed == m.figures.trials);
    let kind = if all {
        Callout::Success
    } else {
        Callout::Warning
    };
    (kind, format!("{lands} {missed}"))
}

/// Whether a method lands in half of its trials: the time axis of a figure is cut for those that do.
fn lands_often(m: &MethodLandings) -> bool {
    2 * m.figures.landed >= m.figures.trials
}

/// Mean, spread, interval and count of every method.
pub(super) fn figures_table(caption: impl Into<String>, methods: &[MethodLandings]) -> Table {
    let mut table = Table::new(caption)
        .text_column("Method")
        .number_column("Landed", "")
        .number_column("Hard", "")
        .number_column("Crashed", "")
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
            Cell::text(f.hard.to_string()),
            Cell::text(f.crashed.to_string()),
            spread(f.t_l_s, 2),
            half_interval(f.t_l_s, 2),
            spread(f.v_l_mps, 3),
            half_interval(f.v_l_mps, 3),
            spread(f.s_l_m, 3),
            half_interval(f.s_l_m, 3),
            spread(f.hover_height_m, 3),
        ]);
    }
    table.note(
        "Mean ± standard deviation over the trials that landed (hover height: those that timed out).",
    )
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
                    .color(of_method(m.method))
                    .width(1.1),
            );
        }
    }
    panel = panel
        .series(Series::dashed("reference", &reference[0], &reference[1]).color(REFERENCE))
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
        let (name, color) = (m.method.name(), of_method(m.method));
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

/// A figure of landings, and the paper's value of it.
struct Quantity {
    label: &'static str,
    of_landing: fn(&Landing) -> Option<f64>,
    printed: fn(&PublishedFigures) -> Option<f64>,
}

const QUANTITIES: [Quantity; 2] = [
    Quantity {
        label: "T_L (s)",
        of_landing: |l| l.t_l_s.filter(|_| l.outcome == Outcome::Landed),
        printed: |p| p.t_l_s,
    },
    Quantity {
        label: "V_L (m/s)",
        of_landing: |l| l.v_l_mps.filter(|_| l.outcome == Outcome::Landed),
        printed: |p| p.v_l_mps,
    },
];

/// Every trial's T_L and V_L as points, side by side, with the mean and its interval.
pub(super) fn distribution(
    id: &str,
    title: &str,
    caption: String,
    clouds: &[Cloud<'_>],
    published: &dyn Fn(&str) -> Option<PublishedFigures>,
) -> Option<Figure> {
    // A method that seldom lands would stretch the axis of time for the sake of a few points.
    let mut names: Vec<&str> = Vec::new();
    for m in clouds
        .iter()
        .flat_map(|c| c.methods)
        .filter(|m| lands_often(m))
    {
        if !names.contains(&m.method.name()) {
            names.push(m.method.name());
        }
    }
    if names.is_empty() {
        return None;
    }
    let mut figure = Figure::new(id, title).caption(caption).size(900, 620);
    for (row, quantity) in QUANTITIES.iter().enumerate() {
        // The legend of the first panel holds for both.
        let named = |name: &str| {
            if row == 0 {
                name.to_string()
            } else {
                String::new()
            }
        };
        let mut panel = Panel::new("Method", quantity.label).categories(names.iter().copied());
        for (c, cloud) in clouds.iter().enumerate() {
            let [points, means] = of_cloud(cloud, quantity, &names, [c, clouds.len()]);
            let last = c + 1 == clouds.len();
            let mean = if last {
                named("mean, 95 % interval")
            } else {
                String::new()
            };
            panel = panel
                .series(Series {
                    name: named(cloud.name),
                    ..points
                })
                .series(Series {
                    name: mean,
                    ..means
                });
        }
        let (x, y): (Vec<f64>, Vec<f64>) = names
            .iter()
            .enumerate()
            .filter_map(|(i, n)| Some((i as f64, (quantity.printed)(&published(n)?)?)))
            .unzip();
        if !x.is_empty() {
            panel = panel.series(
                Series::points(named("paper's mean"), &x, &y)
                    .color(PUBLISHED)
                    .width(3.4),
            );
        }
        let values = panel.series.iter().flat_map(|s| &s.y);
        let highest = values.fold(0.0_f64, |a, b| a.max(*b));
        figure = figure.panel(panel.y_range(0.0, 1.08 * highest));
    }
    Some(figure)
}

/// The trials of the `c`-th of several clouds as points beside the names of their methods, and their means.
fn of_cloud(
    cloud: &Cloud<'_>,
    quantity: &Quantity,
    names: &[&str],
    [c, clouds]: [usize; 2],
) -> [Series; 2] {
    let width = 0.8 / clouds as f64;
    let aside = (c as f64 - 0.5 * (clouds - 1) as f64) * width;
    let (mut x, mut y) = (Vec::new(), Vec::new());
    let (mut at, mut mean, mut half) = (Vec::new(), Vec::new(), Vec::new());
    for m in cloud.methods.iter().filter(|m| lands_often(m)) {
        let place = names.iter().position(|n| *n == m.method.name());
        let center = place.unwrap_or(0) as f64 + aside;
        let values: Vec<f64> = m.landings.iter().filter_map(quantity.of_landing).collect();
        // Multiples of the golden ratio spread points evenly, and the same way every time.
        let spread = |i: usize| (0.618_034 * i as f64).fract() - 0.5;
        x.extend((0..values.len()).map(|i| center - 0.05 + 0.5 * width * spread(i)));
        if let Some(s) = Summary::of(&values) {
            at.push(center + 0.33 * width);
            mean.push(s.mean);
            half.push(s.ci95.map_or(0.0, |[low, high]| 0.5 * (high - low)));
        }
        y.extend(values);
    }
    [
        Series::points("", &x, &y).color(cloud.color).width(1.8),
        Series::error_bars("", &at, &mean, &half)
            .color(Color::BLACK)
            .width(2.0),
    ]
}

fn traced(m: &MethodLandings) -> impl Iterator<Item = &Landing> {
    m.landings.iter().filter(|l| l.trace.is_some())
}

/// Until when there is something to see: a little after the last landing, and long enough to see a hover.
fn longest(methods: &[MethodLandings]) -> f64 {
    let last = methods
        .iter()
        .filter(|m| lands_often(m))
        .flat_map(|m| traced(m).filter_map(|l| l.t_l_s))
        .fold(0.0_f64, f64::max);
    let hovers = methods.iter().any(|m| !lands_often(m));
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
