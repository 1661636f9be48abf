//! The plant against closed forms and reference values.

use touchdown_sim::air::ground::{DeckSurface, WakeLag, rotor_force};
use touchdown_sim::body::plant::{Plant, PlantSettings, PlantState, Surface};

fn plant() -> Plant {
    Plant::new(&PlantSettings::default()).expect("defaults are valid")
}

/// Ground effect at rest with thrust equal to weight, N.
fn force_at_rest(plant: &Plant, height_m: f64) -> f64 {
    let state = PlantState {
        root_thrust: plant.weight_n().sqrt(),
        inflow: plant.target(height_m),
    };
    plant.force(&state, height_m, 0.0, 0.0).ground_effect_n
}

#[test]
fn analytic_inflow_fountain_plate_and_upwash() {
    let settings = PlantSettings::default();
    let law = WakeLag::new(&settings.wake()).expect("defaults are valid");
    let deck = DeckSurface::new(&settings.wake()).expect("defaults are valid");
    // Reference values: z_r, q_rot, q_ftn, E, P.
    for [z, rotor, fountain, plate, upwash] in [
        [0.10, 0.12274, 0.04756, 0.99838, 0.85093],
        [0.15, 0.07234, 0.05398, 0.99468, 0.77892],
        [0.20, 0.05046, 0.05228, 0.98783, 0.70977],
        [0.25, 0.03748, 0.04695, 0.97726, 0.64417],
        [0.30, 0.02883, 0.04071, 0.96270, 0.58264],
        [0.50, 0.01254, 0.02178, 0.86838, 0.38147],
        [0.80, 0.00531, 0.01002, 0.67582, 0.20009],
    ] {
        let images = law.image_sum(0, &[z; 4], &[1.0; 4]);
        // Half a unit of the fifth decimal, all four.
        assert!((images - rotor).abs() < 5.1e-6, "{z} {images}");
        assert!((law.fountain_share(z) - fountain).abs() < 5.1e-6, "{z}");
        assert!((deck.finite_plate(z) - plate).abs() < 5.1e-6, "{z}");
        assert!((deck.upwash(z) - upwash).abs() < 5.1e-6, "{z}");
    }
}

#[test]
fn analytic_image_sum_is_the_closed_form_of_four_rotors() {
    // Sanchez-Cuevas, Heredia & Ollero 2017, equal rotors.
    let law = WakeLag::new(&PlantSettings::default().wake()).expect("defaults are valid");
    let (r, d) = (0.12_f64, 0.32_f64);
    for i in 5..100 {
        let z = 0.01 * f64::from(i);
        let closed = (r / (4.0 * z)).powi(2)
            + r * r * z / (d * d + 4.0 * z * z).powf(1.5)
            + 0.5 * r * r * z / (2.0 * d * d + 4.0 * z * z).powf(1.5);
        // Rounding only.
        assert!((law.image_sum(0, &[z; 4], &[1.0; 4]) - closed).abs() < 1e-15);
    }
}

#[test]
fn analytic_level_vehicle_is_the_sum_of_four_rotors() {
    let settings = PlantSettings::default();
    let law = WakeLag::new(&settings.wake()).expect("defaults are valid");
    let deck = DeckSurface::new(&settings.wake()).expect("defaults are valid");
    let plant = plant();
    let hover_root = settings.weight_n().sqrt();
    for i in 0..60 {
        let height_m = 0.02 + 0.013 * f64::from(i);
        let z = height_m + settings.rotor_height_m;
        let (root, climb, heave) = (3.0 + 0.02 * f64::from(i), -0.3, 0.15);
        let speeds = [root; 4];
        let air_speed = climb - deck.upwash(z) * heave;
        let four: f64 = (0..4)
            .map(|i| {
                let inflow = [
                    law.rotor_target(z, law.image_sum(i, &[z; 4], &speeds)),
                    law.fountain_target(z),
                ];
                let ratio = WakeLag::lift_ratio(inflow);
                let damping = settings.climb_damping_ns_per_m / hover_root;
                rotor_force(root, ratio, damping, air_speed)
            })
            .sum();
        let state = PlantState {
            root_thrust: root,
            inflow: plant.target(height_m),
        };
        let level = plant.force(&state, height_m, climb, heave).ground_effect_n;
        // Rounding of sums of order 1.
        assert!((four - level).abs() < 1e-12, "{height_m}: {four} {level}");
    }
}

#[test]
fn analytic_lower_and_faster_rotors_feel_more() {
    // A tilted vehicle: rotors 0 and 3 (x > 0) lower than 1 and 2.
    let law = WakeLag::new(&PlantSettings::default().wake()).expect("defaults are valid");
    let heights = [0.14, 0.16, 0.16, 0.14];
    let low = law.image_sum(0, &heights, &[1.0; 4]);
    let high = law.image_sum(1, &heights, &[1.0; 4]);
    assert!(low > high);
    let own = |z: f64| (0.12 / (4.0 * z)).powi(2);
    // A neighbour at rest adds nothing: only the rotor's own image is left.
    let alone = law.image_sum(0, &heights, &[1.0, 0.0, 0.0, 0.0]);
    assert!((alone - own(0.14)).abs() < 1e-15);
}

