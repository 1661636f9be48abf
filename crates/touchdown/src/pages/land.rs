//! The report of `touchdown land`.

use std::path::Path;

use touchdown_report::{Callout, Color};

use super::landings::{self, Cloud};
use super::page::{Page, show};
use crate::error::Result;
use crate::experiments::landing::MethodLandings;
use crate::scenario::LandScenario;
use crate::settings::to_toml;

/// Writes `figures/*.svg`, `figures/*.png` and `report.html` of the landings of `methods` into the folder `out`.
///
/// # Errors
/// Files that cannot be written, or figures that cannot be drawn.
pub fn land(methods: &[MethodLandings], scenario: &LandScenario, out: &Path) -> Result<()> {
    let land = scenario.land();
    let mut page = Page::new("Landings", out);
    page.report
        .subtitle(
            "One scenario, one controller after the other, the same vehicles and the same air",
        )
        .fact("Version", env!("CARGO_PKG_VERSION"))
        .fact("Seed", scenario.seed.to_string())
        .fact("Landings of each method", scenario.trials.to_string());
    page.report.section("Landings");
    page.text(landings::SYMBOLS);
    page.text(format!(
        "Start at {} m, landed at {} m, timeout {} s. The deck's acceleration is {}.",
        show(land.scenario.start_height_m, 2),
        show(land.scenario.landed_height_m, 2),
        show(land.scenario.timeout_s, 0),
        if scenario.deck_acceleration {
            "estimated and fed forward, where the deck moves in a sine (never for `imbc`)"
        } else {
            "not fed forward"
        }
    ));
    for m in methods {
        let f = &m.figures;
        if f.landed < f.trials {
            let kind = if f.landed == 0 {
                Callout::Failure
            } else {
                Callout::Warning
            };
            page.report.callout(
                kind,
                format!(
                    "`{}` landed in {} of {} trials.",
                    m.method.name(),
                    f.landed,
                    f.trials
                ),
            );
        }
    }
    page.table(landings::figures_table("Landings by method.", methods))?;
    page.figure(landings::heights(
        "heights",
        "Height over time",
        "The first recorded trials of each method, with the reference that all of them follow."
            .into(),
        methods,
        &land,
    ))?;
    page.figure(landings::height_and_velocity(
        "height-velocity",
        "Relative height and velocity of the first trial",
        "The same vehicle, air and deck for each method. Dots: the landing.".into(),
        methods,
        &land,
    ))?;
    let cloud = Cloud {
        name: "trials",
        methods,
        color: Color::Cycle(5),
    };
    if let Some(figure) = landings::distribution(
        "distribution",
        "Landing time and speed of every trial",
        "Methods that landed in fewer than half of the trials are left out.".into(),
        &[cloud],
        &|_| None,
    ) {
        page.figure(figure)?;
    }
    page.report.section("How to redo this");
    page.report.code("touchdown land scenario.toml --out DIR");
    page.text("`scenario.toml`:");
    page.report.code(to_toml(scenario)?);
    page.finish()
}
