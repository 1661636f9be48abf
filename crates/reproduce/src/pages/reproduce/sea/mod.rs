//! Landing at sea, in six degrees of freedom.

mod figures;

pub use figures::watched;

use touchdown_campaign::statistics::{Share, Summary};
use touchdown_campaign::sweep::Figures;
use touchdown_report::{Cell, Table};
use touchdown_sim::landing::space::Case;

use super::verdict::{Ratio, ratio_text};
use crate::error::Result;
use crate::experiments::Run;
use crate::experiments::sea::SeaMethod;
use crate::experiments::sea::{SeaExperiment, SeaLandings};
use touchdown_pages::page::{Page, half_interval, show, spread};

pub(super) fn write(page: &mut Page, run: &Run) -> Result<()> {
    let sea = &run.sea;
    let trials = run.settings.trials as u64;
    page.report
        .section("Landing at sea, in six degrees of freedom");
    page.text(format!(
        "The whole vehicle: a rigid body with four rotors, each over its own piece of a deck that moves and tilts, attitude control, \
         legs, battery, wind and sensors that are late and wrong (IMU, range, tag camera with the errors of a real detector, GNSS, \
         barometer). The models that it counts on are those identified above. `planned` is `dynamic+observer` with a planner \
         that waits for a calm window of the deck and plans the descent to meet it; `straight down` begins the same descent as \
         soon as the vehicle is ready; `published` is the paper's own set-up, `dynamic` with the exponential reference. {trials} \
         landings each (of every fault half as many), trial k in the same air everywhere; all are judged by the true state in the \
         deck's frame.",
    ));
    let measured = run.settings.sea.series.as_ref().map(|series| {
        let height = series.significant_height_m.map_or_else(String::new, |h| {
            format!(" scaled to {} m significant height", show(h, 2))
        });
        format!("`sea`: a measured motion{height}")
    });
    page.report.list([
        "`paper`: heave of 0.05 m at 0.5 Hz".to_string(),
        "`strong`: the same, and ground effect 60 % stronger than the models say".to_string(),
        "`heave`: 0.3 m at 0.2 Hz, with 3° of roll".to_string(),
        measured.unwrap_or_else(|| {
            "`sea`: a work boat's deck in waves that are random in every trial (settings below)"
                .into()
        }),
    ]);
    page.figure(figures::success(sea))?;
    page.report.subsection("What holds and what does not");
    page.report.list(claims(sea));
    let none = Share::of(0, trials).map_or(1.0, |share| share.ci95[1]);
    page.text(format!(
        "{trials} landings of a case are a glance: none of {trials} that fails leaves up to {} % (95 %), and a 99th percentile of so \
         few is little more than the greatest value. `touchdown campaign` flies thousands. What no landing here can show: \
         errors of sensors, sea and ship that these models of them do not have.",
        show(100.0 * none, 1)
    ));
    page.figure(figures::impact(sea))?;
    page.report.scene(figures::watched(&sea.tracks)?)?;
    if let Some(planned) = sea.tracks.first() {
        page.figure(figures::track(&planned.trace))?;
    }
    for table in [outcomes(sea), touches(sea), planner(sea), faults(sea)] {
        page.table(table)?;
    }
    Ok(())
}

fn of_decks(sea: &SeaExperiment) -> impl Iterator<Item = &SeaLandings> {
    let decks = sea.landings.iter();
    decks.filter(|l| Case::DECKS.contains(&l.case))
}

fn words(name: &str) -> String {
    name.replace('_', " ")
}

/// The case in the first row of it.
fn case(l: &SeaLandings) -> Cell {
    Cell::text(if l.how == SeaMethod::Planned {
        l.case.name()
    } else {
        ""
    })
}

fn count(share: Option<Share>) -> Cell {
    share.map_or_else(Cell::missing, |s| Cell::text(s.count.to_string()))
}

fn percent(share: Option<Share>) -> Cell {
    share.map_or_else(Cell::missing, |s| {
        Cell::text(format!(
            "{} ({}\u{a0}to\u{a0}{})",
            s.count,
            (100.0 * s.ci95[0]).round(),
            (100.0 * s.ci95[1]).round()
        ))
    })
}

fn degrees(value: Option<f64>) -> Cell {
    Cell::maybe(value.map(f64::to_degrees), 1)
}

