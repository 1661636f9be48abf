//! Each item of the checklist.

use super::*;
use crate::autopilot::Autopilot;
use crate::settings::{LimitSettings, ThrottleSide};
use mavlink::dialects::common::{MavParamType, PARAM_VALUE_DATA};
use std::collections::BTreeMap;
use std::sync::LazyLock;

fn px4() -> BTreeMap<&'static str, f64> {
    [
        ("THR_MDL_FAC", 0.0),
        ("MPC_THR_HOVER", 0.5),
        ("COM_OF_LOSS_T", 0.2),
        ("COM_OBL_RC_ACT", 5.0),
        ("EKF2_RNG_CTRL", 0.0),
        ("MPC_LAND_SPEED", 0.7),
        ("LNDMC_Z_VEL_MAX", 0.25),
        ("MC_BAT_SCALE_EN", 0.0),
    ]
    .into()
}

fn ardupilot() -> BTreeMap<&'static str, f64> {
    [
        ("GUID_OPTIONS", 8.0),
        ("GUID_TIMEOUT", 0.2),
        ("MOT_THST_EXPO", 0.65),
        ("MOT_THST_HOVER", 0.35),
        ("MOT_SPIN_MIN", 0.15),
        ("MOT_SPIN_MAX", 0.95),
        ("PLND_ENABLED", 0.0),
        ("ATC_ANGLE_BOOST", 1.0),
        ("MOT_BAT_VOLT_MAX", 0.0),
    ]
    .into()
}

/// The parameters as the autopilot would have sent them.
fn sent(autopilot: Autopilot, values: &BTreeMap<&'static str, f64>) -> Parameters {
    let mut parameters = Parameters::default();
    for (name, value) in values {
        let answer = PARAM_VALUE_DATA {
            param_value: *value as f32,
            param_id: (*name).into(),
            param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
            ..PARAM_VALUE_DATA::default()
        };
        assert!(parameters.take(autopilot, &answer), "{name}");
    }
    parameters
}

/// Everything as it should be, but for the parameters.
fn facts(autopilot: Autopilot, parameters: &Parameters) -> Facts<'_> {
    static SETTINGS: LazyLock<FlightSettings> = LazyLock::new(FlightSettings::default);
    Facts {
        settings: &SETTINGS,
        autopilot,
        parameters,
        firmware: Some(autopilot.oldest()),
        hover_found: Some(if autopilot == Autopilot::Px4 {
            0.5
        } else {
            0.35
        }),
        echoes: true,
        flies: true,
        camera: None,
        rates_hz: Some([100.0, 100.0, 50.0, 30.0, 20.0]),
        sync: Some(SyncReport {
            answers: 5,
            round_trip_s: 0.001,
            offset_s: 1.0,
            drift_ppm: 0.0,
            drift_error_ppm: 10.0,
            steps: 0,
        }),
        battery: Some(0.8),
        hover_throttle: 0.5,
    }
}

fn list(autopilot: Autopilot, parameters: &BTreeMap<&'static str, f64>) -> Checklist {
    Checklist::of(&facts(autopilot, &sent(autopilot, parameters)))
}

#[test]
fn prop_each_parameter_decides_as_the_table_says() {
    assert_eq!(list(Autopilot::Px4, &px4()).verdict(), Verdict::Good);
    assert_eq!(
        list(Autopilot::ArduPilot, &ardupilot()).verdict(),
        Verdict::Good
    );
    for (autopilot, name, value, verdict) in [
        (Autopilot::Px4, "COM_OBL_RC_ACT", 0.0, Verdict::Refused),
        (Autopilot::Px4, "COM_OBL_RC_ACT", 1.0, Verdict::Refused),
        (Autopilot::Px4, "COM_OBL_RC_ACT", 3.0, Verdict::Refused),
        (Autopilot::Px4, "COM_OBL_RC_ACT", 4.0, Verdict::Refused),
        (Autopilot::Px4, "COM_OBL_RC_ACT", f64::NAN, Verdict::Refused),
        (Autopilot::Px4, "COM_OF_LOSS_T", 0.5, Verdict::Warning),
        (Autopilot::Px4, "COM_OF_LOSS_T", 1.0, Verdict::Refused),
        (Autopilot::Px4, "COM_OF_LOSS_T", 0.0, Verdict::Refused),
        (Autopilot::Px4, "EKF2_RNG_CTRL", 1.0, Verdict::Warning),
        (Autopilot::Px4, "MPC_THR_HOVER", 0.4, Verdict::Warning),
        (Autopilot::Px4, "MPC_THR_HOVER", 0.2, Verdict::Refused),
        (Autopilot::Px4, "THR_MDL_FAC", 1.2, Verdict::Refused),
        (Autopilot::ArduPilot, "GUID_OPTIONS", 0.0, Verdict::Refused),
        (Autopilot::ArduPilot, "GUID_OPTIONS", 24.0, Verdict::Good),
        (Autopilot::ArduPilot, "GUID_TIMEOUT", 3.0, Verdict::Refused),
        (Autopilot::ArduPilot, "MOT_SPIN_MIN", -1.0, Verdict::Refused),
        (Autopilot::ArduPilot, "MOT_SPIN_MIN", 0.95, Verdict::Refused),
        (Autopilot::ArduPilot, "ATC_ANGLE_BOOST", 0.0, Verdict::Good),
        (
            Autopilot::ArduPilot,
            "ATC_ANGLE_BOOST",
            f64::NAN,
            Verdict::Refused,
        ),
        (
            Autopilot::ArduPilot,
            "MOT_BAT_VOLT_MAX",
            16.8,
            Verdict::Warning,
        ),
    ] {
        let mut parameters = match autopilot {
            Autopilot::Px4 => px4(),
            Autopilot::ArduPilot => ardupilot(),
        };
        parameters.insert(name, value);
        let list = list(autopilot, &parameters);
        let item = list.items.iter().find(|item| item.name == name).unwrap();
        assert_eq!(item.verdict, verdict, "{name} = {value}: {}", item.sentence);
    }
}

