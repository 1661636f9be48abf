//! Vertical landings of every method, and turns in space, compared with recorded ones: whatever
//! changes a command, a model or a figure of a landing shows here.

mod common;

use common::recorded::Means;
use common::{GRAVITY, MASS_KG, WEIGHT_N, lag, map, ratio};
use touchdown_flight::ground_effect::{
    Empirical, GroundEffectModel, Guarded, Outside, Polynomial, Validity,
};
use touchdown_flight::method::{Method, VerticalLanding, VerticalSettings};
use touchdown_flight::metrics::{LandingMetrics, LandingMetricsState};
use touchdown_flight::reference::{Reference, Terminal};
use touchdown_flight::thrust::{FirstOrder, StaticThrust, ThrustModel, ThrustState};
use touchdown_flight::vertical_controller::VerticalController;
use touchdown_flight::{Attitude, Measurement, Vector};

const W: f64 = core::f64::consts::PI;

const COLUMNS: [&str; 7] = [
    "height_m",
    "relative_mps",
    "thrust_n",
    "throttle",
    "ground_effect_n",
    "rotors_n",
    "path_m",
];

/// Lands on a deck that heaves 0.05 m at 0.5 Hz, lifted by the tests' map of height, and compares.
fn compare(controller: &VerticalController<f64>, name: &str) {
    controller.validate().unwrap();
    let (dt, metrics) = (0.01, LandingMetrics::<f64>::default());
    let throttle = controller.thrust.throttle_for(WEIGHT_N);
    let mut rotors = ThrustState {
        x: controller.thrust.rest(throttle),
    };
    let (mut height_m, mut velocity_mps, mut landed) = (0.7, 0.0, LandingMetricsState::default());
    let mut state = None;
    let mut means = Means::new(&COLUMNS, 50);
    for i in 0..900 {
        let t = dt * f64::from(i);
        let deck_mps = 0.05 * W * (W * t).cos();
        let deck_mps2 = -0.05 * W * W * (W * t).sin();
        let lifted_n = rotors.thrust_n() * (1.0 + map::<f64>().ratio(height_m));
        let mut measured = Measurement {
            height_m,
            relative_velocity_mps: velocity_mps,
            vehicle_velocity_mps: velocity_mps + deck_mps,
            acceleration_mps2: lifted_n / MASS_KG - GRAVITY,
        };
        // A reading that is not a number for 30 ms, and a height far beyond the data.
        match i {
            300..303 => measured.height_m = f64::NAN,
            310 => measured.acceleration_mps2 = f64::INFINITY,
            400..410 => measured.height_m = 1.1,
            _ => {}
        }
        let state = state.get_or_insert_with(|| controller.initial(&measured, throttle));
        let command = controller.step(state, &measured, dt);
        controller.thrust.step(&mut rotors, command.throttle, dt);
        let figures = metrics.step(&mut landed, height_m, velocity_mps, dt);
        velocity_mps += dt * (lifted_n / MASS_KG - GRAVITY - deck_mps2);
        height_m = (height_m + dt * velocity_mps).max(0.05);
        if height_m <= 0.05 {
            velocity_mps = 0.0;
        }
        means.add(&[
            height_m,
            velocity_mps,
            command.thrust_n,
            command.throttle,
            command.ground_effect_n,
            rotors.thrust_n(),
            figures.s_l_m + figures.t_l_s.unwrap_or_default() + figures.v_l_mps.unwrap_or_default(),
        ]);
    }
    means.compare(env!("CARGO_MANIFEST_DIR"), name);
}

fn landing() -> VerticalLanding<f64> {
    VerticalLanding {
        mass_kg: MASS_KG,
        gravity_mps2: GRAVITY,
        start_height_m: 0.7,
        deck_angular_frequency: Some(W),
        deck_acceleration: true,
    }
}

#[test]
fn regress_every_vertical_method() {
    for method in Method::VERTICAL {
        let model = Guarded::new(lag(), Validity::default());
        let controller = VerticalSettings::default()
            .controller(method, &landing(), ThrustModel::published(), model)
            .unwrap();
        compare(&controller, &format!("method_{}", method.name()));
    }
}

#[test]
fn regress_every_ground_effect_model_and_thrust_model() {
    let empirical = GroundEffectModel::Empirical(Empirical {
        mu: 1.9,
        rotor_radius_m: 0.12,
        rotor_offset_m: 0.02,
    });
    let first_order = ThrustModel::FirstOrder(FirstOrder {
        c0: 6.9,
        c1: 0.3,
        t_m_s: 0.06,
    });
    let cubic = ThrustModel::Static(StaticThrust {
        coefficients: [0.3, 6.0, 1.5, -0.8],
        t_m_s: 0.05,
    });
    let cases = [
        ("empirical", empirical, first_order),
        ("map", GroundEffectModel::StaticMap(map()), cubic),
        (
            "polynomial",
            GroundEffectModel::Polynomial(Polynomial::published()),
            first_order,
        ),
        ("ratio", ratio(), cubic),
        ("lag", lag(), cubic),
    ];
    for (k, (name, model, thrust)) in cases.into_iter().enumerate() {
        let validity = Validity {
            height_max_m: 0.6,
            outside: if k % 2 == 0 {
                Outside::Fade
            } else {
                Outside::Clamp
            },
            ..Validity::default()
        };
        let mut controller = VerticalSettings::default()
            .controller(
                Method::Dynamic,
                &landing(),
                thrust,
                Guarded::new(model, validity),
            )
            .unwrap();
        controller.reference = Reference::Terminal(Terminal {
            start_height_m: 0.7,
            end_height_m: 0.12,
            sink_rate_mps: 0.04,
            duration_s: 3.0 + 0.3 * k as f64,
        });
        compare(&controller, &format!("model_{name}"));
    }
}

#[test]
fn regress_turns_in_space() {
    let mut means = Means::new(
        &[
            "w",
            "x",
            "y",
            "z",
            "up_x",
            "up_y",
            "up_z",
            "tilt",
            "yaw",
            "rotated_x",
            "unrotated_y",
            "rotation_z",
            "between_w",
            "thrust_x",
            "limited_x",
            "cross_z",
            "dot",
        ],
        4,
    );
    let mut attitude = Attitude::from_yaw(0.4_f64);
    for i in 0..80 {
        let t = 0.1 * f64::from(i);
        let rates = Vector::new(
            (1.1 * t).sin(),
            0.7 * (0.9 * t).cos(),
            0.5 * (0.3 * t).sin(),
        );
        attitude = attitude.after(rates, 0.1);
        let other = Attitude::from_rotation_vector(rates);
        let towards = Vector::new(rates.x, rates.y, 2.0 + rates.z);
        let [w, x, y, z] = attitude.to_quaternion();
        let up = attitude.up();
        means.add(&[
            w,
            x,
            y,
            z,
            up.x,
            up.y,
            up.z,
            attitude.tilt_rad(),
            attitude.yaw_rad(),
            attitude.rotate(towards).x,
            attitude.inverse().unrotate(towards).y,
            attitude.rotation_vector().z,
            attitude.between(other, 0.3).to_quaternion()[0],
            Attitude::from_thrust_direction(towards, t).unwrap().up().x,
            towards.limited(2.1).x,
            towards.cross(rates).z,
            towards.dot(up),
        ]);
    }
    means.compare(env!("CARGO_MANIFEST_DIR"), "turns");
}
