//! Identifies the models that fly by default and writes their coefficients as Rust:
//!
//! ```text
//! cargo run --release -p touchdown --example default_models -- crates/lander/src/models/fitted.rs
//! ```
//!
//! Thrust by eq. (8) with the plate removed, eq. (2) and the lag form on the rich data of the virtual rig, default
//! plant, seed 1. The test `default_models` compares the file with a fresh identification.

use std::fmt::Write as _;

use touchdown::experiments::identify_cards;
use touchdown_campaign::cards::put_into;
use touchdown_campaign::progress::Silent;
use touchdown_flight::ground_effect::GroundEffectModel;
use touchdown_flight::thrust::ThrustModel;
use touchdown_lander::models::FlightModels;
use touchdown_sim::rig::RigSettings;

const SEED: u64 = 1;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args()
        .nth(1)
        .ok_or("expected the file to write, such as crates/lander/src/models/fitted.rs")?;
    let cards = identify_cards(&RigSettings::default(), SEED, &Silent)?;
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
    let mut text = String::from(
        "//! Coefficients of the models that fly by default, identified on the virtual rig's rich data\n\
         //! (default plant, seed 1). Written by a command, not by hand:\n\
         //! `cargo run --release -p touchdown --example default_models -- crates/lander/src/models/fitted.rs`\n\n",
    );
    let mut constant = |doc: &str, name: &str, kind: &str, value: String| {
        writeln!(
            text,
            "/// {doc}\npub(super) const {name}: {kind} = {value};"
        )
    };
    let [one, x, s, s2, x3, s3, exp, sin] = [
        thrust.one,
        thrust.x,
        thrust.s,
        thrust.s2,
        thrust.x3,
        thrust.s3,
        thrust.exp_neg_x_s,
        thrust.sin_x_s,
    ];
    constant(
        "Eq. (8), in the order of `Library::TERMS`.",
        "THRUST",
        "[f64; 8]",
        format!("{:?}", [one, x, s, s2, x3, s3, exp, sin]),
    )?;
    constant("μ of eq. (2).", "MU", "f64", format!("{:?}", models.mu))?;
    constant(
        "The lag form's map h of height.",
        "LAG_H",
        "[f64; 4]",
        format!("{:?}", lag.map.h),
    )?;
    constant(
        "The lag form's terms in deck velocity, s/m.",
        "LAG_K",
        "[f64; 2]",
        format!("{:?}", lag.k),
    )?;
    constant(
        "The lag form's time constant, s.",
        "LAG_TAU_S",
        "f64",
        format!("{:?}", lag.tau_s),
    )?;
    std::fs::write(path, text)?;
    Ok(())
}
