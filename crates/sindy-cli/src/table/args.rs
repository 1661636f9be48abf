//! The arguments that say how tables are read.

use clap::Args;

/// How tables are read.
#[derive(Args, Debug)]
pub(crate) struct TableArgs {
    /// Column of times [default: the column `t`, `time` or `time_s`, else `t_s`, `timestamp` or `timestamp_s`]
    #[arg(long, value_name = "COLUMN", value_parser = name)]
    pub(crate) time: Option<String>,
    /// Time from row to row, for tables without a column of times
    #[arg(long, value_name = "STEP", conflicts_with = "time", value_parser = positive, allow_negative_numbers = true)]
    pub(crate) dt: Option<f64>,
    /// Column whose values separate trajectories; without it, each file is one trajectory
    #[arg(long, value_name = "COLUMN", value_parser = name)]
    pub(crate) trajectory: Option<String>,
    /// Names of the columns of NumPy arrays, in order
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(crate) columns: Vec<String>,
}

/// The name of a column, without spaces around it.
pub(crate) fn name(text: &str) -> Result<String, String> {
    match text.trim() {
        "" => Err("expected the name of a column, found nothing".to_owned()),
        name => Ok(name.to_owned()),
    }
}

pub(crate) fn positive(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
        _ => Err("expected a positive number".to_owned()),
    }
}
