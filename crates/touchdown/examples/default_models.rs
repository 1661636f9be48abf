//! Identifies the models that fly by default and writes their coefficients as Rust:
//!
//! ```text
//! cargo run --release -p touchdown --example default_models -- crates/lander/src/models/fitted.rs
//! ```
//!
//! Thrust by eq. (8) with the plate removed, eq. (2) and the lag form on the rich data of the virtual rig, default
//! plant, seed 1, at the paper's ground effect and at that of measured quadrotors. The test `default_models` compares the file with a fresh identification.

use touchdown_campaign::cards::put_into;
use touchdown_campaign::progress::Silent;
use touchdown_flight::ground_effect::GroundEffectModel;
use touchdown_flight::thrust::ThrustModel;
use touchdown_lander::models::FlightModels;
use touchdown_reproduce::experiments::identify_cards;
use touchdown_sim::landing::space::SpaceScenario;
use touchdown_sim::rig::RigSettings;

const SEED: u64 = 1;

/// What stands before the models of the ground effect, but for the coefficients of eq. (8).
const HEAD: &str = "\
//! Coefficients of the models that fly by default, identified on the virtual rig's rich data
//! (default plant, seed 1). Written by a command, not by hand:
//! `cargo run --release -p touchdown --example default_models -- crates/lander/src/models/fitted.rs`

/// Models of the ground effect.
pub(super) struct GroundEffect {
    /// μ of eq. (2).
    pub(super) mu: f64,
    /// The lag form's map h of height.
    pub(super) h: [f64; 4],
    /// The lag form's terms in deck velocity, s/m.
    pub(super) k: [f64; 2],
    /// The lag form's time constant, s.
    pub(super) tau_s: f64,
}

";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args()
        .nth(1)
        .ok_or("expected the file to write, such as crates/lander/src/models/fitted.rs")?;
    let mut text = String::from(HEAD);
    let strength = SpaceScenario::default().ground_effect_strength;
    for (strength, name, doc) in [
        (1.0, "PAPER", "At the paper's ground effect.".to_string()),
        (strength, "MEASURED", format!("At {strength} of it.")),
    ] {
        let (library, ground_effect) = identified(strength, name, &doc)?;
        if strength == 1.0 {
            text += &library;
        }
        text += &ground_effect;
    }
    std::fs::write(path, text)?;
    Ok(())
}

/// The constants of thrust, and of the ground effect under a name.
fn identified(
    strength: f64,
    name: &str,
    doc: &str,
) -> Result<(String, String), Box<dyn std::error::Error>> {
    let mut rig = RigSettings::default();
    rig.plant.ground_effect_scale *= strength;
    let cards = identify_cards(&rig, SEED, &Silent)?;
    let mut models = FlightModels::default();
    put_into(
        Some(&cards.thrust),
        cards.empirical.as_ref(),
        cards.dynamic.as_ref(),
        &mut models,
    )?;
    let (ThrustModel::Library(thrust), GroundEffectModel::Lag(lag)) =
        (models.thrust, models.dynamic.model)
    else {
        return Err("expected the thrust library of eq. (8) and the lag form".into());
    };
    let terms = [
        thrust.one,
        thrust.x,
        thrust.s,
        thrust.s2,
        thrust.x3,
        thrust.s3,
        thrust.exp_neg_x_s,
        thrust.sin_x_s,
    ];
    let library = format!(
        "/// Eq. (8), in the order of `Library::TERMS`.\npub(super) const THRUST: [f64; 8] = {terms:#?};\n"
    );
    let (mu, h, k, tau_s) = (models.mu, lag.map.h, lag.k, lag.tau_s);
    let ground_effect = format!(
        "/// {doc}\npub(super) const {name}: GroundEffect = GroundEffect {{\n    mu: {mu:?},\n    h: {h:?},\n    \
         k: {k:?},\n    tau_s: {tau_s:?},\n}};\n"
    );
    Ok((library, ground_effect))
}
