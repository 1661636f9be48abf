//! The main job with its defaults, judged by what it promises: seeds 1 and 2, 40 landings of every method.

use touchdown_campaign::progress::Silent;
use touchdown_flight::Method;
use touchdown_model::Form;
use touchdown_reproduce::experiments::results::Results;
use touchdown_reproduce::experiments::{self, Run, thrust};
use touchdown_reproduce::settings::ReproduceSettings;
use touchdown_sim::rig::sets::VALIDATION_KINDS;

fn run(seed: u64) -> Run {
    let settings = ReproduceSettings {
        seed,
        ..ReproduceSettings::default()
    };
    experiments::run(&settings, &Silent).unwrap()
}

fn check(run: &Run) {
    let results = Results::of(run).unwrap();
    // Thrust, plate removed, eq. (8): 0.06 N is a quarter of a percent of full thrust.
    for kind in thrust::KINDS {
        let mae = results.thrust.plate_removed["eq8"][kind].mae_n.unwrap();
        assert!(mae <= 0.06, "eq8 {kind}: {mae}");
        // The plate at 0.75 m leaves its own ground effect in the reference: 0.14 N at hover.
        let biased = results.thrust.plate_present["eq8"][kind].mae_n.unwrap();
        assert!(biased > 2.0 * mae, "plate present {kind}: {biased}");
    }
    // The lag form on the rich data, each kind of unseen trial: 0.03 N, a third of the turbulence there.
    let ge = &results.ground_effect;
    for kind in VALIDATION_KINDS {
        let mae = |form: Form| ge.rich_data[form.name()][kind].mae_n.unwrap();
        assert!(mae(Form::Lag) <= 0.03, "lag {kind}: {}", mae(Form::Lag));
        assert!(mae(Form::Lag) < mae(Form::Empirical), "{kind}");
    }
    // The ground: feedback hovers where the paper's did, within 0.14..0.17 m; the model lands.
    let ground = &results.ground_landing;
    let feedback = &ground[Method::Feedback.name()];
    assert_eq!((feedback.trials, feedback.landed), (40, 0));
    let hover = feedback.hover_height_m.unwrap().mean;
    assert!((0.14..=0.17).contains(&hover), "hover {hover}");
    let time = |m: Method| ground[m.name()].t_l_s.unwrap().mean;
    assert_eq!(ground[Method::Dynamic.name()].landed, 40);
    assert!(
        (4.8..=5.6).contains(&time(Method::Dynamic)),
        "dynamic {}",
        time(Method::Dynamic)
    );
    assert!(time(Method::Dynamic) < time(Method::Empirical));
    // The deck, its acceleration fed forward: faster than both comparators, and gentle.
    let deck = &results.deck_landing.with_acceleration;
    let time = |m: Method| deck[m.name()].t_l_s.unwrap().mean;
    assert_eq!(deck[Method::Dynamic.name()].landed, 40);
    assert!(time(Method::Dynamic) <= 0.9 * time(Method::Imbc));
    assert!(time(Method::Dynamic) <= 0.8 * time(Method::Ssc));
    assert!(deck[Method::Dynamic.name()].v_l_mps.unwrap().mean <= 0.06);
    // The internal model has no acceleration term: one figure in both columns.
    assert_eq!(
        deck["imbc"],
        results.deck_landing.without_acceleration["imbc"]
    );
}

#[test]
fn paper_promises_of_the_main_job_seed_1() {
    let run = run(1);
    check(&run);
    book(&Results::of(&run).unwrap());
}

