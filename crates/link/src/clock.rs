//! The autopilot's clock, by `TIMESYNC`.
//!
//! Our request holds our time. The autopilot's answer holds both. Of the last five answers the one with the shortest
//! round trip gives the offset: what delays a message on its way makes the offset wrong by at most half of it. A clock that
//! slips, as that of a simulated autopilot on a busy machine, is followed; one that steps is reported.

use std::collections::VecDeque;

use serde::Serialize;

/// Number of questions that wait for an answer.
const ASKED: usize = 8;
/// Number of answers that are kept: a second of them. Over twice of it a simulator that runs at 0.99 of real time slips by
/// 20 ms; in half of it two slow answers in a row decide.
const KEPT: usize = 5;
/// Difference that two answers may have beyond their round trips, µs: rounding to milliseconds, and what clocks drift.
const SLIP_US: i64 = 2_000;
/// Difference beyond which a clock has stepped, µs: half of it is what a simulated autopilot on a busy machine slips at a
/// time; twice of it is a third of the greatest age of a reading.
const STEP_US: i64 = 50_000;
/// Answers in a row that contradict the offset before the clock counts as stepped.
const CONTRADICTIONS: u32 = 2;
/// Difference between two answers to the same question that one clock does not make, µs.
const TWO_CLOCKS_US: i64 = 1_000;

/// Result of an answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SyncEvent {
    /// Nothing new.
    Nothing,
    /// The autopilot's clock has stepped.
    Stepped,
    /// Two clocks answered the same question differently: there are two autopilots.
    TwoClocks,
}

/// One answer.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Answer {
    at_us: i64,
    round_trip_us: i64,
    offset_us: i64,
}

/// Synchronisation with the autopilot's clock.
#[derive(Clone, Debug)]
pub struct ClockSync {
    answers: Vec<Answer>,
    next: usize,
    /// Times of the questions that are not answered yet, µs.
    asked: VecDeque<i64>,
    /// The question that was answered last, and the autopilot's time in the answer, µs.
    last: Option<(i64, i64)>,
    contradictions: u32,
    steps: u32,
    /// Answers since the last step.
    count: u64,
    /// The first answer since the last step.
    first: Option<Answer>,
}

impl Default for ClockSync {
    /// With room for all that is kept, so that nothing allocates later.
    fn default() -> Self {
        Self {
            answers: Vec::with_capacity(KEPT),
            next: 0,
            asked: VecDeque::with_capacity(ASKED),
            last: None,
            contradictions: 0,
            steps: 0,
            count: 0,
            first: None,
        }
    }
}

/// State of the synchronisation, for people.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SyncReport {
    /// Answers since the start, or since the clock stepped.
    pub answers: u64,
    /// Shortest round trip, s.
    pub round_trip_s: f64,
    /// The autopilot's time less ours, s.
    pub offset_s: f64,
    /// Drift of the autopilot's clock against ours since the first answer, in parts per million.
    pub drift_ppm: f64,
    /// How wrong that drift can be by the round trips of the two answers that it comes from, in parts per million.
    pub drift_error_ppm: f64,
    /// How often the autopilot's clock stepped.
    pub steps: u32,
}

impl ClockSync {
    /// We ask at `now_us`, our time, which the question must hold.
    pub fn asks(&mut self, now_us: i64) {
        if self.asked.len() == ASKED {
            self.asked.pop_front();
        }
        self.asked.push_back(now_us);
    }

    /// An answer: when we asked and got it (our time), and the autopilot's time in it. Answers that were not asked for, or
    /// that come twice, change nothing.
    pub fn answered(&mut self, asked_us: i64, autopilot_us: i64, got_us: i64) -> SyncEvent {
        let Some(index) = self.asked.iter().position(|asked| *asked == asked_us) else {
            let other = self.last.is_some_and(|(asked, answer)| {
                asked == asked_us && answer.abs_diff(autopilot_us) > TWO_CLOCKS_US.unsigned_abs()
            });
            return if other {
                SyncEvent::TwoClocks
            } else {
                SyncEvent::Nothing
            };
        };
        self.asked.remove(index);
        self.last = Some((asked_us, autopilot_us));
        let round_trip_us = got_us.saturating_sub(asked_us);
        let offset_us = autopilot_us.saturating_sub(asked_us.saturating_add(round_trip_us / 2));
        let answer = Answer {
            at_us: got_us,
            round_trip_us,
            offset_us,
        };
        let beyond_us = self.best().map_or(0, |best| {
            let apart = best.offset_us.saturating_sub(offset_us).saturating_abs();
            apart - (best.round_trip_us + round_trip_us) / 2
        });
        let stepped = beyond_us > STEP_US;
        if stepped {
            self.contradictions += 1;
            if self.contradictions < CONTRADICTIONS {
                return SyncEvent::Nothing;
            }
            self.steps += 1;
            self.count = 0;
            self.first = None;
        }
        if beyond_us > SLIP_US {
            self.answers.clear();
            self.next = 0;
        }
        self.first.get_or_insert(answer);
        self.contradictions = 0;
        self.count += 1;
        if self.answers.len() < KEPT {
            self.answers.push(answer);
        } else {
            self.answers[self.next] = answer;
        }
        self.next = (self.next + 1) % KEPT;
        if stepped {
            SyncEvent::Stepped
        } else {
            SyncEvent::Nothing
        }
    }

    fn best(&self) -> Option<Answer> {
        self.answers
            .iter()
            .copied()
            .min_by_key(|answer| answer.round_trip_us)
    }

