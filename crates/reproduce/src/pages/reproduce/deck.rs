//! IV-D: landing on the oscillating deck.

use touchdown_campaign::vertical::landings::LandingFigures;
use touchdown_report::{Cell, Color, Table};

use super::super::landings::{self, Cloud};
use super::verdict::{Ratio, ratio_text};
use crate::error::Result;
use crate::experiments::Run;
use crate::experiments::results::Results;
use touchdown_pages::colors::TRIALS;
use touchdown_pages::page::{Page, show, spread};

pub(super) fn write(page: &mut Page, run: &Run, results: &Results) -> Result<()> {
    let land = &run.settings.deck_landing;
    let landing = &run.landing;
    page.report
        .section("Landing on the oscillating deck (IV-D)");
    page.text(format!(
        "From {} m above a deck that moves in a sine. The same three methods, and two comparators that are reconstructions: `imbc`, \
         an internal model of a constant and one sine, and `ssc`, smooth sliding control. The paper leaves open whether the \
         deck's acceleration is fed forward, and it decides V_L, so both are shown; the acceleration comes from a harmonic \
         Kalman filter that knows the deck's frequency and looks {} s ahead. `imbc` has no such term: its landings stand in \
         both columns.",
        show(land.scenario.start_height_m, 2),
        show(land.control.deck_lead_s, 2)
    ));
    page.figure(landings::height_and_velocity(
        "fig7-deck-landing",
        "Relative height and velocity, acceleration fed forward (as the paper's Fig. 7)",
        "The first trial of each method: the same vehicle, air and deck. Dots: the landing; a curve without one had not landed by then.".into(),
        &landing.with_acceleration,
        land,
    ))?;
    page.table(table_one(run, results))?;
    page.folded_tables(
        "Ratios of dynamic to the comparators, and all figures",
        vec![
            ratios(results),
            landings::figures_table(
                "With the deck's acceleration fed forward: all figures.",
                &landing.with_acceleration,
            ),
            landings::figures_table("Without it: all figures.", &landing.without_acceleration),
        ],
    )?;
    page.figure(landings::height_and_velocity(
        "fig7-deck-landing-without-acceleration",
        "Relative height and velocity without the deck's acceleration",
        "The deck's motion stays in the relative velocity until the landing; V_L then depends on the phase in which the deck is met.".into(),
        &landing.without_acceleration,
        land,
    ))?;
    let clouds = [
        Cloud {
            name: "with acceleration",
            methods: &landing.with_acceleration,
            color: TRIALS,
        },
        Cloud {
            name: "without",
            methods: &landing.without_acceleration,
            color: Color::Rgb(0xC9, 0xA2, 0x66),
        },
    ];
    if let Some(figure) = landings::distribution(
        "deck-distribution",
        "Landing time and speed of every trial",
        "Each small point is a landing. Methods that landed in fewer than half of the trials are left out.".into(),
        &clouds,
        &|name| results.published.deck_landing.get(name).copied(),
    ) {
        page.figure(figure)?;
    }
    Ok(())
}

fn table_one(run: &Run, results: &Results) -> Table {
    let mut table = Table::new("Table I, in both readings, beside the paper's.")
        .text_column("Method")
        .text_column("Acceleration")
        .number_column("Landed", "")
        .number_column("T_L", "s")
        .number_column("Paper", "s")
        .number_column("V_L", "m/s")
        .number_column("Paper", "m/s")
        .number_column("S_L", "m")
        .number_column("Paper", "");
    for m in &run.landing.with_acceleration {
        let name = m.method.name();
        let printed = results.published.deck_landing.get(name).copied();
        let without = results.deck_landing.without_acceleration.get(name);
        let both: [(&str, Option<&LandingFigures>); 2] =
            [("yes", Some(&m.figures)), ("no", without)];
        for (row, (how, figures)) in both.into_iter().enumerate() {
            let Some(f) = figures else { continue };
            let paper = |v: Option<f64>, decimals| Cell::maybe(v.filter(|_| row == 0), decimals);
            table = table.row([
                if row == 0 {
                    name.into()
                } else {
                    Cell::text("")
                },
                how.into(),
                landings::landed(f),
                spread(f.t_l_s, 2),
                paper(printed.and_then(|p| p.t_l_s), 2),
                spread(f.v_l_mps, 3),
                paper(printed.and_then(|p| p.v_l_mps), 3),
                spread(f.s_l_m, 3),
                paper(printed.and_then(|p| p.s_l_published_unit), 2),
            ]);
        }
    }
    table.note(
        "Acceleration: whether the deck's is fed forward. Mean ± standard deviation over the trials that landed. The paper's S_L cannot be in metres: its descent is 0.4 m long.",
    )
}

fn ratios(results: &Results) -> Table {
    let deck = &results.deck_landing;
    let mut table = Table::new("`dynamic` relative to the comparators: ratios of means.")
        .text_column("Quantity")
        .text_column("Relative to")
        .number_column("Acceleration fed forward", "")
        .number_column("Not fed forward", "")
        .number_column("Paper", "");
    type Pick = fn(&LandingFigures) -> Option<touchdown_campaign::statistics::Summary>;
    type Printed = fn(&crate::experiments::results::PublishedFigures) -> Option<f64>;
    let quantities: [(&str, Pick, Printed); 3] = [
        ("T_L", |f| f.t_l_s, |p| p.t_l_s),
        ("V_L", |f| f.v_l_mps, |p| p.v_l_mps),
        ("S_L", |f| f.s_l_m, |p| p.s_l_published_unit),
    ];
    for (quantity, pick, printed) in quantities {
        for other in ["imbc", "ssc"] {
            let of = |figures: &std::collections::BTreeMap<&'static str, LandingFigures>| {
                let mean = |name: &str| figures.get(name).and_then(pick);
                Cell::text(ratio_text(Ratio::of(mean("dynamic"), mean(other))))
            };
            let paper = |name: &str| results.published.deck_landing.get(name).and_then(printed);
            let paper = paper("dynamic").zip(paper(other)).map(|(a, b)| a / b);
            table = table.row([
                quantity.into(),
                other.into(),
                of(&deck.with_acceleration),
                of(&deck.without_acceleration),
                Cell::maybe(paper, 3),
            ]);
        }
    }
    table.note("± is half the 95 % interval, from both means' intervals as if their trials were independent. Below one is in favour of `dynamic`.")
}
