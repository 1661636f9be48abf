//! Figures as SVG, PNG and Plotly description.

use proptest::prelude::*;
use resvg::{tiny_skia, usvg};
use touchdown_report::{Color, Error, Figure, MAX_DRAWN_POINTS, Panel, Series};

fn ramp(n: usize) -> Vec<f64> {
    (0..n).map(|i| i as f64).collect()
}

fn one(series: Series) -> Figure {
    Figure::new("test", "A title").panel(Panel::new("Time (s)", "Height (m)").series(series))
}

/// All kinds of series on two panels.
fn rich() -> Figure {
    let x: Vec<f64> = (0..60).map(|i| 0.1 * f64::from(i)).collect();
    let y: Vec<f64> = x.iter().map(|x| x.sin()).collect();
    let low: Vec<f64> = y.iter().map(|y| y - 0.3).collect();
    let high: Vec<f64> = y.iter().map(|y| y + 0.3).collect();
    Figure::new("rich", "All kinds")
        .caption("One of each.")
        .share_x()
        .panel(
            Panel::new("Time (s)", "Height (m)")
                .title("Curves")
                .series(Series::line("line", &x, &y))
                .series(Series::band("band", &x, &low, &high))
                .series(Series::dashed("dashed", &x, &low))
                .series(Series::dotted("dotted", &x, &high))
                .series(Series::horizontal("zero", 0.0))
                .series(Series::vertical("touchdown", 3.0)),
        )
        .panel(
            Panel::new("Time (s)", "Thrust (N)")
                .series(Series::points("points", &x, &low))
                .series(Series::lines_points("both", &x, &high))
                .series(Series::steps("steps", &x[..20], &y[..20]))
                .series(Series::bars("bars", &x, &y))
                .series(Series::error_bars(
                    "errors",
                    &x[30..],
                    &y[30..],
                    &vec![0.2; 30],
                )),
        )
}

fn pixels(png: &[u8]) -> tiny_skia::Pixmap {
    tiny_skia::Pixmap::decode_png(png).expect("a PNG")
}

/// Share of pixels that are near the colour.
fn share(pixmap: &tiny_skia::Pixmap, [r, g, b]: [u8; 3]) -> f64 {
    let near = |p: &&tiny_skia::PremultipliedColorU8| {
        p.red().abs_diff(r) < 8 && p.green().abs_diff(g) < 8 && p.blue().abs_diff(b) < 8
    };
    pixmap.pixels().iter().filter(near).count() as f64 / pixmap.pixels().len() as f64
}

#[test]
fn analytic_svg_needs_no_fonts_and_nothing_from_outside() {
    let svg = rich().svg().unwrap();
    for forbidden in ["<text", "font-family", "<image", "<script", "NaN", "inf"] {
        assert!(!svg.contains(forbidden), "{forbidden}");
    }
    let urls = svg.matches("http").count();
    assert_eq!(urls, 1, "only the name of the SVG namespace");
}

#[test]
fn xval_png_looks_like_our_svg_drawn_by_resvg() {
    let figure = rich();
    let ours = pixels(&figure.png(1.0).unwrap());
    let tree = usvg::Tree::from_str(&figure.svg().unwrap(), &usvg::Options::default()).unwrap();
    let mut theirs = tiny_skia::Pixmap::new(ours.width(), ours.height()).unwrap();
    resvg::render(&tree, tiny_skia::Transform::default(), &mut theirs.as_mut());
    assert_eq!(
        tree.size().to_int_size().dimensions(),
        (ours.width(), ours.height())
    );
    let different = ours
        .data()
        .iter()
        .zip(theirs.data())
        .filter(|(a, b)| a.abs_diff(**b) > 64)
        .count();
    // Coordinates in the SVG have two decimals: edges differ a little, nothing may be missing or moved. A curve moved
    // by one pixel would already change about 1 % of all bytes.
    assert!(
        (different as f64) < 2e-3 * ours.data().len() as f64,
        "{different} bytes differ"
    );
}

#[test]
fn analytic_png_has_its_size_and_its_curve() {
    let blue = Color::Cycle(0).rgb();
    let figure = one(Series::line("curve", &ramp(100), &ramp(100)).width(3.0)).size(600, 300);
    for (scale, size) in [(1.0, (600, 300)), (2.0, (1200, 600)), (0.5, (300, 150))] {
        let pixmap = pixels(&figure.png(scale).unwrap());
        assert_eq!((pixmap.width(), pixmap.height()), size);
        // A line of 3 px across 600 × 300 px is about 1 % of the picture; smoothed edges do not count.
        assert!(
            (0.002..0.02).contains(&share(&pixmap, blue)),
            "{}",
            share(&pixmap, blue)
        );
        assert!(share(&pixmap, [255, 255, 255]) > 0.8);
    }
}

