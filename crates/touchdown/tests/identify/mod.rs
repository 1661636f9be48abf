//! `touchdown identify` as a command, on measured and on generated logs.

mod generated;
mod measured;
mod refusals;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

const LOG10: &str = "flight-crazyflie-1khz-throttle/log10.csv";

fn words(args: &[&str], paths: &[&Path]) -> Vec<OsString> {
    let args = args.iter().map(OsString::from);
    args.chain(paths.iter().map(OsString::from)).collect()
}

/// Settings in which the lag takes the dead time in, as in the reference values.
fn without_dead_time(folder: &Path) -> PathBuf {
    let path = folder.join("none.toml");
    std::fs::write(&path, "[thrust]\ndead_time = \"none\"\n").unwrap();
    path
}
