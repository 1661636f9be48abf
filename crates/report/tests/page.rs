//! The HTML report.

use serde_json::json;
use touchdown_report::{Callout, Cell, Error, Figure, Panel, Report, Scene, Series, Table, Term};

const TERMS: [Term; 1] = [Term {
    names: &["free run"],
    meaning: "A simulation from the first state.",
}];

fn figure(n: usize) -> Figure {
    let x: Vec<f64> = (0..n).map(|i| i as f64).collect();
    Figure::new("curve", "A curve")
        .caption("From `a` to b.")
        .panel(Panel::new("Time (s)", "Height (m)").series(Series::line("</script><b>", &x, &x)))
}

fn report() -> Report {
    let mut report = Report::new("Landing <1> & more");
    report
        .subtitle("sub")
        .fact("Seed", "1")
        .section("First & best")
        .subsection("Part")
        .section("Second");
    report
        .paragraph("a < b & `c<d>` **e**")
        .list(["<li>"])
        .code("if a < b {}")
        .callout(Callout::Warning, "<script>alert(1)</script>")
        .highlights([["Speed", "0.2 m/s", ""]])
        .table(
            Table::new("T")
                .text_column("<col>")
                .number_column("V", "m/s")
                .row(["<x>".into(), Cell::missing()]),
        )
        .unwrap()
        .figure(&figure(10))
        .unwrap()
        .figure(&figure(20))
        .unwrap();
    report
}

/// The page without plotly.js, whose text is not ours.
fn own_part(html: &str) -> String {
    let begin = html.find("/**\n* plotly.js").expect("plotly.js");
    let end = begin + html[begin..].find("</script>").unwrap();
    format!("{}{}", &html[..begin], &html[end..])
}

#[test]
fn analytic_nothing_is_loaded_from_outside() {
    let html = report().html();
    let own = own_part(&html).replace("http://www.w3.org/2000/svg", "");
    for forbidden in [
        "http:",
        "https:",
        "src=\"",
        "@import",
        "url(//",
        "fetch(",
        "XMLHttpRequest",
    ] {
        assert!(!own.contains(forbidden), "{forbidden}");
    }
    assert_eq!(own.matches("<link").count(), 1, "the empty icon");
    assert!(
        html.contains("default-src 'none'"),
        "and the browser is told to refuse"
    );
    assert_eq!(
        html.matches("* plotly.js (basic - minified) v3").count(),
        1,
        "embedded once"
    );
}

#[test]
fn analytic_text_is_escaped() {
    let own = own_part(&report().html());
    for shown in [
        "<title>Landing &lt;1&gt; &amp; more</title>",
        "a &lt; b &amp; <code>c&lt;d&gt;</code> <strong>e</strong>",
        "<li>&lt;li&gt;</li>",
        "if a &lt; b {}",
        "&lt;script&gt;alert(1)",
        "&lt;col&gt;",
        "<td class=\"left\">&lt;x&gt;</td>",
    ] {
        assert!(own.contains(shown), "{shown}");
    }
    assert!(!own.contains("</script><b>"), "a name cannot end the data");
}

#[test]
fn analytic_blocks_are_numbered_and_listed() {
    let html = report().html();
    for part in [
        "Figure 1. A curve",
        "Figure 2. A curve",
        "Table 1.",
        "First &amp; best</a>",
        ">Part</a>",
    ] {
        assert!(html.contains(part), "{part}");
    }
}

/// The descriptions of the figures.
fn descriptions(html: &str) -> Vec<serde_json::Value> {
    let data = html.split("<script type=\"application/json\">").skip(1);
    data.map(|rest| serde_json::from_str(rest.split("</script>").next().unwrap()).unwrap())
        .collect()
}

#[test]
fn analytic_chart_data_are_json() {
    let data = descriptions(&report().html());
    assert_eq!(data.len(), 2);
    assert_eq!(data[1]["data"][0]["x"].as_array().unwrap().len(), 20);
    assert_eq!(data[1]["data"][0]["name"], "&lt;/script&gt;&lt;b&gt;");
}

