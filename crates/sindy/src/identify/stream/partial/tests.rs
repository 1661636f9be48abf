use proptest::prelude::*;

use super::PartialSums;
use crate::identify::stream::tests::long_run;
use crate::identify::{Columns, Identify, Settings, Smoothing};
use crate::{BlockSource, Library, Samples, SindyError};

/// Sources of these trajectories by their rows, cut out of one run behind each other.
fn sources(rows: &[&[usize]]) -> Vec<Samples> {
    let (_, record) = long_run(rows.iter().copied().flatten().sum(), 1e-2);
    let mut start = 0;
    let mut cut = |rows: &usize| -> Vec<Vec<f64>> {
        let part = start..start + rows;
        start = part.end;
        let all = [&record.time, &record.states[0], &record.states[1]];
        all.map(|c| c[part.clone()].to_vec()).into()
    };
    let of = |trajectories: &&[usize]| {
        let mut samples = Samples::new(&["t", "x", "y"]);
        for rows in *trajectories {
            samples.push_group(cut(rows)).unwrap();
        }
        samples
    };
    rows.iter().map(of).collect()
}

fn columns() -> Columns {
    Columns::new("t", &["x", "y"], &[]).unwrap()
}

fn identify() -> Identify {
    Identify::new(Library::polynomial(&["x", "y"], 3).unwrap())
}

fn empty(identify: &Identify, sources: &[Samples]) -> PartialSums {
    let all: Vec<&dyn BlockSource> = sources.iter().map(|s| s as _).collect();
    let names: Vec<String> = (0..all.len()).map(|k| format!("run {k}")).collect();
    identify.partial_sums(&columns(), &names, &all).unwrap()
}

fn filled(identify: &Identify, sources: &[Samples]) -> PartialSums {
    let mut sums = empty(identify, sources);
    for (k, source) in sources.iter().enumerate() {
        sums.add(k, source).unwrap();
    }
    sums
}

/// All that an identification holds, every number to the bit.
fn result(sums: PartialSums) -> String {
    format!("{:?}", sums.identify(&mut |_| ()).unwrap())
}

/// Long trajectories, some of which go on behind the rows that decide, short ones, and one that is too short to use.
const ROWS: [&[usize]; 9] = [
    &[20_000],
    &[4_000, 300, 20],
    &[45_000],
    &[2],
    &[17],
    &[900, 900],
    &[9_000],
    &[5_000],
    &[1_500],
];

#[test]
fn prop_one_source_has_the_bits_of_a_stream() {
    // With the decision in the middle of a trajectory, between two, and at the end.
    let cases: [&[usize]; 4] = [
        &[120_000],
        &[30_000, 20_000, 10_000],
        &[10_000, 45_000, 40],
        &[7_000, 30],
    ];
    let smoothings = [
        Smoothing::Automatic,
        Smoothing::Spline,
        Smoothing::FiniteDifference { order: 4 },
    ];
    for (rows, smoothing) in cases.iter().zip(smoothings.iter().cycle()) {
        let all = sources(&[rows]);
        let settings = Settings {
            smoothing: *smoothing,
            ..Settings::default()
        };
        let identify = identify().settings(settings).unwrap();
        let stream = identify.run_stream(&all[0], &columns(), &mut |_| ());
        let found = result(filled(&identify, &all));
        assert_eq!(found, format!("{:?}", stream.unwrap()), "{rows:?}");
    }
}

#[test]
fn prop_every_division_and_every_order_give_the_same_bits() {
    let all = sources(&ROWS);
    let identify = identify()
        .settings(Settings {
            // Fewer than the rows: pieces have to be thinned out.
            rows: 20_000,
            ..Settings::default()
        })
        .unwrap();
    let empty = empty(&identify, &all);
    let one: Vec<PartialSums> = (0..all.len())
        .map(|k| {
            let mut sums = empty.clone();
            sums.add(k, &all[k]).unwrap();
            sums
        })
        .collect();
    let expected = filled(&identify, &all);
    let order = Just((0..all.len()).collect::<Vec<_>>()).prop_shuffle();
    let workers = proptest::collection::vec(0..4_usize, all.len());
    proptest!(ProptestConfig::with_cases(64), |(order in order, workers in workers)| {
        let mut parts = vec![empty.clone(); 4];
        for k in order {
            let text = one[k].to_json().unwrap();
            parts[workers[k]].merge(PartialSums::from_json(&text).unwrap()).unwrap();
        }
        let mut found = parts.pop().unwrap();
        for part in parts {
            found.merge(PartialSums::from_json(&part.to_json().unwrap()).unwrap()).unwrap();
        }
        prop_assert!(found == expected);
        prop_assert_eq!(found.to_json().unwrap(), expected.to_json().unwrap());
    });
    // And where a worker passes over several sources itself.
    let (mut a, mut b) = (empty.clone(), empty);
    for k in [8, 1, 3, 4, 0] {
        a.add(k, &all[k]).unwrap();
    }
    for k in [2, 7, 6, 5] {
        b.add(k, &all[k]).unwrap();
    }
    b.merge(a).unwrap();
    assert_eq!(b, expected);
    assert!(b.missing().is_empty());
    assert_eq!(b.rows(), ROWS.iter().copied().flatten().sum::<usize>());
    assert_eq!(result(b), result(expected));
}

