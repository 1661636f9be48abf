//! IV-C: landing on the ground.

use touchdown_report::{Cell, Table};

use super::super::landings;
use super::verdict::{Ratio, ratio_text};
use crate::error::Result;
use crate::experiments::Run;
use crate::experiments::results::Results;
use touchdown_pages::page::{Page, show, spread};

pub(super) fn write(page: &mut Page, run: &Run, results: &Results) -> Result<()> {
    let land = &run.settings.ground_landing;
    page.report.section("Landing on the ground (IV-C)");
    page.text(landings::SYMBOLS);
    page.text(format!(
        "From {} m, landed at {} m, timeout {} s. `feedback` is the paper's Method I, eq. (10) without feedforward; `empirical` is \
         Method II, with eq. (2) fed forward; `dynamic` is Method III, with the lag form fed forward, all identified on the rig \
         above. Every trial draws its own strength of ground effect, thrust scale and air.",
        show(land.scenario.start_height_m, 2),
        show(land.scenario.landed_height_m, 2),
        show(land.scenario.timeout_s, 0)
    ));
    page.figure(landings::heights(
        "fig5c-ground-landing",
        "Height over time (as the paper's Fig. 5(c))",
        "Recorded trials of each method. Without feedforward the cushion of air holds the vehicle where it balances \
         the reference's pull; a feedforward that is too weak lets it sink slowly, one that is too strong lets it fall."
            .into(),
        &run.landing.ground,
        land,
    ))?;
    page.table(landings::figures_table(
        "Landings on the ground.",
        &run.landing.ground,
    ))?;
    let mut beside = Table::new("The same, beside the paper.")
        .text_column("Method")
        .number_column("T_L", "s")
        .number_column("Paper's T_L", "s")
        .number_column("Hover height", "m")
        .number_column("Paper's hover height", "m");
    for m in &run.landing.ground {
        let printed = results.published.ground_landing.get(m.method.name());
        beside = beside.row([
            m.method.name().into(),
            spread(m.figures.t_l_s, 2),
            Cell::maybe(printed.and_then(|p| p.t_l_s), 1),
            spread(m.figures.hover_height_m, 3),
            Cell::maybe(printed.and_then(|p| p.hover_height_m), 2),
        ]);
    }
    let time = |name| results.ground_landing.get(name).and_then(|f| f.t_l_s);
    page.table(beside.note(format!(
        "T_L of `dynamic` is calibrated through C. `dynamic` / `empirical`: {} (paper {}).",
        ratio_text(Ratio::of(time("dynamic"), time("empirical"))),
        show(5.1 / 7.1, 2)
    )))?;
    Ok(())
}
