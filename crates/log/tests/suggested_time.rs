//! Which column a suggested map takes for the time, and in which unit.

use touchdown_log::{LogError, Map, apply, inspect, parse_csv};

/// The line for `time_s` in the map for 200 rows, and the trial's period where the map is one.
fn time_line(header: &str, row: impl Fn(i64) -> String) -> (String, Option<f64>) {
    let rows: String = (0..200).map(|i| row(i) + "\n").collect();
    let (table, _) = parse_csv("t.csv", format!("{header}\n{rows}").as_bytes()).unwrap();
    let text = inspect(&table, None).suggested_map.unwrap();
    let line = text
        .lines()
        .find(|line| line.contains("time_s = "))
        .unwrap();
    let period = match Map::parse("suggested.toml", &text) {
        Ok(map) => apply(&table, &map).unwrap().0.period_s(),
        Err(LogError::MapValue {
            at,
            expected,
            found,
        }) => {
            assert_eq!(at.key, "channels.time_s");
            assert_eq!(expected, "an expression for the time in seconds");
            assert_eq!(found, "no such key");
            None
        }
        Err(error) => panic!("{error}\n{text}"),
    };
    (line.to_owned(), period)
}

#[test]
fn regress_a_column_that_rises_is_the_time_in_the_unit_of_its_name_or_size() {
    const NAME: &str = "a guess from its name and its increasing values";
    // Every row is 10 ms after the one before: from, step, factor, and what is said of the unit.
    for (name, from, step, factor, unit) in [
        ("stamp", 0, 10, "1e-3 * ", "; in ms by its steps"),
        ("ts", 5_000_000, 10_000, "1e-6 * ", "; in us by its steps"),
        ("elapsed", 0, 10_000_000, "1e-9 * ", "; in ns by its steps"),
        (
            "header.stamp",
            1_724_321_394_000,
            10,
            "1e-3 * ",
            "; in ms by its size",
        ),
        (
            "epoch",
            1_724_321_394_000_000,
            10_000,
            "1e-6 * ",
            "; in us by its size",
        ),
        (
            "unix_time",
            1_724_321_394_000_000_000,
            10_000_000,
            "1e-9 * ",
            "; in ns by its size",
        ),
        (
            "unix_ns",
            1_724_321_394_000_000_000,
            10_000_000,
            "1e-9 * ",
            "",
        ),
        ("stamp_ns", 0, 10_000_000, "1e-9 * ", ""),
        ("time_boot_ms", 4000, 10, "1e-3 * ", ""),
        ("timeBootMs", 4000, 10, "1e-3 * ", ""),
        ("uptime_ms", 4000, 10, "1e-3 * ", ""),
        ("clock [µs]", 0, 10_000, "1e-6 * ", ""),
    ] {
        let (line, period_s) = time_line(&format!("x,{name}"), |i| {
            format!("{},{}", i % 7, from + step * i)
        });
        assert_eq!(
            line,
            format!("time_s = '{factor}\"{name}\"'  # {NAME}{unit}")
        );
        // Nanoseconds since 1970 are steps of 256 ns in a double.
        let period_s = period_s.unwrap();
        assert!((period_s - 0.01).abs() < 1e-6, "{name}: {period_s}");
    }
    for (name, unit) in [
        ("clock [s]", ""),
        ("secs", ""),
        ("Zeit", "; in s by its steps"),
        ("t0_s", ""),
    ] {
        let (line, period_s) = time_line(&format!("x,{name}"), |i| {
            format!("{},{}", i % 7, 3.0 + 0.02 * i as f64)
        });
        assert_eq!(line, format!("time_s = '\"{name}\"'  # {NAME}{unit}"));
        // Roundings of stamps up to 7 s.
        assert!((period_s.unwrap() - 0.02).abs() < 1e-12, "{name}");
    }
    // Seconds since 1970 at 1 Hz are no milliseconds, whatever their steps.
    let (line, period_s) = time_line("timestamp", |i| format!("{}", 1_724_321_394 + i));
    assert_eq!(
        (line.as_str(), period_s),
        ("time_s = '\"timestamp\"'", Some(1.0))
    );
}

