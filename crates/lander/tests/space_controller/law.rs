//! One step at a time.

use proptest::prelude::*;
use touchdown_flight::control::{Imbc, Law, Ssc};
use touchdown_flight::deck::HarmonicFilter;
use touchdown_flight::ground_effect::{Empirical, GroundEffectModel, Polynomial};
use touchdown_flight::vertical_controller::VerticalController;
use touchdown_flight::{Attitude, Measurement, Real, Vector};
use touchdown_lander::control::{Adaptation, Observer};
use touchdown_lander::space_controller::{Motion, SpaceCommand, SpaceController, Target};

use crate::common::flight::{WEIGHT_N, lag, map, ratio, vertical_controller};
use crate::plant::{hover_throttle, rotors, space_controller};

fn models<R: Real>() -> [GroundEffectModel<R>; 5] {
    [
        GroundEffectModel::None,
        lag(),
        ratio(),
        GroundEffectModel::Polynomial(Polynomial::published()),
        GroundEffectModel::Empirical(Empirical {
            mu: R::from_f64(1.9),
            rotor_radius_m: R::from_f64(0.12),
            rotor_offset_m: R::from_f64(0.05),
        }),
    ]
}

fn laws<R: Real>() -> [Law<R>; 3] {
    [
        vertical_controller(GroundEffectModel::None).law,
        Law::Imbc(Imbc::new(R::from_f64(3.0))),
        Law::Ssc(Ssc::default()),
    ]
}

fn level<R: Real>(m: &Measurement<R>) -> Motion<R> {
    let up = |value| Vector::new(R::ZERO, R::ZERO, value);
    Motion {
        position_m: up(m.height_m),
        relative_velocity_mps: up(m.relative_velocity_mps),
        vehicle_velocity_mps: up(m.vehicle_velocity_mps),
        acceleration_mps2: up(m.acceleration_mps2),
        attitude: Attitude::LEVEL,
        deck_normal: Vector::UP,
    }
}

fn same_as_the_vertical_controller<R: Real>() {
    let n = R::from_f64;
    for model in models() {
        for law in laws() {
            let filter = HarmonicFilter::new(n(3.0));
            let vertical: VerticalController<R> = VerticalController {
                law,
                thrust: rotors(),
                deck: Some(filter),
                ..vertical_controller(model)
            };
            let space: SpaceController<R> = SpaceController {
                law,
                ..space_controller(model)
            };
            let start = Measurement {
                height_m: n(0.8),
                ..Measurement::default()
            };
            let throttle = n(hover_throttle());
            let mut one = vertical.initial(&start, throttle);
            let mut three = space.initial(&level(&start), throttle);
            let mut deck = filter.initial();
            for i in 0..600_u16 {
                let t = 0.01 * f64::from(i);
                let m = Measurement {
                    height_m: n(0.8 - 0.11 * t + 0.02 * (7.0 * t).sin()),
                    relative_velocity_mps: n(-0.11 + 0.3 * (7.0 * t).cos()),
                    vehicle_velocity_mps: n(0.2 * (3.0 * t).sin()),
                    acceleration_mps2: n(0.6 * (3.0 * t).cos()),
                };
                let target = Target {
                    vertical: vertical.reference.at(one.time_s()),
                    deck_acceleration_mps2: Vector::new(
                        R::ZERO,
                        R::ZERO,
                        filter
                            .step(&mut deck, m.deck_velocity_mps(), n(0.01))
                            .acceleration_mps2,
                    ),
                    ..Target::default()
                };
                let wanted = vertical.step(&mut one, &m, n(0.01));
                let found = space.step(&mut three, &level(&m), &target, n(0.01));
                // To the bit: one law, one code.
                assert_eq!(wanted.thrust_n, found.thrust_n, "{i}");
                assert_eq!(wanted.throttle, found.throttle, "{i}");
                assert_eq!(wanted.ground_effect_n, found.ground_effect_n, "{i}");
                assert_eq!(found.attitude, Attitude::LEVEL);
            }
        }
    }
}

