//! Writes two figures and a report with every kind of block: `cargo run -p touchdown-report --example demo -- DIR`.

use std::path::PathBuf;

use touchdown_report::{Callout, Cell, Figure, Panel, Report, Result, Series, Table, Term};

const TERMS: [Term; 1] = [Term {
    names: &["T_L"],
    meaning: "The time from the start of the descent to the first touch.",
}];

fn main() -> std::result::Result<(), Box<dyn std::error::Error>> {
    let directory = PathBuf::from(std::env::args().nth(1).ok_or("usage: demo DIR")?);
    std::fs::create_dir_all(&directory)?;
    let figures = [approach(), methods(), errors(), track()];
    for figure in &figures {
        figure.write(&directory)?;
    }
    report(&figures)?.write(directory.join("report.html"))?;
    Ok(())
}

/// 20 000 samples with a gap, a band, references, two panels on one time axis.
fn approach() -> Figure {
    let t: Vec<f64> = (0..20_000).map(|i| 1e-3 * f64::from(i)).collect();
    let gap = |t: f64| (7.0..7.6).contains(&t);
    let on = |f: fn(f64) -> f64| -> Vec<f64> {
        t.iter()
            .map(|t| if gap(*t) { f64::NAN } else { f(*t) })
            .collect()
    };
    let height = on(|t| 0.05 + 1.2 * (-0.3 * t).exp() + 0.02 * (9.0 * t).sin());
    let reference: Vec<f64> = t.iter().map(|t| 0.05 + 1.2 * (-0.3 * t).exp()).collect();
    let lower: Vec<f64> = reference.iter().map(|z| z - 0.08).collect();
    let upper: Vec<f64> = reference.iter().map(|z| z + 0.08).collect();
    let thrust = on(|t| {
        12.0 + 2.0 * (1.0 - (-0.3 * t).exp()) + 0.3 * (9.0 * t).cos() + 0.1 * (171.0 * t).sin()
    });
    let held: Vec<f64> = (0..21).map(f64::from).collect();
    let command: Vec<f64> = held
        .iter()
        .map(|t| 12.0 + 2.0 * (1.0 - (-0.3 * t).exp()))
        .collect();
    Figure::new("approach", "Approach to the deck")
        .caption("Height above the deck and thrust. The logger lost 0.6 s at 7 s; the curves have a gap there.")
        .share_x()
        .panel(
            Panel::new("Time (s)", "Height above deck (m)")
                .title("Height")
                .series(Series::band("95 % of trials", &t, &lower, &upper))
                .series(Series::line("vehicle zₚ", &t, &height))
                .series(Series::dashed("reference", &t, &reference))
                .series(Series::horizontal("touchdown height", 0.1)),
        )
        .panel(
            Panel::new("Time (s)", "Thrust (N)")
                .title("Thrust")
                .series(Series::line("measured", &t, &thrust))
                .series(Series::steps("command", &held, &command))
                .series(Series::vertical("touchdown", 13.4)),
        )
}

fn methods() -> Figure {
    let position = [0.0, 1.0, 2.0, 3.0];
    Figure::new("methods", "Touchdown speed by method")
        .caption("Mean over 40 trials. `imbc` has no published value.")
        .size(900, 360)
        .panel(
            Panel::new("Method", "Touchdown speed (m/s)")
                .categories(["feedback", "empirical", "dynamic", "imbc"])
                .series(Series::bars("ours", &position, &[0.41, 0.33, 0.18, 0.26]))
                .series(Series::bars(
                    "published",
                    &position,
                    &[0.38, 0.31, 0.2, f64::NAN],
                )),
        )
}

fn errors() -> Figure {
    let n: Vec<f64> = (0..14).map(|i| 10.0 * 2f64.powi(i)).collect();
    let error: Vec<f64> = n.iter().map(|n| 3.0 / n.sqrt()).collect();
    let spread: Vec<f64> = error.iter().map(|e| 0.3 * e).collect();
    Figure::new("errors", "Error against number of samples")
        .caption("Both axes logarithmic; bars are one standard deviation.")
        .size(900, 400)
        .panel(
            Panel::new("Samples", "Error of coefficient ξ₂ (N s/m)")
                .log_x()
                .log_y()
                .series(Series::error_bars("fit", &n, &error, &spread))
                .series(Series::dotted("∝ 1/√n", &n, &error)),
        )
}

