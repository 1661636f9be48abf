//! Tables of thrust stands as people have them: units in other places, several load cells, several runs, lines above
//! the header.

use touchdown_log::{Findings, Inspection, Map, Table, apply, inspect, parse_csv};

fn read(text: &str) -> (Table, Findings) {
    parse_csv("t.csv", text.as_bytes()).unwrap()
}

/// A stand at 100 Hz: a header (of one or two lines), and rows by their number.
fn stand(header: &str, rows: usize, row: impl Fn(f64) -> String) -> (Table, Findings) {
    let rows: String = (0..rows).map(|i| row(i as f64) + "\n").collect();
    read(&format!("{header}\n{rows}"))
}

fn looked(table: &Table) -> (Inspection, String) {
    let seen = inspect(table, None);
    let map = seen.suggested_map.clone().unwrap_or_default();
    (seen, map)
}

/// The thrust of row 50 by the suggested map.
fn thrust_n(table: &Table, map: &str) -> f64 {
    let map = Map::parse("suggested.toml", map).unwrap_or_else(|e| panic!("{e}\n{map}"));
    apply(table, &map).unwrap().0.require("thrust_n").unwrap()[50]
}

#[test]
fn regress_units_of_force_stand_in_the_name_or_in_a_row_below() {
    // By the definitions of the pound (0.45359237 kg) and of the standard gravity (9.80665 m/s²).
    let pound = 0.453_592_37 * 9.806_65;
    for (name, unit, factor) in [
        ("Thrust (lbf)", "", pound),
        ("Thrust [lbs]", "", pound),
        ("thrust_oz", "", pound / 16.0),
        ("Thrust (ozf)", "", pound / 16.0),
        ("Force [mN]", "", 1e-3),
        ("Force {kN}", "", 1e3),
        ("Thrust N", "", 1.0),
        ("thrustKg", "", 9.806_65),
        ("Load cell, grams", "", 9.806_65e-3),
        ("thrust_gram-force", "", 9.806_65e-3),
        ("Thrust", "lbf", pound),
        ("Thrust", "[gf]", 9.806_65e-3),
        ("thrust", "g", 9.806_65e-3),
        ("thrust_1", "(N)", 1.0),
        ("Weight", "kg", 9.806_65),
    ] {
        let units = if unit.is_empty() {
            String::new()
        } else {
            format!("\ns,-,\"{unit}\"")
        };
        let (table, findings) = stand(&format!("time,throttle,\"{name}\"{units}"), 80, |i| {
            format!("{},{},{}", 0.01 * i, i / 80.0, 0.1 * i)
        });
        assert!(!findings.is_lossy(), "{name} {unit}: {findings:?}");
        let (seen, map) = looked(&table);
        let found = thrust_n(&table, &map);
        // Roundings of a product of two numbers.
        assert!(
            (found / (5.0 * factor) - 1.0).abs() < 1e-14,
            "{name} {unit}: {found}\n{map}"
        );
        assert!(!map.contains("by its size"), "{map}");
        let written = (!unit.is_empty()).then_some(unit);
        assert_eq!(seen.columns[2].unit.as_deref(), written, "{name}");
    }
}

#[test]
fn regress_a_row_of_units_counts_for_the_time_and_other_channels() {
    let header = "Clock,ESC signal,Thrust,Voltage,Motor Speed 1,Motor Speed 2\nms,µs,N,mV,RPM,RPM";
    let (table, _) = stand(header, 80, |i| {
        format!("{},{},{i},16000,900,1100", 10.0 * i, 1000.0 + i)
    });
    let (seen, map) = looked(&table);
    assert_eq!(seen.time.unwrap().unit_s, 1e-3);
    for line in [
        "time_s = '1e-3 * \"Clock\"'",
        "throttle = '(\"ESC signal\" - 1000) / 1000'",
        "thrust_n = '\"Thrust\"'",
        "battery_v = '1e-3 * \"Voltage\"'",
        "rotor_rpm = '(\"Motor Speed 1\" + \"Motor Speed 2\") / 2'",
    ] {
        assert!(map.contains(line), "{line}\n{map}");
    }
    // A name and a row may state the same unit.
    let (table, _) = stand("time_s,throttle,thrust_n\ns,-,N", 80, |i| {
        format!("{},{},{i}", 0.01 * i, i / 80.0)
    });
    let (seen, map) = looked(&table);
    assert_eq!(
        (seen.warnings.as_slice(), map.as_str()),
        ([].as_slice(), "")
    );
    // A column in another unit is no time, and a thrust in a unit that nobody knows is no newtons.
    let (table, _) = stand("ramp,throttle,Thrust\nV,-,counts", 80, |i| {
        format!("{},{},{i}", 0.5 * i, i / 80.0)
    });
    let (seen, map) = looked(&table);
    assert!(seen.time.is_none(), "{:?}", seen.time);
    assert!(!map.contains("\nthrust_n"), "{map}");
    assert!(
        map.contains("# \"Thrust\": a thrust in which unit?"),
        "{map}"
    );
}

