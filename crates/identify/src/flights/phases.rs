//! Armed intervals of a log, and the phase of every row.

use serde::Serialize;

use super::armed_interval::ArmedInterval;
use super::marking::mark;
use super::stand::{stands_after, stood};
use super::{Flight, FlightSettings};

/// The motors run for at least this long (s); shorter is a twitch.
/// Spin-up alone takes as long. Half passes self-tests of motors for flights.
const SHORTEST_RUN_S: f64 = 0.3;
/// Pause of the throttle that does not end a run (s).
/// Air modes cut the throttle for less; a landing takes longer.
const LONGEST_PAUSE_S: f64 = 0.1;
/// Hole in the stamps over which nothing is known to go on (s).
/// As heights. A vehicle can land within a longer one.
const LONGEST_HOLE_S: f64 = 0.5;
/// What a row of a log is.
#[derive(Clone, Copy, Debug, Eq, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Phase {
    /// Motors off.
    Off,
    /// Motors on, feet on the ground or motors spinning up.
    Contact,
    /// An impact, a drop, or a leap in the data.
    Impact,
    /// Tilted too far.
    Tilted,
    /// In flight.
    Airborne,
}

/// A log taken apart.
#[derive(Clone, Debug)]
pub struct Phases {
    /// Every row.
    pub rows: Vec<Phase>,
    /// Armed intervals, in order.
    pub runs: Vec<ArmedInterval>,
}

impl Phases {
    /// Takes a log apart.
    #[must_use]
    pub fn of(flight: &Flight, settings: &FlightSettings) -> Self {
        let n = flight.time_s.len();
        let mut rows = vec![Phase::Off; n];
        let runs = runs(flight, settings);
        for run in &runs {
            mark(flight, settings, run, &mut rows);
        }
        Self { rows, runs }
    }

    /// Rows of a kind.
    #[must_use]
    pub fn count(&self, phase: Phase) -> usize {
        self.rows.iter().filter(|p| **p == phase).count()
    }
}

