//! Figures and one self-contained HTML report: data in, pictures out.
//!
//! Start with [`Figure`]: a title, a caption and one or more stacked [`Panel`]s, each with [`Series`].
//! It gives an SVG ([`Figure::svg`]), a PNG ([`Figure::png`]) or a Plotly description ([`Figure::plotly_json`]).
//! [`Report`] gathers text, [`Table`]s and figures into one HTML file that works offline.
//!
//! ```
//! use touchdown_report::{Figure, Panel, Report, Series};
//!
//! let t: Vec<f64> = (0..200).map(|i| 0.05 * f64::from(i)).collect();
//! let h: Vec<f64> = t.iter().map(|t| 0.3 + (-0.5 * t).exp()).collect();
//! let figure = Figure::new("approach", "Approach to the deck")
//!     .caption("Height above the deck.")
//!     .panel(Panel::new("Time (s)", "Height (m)").series(Series::line("vehicle", &t, &h)));
//! let svg = figure.svg()?;
//! assert!(svg.starts_with("<svg"));
//!
//! let mut report = Report::new("Landing");
//! report.section("Approach").paragraph("The vehicle descends.").figure(&figure)?;
//! assert!(report.html().contains("Figure 1"));
//! # Ok::<(), touchdown_report::Error>(())
//! ```
//!
//! What is promised of every picture:
//!
//! * **No fonts needed.** Letters are drawn as outlines of embedded typefaces (Inter, with symbols from DejaVu Sans).
//! * **No network.** The report carries its styles, typefaces, plotly.js and the player of landings, and forbids loading anything else
//!   through a content security policy.
//! * **Gaps stay gaps.** A sample that is not finite breaks the line; it is never joined over or drawn as zero.
//! * **Long series keep their extremes.** Above [`MAX_DRAWN_POINTS`] points a series is thinned for display: each of
//!   1000 index buckets keeps its first and last sample, its smallest and largest x and y, and its gaps.
//!   The data that you hold are never changed.
//! * **Legends stand above their panel**, never over a curve; stacked panels share one left and right edge.
//! * **Same data, same bytes.** No clock, no randomness, no environment.

mod canvas;
mod chart;
mod check;
mod color;
mod curve;
mod decimate;
mod draw;
mod error;
mod figure;
mod files;
mod font;
mod html;
mod layout;
mod pack;
mod plotly_json;
mod plotly_trace;
mod ranges;
mod raster;
mod report;
mod scale;
mod scene;
mod series;
mod shape;
mod svg;
mod table;
mod words;

pub use color::Color;
pub use decimate::MAX_DRAWN_POINTS;
pub use error::Error;
pub use figure::{Figure, Kind, Panel, Series};
pub use report::{Callout, Report};
pub use scene::Scene;
pub use table::{Align, Cell, Column, Table};
pub use words::Term;

/// What every fallible call of this crate returns.
pub type Result<T> = std::result::Result<T, Error>;
