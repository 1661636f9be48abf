//! Settings that are refused: the field of C's struct that is wrong, and what is expected there.

use super::*;

fn expected(setting: &td_setting) -> &str {
    // SAFETY: the interface ends the text with a zero.
    unsafe { CStr::from_ptr(setting.expected.as_ptr()) }
        .to_str()
        .unwrap()
}

/// The settings of the vertical controller with a change, as the interface judges them.
fn of_vertical(change: &dyn Fn(&mut td_vertical_settings)) -> (td_error, td_setting) {
    let mut settings = default(td_vertical_settings_default);
    change(&mut settings);
    let mut memory = memory();
    let (error, handle, setting) = vertical(&mut memory, &settings);
    assert_eq!(handle.is_null(), error != td_error::None);
    (error, setting)
}

fn of_computer(change: &dyn Fn(&mut td_computer_settings)) -> (td_error, td_setting) {
    let mut settings = default(td_computer_settings_default);
    change(&mut settings);
    let mut memory = memory();
    let (error, handle, setting) = computer(&mut memory, &settings);
    assert_eq!(handle.is_null(), error != td_error::None);
    (error, setting)
}

#[track_caller]
fn refused((error, setting): (td_error, td_setting), field: &str, text: &str, found: f64) {
    assert_eq!((error, name(&setting)), (td_error::Setting, field));
    assert_eq!(expected(&setting), text);
    assert!(
        setting.found == found || (setting.found.is_nan() && found.is_nan()),
        "{field}: {}",
        setting.found
    );
}

/// Numbers of a struct: the path in C and what sets it.
macro_rules! members {
    ($settings:ty: $($path:ident $(. $rest:ident)* $([$index:literal])?),+ $(,)?) => {
        [$((
            concat!(stringify!($path) $(, ".", stringify!($rest))* $(, "[", $index, "]")?),
            (|s, value| s.$path $(.$rest)* $([$index])? = value) as fn(&mut $settings, f32),
        )),+]
    };
}

