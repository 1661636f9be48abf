//! Landings that are commanded from outside.

use touchdown_sim::landing::space::{
    Batch, Case, CommandKind, Commanded, LaneEnd, Observation, SpaceOutcome,
};

/// Descends upright at a sink rate, by a proportional law on the velocity relative to the deck.
fn commands(commanded: &Commanded, sink_mps: f64) -> Vec<f64> {
    let mut seen = vec![0.0; commanded.places() * Observation::NUMBERS];
    commanded.observe(&mut seen);
    let weight_n = commanded.weight_n();
    seen.chunks_exact(Observation::NUMBERS)
        .flat_map(|row| {
            let [x, y, _, u, v, w] = [0, 1, 2, 3, 4, 5].map(|k| row[k]);
            // Small angles: pitch pulls x back, roll y.
            let lean = |place: f64, speed: f64| (-0.2 * place - 0.25 * speed).clamp(-0.2, 0.2);
            let (pitch, roll) = (lean(x, u), -lean(y, v));
            // Enough to sink through a ground effect of a tenth of the weight.
            let thrust_n = weight_n * (1.0 - (w + sink_mps)).max(0.5);
            match commanded.kind() {
                CommandKind::Attitude => vec![thrust_n, 1.0, 0.5 * roll, 0.5 * pitch, 0.0],
                // Towards that attitude in a fifth of a second.
                CommandKind::Rates => {
                    let turn = |wanted: f64, k: usize| 5.0 * (wanted - 2.0 * row[9 + k]);
                    vec![thrust_n, turn(roll, 1), turn(pitch, 2), 0.0]
                }
            }
        })
        .collect()
}

/// Flies trial after trial at every place until so many have ended.
fn ends(kind: CommandKind, case: Case, places: usize, ended: usize) -> Vec<LaneEnd> {
    let batch = Batch::new(&case.scenario()).expect("a valid scenario");
    let mut commanded = Commanded::new(batch, kind, places, 0.02).expect("valid settings");
    let mut next = vec![0_u64; places];
    for place in 0..places {
        commanded
            .begin(place, place as u64, 5)
            .expect("a checked scenario");
    }
    let mut all = Vec::new();
    while all.len() < ended {
        let orders = commands(&commanded, 0.25);
        for end in commanded.fly(&orders) {
            next[end.place] += 1;
            let trial = end.place as u64 + next[end.place] * places as u64;
            commanded
                .begin(end.place, trial, 5)
                .expect("a checked scenario");
            all.push(end);
        }
    }
    all
}

fn lands_and_repeats(kind: CommandKind) {
    let whole = ends(kind, Case::Paper, 11, 33);
    let landed = whole.iter().filter(|e| e.landing.outcome.landed()).count();
    // The law has no integral: it sinks at 0.25 m/s less what the ground effect lifts. 0.6 m/s is a crash.
    assert!(landed >= 30, "{landed} of {}", whole.len());
    for end in whole.iter().filter(|e| e.landing.outcome.landed()) {
        let touch = end.landing.touch.expect("it touched");
        assert!((0.03..0.4).contains(&touch.v_l_mps), "{touch:?}");
        // Legs of 0.1 m carry it: the state at the end is that of a vehicle at rest on its deck.
        assert!((end.state[2] - 0.1).abs() < 0.05, "{:?}", end.state);
    }
    assert_eq!(ends(kind, Case::Paper, 11, 33), whole);
}

#[test]
fn prop_a_descent_by_hand_lands_and_repeats_to_the_bit() {
    for kind in [CommandKind::Attitude, CommandKind::Rates] {
        lands_and_repeats(kind);
    }
    // What begins after a clearing begins as in a new value.
    let batch = Batch::new(&Case::Sea.scenario()).expect("a valid scenario");
    let mut commanded =
        Commanded::new(batch, CommandKind::Attitude, 3, 0.02).expect("valid settings");
    let mut fly = || {
        commanded.clear();
        (0..3).for_each(|place| commanded.begin(place, 2, 9).expect("a checked scenario"));
        for _ in 0..7 {
            let orders = commands(&commanded, 0.25);
            commanded.fly(&orders);
        }
        let mut seen = vec![0.0; 3 * Observation::NUMBERS];
        commanded.observe(&mut seen);
        seen
    };
    let first = fly();
    assert_eq!(fly(), first);
}

