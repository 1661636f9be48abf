//! Arguments of `touchdown fly`.

use std::net::SocketAddr;
use std::path::PathBuf;

use clap::Args;

const FLY: &str = "\
Examples:
  touchdown settings fly > flight.toml; touchdown fly flight.toml
  touchdown fly flight.toml --out flight-3.mcap
  touchdown fly flight.toml --live                live view: Foxglove, Open connection, ws://localhost:8765
  touchdown fly --replay flight-3.mcap

With --json, standard output has one object a second, each on a line, and the summary as the last one.
The recording holds every byte that came and went. --replay runs it through the same code and reports the first difference.";

#[derive(Args, Debug)]
#[command(after_help = FLY)]
pub(crate) struct FlyArgs {
    /// Settings of the flight (`touchdown settings fly` prints the defaults)
    #[arg(required_unless_present = "replay")]
    pub(crate) settings: Option<PathBuf>,
    /// Recording to write; an older file of this name is replaced
    #[arg(long, default_value = "flight.mcap", conflicts_with = "replay")]
    pub(crate) out: PathBuf,
    /// Switch the vehicle to OFFBOARD or GUIDED instead of waiting for the pilot: for simulators only
    #[arg(long, conflicts_with = "replay")]
    pub(crate) take_control: bool,
    /// Change parameters that do not fit; each is named, and written back at the end
    #[arg(long, conflicts_with = "replay")]
    pub(crate) set_parameters: bool,
    /// Live view for Foxglove: listen for its WebSocket connections. Anybody who reaches the address can watch, nobody can
    /// command
    #[arg(long, value_name = "ADDRESS:PORT", num_args = 0..=1, require_equals = true,
          default_missing_value = crate::cli::live::ADDRESS, conflicts_with = "replay")]
    pub(crate) live: Option<SocketAddr>,
    /// Run a recording again and compare what is sent, bit for bit
    #[arg(long, value_name = "FLIGHT.mcap", conflicts_with = "settings")]
    pub(crate) replay: Option<PathBuf>,
}
