//! The models that fly by default are those that identification finds today.

use touchdown_campaign::cards::put_into;
use touchdown_campaign::progress::Silent;
use touchdown_flight::ground_effect::GroundEffectModel;
use touchdown_flight::thrust::ThrustModel;
use touchdown_lander::models::FlightModels;
use touchdown_reproduce::experiments::identify_cards;
use touchdown_sim::landing::space::SpaceScenario;
use touchdown_sim::rig::RigSettings;

/// The same command finds the same digits; another platform's elementary functions move the
/// last ones, and the steps of the fit pass that on.
const RELATIVE: f64 = 1e-4;

fn same(name: &str, found: &[f64], kept: &[f64]) {
    for (i, (found, kept)) in found.iter().zip(kept).enumerate() {
        assert!(
            (found - kept).abs() <= RELATIVE * kept.abs(),
            "{name}[{i}]: identified {found}, flown {kept}; write crates/lander/src/models/fitted.rs anew: \
             cargo run --release -p touchdown --example default_models -- crates/lander/src/models/fitted.rs"
        );
    }
}

#[test]
fn regress_default_models_are_those_of_a_fresh_identification() {
    let strength = SpaceScenario::default().ground_effect_strength;
    is_identified(FlightModels::default(), strength);
    is_identified(FlightModels::paper(), 1.0);
}

fn is_identified(kept: FlightModels<f64>, strength: f64) {
    let mut rig = RigSettings::default();
    rig.plant.ground_effect_scale *= strength;
    let cards = identify_cards(&rig, 1, &Silent).unwrap();
    let mut fresh = kept;
    put_into(
        Some(&cards.thrust),
        cards.empirical.as_ref(),
        cards.dynamic.as_ref(),
        &mut fresh,
    )
    .unwrap();
    let (ThrustModel::Library(a), ThrustModel::Library(b)) = (fresh.thrust, kept.thrust) else {
        panic!("the thrust library of eq. (8)")
    };
    let array = |l: touchdown_flight::thrust::Library<f64>| {
        [l.one, l.x, l.s, l.s2, l.x3, l.s3, l.exp_neg_x_s, l.sin_x_s]
    };
    same("thrust", &array(a), &array(b));
    same("mu", &[fresh.mu], &[kept.mu]);
    let (GroundEffectModel::Lag(a), GroundEffectModel::Lag(b)) =
        (fresh.dynamic.model, kept.dynamic.model)
    else {
        panic!("the lag form")
    };
    same("h", &a.map.h, &b.map.h);
    same("k", &a.k, &b.k);
    same("tau_s", &[a.tau_s], &[b.tau_s]);
    assert_eq!(a.map.length_m, b.map.length_m);
    assert_eq!(fresh.dynamic.validity, kept.dynamic.validity);
    assert_eq!(fresh.dynamic.velocity, kept.dynamic.velocity);
}
