//! The automatic call for fields: windows, terms, coefficients and what to think of them.

use serde::Serialize;

use super::bridge::bridged;
use super::colour::NoiseColour;
use super::data::{Axis, FieldData};
use super::doubts::doubts;
use super::fit::{FieldFit, Search};
use super::model::{FieldEquation, FoundTerm, left};
use super::moments::NoisyFields;
use super::system::{Quantity, WeakField};
use super::term::{FieldLibrary, FieldTerm};
use super::window::{AxisWindows, POWER, REACH};
use crate::derivative::noise_level;
use crate::error::{SindyError, require};
use crate::identify::FrontPoint;
use crate::numerics::upper_median;
use crate::solve::outcome::Outcome;
use crate::statistics::regression::student_95;
use crate::weak::half_width_of;

/// Lines of each axis from which noise and windows are taken.
const LINES: usize = 24;
/// Samples of a line whose spectrum tells a half-width.
const SPECTRUM: usize = 48;
/// The least half-width that is chosen, in steps: sums approximate integrals of the derivatives of the test function.
const STEPS: f64 = 12.0;
/// Independent windows for each candidate below which terms are chosen from too little.
const FEW: f64 = 2.0;

/// The automatic identification of partial differential equations.
#[derive(Clone, Debug)]
pub struct IdentifyField {
    library: FieldLibrary,
    time_order: u8,
    relevance: f64,
    half_widths: Option<Vec<f64>>,
}

/// An equation with what it rests on.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FieldIdentification {
    /// One for each field.
    pub equations: Vec<FieldEquation>,
    /// By field, the rest.
    pub fits: Vec<FieldQuality>,
    /// By data set, the half-widths of the windows, in the axes' units.
    pub half_widths: Vec<Vec<f64>>,
    /// Windows without missing samples, in all data sets, and how many of them are independent.
    pub windows: usize,
    /// Windows that are independent of each other, about.
    pub independent: f64,
    /// What qualifies the numbers.
    pub warnings: Vec<String>,
}

/// How well an equation fits.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct FieldQuality {
    /// Standard deviation of the field's noise, mean square over the data sets.
    pub noise: f64,
    /// Root mean square of the residual over that which noise explains.
    pub misfit: f64,
    /// The residual's share of the left side, as root mean squares.
    pub unexplained: f64,
    /// Root mean square of the residual, in the unit of the left side.
    pub residual: f64,
    /// The best equation of each number of terms.
    pub front: Vec<FrontPoint>,
    /// [`Outcome::Optimal`] where these are proven.
    pub outcome: Outcome,
}

impl IdentifyField {
    /// With candidate terms for all equations, first order in time and windows from the data.
    #[must_use]
    pub fn new(library: FieldLibrary) -> Self {
        Self {
            library,
            time_order: 1,
            relevance: 1e-4,
            half_widths: None,
        }
    }

    /// The same with another derivative in time on the left side.
    ///
    /// # Errors
    /// An order other than 1 and 2.
    pub fn time_order(self, time_order: u8) -> Result<Self, SindyError> {
        require(
            (1..=2).contains(&time_order),
            "time_order",
            "1 or 2",
            time_order,
        )?;
        Ok(Self { time_order, ..self })
    }

    /// The same without terms that contribute less than this share of their equation's largest term.
    ///
    /// # Errors
    /// A share outside 0 to 1.
    pub fn relevance(self, relevance: f64) -> Result<Self, SindyError> {
        let allowed = (0.0..1.0).contains(&relevance);
        require(allowed, "relevance", "at least 0 and below 1", relevance)?;
        Ok(Self { relevance, ..self })
    }

    /// The same with windows of these half-widths, time first, in the axes' units.
    ///
    /// # Errors
    /// Half-widths that are not positive and finite.
    pub fn half_widths(self, half_widths: Vec<f64>) -> Result<Self, SindyError> {
        let allowed = half_widths.iter().all(|h| *h > 0.0 && h.is_finite());
        require(
            allowed,
            "half_widths",
            "positive and finite",
            format!("{half_widths:?}"),
        )?;
        let half_widths = Some(half_widths);
        Ok(Self {
            half_widths,
            ..self
        })
    }

