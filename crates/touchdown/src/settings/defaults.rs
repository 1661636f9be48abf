//! The default settings as commented TOML: what `touchdown settings` prints. Tests hold them equal to the
//! defaults in code, key by key.

use touchdown_lander::models::FlightModels;
use touchdown_lander::settings::ControlSettings;

/// Settings of `reproduce`.
pub const REPRODUCE: &str = include_str!("../../settings/reproduce.toml");
/// A rig scenario.
pub const RIG: &str = include_str!("../../settings/rig.toml");
/// A landing scenario.
pub const LAND: &str = include_str!("../../settings/land.toml");
/// Settings of identification.
pub const IDENTIFY: &str = include_str!("../../settings/identify.toml");

/// A flight beside an autopilot, without the settings of the landing computer.
pub const FLY: &str = include_str!("../../settings/fly.toml");

/// A sweep to start from.
pub const CAMPAIGN: &str = include_str!("../../settings/campaign.toml");

/// A sweep to start from, and beneath it every setting of a landing in space with its default, as comments.
///
/// # Errors
/// None that a test would not have found.
pub fn campaign() -> crate::Result<String> {
    #[derive(serde::Serialize)]
    struct Defaults {
        scenario: touchdown_sim::landing::space::SpaceScenario,
    }
    let defaults = super::to_toml(&Defaults {
        scenario: touchdown_sim::landing::space::SpaceScenario::default(),
    })?;
    let title = "Every setting of a landing";
    let replaced_by = |key: &str| {
        let key = key.strip_prefix("scenario.")?;
        touchdown_sim::landing::space::replaced_by(key)
    };
    let defaults = as_comments(title, &defaults, replaced_by);
    Ok(format!("{CAMPAIGN}{defaults}"))
}

/// A flight beside an autopilot, and beneath it every setting of the landing computer with its default, as comments.
///
/// # Errors
/// None that a test would not have found.
pub fn fly() -> crate::Result<String> {
    #[derive(serde::Serialize)]
    struct Defaults {
        control: ControlSettings<f64>,
        models: FlightModels<f64>,
    }
    let defaults = super::to_toml(&Defaults {
        control: ControlSettings::default(),
        models: FlightModels::default(),
    })?;
    let title = "Every setting of the landing computer, and the models";
    let defaults = as_comments(title, &defaults, touchdown_link::settings::replaced_by);
    Ok(format!("{FLY}{defaults}"))
}