/// The armed intervals: the motors run, with pauses and holes that are too short for a landing.
fn runs(flight: &Flight, settings: &FlightSettings) -> Vec<ArmedInterval> {
    let (time, throttle) = (&flight.time_s, &flight.throttle);
    let running = |i: usize| throttle[i] > settings.idle_throttle;
    let mut spans: Vec<[usize; 2]> = Vec::new();
    for i in (0..time.len()).filter(|&i| running(i)) {
        match spans.last_mut() {
            Some([_, end])
                if time[i] - time[*end] <= LONGEST_PAUSE_S
                    || *end + 1 == i && time[i] - time[*end] <= LONGEST_HOLE_S =>
            {
                *end = i;
            }
            _ => spans.push([i, i]),
        }
    }
    spans.retain(|[a, b]| time[*b] - time[*a] >= SHORTEST_RUN_S);
    let ends: Vec<usize> = spans
        .iter()
        .skip(1)
        .map(|[a, _]| *a)
        .chain([time.len()])
        .collect();
    let mut before = 0;
    let mut out: Vec<ArmedInterval> = spans
        .iter()
        .zip(&ends)
        .map(|(&[a, b], &end)| {
            // Where the throttle is not known, neither is a stand.
            let known = |i: &usize| throttle[*i].is_finite();
            let seen = (before..a).rev().take_while(known).count();
            let stand = a - seen..a;
            before = b + 1;
            let (stood_m, drift_m) = stood(flight, stand);
            let stood_m = stood_m.or_else(|| stands_after(flight, [a, b], end, settings));
            ArmedInterval {
                // Across a gap the state is unknown.
                on_s: (seen > 0 && time[a] - time[a - 1] <= LONGEST_HOLE_S).then(|| time[a]),
                off_s: (throttle.get(b + 1).is_some_and(|s| s.is_finite())
                    && time[b + 1] - time[b] <= LONGEST_HOLE_S)
                    .then(|| time[b + 1]),
                ran_from_s: time[a],
                ran_until_s: time[b],
                rows: [a, b],
                stood_m,
                drift_m,
            }
        })
        .collect();
    // The ground does not move: where it is found elsewhere than at first, the height has drifted.
    let first = out.iter().find_map(|run| run.stood_m);
    for run in &mut out {
        if let (Some(first), Some(stood)) = (first, run.stood_m) {
            run.drift_m = run.drift_m.max((stood - first).abs());
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stands 1 s, motors on, rises from 2 s, hovers, touches down at 8 s with a blow, motors off at 8.5 s.
    fn flight() -> Flight {
        let time_s: Vec<f64> = (0..1000).map(|i| 0.01 * f64::from(i)).collect();
        let height = |t: f64| 0.5 * ((t - 2.0).clamp(0.0, 1.0) - (t - 7.0).clamp(0.0, 1.0));
        Flight {
            name: "made".into(),
            throttle: time_s
                .iter()
                .map(|t| if (1.0..8.5).contains(t) { 0.5 } else { 0.0 })
                .collect(),
            force: time_s
                .iter()
                .map(|t| if (8.0..8.02).contains(t) { 5.0 } else { 1.0 })
                .collect(),
            height_m: time_s.iter().map(|t| 0.03 + height(*t)).collect(),
            throttle_period_s: 0.01,
            time_s,
            ..Flight::default()
        }
    }

    #[test]
    fn analytic_stand_climb_hover_and_blow() {
        let settings = FlightSettings {
            rotor_radius_m: Some(0.05),
            ..FlightSettings::default()
        };
        let found = Phases::of(&flight(), &settings);
        let [run] = &found.runs[..] else {
            panic!("{:?}", found.runs)
        };
        assert!(
            (run.on_s.unwrap() - 1.0).abs() < 0.011 && (run.off_s.unwrap() - 8.5).abs() < 0.011
        );
        assert!((run.stood_m.unwrap() - 0.03).abs() < 1e-12 && run.drift_m < 1e-12);
        let at = |t: f64| found.rows[(t * 100.0).round() as usize];
        assert_eq!(at(0.5), Phase::Off);
        assert_eq!(at(1.5), Phase::Contact);
        // 1 cm clear is 0.02 s into the climb at 0.5 m/s.
        assert_eq!(at(2.01), Phase::Contact);
        assert_eq!(at(2.04), Phase::Airborne);
        assert_eq!(at(5.0), Phase::Airborne);
        assert_eq!(at(7.9), Phase::Impact, "0.15 s around the blow");
        assert_eq!(at(8.3), Phase::Contact);
        assert_eq!(at(9.0), Phase::Off);
    }

    #[test]
    fn analytic_a_record_that_begins_in_flight_has_no_stand() {
        let mut flight = flight();
        flight.throttle.fill(0.5);
        let found = Phases::of(&flight, &FlightSettings::default());
        assert_eq!(found.runs[0].on_s, None);
        assert_eq!(found.runs[0].stood_m, None);
        assert_eq!(found.rows[100], Phase::Airborne);
    }

    #[test]
    fn analytic_a_landing_whose_stand_comes_after_it() {
        // From 4 s on: in flight, the feet down at 8 s, motors as in flight until 8.5 s.
        let of = |c: &[f64]| c[400..].to_vec();
        let whole = flight();
        let landing = Flight {
            time_s: of(&whole.time_s),
            throttle: of(&whole.throttle),
            force: of(&whole.force),
            height_m: of(&whole.height_m),
            ..whole
        };
        let settings = FlightSettings::default();
        let phases = Phases::of(&landing, &settings);
        let stood = phases.runs[0].stood_m.expect("stands after");
        assert!((stood - 0.03).abs() < 1e-12, "{stood}");
        let last = phases.rows.iter().rposition(|p| *p == Phase::Airborne);
        let last_s = landing.time_s[last.expect("in flight")];
        // Clear of the ground by 5 mm at 0.5 m/s, and 0.15 s around the blow.
        assert!((7.8..8.0).contains(&last_s), "{last_s}");
        // Motors that stop in the air leave no stand: what falls goes on falling.
        let mut falling = landing.clone();
        for i in 250..600 {
            falling.throttle[i] = 0.0;
            falling.height_m[i] = 0.5 - 0.3 * f64::from(i as u32 - 250) * 0.01;
        }
        assert_eq!(Phases::of(&falling, &settings).runs[0].stood_m, None);
        // A throttle that gets lost in a hover tells of no stand either.
        let mut lost = landing.clone();
        for i in 100..600 {
            lost.throttle[i] = f64::NAN;
            lost.height_m[i] = lost.height_m[100];
        }
        assert_eq!(Phases::of(&lost, &settings).runs[0].stood_m, None);
    }

    #[test]
    fn analytic_a_vehicle_that_never_flew_has_no_row_in_flight() {
        let mut flight = flight();
        flight.height_m.fill(0.03);
        let settings = FlightSettings::default();
        assert_eq!(Phases::of(&flight, &settings).count(Phase::Airborne), 0);
        flight.throttle.fill(0.0);
        assert!(Phases::of(&flight, &settings).runs.is_empty());
    }
}
