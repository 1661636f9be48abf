//! Figures of the landings at sea.

use touchdown_campaign::statistics::Share;
use touchdown_campaign::sweep::Figures;
use touchdown_flight::Method;
use touchdown_report::{Color, Figure, Panel, Scene, Series};
use touchdown_sim::landing::space::{Case, SpaceTrace};

use super::words;
use crate::error::Result;
use crate::experiments::sea::{SeaExperiment, SeaMethod, SeaTrack};
use touchdown_pages::colors::of_method;
use touchdown_pages::page::{share_series, shares_below};
use touchdown_pages::track::Track;
use touchdown_pages::watch::{start_s, watch};

/// The colour of a way to land at sea: that of its controller, where the way is the controller's usual one.
fn of_how(how: SeaMethod) -> Color {
    match how {
        SeaMethod::Planned => of_method(Method::DynamicObserver),
        SeaMethod::StraightDown => Color::Cycle(4),
        SeaMethod::Published => of_method(Method::Dynamic),
    }
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
        .caption("Points: share of the trials; lines: its 95 % interval (Wilson). All faults are flown above the paper's deck; the last table explains each.")
        .size(900, 640);
    for (row, (label, pick)) in panels.into_iter().enumerate() {
        let mut panel = Panel::new("Deck or fault", label)
            .categories(cases.iter().map(|case| short(*case)))
            .y_range(-4.0, 104.0);
        for (k, how) in SeaMethod::ALL.into_iter().enumerate() {
            let at = |place: usize| place as f64 + 0.22 * (k as f64 - 1.0);
            let shares = cases.iter().enumerate();
            let shares: Vec<(f64, Share)> = shares
                .filter_map(|(place, case)| Some((at(place), pick(&sea.of(*case, how)?.figures)?)))
                .collect();
            let name = if row == 0 {
                words(how.name())
            } else {
                String::new()
            };
            panel
                .series
                .extend(share_series(&name, &shares, of_how(how)));
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
            panel = panel.series(Series::steps(name, &values, &shares).color(of_how(how)));
        }
        figure = figure.panel(panel);
    }
    figure
}

/// The first landing on the heaving deck to watch, as planned and as published.
///
/// # Errors
/// Records that are no landings to watch.
pub fn watched(tracks: &[SeaTrack]) -> Result<Scene> {
    let caption = "Trial 0 of `heave`, as `planned`; the ghost flies the paper's own set-up, `published`, above the same deck in the same air. \
                   The orange disc is the strength of the ground effect, the yellow bars are the forces on the feet.";
    let from_s = start_s(tracks.iter().map(|track| &track.trace));
    let scene = Scene::new("sea-watch", "Two landings to watch").caption(caption);
    tracks.iter().try_fold(scene, |scene, track| {
        let landing = watch(&track.scenario, &track.trace, from_s)?;
        Ok(scene.landing(words(track.how.name()), landing))
    })
}

/// One landing over the heaving deck.
pub(super) fn track(trace: &SpaceTrace) -> Figure {
    let track = Track::of(trace);
    let [band, forecast] = track.forecast();
    let mut deck = track.deck().series(forecast);
    deck.series.insert(0, band);
    Figure::new("sea-track", "One landing on the heaving deck")
        .caption("Trial 0 of `heave`, as `planned`: the true state, what the landing computer estimates, and its forecast of a second before.")
        .share_x()
        .size(900, 820)
        .panel(track.altitude())
        .panel(track.height())
        .panel(deck)
        .panel(track.ground_effect())
}
