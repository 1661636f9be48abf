//! What the reader takes for a table, and what it says of the rest.

use proptest::prelude::*;
use touchdown_log::{
    Column, ColumnKind, ErrorKind, Findings, LogError, Map, Table, inspect, parse_csv,
};

fn read(text: &str) -> (Table, Findings) {
    parse_csv("t.csv", text.as_bytes()).unwrap()
}

fn fails(bytes: &[u8]) -> LogError {
    parse_csv("t.csv", bytes).unwrap_err()
}

fn values(table: &Table, name: &str) -> Vec<f64> {
    table.column(name).unwrap().values().to_vec()
}

#[test]
fn analytic_byte_order_mark_line_ends_and_spaces() {
    for end in ["\n", "\r\n", "\r", "\n\n", "\r\r\n"] {
        let text = format!("\u{feff} a , \"b, c\" {end}1, 2{end} 3 ,\"4\"{end}");
        let (table, findings) = read(&text);
        assert_eq!(values(&table, "a"), [1.0, 3.0], "{end:?}");
        assert_eq!(values(&table, "b, c"), [2.0, 4.0], "{end:?}");
        assert_eq!(findings.warnings, [""; 0], "{end:?}");
        assert!(!findings.is_lossy());
    }
    // Line ends of several kinds in one file.
    assert_eq!(read("a,b\r1,2\n3,4\r\n5,6").0.len(), 3);
}

#[test]
fn analytic_delimiters() {
    for (text, b) in [
        ("a,b\n1,2.5\n", 2.5),
        ("a;b\n1;2.5\n", 2.5),
        ("a\tb\n1\t2.5\n", 2.5),
        ("a|b\n1|2.5\n", 2.5),
        ("sep=;\na;b\n1;2.5\n", 2.5),
        ("a;b (x, y, z)\n1;2.5\n", 2.5),
    ] {
        let (table, _) = read(text);
        assert_eq!(table.columns()[1].values(), [b], "{text:?}");
    }
    let (table, findings) = read("a;b\n1,5;2\n2,5;3\n");
    assert_eq!(values(&table, "a"), [1.5, 2.5]);
    assert_eq!(
        findings.warnings,
        ["2 cells have a decimal comma; it was read as a decimal point"]
    );
    // One column has no delimiter at all.
    assert_eq!(values(&read("a\n1\n2\n").0, "a"), [1.0, 2.0]);
}

#[test]
fn analytic_header_behind_a_hash_and_comments() {
    let (table, _) = read("# made by hand\n# t, x (m)\n1,2\n# a remark\n3,4\n");
    assert_eq!(values(&table, "x (m)"), [2.0, 4.0]);
    let (table, _) = read("# made by hand\nt,x\n1,2\n");
    assert_eq!(values(&table, "t"), [1.0]);
}

#[test]
fn analytic_gaps_and_words() {
    let (table, findings) = read("a,b,c\n1,,x\nnan,2,y\nN/A,3,z\n4,inf,\n");
    let a = values(&table, "a");
    assert!(a[0] == 1.0 && a[1].is_nan() && a[2].is_nan() && a[3] == 4.0);
    assert_eq!(values(&table, "b")[3], f64::INFINITY);
    assert_eq!(findings.empty_cells["a"], 2);
    assert_eq!(findings.empty_cells["b"], 1);
    assert_eq!(findings.text_columns, ["c"]);
    assert!(!findings.is_lossy() && findings.warnings.is_empty());
    let kind = table.column("c").unwrap().kind().clone();
    let example = "x".to_owned();
    assert_eq!(kind, ColumnKind::Text { example });
}

#[test]
fn prop_a_column_of_numbers_with_thousands_separators_is_named() {
    let warned = |cells: &[&str]| {
        let rows = cells.iter().enumerate();
        let rows: String = rows.map(|(i, cell)| format!("{i},\"{cell}\"\n")).collect();
        let (table, findings) = read(&format!("time_s,thrust_n\n{rows}"));
        assert!(table.column("thrust_n").unwrap().is_text());
        findings.warnings
    };
    assert_eq!(
        warned(&["13,307.3", "1,238.1", "ends"]),
        [
            "column \"thrust_n\" was taken for text: most of its cells are numbers with thousands separators, the first in line 2: \
             expected a number, found \"13,307.3\". Write its numbers without separators"
        ]
    );
    assert!(warned(&["off", "1,238.1", "950.2", "1,200.0"])[0].contains("line 3"));
    // Notes, names, addresses and versions are text.
    for text in [
        &["hover", "climb", "1,200 m"][..],
        &["192.168.100.200", "192.168.100.201"],
        &["1.234.567", "1.234.568"],
        &["run 1", "1,200"],
    ] {
        assert_eq!(warned(text), [""; 0], "{text:?}");
    }
}