#[test]
fn analytic_level_and_centred_it_is_the_autopilot() {
    same_as_the_vertical_controller::<f64>();
    same_as_the_vertical_controller::<f32>();
}

fn hovering(height_m: f64) -> Motion<f64> {
    Motion {
        deck_normal: Vector::UP,
        position_m: Vector::new(0.0, 0.0, height_m),
        ..Motion::default()
    }
}

fn target(height_m: f64) -> Target<f64> {
    let mut target = Target::default();
    target.vertical.height_m = height_m;
    target
}

#[test]
fn analytic_tilt_is_made_up_for() {
    // A family with a ratio, and one with a force.
    for model in [
        lag(),
        GroundEffectModel::Polynomial(Polynomial::published()),
    ] {
        let controller = space_controller::<f64>(model);
        for angle in [0.1, 0.3, 0.6] {
            let mut motion = hovering(0.2);
            // In rest at the target: weight is what is wanted upward.
            let mut state = controller.initial(&motion, hover_throttle());
            let rotation = Vector::new(0.6 * angle, -0.8 * angle, 0.0);
            motion.attitude = Attitude::from_rotation_vector(rotation);
            let command = controller.step(&mut state, &motion, &target(0.2), 0.01);
            let lift = match model {
                GroundEffectModel::Polynomial(_) => command.ground_effect_n,
                _ => {
                    let at = state.vertical.thrust.thrust_n();
                    command.ground_effect_n / at * command.thrust_n
                }
            };
            let upward = (command.thrust_n + lift) * angle.cos();
            // Roundings of forces of ten newtons.
            assert!((upward - WEIGHT_N).abs() < 1e-12, "{angle} {upward}");
        }
        // More than there is.
        let mut motion = hovering(0.2);
        let mut state = controller.initial(&motion, hover_throttle());
        motion.attitude = Attitude::from_rotation_vector(Vector::new(3.0, 0.0, 0.0));
        let command = controller.step(&mut state, &motion, &target(0.2), 0.01);
        assert_eq!(command.thrust_n, 20.4);
        assert!(command.saturated);
    }
    // Beyond 60 degrees no more is made up for than at 60: twice the weight.
    let mut strong = space_controller::<f64>(GroundEffectModel::None);
    strong.limits.thrust_max_n = 100.0;
    let mut motion = hovering(0.2);
    let mut state = strong.initial(&motion, hover_throttle());
    motion.attitude = Attitude::from_rotation_vector(Vector::new(0.0, 1.3, 0.0));
    let command = strong.step(&mut state, &motion, &target(0.2), 0.01);
    assert!((command.thrust_n - 2.0 * WEIGHT_N).abs() < 1e-12);
}

#[test]
fn analytic_horizontal_law_and_attitude() {
    let controller = space_controller::<f64>(GroundEffectModel::None);
    let mut motion = hovering(0.5);
    motion.position_m += Vector::new(0.1, -0.05, 0.0);
    motion.relative_velocity_mps = Vector::new(0.02, 0.03, 0.0);
    let mut state = controller.initial(&motion, hover_throttle());
    let goal = Target {
        velocity_mps: Vector::new(0.05, 0.0, 0.0),
        deck_acceleration_mps2: Vector::new(0.2, 0.1, 0.0),
        yaw_rad: 0.7,
        ..target(0.5)
    };
    let command = controller.step(&mut state, &motion, &goal, 0.01);
    let a = Vector::new(
        0.2 - 3.2 * 0.1 - 3.2 * (0.02 - 0.05),
        0.1 + 3.2 * 0.05 - 3.2 * 0.03,
        9.81,
    );
    // m (a + g) points along the axis asked for; roundings of numbers below ten.
    assert!(command.attitude.up().cross(a).norm() < 1e-13);
    assert!((command.attitude.yaw_rad() - 0.7).abs() < 0.02);
    assert!(!command.limited && !command.saturated);
    // A step integrates s = (v - v_ref) + (k_p/k_d) e, times k_i dt.
    let s = Vector::new(0.02 - 0.05 + 0.1, 0.03 - 0.05, 0.0);
    let moved = state.horizontal.integral_mps2;
    assert!((moved - s * (0.8 * 0.01)).norm() < 1e-16);

    // Far away: towards the target at the tilt limit, and no integral.
    motion.position_m = Vector::new(30.0, 40.0, 0.5);
    motion.relative_velocity_mps = Vector::ZERO;
    let mut state = controller.initial(&motion, hover_throttle());
    let command = controller.step(&mut state, &motion, &target(0.5), 0.01);
    let up = command.attitude.up();
    // The speed limit 1 m/s times 3.2 1/s is above the 3 m/s² allowed.
    assert!((command.attitude.tilt_rad() - (3.0_f64 / 9.81).atan()).abs() < 1e-13);
    assert!(up.x < 0.0 && (up.y / up.x - 4.0 / 3.0).abs() < 1e-12);
    assert!(command.limited);
    assert_eq!(state.horizontal.integral_mps2, Vector::ZERO);
}

