//! Settings as data: every family there and back, unknown keys refused.
#![cfg(feature = "serde")]

use crate::common;

use common::{lag, map, ratio, vertical_controller};
use touchdown_flight::control::{Imbc, Law, Ssc};
use touchdown_flight::deck::HarmonicFilter;
use touchdown_flight::ground_effect::{Empirical, GroundEffectModel, Guarded, Polynomial};
use touchdown_flight::thrust::{FirstOrder, StaticThrust, ThrustModel};
use touchdown_flight::vertical_controller::VerticalController;

#[test]
fn prop_settings_round_trip() {
    let models = [
        GroundEffectModel::None,
        GroundEffectModel::Empirical(Empirical {
            mu: 1.9,
            rotor_radius_m: 0.12,
            rotor_offset_m: 0.0,
        }),
        GroundEffectModel::StaticMap(map()),
        GroundEffectModel::Polynomial(Polynomial::published()),
        ratio(),
        lag(),
    ];
    let thrusts = [
        ThrustModel::published(),
        ThrustModel::FirstOrder(FirstOrder {
            c0: 6.9,
            c1: 0.3,
            t_m_s: 0.06,
        }),
        ThrustModel::Static(StaticThrust {
            coefficients: [0.35, 8.0, -1.0, -2.5],
            t_m_s: 0.06,
        }),
    ];
    let laws = [
        vertical_controller::<f64>(GroundEffectModel::None).law,
        Law::Imbc(Imbc::new(3.0)),
        Law::Ssc(Ssc::default()),
    ];
    for (i, model) in models.into_iter().enumerate() {
        let mut controller = vertical_controller::<f64>(model);
        controller.thrust = thrusts[i % 3];
        controller.law = laws[i % 3];
        controller.deck = (i % 2 == 0).then(|| HarmonicFilter::new(3.0));
        let text = serde_json::to_string(&controller).unwrap();
        let back: VerticalController<f64> = serde_json::from_str(&text).unwrap();
        assert_eq!(back, controller);
    }
}

#[test]
fn prop_unknown_keys_are_refused() {
    let good = r#"{ "model": "none" }"#;
    assert!(serde_json::from_str::<Guarded<f64>>(good).is_ok());
    let bad = r#"{ "model": "none", "validty": 1 }"#;
    let error = serde_json::from_str::<Guarded<f64>>(bad).unwrap_err();
    assert!(error.to_string().contains("validty"), "{error}");
}
