//! Where the examples' figures go.

use std::error::Error;
use std::path::PathBuf;

use touchdown_report::Figure;

/// Writes SVG and PNG into the folder that the first argument names, `target/sindy-examples` without one.
#[allow(clippy::print_stdout)]
pub(crate) fn save(figure: &Figure) -> Result<(), Box<dyn Error>> {
    let folder = std::env::args_os()
        .nth(1)
        .map_or_else(|| PathBuf::from("target/sindy-examples"), PathBuf::from);
    std::fs::create_dir_all(&folder)?;
    let [svg, png] = figure.write(&folder)?;
    println!("{}\n{}", svg.display(), png.display());
    Ok(())
}