#[test]
fn prop_integrals_stand_at_zero_while_another_controller_flies() {
    let controller = space_controller(lag());
    let motion = Motion {
        position_m: Vector::new(0.2, -0.1, 0.6),
        relative_velocity_mps: Vector::new(0.1, 0.0, -0.2),
        ..hovering(0.6)
    };
    let fly = |flown: Option<SpaceCommand<f64>>| {
        let mut state = controller.initial(&hovering(0.8), hover_throttle());
        for _ in 0..50 {
            controller.step(&mut state, &motion, &target(0.8), 0.01);
            if let Some(command) = &flown {
                controller.replace(&mut state, command);
            }
        }
        state
    };
    let own = fly(None);
    let other = SpaceCommand {
        thrust_n: 0.9 * WEIGHT_N,
        throttle: 0.4,
        attitude: Attitude::from_yaw(0.3),
        ..SpaceCommand::default()
    };
    let replaced = fly(Some(other));
    let none = controller.law.initial(other.thrust_n);
    assert!(own.horizontal.integral_mps2 != Vector::ZERO && own.vertical.law != none);
    assert_eq!(replaced.horizontal.integral_mps2, Vector::ZERO);
    assert_eq!(replaced.vertical.law, none);
    let command = replaced.vertical.command;
    assert_eq!((command.thrust_n, command.throttle), (other.thrust_n, 0.4));
}

#[test]
fn analytic_the_height_is_along_the_decks_normal() {
    let controller = space_controller::<f64>(models()[4]);
    let lift = |attitude: Attitude<f64>, normal: Vector<f64>, position_m: Vector<f64>| {
        let motion = Motion {
            attitude,
            deck_normal: normal,
            position_m,
            ..Motion::default()
        };
        controller
            .initial(&motion, hover_throttle())
            .vertical
            .command
    };
    let flat = lift(Attitude::LEVEL, Vector::UP, Vector::new(0.0, 0.0, 0.1));
    // The rotor plane is 0.05 m above the reference point.
    let q = 1.9 * (0.12_f64 / (4.0 * 0.15)).powi(2);
    assert!((flat.ground_effect_n / flat.thrust_n - q / (1.0 - q)).abs() < 1e-13);
    // Deck and vehicle turned together: as level, wherever along the deck.
    let rolled = Attitude::from_rotation_vector(Vector::new(0.1, 0.0, 0.0));
    let normal = rolled.up();
    let aside = rolled.rotate(Vector::new(0.3, -0.2, 0.1));
    for position_m in [normal * 0.1, aside] {
        let both = lift(rolled, normal, position_m);
        assert!((both.ground_effect_n - flat.ground_effect_n).abs() < 1e-13);
    }
}

