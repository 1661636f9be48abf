//! The object of `pde --json`.

use serde::Serialize;
use sindy::pde::{FieldData, FieldIdentification, FieldQuality};

use crate::fit::object::{Front, FrontPoint, TermObject};
use crate::named::Named;

/// The result of an identification of fields.
#[derive(Serialize)]
pub(super) struct PdeObject {
    /// The equations as text.
    pub(super) text: Vec<String>,
    /// The terms of each field's equation.
    pub(super) equations: Named<Vec<TermObject>>,
    pub(super) fits: Named<FitOfField>,
    /// Terms against error, for each field.
    pub(super) front: Named<Front>,
    /// Windows without missing samples.
    pub(super) windows: usize,
    /// Windows that are independent of each other, about.
    pub(super) independent_windows: f64,
    pub(super) data: Vec<DataOfField>,
    pub(super) warnings: Vec<String>,
    version: &'static str,
}

/// How well the equation of a field fits.
#[derive(Serialize)]
pub(super) struct FitOfField {
    /// Standard deviation of the field's noise.
    pub(super) noise: f64,
    /// Root mean square of the residual over that which noise explains.
    pub(super) misfit: f64,
    /// The residual's share of the left side.
    pub(super) unexplained: f64,
}

/// A measurement.
#[derive(Serialize)]
pub(super) struct DataOfField {
    /// Points along the axes, time first.
    pub(super) points: Named<usize>,
    /// Half-widths of the windows, in the axes' units.
    pub(super) half_widths: Named<f64>,
}

impl PdeObject {
    /// With the `warnings` of the data before those of the identification.
    pub(super) fn new(
        found: &FieldIdentification,
        data: &[FieldData],
        mut warnings: Vec<String>,
    ) -> Self {
        warnings.extend(found.warnings.iter().cloned());
        let names = data[0].names();
        let terms = found.equations.iter().map(|equation| {
            let terms = equation.terms.iter().map(|t| TermObject {
                term: t.term.clone(),
                coefficient: t.coefficient,
                std_error: Some(t.std_error),
                inclusion: Some(t.inclusion),
                interval: Some(t.interval),
            });
            terms.collect()
        });
        let fit = |f: &FieldQuality| FitOfField {
            noise: f.noise,
            misfit: f.misfit,
            unexplained: f.unexplained,
        };
        let widths = data.iter().zip(&found.half_widths);
        Self {
            text: found.equations.iter().map(|e| format!("{e:.5}")).collect(),
            equations: Named::new(names, terms),
            fits: Named::new(names, found.fits.iter().map(fit)),
            front: Named::new(names, found.fits.iter().map(front)),
            windows: found.windows,
            independent_windows: found.independent,
            data: widths
                .map(|(data, widths)| {
                    let axes: Vec<String> =
                        data.axes().iter().map(|a| a.name().to_owned()).collect();
                    DataOfField {
                        points: Named::new(&axes, data.axes().iter().map(sindy::pde::Axis::points)),
                        half_widths: Named::new(&axes, widths.iter().copied()),
                    }
                })
                .collect(),
            warnings,
            version: env!("CARGO_PKG_VERSION"),
        }
    }
}

fn front(fit: &FieldQuality) -> Front {
    Front {
        unit: "residual over the left side, root mean squares under the windows",
        noise: fit.noise,
        residual: Some(fit.residual),
        disturbance: None,
        points: fit.front.iter().map(FrontPoint::of).collect(),
    }
}