fn outcomes(sea: &SeaExperiment) -> Table {
    let mut table = Table::new("Decks: how landings end, and how long they take.")
        .text_column("Deck")
        .text_column("Flown")
        .number_column("Trials", "")
        .number_column("Landed", "")
        .number_column("First", "")
        .number_column("Hard", "")
        .number_column("Crashed", "")
        .number_column("Waiting", "s")
        .number_column("T_L", "s")
        .number_column("CI", "s");
    for l in of_decks(sea) {
        let f = &l.figures;
        table = table.row([
            case(l),
            Cell::text(words(l.how.name())),
            Cell::text(f.trials.to_string()),
            percent(f.landed),
            percent(f.landed_at_first),
            percent(f.hard),
            percent(f.crashed),
            spread(f.waited_s.summary(), 2),
            spread(f.t_l_s.summary(), 2),
            half_interval(f.t_l_s.summary(), 2),
        ]);
    }
    table.note(
        "Counts; in brackets the 95 % interval of their share in % (Wilson). First: in the first descent. Hard: landed, with a touch above half of the crash speed. Waiting: to see the deck's motion and for a window, over all landings. T_L: from \
         the start of the last descent to the first touch, over those that landed; mean ± standard deviation. CI: half the 95 % \
         interval of the mean.",
    )
}

fn touches(sea: &SeaExperiment) -> Table {
    let mut table = Table::new("Decks: the touch.")
        .text_column("Deck")
        .text_column("Flown")
        .number_column("V_L", "m/s")
        .number_column("CI", "m/s")
        .number_column("99 %", "m/s")
        .number_column("S_L", "m")
        .number_column("Lateral 95 %", "m")
        .number_column("Tilt 95 %", "°");
    for l in of_decks(sea) {
        let f = &l.figures;
        table = table.row([
            case(l),
            Cell::text(words(l.how.name())),
            spread(f.v_l_mps.summary(), 3),
            half_interval(f.v_l_mps.summary(), 3),
            Cell::maybe(f.v_l_mps.p99, 3),
            spread(f.s_l_m.summary(), 3),
            Cell::maybe(f.lateral_m.p95, 3),
            degrees(f.impact_tilt_rad.p95),
        ]);
    }
    table.note(
        "V_L: speed along the deck's normal at the first touch. S_L = ∫|v| dt over the descent. Lateral: distance from the deck's centre. All \
         over the landings that landed, but tilt, which is over every touch, crashes too.",
    )
}

/// V_L of one way relative to another.
fn softer(sea: &SeaExperiment, case: Case, how: SeaMethod, than: SeaMethod) -> Option<Ratio> {
    let of = |how| sea.of(case, how)?.figures.v_l_mps.summary();
    Ratio::of(of(how), of(than))
}

/// One figure of the planned landings, the same of those that go straight down.
fn beside(of: [Option<f64>; 2], decimals: usize) -> Cell {
    let [a, b] = of.map(|v| show(v.unwrap_or(f64::NAN), decimals));
    Cell::text(format!("{a} / {b}"))
}

fn planner(sea: &SeaExperiment) -> Table {
    let mut table =
        Table::new("What the planner gains over going straight down: planned / straight down.")
            .text_column("Deck")
            .number_column("First attempt", "")
            .number_column("V_L", "m/s")
            .number_column("ratio", "")
            .number_column("V_L 99 %", "m/s")
            .number_column("Tilt 95 %", "°")
            .number_column("Before the descent", "s");
    for deck in Case::DECKS {
        let (Some(planned), Some(straight)) = (
            sea.of(deck, SeaMethod::Planned),
            sea.of(deck, SeaMethod::StraightDown),
        ) else {
            continue;
        };
        let both = [&planned.figures, &straight.figures];
        let first = both.map(|f| f.landed_at_first.map(|s| s.count as f64));
        table = table.row([
            Cell::text(deck.name()),
            beside(first, 0),
            beside(both.map(|f| f.v_l_mps.mean), 3),
            Cell::text(ratio_text(softer(
                sea,
                deck,
                SeaMethod::Planned,
                SeaMethod::StraightDown,
            ))),
            beside(both.map(|f| f.v_l_mps.p99), 3),
            beside(both.map(|f| f.impact_tilt_rad.p95.map(f64::to_degrees)), 1),
            beside([planned, straight].map(before), 1),
        ]);
    }
    table.note("Ratio of the mean V_L: below one, the planner's touch is softer; ± is half its 95 % interval, as if the trials were independent.")
}