fn track() -> Figure {
    let angle: Vec<f64> = (0..400).map(|i| 0.05 * f64::from(i)).collect();
    let x: Vec<f64> = angle.iter().map(|a| (2.0 - 0.1 * a) * a.cos()).collect();
    let y: Vec<f64> = angle.iter().map(|a| (2.0 - 0.1 * a) * a.sin()).collect();
    let last = x.len() - 1;
    Figure::new("track", "Track seen from above")
        .size(900, 520)
        .panel(
            Panel::new("East (m)", "North (m)")
                .equal_aspect()
                .series(Series::line("track", &x, &y))
                .series(Series::points("touchdown", &x[last..], &y[last..]).width(3.0)),
        )
}

fn report(figures: &[Figure]) -> Result<Report> {
    let table = Table::new("Landings on a moving deck, 40 trials a method. Best in **bold**.")
        .text_column("Method")
        .number_column("Landed", "")
        .number_column("T_L", "s")
        .number_column("V_L", "m/s")
        .number_column("S_L", "m")
        .number_column("Published V_L", "m/s")
        .row([
            "feedback".into(),
            Cell::count(36),
            Cell::plus_minus(3.21, 0.4, 2),
            Cell::plus_minus(0.41, 0.06, 2),
            Cell::number(0.121, 3),
            Cell::number(0.38, 2),
        ])
        .row([
            "empirical".into(),
            Cell::count(39),
            Cell::plus_minus(2.84, 0.31, 2),
            Cell::plus_minus(0.33, 0.05, 2),
            Cell::number(0.094, 3),
            Cell::number(0.31, 2),
        ])
        .row([
            "dynamic".into(),
            Cell::count(40).bold(),
            Cell::plus_minus(2.12, 0.2, 2).bold(),
            Cell::plus_minus(0.18, 0.03, 2).bold(),
            Cell::number(0.041, 3).bold(),
            Cell::number(0.2, 2),
        ])
        .row([
            "imbc".into(),
            Cell::count(0),
            Cell::missing(),
            Cell::missing(),
            Cell::missing(),
            Cell::missing(),
        ])
        .note("Mean ± standard deviation. A dash stands where there is no value.");
    let mut report = Report::new("From thrust log to touchdown");
    report
        .subtitle("A demonstration of every block that a report can have")
        .fact("Version", env!("CARGO_PKG_VERSION"))
        .fact("Seed", "1")
        .fact("Trials", "40");
    report
        .glossary(&TERMS)
        .verdict(
            Callout::Success,
            "The method `dynamic` lands in 2.12 s: it is **faster** than all others.",
        )
        .figure(&figures[1])?
        .section("Summary")
        .highlights([
            ["Touchdown speed", "0.18 m/s", "published: 0.20 m/s"],
            ["Landed", "40 of 40", "method `dynamic`"],
            ["Model error", "0.11 N", "on unseen trials"],
        ])
        .paragraph("The method `dynamic` lands **softest** and fastest. Data are invented: x < 1 & y > 2 must survive.")
        .callout(Callout::Success, "All trials of `dynamic` landed.")
        .callout(Callout::Warning, "`imbc` never landed: its deck model does not fit this sea.")
        .table(table)?
        .section("Approach")
        .paragraph("Drag in a chart to zoom, double-click to go back, click a name to hide its curve.")
        .figure(&figures[0])?
        .section("Sample size")
        .figure(&figures[2])?
        .section("Track")
        .figure(&figures[3])?
        .section("How this was made")
        .list(["settings in `settings.toml`", "every random number from the seed"])
        .folded("The command", |inner| {
            inner.code("touchdown reproduce --out DIR --seed 1\n  --trials 40");
            Ok::<(), touchdown_report::Error>(())
        })?;
    Ok(report)
}