/// The book's table of the terms that the equations need.
fn sparsity(results: &Results, text: &str) {
    let ge = &results.ground_effect;
    let rows = [
        (
            "eq. (8), throttle to thrust",
            &results.thrust.fronts["plate_removed"],
        ),
        ("eq. (9), the paper's scenarios", &ge.fronts["paper_data"]),
        ("eq. (9), rich data", &ge.fronts["rich_data"]),
        (
            "eq. (9), vehicle and plate both move",
            &ge.fronts["moving_data"],
        ),
    ];
    for (name, front) in rows {
        assert!(front.certificate.proven, "{name}");
        let all = front.sizes.len() - 1;
        let left = |k: usize| format!("{:.4}", front.sizes[k].left_out_rmse.unwrap());
        let run = |k: usize| match front.sizes[k].free_run_rmse_n {
            Some(v) if v < 10.0 => format!("{v:.3}"),
            _ => "unstable".to_string(),
        };
        let freely = match (front.sizes[all].free_run_rmse_n, run(all).as_str()) {
            _ if front.of == "x'" => " |".to_string(),
            (_, "unstable") => format!(" {} N, unstable |", run(front.chosen_terms)),
            _ => format!(" {}, {} N |", run(front.chosen_terms), run(all)),
        };
        let row = format!(
            "| {name} | {} | {} | {} | {} | {}, {}, {} {} |{freely}",
            front.certificate.subsets,
            front.certificate.nodes,
            front.model.terms,
            front.chosen_terms,
            left(front.chosen_terms),
            left(all),
            left(0),
            front.unit
        );
        assert!(text.contains(&row), "docs/src/paper.md lacks: {row}");
    }
    let moving = &ge.fronts["moving_data"];
    let share = moving.sizes[11].training_rmse / moving.sizes[0].training_rmse;
    let level = |model: &str| {
        let found = ge.levels["rich_data"].iter().find(|l| l.model == model);
        found.unwrap().free_run_rmse_n.unwrap()
    };
    let printed = ge.relative_velocity["printed_eq12"];
    let flat = text.split_whitespace().collect::<Vec<_>>().join(" ");
    for expected in [
        format!("{:.1} % of its mean square", 100.0 * (1.0 - share * share)),
        format!("SR3 on eq. (9) leaves {:.3} N", level("derivative")),
        format!(
            "refined by multiple shooting leave {:.3} N",
            level("refined")
        ),
        format!("the lag form leaves {:.3} N", level("lag")),
        format!(
            "leave {:.4} N/s of {:.3} N/s",
            printed.relative.training_rmse_n_per_s, printed.target_rms_n_per_s
        ),
    ] {
        assert!(
            flat.contains(&expected),
            "docs/src/paper.md lacks: {expected}"
        );
    }
}

/// The figures that the book's page on the paper shows are those of this very run.
fn book(results: &Results) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/src/paper.md");
    let text = std::fs::read_to_string(path).unwrap();
    sparsity(results, &text);
    let mean = |s: Option<touchdown_campaign::statistics::Summary>| s.unwrap().mean;
    let ground = &results.ground_landing;
    let hover = format!("hovers at {:.3} m", mean(ground["feedback"].hover_height_m));
    assert!(text.contains(&hover), "docs/src/paper.md lacks: {hover}");
    let deck = &results.deck_landing.with_acceleration;
    let rows = [
        ("ground", ground, "empirical"),
        ("ground", ground, "dynamic"),
    ]
    .into_iter()
    .chain(["imbc", "ssc", "dynamic"].map(|m| ("deck", deck, m)));
    for (place, figures, method) in rows {
        let f = &figures[method];
        let row = text
            .lines()
            .find(|l| l.starts_with(&format!("| {place}, `{method}`")))
            .unwrap_or_else(|| panic!("docs/src/paper.md has no row of {place}, {method}"));
        let expected = format!(
            "| {} | {:.2} | {:.3} |",
            f.landed,
            mean(f.t_l_s),
            mean(f.v_l_mps)
        );
        assert!(row.contains(&expected), "{row}\nshould have {expected}");
    }
    let range = |form: &str| {
        let errors: Vec<f64> = results.ground_effect.rich_data[form]
            .values()
            .map(|e| e.mae_n.unwrap())
            .collect();
        let least = errors.iter().copied().fold(f64::INFINITY, f64::min);
        (least, errors.iter().copied().fold(0.0, f64::max))
    };
    let eq8 = &results.thrust.plate_removed["eq8"];
    let (lag, derivative, empirical) = (range("lag"), range("derivative"), range("empirical"));
    for expected in [
        format!(
            "eq. (8) {:.3} N on a ramp and {:.3} N on a sine",
            eq8["ramp"].mae_n.unwrap(),
            eq8["sine"].mae_n.unwrap()
        ),
        format!("lag form {:.3} to {:.3} N", lag.0, lag.1),
        format!("derivatives {:.2} to {:.2} N", derivative.0, derivative.1),
        format!("eq. (2) {:.2} to {:.2} N", empirical.0, empirical.1),
    ] {
        // The text may be broken anywhere.
        let flat = text.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(
            flat.contains(&expected),
            "docs/src/paper.md lacks: {expected}"
        );
    }
}

#[test]
fn paper_promises_of_the_main_job_seed_2() {
    check(&run(2));
}