/// Lines of TOML as comments. Settings that others replace name them.
fn as_comments(
    title: &str,
    defaults: &str,
    replaced_by: impl Fn(&str) -> Option<&'static str>,
) -> String {
    let mut text = format!("\n# {title}, with its default (SI units):\n");
    let mut section = "";
    for line in defaults.lines() {
        if let Some(name) = line.strip_prefix('[') {
            section = name.trim_end_matches(']');
        }
        text.push_str(if line.is_empty() { "#" } else { "# " });
        text.push_str(line);
        let key = line.split_once(" = ").map_or("", |(key, _)| key);
        if let Some(by) = replaced_by(&format!("{section}.{key}")) {
            text.push_str(&format!("  # replaced by {by}"));
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use serde::Serialize;
    use serde::de::DeserializeOwned;

    use touchdown_campaign::vertical::scenario::LandScenario;
    use touchdown_identify::IdentificationSettings;

    use touchdown_reproduce::settings::ReproduceSettings;

    use crate::settings::rig::RigScenario;

    fn keys(table: &toml::Table, above: &str, out: &mut Vec<String>) {
        for (key, value) in table {
            let path = format!("{above}{key}");
            match value {
                toml::Value::Table(t) => keys(t, &format!("{path}."), out),
                _ => out.push(path),
            }
        }
    }

    fn same<T: Default + DeserializeOwned + Serialize + PartialEq + std::fmt::Debug>(text: &str) {
        assert_eq!(toml::from_str::<T>(text).unwrap(), T::default());
        let (mut printed, mut real) = (Vec::new(), Vec::new());
        keys(&toml::from_str(text).unwrap(), "", &mut printed);
        keys(
            &toml::from_str(&toml::to_string(&T::default()).unwrap()).unwrap(),
            "",
            &mut real,
        );
        assert_eq!(printed.iter().filter(|k| !real.contains(k)).count(), 0);
        let missing: Vec<_> = real.iter().filter(|k| !printed.contains(k)).collect();
        assert!(
            missing.is_empty(),
            "not in the printed settings: {missing:?}"
        );
        let bare = |l: &&str| l.contains('=') && !l.contains('#') && !l.trim().starts_with('[');
        let uncommented: Vec<&str> = text.lines().filter(bare).collect();
        assert!(uncommented.is_empty(), "without a comment: {uncommented:?}");
    }

    #[test]
    fn prop_printed_settings_are_the_defaults_and_every_key_is_commented() {
        same::<ReproduceSettings>(super::REPRODUCE);
        same::<RigScenario>(super::RIG);
        same::<LandScenario>(super::LAND);
        same::<IdentificationSettings>(super::IDENTIFY);
    }

    #[test]
    fn prop_printed_settings_of_a_flight_are_the_defaults_with_and_without_comments() {
        use touchdown_link::settings::FlightSettings;
        let (own, all) = (super::FLY, super::fly().unwrap());
        assert_eq!(
            toml::from_str::<FlightSettings>(own).unwrap(),
            FlightSettings::default()
        );
        let hidden = all.strip_prefix(own).unwrap();
        let hidden = hidden.split_once("units):\n").unwrap().1;
        let bare: String = hidden
            .lines()
            .map(|l| format!("{}\n", l.strip_prefix("# ").unwrap_or("")))
            .collect();
        let whole = format!("{own}\n{bare}");
        assert_eq!(
            toml::from_str::<FlightSettings>(&whole).unwrap(),
            FlightSettings::default()
        );
        let (mut printed, mut real) = (Vec::new(), Vec::new());
        keys(&toml::from_str(&whole).unwrap(), "", &mut printed);
        let defaults = toml::to_string(&FlightSettings::default()).unwrap();
        keys(&toml::from_str(&defaults).unwrap(), "", &mut real);
        printed.sort();
        real.sort();
        assert_eq!(printed, real);
        let bare = |l: &&str| l.contains('=') && !l.contains('#') && !l.trim().starts_with('[');
        assert_eq!(
            own.lines().filter(bare).count(),
            0,
            "keys without a comment"
        );
    }

    /// The tables of `[scenario]` that stand in the sweep as comments, each on its own.
    fn variants() -> Vec<String> {
        let lines = super::CAMPAIGN.lines().filter_map(|l| l.strip_prefix("# "));
        let mut out: Vec<String> = Vec::new();
        for line in lines {
            if line.starts_with("[scenario.") {
                // A second table of the same motion belongs to it.
                match out.last_mut() {
                    Some(last) if line.starts_with("[scenario.deck.") => last.push_str(line),
                    _ => out.push(line.to_string()),
                }
            } else if let Some(last) = out.last_mut().filter(|_| !line.starts_with('#')) {
                last.push('\n');
                last.push_str(line);
            }
            if let Some(last) = out.last_mut() {
                last.push('\n');
            }
        }
        out
    }

    #[test]
    fn prop_variants_in_the_comments_of_a_sweep_can_be_flown() {
        let variants = variants();
        assert_eq!(variants.len(), 10, "{variants:#?}");
        for text in variants {
            let settings = crate::settings::parse(&format!("trials = 1\n{text}"), "variant.toml")
                .unwrap_or_else(|e| panic!("{text}\n{e}"));
            touchdown_campaign::sweep::Sweep::new(
                settings,
                std::path::Path::new("."),
                "variant.toml".into(),
            )
            .unwrap_or_else(|e| panic!("{text}\n{e}"));
        }
    }
}
