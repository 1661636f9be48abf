//! Figures into files: SVG and PNG hold one picture, HTML is a page that can be zoomed.

use std::path::Path;

use touchdown_report::{Figure, Report};

use crate::error::{Error, Result};
use crate::output;

/// Pixels of a PNG for each pixel of the figure.
const PNG_SCALE: f32 = 2.0;

/// The format of a file, by its ending.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub(crate) enum Format {
    Svg,
    Png,
    Html,
}

/// The format of a file that is to be drawn.
pub(crate) fn check(path: &Path) -> Result<Format> {
    let ending = path.extension().map(|e| e.to_string_lossy().to_lowercase());
    match ending.as_deref() {
        Some("svg") => Ok(Format::Svg),
        Some("png") => Ok(Format::Png),
        Some("html" | "htm") => Ok(Format::Html),
        _ => Err(Error::Arguments(format!(
            "--figure: expected a file that ends in .svg, .png or .html, found {}",
            path.display()
        ))),
    }
}

/// Writes the picture, or the page.
pub(crate) fn write(
    path: &Path,
    picture: impl FnOnce() -> Figure,
    page: impl FnOnce() -> touchdown_report::Result<Report>,
) -> Result<()> {
    match check(path)? {
        Format::Svg => {
            let svg = picture().svg().map_err(Error::Figure)?;
            output::write(path, svg.as_bytes())
        }
        Format::Png => {
            let png = picture().png(PNG_SCALE).map_err(Error::Figure)?;
            output::write(path, &png)
        }
        Format::Html => {
            let page = page().map_err(Error::Figure)?;
            output::write(path, page.html().as_bytes())
        }
    }
}
