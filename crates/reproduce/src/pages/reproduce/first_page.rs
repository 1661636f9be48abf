//! The first page: what reproduces, what does not, what was calibrated and what is reconstructed.

use touchdown_campaign::statistics::Summary;
use touchdown_campaign::vertical::landings::LandingFigures;
use touchdown_identify::scores::Errors;
use touchdown_model::Form;
use touchdown_report::Callout;

use super::printed;
use super::verdict::{self, Beside, Claim, FAILS, REPRODUCES, Ratio, ratio_text, verdict};
use crate::error::{Error, Result};
use crate::experiments::Run;
use crate::experiments::ground_effect::kind_of;
use crate::experiments::results::Results;
use touchdown_pages::page::{Page, maybe, show};

/// Hover height counts as reproduced within this (m).
const HOVER_TOLERANCE_M: f64 = 0.03;
/// The paper's T_L of `dynamic` over that of `empirical` on the ground.
const PAPER_GROUND_T_L: f64 = 5.1 / 7.1;
/// The paper's figures of `dynamic` on the deck over those of `imbc` and of `ssc` (Table I).
const PAPER_T_L: [f64; 2] = [0.721, 0.700];
const PAPER_V_L: [f64; 2] = [0.419, 0.429];
const PAPER_S_L: [f64; 2] = [0.544, 0.780];

pub(super) fn write(page: &mut Page, run: &Run, results: &Results) -> Result<()> {
    let claims = claims(run, results)?;
    let (kind, summary) = verdict::summary(&claims);
    let ratios = ratios(results);
    page.report
        .verdict(kind, format!("{summary} {}", sooner(&ratios)));
    page.figure(verdict::figure(&ratios))?;
    page.report.highlights(highlights(run, results));
    page.report.section("What reproduces and what does not");
    page.text(
        "The paper identifies how throttle makes thrust and how the ground adds to it. It feeds both forward in landing. No data \
         of its rig are public. So its procedure runs here on a virtual rig and a virtual vehicle. Their ground effect, motors and \
         air come from the literature, and no fitted model has their form. Procedure, orders and ratios can be compared; \
         coefficients cannot.",
    );
    page.table(verdict::table(&claims).note(
        "± is half the 95 % interval of a ratio of means. Verdicts are conditions on these figures, evaluated in every run. Direction: the \
         whole interval is below one (for V_L with and without the deck's acceleration). Size: at least three quarters of the \
         paper's gain, which is one minus the ratio. Undecided: the interval holds no gain as well as one of that size. Hover \
         height: none lands, mean within 3 cm.",
    ))?;
    let lists = [
        (
            "Each claim in words",
            claims.into_iter().map(|claim| claim.words).collect(),
        ),
        (
            "What was calibrated to the paper",
            sentences(&results.calibrated),
        ),
        ("What is reconstructed", sentences(&results.reconstructed)),
    ];
    for (summary, items) in lists {
        page.report.folded(summary, |inner| {
            inner.list::<String>(items);
            Ok::<(), Error>(())
        })?;
    }
    page.report.callout(
        Callout::Note,
        "Absolute times of `imbc` and `ssc` depend on gains that the paper does not print. Ratios to them are weaker evidence than \
         ratios to `feedback` and `empirical`.",
    );
    Ok(())
}

/// The paper's ratios beside those of this run: on the ground, then on the deck with its acceleration fed forward.
fn ratios(results: &Results) -> Vec<Beside> {
    type Pick = fn(&LandingFigures) -> Option<Summary>;
    let [t, v, s]: [Pick; 3] = [|f| f.t_l_s, |f| f.v_l_mps, |f| f.s_l_m];
    let (ground, deck) = (
        &results.ground_landing,
        &results.deck_landing.with_acceleration,
    );
    let paper_ground = PAPER_GROUND_T_L;
    [
        (ground, "T_L, ground", "empirical", t, paper_ground),
        (deck, "T_L, deck", "imbc", t, PAPER_T_L[0]),
        (deck, "T_L, deck", "ssc", t, PAPER_T_L[1]),
        (deck, "V_L, deck", "imbc", v, PAPER_V_L[0]),
        (deck, "V_L, deck", "ssc", v, PAPER_V_L[1]),
        (deck, "S_L, deck", "imbc", s, PAPER_S_L[0]),
        (deck, "S_L, deck", "ssc", s, PAPER_S_L[1]),
    ]
    .map(|(figures, quantity, other, pick, paper)| {
        let of = |name: &str| figures.get(name).and_then(pick);
        Beside {
            name: format!("{quantity} / {other}"),
            here: Ratio::of(of("dynamic"), of(other)),
            paper,
        }
    })
    .into()
}

/// How much sooner the identified model lands on the moving deck.
fn sooner(ratios: &[Beside]) -> String {
    let percent = |ratio: f64| show(100.0 * (1.0 - ratio), 0);
    let found = ratios.iter().find(|r| r.name.starts_with("T_L, deck"));
    match found.and_then(|r| Some((r.here?.value, r.paper))) {
        Some((here, paper)) => format!(
            "On the moving deck, `dynamic` lands {} % sooner than `imbc`; the paper reports {} %.",
            percent(here),
            percent(paper)
        ),
        None => "On the moving deck, `dynamic` or `imbc` does not land.".into(),
    }
}