    /// Identifies the equations of `data`, one or more measurements of the same fields on grids of their own.
    ///
    /// # Errors
    /// No data, fields or axes that differ from the library's, axes of fewer than 9 points, fewer windows without missing samples
    /// than candidates.
    pub fn run(&self, data: &[FieldData]) -> Result<FieldIdentification, SindyError> {
        let mut warnings = Vec::new();
        require(!data.is_empty(), "data", "at least one field", "none")?;
        let again = (1..data.len()).find(|&k| data[..k].contains(&data[k]));
        let found = again.map_or(0, |k| k + 1);
        let expected = "measurements that differ";
        require(
            again.is_none(),
            "data",
            expected,
            format!("number {found} again"),
        )?;
        data.iter().try_for_each(|d| self.check(d))?;
        let points: usize = data.iter().map(|d| d.points() * d.names().len()).sum();
        let (data, filled): (Vec<FieldData>, Vec<usize>) = data.iter().map(bridged).unzip();
        let filled: usize = filled.iter().sum();
        if filled > 0 {
            warnings.push(format!(
                "{filled} of {points} samples are missing: each was filled from its neighbours, and standard errors ignore that"
            ));
        }
        let noise = data.iter().map(noise).collect::<Result<Vec<_>, _>>()?;
        let windows = data
            .iter()
            .map(|d| self.windows(d))
            .collect::<Result<Vec<_>, _>>()?;
        let axes = self.library.space.len() + 1;
        let fields = self.library.fields.len();
        let terms = self.library.terms.iter().map(Quantity::of_term);
        let of_field = |f| Quantity::of_field(f, fields, self.time_order, axes);
        let quantities: Vec<Quantity> = terms.chain((0..fields).map(of_field)).collect();
        let weak: Vec<WeakField<'_>> = data
            .iter()
            .zip(&noise)
            .zip(&windows)
            .map(|((data, (variances, correlations)), windows)| {
                let fields = NoisyFields {
                    data,
                    variances,
                    correlations,
                };
                WeakField::new(fields, windows.clone(), quantities.clone())
            })
            .collect();
        let rows: usize = weak.iter().map(|w| w.rows).sum();
        let independent: f64 = weak.iter().map(WeakField::independent).sum();
        let candidates = self.library.len();
        if rows <= candidates {
            let what = "windows without missing samples (more than the library has terms)";
            return Err(SindyError::shape(what, candidates + 1, rows));
        }
        if independent < FEW * candidates as f64 {
            warnings.push(format!(
                "{candidates} candidates and only some {independent:.0} independent windows: the choice of terms is not safe; \
                 measure longer or wider, or give fewer candidates"
            ));
        }
        let search = Search::new(&weak, candidates, self.relevance);
        let (mut equations, mut fits) = (Vec::new(), Vec::new());
        for f in 0..fields {
            let fit = search.find(candidates + f)?;
            let equation = self.equation(data[0].axes()[0].name(), f, &fit);
            warnings.extend(doubts(&equation, &fit, &self.library.names()));
            let mean = noise.iter().map(|n| n.0[f]).sum::<f64>() / noise.len() as f64;
            fits.push(self.quality(&fit, mean.sqrt()));
            equations.push(equation);
        }
        let widths = |w: &Vec<AxisWindows>| w.iter().map(AxisWindows::half_width).collect();
        Ok(FieldIdentification {
            equations,
            fits,
            half_widths: windows.iter().map(widths).collect(),
            windows: rows,
            independent,
            warnings,
        })
    }

    fn check(&self, data: &FieldData) -> Result<(), SindyError> {
        let expected = self.library.fields.join(", ");
        let same = data.names() == self.library.fields;
        require(same, "fields", expected, data.names().join(", "))?;
        let space: Vec<&str> = data.axes()[1..].iter().map(Axis::name).collect();
        let same = space == self.library.space;
        require(
            same,
            "space",
            self.library.space.join(", "),
            space.join(", "),
        )?;
        let least = 2 * REACH + 1;
        match data.axes().iter().map(Axis::points).find(|n| *n < least) {
            Some(found) => Err(SindyError::too_short(least, found)),
            None => Ok(()),
        }
    }

    /// The windows of every axis.
    fn windows(&self, data: &FieldData) -> Result<Vec<AxisWindows>, SindyError> {
        let axes = data.axes().iter().enumerate();
        axes.map(|(place, axis)| {
            let given = self.half_widths.as_ref();
            let width = match given.map(|all| all.get(place).copied()) {
                Some(Some(width)) => width,
                Some(None) => {
                    let found = given.map_or(0, Vec::len);
                    let what = "half-widths (one for each axis)";
                    return Err(SindyError::shape(what, data.axes().len(), found));
                }
                None => chosen(data, place, self.highest(place))?,
            };
            let most = (axis.points() - 1) / 2;
            let reach = (width / axis.step()).round() as usize;
            Ok(AxisWindows::new(
                axis.points(),
                axis.step(),
                reach.clamp(REACH, most),
            ))
        })
        .collect()
    }

    /// The highest derivative by an axis, at least the first.
    fn highest(&self, place: usize) -> u8 {
        let Some(space) = place.checked_sub(1) else {
            return self.time_order;
        };
        let orders = self.library.terms.iter().map(|t| t.orders[space]);
        orders.max().unwrap_or(1).max(1)
    }

