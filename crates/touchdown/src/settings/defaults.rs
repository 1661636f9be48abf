//! The default settings as commented TOML: what `touchdown settings` prints. Tests hold them equal to the
//! defaults in code, key by key.

/// Settings of `reproduce`.
pub const REPRODUCE: &str = include_str!("../../settings/reproduce.toml");
/// A rig scenario.
pub const RIG: &str = include_str!("../../settings/rig.toml");
/// A landing scenario.
pub const LAND: &str = include_str!("../../settings/land.toml");
/// Settings of identification.
pub const IDENTIFY: &str = include_str!("../../settings/identify.toml");

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
    let mut text =
        format!("{CAMPAIGN}\n# Every setting of a landing, with its default (SI units):\n");
    for line in defaults.lines() {
        text.push_str(if line.is_empty() { "#" } else { "# " });
        text.push_str(line);
        text.push('\n');
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use serde::Serialize;
    use serde::de::DeserializeOwned;

    use touchdown_campaign::vertical::scenario::LandScenario;
    use touchdown_identify::IdentificationSettings;

    use crate::settings::ReproduceSettings;
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
        assert_eq!(variants.len(), 6, "{variants:#?}");
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