#[test]
fn analytic_landings_to_watch_are_data_beside_one_player() {
    let steps = |n: i32| -> Vec<[f64; 3]> { (0..n).map(|k| [0.0, 0.5, f64::from(k)]).collect() };
    let landing =
        json!({ "weight_n": 13.4, "frames": { "position_m": steps(400), "phase": ["</script>"] } });
    let scene = |id: &str| {
        Scene::new(id, "To <watch>")
            .caption("Of `a`.")
            .landing("planned", landing.clone())
    };
    let mut report = Report::new("t");
    report.figure(&figure(10)).unwrap();
    for id in ["one", "two"] {
        report.scene(scene(id)).unwrap();
    }
    let html = report.html();
    assert!(html.contains("Figure 3. To &lt;watch&gt;."));
    let data = descriptions(&html);
    let frames = &data[1]["landings"][0]["frames"];
    assert_eq!(
        frames["phase"][0], "</script>",
        "and it cannot end the data"
    );
    assert_eq!(frames["position_m"]["columns"][1]["low"], 0.5);
    assert_eq!(html.matches("figure.scene").count(), 1, "the player once");
    assert!(matches!(report.scene(scene("a b")), Err(Error::Id { .. })));
}

#[test]
fn analytic_the_page_draws_with_a_trace_that_its_bundle_has() {
    // The basic bundle has three kinds of traces; figures use two.
    for description in descriptions(&report().html()) {
        for trace in description["data"].as_array().unwrap() {
            assert!(["scatter", "bar"].contains(&trace["type"].as_str().unwrap()));
        }
    }
}

#[test]
fn analytic_a_term_is_explained_below_its_first_use_outside_folds() {
    let mut report = Report::new("t");
    report
        .glossary(&TERMS)
        .verdict(Callout::Success, "The free run follows.")
        .figure(&figure(10))
        .unwrap()
        .paragraph("A free run.");
    report
        .folded("Settings", |inner| -> Result<(), Error> {
            inner.code("a = 1");
            Ok(())
        })
        .unwrap();
    let html = report.html();
    let at = |part: &str| html.find(part).unwrap_or_else(|| panic!("{part}"));
    let explained = "<dfn>free run</dfn>: A simulation from the first state.";
    assert_eq!(html.matches(explained).count(), 1);
    // Verdict, its picture, and only then the words that explain.
    assert!(at("class=\"verdict success\"") < at("<figure class=\"chart\""));
    assert!(at("<figure class=\"chart\"") < at(explained));
    assert!(html.contains("<abbr title=\"A simulation from the first state.\">free run</abbr>"));
    assert!(html.contains(
        "<details><summary>Settings</summary><div><pre><code>a = 1</code></pre></div></details>"
    ));
}

#[test]
fn analytic_a_report_without_figures_is_small() {
    let mut report = Report::new("t");
    report.paragraph("words");
    // Two typefaces of 70 kB as base64, styles and words; no plotly.js.
    assert!(report.html().len() < 250_000, "{}", report.html().len());
}

#[test]
fn analytic_long_series_do_not_swell_the_report() {
    let mut report = Report::new("t");
    report.figure(&figure(1_000_000)).unwrap();
    let one = report.html().len();
    // plotly.js has 1.1 MB, the typefaces 0.2 MB.
    assert!(one < 1_500_000, "{one}");
    for _ in 0..20 {
        report.figure(&figure(1_000_000)).unwrap();
    }
    assert!(
        report.html().len() < one + 20 * 60_000,
        "{}",
        report.html().len()
    );
}

#[test]
fn analytic_wrong_blocks_are_refused() {
    let mut report = Report::new("t");
    let table = Table::new("T").text_column("a").row([]);
    assert!(matches!(
        report.table(table),
        Err(Error::Row {
            expected: 1,
            found: 0,
            ..
        })
    ));
    assert!(matches!(
        report.figure(&Figure::new("a", "")),
        Err(Error::NoPanels { .. })
    ));
}

#[test]
fn analytic_same_report_same_bytes_and_written_whole() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("report.html");
    report().write(&path).unwrap();
    report().write(&path).unwrap();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), report().html());
    assert_eq!(std::fs::read_dir(directory.path()).unwrap().count(), 1);
}
