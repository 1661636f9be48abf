//! Verdicts: conditions on figures, never words written beforehand.

use touchdown_campaign::statistics::Summary;
use touchdown_flight::Method;
use touchdown_report::{Callout, Cell, Figure, Panel, Series, Table};

use touchdown_pages::colors::{PUBLISHED, of_method};
use touchdown_pages::page::show;

/// Share of the paper's gain from which a size counts as reproduced.
const SHARE_OF_GAIN: f64 = 0.75;

/// How a ratio compares with the paper's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Comparison {
    /// Its whole interval is below one, and the gain is of the paper's size.
    Size,
    /// Its whole interval is below one, but the gain is smaller.
    Direction,
    /// Its interval holds both no gain and a gain of the paper's size.
    Undecided,
    /// Its interval holds no gain, and none of the paper's size.
    Fails,
}

/// A ratio of two means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Ratio {
    pub(super) value: f64,
    /// Half the 95 % interval, by propagation of both intervals as if the trials were independent.
    pub(super) half: f64,
}

impl Ratio {
    pub(super) fn of(a: Option<Summary>, b: Option<Summary>) -> Option<Self> {
        let (a, b) = (a?, b?);
        let relative = |s: Summary| {
            s.ci95
                .map_or(f64::NAN, |[low, high]| 0.5 * (high - low) / s.mean)
        };
        let value = a.mean / b.mean;
        Some(Self {
            value,
            half: value * relative(a).hypot(relative(b)),
        })
    }

    /// Comparison of the ratio with the paper's, which is below one.
    pub(super) fn beside(self, paper: f64) -> Comparison {
        let enough = 1.0 - SHARE_OF_GAIN * (1.0 - paper);
        let [low, high] = [self.value - self.half, self.value + self.half];
        match (high < 1.0, self.value <= enough) {
            _ if self.half.is_nan() => Comparison::Undecided,
            (true, true) => Comparison::Size,
            (true, false) => Comparison::Direction,
            (false, _) if low <= enough => Comparison::Undecided,
            (false, _) => Comparison::Fails,
        }
    }

    pub(super) fn shown(self) -> String {
        Cell::plus_minus(self.value, self.half, 2)
            .shown()
            .to_string()
    }
}

/// The ratio in words, or a dash.
pub(super) fn ratio_text(ratio: Option<Ratio>) -> String {
    ratio.map_or_else(|| show(f64::NAN, 2), Ratio::shown)
}

/// One line of the first page.
pub(super) struct Claim {
    /// What is compared.
    pub(super) what: &'static str,
    /// The paper's figure.
    pub(super) paper: String,
    /// Ours.
    pub(super) here: String,
    /// In a few words; bold where it is plain.
    pub(super) verdict: &'static str,
    /// The same in a sentence.
    pub(super) words: String,
}

/// Holds in full.
pub(super) const REPRODUCES: &str = "**reproduces**";
/// Does not hold.
pub(super) const FAILS: &str = "**does not reproduce**";

/// The verdict on a claim of one or more ratios; a ratio is absent where a method did not land.
pub(super) fn verdict(ratios: &[(Option<Ratio>, f64)]) -> &'static str {
    let found: Option<Vec<Comparison>> = ratios
        .iter()
        .map(|(ratio, paper)| ratio.map(|r| r.beside(*paper)))
        .collect();
    let Some(found) = found else {
        return "no figure: none landed";
    };
    let any = |what| found.contains(&what);
    match (any(Comparison::Size), any(Comparison::Direction)) {
        _ if any(Comparison::Fails) => FAILS,
        _ if any(Comparison::Undecided) => "undecided: too few trials",
        (true, false) => REPRODUCES,
        (true, true) => "direction; size in part",
        (false, _) => "direction, not size",
    }
}

/// How many claims hold, in a sentence.
pub(super) fn summary(claims: &[Claim]) -> (Callout, String) {
    let count = |holds: fn(&str) -> bool| claims.iter().filter(|c| holds(c.verdict)).count();
    let full = count(|v| v.starts_with(REPRODUCES));
    let part = count(|v| v.starts_with("direction"));
    let open = count(|v| v.starts_with("undecided") || v.starts_with("no figure"));
    let fails = claims.len() - full - part - open;
    let kind = if full == claims.len() {
        Callout::Success
    } else {
        Callout::Warning
    };
    let rest = [
        (part, "reproduce in direction only or in part"),
        (fails, "do not reproduce"),
        (open, "stay undecided"),
    ];
    let rest = rest.iter().filter(|(n, _)| *n > 0);
    let rest: String = rest.map(|(n, what)| format!(", {n} {what}")).collect();
    (
        kind,
        format!(
            "{full} of {} claims of the paper reproduce{rest}.",
            claims.len()
        ),
    )
}

/// A ratio of two methods beside the paper's.
pub(super) struct Beside {
    pub(super) name: String,
    pub(super) here: Option<Ratio>,
    pub(super) paper: f64,
}