#[test]
fn analytic_a_name_that_speaks_of_time_comes_before_others_that_rise() {
    let row = |i: i64| format!("{},{},{}", 20 * i, 10 * i, 10 * i);
    let line = |header| time_line(header, row).0;
    assert!(line("ramp,stamp,other").starts_with("time_s = '1e-3 * \"stamp\"'"));
    assert!(line("ramp,stamp,clock_ms").starts_with("time_s = '1e-3 * \"clock_ms\"'"));
    assert!(line("ramp,stamp,t_ms").starts_with("time_s = '1e-3 * \"t_ms\"'"));
    // Nothing but its steps speaks for a column: that is asked about.
    assert_eq!(
        line("ramp,up,other"),
        "time_s = '1e-3 * \"ramp\"'  # a guess from its even steps (is it the time?); in ms by its steps"
    );
    // Stamps of every other row, some out of order, and gaps between them.
    let (line, _) = time_line("v,stamp", |i| match i {
        50 => "1,0.49".to_owned(),
        60 => "1,".to_owned(),
        _ => format!(
            "1,{}",
            0.01 * (i / 2 * 2) as f64 + if i > 90 { 3.0 } else { 0.0 }
        ),
    });
    assert!(line.starts_with("time_s = '\"stamp\"'"), "{line}");
}

#[test]
fn analytic_without_a_time_the_map_is_refused_until_the_period_is_said() {
    const NONE: &str =
        "# time_s = 'row * 0.01'  # no column looks like the time: what is the period?";
    type Cell = fn(i64) -> f64;
    let cells: [(&str, Cell); 16] = [
        // Numbers of rows and turns.
        ("seq", |i| i as f64),
        ("header.seq", |i| (4711 + i) as f64),
        ("Unnamed: 0", |i| i as f64),
        ("time_index", |i| (10 * i) as f64),
        // Other things that rise.
        ("alt", |i| (480 + i) as f64),
        ("PWM", |i| (1000 + 5 * i) as f64),
        ("motor7", |i| (10_000 * i) as f64),
        ("drawn [mAh]", |i| 0.1 * i as f64),
        ("up (V)", |i| 0.1 * i as f64),
        // Times in units that are not guessed at, or too coarse, or a part of one.
        ("elapsed_min", |i| 0.001 * i as f64),
        ("stamp_secs", |i| (i / 3) as f64),
        ("stamp.nsec", |i| (i % 150 * 6_000_000) as f64),
        // What does not rise, does so in leaps, or stands still.
        ("stamp", |i| (i % 20) as f64),
        ("stamp", |i| (i / 5) as f64),
        ("quantity", |i| (i * i * i) as f64),
        ("quantity", |i| (i / 5 * 10) as f64),
    ];
    for (name, cell) in cells {
        let (line, period_s) = time_line(&format!("{name},other"), |i| format!("{},1", cell(i)));
        assert_eq!((line.as_str(), period_s), (NONE, None), "{name}");
    }
    // Too few rows.
    let (table, _) = parse_csv("t.csv", b"u,w\n1,2\n3,4\n5,6\n").unwrap();
    assert!(inspect(&table, None).suggested_map.unwrap().contains(NONE));
}

#[test]
fn regress_a_unit_that_may_be_s_or_ms_is_asked_for() {
    // A bench at 1 Hz, or an autopilot at 1 kHz: only the user knows.
    for (name, step, guess) in [
        ("time", "1", ""),
        ("t", "0.5", ""),
        (
            "stamp",
            "4",
            "; a guess from its name and its increasing values",
        ),
    ] {
        let each: f64 = step.parse().unwrap();
        let (table, _) = {
            let rows: String = (0..200)
                .map(|i| format!("{},1\n", each * f64::from(i)))
                .collect();
            parse_csv("t.csv", format!("{name},x\n{rows}").as_bytes()).unwrap()
        };
        let seen = inspect(&table, None);
        let text = seen.suggested_map.unwrap();
        let asked = format!(
            "# \"{name}\" does not state its unit, and its steps of {step} may be s or ms: remove the # of one line{guess}\n"
        );
        assert!(text.contains(&asked), "{text}");
        assert!(
            seen.warnings.iter().any(|w| w.contains("may be s or ms")),
            "{:?}",
            seen.warnings
        );
        // The map does not run until it is answered, and each answer runs.
        assert!(Map::parse("suggested.toml", &text).is_err());
        for (line, factor) in [
            (format!("# time_s = '\"{name}\"'"), 1.0),
            (format!("# time_s = '1e-3 * \"{name}\"'"), 1e-3),
        ] {
            let answered = text.replace(&line, line.trim_start_matches("# "));
            let map = Map::parse("answered.toml", &answered).unwrap();
            let period_s = apply(&table, &map).unwrap().0.period_s().unwrap();
            // Rounding of stamps up to 800.
            assert!(
                (period_s / (factor * each) - 1.0).abs() < 1e-9,
                "{answered}"
            );
        }
    }
    let (line, _) = time_line("time,x", |i| format!("{i},1"));
    assert_eq!(line, "# time_s = '\"time\"'  # in s: 1 Hz for 199 s");
}