#[test]
fn analytic_gaps_are_not_joined() {
    let mut y = ramp(5);
    y[2] = f64::NAN;
    let whole = one(Series::line("", &ramp(5), &ramp(5)).color(Color::Rgb(1, 2, 3)));
    let broken = one(Series::line("", &ramp(5), &y).color(Color::Rgb(1, 2, 3)));
    let runs = |figure: &Figure| {
        let svg = figure.svg().unwrap();
        let line = svg
            .lines()
            .find(|l| l.contains("stroke=\"#010203\""))
            .unwrap()
            .to_owned();
        line.matches('M').count()
    };
    assert_eq!((runs(&whole), runs(&broken)), (1, 2));
    let json = broken.plotly_json().unwrap();
    assert!(json["data"][0]["y"][2].is_null() && json["data"][0]["connectgaps"] == false);
}

#[test]
fn analytic_a_lone_sample_between_gaps_is_seen() {
    let y = [f64::NAN, 1.0, f64::NAN];
    let pixmap = pixels(
        &one(Series::line("", &ramp(3), &y).width(4.0))
            .png(1.0)
            .unwrap(),
    );
    assert!(share(&pixmap, Color::Cycle(0).rgb()) > 0.0);
}

#[test]
fn analytic_thinning_keeps_extremes() {
    let n = 200_000;
    let mut y: Vec<f64> = ramp(n).iter().map(|x| (1e-3 * x).sin()).collect();
    y[77_777] = 5.0;
    y[150_001] = -7.0;
    let json = one(Series::line("y", &ramp(n), &y)).plotly_json().unwrap();
    let shown: Vec<f64> = json["data"][0]["y"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(serde_json::Value::as_f64)
        .collect();
    assert!(shown.len() <= MAX_DRAWN_POINTS, "{}", shown.len());
    assert!(shown.contains(&5.0) && shown.contains(&-7.0));
    let svg = one(Series::line("y", &ramp(n), &y)).svg().unwrap();
    // 4000 points of about 14 characters, and the letters.
    assert!(svg.len() < 120_000, "{} bytes", svg.len());
}

#[test]
fn analytic_stacked_panels_share_their_edges() {
    let wide = Series::line("", &ramp(3), &[1e5, 2e5, 3e5]);
    let narrow = Series::line("", &ramp(3), &[1.0, 2.0, 3.0]);
    let svg = Figure::new("test", "t")
        .panel(Panel::new("x", "a").series(wide))
        .panel(Panel::new("x", "b").series(narrow))
        .svg()
        .unwrap();
    let edges: Vec<&str> = svg
        .split("<clipPath")
        .skip(1)
        .map(|clip| {
            clip.split("y=")
                .next()
                .unwrap()
                .split("<rect")
                .nth(1)
                .unwrap()
        })
        .collect();
    assert_eq!(edges.len(), 2);
    assert_eq!(edges[0], edges[1]);
}

#[test]
fn analytic_wrong_figures_are_told_what_is_wrong() {
    let y = ramp(3);
    let message = |figure: Figure| figure.svg().unwrap_err().to_string();
    assert!(message(Figure::new("a/b", "")).contains("a/b"));
    assert!(message(Figure::new("a", "")).contains("at least one panel"));
    let short = message(one(Series::line("thrust", &ramp(4), &y)));
    assert!(
        short.contains("thrust") && short.contains('3') && short.contains('4'),
        "{short}"
    );
    let short = message(one(Series::band("b", &ramp(3), &y, &ramp(2))));
    assert!(short.contains("upper"), "{short}");
    let range = Panel::new("x", "y").y_range(2.0, 1.0);
    assert!(message(Figure::new("a", "").panel(range)).contains("(2, 1)"));
    let range = Panel::new("x", "y").log_x().x_range(0.0, 1.0);
    assert!(message(Figure::new("a", "").panel(range)).contains("logarithmic"));
    let scale = one(Series::line("", &y, &y)).png(f32::NAN);
    assert!(matches!(scale, Err(Error::Setting { key: "scale", .. })));
}

#[test]
fn analytic_files_are_written_whole_and_named_by_id() {
    let directory = tempfile::tempdir().unwrap();
    let paths = rich().write(directory.path()).unwrap();
    assert_eq!(paths[0], directory.path().join("rich.svg"));
    assert!(std::fs::read(&paths[1]).unwrap().starts_with(b"\x89PNG"));
    let names = std::fs::read_dir(directory.path()).unwrap().count();
    assert_eq!(names, 2, "no temporary file is left");
    let error = rich().write(directory.path().join("absent")).unwrap_err();
    assert!(matches!(error, Error::Write { .. }));
}

#[test]
fn analytic_reference_lines_and_order_in_the_description() {
    let json = rich().plotly_json().unwrap();
    assert_eq!(json["data"][0]["name"], "band", "bands lie below");
    assert_eq!(json["layout"]["shapes"][0]["yref"], "y");
    assert_eq!(json["layout"]["shapes"][1]["yref"], "y domain");
    assert_eq!(json["data"][8]["yaxis"], "y2");
    assert!(json["layout"]["xaxis2"].is_null(), "one shared x");
}

#[test]
fn analytic_markup_in_names_is_shown_as_written() {
    let figure = one(Series::line("a<b> & \"c\"", &ramp(3), &ramp(3)));
    let figure = Figure {
        title: "x < y & z".to_owned(),
        caption: "1 < 2".to_owned(),
        ..figure
    };
    let svg = figure.svg().unwrap();
    assert!(usvg::Tree::from_str(&svg, &usvg::Options::default()).is_ok());
    assert!(svg.contains("x &lt; y &amp; z") && svg.contains("1 &lt; 2"));
    assert_eq!(
        figure.plotly_json().unwrap()["data"][0]["name"],
        "a&lt;b&gt; &amp; \"c\""
    );
}

#[test]
fn regress_values_far_outside_fixed_limits_stay_finite() {
    let panel = Panel::new("x", "y").y_range(-1.0, 1.0).series(Series::line(
        "",
        &[f64::MAX, 0.0, 1.0],
        &[f64::MAX, f64::MIN, 2.5e166],
    ));
    let svg = Figure::new("far", "").panel(panel).svg().unwrap();
    assert!(!svg.contains("inf") && !svg.contains("NaN"));
}

#[test]
fn regress_legends_stay_within_the_picture() {
    let x = ramp(20);
    let y: Vec<f64> = x.iter().map(|x| 1e6 + 1e-3 * x).collect();
    let mut panel = Panel::new("x", "y").title("Crowded");
    for _ in 0..9 {
        panel = panel.series(Series::line("a method with a rather long name", &x, &y));
    }
    let svg = Figure::new("wide", "")
        .panel(panel)
        .size(800, 400)
        .svg()
        .unwrap();
    let tree = usvg::Tree::from_str(&svg, &usvg::Options::default()).unwrap();
    let right = tree.root().abs_bounding_box().right();
    assert!(right <= 800.0, "{right}");
}

fn awkward() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<f64>(),
        -10.0..10.0f64,
        Just(f64::NAN),
        Just(f64::INFINITY),
        Just(f64::MAX),
        Just(f64::MIN_POSITIVE),
        Just(5e-324),
        Just(0.0),
        Just(1e15 + 0.125),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever the numbers, every picture is drawn, parses, and has no number that is not finite.
    #[test]
    fn prop_any_numbers_can_be_drawn(
        rows in prop::collection::vec((awkward(), awkward(), awkward()), 0..12),
        kind in 0usize..10,
        log_x: bool,
        log_y: bool,
        equal_aspect: bool,
        range in prop::option::of((-1e3..0.9e3f64, 1e3..1e9f64)),
    ) {
        let [x, y, z]: [Vec<f64>; 3] = [
            rows.iter().map(|r| r.0).collect(),
            rows.iter().map(|r| r.1).collect(),
            rows.iter().map(|r| r.2).collect(),
        ];
        let series = match kind {
            0 => Series::line("s", &x, &y),
            1 => Series::dashed("s", &x, &y),
            2 => Series::dotted("s", &x, &y),
            3 => Series::points("s", &x, &y),
            4 => Series::lines_points("s", &x, &y),
            5 => Series::bars("s", &x, &y),
            6 => Series::steps("s", &x, &y),
            7 => Series::band("s", &x, &y, &z),
            8 => Series::error_bars("s", &x, &y, &z),
            _ => Series::horizontal("s", y.first().copied().unwrap_or(f64::NAN)),
        };
        let y_range = range.filter(|_| !log_y);
        let panel = Panel { log_x, log_y, equal_aspect, y_range, ..Panel::new("x", "y") }.series(series);
        let figure = Figure::new("any", "any").size(300, 200).panel(panel);
        let svg = figure.svg().unwrap();
        prop_assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        prop_assert!(usvg::Tree::from_str(&svg, &usvg::Options::default()).is_ok());
        let pixmap = pixels(&figure.png(1.0).unwrap());
        prop_assert_eq!((pixmap.width(), pixmap.height()), (300, 200));
        let json = figure.plotly_json().unwrap();
        prop_assert!(json["layout"]["yaxis"]["range"].as_array().unwrap().iter().all(serde_json::Value::is_number));
    }

    /// Whatever the words, they are drawn or cut, never a panic or a broken file.
    #[test]
    fn prop_any_words_can_be_drawn(title in ".{0,200}", label in ".{0,80}", name in ".{0,120}", category in ".{0,30}") {
        let panel = Panel::new(label.clone(), label.clone())
            .title(title.clone())
            .categories([category.clone(), category])
            .series(Series::bars(name, &[0.0, 1.0], &[1.0, 2.0]));
        let figure = Figure::new("words", title).caption(label).size(240, 120).panel(panel);
        let svg = figure.svg().unwrap();
        prop_assert!(usvg::Tree::from_str(&svg, &usvg::Options::default()).is_ok());
        prop_assert!(figure.png(1.0).is_ok());
    }
}