#[test]
fn analytic_ground_effect_is_reckoned_along_the_decks_normal() {
    let controller = space_controller::<f64>(lag());
    let normal = Vector::new(0.3, 0.0, 1.0).direction().unwrap();
    let motion = Motion {
        position_m: Vector::new(0.2, 5.0, 0.15),
        deck_normal: normal,
        ..Motion::default()
    };
    let command = controller
        .initial(&motion, hover_throttle())
        .vertical
        .command;
    let height_m = (0.2 * 0.3 + 0.15) / 1.09_f64.sqrt();
    let expected = map::<f64>().ratio(height_m) * command.thrust_n;
    assert!((command.ground_effect_n - expected).abs() < 1e-13);
}

#[test]
fn analytic_thrust_is_taken_back_along_the_deck() {
    let controller = space_controller::<f64>(lag());
    let normal = Vector::new(0.05, -0.02, 1.0);
    let motion = Motion {
        deck_normal: normal,
        ..hovering(0.1)
    };
    let mut state = controller.initial(&motion, hover_throttle());
    let mut last = state.vertical.command.thrust_n;
    for _ in 0..100 {
        let command = controller.idle(&mut state, &motion, 40.0, 0.01);
        // 0.4 N a step, down to the least.
        assert!((command.thrust_n - (last - 0.4).max(0.5)).abs() < 1e-13);
        assert!(command.attitude.up().cross(normal).norm() < 1e-14);
        last = command.thrust_n;
    }
    assert_eq!(last, 0.5);
    assert_eq!(state.disturbance_n, Vector::ZERO);
}

#[test]
fn regress_thrust_is_taken_back_from_what_was_asked_for() {
    let mut controller = space_controller::<f64>(GroundEffectModel::None);
    controller.motor_lag_share = 0.5;
    let motion = hovering(0.6);
    for target_m in [0.5, 0.7] {
        let mut state = controller.initial(&motion, hover_throttle());
        let command = controller.step(&mut state, &motion, &target(target_m), 0.01);
        let asked_n = state.demand_n;
        // The command leads the demand, away from the thrust now.
        let ahead_n = (command.thrust_n - asked_n) * (target_m - 0.6).signum();
        assert!(ahead_n > 0.1, "{command:?}");
        // At 10 N/s: a tenth of a newton less than what was asked for, not than the command. Roundings.
        let first = controller.idle(&mut state, &motion, 10.0, 0.01);
        assert!(
            (first.thrust_n - (asked_n - 0.1)).abs() < 1e-12,
            "{first:?}"
        );
        let second = controller.idle(&mut state, &motion, 10.0, 0.01);
        assert!((second.thrust_n - (asked_n - 0.2)).abs() < 1e-12);
    }
}

#[test]
fn regress_a_tag_that_flips_on_the_deck_does_not_tip_the_vehicle() {
    let controller = space_controller::<f64>(lag());
    // Twice the tilt of a deck on which it lands.
    let limit_rad = 0.3_f64;
    for tilt_rad in [0.2_f64, 1.31, 1.57, 3.0] {
        let motion = Motion {
            deck_normal: Vector::new(0.6 * tilt_rad.sin(), 0.8 * tilt_rad.sin(), tilt_rad.cos()),
            ..hovering(0.1)
        };
        let mut state = controller.initial(&motion, hover_throttle());
        let command = controller.idle(&mut state, &motion, 40.0, 0.01);
        let found = command.attitude.tilt_rad();
        // Rounding; near a level thrust the direction is not defined, and the last attitude is kept.
        assert!(
            found <= tilt_rad.min(limit_rad) + 1e-9,
            "{tilt_rad}: {found}"
        );
    }
}

#[test]
fn analytic_settings_are_checked() {
    let refused = |change: fn(&mut SpaceController<f64>), key: &str| {
        let mut bad = space_controller(GroundEffectModel::None);
        change(&mut bad);
        let error = bad.validate().unwrap_err().to_string();
        assert!(error.starts_with(key), "{error}");
    };
    refused(|p| p.mass_kg = -1.0, "mass_kg");
    refused(|p| p.motor_lag_share = 0.49, "computer.motor_lag_share");
    refused(|p| p.motor_lag_share = 1.01, "computer.motor_lag_share");
    refused(|p| p.motor_lag_share = f64::NAN, "computer.motor_lag_share");
    refused(|p| p.horizontal.tilt_limit_rad = 1.2, "horizontal.tilt");
    refused(
        |p| p.horizontal.integral_per_s2 = -1.0,
        "horizontal.integral_per_s2",
    );
    refused(|p| p.delays.sensing_s = -0.01, "delays.sensing_s");
    refused(
        |p| {
            p.observer = Some(Observer {
                filter_s: 0.0,
                ..Observer::default()
            });
        },
        "observer.filter_s",
    );
    refused(
        |p| {
            p.adaptation = Some(Adaptation {
                strength_min: 3.0,
                ..Adaptation::default()
            });
        },
        "adaptation.strength_min",
    );
}