#[test]
fn regress_several_load_cells_are_asked_about() {
    for (a, b) in [
        ("Thrust1 [g]", "Thrust2 [g]"),
        ("thrust_left_g", "thrust_right_g"),
        ("Load cell A (g)", "Load cell B (g)"),
        ("Force + -1 (g)", "Force + -2 (g)"),
    ] {
        let header = format!("time_s,throttle,Weight of battery (kg),{a},{b}");
        let (table, _) = stand(&header, 80, |i| {
            format!("{},{},{},{i},{}", 0.01 * i, i / 80.0, i % 2.0, -2.0 * i)
        });
        let (seen, map) = looked(&table);
        assert!(!map.contains("\nthrust_n"), "{map}");
        let asked = format!("{a:?} and {b:?} look like thrust_n");
        assert!(
            seen.warnings.iter().any(|w| w.starts_with(&asked)),
            "{:?}",
            seen.warnings
        );
        // Each choice is a map; the second cell is mounted upside down.
        let choices: Vec<&str> = map
            .lines()
            .filter(|line| line.starts_with("# thrust_n = "))
            .collect();
        let found: Vec<f64> = choices
            .iter()
            .map(|line| thrust_n(&table, &map.replace(line, &line[2..])))
            .collect();
        let gram = 9.806_65e-3;
        assert_eq!(found.len(), 3, "{map}");
        for (found, grams) in found.iter().zip([150.0, 50.0, 100.0]) {
            // Roundings of a sum.
            assert!(
                (found / (grams * gram) - 1.0).abs() < 1e-14,
                "{found}\n{map}"
            );
        }
    }
}

#[test]
fn regress_the_whole_thrust_among_several_forces_is_taken() {
    for (header, line) in [
        // The same quantity in two units.
        ("Thrust (N),Thrust (kgf)", "thrust_n = '\"Thrust (N)\"'\n"),
        (
            "Thrust1 (N),Thrust2 (N),Thrust total (N)",
            "thrust_n = '\"Thrust total (N)\"'\n",
        ),
        (
            "Force X (N),Force Y (N),Force Z (N)",
            "thrust_n = '\"Force Z (N)\"'\n",
        ),
        (
            "Thrust (N),Load cell (kg)",
            "thrust_n = '\"Thrust (N)\"'  # \"Load cell (kg)\" is a force as well: is this the whole thrust?\n",
        ),
    ] {
        let columns = header.split(',').count();
        let (table, _) = stand(&format!("time_s,throttle,{header}"), 80, |i| {
            format!(
                "{},{}{}",
                0.01 * i,
                i / 80.0,
                format!(",{i}").repeat(columns)
            )
        });
        let (seen, map) = looked(&table);
        assert!(map.contains(line), "{line}\n{map}");
        assert_eq!(seen.warnings, [""; 0]);
    }
}

#[test]
fn regress_the_mean_of_motors_keeps_their_number() {
    let row = |i: f64| format!("{},{u},{u},{u},{u},{i}", 0.01 * i, u = i / 80.0);
    let rotors = |header: &str| {
        let (table, _) = stand(header, 80, row);
        let map = looked(&table).1;
        Map::parse("suggested.toml", &map)
            .unwrap()
            .vehicle()
            .measured_rotors
    };
    assert_eq!(
        rotors("time_s,throttle_1,throttle_2,throttle_3,throttle_4,Thrust [N]"),
        Some(4)
    );
    assert_eq!(rotors("time,throttle,rpm1,rpm2,rpm3,Thrust [N]"), Some(3));
    // Without a measured thrust there is nothing to count, and one motor is no mean.
    assert_eq!(rotors("time_s,m1,m2,m3,m4,az"), None);
    assert_eq!(rotors("time_s,throttle,a,b,c,Thrust [N]"), None);
}

#[test]
fn regress_milliseconds_under_the_name_of_seconds_are_asked_about() {
    let warned = |rows: usize, step: f64| {
        let (table, _) = stand("time_s,throttle,thrust_n", rows, |i| {
            format!("{},0.5,{i}", step * i)
        });
        let seen = inspect(&table, None);
        let by_inspect = seen
            .warnings
            .iter()
            .any(|w| w.contains("which suggests ms"));
        let map = Map::identity_for(&table).unwrap();
        let findings = apply(&table, &map).unwrap().1;
        let by_apply = findings
            .warnings
            .iter()
            .any(|w| w.ends_with("is it in milliseconds?"));
        assert_eq!(by_inspect, by_apply, "{rows} rows of {step}");
        by_apply
    };
    // Logs of 100 Hz and 500 Hz for half a minute, and of 50 Hz however short.
    assert!(warned(3000, 10.0) && warned(15_000, 2.0) && warned(100, 20.0));
    // A bench that is read every ten seconds, and an endurance test of two hours.
    assert!(!warned(60, 10.0) && !warned(7200, 1.0) && !warned(30_000, 0.1));
}