#[test]
fn analytic_stamps_become_seconds() {
    let (table, _) = read(
        "Timestamp,x\n2019-11-07 23:59:59:868,1\n2019-11-08 00:00:00:118,2\n,3\n2019-11-08 00:01:00:868,4\n",
    );
    let stamps = values(&table, "Timestamp");
    assert_eq!(
        table.column("Timestamp").unwrap().kind(),
        &ColumnKind::Stamp
    );
    assert!(stamps[2].is_nan());
    // Whole nanoseconds divided by 1e9: exact to the nearest number.
    assert_eq!([stamps[0], stamps[1], stamps[3]], [0.0, 0.25, 61.0]);
}

#[test]
fn analytic_odd_headers() {
    // A delimiter at the end of every line, of the header only, of the rows only.
    for text in ["a,b,\n1,2,\n", "a,b,\n1,2\n", "a,b\n1,2,\n"] {
        let (table, findings) = read(text);
        assert_eq!(table.columns().len(), 2, "{text:?}");
        assert!(!findings.is_lossy(), "{text:?}");
    }
    let (table, findings) = read("a,,a\n1,2,3\n");
    let names: Vec<&str> = table.columns().iter().map(Column::name).collect();
    assert_eq!(names, ["a", "column_2", "a#2"]);
    assert_eq!(findings.warnings.len(), 2);
    let (table, findings) = parse_csv("t.csv", b"ESC (\xb5s),b\n1,2\n").unwrap();
    assert_eq!(values(&table, "ESC (µs)"), [1.0]);
    assert_eq!(
        findings.warnings,
        ["the header is not UTF-8; it was read as Latin-1"]
    );
}

#[test]
fn analytic_a_row_of_units_is_passed_over() {
    let (table, findings) = read("t,f,who\ns,N,\n0,1,a\n1,2,b\n");
    assert_eq!(values(&table, "f"), [1.0, 2.0]);
    assert_eq!((findings.rows_read, findings.corrupt_rows), (2, 0));
    assert_eq!(
        findings.warnings,
        ["line 2 holds no number; it was read as a row of units"]
    );
    // Farther down it is a defect.
    assert!(read("t,f\n0,1\ns,N\n1,2\n").1.is_lossy());
}

#[test]
fn analytic_files_that_are_no_table() {
    assert!(matches!(fails(b""), LogError::Empty { .. }));
    assert!(matches!(
        fails(b"\xef\xbb\xbf\r\n \n"),
        LogError::Empty { .. }
    ));
    assert!(matches!(fails(b"\xff\xfea\0"), LogError::NotText { .. }));
    // Its first line is text.
    assert!(matches!(
        fails(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\n1,2\n3,4\n"),
        LogError::NotText { .. }
    ));
    assert!(matches!(
        fails(b"ULog\x01\x12\x35\x01\0"),
        LogError::NotText { .. }
    ));
    let only_header = fails(b"a,b\n");
    assert_eq!(
        only_header.to_string(),
        "t.csv: no usable rows: the file contains only a header"
    );
    let ragged = fails(b"a,b,c\n1,2\n3,4\n");
    assert!(
        ragged
            .to_string()
            .contains("line 2: expected 3 cells, found 2"),
        "{ragged}"
    );
    let missing = touchdown_log::read_csv("/nowhere/at/all.csv").unwrap_err();
    assert!(
        missing
            .to_string()
            .starts_with("/nowhere/at/all.csv: cannot be read: ")
    );
    for error in [only_header, ragged, missing] {
        assert_eq!(error.kind(), ErrorKind::Unreadable);
    }
}

#[test]
fn xval_sha256() {
    // printf 'a\n1\n' | sha256sum
    let (table, _) = read("a\n1\n");
    assert_eq!(
        table.sha256(),
        "309b0e45a73d3fc5325e2b6ed0a01ef8b9cde6b05a5633c1f893f970d52bfddc"
    );
}

proptest! {
    #[test]
    fn prop_any_bytes_are_a_table_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = parse_csv("p.csv", &bytes);
    }

    #[test]
    fn prop_any_likely_text_is_a_table_or_an_error(
        text in "[a-c\"#,;\t|\r\n0-9.eE+: \u{feff}nµ-]{0,200}"
    ) {
        if let Ok((table, findings)) = parse_csv("p.csv", text.as_bytes()) {
            prop_assert!(!table.is_empty());
            prop_assert!(table.columns().iter().all(|c| c.values().len() == table.len()));
            // Every row read is used or accounted for.
            let gone = findings.corrupt_rows + findings.empty_rows + usize::from(findings.truncated);
            prop_assert_eq!(findings.rows_used + gone, findings.rows_read);
            // Whatever it holds, it can be looked at, and the suggested map is one, with the
            // period where no column is the time.
            if let Some(map) = inspect(&table, None).suggested_map {
                let map = map.replace("\n# time_s = ", "\ntime_s = ");
                let parsed = Map::parse("suggested.toml", &map);
                prop_assert!(parsed.is_ok(), "{:?}\n{}", parsed.err().map(|e| e.to_string()), map);
            }
        }
    }
}

