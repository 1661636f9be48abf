//! What settings of identification must be.

use super::{CriterionName, IdentificationSettings, SolverName};
use crate::error::{Error, Result};

/// The searches for lags start at 2 ms; a shorter range than this leaves them nothing.
const SHORTEST_MAX_LAG_S: f64 = 0.01;

impl IdentificationSettings {
    /// Checks all settings; `file` names them in errors.
    ///
    /// # Errors
    /// The first setting out of range.
    pub fn check(&self, file: &str) -> Result<()> {
        let bad = |key: &str, expected: &str, found: String| {
            Err(Error::Settings {
                file: file.to_string(),
                message: format!("key `{key}`: expected {expected}, found {found}"),
            })
        };
        for (key, window) in [
            ("smoothing.window", self.smoothing.window),
            ("smoothing.thrust_window", self.smoothing.thrust_window),
        ] {
            if let Err(e) = sindy::SavitzkyGolay::new(window, self.smoothing.degree) {
                return Err(Error::Settings {
                    file: file.to_string(),
                    message: format!("key `{key}`: {e}"),
                });
            }
        }
        if self.sr3.thresholds.is_empty() || self.sr3.nus.is_empty() {
            return bad("sr3", "at least one threshold and one nu", "none".into());
        }
        if let Some(v) = self
            .sr3
            .thresholds
            .iter()
            .find(|v| !(**v >= 0.0 && v.is_finite()))
        {
            return bad(
                "sr3.thresholds",
                "finite numbers, at least 0",
                v.to_string(),
            );
        }
        if let Some(v) = self.sr3.nus.iter().find(|v| !(**v > 0.0 && v.is_finite())) {
            return bad("sr3.nus", "finite numbers above 0", v.to_string());
        }
        for (key, v) in [
            ("sr3.lambda", self.sr3.lambda),
            ("published.threshold", Some(self.published.threshold)),
        ] {
            if let Some(v) = v.filter(|v| !(*v >= 0.0 && v.is_finite())) {
                return bad(key, "a finite number, at least 0", v.to_string());
            }
        }
        for (key, v) in [
            ("sr3.nu", self.sr3.nu),
            ("published.nu", Some(self.published.nu)),
            ("choice.effective_rows", self.choice.effective_rows),
        ] {
            if let Some(v) = v.filter(|v| !(*v > 0.0 && v.is_finite())) {
                return bad(key, "a finite number above 0", v.to_string());
            }
        }
        let choice = &self.choice;
        if choice.folds == 1 {
            return bad("choice.folds", "0, or at least 2", "1".into());
        }
        if choice.solver == SolverName::Stepwise && choice.criterion == CriterionName::LeftOut {
            let expected = "aic, aicc, bic or evidence for the solver `stepwise`";
            return bad("choice.criterion", expected, "left_out".into());
        }
        // TOML has 64-bit signed numbers.
        for (key, seed) in [
            ("choice.seed", choice.seed),
            ("flight.seed", self.flight.seed),
        ] {
            if i64::try_from(seed).is_err() {
                return bad(key, &format!("at most {}", i64::MAX), seed.to_string());
            }
        }
        if let Err(e) = self.weak.build() {
            return Err(Error::Settings {
                file: file.to_string(),
                message: format!("key `weak`: {e}"),
            });
        }
        if let Some((key, expected, found)) = self.flight.fault() {
            return bad(key, expected, found);
        }
        let t = &self.thrust;
        if !(1..=6).contains(&t.degree) {
            return bad("thrust.degree", "1 to 6", t.degree.to_string());
        }
        let g = &self.ground_effect;
        let positive = [
            ("shooting.window_s", self.shooting.window_s),
            ("shooting.stride_s", self.shooting.stride_s),
            ("shooting.noise_n", self.shooting.noise_n),
            ("thrust.max_lag_s", t.max_lag_s),
            ("ground_effect.rotor_radius_m", g.rotor_radius_m),
            ("ground_effect.lengths_m[0]", g.lengths_m[0]),
            ("ground_effect.lengths_m[1]", g.lengths_m[1]),
            ("ground_effect.lengths_m[2]", g.lengths_m[2]),
            ("ground_effect.lag_bounds_s[0]", g.lag_bounds_s[0]),
        ];
        for (key, v) in positive {
            if !(v > 0.0 && v.is_finite()) {
                return bad(key, "a finite number above 0", v.to_string());
            }
        }
        if t.max_lag_s < SHORTEST_MAX_LAG_S {
            let expected = format!("at least {SHORTEST_MAX_LAG_S} s");
            return bad("thrust.max_lag_s", &expected, t.max_lag_s.to_string());
        }
        for (key, v) in [
            ("thrust.settle_s", t.settle_s),
            ("thrust.min_thrust_n", t.min_thrust_n),
        ] {
            if !(v >= 0.0 && v.is_finite()) {
                return bad(key, "a finite number, at least 0", v.to_string());
            }
        }
        if self.shooting.every == 0 {
            return bad("shooting.every", "at least 1", "0".into());
        }
        for (key, [lo, hi]) in [
            ("ground_effect.lag_bounds_s", g.lag_bounds_s),
            ("ground_effect.ratio_limits", g.ratio_limits),
        ] {
            if !(lo < hi && lo.is_finite() && hi.is_finite()) {
                return bad(key, "[min, max] with min < max", format!("[{lo}, {hi}]"));
            }
        }
        let libraries: [(&str, &Vec<String>, &[&str]); 2] = [
            ("thrust.library", &t.library, &["x", "s"]),
            (
                "ground_effect.library",
                &g.library,
                &["f", "s", "z", "v_p", "v_q"],
            ),
        ];
        for (key, library, names) in libraries {
            let library = match sindy::Library::parse(library) {
                Ok(library) => library,
                Err(e) => return bad(key, "distinct expressions", e.to_string()),
            };
            if let Some(unknown) = library
                .variables()
                .iter()
                .find(|v| !names.contains(&v.as_str()))
            {
                return bad(
                    key,
                    &format!("terms in {}", names.join(", ")),
                    format!("`{unknown}`"),
                );
            }
        }
        Ok(())
    }
}
