//! Readings that come late, out of order, or too many of them.

use crate::common::noise::Noise;
use touchdown_flight::Attitude;
use touchdown_lander::estimate::relative::{
    GnssVelocity, ImuModel, ImuSample, RangeReading, Reading, RelativeEstimate, RelativeFilter,
    RelativeState,
};

use crate::truth::*;

/// The same readings, delivered `late` after they were made.
fn delivered(late: [usize; 3], until: usize) -> RelativeEstimate<f64> {
    let filter = mounted();
    let mut state: State = filter.initial();
    let mut estimate = None;
    let mut noise = Noise::new(7);
    // Noise belongs to the reading, not to its delivery.
    let noisy: Vec<f64> = (0..=until).map(|_| 0.01 * noise.normal()).collect();
    for step in 1..=until {
        let t = step as f64 * DT;
        let mut all = Vec::new();
        for (kind, (late, every)) in late.into_iter().zip([2, 3, 20]).enumerate() {
            if step <= late + 5 {
                continue;
            }
            let made = step - late;
            if !due(made, every) || made > until - 20 {
                continue;
            }
            let (then, age) = (made as f64 * DT, late as f64 * DT);
            all.push(match kind {
                0 => {
                    let mut range = PAPER_DECK.range(&filter, then, age);
                    range.distance_m += noisy[made];
                    Reading::Range(range)
                }
                1 => Reading::Tag(PAPER_DECK.tag(&filter, then, age)),
                _ => Reading::Gnss(GnssVelocity {
                    velocity_mps: PAPER_DECK.at(then).velocity,
                    age_s: age,
                }),
            });
        }
        estimate = Some(filter.step(&mut state, &PAPER_DECK.imu(t, V::ZERO), &all, DT));
    }
    estimate.unwrap()
}

#[test]
fn analytic_delays_are_compensated_exactly() {
    // Late readings, out of order, lead to where punctual ones do.
    let punctual = delivered([0, 0, 0], 500);
    for late in [[2, 0, 0], [0, 6, 0], [2, 6, 12], [13, 5, 1]] {
        let estimate = delivered(late, 500);
        let apart = (estimate.position_m - punctual.position_m).norm()
            + (estimate.velocity_mps - punctual.velocity_mps).norm()
            + (estimate.deck_velocity_mps - punctual.deck_velocity_mps).norm();
        // Readings of one moment are taken in another order, and times are sums of
        // steps: rounding of the filter's numbers, 1e-16 over 500 steps.
        assert!(apart < 1e-12, "{late:?}: {apart}");
    }
}

#[test]
fn analytic_a_wrong_delay_costs_speed_times_error() {
    // At a steady descent the place is wrong by the way of 50 ms.
    let filter = RelativeFilter {
        imu: ImuModel {
            bias_sd_mps2: 0.0,
            bias_walk: 0.0,
            ..ImuModel::default()
        },
        ..still(mounted())
    };
    let run = |claimed: f64| {
        let mut state: State = filter.initial();
        let imu = ImuSample {
            specific_force_mps2: V::UP * G,
            attitude: Attitude::LEVEL,
        };
        let mut height = 0.0;
        for step in 1..=600 {
            let t = f64::from(step) * DT;
            let distance = 5.0 - 0.5 * (t - 0.05) - 0.04;
            let range = Reading::Range(RangeReading::level(distance, claimed));
            height = filter.step(&mut state, &imu, &[range], DT).height_m();
        }
        height - (5.0 - 0.5 * 6.0)
    };
    // Steady motion: the filter has forgotten its start to 1e-6.
    assert!(run(0.05).abs() < 1e-5, "{}", run(0.05));
    assert!((run(0.0) - 0.025).abs() < 1e-4, "{}", run(0.0));
}