proptest! {
    #[test]
    fn prop_commands_are_finite_and_within_limits(
        values in proptest::collection::vec(proptest::num::f32::ANY, 26 * 12),
        dts in proptest::collection::vec(proptest::num::f32::ANY, 12),
        model in 0..5_usize,
        law in 0..3_usize,
        share in 0.5..=1.0_f32,
        hold in any::<bool>(),
    ) {
        let controller = SpaceController::<f32> {
            law: laws()[law],
            motor_lag_share: share,
            observer: Some(Observer::default()),
            adaptation: Some(Adaptation::default()),
            ..space_controller(models()[model])
        };
        let vector = |v: &[f32]| Vector::new(v[0], v[1], v[2]);
        let motion = |v: &[f32]| Motion {
            position_m: vector(v),
            relative_velocity_mps: vector(&v[3..]),
            vehicle_velocity_mps: vector(&v[6..]),
            acceleration_mps2: vector(&v[9..]),
            attitude: Attitude::from_quaternion([v[12], v[13], v[14], v[15]])
                .unwrap_or_default(),
            deck_normal: vector(&v[16..]),
        };
        let mut state = controller.initial(&motion(&values), values[0]);
        for (v, dt) in values.chunks(26).zip(&dts) {
            let mut goal = Target {
                position_m: vector(&v[17..]),
                velocity_mps: vector(&v[18..]),
                deck_acceleration_mps2: vector(&v[20..]),
                yaw_rad: v[23],
                hold_estimates: hold,
                ..Target::default()
            };
            goal.vertical.height_m = v[24];
            goal.vertical.acceleration_mps2 = v[25];
            let command = controller.step(&mut state, &motion(v), &goal, *dt);
            prop_assert!((0.5..=20.4).contains(&command.thrust_n), "{command:?}");
            prop_assert!((0.05..=1.0).contains(&command.throttle), "{command:?}");
            prop_assert!(command.ground_effect_n.is_finite());
            prop_assert!(command.attitude.is_finite());
            // The tilt asked for stays within its limit; f32 roundings.
            prop_assert!(command.attitude.tilt_rad() < 0.7001, "{command:?}");
            prop_assert!(state.disturbance_n.norm() < 12.001);
            prop_assert!(state.horizontal.integral_mps2.norm() < 0.5001);
        }
        // And after it, sensible samples for fifteen seconds: at the target, accelerated
        // as the command would in free air.
        let mut good = Motion {
            position_m: Vector::new(0.0, 0.0, 0.4),
            deck_normal: Vector::UP,
            ..Motion::default()
        };
        let mut goal = Target::default();
        goal.vertical.height_m = 0.4;
        let mut command = controller.step(&mut state, &good, &goal, 0.01);
        for _ in 0..1500 {
            let up = command.attitude.up();
            good.acceleration_mps2 = up * (command.thrust_n / controller.mass_kg) - Vector::UP * 9.81;
            command = controller.step(&mut state, &good, &goal, 0.01);
        }
        prop_assert!((0.5..=20.4).contains(&command.thrust_n), "{command:?}");
        // Back at the target, no force to the side but what the integral (0.5 m/s² at
        // most) has left to lose.
        let side_n = (command.thrust_n + command.ground_effect_n) * command.attitude.tilt_rad().sin();
        prop_assert!(side_n < 1.05 * 0.5 * controller.mass_kg, "{side_n} {command:?}");
    }
}
