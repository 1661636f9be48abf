//! Maps that are suggested for tables of other names, and what is said of their time.

use touchdown_log::{Inspection, Map, apply, inspect, parse_csv};
use touchdown_trial::Trial;

/// A table of 100 rows; the row's number makes the cells.
fn table(header: &str, row: impl Fn(f64) -> String) -> (Inspection, Option<Trial>) {
    let rows: String = (0..100).map(|i| row(f64::from(i)) + "\n").collect();
    let (table, _) = parse_csv("t.csv", format!("{header}\n{rows}").as_bytes()).unwrap();
    let seen = inspect(&table, None);
    let trial = seen.suggested_map.as_ref().map(|text| {
        let map = Map::parse("suggested.toml", text).unwrap_or_else(|e| panic!("{e}\n{text}"));
        apply(&table, &map).unwrap().0
    });
    (seen, trial)
}

fn has(trial: &Trial, channel: &str, value: f64) {
    let found = trial.require(channel).unwrap()[50];
    // A few roundings of numbers up to 13.
    assert!((found - value).abs() < 1e-12, "{channel}: {found}");
}

#[test]
fn analytic_columns_of_other_names_are_recognised() {
    let (seen, trial) = table("t,m1,m2,m3,m4,acc_z_g,zrange,vbat,vz,x", |i| {
        format!(
            "{},0,65535,32767.5,32767.5,1.0,{},3900,-0.5,7",
            0.01 * i,
            20.0 * i
        )
    });
    let (text, trial) = (seen.suggested_map.unwrap(), trial.unwrap());
    has(&trial, "throttle", 0.5);
    has(&trial, "specific_force_mps2", 9.80665);
    has(&trial, "height_m", 1.0);
    has(&trial, "battery_v", 3.9);
    has(&trial, "vehicle_velocity_mps", -0.5);
    for line in [
        r#"throttle = '("m1" + "m2" + "m3" + "m4") / 262140'  # of 65535 by its size"#,
        r#"specific_force_mps2 = '9.80665 * "acc_z_g"'"#,
        r#"height_m = '1e-3 * "zrange"'  # in mm by its size"#,
        r#"battery_v = '1e-3 * "vbat"'  # in mV by its size"#,
        r#"vehicle_velocity_mps = '"vz"'  # in m/s by its size; up is positive"#,
        r#"# "x""#,
    ] {
        assert!(text.lines().any(|found| found == line), "{line}\n{text}");
    }
}

#[test]
fn analytic_commands_and_axes_are_scaled_by_their_size() {
    for (cell, throttle) in [("0.25", 0.25), ("25", 0.25), ("1250", 0.25), ("51", 0.51)] {
        let (_, trial) = table("time (s),PWM,az,range_cm,battery", |i| {
            format!("{i},{cell},-9.5,150,12.5")
        });
        let trial = trial.unwrap();
        has(&trial, "throttle", throttle);
        has(&trial, "specific_force_mps2", 9.5);
        has(&trial, "height_m", 1.5);
        has(&trial, "battery_v", 12.5);
    }
    // Nothing is made of what could be anything, nor of an altitude above the sea.
    let (seen, _) = table("time (s),az,pwm,alt", |i| {
        format!("{i},300,-5,{}", 480.0 + i)
    });
    let text = seen.suggested_map.unwrap();
    assert!(
        !text.contains("specific_force") && !text.contains("throttle ="),
        "{text}"
    );
    assert!(!text.contains("height_m"), "{text}");
}

#[test]
fn analytic_a_table_with_our_time_gets_a_map_for_what_is_not_ours() {
    let (seen, _) = table("time_s,throttle,height_m,note", |i| format!("{i},0.5,1,9"));
    assert_eq!(seen.suggested_map, None);
    let (seen, trial) = table("time_s,throttle,alt", |i| format!("{},0.5,1.25", 0.1 * i));
    let trial = trial.unwrap();
    has(&trial, "throttle", 0.5);
    has(&trial, "height_m", 1.25);
    assert!(
        seen.suggested_map
            .unwrap()
            .contains("time_s = '\"time_s\"'\n")
    );
}