#[test]
fn prop_what_is_missing_is_waited_for() {
    let mut parameters = px4();
    parameters.remove("COM_OBL_RC_ACT");
    let list = list(Autopilot::Px4, &parameters);
    assert_eq!(list.verdict(), Verdict::Waiting);
    assert!(list.changes(&[]).contains("waiting  COM_OBL_RC_ACT"));
}
#[test]
fn prop_each_wanted_value_is_judged_good() {
    let limits = LimitSettings::default();
    for (autopilot, name, value) in [
        (Autopilot::Px4, "COM_OBL_RC_ACT", 4.0),
        (Autopilot::Px4, "COM_OF_LOSS_T", 1.0),
        (Autopilot::Px4, "EKF2_RNG_CTRL", 1.0),
        (Autopilot::ArduPilot, "GUID_OPTIONS", 3.0),
        (Autopilot::ArduPilot, "GUID_TIMEOUT", 3.0),
    ] {
        let mut values = match autopilot {
            Autopilot::Px4 => px4(),
            Autopilot::ArduPilot => ardupilot(),
        };
        let right = wanted(name, value, &limits).unwrap();
        values.insert(name, right);
        assert_eq!(list(autopilot, &values).verdict(), Verdict::Good, "{name}");
        assert_eq!(wanted(name, right, &limits), None, "{name}");
    }
    assert_eq!(
        wanted("GUID_OPTIONS", 3.0, &limits),
        Some(11.0),
        "other bits stay"
    );
    for (name, value) in px4().into_iter().chain(ardupilot()) {
        assert_eq!(wanted(name, value, &limits), None, "{name}");
    }
}

#[test]
fn analytic_angle_boost_is_undone_by_the_cosine_of_the_tilt() {
    let side = ThrottleSide::ThrustSetpoint;
    let mut values = ardupilot();
    let of = |values: &BTreeMap<_, _>| {
        Thrust::of(
            Autopilot::ArduPilot,
            side,
            &sent(Autopilot::ArduPilot, values),
        )
        .unwrap()
    };
    // 0.4 at a tilt of 60 degrees: ArduPilot divides 0.2 by 0.5.
    assert_eq!(of(&values).setpoint(0.4, 0.5), 0.2);
    values.insert("ATC_ANGLE_BOOST", 0.0);
    assert_eq!(of(&values).setpoint(0.4, 0.5), 0.4);
}

#[test]
fn prop_a_weight_that_does_not_fit_the_card_is_refused() {
    let values = px4();
    for (found, echoes, flies, verdict) in [
        (Some(0.51), true, true, Verdict::Good),
        (Some(0.6), true, true, Verdict::Warning),
        (Some(0.7), true, true, Verdict::Refused),
        // On the ground it is unknown, and without reports it stays so. In the air it is measured before control.
        (None, true, false, Verdict::Warning),
        (None, false, true, Verdict::Warning),
        (None, true, true, Verdict::Waiting),
    ] {
        let parameters = sent(Autopilot::Px4, &values);
        let settings = FlightSettings::default();
        let list = Checklist::of(&Facts {
            settings: &settings,
            autopilot: Autopilot::Px4,
            firmware: None,
            parameters: &parameters,
            rates_hz: None,
            sync: None,
            battery: None,
            hover_throttle: 0.5,
            hover_found: found,
            echoes,
            flies,
            camera: None,
        });
        let item = list
            .items
            .iter()
            .find(|item| item.name == "weight")
            .unwrap();
        assert_eq!(item.verdict, verdict, "{}", item.sentence);
    }
}

#[test]
fn prop_a_drifting_clock_is_a_warning_once_it_is_sure() {
    let parameters = sent(Autopilot::Px4, &px4());
    for (drift_ppm, drift_error_ppm, verdict) in [
        (50.0, 10.0, Verdict::Good),
        // A millisecond over the half second between two answers.
        (2000.0, 2000.0, Verdict::Good),
        (12_000.0, 100.0, Verdict::Warning),
        (-12_000.0, 100.0, Verdict::Warning),
        (0.0, f64::INFINITY, Verdict::Good),
    ] {
        let mut facts = facts(Autopilot::Px4, &parameters);
        let sync = facts.sync.as_mut().unwrap();
        (sync.drift_ppm, sync.drift_error_ppm) = (drift_ppm, drift_error_ppm);
        let item = facts.time();
        assert_eq!(item.verdict, verdict, "{drift_ppm}: {}", item.sentence);
    }
}
