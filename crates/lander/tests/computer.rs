//! The landing computer: from readings to commands.

use touchdown_flight::control::{Composite, Law};
use touchdown_flight::ground_effect::{GroundEffectState, Guarded, GuardedState};
use touchdown_flight::thrust::{FirstOrder, ThrustModel};
use touchdown_flight::{Attitude, Limits, Real, Vector};
use touchdown_lander::computer::{Computer, ComputerState, Descent, Feet, NormalReading, Sensed};
use touchdown_lander::control::{Delays, Horizontal, Observer};
use touchdown_lander::estimate::deck::{DeckEstimator, Observed};
use touchdown_lander::estimate::relative::{
    GnssVelocity, ImuSample, RangeReading, Reading, RelativeFilter, TagReading,
};
use touchdown_lander::guidance::Guidance;
use touchdown_lander::planner::Planner;
use touchdown_lander::space_controller::SpaceController;
use touchdown_lander::state_machine::{OperatorRequest, Phase, StateMachine};

type State<R> = ComputerState<R, GuardedState<R, GroundEffectState<R>>>;

fn computer<R: Real>() -> Computer<R> {
    let n = R::from_f64;
    let computer = Computer {
        under_way: false,
        seek: None,
        relative: RelativeFilter::default(),
        latency: None,
        deck: DeckEstimator {
            delay_s: n(0.05),
            ..DeckEstimator::new(Observed::Displacement, n(0.005))
        },
        descent: Descent::Planned(Planner::default()),
        state_machine: StateMachine::default(),
        guidance: Guidance::default(),
        controller: SpaceController {
            motor_lag_share: n(0.5),
            mass_kg: n(1.37),
            gravity_mps2: n(9.81),
            law: Law::Composite(Composite::default()),
            horizontal: Horizontal::default(),
            thrust: ThrustModel::FirstOrder(FirstOrder {
                c0: n(6.9),
                c1: n(0.3),
                t_m_s: n(0.06),
            }),
            ground_effect: Guarded::default(),
            observer: Some(Observer::default()),
            adaptation: None,
            delays: Delays::default(),
            limits: Limits::default(),
        },
        deck_acceleration: true,
        imu_latency_s: R::ZERO,
        known_sd_m: n(0.3),
        known_sd_mps: n(0.3),
        restart_s: n(0.5),
        feet: Feet {
            radius_m: n(0.15),
            depth_m: n(0.10),
        },
        contact_height_m: n(0.11),
        watch_s: n(3.0),
        deck_known_mps: n(0.02),
        least_damping_ratio: n(0.1),
        normal_filter_s: n(0.2),
        tilt_memory_s: n(10.0),
        planner_period_s: n(0.1),
    };
    computer.validate().unwrap();
    computer
}

/// What a vehicle at rest 0.8 m above a deck at rest senses, every 10 ms.
fn at_rest<R: Real>() -> (ImuSample<R>, [Reading<R>; 2]) {
    let n = R::from_f64;
    let imu = ImuSample {
        specific_force_mps2: Vector::new(R::ZERO, R::ZERO, n(9.81)),
        attitude: Attitude::LEVEL,
    };
    let range = RangeReading::level(n(0.8), n(0.02));
    let tag = TagReading {
        position_m: Vector::new(R::ZERO, R::ZERO, n(0.8)),
        covariance_m2: [
            [n(1e-6), R::ZERO, R::ZERO],
            [R::ZERO, n(1e-6), R::ZERO],
            [R::ZERO, R::ZERO, n(1e-6)],
        ],
        age_s: n(0.04),
    };
    (imu, [Reading::Range(range), Reading::Tag(tag)])
}

fn sensed<'a, R: Real>(imu: ImuSample<R>, readings: &'a [Reading<R>]) -> Sensed<'a, R> {
    Sensed {
        imu,
        readings,
        deck_normal: None,
        battery_share: R::from_f64(0.6),
        contact: None,
        request: OperatorRequest::None,
    }
}

fn hovers_then_descends<R: Real>() {
    let n = R::from_f64;
    let computer = computer::<R>();
    let mut state: State<R> = computer.initial(n(0.49));
    let (imu, readings) = at_rest::<R>();
    // Nothing seen yet: the weight, level.
    let output = computer.step(&mut state, &sensed(imu, &[]), n(0.01));
    let command = output.command.unwrap();
    assert_eq!(command.thrust_n.to_f64(), (n(1.37) * n(9.81)).to_f64());
    assert_eq!(command.attitude, Attitude::LEVEL);
    assert!(output.target.is_none());
    let mut descended_s = None;
    for i in 1..600 {
        let output = computer.step(&mut state, &sensed(imu, &readings), n(0.01));
        if i == 200 {
            // The deck has been seen for its shortest period, and 0.5 s were settled.
            assert_eq!(state.phase(), Phase::Wait);
            let estimate = output.estimate;
            // Seen two hundred times to 5 mm and better.
            assert!((estimate.height_m().to_f64() - 0.8).abs() < 2e-3);
            assert!(output.command.unwrap().attitude.tilt_rad().to_f64() < 1e-3);
        }
        if output.state_machine.phase == Phase::Descend && descended_s.is_none() {
            descended_s = Some(0.01 * f64::from(i));
            assert!(output.plan.is_some());
        }
    }
    // Not before the deck was watched for 3 s, at the planner's next look.
    let descended_s = descended_s.unwrap();
    assert!((2.99..3.15).contains(&descended_s), "{descended_s}");
}

