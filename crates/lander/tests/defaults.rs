//! What a program that knows `touchdown-flight` and `touchdown-lander` alone flies by default.

use touchdown_flight::Real;
use touchdown_flight::control::{Gains, Law};
use touchdown_flight::ground_effect::GroundEffectModel;
use touchdown_flight::method::Method;
use touchdown_lander::computer::{Computer, Descent};
use touchdown_lander::models::FlightModels;
use touchdown_lander::settings::{
    ControlSettings, DescentShape, LoopTiming, SensorNumbers, VehicleNumbers,
};

fn computer<R: Real>(method: Method, reference: DescentShape, planner: bool) -> Computer<R> {
    let settings = ControlSettings {
        method,
        reference,
        planner,
        ..ControlSettings::default()
    };
    settings
        .computer(
            &FlightModels::default(),
            &VehicleNumbers::default(),
            &SensorNumbers::default(),
            &LoopTiming::default(),
            R::from_f64(0.8),
        )
        .unwrap()
}

/// Law, ground-effect model and observer of each method.
fn parts<R: Real>(method: Method) -> (&'static str, &'static str, bool) {
    let controller = computer::<R>(method, DescentShape::Terminal, true).controller;
    let law = match controller.law {
        Law::Composite(_) => "composite",
        Law::Imbc(_) => "imbc",
        Law::Ssc(_) => "ssc",
    };
    let model = match controller.ground_effect.model {
        GroundEffectModel::None => "none",
        GroundEffectModel::Empirical(_) => "empirical",
        GroundEffectModel::Lag(_) => "lag",
        _ => "other",
    };
    (law, model, controller.observer.is_some())
}

#[test]
fn prop_every_method_by_name() {
    let expected = [
        ("feedback", ("composite", "none", false)),
        ("empirical", ("composite", "empirical", false)),
        ("dynamic", ("composite", "lag", false)),
        ("imbc", ("imbc", "none", false)),
        ("ssc", ("ssc", "none", false)),
        ("observer", ("composite", "none", true)),
        ("dynamic+observer", ("composite", "lag", true)),
    ];
    for (method, (name, of)) in Method::ALL.into_iter().zip(expected) {
        assert_eq!(method.name(), name);
        assert_eq!(parts::<f64>(method), of, "{name}");
        assert_eq!(parts::<f32>(method), of, "{name}, single precision");
    }
    assert_eq!(
        ControlSettings::<f64>::default().method.name(),
        "dynamic+observer"
    );
}

#[test]
fn prop_the_gains_that_fly() {
    let controller = computer::<f64>(Method::default(), DescentShape::Terminal, true).controller;
    let Law::Composite(law) = controller.law else {
        panic!("the default method flies the composite law")
    };
    // Stiffer than the paper's (K_P 4, Γ 2), which stay the defaults of vertical landings.
    assert_eq!((law.gains.k_p, law.gains.gamma), (8.0, 2.5));
    assert_eq!((law.gains.k_i, law.gains.integral_limit_n), (0.01, 2.0));
    assert_eq!(Gains::<f64>::default().k_p, 4.0);
    // The mean of the acceleration over a period is half a period older than the sample.
    let delays = controller.delays;
    assert!((delays.sensing_s - 0.025).abs() < 1e-12);
    assert!((delays.attitude_s - 0.025).abs() < 1e-12);
    assert_eq!(delays.command_s, 0.01);
}

#[test]
fn prop_the_descent_follows_its_shape() {
    let descent = |shape, planner| computer::<f64>(Method::default(), shape, planner).descent;
    assert!(matches!(
        descent(DescentShape::Terminal, true),
        Descent::Planned(_)
    ));
    for (shape, end_height_m) in [
        (DescentShape::Terminal, 0.11),
        (DescentShape::Exponential, 0.0),
    ] {
        let Descent::Straight(reference) = descent(shape, false) else {
            panic!("without a planner the descent is straight down")
        };
        assert_eq!(reference.end_height_m(), end_height_m);
        assert_eq!(reference.at(0.0).height_m, 0.8);
    }
    assert!(matches!(
        descent(DescentShape::Exponential, true),
        Descent::Straight(_)
    ));
}