#[test]
fn prop_a_landing_does_not_depend_on_its_company() {
    // First landings begin at a knot: the same in one lane as beside ten others.
    for kind in [CommandKind::Attitude, CommandKind::Rates] {
        let mut beside = ends(kind, Case::Sea, 11, 11);
        beside.retain(|end| end.landing.trial_index == 0);
        let alone = ends(kind, Case::Sea, 1, 1);
        assert_eq!(beside.len(), 1, "the trial of place 0 ends among the first");
        assert_eq!(beside, alone);
    }
}

#[test]
fn analytic_the_vehicle_turns_at_the_rates_that_are_asked_for_within_limits() {
    let batch = Batch::new(&Case::Still.scenario()).expect("a valid scenario");
    let mut commanded = Commanded::new(batch, CommandKind::Rates, 2, 0.1).expect("valid settings");
    for place in 0..2 {
        commanded.begin(place, 7, 1).expect("a checked scenario");
    }
    let weight_n = commanded.weight_n();
    let mut seen = vec![0.0; 2 * Observation::NUMBERS];
    let mut turn = |rates: [f64; 3], decisions: usize| {
        let [p, q, r] = rates;
        for _ in 0..decisions {
            assert!(
                commanded
                    .fly(&[weight_n, p, q, r, weight_n, -p, -q, -r])
                    .is_empty()
            );
        }
        commanded.observe(&mut seen);
        [13, 14, 15].map(|k| (seen[k], seen[Observation::NUMBERS + k]))
    };
    // Rate loops of PX4's speed: within 10 % after 0.3 s, yaw within 25 %.
    for (k, (there, back)) in turn([0.5, -0.3, 0.2], 3).into_iter().enumerate() {
        let wanted = [0.5, -0.3, 0.2][k];
        let share = [0.1, 0.1, 0.25][k];
        for (rate, wanted) in [(there, wanted), (back, -wanted)] {
            assert!(
                (rate - wanted).abs() < share * 0.5,
                "{k}: {rate} for {wanted}"
            );
        }
    }
    // The limit of 3.84 rad/s; the loop swings over it by less than a fifth.
    let [(roll, _), ..] = turn([30.0, 0.0, 0.0], 2);
    assert!((3.0..4.6).contains(&roll), "{roll}");
}

#[test]
fn prop_no_thrust_is_a_crash_and_hovering_times_out() {
    let mut scenario = Case::Still.scenario();
    scenario.timeout_s = 1.0;
    let batch = Batch::new(&scenario).expect("a valid scenario");
    let mut commanded =
        Commanded::new(batch, CommandKind::Attitude, 2, 0.1).expect("valid settings");
    for place in 0..2 {
        commanded.begin(place, 7, 1).expect("a checked scenario");
    }
    let weight_n = commanded.weight_n();
    let orders = [0.0, 1.0, 0.0, 0.0, 0.0, weight_n, 1.0, 0.0, 0.0, 0.0];
    let mut ends = Vec::new();
    for _ in 0..11 {
        ends.extend(commanded.fly(&orders));
    }
    assert!(
        ends[0].landing.outcome.crashed() && ends[0].place == 0,
        "{ends:?}"
    );
    assert_eq!(ends[1].landing.outcome, SpaceOutcome::TimedOut);
    // The state at the end is of the flight, not of an empty lane.
    assert!(ends[1].state[2] > 0.3, "{:?}", ends[1].state);
    assert!(commanded.fly(&orders).is_empty());
}

#[test]
fn prop_bad_settings_are_named() {
    let batch = Batch::new(&Case::Paper.scenario()).expect("a valid scenario");
    for (decision_s, places, key) in [
        (0.01, 1, "decision_s"),
        (f64::NAN, 1, "decision_s"),
        (0.02, 0, "places"),
    ] {
        let error = Commanded::new(batch.clone(), CommandKind::Rates, places, decision_s)
            .unwrap_err()
            .to_string();
        assert!(error.contains(key), "{error}");
    }
}
