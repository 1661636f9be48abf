//! What campaigns fly is what `touchdown-flight` and `touchdown-lander` build from their own
//! defaults.

use std::path::Path;

use touchdown_campaign::sweep::{Sweep, SweepSettings};
use touchdown_campaign::vertical::controllers::{Cards, controller};
use touchdown_campaign::vertical::settings::LandSettings;
use touchdown_flight::Method;
use touchdown_flight::ground_effect::{GroundEffectModel, Guarded, Validity};
use touchdown_flight::method::{C_DECK_PER_S, Feedforward, VerticalLanding, VerticalSettings};
use touchdown_lander::models::FlightModels;
use touchdown_lander::settings::{
    ControlSettings, DescentShape, LoopTiming, SensorNumbers, VehicleNumbers,
};
use touchdown_model::{Card, published};

#[test]
fn prop_campaigns_fly_the_defaults_of_the_lander() {
    for method in Method::ALL {
        for reference in [DescentShape::Terminal, DescentShape::Exponential] {
            let control = ControlSettings {
                method,
                reference,
                ..ControlSettings::default()
            };
            let start_height_m = 0.8;
            let own = control
                .computer(
                    &FlightModels::default(),
                    &VehicleNumbers::default(),
                    &SensorNumbers::default(),
                    &LoopTiming::default(),
                    start_height_m,
                )
                .unwrap();
            // The campaign knows names alone.
            let text = format!(
                "[scenario.control]\ncontroller = \"{}\"\nreference = \"{}\"\n",
                method.name(),
                match reference {
                    DescentShape::Terminal => "terminal",
                    DescentShape::Exponential => "exponential",
                }
            );
            let settings: SweepSettings = toml::from_str(&text).unwrap();
            let sweep = Sweep::new(settings, Path::new(""), "test".into()).unwrap();
            let lander = sweep.lander(0).unwrap();
            assert_eq!(lander.computer(), &own, "{}", method.name());
            let text = |computer| serde_json::to_string(computer).unwrap();
            assert_eq!(text(lander.computer()), text(&own));
        }
    }
}

#[test]
fn prop_vertical_landings_fly_the_defaults_of_flight() {
    let cards = Cards {
        vehicle: touchdown_campaign::vehicle::VehicleSettings::default(),
        thrust: Card::parse(published::EQ_11, "eq11").unwrap(),
        empirical: None,
        dynamic: Some(Card::parse(published::EQ_12, "eq12").unwrap()),
    };
    let settings = LandSettings::deck();
    let landing = VerticalLanding {
        mass_kg: 1.37,
        gravity_mps2: 9.81,
        start_height_m: 0.5,
        deck_angular_frequency: Some(std::f64::consts::PI),
        deck_acceleration: true,
    };
    let own = VerticalSettings {
        c_per_s: C_DECK_PER_S,
        ..VerticalSettings::default()
    };
    for method in [Method::Feedback, Method::Dynamic, Method::Imbc, Method::Ssc] {
        let ground_effect = match method.feedforward() {
            Feedforward::Dynamic => cards.dynamic.as_ref().unwrap().ground_effect().unwrap(),
            _ => Guarded::new(GroundEffectModel::None, Validity::default()),
        };
        let thrust = cards.thrust.thrust_model().unwrap();
        let own = own.controller(method, &landing, thrust, ground_effect);
        let flown = controller(method, &cards, &settings, true).unwrap();
        assert_eq!(flown, own.unwrap(), "{}", method.name());
    }
    for method in [Method::Observer, Method::DynamicObserver] {
        let error = controller(method, &cards, &settings, true).unwrap_err();
        assert!(error.to_string().contains(method.name()), "{error}");
    }
}