#[test]
fn analytic_force_at_rest() {
    let plant = plant();
    for (height_m, force_n) in [
        (0.1, 1.9314),
        (0.15, 1.5182),
        (0.2, 1.2086),
        (0.3, 0.7724),
        (0.5, 0.3398),
        (0.75, 0.1407),
    ] {
        let found = force_at_rest(&plant, height_m);
        // Half a unit of the fourth decimal.
        assert!((found - force_n).abs() < 5.1e-5, "{height_m}: {found}");
    }
}

#[test]
fn analytic_step_of_height() {
    // z_r from 0.55 to 0.25 m at hover; rotor height is 0.05 m above z. Both
    // lags are exponentials with the time constants of z_r = 0.25 m.
    let plant = plant();
    let (from, to) = (plant.target(0.50), plant.target(0.20));
    let lags_s = [0.05 * 0.45 / 0.4, 0.28 * 0.85 / 0.8];
    let exact = |t: f64| -> [f64; 2] {
        std::array::from_fn(|j| to[j] + (from[j] - to[j]) * (-t / lags_s[j]).exp())
    };
    let throttle = plant.motor().throttle_for(plant.weight_n());
    let mut y = plant.rest(throttle, 0.50);
    let dt = 1e-4;
    for i in 1..=5000 {
        // Midpoint rule with a tenth of the plant's step.
        let rate = plant.derivative(&y, throttle, 0.20);
        let mut middle = y;
        for j in 0..2 {
            middle.inflow[j] += 0.5 * dt * rate.inflow[j];
        }
        let rate = plant.derivative(&middle, throttle, 0.20);
        for (j, expected) in exact(f64::from(i) * dt).into_iter().enumerate() {
            y.inflow[j] += dt * rate.inflow[j];
            // (dt/τ)²/6 of a step of 0.03 is 2e-8.
            assert!((y.inflow[j] - expected).abs() < 2e-8, "{i}");
        }
    }
    // Reference values with five decimals: t, rotor, fountain.
    for (t, rotor, fountain) in [(0.1, 0.03194, 0.02437), (0.5, 0.03662, 0.04028)] {
        let [q1, q2] = exact(t);
        assert!((q1 - rotor).abs() < 5.1e-6 && (q2 - fountain).abs() < 5.1e-6);
    }
    // At these times the reference, stepped at 1 ms to first order, is one unit of its last digit off.
    for (t, rotor, fountain) in [(0.05, 0.02523, 0.02044), (0.2, 0.03584, 0.03051)] {
        let [q1, q2] = exact(t);
        assert!(
            (q1 - rotor).abs() < 1.51e-5 && (q2 - fountain).abs() < 1.51e-5,
            "{q1} {q2}"
        );
    }
}

#[test]
fn analytic_hover_of_a_proportional_pilot() {
    // K_P Γ = 8 N/m: 8 z = W (q1* + q2*).
    for (scale, height_m) in [
        (0.3, 0.0728),
        (0.42, 0.0920),
        (0.6, 0.1173),
        (0.8, 0.1414),
        (1.0, 0.1622),
        (1.2, 0.1804),
    ] {
        let plant = Plant::new(&PlantSettings {
            ground_effect_scale: scale,
            ..PlantSettings::default()
        })
        .expect("valid settings");
        let excess = |z: f64| 8.0 * z - plant.weight_n() * plant.target(z).iter().sum::<f64>();
        let (mut low, mut high) = (0.01, 0.5);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if excess(middle) < 0.0 {
                low = middle;
            } else {
                high = middle;
            }
        }
        // Half a unit of the fourth decimal.
        assert!((low - height_m).abs() < 5.1e-5, "{scale}: {low}");
    }
}

#[test]
fn analytic_damping_of_climb_and_deck() {
    let plant = plant();
    let state = PlantState {
        root_thrust: plant.weight_n().sqrt(),
        inflow: plant.target(0.15),
    };
    let force = |v_q, v_p| plant.force(&state, 0.15, v_q, v_p).ground_effect_n;
    // At hover -k_v v_q, and +k_v P v_p with P(0.2 m) = 0.70977 (5 decimals).
    assert!((force(0.1, 0.0) - force(0.0, 0.0) + 0.079).abs() < 1e-12);
    assert!((force(0.0, 0.1) - force(0.0, 0.0) - 0.079 * 0.70977).abs() < 5e-7);
}

