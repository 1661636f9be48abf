//! Any sequence of messages, ticks and pauses.

use super::*;
use proptest::prelude::*;

/// What may happen, in any order.
#[derive(Clone, Debug)]
enum Happening {
    Heartbeat(u32, bool),
    Readings(f64, f32),
    Ticks(u8),
    Bytes(Vec<u8>),
    Sync(i64, i64),
    Parameter(f32),
    Pause(u32),
    Stop,
}

fn happening() -> impl Strategy<Value = Happening> {
    prop_oneof![
        3 => (prop_oneof![Just(OFFBOARD), Just(POSITION), any::<u32>()], any::<bool>())
            .prop_map(|(mode, armed)| Happening::Heartbeat(mode, armed)),
        4 => (0.0..3.0_f64, prop_oneof![Just(-9.81_f32), any::<f32>()])
            .prop_map(|(height, force)| Happening::Readings(height, force)),
        4 => (1..40_u8).prop_map(Happening::Ticks),
        1 => proptest::collection::vec(any::<u8>(), 0..80).prop_map(Happening::Bytes),
        1 => (any::<i64>(), any::<i64>()).prop_map(|(a, b)| Happening::Sync(a, b)),
        1 => any::<f32>().prop_map(Happening::Parameter),
        1 => any::<u32>().prop_map(Happening::Pause),
        1 => Just(Happening::Stop),
    ]
}

fn happen(bench: &mut Bench, happening: &Happening) {
    match happening {
        Happening::Heartbeat(mode, armed) => {
            (bench.mode, bench.armed) = (*mode, *armed);
            bench.heartbeat();
        }
        Happening::Readings(height_m, force) => {
            (bench.height_m, bench.specific_force) = (*height_m, *force);
            bench.now_us += 1000;
            bench.readings(6);
        }
        Happening::Ticks(count) => bench.run(f64::from(*count) * 0.01),
        Happening::Bytes(bytes) => bench.event(Event::Received(bytes)),
        Happening::Sync(tc1, ts1) => bench.deliver(&MavMessage::TIMESYNC(TIMESYNC_DATA {
            tc1: *tc1,
            ts1: *ts1,
            ..TIMESYNC_DATA::default()
        })),
        Happening::Parameter(value) => bench.deliver(&MavMessage::PARAM_VALUE(PARAM_VALUE_DATA {
            param_value: *value,
            param_id: "THR_MDL_FAC".into(),
            param_type: MavParamType::MAV_PARAM_TYPE_REAL32,
            ..PARAM_VALUE_DATA::default()
        })),
        Happening::Pause(us) => bench.now_us += u64::from(*us) % 3_000_000,
        Happening::Stop => bench.event(Event::Stop),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, ..ProptestConfig::default() })]

    /// Whatever happens: no panic, no setpoint that is not finite, and none after the end.
    #[test]
    fn prop_no_sequence_yields_a_setpoint_after_a_take_over(
        flies in any::<bool>(),
        sequence in proptest::collection::vec(happening(), 0..40),
    ) {
        let mut bench = if flies { Bench::flying() } else { Bench::new() };
        let mut after_end = None;
        for each in &sequence {
            let stage = bench.companion.stage();
            happen(&mut bench, each);
            for message in &bench.sent {
                if let MavMessage::SET_ATTITUDE_TARGET(m) = message {
                    prop_assert!(m.q.iter().all(|c| c.is_finite()) && (0.0..=1.0).contains(&m.thrust));
                }
            }
            if stage == Stage::Ended {
                prop_assert_eq!(bench.companion.stage(), Stage::Ended);
                prop_assert_eq!(bench.setpoints(), after_end.unwrap_or(0));
            }
            if matches!(stage, Stage::HandingOver) {
                prop_assert!(matches!(bench.companion.stage(), Stage::HandingOver | Stage::Ended));
            }
            after_end = Some(bench.setpoints());
        }
    }
}