/// The ratios with their intervals, and the paper's.
pub(super) fn figure(ratios: &[Beside]) -> Figure {
    let at = |i: usize, aside: f64| i as f64 + aside;
    let here: Vec<(f64, Ratio)> = ratios
        .iter()
        .enumerate()
        .filter_map(|(i, r)| Some((at(i, -0.06), r.here?)))
        .collect();
    let (x, y): (Vec<f64>, Vec<f64>) = here.iter().map(|(at, r)| (*at, r.value)).unzip();
    let half: Vec<f64> = here.iter().map(|(_, r)| r.half).collect();
    let paper_x: Vec<f64> = (0..ratios.len()).map(|i| at(i, 0.06)).collect();
    let paper: Vec<f64> = ratios.iter().map(|r| r.paper).collect();
    let highest = y
        .iter()
        .zip(&half)
        .map(|(y, h)| y + h.max(0.0))
        .fold(1.0, f64::max);
    let panel = Panel::new(
        "Quantity / method that dynamic is compared with",
        "dynamic relative to it",
    )
    .categories(ratios.iter().map(|r| r.name.as_str()))
    .y_range(0.0, 1.1 * highest)
    .series(
        Series::error_bars("here, with 95 % interval", &x, &y, &half)
            .color(of_method(Method::Dynamic))
            .width(3.0),
    )
    .series(
        Series::points("paper", &paper_x, &paper)
            .color(PUBLISHED)
            .width(3.4),
    )
    .series(Series::horizontal("no difference", 1.0));
    Figure::new("claims", "The identified model against the other methods")
        .caption("Below one, `dynamic` is better: it lands sooner (T_L), softer (V_L) or on a shorter path (S_L).")
        .size(900, 380)
        .panel(panel)
}

pub(super) fn table(claims: &[Claim]) -> Table {
    let mut table = Table::new("Results of the paper and of these runs.")
        .text_column("Compared")
        .text_column("Paper")
        .text_column("Here")
        .text_column("Verdict");
    for claim in claims {
        let plain = Cell::text(claim.verdict.replace("**", ""));
        let verdict = if claim.verdict.starts_with("**") {
            plain.bold()
        } else {
            plain
        };
        table = table.row([
            claim.what.into(),
            claim.paper.as_str().into(),
            claim.here.as_str().into(),
            verdict,
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    fn summary(mean: f64, half: f64) -> Option<Summary> {
        Some(Summary {
            mean,
            sd: None,
            ci95: Some([mean - half, mean + half]),
        })
    }

    #[test]
    fn analytic_ratio_carries_both_intervals() {
        let r = Ratio::of(summary(2.0, 0.06), summary(4.0, 0.16)).unwrap();
        // Relative halves of 3 % and 4 % make 5 % of 0.5; one rounding in each operation.
        assert!((r.value - 0.5).abs() < 1e-12 && (r.half - 0.025).abs() < 1e-12);
        // Gains of 0.5 against 0.6 and 0.8 in print: 83 % and 62 %.
        assert_eq!(
            (r.beside(0.4), r.beside(0.2)),
            (Comparison::Size, Comparison::Direction)
        );
        assert!(Ratio::of(summary(1.0, 0.1), None).is_none());
    }

    #[test]
    fn analytic_an_interval_that_holds_both_decides_nothing() {
        let ratio = |value, half| Ratio { value, half };
        // Three quarters of the gain of 0.6 is a ratio of 0.7.
        assert_eq!(ratio(0.9, 0.25).beside(0.6), Comparison::Undecided);
        assert_eq!(ratio(0.9, 0.15).beside(0.6), Comparison::Fails);
        let one = Ratio::of(Summary::of(&[1.0]), Summary::of(&[2.0])).unwrap();
        assert_eq!(one.beside(0.6), Comparison::Undecided);
    }

    #[test]
    fn prop_the_summary_counts_every_claim_once() {
        let claim = |verdict| Claim {
            what: "",
            paper: String::new(),
            here: String::new(),
            verdict,
            words: String::new(),
        };
        let (kind, text) = super::summary(&[
            claim(REPRODUCES),
            claim("direction, not size"),
            claim(FAILS),
        ]);
        assert_eq!(kind, Callout::Warning);
        assert!(
            text.starts_with("1 of 3 claims") && text.contains("1 do not reproduce"),
            "{text}"
        );
        assert_eq!(super::summary(&[claim(REPRODUCES)]).0, Callout::Success);
    }

    #[test]
    fn prop_verdicts_follow_their_conditions() {
        let of = |values: &[f64]| {
            let ratios = values
                .iter()
                .map(|&value| (Some(Ratio { value, half: 0.02 }), 0.6));
            verdict(&ratios.collect::<Vec<_>>())
        };
        assert_eq!(of(&[0.5, 0.69]), REPRODUCES);
        assert_eq!(of(&[0.5, 0.8]), "direction; size in part");
        assert_eq!(of(&[0.9, 0.8]), "direction, not size");
        assert_eq!(of(&[0.5, 1.0]), FAILS);
        assert!(verdict(&[(None, 0.6)]).starts_with("no figure"));
    }
}