#[test]
fn analytic_a_time_in_another_unit_is_told_with_the_line_of_a_map() {
    for (header, step, unit, line) in [
        ("t,x", 8.0, "ms", r#"time_s = '1e-3 * "t"'"#),
        (
            "timestamp,x",
            4000.0,
            "us",
            r#"time_s = '1e-6 * "timestamp"'"#,
        ),
        ("time_s,x", 20.0, "ms", r#"time_s = '1e-3 * "time_s"'"#),
    ] {
        let (seen, trial) = table(header, |i| format!("{},1", step * i));
        let told = format!("median step of {step}, which suggests {unit}");
        let is_told = |w: &String| w.contains(&told) && w.ends_with(line);
        assert!(seen.warnings.iter().any(is_told), "{:?}", seen.warnings);
        // Without a map the columns are channels already.
        assert_eq!(trial.is_none(), header.starts_with("time_s"), "{header}");
        if let Some(trial) = trial {
            let expected = if unit == "ms" { 1e-3 } else { 1e-6 } * step;
            // Rounding of stamps of some seconds.
            assert!((trial.period_s().unwrap() - expected).abs() < 1e-12);
        }
    }
    // What the name says is believed, and so are steps of less than a second.
    for (header, step) in [("t_ms,x", 10.0), ("t,x", 0.2), ("time_s,x", 2.0)] {
        let (seen, _) = table(header, |i| format!("{},1", step * i));
        assert!(
            !seen.warnings.iter().any(|w| w.contains("as if")),
            "{:?}",
            seen.warnings
        );
    }
}

#[test]
fn analytic_jumps_of_time_are_told() {
    let (seen, _) = table("t_s,x", |i| {
        let hours = if i >= 60.0 { 3600.0 } else { 0.0 };
        format!("{},1", 0.1 * i + hours)
    });
    assert_eq!(
        seen.warnings,
        [
            "\"t_s\" jumps once by more than a minute: after row 59, 5.900 s from the start, by 3600 s"
        ]
    );
    // In microseconds that nothing states: four seconds in all, and no jump.
    let (seen, _) = table("t,x", |i| format!("{},1", 40_000.0 * i));
    assert!(
        !seen.warnings.iter().any(|w| w.contains("jumps")),
        "{:?}",
        seen.warnings
    );
}

#[test]
fn regress_rotors_are_averaged_as_motors_are() {
    for (header, mean) in [
        (
            "t,rpm1,rpm2,rpm3,rpm4",
            r#"("rpm1" + "rpm2" + "rpm3" + "rpm4") / 4"#,
        ),
        (
            "t,rpm[0],rpm[1],rpm[2],rpm[3]",
            r#"("rpm[0]" + "rpm[1]" + "rpm[2]" + "rpm[3]") / 4"#,
        ),
        (
            "t,esc1_rpm,esc2_rpm,esc3_rpm,esc4_rpm",
            r#"("esc1_rpm" + "esc2_rpm" + "esc3_rpm" + "esc4_rpm") / 4"#,
        ),
    ] {
        let (seen, trial) = table(header, |i| format!("{},1000,2000,3000,4000", 0.01 * i));
        let text = seen.suggested_map.unwrap();
        assert!(text.contains(&format!("rotor_rpm = '{mean}'\n")), "{text}");
        has(&trial.unwrap(), "rotor_rpm", 2500.0);
    }
    // What never turns is no rotor, and what turns the other way does not cancel.
    let (seen, trial) = table("t,rpm1,rpm2,rpm3", |i| format!("{},1000,-2000,0", 0.01 * i));
    has(&trial.unwrap(), "rotor_rpm", 1500.0);
    assert!(!seen.suggested_map.unwrap().contains("# "));
}

#[test]
fn regress_names_of_vehicles_are_recognised_by_name_and_size() {
    for (name, cell, channel, value) in [
        ("motor_out", "0.25", "throttle", 0.25),
        ("gas", "25", "throttle", 0.25),
        ("cmd", "1250", "throttle", 0.25),
        ("thrust_cmd", "0.25", "throttle", 0.25),
        ("actuatorThrust", "32767.5", "throttle", 0.5),
        ("actuators[0]", "0.25", "throttle", 0.25),
        ("sonar", "1.5", "height_m", 1.5),
        ("tof", "1.5", "height_m", 1.5),
        ("tof_mm", "1500", "height_m", 1.5),
        ("range_floor", "1500", "height_m", 1.5),
        ("stateEstimate.z", "1.5", "height_m", 1.5),
        ("imu_up", "1", "specific_force_mps2", 9.80665),
        ("stateEstimate.az", "1", "specific_force_mps2", 9.80665),
        ("accelz", "9.5", "specific_force_mps2", 9.5),
        ("pm.vbatMV", "3900", "battery_v", 3.9),
    ] {
        let (_, trial) = table(&format!("t,{name}"), |i| format!("{},{cell}", 0.01 * i));
        has(&trial.unwrap(), channel, value);
    }
    // A force, another command, centimetres or a time, surfaces, and accelerations without gravity.
    for (name, cell) in [
        ("thrust_cmd", "12.5"),
        ("actuatorThrust", "5000"),
        ("cmd", "0.5"),
        ("sonar", "150"),
        ("tof", "5800"),
        ("actuators[0]", "-0.1"),
        ("imu_up", "0.02"),
        ("stateEstimate.az", "-0.001"),
    ] {
        let (seen, _) = table(&format!("t,{name}"), |i| format!("{},{cell}", 0.01 * i));
        let text = seen.suggested_map.unwrap();
        let last = text.lines().last().unwrap();
        assert!(last.starts_with(&format!("# \"{name}\"")), "{text}");
    }
    // Six outputs, two of which lead nowhere.
    let (_, trial) = table(
        "t,output[0],output[1],output[2],output[3],output[4],output[5]",
        |i| {
            let v = if i == 50.0 { 0.5 } else { 1.0 };
            format!("{},{v},{v},{v},{v},0,0", 0.01 * i)
        },
    );
    has(&trial.unwrap(), "throttle", 0.5);
}

/// The line of the suggested map for a channel.
fn line(text: &str, channel: &str) -> Option<String> {
    let (table, _) = touchdown_log::parse_csv("t.csv", text.as_bytes()).unwrap();
    let map = inspect(&table, None).suggested_map.unwrap();
    let of_channel = |line: &&str| line.starts_with(&format!("{channel} ="));
    map.lines().find(of_channel).map(str::to_owned)
}

#[test]
fn analytic_a_bench_table_gets_a_map_that_reads_it() {
    let mut text = "Throttle (%),Load cell [g],rpm_mean,acc_up\n".to_owned();
    for k in 1..=10 {
        text += &format!("{},{},{},9.8\n", 10 * k, 12 * k * k, 1000 * k);
    }
    let thrust = line(&text, "thrust_n").unwrap();
    assert_eq!(thrust, "thrust_n = '9.80665e-3 * \"Load cell [g]\"'");
    assert_eq!(
        line(&text, "rotor_rpm").unwrap(),
        "rotor_rpm = '\"rpm_mean\"'"
    );
    let force = line(&text, "specific_force_mps2").unwrap();
    assert!(
        force.starts_with("specific_force_mps2 = '\"acc_up\"'"),
        "{force}"
    );
    // Ten steady points have no time, and need none.
    assert!(line(&text, "time_s").unwrap().starts_with("time_s = 'row'"));
    let (table, _) = touchdown_log::parse_csv("t.csv", text.as_bytes()).unwrap();
    let map = inspect(&table, None).suggested_map.unwrap();
    let map = Map::parse("m.toml", &map).unwrap();
    map.check_names().unwrap();
    let (trial, _) = touchdown_log::apply(&table, &map).unwrap();
    assert_eq!(trial.require("throttle").unwrap()[9], 1.0);
    // 1.2 kg at full throttle.
    assert!((trial.require("thrust_n").unwrap()[9] - 11.767_98).abs() < 1e-12);
}

#[test]
fn analytic_thrust_upside_down_in_grams_and_commanded() {
    let rows = |header: &str, row: &dyn Fn(f64) -> String| {
        let rows: String = (0..80).map(|k| row(f64::from(k))).collect();
        format!("{header}\n{rows}")
    };
    let down = rows("time_s,throttle,Thrust (gf)", &|k| {
        format!("{k},{},{}\n", k / 80.0, -10.0 * k)
    });
    let found = line(&down, "thrust_n").unwrap();
    assert_eq!(
        found,
        "thrust_n = '-9.80665e-3 * \"Thrust (gf)\"'  # turned to be up by its sign"
    );
    let grams = rows("time_s,throttle,Thrust (N)", &|k| {
        format!("{k},{},{}\n", k / 80.0, 10.0 * k)
    });
    let found = line(&grams, "thrust_n").unwrap();
    assert_eq!(
        found,
        "thrust_n = '9.80665e-3 * \"Thrust (N)\"'  # in g by its size"
    );
    // What was commanded is not what was measured, also where it comes first.
    let both = "time (s),pwm,thrust_cmd (N),Thrust setpoint [g],thrust (N)";
    let both = rows(both, &|k| format!("{k},{},{k},{k},{k}\n", 1000.0 + 5.0 * k));
    assert_eq!(
        line(&both, "thrust_n").unwrap(),
        "thrust_n = '\"thrust (N)\"'"
    );
    // The third motor has a sensor and no rotor.
    let rotors = "time_s,throttle,rpm1,rpm2,rpm3";
    let rotors = rows(rotors, &|k| {
        format!("{k},0.5,{0},{0},{1}\n", 100.0 * k, k % 2.0)
    });
    let found = line(&rotors, "rotor_rpm").unwrap();
    assert_eq!(found, "rotor_rpm = '(\"rpm1\" + \"rpm2\") / 2'");
}

#[test]
fn regress_a_thrust_without_a_unit_is_suggested_beside_a_throttle() {
    let lines = |header: &str, row: &dyn Fn(f64) -> String| {
        let rows: String = (0..80).map(|k| row(f64::from(k)) + "\n").collect();
        let text = format!("{header}\n{rows}");
        (line(&text, "throttle"), line(&text, "thrust_n"))
    };
    let found = |throttle: &str, thrust: &str| {
        (
            Some(format!("throttle = {throttle}")),
            Some(format!("thrust_n = {thrust}")),
        )
    };
    assert_eq!(
        lines("time_s,pwm,thrust", &|k| format!(
            "{k},{},{}",
            1000.0 + 10.0 * k,
            0.1 * k
        )),
        found(
            "'max(\"pwm\" - 1000, 0) / 1000'  # µs from 1000 to 2000 by its size",
            "'\"thrust\"'  # in N by its size"
        )
    );
    assert_eq!(
        lines("time_s,motor_cmd,Fz", &|k| format!(
            "{k},{},{}",
            k / 80.0,
            -0.1 * k
        )),
        found(
            "'\"motor_cmd\"'",
            "'-\"Fz\"'  # in N by its size, and turned to be up by its sign"
        )
    );
    assert_eq!(
        lines("t_s,u,F", &|k| format!("{k},{},{}", k / 80.0, 10.0 * k)),
        found(
            "'\"u\"'  # from 0 to 1 beside a force: is it the throttle?",
            "'9.80665e-3 * \"F\"'  # in g by its size"
        )
    );
    // Without a throttle it may be a command, and from 0 to 1 it is one rather than a force.
    for (header, greatest) in [
        ("t_s,az,thrust", 60_000.0),
        ("t_s,az,thrust", 9.0),
        ("t_s,esc,thrust", 0.9),
    ] {
        let (_, thrust) = lines(header, &|k| {
            format!("{k},{},{}", k / 80.0, greatest * k / 80.0)
        });
        assert_eq!(thrust, None, "{header} {greatest}");
    }
}

#[test]
fn regress_a_thrust_that_is_not_suggested_has_the_reason() {
    let map = |header: &str, greatest: f64| {
        let rows: String = (0..80)
            .map(|k| {
                format!(
                    "{},{},{}\n",
                    0.01 * f64::from(k),
                    f64::from(k) / 80.0,
                    greatest * f64::from(k) / 79.0
                )
            })
            .collect();
        let (table, _) = parse_csv("t.csv", format!("{header}\n{rows}").as_bytes()).unwrap();
        inspect(&table, None).suggested_map.unwrap()
    };
    for (header, greatest, why) in [
        (
            "t,roll,thrust",
            9.0,
            "# \"thrust\": a thrust or a command? No column beside it is a throttle. If it is a thrust in N: thrust_n = '\"thrust\"'\n",
        ),
        (
            "t,throttle,thrust",
            1.0,
            "# \"thrust\": from 0 to 1, perhaps a command. If it is a thrust in N: thrust_n = '\"thrust\"'\n",
        ),
        (
            "t,throttle,thrust",
            65_535.0,
            "# \"thrust\": too large for N or g, perhaps a command\n",
        ),
        (
            "t,throttle,commanded thrust [N]",
            9.0,
            "# \"commanded thrust [N]\": commanded, not measured\n",
        ),
        (
            "t,throttle,Thrust (counts)",
            9.0,
            "# \"Thrust (counts)\": a thrust in which unit? In N: thrust_n = '\"Thrust (counts)\"'; in g: thrust_n = '9.80665e-3 * \"Thrust (counts)\"'\n",
        ),
    ] {
        let text = map(header, greatest);
        assert!(text.contains(why), "{text}");
    }
}