    /// Our time of a stamp of the autopilot, µs.
    #[must_use]
    pub fn ours_us(&self, autopilot_us: i64) -> Option<i64> {
        Some(autopilot_us.saturating_sub(self.best()?.offset_us))
    }

    /// The autopilot's time of one of ours, µs.
    #[must_use]
    pub fn theirs_us(&self, ours_us: i64) -> Option<i64> {
        Some(ours_us.saturating_add(self.best()?.offset_us))
    }

    /// The drift from the first answer to the best one, and its greatest error; an infinite error if both are the same.
    fn drift_ppm(&self, best: Answer) -> [f64; 2] {
        let first = self.first.unwrap_or(best);
        let elapsed_us = best.at_us.saturating_sub(first.at_us);
        if elapsed_us <= 0 {
            return [0.0, f64::INFINITY];
        }
        let ppm = |us: i64| us as f64 / elapsed_us as f64 * 1e6;
        let round_trips_us = best.round_trip_us.saturating_add(first.round_trip_us);
        [
            ppm(best.offset_us.saturating_sub(first.offset_us)),
            0.5 * ppm(round_trips_us),
        ]
    }

    /// The state, once there is an answer.
    #[must_use]
    pub fn report(&self) -> Option<SyncReport> {
        let best = self.best()?;
        let [drift_ppm, drift_error_ppm] = self.drift_ppm(best);
        Some(SyncReport {
            answers: self.count,
            round_trip_s: best.round_trip_us as f64 * 1e-6,
            offset_s: best.offset_us as f64 * 1e-6,
            drift_ppm,
            drift_error_ppm,
            steps: self.steps,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A question and its answer; whether the clock has stepped.
    fn exchange(clock: &mut ClockSync, asked_us: i64, autopilot_us: i64, got_us: i64) -> bool {
        clock.asks(asked_us);
        clock.answered(asked_us, autopilot_us, got_us) == SyncEvent::Stepped
    }

    #[test]
    fn analytic_the_shortest_round_trip_decides() {
        let mut clock = ClockSync::default();
        // The autopilot's clock is 5 s ahead; the second answer waits 8 ms on its way back.
        assert!(!exchange(&mut clock, 1_000_000, 6_001_000, 1_002_000));
        assert!(!exchange(&mut clock, 2_000_000, 7_001_000, 2_010_000));
        assert_eq!(clock.ours_us(8_000_000), Some(3_000_000));
        assert_eq!(clock.theirs_us(3_000_000), Some(8_000_000));
        let report = clock.report().unwrap();
        assert_eq!((report.answers, report.round_trip_s), (2, 0.002));
    }

    #[test]
    fn analytic_a_clock_that_runs_fast_drifts() {
        let mut clock = ClockSync::default();
        for k in 0..50_i64 {
            let asked = k * 200_000;
            // 100 parts per million fast.
            let theirs = 5_000_000 + asked + asked / 10_000;
            exchange(&mut clock, asked, theirs, asked);
        }
        let report = clock.report().unwrap();
        let drift = report.drift_ppm;
        // The best of the last answers is the first of them; whole microseconds round by 1 in 7 s.
        assert!((drift - 100.0).abs() < 0.5, "{drift}");
        assert_eq!(report.drift_error_ppm, 0.0);
    }

    #[test]
    fn prop_a_step_of_the_clock_is_found_at_the_second_answer() {
        let mut clock = ClockSync::default();
        for k in 0..20 {
            let asked = k * 200_000;
            assert!(!exchange(&mut clock, asked, asked + 5_000_200, asked + 400));
        }
        // The autopilot restarted.
        assert!(!exchange(&mut clock, 4_000_000, 100_000, 4_000_400));
        assert!(exchange(&mut clock, 4_200_000, 300_000, 4_200_400));
        assert_eq!(clock.report().unwrap().steps, 1);
        assert_eq!(clock.ours_us(300_000), Some(4_200_200));
    }

    #[test]
    fn prop_a_clock_that_slips_is_followed() {
        let mut clock = ClockSync::default();
        let mut slipped_us = 0;
        for k in 0..50_i64 {
            let asked = k * 200_000;
            if k % 7 == 0 {
                slipped_us += 30_000;
            }
            let theirs = asked + 5_000_000 - slipped_us;
            assert!(!exchange(&mut clock, asked, theirs, asked + 100));
            // Half of the round trip.
            assert!((clock.theirs_us(asked).unwrap() - theirs).abs() <= 50);
        }
        let report = clock.report().unwrap();
        assert_eq!((report.answers, report.steps), (50, 0));
    }

    #[test]
    fn prop_answers_that_nobody_asked_for_change_nothing() {
        let mut clock = ClockSync::default();
        assert!(!exchange(&mut clock, 1_000_000, 6_001_000, 1_002_000));
        let before = clock.report();
        let again = clock.answered(1_000_000, 6_001_000, 1_003_000);
        assert_eq!(again, SyncEvent::Nothing, "a packet that came twice");
        let other = clock.answered(1_000_000, 9_000_000, 1_003_000);
        assert_eq!(other, SyncEvent::TwoClocks);
        assert_eq!(clock.report(), before);
        let mut clock = ClockSync::default();
        assert_eq!(clock.answered(10, 0, 5), SyncEvent::Nothing);
        let absurd = clock.answered(i64::MIN, i64::MAX, i64::MAX);
        assert_eq!(absurd, SyncEvent::Nothing);
        assert!(clock.report().is_none());
    }
}