#[test]
fn analytic_tables_without_a_header_and_with_blanks() {
    let read = |text: &str| {
        let (table, findings) = parse_csv("t.txt", text.as_bytes()).unwrap();
        let columns = table.columns().iter();
        let columns = columns.map(|c| (c.name().to_owned(), c.values().to_vec()));
        (columns.collect::<Vec<_>>(), findings.warnings)
    };
    let columns = |names: [&str; 2]| {
        let [a, b] = names.map(str::to_owned);
        vec![(a, vec![0.0, 1.0]), (b, vec![2.5, 3.5])]
    };
    let headless = "the table has no header; its columns are called c1 to c2".to_owned();
    for text in [
        "0,2.5\n1,3.5\n",
        "0;2,5\n1;3,5\n",
        "0 2.5\n1 3.5\n",
        "  0.0   2.5\n  1.0\t3.5  \n",
        "# a stand of 2024\n0,2.5\n1,3.5\n",
        "# a stand of 2024\n0 2.5\n1 3.5\n",
        "0,2.5,\n1,3.5,\n",
    ] {
        let (found, warnings) = read(text);
        assert_eq!(found, columns(["c1", "c2"]), "{text:?}");
        assert!(warnings.contains(&headless), "{text:?}: {warnings:?}");
    }
    for text in [
        "t thrust\n0 2.5\n1 3.5\n",
        "# t thrust\n0 2.5\n1 3.5\n",
        "# made by hand\n# t,thrust\n0,2.5\n1,3.5\n",
    ] {
        assert_eq!(
            read(text),
            (columns(["t", "thrust"]), Vec::new()),
            "{text:?}"
        );
    }
    // Names that hold blanks themselves are not those of the columns.
    let (found, warnings) = read("Time (s)  Thrust (N)\n0 2.5\n1 3.5\n");
    assert_eq!(found, columns(["c1", "c2"]));
    let what = "line 1 does not have a name for each column".to_owned();
    assert_eq!(warnings, [what, headless]);
}

#[test]
fn analytic_decimal_commas_between_commas_are_asked_for() {
    let text = fails(b"time_s,throttle\n0,00,0,5\n0,01,0,6\n").to_string();
    assert!(
        text.contains("expected 2 cells, found 4 (decimal commas"),
        "{text}"
    );
    let text = fails(b"time_s,throttle\n0.0,0.5,1\n0.1,0.6,2\n").to_string();
    assert!(!text.contains("decimal commas"), "{text}");
}

#[test]
fn analytic_a_row_of_units_may_have_a_one() {
    let (table, findings) = read("time_s,throttle,thrust_n\ns,1,N\n0.0,0.5,3.0\n0.1,0.6,4.0\n");
    assert_eq!(values(&table, "throttle"), [0.5, 0.6]);
    assert_eq!(table.column("thrust_n").unwrap().unit(), Some("N"));
    assert_eq!(table.column("throttle").unwrap().unit(), None);
    assert!(!findings.is_lossy(), "{findings:?}");
}

#[test]
fn analytic_a_channel_of_text_is_refused_with_one_of_its_cells() {
    let refused = |text: &str| {
        let error = Map::identity_for(&read(text).0).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::BadInput);
        error.to_string()
    };
    for (text, column, example) in [
        // Percent, units and decimal commas in cells.
        (
            "time_s,throttle\n0.0,76.4%\n0.1,80.0%\n",
            "throttle",
            "76.4%",
        ),
        ("time_s,thrust_n_2\n0.0,3 N\n0.1,4 N\n", "thrust_n_2", "3 N"),
        (
            "time_s,throttle\n\"0,5\",0.1\n\"0,6\",0.2\n",
            "time_s",
            "0,5",
        ),
        (
            "time_s,throttle\n12:00:01.230,0.1\n12:00:01.240,0.2\n",
            "time_s",
            "12:00:01.230",
        ),
    ] {
        let expected = format!(
            "t.csv: expected numbers in the column {column:?}, found text such as {example:?}"
        );
        assert_eq!(refused(text), expected);
    }
    // Other text is passed over, and a map shows it.
    let (table, _) = read("time_s,throttle,pilot\n0.0,0.5,Ada\n0.1,0.6,Ada\n");
    assert!(Map::identity_for(&table).is_ok());
    let (table, _) = read("t [s],thr,pilot\n0.0,0.5,Ada\n0.1,0.6,Ada\n");
    let map = inspect(&table, None).suggested_map.unwrap();
    assert!(map.contains("# \"pilot\", text such as \"Ada\"\n"), "{map}");
}