/// Mean time from the start of a trial to that of the last descent, s.
fn before(l: &SeaLandings) -> Option<f64> {
    let times = l.rows.iter().filter_map(|r| r.number("before_descent_s"));
    Some(Summary::of(&times.collect::<Vec<f64>>())?.mean)
}

fn faults(sea: &SeaExperiment) -> Table {
    let mut table = Table::new("Faults above the paper's deck, as `planned`.")
        .text_column("Fault")
        .number_column("Landed", "")
        .number_column("First", "")
        .number_column("Crashed", "")
        .number_column("Unwarned", "")
        .number_column("V_L 99 %", "m/s")
        .number_column("Lateral 95 %", "m")
        .text_column("Go-arounds");
    for l in &sea.landings {
        if !Case::FAULTS.contains(&l.case) {
            continue;
        }
        let f = &l.figures;
        let aborts: Vec<String> = f
            .aborts
            .iter()
            .map(|(reason, count)| format!("{} {count}", words(reason)))
            .collect();
        let landed = f.landed.map_or(0, |s| s.count);
        table = table.row([
            Cell::text(l.case.description()),
            Cell::text(format!("{landed} of {}", f.trials)),
            count(f.landed_at_first),
            count(f.crashed),
            Cell::text(f.crashed_without_abort.to_string()),
            Cell::maybe(f.v_l_mps.p99, 3),
            Cell::maybe(f.lateral_m.p95, 3),
            if aborts.is_empty() {
                Cell::missing()
            } else {
                Cell::text(aborts.join(", "))
            },
        ]);
    }
    table.note(
        "Faults begin with the first descent or shortly after it. Go-arounds: descents broken off and hovers climbed away from. Unwarned: crashed without a go-around before. Those that \
         neither landed nor crashed gave up and hold, or still wait at the end of their time: how often is in `results.json`.",
    )
}

/// Conditions on the figures, evaluated in every run.
fn claims(sea: &SeaExperiment) -> Vec<String> {
    let mut out = Vec::new();
    let mut claim = |holds: Option<bool>, words: String| {
        let verdict = match holds {
            Some(true) => "**Holds**",
            Some(false) => "**Does not hold**",
            None => "**Undecided**",
        };
        out.push(format!("{verdict}: {words}"));
    };
    let all = |f: &Figures, share: Option<Share>| share.is_some_and(|s| s.count == f.trials);
    for deck in Case::DECKS {
        let Some(SeaLandings { figures: f, .. }) = sea.of(deck, SeaMethod::Planned) else {
            continue;
        };
        let number = |share: Option<Share>| share.map_or(0, |s| s.count);
        claim(
            Some(all(f, f.landed_at_first) && number(f.crashed) == 0),
            format!(
                "on `{}`, `planned` lands every time at the first attempt ({} of {} do, {} crash).",
                deck.name(),
                number(f.landed_at_first),
                f.trials,
                number(f.crashed)
            ),
        );
    }
    for (than, name) in [
        (SeaMethod::StraightDown, "going straight down"),
        (SeaMethod::Published, "the paper's set-up"),
    ] {
        for deck in Case::DECKS {
            let ratio = softer(sea, deck, SeaMethod::Planned, than).filter(|r| r.half.is_finite());
            let holds =
                ratio.and_then(|r| match (r.value + r.half < 1.0, r.value - r.half > 1.0) {
                    (true, _) => Some(true),
                    (_, true) => Some(false),
                    _ => None,
                });
            claim(
                holds,
                format!(
                    "on `{}`, `planned` touches softer than {name}: mean V_L {} of it.",
                    deck.name(),
                    ratio_text(ratio)
                ),
            );
        }
    }
    let faults = sea
        .landings
        .iter()
        .filter(|l| Case::FAULTS.contains(&l.case));
    let unwarned: u64 = faults.map(|l| l.figures.crashed_without_abort).sum();
    claim(
        Some(unwarned == 0),
        format!("no fault ends in a crash without an abort before ({unwarned} do)."),
    );
    out
}
