//! Verdicts: conditions on figures, never words written beforehand.

use touchdown_report::{Cell, Table};

use super::super::page::show;
use crate::statistics::Summary;

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

    pub(super) fn within(self, of: f64, tolerance: f64) -> bool {
        (self.value - of).abs() <= tolerance
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
    pub(super) what: &'static str,
    pub(super) paper: String,
    pub(super) here: String,
    pub(super) verdict: String,
}

/// Says whether a claim holds in direction and in size; `None` where a figure is absent.
pub(super) fn direction_and_size(found: Option<(bool, bool)>) -> String {
    match found {
        None => "no figure: a method did not land",
        Some((true, true)) => "**reproduces**",
        Some((true, false)) => "direction reproduces, size does not",
        Some((false, _)) => "**does not reproduce**",
    }
    .to_string()
}

pub(super) fn table(claims: Vec<Claim>) -> Table {
    let mut table = Table::new("What the paper says, and what these runs give.")
        .text_column("Claim")
        .text_column("Paper")
        .text_column("Here")
        .text_column("Verdict");
    for claim in claims {
        let bold = claim.verdict.starts_with("**");
        let verdict = Cell::text(claim.verdict.replace("**", ""));
        table = table.row([
            claim.what.into(),
            claim.paper.into(),
            claim.here.into(),
            if bold { verdict.bold() } else { verdict },
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
        assert!(r.below_one() && r.within(0.55, 0.1) && !r.within(0.7, 0.1));
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
        assert!(direction_and_size(Some((false, true))).contains("not reproduce"));
        assert!(direction_and_size(Some((true, false))).contains("size does not"));
        assert!(direction_and_size(None).starts_with("no figure"));
    }
}
