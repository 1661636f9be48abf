//! Whether the parts of a scenario fit each other.

use std::f64::consts::FRAC_1_SQRT_2;

use super::scenario::SpaceScenario;
use crate::STEP_S;
use crate::body::contact::DEEPEST_M;
use crate::body::plant::Surface;
use crate::check::that;
use crate::error::SimError;
use touchdown_lander::settings::DescentShape;

/// Largest phase of a mode of the legs in one step, rad. Runge–Kutta of order four is
/// stable up to 2.8; half of it leaves room for heave, tilt and sliding together.
const MOST_TURN: f64 = 1.4;
/// Largest difference between the touchdown height of the settings and that of the feet, m.
const LANDED_M: f64 = 0.01;

/// Checks what no part can check by itself; every part is valid.
pub(super) fn check(scenario: &SpaceScenario) -> Result<(), SimError> {
    legs(scenario)?;
    feet(scenario)?;
    heights(scenario)
}

/// The feet, corners of a square, find room on a plate: a square fits there where its diagonal is no longer than the plate's.
fn feet(scenario: &SpaceScenario) -> Result<(), SimError> {
    let (plant, radius_m) = (&scenario.plant, scenario.legs.radius_m);
    if plant.surface == Surface::Ground {
        return Ok(());
    }
    let side_m = plant.plate_side_m;
    let most_m = side_m * FRAC_1_SQRT_2;
    let expected = format!(
        "a circle of feet that finds room on the deck, a plate of the side `plant.plate_side_m` = {side_m:.3} m: a radius of at most \
         {most_m:.3} m"
    );
    that(radius_m <= most_m, "legs.radius_m", &expected, radius_m)
}

/// The legs carry the weight, and are not too stiff for the step of the integration.
fn legs(scenario: &SpaceScenario) -> Result<(), SimError> {
    let (legs, plant) = (&scenario.legs, &scenario.plant);
    let weight_n = plant.mass_kg * plant.gravity_mps2;
    // At rest within half of what a foot may sink in.
    let least = weight_n / (4.0 * 0.5 * DEEPEST_M);
    let k = legs.stiffness_n_per_m;
    that(
        k >= least,
        "legs.stiffness_n_per_m",
        &format!("at least {least:.1}, for feet deeper than {DEEPEST_M} m stand on nothing"),
        k,
    )?;
    // What a force of one newton at every foot, up or to the side, moves at the feet.
    let [x, y, z] = scenario.body.inertia_kg_m2;
    let (r2, h2) = (legs.radius_m.powi(2), legs.depth_m.powi(2));
    let tilting = x.min(y);
    let heave = 4.0 / plant.mass_kg;
    let up = heave.max(2.0 * r2 / tilting);
    let aside = (heave + 4.0 * h2 / tilting).max(4.0 * r2 / z);
    let most = [
        (MOST_TURN / STEP_S).powi(2) / up,
        MOST_TURN / STEP_S / up,
        (MOST_TURN / STEP_S).powi(2) / aside,
        MOST_TURN / STEP_S / aside,
    ];
    let given = [
        ("legs.stiffness_n_per_m", k),
        ("legs.damping_ns_per_m", legs.damping_ns_per_m),
        (
            "legs.tangential_stiffness_n_per_m",
            legs.tangential_stiffness_n_per_m,
        ),
        (
            "legs.tangential_damping_ns_per_m",
            legs.tangential_damping_ns_per_m,
        ),
    ];
    for ((key, value), most) in given.into_iter().zip(most) {
        let expected =
            format!("at most {most:.1} for this mass and inertia and the step of {STEP_S} s");
        that(value <= most, key, &expected, value)?;
    }
    Ok(())
}

/// The computer's heights are those of a vehicle on its legs.
fn heights(scenario: &SpaceScenario) -> Result<(), SimError> {
    let (depth_m, control) = (scenario.legs.depth_m, &scenario.control);
    that(
        (scenario.landed_height_m - depth_m).abs() <= LANDED_M,
        "landed_height_m",
        &format!("the height of contact, `legs.depth_m` = {depth_m}, to {LANDED_M} m"),
        scenario.landed_height_m,
    )?;
    that(
        control.state_machine.touchdown_height_m > depth_m,
        "control.lander.touchdown_height_m",
        &format!("above contact, `legs.depth_m` = {depth_m}: else no touchdown is seen"),
        control.state_machine.touchdown_height_m,
    )?;
    let mut at_least = vec![("control.contact_height_m", control.contact_height_m)];
    if control.reference == DescentShape::Terminal {
        let end_m = control.planning.descent.end_height_m;
        at_least.push(("control.planning.descent.end_height_m", end_m));
    }
    for (key, value) in at_least {
        let expected = format!("at least the height of contact, `legs.depth_m` = {depth_m}");
        that(value >= depth_m, key, &expected, value)?;
    }
    Ok(())
}
