//! The first page: what reproduces, what does not, what was calibrated and what is reconstructed.

use touchdown_report::Callout;

use super::super::page::{Page, maybe, show};
use super::printed;
use super::verdict::{Claim, FAILS, REPRODUCES, Ratio, ratio_text, table, verdict};
use crate::campaign::LandingFigures;
use crate::error::Result;
use crate::experiments::Run;
use crate::experiments::ground_effect::kind_of;
use crate::identify::settings::GroundEffectForm;
use crate::results::Results;
use crate::score::Errors;
use crate::statistics::Summary;

/// Hover height counts as reproduced within this (m).
const HOVER_TOLERANCE_M: f64 = 0.03;

pub(super) fn write(page: &mut Page, run: &Run, results: &Results) -> Result<()> {
    page.report.section("What reproduces and what does not");
    page.text(
        "The paper identifies how throttle makes thrust and how the ground adds to it, and feeds both forward in landing. No data \
         of its rig are public. So its procedure ran here on a virtual rig and a virtual vehicle, whose ground effect, motors and \
         air were taken from the literature and are not of the form of any model that is fitted. What can be compared are the \
         procedure, orders and ratios; coefficients cannot.",
    );
    let ge = &run.ground_effect;
    let deck = &results.deck_landing.with_acceleration;
    let time = |name| deck.get(name).and_then(|f: &LandingFigures| f.t_l_s);
    let hover = results
        .ground_landing
        .get("feedback")
        .and_then(|f| f.hover_height_m);
    page.report.highlights([
        [
            "Hover height of feedback".to_string(),
            format!("{} m", maybe(hover.map(|s| s.mean))),
            "paper: 0.15 m".to_string(),
        ],
        [
            "T_L on the deck, dynamic / imbc".to_string(),
            ratio_text(Ratio::of(time("dynamic"), time("imbc"))),
            "paper: 0.72".to_string(),
        ],
        [
            "Lag form, mean error in free run".to_string(),
            format!(
                "{} N",
                maybe(all_kinds(run, 1, GroundEffectForm::Lag).map(|e| e.mae))
            ),
            format!(
                "the measurement's own noise: {} N",
                maybe(Errors::pool(&ge.floor).map(|e| e.mae))
            ),
        ],
    ]);
    let claims = claims(run, results)?;
    page.table(table(&claims).note(
        "± is half the 95 % interval of a ratio of means. Verdicts are conditions on these figures, evaluated in every run. Direction: the \
         whole interval is below one (for V_L with and without the deck's acceleration). Size: at least three quarters of the \
         paper's gain, which is one minus the ratio. Undecided: the interval holds no gain as well as one of that size. Hover \
         height: none lands, mean within 3 cm.",
    ))?;
    page.report
        .list(claims.into_iter().map(|claim| claim.words));
    page.report.subsection("What was calibrated to the paper");
    page.report.list(sentences(&results.calibrated));
    page.report.subsection("What is reconstructed");
    page.report.list(sentences(&results.reconstructed));
    page.report.callout(
        Callout::Note,
        "Absolute times of `imbc` and `ssc` depend on gains that the paper does not print, so ratios to them are weaker evidence than \
         ratios to `feedback` and `empirical`.",
    );
    Ok(())
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
    let paper = 5.1 / 7.1;
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
            verdict: verdict(&beside(t, [0.721, 0.700])),
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
            verdict: verdict(
                &[beside(v, [0.419, 0.429]), beside(v_without, [0.419, 0.429])].concat(),
            ),
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
            verdict: verdict(&beside(s, [0.544, 0.780])),
            words: format!(
                "The path S_L of `dynamic` is {} m long, for a descent of 0.4 m; the ratios are {}. The paper's 12.89 cannot be metres.",
                maybe(figure(length).map(|m| m.mean)),
                text(s)
            ),
        },
    ]
}

/// Errors of a form over all validation trials.
pub(super) fn all_kinds(run: &Run, set: usize, form: GroundEffectForm) -> Option<Errors> {
    let model = GroundEffectForm::ALL.iter().position(|f| *f == form)?;
    let judged = &run.ground_effect.sets[set].errors[model];
    Errors::pool(&judged.iter().map(|j| j.truth).collect::<Vec<_>>())
}

fn models(run: &Run) -> [Claim; 2] {
    let ge = &run.ground_effect;
    let eq_9 = GroundEffectForm::ALL
        .iter()
        .position(|f| *f == GroundEffectForm::Derivative);
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
    let [eq2, map, eq9] = [
        GroundEffectForm::Empirical,
        GroundEffectForm::Static,
        GroundEffectForm::Derivative,
    ]
    .map(|form| mae(0, form));
    let rich = [GroundEffectForm::Static, GroundEffectForm::Lag].map(|form| show(mae(1, form), 3));
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