#[test]
fn analytic_readings_between_steps_and_ahead_of_the_imu() {
    let filter = mounted();
    let (a, b) = (0.004, 0.006);
    let accelerated = ImuSample {
        specific_force_mps2: V::new(0.3, -0.2, G + 0.5),
        attitude: Attitude::LEVEL,
    };
    let range = |t: f64, age: f64| Reading::Range(RangeReading::level(2.0 + 0.3 * t, age));
    // Steps cut at the reading's time ...
    let mut cut: State = filter.initial();
    // ... and a reading that is 6 ms old at the end of a whole step.
    let mut whole: State = filter.initial();
    // ... and one that is newer than the IMU, which is 10 ms old.
    let delayed = RelativeFilter {
        imu: ImuModel {
            delay_s: DT,
            ..filter.imu
        },
        ..filter
    };
    let mut ahead: State = delayed.initial();
    let mut ends = [None; 3];
    for step in 0..300 {
        let t = f64::from(step) * DT;
        let imu = accelerated;
        let last = step == 299;
        filter.step(&mut cut, &imu, &[range(t + a, 0.0)], a);
        ends[0] = Some(filter.step(&mut cut, &imu, &[], b));
        ends[1] = Some(filter.step(&mut whole, &imu, &[range(t + a, b)], DT));
        // The sample over [t, t + dt] arrives at t + 2 dt; the reading of the next
        // interval is already there.
        let early = if step == 0 {
            vec![range(a, DT + b), range(DT + a, b)]
        } else {
            vec![range(t + DT + a, b)]
        };
        let early = if last { Vec::new() } else { early };
        ends[2] = Some(delayed.step(&mut ahead, &imu, &early, DT));
    }
    let [cut, whole, ahead] = ends.map(Option::unwrap);
    // Noise over cut steps is exact for the integrators and right to ω dt = 3 % of
    // the deck's share of a step otherwise.
    assert!((cut.height_m() - whole.height_m()).abs() < 1e-5);
    assert!((cut.velocity_mps - whole.velocity_mps).norm() < 1e-4);
    // The same computation.
    assert!((ahead.height_m() - whole.height_m()).abs() < 1e-12);
    assert!((ahead.velocity_mps - whole.velocity_mps).norm() < 1e-12);
}

#[test]
fn analytic_too_old_and_too_many() {
    let filter = mounted();
    let mut state: RelativeState<f64, 8, 4> = filter.initial();
    let imu = STILL.imu(0.0, V::ZERO);
    for _ in 0..20 {
        filter.step(&mut state, &imu, &[], DT);
    }
    let range = |age: f64| Reading::Range(RangeReading::level(1.5, age));
    // Seven steps back are remembered, more are not.
    filter.step(&mut state, &imu, &[range(0.0699), range(0.0701)], DT);
    let health = filter.health(&state).range;
    assert_eq!((health.used, health.too_old), (1, 1));
    filter.step(&mut state, &imu, &[range(0.0); 6], DT);
    let health = filter.health(&state).range;
    // Six more in a log of four: those that are in the state have given way.
    assert_eq!((health.used, health.no_room), (7, 0));
    // What they stood for is no longer known apart: readings of that time are too late.
    filter.step(
        &mut state,
        &imu,
        &[range(0.03), range(0.01), range(0.0)],
        DT,
    );
    let health = filter.health(&state).range;
    assert_eq!((health.used, health.too_old), (9, 2));
}

#[test]
fn analytic_readings_that_give_way_stay_in_the_state() {
    // On time, a log of two gives what a log of sixty does; late by 20 ms and two a
    // step, one of six does.
    let filter = mounted();
    let (mut small, mut middle, mut large): (
        RelativeState<f64, 16, 2>,
        RelativeState<f64, 16, 6>,
        RelativeState<f64, 16, 60>,
    ) = (filter.initial(), filter.initial(), filter.initial());
    let imu = STILL.imu(0.0, V::ZERO);
    let readings = |i: u32, age: f64| {
        let noise = 0.01 * f64::from(i * 7 % 5);
        [0.0, 1e-3].map(|early| Reading::Range(RangeReading::level(1.5 + noise, age + early)))
    };
    for i in 0..100 {
        let a = filter.step(&mut small, &imu, &readings(i, 0.0), DT);
        let b = filter.step(&mut large, &imu, &readings(i, 0.0), DT);
        assert_eq!(a, b, "{i}");
    }
    let mut large: RelativeState<f64, 16, 60> = filter.initial();
    for i in 0..100 {
        let a = filter.step(&mut middle, &imu, &readings(i, 0.02), DT);
        let b = filter.step(&mut large, &imu, &readings(i, 0.02), DT);
        assert_eq!(a, b, "{i}");
    }
}