#[test]
fn analytic_surfaces() {
    let on = |surface| {
        Plant::new(&PlantSettings {
            surface,
            ..PlantSettings::default()
        })
        .expect("valid settings")
    };
    let (plate, ground, absent) = (on(Surface::Plate), on(Surface::Ground), on(Surface::Absent));
    for height_m in [0.05, 0.2, 0.8] {
        assert_eq!(absent.target(height_m), [0.0; 2]);
        assert!(force_at_rest(&ground, height_m) > force_at_rest(&plate, height_m));
        // On unbounded ground only v_q - v_p counts.
        let state = ground.rest(0.5, height_m);
        let together = ground.force(&state, height_m, 0.2, 0.2);
        assert_eq!(together, ground.force(&state, height_m, 0.0, 0.0));
    }
}

#[test]
fn analytic_second_plant() {
    let plant = Plant::new(&PlantSettings::exponential()).expect("defaults are valid");
    for z in [0.1_f64, 0.3, 0.8] {
        let expected = plant.weight_n() * 0.111 * (-5.39 * z).exp();
        // Rounding only.
        assert!((force_at_rest(&plant, z) - expected).abs() < 1e-12);
    }
    let away = PlantState {
        root_thrust: 3.0,
        inflow: [0.0; 2],
    };
    let rate = plant.derivative(&away, 0.4, 0.2).inflow[0];
    assert!((rate - plant.target(0.2)[0] / 0.15).abs() < 1e-12);
}

#[test]
fn prop_settings_survive_text_and_reject_unknown_keys() {
    let settings = PlantSettings::exponential();
    let text = toml::to_string(&settings).expect("plain settings");
    assert_eq!(toml::from_str::<PlantSettings>(&text), Ok(settings));
    let error = toml::from_str::<PlantSettings>("rotor_radius = 0.12")
        .expect_err("not a key")
        .to_string();
    assert!(error.contains("rotor_radius"), "{error}");
}

#[test]
fn prop_bad_settings_name_key_and_number() {
    let base = PlantSettings::default();
    let cases = [
        (
            PlantSettings {
                mass_kg: -1.5,
                ..base
            },
            "mass_kg",
            "-1.5",
        ),
        (
            PlantSettings {
                mass_kg: 2.5,
                ..base
            },
            "mass_kg",
            "2.5",
        ),
        (
            PlantSettings {
                rotor_spacing_m: 0.2,
                ..base
            },
            "rotor_spacing_m",
            "0.2",
        ),
        (
            PlantSettings {
                fountain_lag_s: 0.0,
                ..base
            },
            "fountain_lag_s",
            "0",
        ),
        (
            PlantSettings {
                turbulence: f64::NAN,
                ..base
            },
            "turbulence",
            "NaN",
        ),
        (
            PlantSettings {
                plate_side_m: f64::INFINITY,
                ..base
            },
            "plate_side_m",
            "inf",
        ),
    ];
    for (settings, key, number) in cases {
        let message = settings.validate().expect_err(key).to_string();
        assert!(message.contains(key), "{message}");
        assert!(message.contains(&format!("found {number}")), "{message}");
    }
}

proptest::proptest! {
    #[test]
    fn prop_force_and_rates_are_finite(
        root in 0.0_f64..5.0, q1 in -0.1_f64..1.0, q2 in -0.1_f64..1.0,
        z in -0.5_f64..10.0, v_q in -5.0_f64..5.0, v_p in -5.0_f64..5.0,
        throttle in -1.0_f64..2.0, second in proptest::bool::ANY,
    ) {
        let settings = if second { PlantSettings::exponential() } else { PlantSettings::default() };
        let plant = Plant::new(&settings).expect("defaults are valid");
        let state = PlantState { root_thrust: root, inflow: [q1, q2] };
        let rate = plant.derivative(&state, throttle, z);
        proptest::prop_assert!(plant.force(&state, z, v_q, v_p).total_n().is_finite());
        proptest::prop_assert!(rate.root_thrust.is_finite() && rate.inflow.iter().all(|r| r.is_finite()));
        proptest::prop_assert!(plant.turbulence_sd_n(&state, z) >= 0.0);
    }
}

#[test]
fn analytic_limits_of_inflow_and_lift() {
    // A rotor of 0.2 m radius near the plate: image sources beyond a half count as a half.
    let wide = Plant::new(&PlantSettings {
        rotor_radius_m: 0.2,
        rotor_spacing_m: 0.5,
        ..PlantSettings::default()
    })
    .expect("valid settings");
    let own: f64 = (0.2_f64 / (4.0 * 0.05)).powi(2);
    assert!(own > 0.5);
    let finite_plate = 1.0 - (1.0 + (0.846_284_f64 / 0.05).powi(2)).powf(-1.5);
    // The plate's side gives a to six digits.
    assert!((wide.target(0.0)[0] - 0.5 * finite_plate).abs() < 1e-8);
    // Together q1 and q2 count up to 0.6: a gain of 1/(1 - 0.6) = 2.5, a lift of 1.5 of the thrust.
    let most = wide.lift_ratio([0.5, 0.4]);
    assert!((most - 1.5).abs() < 1e-12, "{most}");
    assert!((wide.lift_ratio([0.1, 0.1]) - 0.25).abs() < 1e-12);
}
