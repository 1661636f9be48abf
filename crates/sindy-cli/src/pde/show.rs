//! The equations of fields as text for people.

use std::fmt::Write as _;

use super::object::PdeObject;
use crate::fit::show::{coefficients, front, wrapped};
use crate::numbers::significant;

/// Equations, coefficients with intervals, fronts, windows and data.
pub(super) fn text(object: &PdeObject) -> String {
    let mut out = format!("{}\n\n", object.text.join("\n"));
    out.push_str(&coefficients(&object.equations));
    out.push_str(&front(&object.front));
    for (field, fit) in object.fits.iter() {
        let text = format!(
            "{field}: noise {}; the residual is {} % of the left side, {} times what the noise explains",
            significant(fit.noise, 3),
            significant(100.0 * fit.unexplained, 2),
            significant(fit.misfit, 2)
        );
        let _ = write!(out, "\nfit       {}", wrapped(&text));
    }
    for data in &object.data {
        let axes = data.points.iter().zip(data.half_widths.iter());
        let axes: Vec<String> = axes
            .map(|((axis, points), (_, width))| {
                format!(
                    "{axis}: {points} points, windows of ±{}",
                    significant(*width, 4)
                )
            })
            .collect();
        let _ = write!(out, "\ndata      {}", wrapped(&axes.join("; ")));
    }
    let text = format!(
        "{}, of which {:.0} are independent",
        object.windows, object.independent_windows
    );
    let _ = write!(out, "\nwindows   {}", wrapped(&text));
    out
}