fn highlights(run: &Run, results: &Results) -> [[String; 3]; 3] {
    let feedback = results.ground_landing.get("feedback");
    let hover = feedback.and_then(|f| f.hover_height_m);
    let landings: u64 = run.sea.landings.iter().map(|l| l.figures.trials).sum();
    let crashed = run.sea.landings.iter().filter_map(|l| l.figures.crashed);
    let crashed: u64 = crashed.map(|share| share.count).sum();
    let lag = all_kinds(run, 1, Form::Lag).map(|e| e.mae);
    let floor = Errors::pool(&run.ground_effect.floor).map(|e| e.mae);
    [
        [
            "Hover height of feedback".to_string(),
            format!("{} m", maybe(hover.map(|s| s.mean))),
            "paper: 0.15 m".to_string(),
        ],
        [
            "Lag form, mean error in free run".to_string(),
            format!("{} N", maybe(lag)),
            format!("noise of the measurement: {} N", maybe(floor)),
        ],
        [
            "Landings at sea".to_string(),
            landings.to_string(),
            format!("decks and faults; {crashed} crash"),
        ],
    ]
}

fn sentences<S: std::fmt::Display>(
    notes: &std::collections::BTreeMap<&'static str, S>,
) -> Vec<String> {
    notes
        .iter()
        .map(|(key, text)| format!("`{key}`: {text}."))
        .collect()
}

fn claims(run: &Run, results: &Results) -> Result<Vec<Claim>> {
    let mut claims = vec![hover(results), ground_order(results)];
    claims.extend(deck(results));
    claims.extend(models(run));
    claims.extend(printed::claims(run)?);
    Ok(claims)
}

fn hover(results: &Results) -> Claim {
    let f = results.ground_landing.get("feedback");
    let height = f.and_then(|f| f.hover_height_m);
    let (landed, trials) = f.map_or((0, 0), |f| (f.landed, f.trials));
    let same = height.is_some_and(|h| landed == 0 && (h.mean - 0.15).abs() <= HOVER_TOLERANCE_M);
    let height = maybe(height.map(|h| h.mean));
    Claim {
        what: "Hover height without feedforward",
        paper: "0.15 m".into(),
        here: format!("{height} m; {landed} of {trials} land"),
        verdict: if same {
            "**reproduces**, calibrated"
        } else {
            FAILS
        },
        words: format!(
            "Without feedforward (`feedback`) {landed} of {trials} vehicles land on the ground; the others hover at {height} m. The paper's hover \
             at 0.15 m. Weak evidence: the strength of ground effect was chosen with that figure in view."
        ),
    }
}

fn ground_order(results: &Results) -> Claim {
    let time = |name| results.ground_landing.get(name).and_then(|f| f.t_l_s);
    let (ours, empirical) = (time("dynamic"), time("empirical"));
    let ratio = Ratio::of(ours, empirical);
    let gain = |r: f64| 100.0 * (1.0 - r);
    let paper = PAPER_GROUND_T_L;
    Claim {
        what: "Ground: T_L of dynamic / empirical",
        paper: show(paper, 3),
        here: ratio_text(ratio),
        verdict: verdict(&[(ratio, paper)]),
        words: format!(
            "On the ground the identified dynamic model (`dynamic`) lands in {} s, eq. (2) (`empirical`) in {} s: {} % sooner, in the paper {} %.",
            mean(ours),
            mean(empirical),
            show(ratio.map_or(f64::NAN, |r| gain(r.value)), 0),
            show(gain(paper), 0)
        ),
    }
}

fn mean(summary: Option<Summary>) -> String {
    show(summary.map_or(f64::NAN, |s| s.mean), 2)
}