    fn equation(&self, time: &str, field: usize, fit: &FieldFit) -> FieldEquation {
        let estimate = &fit.estimate;
        let term = |(a, &j): (usize, &usize)| {
            let (coefficient, std_error) = (estimate.coefficients[a], estimate.std_errors[a]);
            let half = student_95(estimate.degrees) * std_error;
            let of: FieldTerm = self.library.terms[j].clone();
            FoundTerm {
                term: self.library.name(&of),
                coefficient,
                std_error,
                inclusion: 1.0 / (1.0 + (-0.5 * fit.evidence[a]).exp()),
                interval: [coefficient - half, coefficient + half],
                of,
            }
        };
        let field = self.library.fields[field].clone();
        FieldEquation {
            left: left(&field, time, self.time_order),
            field,
            terms: fit.terms.iter().enumerate().map(term).collect(),
        }
    }

    fn quality(&self, fit: &FieldFit, noise: f64) -> FieldQuality {
        let names = self.library.names();
        let weight = fit
            .subsets
            .sizes
            .first()
            .map_or(1.0, |s| s.fit.residual_sum);
        // The empty subset leaves the whole left side.
        let whole = weight.max(f64::MIN_POSITIVE);
        let point = |s: &crate::solve::exact::Subset| {
            let terms: Vec<usize> = (0..names.len()).filter(|&j| s.fit.support[j]).collect();
            FrontPoint {
                error: (s.fit.residual_sum / whole).sqrt(),
                proven: s.fit.outcome == Outcome::Optimal,
                chosen: terms == fit.terms,
                terms: terms.into_iter().map(|j| names[j].clone()).collect(),
            }
        };
        FieldQuality {
            noise,
            misfit: fit.estimate.misfit,
            unexplained: fit.estimate.unexplained,
            residual: fit.estimate.residual,
            front: fit.subsets.sizes.iter().map(point).collect(),
            outcome: fit.subsets.outcome,
        }
    }
}

/// The variances of the fields' noise, and by axis its correlation 0, 1, 2, ... samples apart, the mean of all fields.
fn noise(data: &FieldData) -> Result<(Vec<f64>, Vec<Vec<f64>>), SindyError> {
    let white = variances(data)?;
    let all: Vec<NoiseColour> = white
        .iter()
        .enumerate()
        .map(|(field, white)| NoiseColour::new(data, field, *white))
        .collect();
    let mean = |axis: usize| {
        let lags = all.iter().map(|n| n.correlations[axis].len()).max();
        let at = |lag: usize| {
            let found = all.iter().filter_map(|n| n.correlations[axis].get(lag));
            found.sum::<f64>() / all.len() as f64
        };
        (0..lags.unwrap_or(1)).map(at).collect()
    };
    let correlations = (0..data.axes().len()).map(mean).collect();
    Ok((all.iter().map(|n| n.variance).collect(), correlations))
}

/// The variance of each field's noise if it is white: along the axis that shows the least of it, which samples the field best.
fn variances(data: &FieldData) -> Result<Vec<f64>, SindyError> {
    (0..data.names().len())
        .map(|field| {
            let mut least = f64::INFINITY;
            for axis in 0..data.axes().len() {
                let places: Vec<f64> = (0..data.axes()[axis].points()).map(|i| i as f64).collect();
                let mut levels = data
                    .lines(field, axis, LINES)
                    .iter()
                    .map(|line| Ok(noise_level(&places, line)?.sigma))
                    .collect::<Result<Vec<f64>, SindyError>>()?;
                if let Some(level) = upper_median(&mut levels) {
                    least = least.min(level);
                }
            }
            // Without noise the digits of the numbers are left, less those that sums of thousands of them lose.
            let sizes = data.values(field).iter().filter(|v| v.is_finite());
            let digits = 1024.0 * f64::EPSILON * sizes.fold(0.0_f64, |most, v| most.max(v.abs()));
            let sigma = if least.is_finite() {
                least.max(digits)
            } else {
                digits
            };
            Ok(sigma * sigma)
        })
        .collect()
}

/// The half-width along an axis: the median over lines of all fields of that which the weak form of a series takes.
fn chosen(data: &FieldData, place: usize, order: u8) -> Result<f64, SindyError> {
    let axis = &data.axes()[place];
    let n = axis.points();
    let quarter = axis.step() * (n as f64 - 1.0) / 4.0;
    if n < SPECTRUM {
        return Ok(quarter);
    }
    let coordinates: Vec<f64> = (0..n).map(|i| axis.step() * i as f64).collect();
    let mut widths = (0..data.names().len())
        .flat_map(|field| data.lines(field, place, LINES))
        .map(|line| half_width_of(&coordinates, &line, order, (POWER, STEPS)))
        .collect::<Result<Vec<f64>, SindyError>>()?;
    Ok(upper_median(&mut widths).unwrap_or(quarter))
}
