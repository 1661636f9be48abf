//! Which landings of a sweep a learned policy flies: those whose `control.controller` is `"policy"`.

use std::path::{Path, PathBuf};

use toml::Value;

use super::axes::{Axes, KeyError};
use super::draw::Distribution;
use super::settings::SweepSettings;
use crate::error::Result;
use crate::policy::{POLICY, POLICY_FILE, PolicyFile};

/// The key of controllers.
pub(super) const CONTROLLER: &str = "control.controller";

/// Whether a value of a key says that a policy flies.
pub(super) fn names_policy(key: &str, value: &Value) -> bool {
    key == CONTROLLER && value.as_str() == Some(POLICY)
}

/// Whether one of these values says so.
pub(super) fn is_policy(values: &[(&str, &Value)]) -> bool {
    values.iter().any(|(key, value)| names_policy(key, value))
}

impl SweepSettings {
    /// Lets these controllers fly, and a policy beside them. Without any, the sweep's own fly, or else the scenario's. Where the
    /// sweep draws its controllers, a policy takes the place of its policy there.
    pub fn set_controllers(&mut self, controllers: Vec<String>, policy: Option<PathBuf>) {
        let mut values: Vec<Value> = controllers.into_iter().map(Value::from).collect();
        if policy.is_none() && !values.is_empty() {
            let named = values.iter().any(|value| names_policy(CONTROLLER, value));
            self.policy = self.policy.take().filter(|_| named);
        }
        if let Some(policy) = policy {
            self.policy = Some(policy);
            if values.is_empty() && self.random.contains_key(CONTROLLER) {
                return;
            }
            if values.is_empty() {
                values = match self.grid.get(CONTROLLER) {
                    Some(Value::Array(own)) => own.clone(),
                    _ => vec![self.scenario.control.method.name().into()],
                };
            }
            if !values.iter().any(|value| names_policy(CONTROLLER, value)) {
                values.push(POLICY.into());
            }
        }
        if !values.is_empty() {
            self.grid.insert(CONTROLLER.to_owned(), values.into());
        }
    }
}

