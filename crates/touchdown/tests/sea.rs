//! Landings at sea: their cases, and the settings that make no sense.

use std::path::Path;

use touchdown_campaign::progress::Silent;
use touchdown_campaign::sweep;
use touchdown_flight::Method;
use touchdown_lander::settings::DescentShape;
use touchdown_reproduce::experiments::sea::{SeaCell, SeaMethod};
use touchdown_reproduce::settings::ReproduceSettings;
use touchdown_sim::deck::rigid::RigidMotion;
use touchdown_sim::landing::space::Case;

fn cells(text: &str, folder: &Path) -> Result<Vec<SeaCell>, String> {
    let mut settings: ReproduceSettings =
        touchdown::settings::parse(text, "s.toml").map_err(|e| e.to_string())?;
    settings.sea = settings.sea.from(folder);
    settings.trials = 1;
    touchdown_reproduce::experiments::sea::cells(&settings, None, "s.toml")
        .map_err(|e| e.to_string())
}

#[test]
fn prop_cases_differ_in_what_their_names_say() {
    let cells = cells("[sea.scenario]\ntimeout_s = 60.0\n", Path::new("")).unwrap();
    assert_eq!(cells.len(), 4 * 3 + 7);
    for cell in &cells {
        let scenario = &cell.sweep.settings().scenario;
        let control = &scenario.control;
        assert_eq!(scenario.timeout_s, 60.0, "what is set is set in all cases");
        assert_eq!(control.planner, cell.how != SeaMethod::StraightDown);
        let (controller, reference) = match cell.how {
            SeaMethod::Published => (Method::Dynamic, DescentShape::Exponential),
            _ => (Method::DynamicObserver, DescentShape::Terminal),
        };
        assert_eq!((control.method, control.reference), (controller, reference));
        let strength = if cell.case == Case::Strong { 1.6 } else { 1.0 };
        assert_eq!(scenario.ground_effect_strength, strength);
        assert_eq!(
            cell.case == Case::Sea,
            matches!(scenario.deck, RigidMotion::Sea(_))
        );
        // A fault is one, and nothing else than a fault.
        let mut without = scenario.clone();
        without.faults = Case::Paper.scenario().faults;
        assert_eq!(Case::FAULTS.contains(&cell.case), without != *scenario);
    }
}

#[test]
fn prop_a_measured_motion_moves_the_deck_of_the_sea_alone() {
    let folder = tempfile::tempdir().unwrap();
    let rows: String = (0..400)
        .map(|i| format!("{i},{}\n", (f64::from(i) / 1.2).sin()))
        .collect();
    std::fs::write(folder.path().join("z.csv"), format!("t,z\n{rows}")).unwrap();
    let text = "[sea.series]\nfile = \"z.csv\"\nsignificant_height_m = 0.1\n[sea.series.format]\n\
                time = [{ column = \"t\", factor = 1.0 }]\n\
                channels = [{ axis = \"heave\", column = \"z\", factor = 1.0 }]\nlongest_step_s = 2.0\n";
    let cells_of = cells(text, folder.path()).unwrap();
    for cell in &cells_of {
        assert_eq!(cell.case == Case::Sea, cell.sweep.measured().is_some());
    }
    let straight = cells_of
        .iter()
        .find(|c| c.case == Case::Sea && c.how == SeaMethod::StraightDown)
        .unwrap();
    let trace = sweep::replay(&straight.sweep, &[0]).unwrap().remove(0);
    // Scaled to 0.1 m: four standard deviations of a sine, so an amplitude of √2/4 of it.
    let amplitude = 2.0_f64.sqrt() / 4.0 * 0.1;
    let highest = trace.rows.iter().map(|r| r.deck_m[2]).fold(0.0, f64::max);
    // Six points a period and a spline between them; 1 % of a cycle is missed at most.
    assert!((highest / amplitude - 1.0).abs() < 0.02, "{highest}");
    let rows = sweep::rows(&straight.sweep, 0..1, &Silent).unwrap();
    assert!(rows[0].landed(), "{rows:?}");
    // Where the file lies makes no difference to the settings' sum.
    let sum = |file: &str| {
        let text = text.replace("z.csv", file);
        let settings: ReproduceSettings = touchdown::settings::parse(&text, "s.toml").unwrap();
        touchdown_reproduce::experiments::results::settings_sha256(&settings).unwrap()
    };
    assert_eq!(sum("a.csv"), sum("/b/c.csv"));
}

#[test]
fn prop_settings_that_make_no_sense_name_their_key() {
    let said = |text: &str| cells(text, Path::new("/no/such/folder")).unwrap_err();
    for (text, named) in [
        ("[sea]\ncolour = 1\n", vec!["colour"]),
        (
            "[sea.scenario]\ndeck = { kind = \"still\" }\n",
            vec!["sea.scenario.deck", "cases"],
        ),
        (
            "[sea.scenario]\nheight = 3.0\n",
            vec!["sea.scenario", "height"],
        ),
        (
            "[sea.scenario]\ntimeout_s = -1.0\n",
            vec!["timeout_s", "-1"],
        ),
        (
            "[sea.wave.spectrum]\npeak_period_s = 0.0\n",
            vec!["peak_period_s", "sea", "0"],
        ),
        (
            "[sea.series]\nfile = \"z.csv\"\n[sea.series.format]\ntime = []\nchannels = []\nlongest_step_s = 1.0\n",
            vec!["/no/such/folder/z.csv"],
        ),
    ] {
        let said = said(text);
        assert!(named.iter().all(|n| said.contains(n)), "{text}: {said}");
    }
}