#[test]
fn prop_sums_by_source_are_those_of_all_rows() {
    let all = sources(&ROWS);
    let mut whole = Samples::new(&["t", "x", "y"]);
    for source in &all {
        for group in 0..source.groups() {
            whole.push_group(source.group(group).to_vec()).unwrap();
        }
    }
    let stream = identify()
        .run_stream(&whole, &columns(), &mut |_| ())
        .unwrap();
    let found = filled(&identify(), &all).identify(&mut |_| ()).unwrap();
    assert_eq!(found.data, stream.data);
    let pairs = found.model.equations().iter().flatten();
    for (a, b) in pairs.zip(stream.model.equations().iter().flatten()) {
        assert_eq!(a.expression, b.expression);
        // The same rows, summed in another order.
        let error = (a.coefficient - b.coefficient).abs();
        assert!(error < 1e-12, "{} {}", a.coefficient, b.coefficient);
        // Blocks go to other clusters, whose scatter is the error: of 60 clusters it is known to about 10 %.
        let (a, b) = (a.std_error.unwrap(), b.std_error.unwrap());
        assert!((a / b - 1.0).abs() < 0.3, "{a} {b}");
    }
}

#[test]
fn prop_what_does_not_belong_together_is_one_clear_error() {
    let all = sources(&[&[400], &[300], &[200]]);
    let mut sums = filled(&identify(), &all[..2]);
    let before = sums.clone();
    let says = |error: Result<(), SindyError>, text: &str| {
        let error = error.unwrap_err().to_string();
        assert!(error.contains(text), "{text}: {error}");
    };
    says(sums.add(1, &all[1]), "each source once, found run 1 again");
    says(sums.add(2, &all[2]), "a number below 2, found 2");
    says(
        sums.merge(before.clone()),
        "each source once, found run 0 in two of them",
    );
    let other = |identify: Identify| empty(&identify, &all[..2]);
    let library = Library::polynomial(&["x", "y"], 2).unwrap();
    says(
        sums.merge(other(Identify::new(library))),
        "terms: expected [[",
    );
    let settings = Settings {
        folds: 7,
        ..Settings::default()
    };
    let settings = identify().settings(settings).unwrap();
    says(sums.merge(other(settings)), "settings: expected Settings");
    says(sums.merge(empty(&identify(), &all)), "sources: expected [");
    let rows = sources(&[&[500], &[300]]);
    says(
        sums.merge(empty(&identify(), &rows)),
        "the plan of the first rows",
    );
    assert_eq!(sums, before);

    let mut part = empty(&identify(), &all);
    part.add(1, &all[1]).unwrap();
    says(
        part.clone().identify(&mut |_| ()).map(|_| ()),
        "those of all 3 sources, found none of 2 of them, the first of which is run 0",
    );
}

#[test]
fn prop_a_damaged_text_is_one_clear_error() {
    let all = sources(&[&[400], &[300]]);
    let text = filled(&identify(), &all).to_json().unwrap();
    let says = |text: &str, what: &str| {
        let error = PartialSums::from_json(text).unwrap_err().to_string();
        assert!(
            error.starts_with("partial sums: ") && error.contains(what),
            "{error}"
        );
    };
    says("", "EOF");
    // Not inside of a number, which would be the fault instead.
    let half = text[..text.len() / 2].rfind(',').unwrap();
    for end in [1, 100, half, text.len() - 1] {
        says(&text[..end], "EOF");
    }
    says(
        &text.replacen("\"format\":1", "\"format\":2", 1),
        "found format 2",
    );
    says(
        &text.replacen("\"level\":1", "\"level\":60", 1),
        "of different counts",
    );
    says(
        &text.replacen("\"level\":1", "\"level\":2", 1),
        "of different counts",
    );
    says(
        &text.replacen("\"first\":0", "\"first\":1", 1),
        "of different counts",
    );
    says(
        &text.replacen("\"xty\":[", "\"xty\":[1.0,", 1),
        "numbers, found",
    );
    says(
        &text.replacen("\"block\":", "\"block\":9", 1),
        "of different counts",
    );
    says(
        &text.replacen("\"smooth\":[[", "\"smooth\":[[1.0,", 1),
        "of different counts",
    );
    says(
        &text.replacen("\"period\":", "\"unknown\":1,\"period\":", 1),
        "unknown field",
    );
}
