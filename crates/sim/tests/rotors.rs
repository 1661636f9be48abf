//! Four rotors over a tilted, finite deck: levelling torque, edge, turbulence.

use touchdown_sim::air::ground::DeckSurface;
use touchdown_sim::air::turbulence::RotorTurbulence;
use touchdown_sim::body::BodySettings;
use touchdown_sim::body::plant::{Plant, PlantSettings};
use touchdown_sim::body::rigid::{Disturbance, RigidVehicle};
use touchdown_sim::deck::rigid::DeckPose;
use touchdown_sim::random::{Purpose, Stream};

fn vehicle() -> RigidVehicle {
    RigidVehicle::new(&PlantSettings::default(), &BodySettings::default()).expect("valid settings")
}

/// Turn about one of the axes x, y, z.
fn turn(axis: usize, angle_rad: f64) -> [f64; 4] {
    let (sin, cos) = (0.5 * angle_rad).sin_cos();
    let mut q = [cos, 0.0, 0.0, 0.0];
    q[axis + 1] = sin;
    q
}

/// Torques about x and y of the rotors' forces at rest in the attitude q, the reference point at
/// `place_m` over a level deck, all rotors at hover.
fn torque_at_rest(vehicle: &RigidVehicle, place_m: [f64; 3], q: [f64; 4]) -> [f64; 2] {
    let deck = DeckPose::default();
    let (mut state, _) = vehicle.balanced(place_m[2], &deck);
    (state.position_m, state.attitude) = (place_m, q);
    let places = vehicle.places(&state, &deck, [0.0; 3]);
    let target = vehicle.rotors().target(&state.rotors.root_thrust, &places);
    (state.rotors.inflow, state.rotors.fountain) = (target.inflow, target.fountain);
    let loads = vehicle.loads(&state, &deck, &Disturbance::default());
    [0, 1].map(|k| loads.angular_acceleration[k] * vehicle.body().inertia_kg_m2[k])
}

#[test]
fn analytic_tilt_levels() {
    let five = 5.0_f64.to_radians();
    let vehicle = vehicle();
    for angle in [five, -five] {
        let [about_x, _] = torque_at_rest(&vehicle, [0.0, 0.0, 0.15], turn(0, angle));
        let [_, about_y] = torque_at_rest(&vehicle, [0.0, 0.0, 0.15], turn(1, angle));
        assert!(about_x * angle < 0.0 && about_y * angle < 0.0, "it levels");
        // A square vehicle over a square deck: the same about both axes.
        assert!((about_x.abs() - about_y.abs()).abs() < 1e-12);
        // 0.0092 N m at 0.15 m and 5° (rotors 0.20 m above the deck), 0.020 N m at 0.10 m: of the
        // order that is measured, 0.01 to 0.1 N m. The plain sums below, up to the
        // error of 2e-10 of the tables over the height, times 13 N × 0.16 m.
        for (height_m, about) in [(0.15, 0.0092), (0.10, 0.020)] {
            let place = [0.0, 0.0, height_m];
            let [found, _] = torque_at_rest(&vehicle, place, turn(0, angle));
            let expected = plain_levelling_torque(height_m, angle);
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
            assert!((found.abs() - about).abs() < 5e-4, "{found}");
        }
    }
    let at = |height_m: f64| torque_at_rest(&vehicle, [0.0, 0.0, height_m], turn(0, five))[0];
    assert!(
        at(0.10) < 2.0 * at(0.20) && at(0.20) < 3.0 * at(0.5),
        "it fades"
    );
    let level = torque_at_rest(&vehicle, [0.0, 0.0, 0.15], turn(2, 0.5));
    // Heading makes no tilt: only the square's corners turn.
    assert!(level[0].abs() < 1e-12 && level[1].abs() < 1e-12);
}

/// The torque about x of four equal rotors rolled by `angle` above the deck's centre, written out:
/// image sources, finite plate and its share of solid angle, fountain.
fn plain_levelling_torque(height_m: f64, angle: f64) -> f64 {
    let settings = PlantSettings::default();
    let plant = Plant::new(&settings).expect("valid settings");
    let thrust = plant
        .balanced(height_m, 0.0, 0.0, 0.0)
        .0
        .root_thrust
        .powi(2)
        / 4.0;
    let (radius, h_r, l) = (0.12_f64, 0.05, 0.75_f64);
    let a = l * 2.0 / std::f64::consts::PI.sqrt();
    let plate = |z: f64| 1.0 - (1.0 + (a / z).powi(2)).powf(-1.5);
    let solid = |[x, y, z]: [f64; 3]| {
        let mut sum = 0.0;
        for u in [l - x, l + x] {
            for v in [l - y, l + y] {
                sum += (u * v / (z * (u * u + v * v + z * z).sqrt())).atan();
            }
        }
        sum
    };
    let places = [[0.16, 0.16], [-0.16, 0.16], [-0.16, -0.16], [0.16, -0.16]].map(|[x, y]| {
        let (sin, cos) = angle.sin_cos();
        [x, y * cos - h_r * sin, height_m + y * sin + h_r * cos]
    });
    let share = places.map(|p| solid(p) / solid([0.16, 0.16, p[2]]));
    let z_c = places.iter().map(|p| p[2]).sum::<f64>() / 4.0;
    let b2 = 2.0 * 0.32 * 0.32;
    let fountain = plate(z_c) * share.iter().sum::<f64>() / 4.0 * 4.0 * radius * radius * z_c
        / (b2 + 4.0 * z_c * z_c).powf(1.5);
    let mut torque = 0.0;
    for (i, arm) in [0.16, 0.16, -0.16, -0.16].into_iter().enumerate() {
        let p = places[i];
        let images: f64 = places
            .iter()
            .map(|o| {
                let (s2, h) = ((p[0] - o[0]).powi(2) + (p[1] - o[1]).powi(2), p[2] + o[2]);
                radius * radius / 4.0 * h / (s2 + h * h).powf(1.5)
            })
            .sum();
        let q = plate(p[2]) * share[i] * images + fountain;
        torque += arm * thrust / (1.0 - q);
    }
    torque
}

