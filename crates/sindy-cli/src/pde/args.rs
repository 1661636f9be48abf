//! The arguments of `sindy pde`.

use std::path::PathBuf;

use clap::Args;

use crate::table::args::{name, positive};

/// Find the partial differential equations behind fields on a grid.
///
/// The derivative of each field in time is written as a sum of few candidate terms: derivatives in space of products of the
/// fields, such as `u_xx` or `(u^2)_x`, which is 2 u u_x. The weak form needs no derivative of the data; windows, terms and
/// coefficients are chosen from them, and the bias of white noise is taken away. Steps of the grid are even.
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub(crate) struct PdeArgs {
    /// Fields on a grid: NumPy arrays (.npz with an array for each axis and field, or .npy), or a table (CSV, Parquet) with a row
    /// for each point; several files are measurements of the same fields
    #[arg(required = true, value_name = "DATA")]
    pub(crate) data: Vec<PathBuf>,
    /// The fields [default: all arrays or columns that are no axis; `u` of a .npy]
    #[arg(long, value_name = "u,v", value_delimiter = ',', value_parser = name)]
    pub(crate) fields: Vec<String>,
    /// The axes in the order in which the arrays have them, that of time among them
    #[arg(long, value_name = "t,x,y", value_delimiter = ',', value_parser = name, default_value = "t,x")]
    pub(crate) axes: Vec<String>,
    /// The axis of time
    #[arg(long, value_name = "AXIS", value_parser = name, default_value = "t")]
    pub(crate) time: String,
    /// Steps of the axes, for arrays without coordinates: t=0.1,x=0.05
    #[arg(long, value_name = "AXIS=STEP", value_delimiter = ',', value_parser = step)]
    pub(crate) spacing: Vec<(String, f64)>,
    /// Highest degree of the products of fields
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u8).range(1..=8))]
    pub(crate) degree: u8,
    /// Highest order of the derivatives in space [default: 4 in one dimension of space, else 2]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u8).range(0..=8))]
    pub(crate) order: Option<u8>,
    /// Candidate term in place of all those of --degree and --order; repeatable: `1`, `u`, `u^2*v`, `u_xx`, `(u^2)_x`
    #[arg(long, value_name = "TERM", conflicts_with_all = ["degree", "order"])]
    pub(crate) term: Vec<String>,
    /// Order of the derivative in time on the left side: 2 for waves
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u8).range(1..=2))]
    pub(crate) time_order: u8,
    /// Half-widths of the windows by axis, in its unit [default: from the data]
    #[arg(long, value_name = "AXIS=WIDTH", value_delimiter = ',', value_parser = step)]
    pub(crate) half_width: Vec<(String, f64)>,
    /// Figure of terms against error (.svg, .png or .html)
    #[arg(long, value_name = "OUT")]
    pub(crate) figure: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  sindy pde burgers.npz
  sindy pde patterns.npz --axes t,y,x --fields u,v --json
  sindy pde wave.npy --spacing t=0.01,x=0.1 --time-order 2
  sindy pde film.parquet --axes time,x --time time --fields h --order 4
  sindy pde flame.npz --term u_x --term u_xx --term '(u^2)_x' --figure front.html";

/// `name=number` with a positive number.
fn step(text: &str) -> Result<(String, f64), String> {
    let parts = text.split_once('=');
    let parts = parts.ok_or_else(|| "expected axis=number, such as x=0.05".to_owned())?;
    Ok((name(parts.0)?, positive(parts.1)?))
}