#[test]
fn analytic_unusable_settings_are_named() {
    type Refused = (fn(&mut td_vertical_settings), td_error, &'static str);

    let refused: [Refused; 7] = [
        (
            |s| s.vehicle.mass_kg = f32::NAN,
            td_error::Setting,
            "vehicle.mass_kg",
        ),
        (
            |s| s.vehicle.gravity_mps2 = -9.81,
            td_error::Setting,
            "vehicle.gravity_mps2",
        ),
        (
            |s| s.vehicle.greatest_thrust_n = 0.1,
            td_error::Setting,
            "vehicle.greatest_thrust_n",
        ),
        (|s| s.method = 5, td_error::UnknownValue, "method"),
        (|s| s.method = u32::MAX, td_error::UnknownValue, "method"),
        (
            |s| s.models.thrust.form = 9,
            td_error::UnknownValue,
            "models.thrust.form",
        ),
        (
            |s| s.models.ground_effect.outside = 2,
            td_error::UnknownValue,
            "models.ground_effect.outside",
        ),
    ];
    for (change, error, setting) in refused {
        let (found, refused) = of_vertical(&change);
        assert_eq!((found, name(&refused)), (error, setting));
        assert!(!expected(&refused).is_empty());
    }
    let (error, setting) = of_computer(&|s| s.seeks_deck = 2);
    assert_eq!(
        (error, name(&setting), expected(&setting), setting.found),
        (td_error::UnknownValue, "seeks_deck", "0 or 1", 2.0)
    );
}

#[test]
fn prop_every_number_of_the_settings_that_is_nan_is_named() {
    let fields = members![td_vertical_settings:
        vehicle.mass_kg,
        vehicle.gravity_mps2,
        vehicle.greatest_thrust_n,
        models.ground_effect.height_min_m,
        models.ground_effect.height_max_m,
        models.ground_effect.ratio_min,
        models.ground_effect.ratio_max,
        start_height_m,
        end_height_m,
        descent_rate_per_s,
        deck_frequency_hz,
    ];
    for (path, set) in fields {
        let (error, setting) = of_vertical(&|s| set(s, f32::NAN));
        assert_eq!((error, name(&setting)), (td_error::Setting, path));
    }
    let fields = members![td_computer_settings:
        vehicle.mass_kg,
        vehicle.gravity_mps2,
        vehicle.rotor_radius_m,
        vehicle.greatest_thrust_n,
        sensors.imu_latency_s,
        sensors.range_quantum_m,
        sensors.range_min_m,
        sensors.range_max_m,
        sensors.range_jitter_s,
        sensors.camera_turn_rad,
        sensors.camera_jitter_s,
        period_s,
        command_delay_s,
        start_height_m,
    ];
    for (path, set) in fields {
        let (error, setting) = of_computer(&|s| set(s, f32::NAN));
        assert_eq!((error, name(&setting)), (td_error::Setting, path));
    }
    let positions =
        members![td_computer_settings: sensors.range_position_m[1], sensors.camera_position_m[2]];
    for (path, set) in positions {
        let (error, setting) = of_computer(&|s| set(s, f32::NAN));
        let array = path.split_once('[').unwrap().0;
        assert_eq!((error, name(&setting)), (td_error::Setting, array));
    }
    for (path, set) in members![td_vertical_settings: models.empirical_mu, vehicle.rotor_radius_m] {
        let empirical = |s: &mut td_vertical_settings| {
            s.method = td_method::Empirical as u32;
            set(s, f32::NAN);
        };
        let (error, setting) = of_vertical(&empirical);
        assert_eq!((error, name(&setting)), (td_error::Setting, path));
    }
}

#[test]
fn prop_every_coefficient_that_is_nan_is_named() {
    for (model, count) in thrusts_of_each_form() {
        for index in 0..count {
            let (error, setting) = of_vertical(&|s| {
                s.models.thrust = model;
                s.models.thrust.coefficients[index] = f32::NAN;
            });
            let path = format!("models.thrust.coefficients[{index}]");
            assert_eq!((error, name(&setting)), (td_error::Setting, &path[..]));
        }
    }
    for (form, count) in [
        (td_ground_effect_form::Empirical, 3),
        (td_ground_effect_form::StaticMap, 7),
        (td_ground_effect_form::Polynomial, 11),
        (td_ground_effect_form::Ratio, 12),
        (td_ground_effect_form::Lag, 10),
    ] {
        for index in 0..count {
            let (error, setting) = of_vertical(&|s| {
                s.models.ground_effect.form = form as u32;
                s.models.ground_effect.coefficients = [0.2; 12];
                s.models.ground_effect.coefficients[index] = f32::NAN;
            });
            let path = format!("models.ground_effect.coefficients[{index}]");
            assert_eq!((error, name(&setting)), (td_error::Setting, &path[..]));
        }
    }
    // A coefficient of the map may be below 0, a length may not.
    let negative = |s: &mut td_vertical_settings| {
        s.models.ground_effect.form = td_ground_effect_form::StaticMap as u32;
        s.models.ground_effect.coefficients = [0.2; 12];
        s.models.ground_effect.coefficients[3] = -1.0;
        s.models.ground_effect.coefficients[5] = -1.0;
    };
    refused(
        of_vertical(&negative),
        "models.ground_effect.coefficients[5]",
        "a finite number greater than 0",
        -1.0,
    );
}

/// A thrust model of each form with its number of coefficients.
fn thrusts_of_each_form() -> [(td_thrust_model, usize); 5] {
    let library = default(td_models_default).thrust.coefficients;
    let model = |form: td_thrust_form, coefficients| td_thrust_model {
        form: form as u32,
        coefficients,
    };
    let mut of_rotors = library;
    of_rotors[8] = 1.0;
    let cubic = [0.1, 5.0, 0.1, 0.1, 0.05, 0.0, 0.0, 0.0, 0.0];
    [
        (
            model(
                td_thrust_form::FirstOrder,
                [5.0, 0.1, 0.05, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
            ),
            3,
        ),
        (model(td_thrust_form::Library, library), 8),
        (model(td_thrust_form::Static, cubic), 5),
        (model(td_thrust_form::LaggedThrottle, cubic), 5),
        (model(td_thrust_form::LibraryOfRotors, of_rotors), 9),
    ]
}

#[test]
fn analytic_an_error_says_what_is_expected() {
    let positive = "a finite number greater than 0";
    refused(
        of_vertical(&|s| s.vehicle.mass_kg = 0.0),
        "vehicle.mass_kg",
        positive,
        0.0,
    );
    refused(
        of_vertical(&|s| s.end_height_m = 2.0),
        "end_height_m",
        "less than start_height_m",
        2.0,
    );
    refused(
        of_computer(&|s| s.sensors.range_max_m = 0.01),
        "sensors.range_min_m",
        "less than sensors.range_max_m",
        // The default, 0.02 m, in single precision.
        f64::from(0.02_f32),
    );
    refused(
        of_computer(&|s| s.start_height_m = f32::NEG_INFINITY),
        "start_height_m",
        positive,
        f64::NEG_INFINITY,
    );
}

#[test]
fn regress_a_thrust_that_does_not_carry_the_vehicle_is_refused() {
    let lift = "at least 1.3 times the weight, mass_kg times gravity_mps2";
    let heavy = |vehicle: &mut td_vehicle| vehicle.mass_kg = 100.0;
    let greatest_n = f64::from(20.4_f32);
    let field = "vehicle.greatest_thrust_n";
    refused(
        of_vertical(&|s| heavy(&mut s.vehicle)),
        field,
        lift,
        greatest_n,
    );
    refused(
        of_computer(&|s| heavy(&mut s.vehicle)),
        field,
        lift,
        greatest_n,
    );
    // The vehicle claims a thrust that its model does not give.
    let (error, setting) = of_vertical(&|s| {
        heavy(&mut s.vehicle);
        s.vehicle.greatest_thrust_n = 2000.0;
    });
    assert_eq!(
        (error, name(&setting), expected(&setting)),
        (
            td_error::Setting,
            "models.thrust.coefficients",
            "a greatest thrust of at least 1.3 times the weight"
        )
    );
    // Coefficients that nobody filled in.
    let mut models = default(td_models_default);
    models.thrust.coefficients = [0.0; 9];
    let (error, setting) = of_vertical(&|s| s.models = models);
    assert_eq!(
        (error, name(&setting)),
        (td_error::Setting, "models.thrust.coefficients")
    );
    let vehicle = default(td_vertical_settings_default).vehicle;
    let (mut throttle, mut setting) = (-1.0, SETTING);
    // SAFETY: variables of this frame.
    let error = unsafe {
        td_hover_throttle(
            &raw const vehicle,
            &raw const models,
            &raw mut throttle,
            &raw mut setting,
        )
    };
    assert_eq!(
        (error, name(&setting), throttle),
        (td_error::Setting, "models.thrust.coefficients", -1.0)
    );
}