#[test]
fn regress_runs_after_each_other_are_told_with_row_and_remedy() {
    let runs = |header: &str, scale: f64| {
        stand(header, 300, |i| format!("{},0.5,{i}", scale * (i % 100.0))).0
    };
    let told = |warnings: &[String], column: &str| {
        let text = format!(
            "{column} goes back 2 times and runs on from there, first at row 100 (from 0), from 0.99 to 0: "
        );
        let told: Vec<&String> = warnings.iter().filter(|w| w.starts_with(&text)).collect();
        assert!(
            told.len() == 1 && told[0].ends_with("[filter] keep = 'row < 100'"),
            "{warnings:?}"
        );
    };
    let table = runs("time_s,throttle,thrust_n", 0.01);
    let identity = Map::identity_for(&table).unwrap();
    told(&apply(&table, &identity).unwrap().1.warnings, "time_s");
    told(
        &inspect(&runs("t_ms,throttle,F", 10.0), None).warnings,
        "\"t_ms\"",
    );
    // The remedy works.
    let map = "schema = 1\n[channels]\ntime_s = 'time_s'\nthrust_n = 'thrust_n'\n[filter]\nkeep = 'row < 100'\n";
    let (trial, findings) = apply(&table, &Map::parse("m.toml", map).unwrap()).unwrap();
    assert_eq!(
        (trial.len(), findings.warnings.as_slice()),
        (100, [].as_slice())
    );
}

#[test]
fn regress_stamps_that_are_equal_or_decrease_have_a_remedy() {
    let last = |cell: &dyn Fn(f64) -> f64| {
        let (table, _) = stand("time_s,throttle,thrust_n", 100, |i| {
            format!("{},0.5,{i}", cell(i))
        });
        let map = Map::identity_for(&table).unwrap();
        let findings = apply(&table, &map).unwrap().1;
        findings.warnings.last().cloned().unwrap_or_default()
    };
    let coarse = last(&|i| (0.01 * i * 5.0).floor());
    assert!(
        coarse.contains("coarser than the rows") && coarse.contains("'row * 0.01'"),
        "{coarse}"
    );
    // Seventy rows that decrease, below thirty that increase.
    let falls = |i: f64| if i < 30.0 { i } else { 29.5 - 0.01 * i };
    let reversed = last(&|i| falls(i));
    assert!(reversed.ends_with("Sort the rows by time"), "{reversed}");
    // A few of them need none.
    let few = last(&|i| if i == 50.0 { 0.49 } else { 0.01 * i });
    assert_eq!(few, "1 of 100 rows repeat a stamp and were dropped");
}

#[test]
fn regress_lines_above_the_header_are_passed_over() {
    const TABLE: &str = "Time (s),Throttle (%),Thrust (gf)\n0,10,1\n0.01,20,2\n";
    for (above, what) in [
        ("RCbenchmark v1.2\n", "line 1 stands"),
        (
            "\nRCbenchmark v1.2\nDate: 2024-05-01, noon\n\nProp,5,x,4.5\nby hand\n",
            "lines 2 to 6 stand",
        ),
    ] {
        for end in ["\n", "\r\n"] {
            let (table, findings) = read(&format!("{above}{TABLE}").replace('\n', end));
            assert_eq!(table.columns()[2].name(), "Thrust (gf)");
            assert_eq!(table.columns()[2].values(), [1.0, 2.0]);
            assert_eq!(
                findings.warnings,
                [format!(
                    "{what} above the header and were passed over: they begin with \"RCbenchmark v1.2\""
                )]
            );
            assert!(!findings.is_lossy());
        }
    }
    // With a row of units, other delimiters, decimal commas, and a last row that breaks off.
    let (table, findings) = read("Test 7\nt;Thrust;note\ns;g;-\n0,5;1,5;a\n1,5;2,5;b\n2,5;3");
    assert_eq!(table.columns()[1].values(), [1.5, 2.5]);
    assert_eq!(table.columns()[1].unit(), Some("g"));
    assert!(findings.truncated);
}

#[test]
fn regress_a_header_that_is_not_clear_is_not_looked_for() {
    // The first line has as many cells as the rows, or rows come before another header, or nothing is a header.
    for text in [
        "a,b\n1,2\n3\n4,5\n6,7\n",
        "a,b\n1,2\nx,y,z\n1,2,3\n4,5,6\n",
        "a,b\n1,2,\n3,4,\n5,6,\n",
        "a\n1\n2\n",
    ] {
        let (table, findings) = parse_csv("t.csv", text.as_bytes()).map_or_else(
            |e| (None, e.to_string()),
            |(table, findings)| (Some(table), findings.warnings.concat()),
        );
        assert!(!findings.contains("above the header and"), "{findings}");
        assert!(
            table.is_none_or(|table| table.columns()[0].name() == "a"),
            "{text}"
        );
    }
    let refused = parse_csv("t.csv", b"Stand of Ann\n1,2\n3,4,5\n6,7\n").unwrap_err();
    assert_eq!(
        refused.to_string(),
        "t.csv: no usable rows: all 3 rows are corrupt, the first in line 2: expected 1 cells, found 2. Line 1 was taken \
         for the header: if it is not, delete the lines above the header"
    );
}