/// Reads the policy of a sweep, and names its file as it is named in the folder of a campaign.
///
/// # Errors
/// A policy that cannot be read, that no value of `control.controller` names, or that is named and not there.
pub(super) fn policy_of(
    settings: &mut SweepSettings,
    folder: &Path,
    axes: &Axes,
    bad: &KeyError<'_>,
) -> Result<Option<PolicyFile>> {
    let swept = axes.grid.iter().map(|(key, values)| (key, values));
    let drawn = axes.random.iter().filter_map(|(key, of)| match of {
        Distribution::Choice { of } => Some((key, of)),
        _ => None,
    });
    let is_named = swept
        .chain(drawn)
        .any(|(key, values)| values.iter().any(|value| names_policy(key, value)));
    match &mut settings.policy {
        None if is_named => Err(bad(
            "policy",
            &format!("expected the file of the policy that `{CONTROLLER}` names, found none"),
        )),
        None => Ok(None),
        Some(_) if settings.autopilot.is_some() => Err(bad(
            "policy",
            "expected none beside `autopilot`, found one: policies fly in the simulation only",
        )),
        Some(_) if !is_named => Err(bad(
            "policy",
            &format!(
                "expected \"{POLICY}\" among the values of `{CONTROLLER}` in [grid] or [random], found none"
            ),
        )),
        Some(given) if given.as_os_str().is_empty() => Err(bad(
            "policy",
            "expected the name of a file, found an empty one",
        )),
        Some(given) => {
            let read = PolicyFile::read(&folder.join(&*given))?;
            *given = POLICY_FILE.into();
            Ok(Some(read))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Silent;
    use crate::sweep::{Sweep, pack, rows, summarise, unpack};

    const SWEEP: &str = "trials = 3\npolicy = \"own.json\"\n[scenario]\ntimeout_s = 20.0\n";
    const BOTH: &str = "[grid]\n\"control.controller\" = [\"policy\", \"observer\"]\n";

    /// Descends at a rate less what the ground effect lifts; `bias` is the sink rate in m/s, times -2.
    fn policy(bias: f64) -> String {
        let mut weights = [[0.0; 19]; 3];
        weights[0][5] = -2.0;
        (weights[1][1], weights[1][4]) = (0.8, 1.0);
        (weights[2][0], weights[2][3]) = (-0.8, -1.0);
        let [offset, scale] = [[0.0; 19], [1.0; 19]];
        format!(
            "{{\"schema\": 1, \"decision_s\": 0.02, \"action\": {{}}, \
             \"input\": {{\"offset\": {offset:?}, \"scale\": {scale:?}}}, \
             \"layers\": [{{\"weights\": {weights:?}, \"bias\": [{bias:?}, 0.0, 0.0], \"activation\": \"linear\"}}]}}"
        )
    }

    fn sweep(text: &str, policy: &str) -> Result<Sweep> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("own.json"), policy).unwrap();
        let settings = SweepSettings::parse(text, "sweep.toml")?;
        Sweep::new(settings, folder.path(), "sweep.toml".to_owned())
    }

    #[test]
    fn prop_a_policy_flies_where_it_is_named_and_goes_with_its_sweep() {
        let own = sweep(&format!("{SWEEP}{BOTH}"), &policy(-0.5)).unwrap();
        let flown = rows(&own, 0..own.landings(), &Silent).unwrap();
        let results = summarise(&own, &flown).unwrap();
        let names: Vec<&str> = results
            .points
            .iter()
            .map(|p| p.of.controller.as_str())
            .collect();
        assert_eq!(names, ["policy", "observer"]);
        // The scenario's controller stands by, and the other point is what it is without any policy.
        let text = SWEEP.replace("policy = \"own.json\"\n", "");
        let without = format!("{text}[grid]\n\"control.controller\" = [\"observer\"]\n");
        let without = sweep(&without, "").unwrap();
        let alone = rows(&without, 0..3, &Silent).unwrap();
        for (beside, alone) in flown[3..].iter().zip(&alone) {
            assert_eq!(
                (&beside.outcome, &beside.numbers),
                (&alone.outcome, &alone.numbers)
            );
            assert_ne!(beside.numbers, flown[(beside.landing - 3) as usize].numbers);
        }
        // Another process flies the same.
        let (again, _) = unpack(pack(&own, &[]).unwrap(), 0, 0).unwrap();
        assert_eq!(again.sha256(), own.sha256());
        assert_eq!(rows(&again, 0..3, &Silent).unwrap(), flown[..3]);
        let other = sweep(&format!("{SWEEP}{BOTH}"), &policy(-0.4)).unwrap();
        assert_ne!(other.sha256(), own.sha256());
        assert_ne!(rows(&other, 0..1, &Silent).unwrap(), flown[..1]);
        // Drawn, it flies some of the trials.
        let drawn = "[random]\n\"control.controller\" = { kind = \"choice\", of = [\"policy\", \"observer\"] }\n";
        let drawn = sweep(
            &format!("{SWEEP}{drawn}").replace("trials = 3", "trials = 12"),
            &policy(-0.5),
        );
        let drawn = rows(&drawn.unwrap(), 0..3, &Silent).unwrap();
        let known = |row: &crate::sweep::LandingRow| {
            let of = flown.iter().map(|row| &row.numbers);
            of.filter(|numbers| **numbers == row.numbers).count()
        };
        assert!(drawn.iter().all(|row| known(row) == 1), "{drawn:?}");
    }

    #[test]
    fn prop_a_policy_that_does_not_fit_its_sweep_is_refused() {
        let autopilot = "autopilot = \"px4\"\n";
        let in_the_loop = format!("[software_in_the_loop]\nprogram = \"px4\"\n{BOTH}");
        let late = policy(-0.5).replace("0.02", "0.025");
        for (text, policy, said) in [
            (
                SWEEP.to_owned(),
                policy(-0.5),
                vec!["`policy`", "\"policy\"", "control.controller"],
            ),
            (
                format!("{}{BOTH}", SWEEP.replace("policy = \"own.json\"\n", "")),
                policy(-0.5),
                vec!["`policy`", "expected the file", "found none"],
            ),
            (
                format!("{autopilot}{SWEEP}{in_the_loop}"),
                policy(-0.5),
                vec!["`policy`", "autopilot"],
            ),
            (
                format!("{SWEEP}{BOTH}"),
                late,
                vec!["policy.decision_s", "0.01 s", "0.025"],
            ),
            (
                format!("{}{BOTH}", SWEEP.replace("own.json", "")),
                policy(-0.5),
                vec!["`policy`", "an empty one"],
            ),
            (
                format!("{}{BOTH}", SWEEP.replace("own", "absent")),
                policy(-0.5),
                vec!["absent.json", "No such file"],
            ),
        ] {
            let error = sweep(&text, &policy).map(|_| ()).unwrap_err().to_string();
            for word in said {
                assert!(error.contains(word), "{word}: {error}");
            }
        }
    }

    #[test]
    fn prop_a_policy_flies_beside_the_controllers_that_are_asked_for() {
        let set = |text: &str, controllers: &[&str], policy: Option<&str>| {
            let mut settings = SweepSettings::parse(text, "sweep").unwrap();
            let names = controllers.iter().map(|name| (*name).to_owned());
            settings.set_controllers(names.collect(), policy.map(PathBuf::from));
            settings.grid.get(CONTROLLER).map(ToString::to_string)
        };
        let file = Some("a.json");
        assert_eq!(set("", &[], None), None);
        let beside = |name: &str| Some(format!("[\"{name}\", \"policy\"]"));
        assert_eq!(set("", &[], file), beside("dynamic+observer"));
        assert_eq!(set("", &["observer"], file), beside("observer"));
        let own = "[grid]\n\"control.controller\" = [\"feedback\"]\n";
        assert_eq!(set(own, &[], file), beside("feedback"));
        assert_eq!(set(own, &["policy"], file), Some("[\"policy\"]".to_owned()));
        // Controllers in the place of a sweep's own leave a policy that none of them is.
        let mut settings = SweepSettings::parse(&format!("{SWEEP}{BOTH}"), "sweep").unwrap();
        settings.set_controllers(vec!["observer".to_owned()], None);
        assert_eq!(settings.policy, None);
        // Where controllers are drawn, the file is another.
        let drawn = "[random]\n\"control.controller\" = { kind = \"choice\", of = [\"policy\", \"observer\"] }\n";
        assert_eq!(set(drawn, &[], file), None);
    }
}