#[test]
fn analytic_it_hovers_until_it_knows_and_descends_after_watching() {
    hovers_then_descends::<f64>();
    hovers_then_descends::<f32>();
}

#[test]
fn prop_readings_that_are_not_finite_never_begin_a_descent() {
    let computer = computer::<f64>();
    let (mut before, mut begun, mut waited) = (Phase::Approach, 0, false);
    let mut state: State<f64> = computer.initial(0.49);
    let (imu, readings) = at_rest::<f64>();
    for i in 0..1500 {
        // Good readings for long enough to settle, and bad ones.
        let bad = i % 120 > 80;
        let mut imu = imu;
        let mut readings = readings;
        if bad {
            imu.specific_force_mps2.x = f64::NAN;
            readings[0] = Reading::Range(RangeReading::level(f64::NAN, 0.02));
            readings[1] = Reading::Range(RangeReading::level(f64::INFINITY, f64::NAN));
        }
        let mut sensed = sensed(imu, &readings);
        sensed.deck_normal = bad.then_some(NormalReading {
            normal: Vector::new(f64::NAN, 0.0, 1.0),
            age_s: f64::NAN,
        });
        let output = computer.step(&mut state, &sensed, 0.01);
        let command = output.command.unwrap();
        assert!(command.thrust_n.is_finite() && command.attitude.is_finite());
        let phase = output.state_machine.phase;
        if phase == Phase::Descend && before != phase {
            begun += 1;
            let ages = [output.health.range.age_s, output.health.imu.age_s];
            assert!(ages[0] <= 0.15 && ages[1] <= 0.05, "{i} {ages:?}");
        }
        // A bad spell of 0.4 s ends every descent.
        assert!(i % 120 < 110 || phase != Phase::Descend, "{i}");
        assert!(!matches!(phase, Phase::Commit | Phase::Disarmed), "{i}");
        waited |= phase == Phase::Wait && bad;
        before = phase;
    }
    assert!(waited && begun > 0, "{waited} {begun}");
}

#[test]
fn analytic_the_attitude_of_a_late_reading_is_that_of_its_time() {
    let filter = RelativeFilter::<f64>::default();
    let mut state = filter.initial::<32, 32>();
    let rate = Vector::new(0.3, -0.2, 0.1);
    let at = |time_s: f64| Attitude::from_rotation_vector(rate * time_s);
    for i in 1..=50 {
        let imu = ImuSample {
            specific_force_mps2: Vector::UP * 9.81,
            attitude: at(0.01 * f64::from(i)),
        };
        filter.step(&mut state, &imu, &[], 0.01);
    }
    for age_s in [0.0, 0.01, 0.034, 0.2] {
        let error = filter.attitude_at(&state, age_s).inverse() * at(0.5 - age_s);
        // A chord for an arc of 4 mrad: its cube over 60.
        assert!(error.tilt_rad() < 1e-8, "{age_s} {}", error.tilt_rad());
    }
    // Older than remembered: the oldest, 31 steps ago.
    let error = filter.attitude_at(&state, 2.0).inverse() * at(0.19);
    assert!(error.tilt_rad() < 1e-12);
}

#[test]
fn prop_settings_that_cannot_be_are_refused_by_name() {
    let bad = Computer {
        watch_s: -1.0,
        ..computer::<f64>()
    };
    let error = bad.validate().unwrap_err().to_string();
    assert!(
        error.contains("computer.watch_s") && error.contains("-1"),
        "{error}"
    );
    let bad = Computer {
        known_sd_m: f64::NAN,
        ..computer::<f64>()
    };
    assert!(
        bad.validate()
            .unwrap_err()
            .to_string()
            .contains("known_sd_m")
    );
}

#[test]
fn analytic_a_vehicle_that_rises_with_a_deck_believes_the_satellites() {
    let computer = computer::<f64>();
    for rise_mps in [-3.0, -1.0, 0.0, 1.0, 3.0] {
        let mut state: State<f64> = computer.initial(0.49);
        let (imu, [range, tag]) = at_rest::<f64>();
        let gnss = Reading::Gnss(GnssVelocity {
            velocity_mps: Vector::new(0.3 * rise_mps, 0.0, rise_mps),
            age_s: 0.1,
        });
        let mut velocity_mps = Vector::ZERO;
        for i in 0..200 {
            // Tag at 25 Hz, satellites at 10 Hz, as they come: after the others.
            let readings: &[Reading<f64>] = match (i % 10, i % 4) {
                (9, _) => &[range, tag, gnss],
                (_, 0) => &[range, tag],
                _ => &[range],
            };
            let output = computer.step(&mut state, &sensed(imu, readings), 0.01);
            velocity_mps = output.estimate.velocity_mps;
        }
        // Twenty readings of 0.15 m/s, and the prior of a deck of 1 m/s, which holds back a tenth of 3 m/s.
        assert!(
            (velocity_mps.z - rise_mps).abs() < 0.3,
            "{rise_mps} {velocity_mps:?}"
        );
        assert!(
            (velocity_mps.x - 0.3 * rise_mps).abs() < 0.1,
            "{rise_mps} {velocity_mps:?}"
        );
    }
}
