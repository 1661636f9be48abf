//! Verdicts: conditions on figures, never words written beforehand.

use touchdown_report::{Cell, Table};

use super::super::page::show;
use crate::statistics::Summary;

/// Share of the paper's gain from which a size counts as reproduced.
const SHARE_OF_GAIN: f64 = 0.75;

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

    /// Below one with its whole interval.
    pub(super) fn below_one(self) -> bool {
        self.value + self.half < 1.0
    }

    /// Whether this is at least three quarters of the gain that the paper's ratio is.
    pub(super) fn gains(self, paper: f64) -> bool {
        1.0 - self.value >= SHARE_OF_GAIN * (1.0 - paper)
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

/// Says whether a claim holds in direction and, figure by figure, in size; `None` where a figure is absent.
pub(super) fn direction_and_size(found: Option<(bool, Vec<bool>)>) -> &'static str {
    let Some((direction, sizes)) = found else {
        return "no figure: none landed";
    };
    let large = sizes.iter().filter(|s| **s).count();
    match (direction, large) {
        (false, _) => FAILS,
        (true, n) if n == sizes.len() => REPRODUCES,
        (true, 0) => "direction, not size",
        (true, _) => "direction; size in part",
    }
}

pub(super) fn table(claims: &[Claim]) -> Table {
    let mut table = Table::new("What the paper says, and what these runs give.")
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
        assert!(r.below_one() && r.gains(0.4) && !r.gains(0.2));
        assert!(Ratio::of(summary(1.0, 0.1), None).is_none());
    }

    #[test]
    fn analytic_a_single_trial_proves_no_direction() {
        let one = Summary::of(&[1.0]);
        let two = Summary::of(&[2.0]);
        assert!(!Ratio::of(one, two).unwrap().below_one());
    }

    #[test]
    fn prop_verdicts_follow_their_conditions() {
        let verdict =
            |direction, sizes: &[bool]| direction_and_size(Some((direction, sizes.into())));
        assert_eq!(verdict(true, &[true, true]), REPRODUCES);
        assert_eq!(verdict(false, &[true]), FAILS);
        assert_eq!(verdict(true, &[false]), "direction, not size");
        assert_eq!(verdict(true, &[false, true]), "direction; size in part");
        assert!(direction_and_size(None).starts_with("no figure"));
    }
}
