//! The truth of a landing, as a Parquet file.

use std::path::Path;

use touchdown::{Error, Result};
use touchdown_log::{ParquetValues, to_parquet};
use touchdown_sim::landing::space::VehicleTruth;

use crate::cli::output;

/// Columns, each with one value of a row.
type Row = Vec<(&'static str, f64)>;

/// The rows of a landing.
#[derive(Default)]
pub(crate) struct TruthTable {
    columns: Vec<(&'static str, Vec<f64>)>,
}

fn row(truth: &VehicleTruth) -> Row {
    let state = &truth.state;
    let mut row = vec![("time_s", truth.time_s)];
    let mut add = |names: [&'static str; 3], values: [f64; 3]| {
        row.extend(names.into_iter().zip(values));
    };
    add(["x_m", "y_m", "z_m"], state.position_m);
    add(["x_mps", "y_mps", "z_mps"], state.velocity_mps);
    add(["x_mps2", "y_mps2", "z_mps2"], truth.acceleration_mps2);
    add(
        ["roll_rate_radps", "pitch_rate_radps", "yaw_rate_radps"],
        state.rates,
    );
    add(["deck_x_m", "deck_y_m", "deck_z_m"], truth.deck.origin_m);
    add(
        ["deck_x_mps", "deck_y_mps", "deck_z_mps"],
        truth.deck.velocity_mps,
    );
    add(
        ["deck_x_mps2", "deck_y_mps2", "deck_z_mps2"],
        truth.deck.acceleration_mps2,
    );
    add(
        ["relative_x_m", "relative_y_m", "relative_z_m"],
        truth.relative_m,
    );
    add(
        ["relative_x_mps", "relative_y_mps", "relative_z_mps"],
        truth.relative_mps,
    );
    add(["wind_x_mps", "wind_y_mps", "wind_z_mps"], truth.wind_mps);
    let mut add = |names: [&'static str; 4], values: [f64; 4]| {
        row.extend(names.into_iter().zip(values));
    };
    add(
        ["attitude_w", "attitude_x", "attitude_y", "attitude_z"],
        state.attitude,
    );
    add(
        ["rotor_0_n", "rotor_1_n", "rotor_2_n", "rotor_3_n"],
        truth.rotor_n,
    );
    add(
        ["motor_0", "motor_1", "motor_2", "motor_3"],
        truth.signals.0,
    );
    add(
        ["foot_0_n", "foot_1_n", "foot_2_n", "foot_3_n"],
        truth.feet_n,
    );
    row.push(("ground_effect_n", truth.ground_effect_n));
    row
}

impl TruthTable {
    /// Adds a row.
    pub(super) fn push(&mut self, truth: &VehicleTruth) {
        let row = row(truth);
        if self.columns.is_empty() {
            self.columns = row.iter().map(|(name, _)| (*name, Vec::new())).collect();
        }
        for ((_, column), (_, value)) in self.columns.iter_mut().zip(row) {
            column.push(value);
        }
    }

    /// Writes the file.
    pub(crate) fn write(self, path: &Path) -> Result<()> {
        let columns: Vec<_> = self
            .columns
            .into_iter()
            .map(|(name, values)| (name.to_string(), ParquetValues::Numbers(values)))
            .collect();
        let program = concat!("touchdown ", env!("CARGO_PKG_VERSION"));
        let bytes =
            to_parquet("truth", program, &[], &columns).map_err(|e| Error::file(path, e))?;
        Ok(output::write(path, &bytes)?)
    }
}