fn deck(results: &Results) -> [Claim; 3] {
    type Pick = fn(&LandingFigures) -> Option<Summary>;
    let ratios = |with: bool, pick: Pick| {
        let deck = &results.deck_landing;
        let figures = if with {
            &deck.with_acceleration
        } else {
            &deck.without_acceleration
        };
        let of = |name: &str| figures.get(name).and_then(pick);
        ["imbc", "ssc"].map(|other| Ratio::of(of("dynamic"), of(other)))
    };
    let text = |r: [Option<Ratio>; 2]| format!("{}, {}", ratio_text(r[0]), ratio_text(r[1]));
    let [time, speed, length]: [Pick; 3] = [|f| f.t_l_s, |f| f.v_l_mps, |f| f.s_l_m];
    let beside = |r: [Option<Ratio>; 2], paper: [f64; 2]| [(r[0], paper[0]), (r[1], paper[1])];
    let (t, s) = (ratios(true, time), ratios(true, length));
    let (v, v_without) = (ratios(true, speed), ratios(false, speed));
    let figure = |pick: Pick| {
        results
            .deck_landing
            .with_acceleration
            .get("dynamic")
            .and_then(pick)
    };
    let without_speed = results
        .deck_landing
        .without_acceleration
        .get("dynamic")
        .and_then(speed);
    [
        Claim {
            what: "Deck: T_L of dynamic / imbc, / ssc",
            paper: "0.721, 0.700".into(),
            here: text(t),
            verdict: verdict(&beside(t, PAPER_T_L)),
            words: format!(
                "On the deck `dynamic` lands in {} s. Its T_L is {} of that of `imbc` and `ssc`; in the paper 0.721, 0.700.",
                mean(figure(time)),
                text(t)
            ),
        },
        Claim {
            what: "Deck: V_L of dynamic / imbc, / ssc",
            paper: "0.419, 0.429".into(),
            here: text(v),
            verdict: verdict(&[beside(v, PAPER_V_L), beside(v_without, PAPER_V_L)].concat()),
            words: format!(
                "The paper's landing speed is about half that of the comparators. Here the ratios are {} with the deck's acceleration fed \
                 forward and {} without; with that term alone V_L of `dynamic` goes from {} to {} m/s. The paper does not say whether it has it.",
                text(v),
                text(v_without),
                maybe(without_speed.map(|s| s.mean)),
                maybe(figure(speed).map(|s| s.mean))
            ),
        },
        Claim {
            what: "Deck: S_L of dynamic / imbc, / ssc",
            paper: "0.544, 0.780".into(),
            here: text(s),
            verdict: verdict(&beside(s, PAPER_S_L)),
            words: format!(
                "The path S_L of `dynamic` is {} m long, for a descent of 0.4 m; the ratios are {}. The paper's 12.89 cannot be metres.",
                maybe(figure(length).map(|m| m.mean)),
                text(s)
            ),
        },
    ]
}

/// Errors of a form over all validation trials.
pub(super) fn all_kinds(run: &Run, set: usize, form: Form) -> Option<Errors> {
    let model = Form::GROUND_EFFECT.iter().position(|f| *f == form)?;
    let judged = &run.ground_effect.sets[set].errors[model];
    Errors::pool(&judged.iter().map(|j| j.truth).collect::<Vec<_>>())
}

fn models(run: &Run) -> [Claim; 2] {
    let ge = &run.ground_effect;
    let eq_9 = Form::GROUND_EFFECT
        .iter()
        .position(|f| *f == Form::Derivative);
    // The paper's bound is for each thrust level, on the approach and on the oscillation.
    let over_thrusts = |kind: &str| {
        let errors = eq_9.map_or(&[][..], |m| &ge.sets[0].errors[m]);
        ge.validation
            .iter()
            .zip(errors)
            .filter(|(t, _)| kind_of(&t.name) == kind)
            .map(|(_, judged)| judged.truth.mae)
            .fold(f64::NAN, f64::max)
    };
    let (oscillation, approach) = (over_thrusts("triangle_mid"), over_thrusts("approach"));
    let constant = super::ground_effect::constant(ge, "triangle_mid").map(|e| e.mae);
    let mae = |set, form| all_kinds(run, set, form).map_or(f64::NAN, |e| e.mae);
    let [eq2, map, eq9] =
        [Form::Empirical, Form::Static, Form::Derivative].map(|form| mae(0, form));
    let rich = [Form::Static, Form::Lag].map(|form| show(mae(1, form), 3));
    let map_is_as_good = map <= eq9;
    [
        Claim {
            what: "Ground effect: mean absolute error",
            paper: "within 0.2 N".into(),
            here: format!(
                "{} N, approach {} N",
                show(oscillation, 3),
                show(approach, 3)
            ),
            verdict: match (oscillation <= 0.2, approach <= 0.2) {
                (true, true) => REPRODUCES,
                (true, false) => "**reproduces** on the oscillation only",
                _ => FAILS,
            },
            words: format!(
                "The paper's bound on the mean error is for every thrust from 10 to 16 N. Eq. (9) by the paper's procedure on the paper's kind of \
                 data has a mean error of at most {} N in free run on the oscillation between 0.15 and 0.25 m, and of at most {} N on the slow \
                 approach. The bound is wide: on that oscillation a constant, each trial's own mean, has {} N.",
                show(oscillation, 3),
                show(approach, 3),
                maybe(constant)
            ),
        },
        Claim {
            what: "Ground effect: error of eq. (9) against eq. (2)",
            paper: "smaller (Fig. 1)".into(),
            here: format!("{} N, {} N", show(eq9, 3), show(eq2, 3)),
            verdict: match (eq9 < eq2, map_is_as_good) {
                (true, true) => "**reproduces**, not by dynamics",
                (true, false) => REPRODUCES,
                _ => FAILS,
            },
            words: format!(
                "Eq. (9) has a mean error of {} N, eq. (2) of {} N, but a static map T h(z) of the same data has {} N{}. On the rich data the \
                 static map has {} N, the lag form {} N.",
                show(eq9, 3),
                show(eq2, 3),
                show(map, 3),
                if map_is_as_good {
                    ": the gain is the shape of the curve, not its dynamics"
                } else {
                    ""
                },
                rich[0],
                rich[1]
            ),
        },
    ]
}