#[test]
fn analytic_solid_angle_and_edge() {
    let deck = DeckSurface::new(&PlantSettings::default().wake()).expect("valid settings");
    let l = 0.75_f64;
    for [x, y, z] in [
        [0.0, 0.0, 0.05],
        [0.1, -0.3, 0.2],
        [0.74, 0.74, 0.05],
        [0.76, 0.2, 0.1],
        [2.0, -1.5, 0.3],
        [0.3, 0.1, 30.0],
    ] {
        let mut sum = 0.0;
        for a in [l - x, l + x] {
            for b in [l - y, l + y] {
                sum += (a * b / (z * (a * a + b * b + z * z).sqrt())).atan();
            }
        }
        // Rounding of a sum of angles.
        assert!(
            (deck.solid_angle([x, y, z]) - sum).abs() < 1e-14,
            "{x} {y} {z}"
        );
    }
    let far = deck.solid_angle([0.0, 0.0, 100.0]);
    // Area over distance squared, less the cosine and spread: (1.5/100)².
    assert!((far / (1.5 * 1.5 / 1e4) - 1.0).abs() < 2e-4);
    let share = |x: f64| deck.edge_share([x, 0.16, 0.15], 0.16);
    assert!((deck.edge_share([0.16, -0.16, 0.15], 0.16) - 1.0).abs() < 1e-15);
    // Over the edge half the plane is missing; the other edges a little of the centre's.
    assert!((share(0.75) - 0.5).abs() < 0.06, "{}", share(0.75));
    // Just inside and just outside an edge add up to a whole, as far as the other edges let them.
    assert!((share(0.6) + share(0.9) - 2.0 * share(0.75)).abs() < 0.03);
    assert!(share(0.6) > 0.75 && share(0.9) < 0.3);
    // Far outside: area × z/distance³ = 2.25 × 0.15/27 over about 5.
    assert!(share(3.0) < 3e-3, "{}", share(3.0));
    for beyond in [1e3, 1e6, 1e9] {
        assert!(share(beyond) < 1e-5);
    }
}

#[test]
fn analytic_over_the_edge_the_inner_rotors_lift() {
    // Centre of the vehicle above the deck's left edge: rotors 0 and 1 hang over it.
    let [about_x, about_y] = torque_at_rest(&vehicle(), [0.0, 0.75, 0.15], turn(0, 0.0));
    // More lift on the right turns the vehicle to the left: about x, negative y pushes up.
    assert!(about_x < -0.01, "{about_x}");
    assert!(about_y.abs() < 1e-12, "{about_y}");
    // Far outside nothing is left of the deck.
    let deck = DeckPose::default();
    let (mut state, _) = vehicle().balanced(0.15, &deck);
    state.position_m[0] = 50.0;
    let places = vehicle().places(&state, &deck, [0.0; 3]);
    let target = vehicle()
        .rotors()
        .target(&state.rotors.root_thrust, &places);
    assert!(target.inflow[0] < 1e-6 && target.fountain < 1e-6 && target.upwash[0] < 1e-6);
}

#[test]
fn analytic_turbulence_of_four_rotors_adds_up() {
    let vehicle = vehicle();
    let (state, _) = vehicle.balanced(0.15, &DeckPose::default());
    let loads = vehicle.loads(&state, &DeckPose::default(), &Disturbance::default());
    let root = state.rotors.root_thrust;
    let sd = vehicle.rotors().turbulence_sd_n(&root, &loads.target);
    let plant = vehicle.rotors().plant();
    let (one, _) = plant.balanced(0.15, 0.0, 0.0, 0.0);
    let whole = plant.turbulence_sd_n(&one, 0.15);
    // Four of correlation 0.5: √10 of one. Rounding only.
    assert!((sd[0] * 10.0_f64.sqrt() - whole).abs() < 1e-12);
    let stream = Stream::new(4, 0, Purpose::Turbulence);
    let mut turbulence = RotorTurbulence::new(stream, 0.15, 0.01, sd);
    let (mut total, mut product, mut square) = (0.0, 0.0, 0.0);
    for _ in 0..200_000 {
        let n = turbulence.step(sd);
        total += n.iter().sum::<f64>().powi(2);
        product += n[0] * n[2];
        square += n[1] * n[1];
    }
    // 2000 s hold 6700 independent values: 1.7 % of a variance; 4 of these.
    assert!((total / 2e5 / (whole * whole) - 1.0).abs() < 0.07);
    assert!((product / square - 0.5).abs() < 0.07);
}
