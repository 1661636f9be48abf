//! The autopilot's reports of the setpoints that it follows (`ATTITUDE_TARGET`).
//!
//! Before control they come from the pilot or the autopilot's own modes: in hover their mean is the thrust of the weight.
//! In control they must be those that were sent.

const SECOND_US: i64 = 1_000_000;
/// Difference of an echoed thrust from all that were sent lately: rounding and filters of the autopilot. With half of it,
/// the input filter of ArduPilot would count as a rejection; with twice of it, a hover at the autopilot's own thrust may pass.
const SAME: f64 = 0.03;
/// Time for which other setpoints must be followed before they count as rejected, µs. Half of it is a gap of the link; in twice of it a vehicle that does not follow drifts by metres.
const REJECTED_US: i64 = SECOND_US;
/// Reports older than this are missing, µs.
const MISSING_US: i64 = SECOND_US / 2;
/// Reports in hover before their mean is used: 3 s at 50 Hz.
const ENOUGH: u32 = 150;
/// Share of a new report in the mean: it remembers about as many as are enough.
const SHARE: f64 = 1.0 / ENOUGH as f64;
/// Specific force in hover, as a share of gravity: beyond, the vehicle climbs, sinks or stands on something.
const HOVERS: std::ops::RangeInclusive<f64> = 0.9..=1.1;

/// The reports so far.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Echo {
    heard_us: Option<i64>,
    /// When a report last had a thrust that was sent.
    agreed_us: i64,
    /// Least and greatest thrust sent in this half second, and in the one before.
    sent: [Option<(f64, f64)>; 2],
    half_us: i64,
    hover: f64,
    reports: u32,
}

impl Echo {
    /// Control begins: setpoints of before do not count.
    pub(super) fn begin(&mut self, now_us: i64) {
        self.agreed_us = now_us;
        self.sent = [None; 2];
    }

    /// A thrust was sent.
    pub(super) fn sends(&mut self, thrust: f64, now_us: i64) {
        if now_us - self.half_us >= MISSING_US {
            self.half_us = now_us;
            self.sent = [None, self.sent[0]];
        }
        let (least, greatest) = self.sent[0].unwrap_or((thrust, thrust));
        self.sent[0] = Some((least.min(thrust), greatest.max(thrust)));
    }

    /// The autopilot reports the thrust that it follows.
    pub(super) fn hears(&mut self, thrust: f64, now_us: i64) {
        self.heard_us = Some(now_us);
        let near =
            |(least, greatest): &(f64, f64)| (least - SAME..=greatest + SAME).contains(&thrust);
        if self.sent.iter().flatten().any(near) {
            self.agreed_us = now_us;
        }
    }

    /// The same, while another flies: at this specific force, as a share of gravity.
    pub(super) fn hovers(&mut self, thrust: f64, load: f64) {
        if HOVERS.contains(&load) && thrust > 0.0 && thrust <= 1.0 {
            let share = SHARE.max(1.0 / f64::from(self.reports + 1));
            self.hover += share * (thrust / load - self.hover);
            self.reports = self.reports.saturating_add(1).min(10 * ENOUGH);
        }
    }

    /// Whether reports come, but for long none had a thrust that was sent.
    pub(super) fn rejected(&self, now_us: i64) -> bool {
        let comes = self
            .heard_us
            .is_some_and(|heard| now_us - heard < MISSING_US);
        comes && now_us - self.agreed_us > REJECTED_US
    }

    /// Whether there ever was a report.
    pub(super) fn heard(&self) -> bool {
        self.heard_us.is_some()
    }

    /// The autopilot's thrust setpoint in hover.
    pub(super) fn hover(&self) -> Option<f64> {
        (self.reports >= ENOUGH).then_some(self.hover)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_only_other_thrusts_for_a_second_are_a_rejection() {
        let mut echo = Echo::default();
        echo.begin(0);
        for tick in 0..300 {
            let now = tick * 10_000;
            echo.sends(0.5 + 0.001 * (tick % 100) as f64, now);
            let followed = if tick < 100 { 0.52 } else { 0.3 };
            if tick % 10 == 0 {
                echo.hears(followed, now);
            }
            assert_eq!(echo.rejected(now), now > 900_000 + REJECTED_US, "{now}");
        }
        assert!(
            !echo.rejected(10_000_000),
            "reports that do not come reject nothing"
        );
    }

    #[test]
    fn analytic_the_hover_thrust_is_the_mean_at_rest() {
        let mut echo = Echo::default();
        echo.hovers(0.9, 1.5);
        assert_eq!(echo.hover(), None);
        for k in 0..300 {
            echo.hovers(if k % 2 == 0 { 0.44 } else { 0.46 }, 1.0);
        }
        // The newest report weighs a 150th of the step of 0.02.
        assert!((echo.hover().unwrap() - 0.45).abs() < 0.02 / 150.0);
    }
}
