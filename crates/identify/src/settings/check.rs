//! What settings of identification must be.

use super::{CriterionName, IdentificationSettings, SolverName};
use crate::error::{Error, Result};

/// The searches for lags start at 2 ms; a shorter range than this leaves them nothing.
const SHORTEST_MAX_LAG_S: f64 = 0.01;

/// A key, what it must be, and what was found.
type Fault = (&'static str, String, String);

/// Refuses a value that is not what is expected of a key.
fn expect(
    holds: bool,
    key: &'static str,
    expected: impl Into<String>,
    found: &(impl ToString + ?Sized),
) -> std::result::Result<(), Fault> {
    if holds {
        Ok(())
    } else {
        Err((key, expected.into(), found.to_string()))
    }
}

fn above_0(key: &'static str, v: f64) -> std::result::Result<(), Fault> {
    expect(v > 0.0 && v.is_finite(), key, "a finite number above 0", &v)
}

fn at_least_0(key: &'static str, v: f64) -> std::result::Result<(), Fault> {
    let expected = "a finite number, at least 0";
    expect(v >= 0.0 && v.is_finite(), key, expected, &v)
}

impl IdentificationSettings {
    /// Checks all settings; `file` names them in errors.
    ///
    /// # Errors
    /// The first setting out of range.
    pub fn check(&self, file: &str) -> Result<()> {
        let bad = |message: String| Error::Settings {
            file: file.to_string(),
            message,
        };
        for (key, window) in [
            ("smoothing.window", self.smoothing.window),
            ("smoothing.thrust_window", self.smoothing.thrust_window),
        ] {
            sindy::SavitzkyGolay::new(window, self.smoothing.degree)
                .map_err(|e| bad(format!("key `{key}`: {e}")))?;
        }
        self.weak
            .build()
            .map_err(|e| bad(format!("key `weak`: {e}")))?;
        self.check_solver()
            .and_then(|()| self.check_models())
            .and_then(|()| self.check_libraries())
            .map_err(|(key, expected, found)| {
                bad(format!("key `{key}`: expected {expected}, found {found}"))
            })
    }

    /// Solver, choice and seeds.
    fn check_solver(&self) -> std::result::Result<(), Fault> {
        let (sr3, choice) = (&self.sr3, &self.choice);
        let some = !sr3.thresholds.is_empty() && !sr3.nus.is_empty();
        expect(some, "sr3", "at least one threshold and one nu", "none")?;
        if let Some(v) = sr3
            .thresholds
            .iter()
            .find(|v| !(**v >= 0.0 && v.is_finite()))
        {
            let expected = "finite numbers, at least 0";
            return expect(false, "sr3.thresholds", expected, v);
        }
        if let Some(v) = sr3.nus.iter().find(|v| !(**v > 0.0 && v.is_finite())) {
            return expect(false, "sr3.nus", "finite numbers above 0", v);
        }
        at_least_0("sr3.lambda", sr3.lambda.unwrap_or(0.0))?;
        at_least_0("published.threshold", self.published.threshold)?;
        above_0("sr3.nu", sr3.nu.unwrap_or(1.0))?;
        above_0("published.nu", self.published.nu)?;
        above_0(
            "choice.effective_rows",
            choice.effective_rows.unwrap_or(1.0),
        )?;
        expect(choice.folds != 1, "choice.folds", "0, or at least 2", &1)?;
        expect(
            choice.solver != SolverName::Stepwise || choice.criterion != CriterionName::LeftOut,
            "choice.criterion",
            "aic, aicc, bic or evidence for the solver `stepwise`",
            "left_out",
        )?;
        // TOML has 64-bit signed numbers.
        for (key, seed) in [
            ("choice.seed", choice.seed),
            ("flight.seed", self.flight.seed),
        ] {
            let fits = i64::try_from(seed).is_ok();
            expect(fits, key, format!("at most {}", i64::MAX), &seed)?;
        }
        Ok(())
    }

    /// Models of stands, rigs and flights.
    fn check_models(&self) -> std::result::Result<(), Fault> {
        if let Some((key, expected, found)) = self.flight.fault().or(self.vehicle.fault()) {
            return Err((key, expected.to_string(), found));
        }
        for (key, of_vehicle, of_flight) in [
            ("vehicle.mass_kg", self.vehicle.mass_kg, self.flight.mass_kg),
            (
                "vehicle.rotor_radius_m",
                self.vehicle.rotor_radius_m,
                self.flight.rotor_radius_m,
            ),
        ] {
            if let (Some(a), Some(b)) = (of_vehicle, of_flight) {
                expect(a == b, key, format!("the value of [flight], {b}"), &a)?;
            }
        }
        let (t, g, shooting) = (&self.thrust, &self.ground_effect, &self.shooting);
        expect(
            (1..=6).contains(&t.degree),
            "thrust.degree",
            "1 to 6",
            &t.degree,
        )?;
        let lengths_m = g.lengths_m();
        for (key, v) in [
            ("shooting.window_s", shooting.window_s),
            ("shooting.stride_s", shooting.stride_s),
            ("shooting.noise_n", shooting.noise_n.unwrap_or(1.0)),
            ("thrust.max_lag_s", t.max_lag_s),
            ("ground_effect.rotor_radius_m", g.rotor_radius_m),
            ("ground_effect.lengths_m[0]", lengths_m[0]),
            ("ground_effect.lengths_m[1]", lengths_m[1]),
            ("ground_effect.lengths_m[2]", lengths_m[2]),
            ("ground_effect.lag_bounds_s[0]", g.lag_bounds_s[0]),
        ] {
            above_0(key, v)?;
        }
        let expected = format!("at least {SHORTEST_MAX_LAG_S} s");
        let long = t.max_lag_s >= SHORTEST_MAX_LAG_S;
        expect(long, "thrust.max_lag_s", expected, &t.max_lag_s)?;
        at_least_0("thrust.settle_s", t.settle_s)?;
        at_least_0("thrust.min_thrust_n", t.min_thrust_n.unwrap_or(0.0))?;
        expect(shooting.every > 0, "shooting.every", "at least 1", &0)?;
        for (key, [lo, hi]) in [
            ("ground_effect.lag_bounds_s", g.lag_bounds_s),
            ("ground_effect.ratio_limits", g.ratio_limits),
        ] {
            let ordered = lo < hi && lo.is_finite() && hi.is_finite();
            let found = format!("[{lo}, {hi}]");
            expect(ordered, key, "[min, max] with min < max", &found)?;
        }
        Ok(())
    }

    /// Candidate terms.
    fn check_libraries(&self) -> std::result::Result<(), Fault> {
        let libraries: [(&str, &Vec<String>, &[&str]); 2] = [
            ("thrust.library", &self.thrust.library, &["x", "s"]),
            (
                "ground_effect.library",
                &self.ground_effect.library,
                &["f", "s", "z", "v_p", "v_q"],
            ),
        ];
        for (key, library, names) in libraries {
            let library = sindy::Library::parse(library)
                .map_err(|e| (key, "distinct expressions".to_string(), e.to_string()))?;
            let variables = library.variables();
            if let Some(unknown) = variables.iter().find(|v| !names.contains(&v.as_str())) {
                let expected = format!("terms in {}", names.join(", "));
                return expect(false, key, expected, &format!("`{unknown}`"));
            }
        }
        Ok(())
    }
}
