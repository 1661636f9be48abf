//! Parameters that are changed and written back.

use super::*;

fn changing() -> Bench {
    let session = Session {
        set_parameters: true,
        ..Session::default()
    };
    let mut bench = Bench::session(PX4, &session);
    bench.parameters.insert("COM_OF_LOSS_T", 1.1);
    bench.parameters.insert("COM_OBL_RC_ACT", f32::from_bits(3));
    bench
}

fn values(bench: &Bench) -> (f32, u32) {
    let of = |name| bench.parameters[name];
    (of("COM_OF_LOSS_T"), of("COM_OBL_RC_ACT").to_bits())
}

#[test]
fn prop_parameters_are_changed_and_written_back_at_every_end() {
    let ends: [(&str, Fault, Ending); 3] = [
        ("take-over", |b| b.mode = POSITION, Ending::PilotTookOver),
        ("Ctrl-C", |b| b.event(Event::Stop), Ending::Stopped),
        (
            "silence",
            |b| {
                b.mute = (0..500).collect();
                b.run(1.0);
                b.mute.clear();
                b.mode = POSITION;
            },
            Ending::Silent,
        ),
    ];
    for (name, fault, ending) in ends {
        let mut bench = changing();
        bench.becomes_ready();
        assert_eq!(values(&bench), (0.2, 5));
        let said = bench.companion.take_notes().join("\n");
        assert!(said.contains("COM_OF_LOSS_T: 1.1 becomes 0.2"), "{said}");
        bench.mode = OFFBOARD;
        bench.run(1.5);
        fault(&mut bench);
        bench.run(0.5);
        bench.mode = POSITION;
        bench.run(8.0);
        bench.ends(Stage::Ended, ending);
        assert_eq!(values(&bench), (1.1, 3), "{name}");
        assert!(
            bench
                .companion
                .summary()
                .parameters
                .iter()
                .all(|change| change.restored)
        );
    }
}

#[test]
fn prop_nothing_is_written_back_while_the_vehicle_may_need_it() {
    let mut bench = changing();
    bench.becomes_ready();
    bench.mode = OFFBOARD;
    bench.run(1.5);
    // The vehicle stays in OFFBOARD, whatever is asked: its failsafe must act as before.
    bench.event(Event::Stop);
    bench.run(11.0);
    bench.ends(Stage::Ended, Ending::Stopped);
    assert_eq!(values(&bench), (0.2, 5));
    let said = bench.companion.take_notes().join("\n");
    assert!(
        said.contains("COM_OBL_RC_ACT was NOT written back. Set it to 3"),
        "{said}"
    );
}

#[test]
fn prop_ctrl_c_before_control_writes_back_too() {
    let mut bench = changing();
    bench.run(3.5);
    assert_eq!(values(&bench), (0.2, 5));
    bench.event(Event::Stop);
    bench.run(1.0);
    bench.ends(Stage::Ended, Ending::Stopped);
    assert_eq!(values(&bench), (1.1, 3));
}

#[test]
fn prop_a_change_that_is_never_confirmed_is_said_and_not_taken_for_one() {
    let mut bench = changing();
    bench.deaf = true;
    bench.run(8.0);
    let said = bench.companion.take_notes().join("\n");
    let times = |words: &str| said.matches(words).count();
    assert_eq!(
        times("COM_OF_LOSS_T: the autopilot has not confirmed"),
        1,
        "{said}"
    );
    bench.event(Event::Stop);
    bench.run(8.0);
    assert_eq!(bench.companion.stage(), Stage::Ended);
    let said = bench.companion.take_notes().join("\n");
    let expected = "COM_OF_LOSS_T may be changed: the autopilot confirmed neither the change nor the old value. Set it to 1.1";
    assert!(
        said.contains(expected) && !said.contains("1.10000"),
        "{said}"
    );
}
