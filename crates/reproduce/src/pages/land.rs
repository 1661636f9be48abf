//! The report of `touchdown land`.

use std::path::Path;

use touchdown_campaign::vertical::scenario::LandScenario;
use touchdown_report::Callout;

use super::landings::{self, Cloud};
use crate::error::Result;
use crate::experiments::landing::MethodLandings;
use crate::settings::to_toml;
use touchdown_pages::colors::TRIALS;
use touchdown_pages::page::{Page, how_made, show};

/// Writes `figures/*.svg`, `figures/*.png` and `report.html` of the landings of `methods` into the folder `out`;
/// before the landings stand the vehicle that is flown, where it followed the cards, and `warnings`.
///
/// # Errors
/// Files that cannot be written, or figures that cannot be drawn.
pub fn land(
    methods: &[MethodLandings],
    scenario: &LandScenario,
    vehicle: Option<&str>,
    warnings: &[String],
    out: &Path,
) -> Result<()> {
    let land = scenario.land();
    let mut page = Page::new(
        "Landings",
        "One scenario, one controller after the other, the same vehicles and the same air",
        out,
    );
    page.report
        .fact("Seed", scenario.seed.to_string())
        .fact("Landings of each method", scenario.trials.to_string());
    let (kind, verdict) = landings::verdict(methods);
    page.report.verdict(kind, verdict);
    page.figure(landings::heights(
        "heights",
        "Height over time",
        "The first recorded trials of each method, with the reference that all of them follow."
            .into(),
        methods,
        &land,
    ))?;
    page.report.section("Landings");
    page.text(landings::SYMBOLS);
    if let Some(vehicle) = vehicle {
        page.text(vehicle);
    }
    for warning in warnings {
        page.report.callout(Callout::Warning, warning.clone());
    }
    page.text(format!(
        "Start at {} m, landed at {} m, timeout {} s. The deck's acceleration is {}.",
        show(land.scenario.start_height_m, 2),
        show(land.scenario.landed_height_m, 2),
        show(land.scenario.timeout_s, 0),
        if scenario.deck_acceleration {
            "estimated and fed forward, where the deck moves in a sine (never for `imbc`)"
        } else {
            "not fed forward"
        }
    ));
    page.table(landings::figures_table("Landings by method.", methods))?;
    page.figure(landings::height_and_velocity(
        "height-velocity",
        "Relative height and velocity of the first trial",
        "The same vehicle, air and deck for each method. Dots: the landing.".into(),
        methods,
        &land,
    ))?;
    let cloud = Cloud {
        name: "trials",
        methods,
        color: TRIALS,
    };
    if let Some(figure) = landings::distribution(
        "distribution",
        "Landing time and speed of every trial",
        "Methods that landed in fewer than half of the trials are left out.".into(),
        &[cloud],
        &|_| None,
    ) {
        page.figure(figure)?;
    }
    how_made(
        &mut page.report,
        "touchdown land scenario.toml --out DIR",
        Some(("scenario.toml", to_toml(scenario)?)),
    )?;
    Ok(page.finish()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use touchdown_campaign::vertical::landings::LandingFigures;
    use touchdown_flight::Method;
    use touchdown_sim::landing::vertical::{Landing, LandingTrace, Outcome};

    /// A method whose `landed` of four trials land at about `t_l_s`.
    fn method(method: Method, landed: u64, t_l_s: f64) -> MethodLandings {
        let landing = |trial_index: u64| {
            let down = trial_index < landed;
            let time_s: Vec<f64> = (0..=100).map(|i| 0.01 * t_l_s * f64::from(i)).collect();
            let height_m: Vec<f64> = time_s.iter().map(|t| 0.5 - 0.4 * t / t_l_s).collect();
            Landing {
                trial_index,
                outcome: if down {
                    Outcome::Landed
                } else {
                    Outcome::TimedOut
                },
                t_l_s: down.then_some(t_l_s + 0.1 * trial_index as f64),
                v_l_mps: down.then_some(0.05),
                s_l_m: 0.4,
                final_height_m: 0.1,
                hover_height_m: (!down).then_some(0.15),
                trace: (trial_index == 0).then(|| LandingTrace {
                    relative_velocity_mps: vec![-0.4 / t_l_s; time_s.len()],
                    time_s,
                    height_m,
                    ..LandingTrace::default()
                }),
            }
        };
        let landings: Vec<Landing> = (0..4).map(landing).collect();
        MethodLandings {
            method,
            figures: LandingFigures::of(&landings, touchdown_flight::touch::CRASH_MPS),
            landings,
        }
    }

    fn written(methods: &[MethodLandings]) -> (String, Vec<String>) {
        let folder = tempfile::tempdir().unwrap();
        let warnings = ["another vehicle".to_string()];
        let flown = Some("simulated vehicle: the cards'");
        land(
            methods,
            &LandScenario::default(),
            flown,
            &warnings,
            folder.path(),
        )
        .unwrap();
        let html = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
        let mut files: Vec<String> = std::fs::read_dir(folder.path().join("figures"))
            .unwrap()
            .map(|f| f.unwrap().file_name().into_string().unwrap())
            .collect();
        files.sort();
        (html, files)
    }

    #[test]
    fn prop_a_method_that_does_not_land_is_reported_and_not_in_the_cloud() {
        let (html, files) = written(&[
            method(Method::Dynamic, 4, 5.0),
            method(Method::Feedback, 1, 9.0),
        ]);
        let at = |part: &str| html.find(part).unwrap_or_else(|| panic!("{part}"));
        assert!(html.contains("</code> lands in 1 of 4 trials."));
        assert!(at("class=\"verdict warning\"") < at("<figure class=\"chart\""));
        assert!(at("<figure class=\"chart\"") < at("<h2"));
        assert!(html.len() < 1_700_000, "{}", html.len());
        // What is flown is no warning; that a card is of another vehicle is one.
        assert!(html.contains("<p>simulated vehicle: the cards"), "{html}");
        assert!(html.contains("another vehicle"));
        assert_eq!(files.len(), 6);
        assert!(files.contains(&"distribution.svg".to_string()));
        // The mean of 5.0, 5.1, 5.2 and 5.3 s, to the two decimals that are shown.
        assert!(html.contains("5.15 ±"));
    }

    #[test]
    fn prop_nothing_landed_is_a_report_too() {
        let (html, files) = written(&[method(Method::Feedback, 0, 5.0)]);
        assert!(
            html.contains("lands in 0 of 4 trials") && html.contains("class=\"verdict failure\"")
        );
        assert!(!files.contains(&"distribution.svg".to_string()));
    }

    #[test]
    fn prop_same_landings_same_bytes() {
        let methods = [method(Method::Ssc, 4, 7.0)];
        assert_eq!(written(&methods), written(&methods));
    }
}
