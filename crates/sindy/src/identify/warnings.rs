//! Warnings about the data.

use super::known::KnownPart;
use super::regress::Statistics;
use crate::data::dataset::DataReport;
use crate::data::samples::Samples;
use crate::error::SindyError;
use crate::library::Library;
use crate::statistics::gram::Gram;
use crate::uncertainty::identifiability::examine;

/// A condition of the scaled library above which collinear terms are named: intervals are ten thousand times those of
/// separate terms. A warning only.
const CONDITION: f64 = 1e4;

/// Warnings about the data before anything is fitted; `samples` are all usable rows.
pub(super) fn of_data(
    report: &DataReport,
    statistics: &Statistics,
    libraries: &[(Library, KnownPart)],
    samples: &Samples,
) -> Result<Vec<String>, SindyError> {
    let mut out = Vec::new();
    if report.missing_rows + report.holes + report.short_rows > 0 {
        out.push(format!(
            "gaps split the trajectories into {} stretches: {} rows with missing values, {} jumps of time, {} rows in \
             stretches too short to use",
            report.stretches, report.missing_rows, report.holes, report.short_rows
        ));
    }
    for (i, parts) in statistics.grams.iter().enumerate() {
        let (library, _) = &libraries[i];
        if library.is_empty() || libraries[..i].contains(&libraries[i]) {
            continue;
        }
        let total = Gram::total(parts);
        if total.skipped > 0 {
            out.push(format!(
                "{} of {} rows left out of the regression: a term of the library is not finite there",
                total.skipped,
                total.skipped + total.rows
            ));
        }
        let found = examine(library, &total, samples)?;
        if !found.zero_terms.is_empty() {
            out.push(format!(
                "terms that are zero throughout: {}",
                found.zero_terms.join(", ")
            ));
        }
        for (condition, terms) in found.collinear.iter().filter(|c| c.0 > CONDITION) {
            out.push(format!(
                "nearly collinear terms (condition {condition:.1e}): {}",
                terms.join(", ")
            ));
        }
        for column in found.inputs.iter().filter(|c| c.hardly_excited) {
            out.push(format!(
                "column `{}` hardly moves: mean {:.4}, standard deviation {:.2e}",
                column.name, column.mean, column.sd
            ));
        }
    }
    out.dedup();
    Ok(out)
}

/// A warning where weights above 0 differ by more than a tenth.
pub(super) fn weights_differ<'a>(weights: impl Iterator<Item = &'a f64>) -> Option<String> {
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    for &w in weights.filter(|w| **w > 0.0) {
        (least, most) = (least.min(w), most.max(w));
    }
    (most > 1.1 * least).then(|| {
        format!(
            "weights differ ({:.1} times): regressions on slopes and the output error use them; the noise estimate, smoothing \
             and the weak form count all rows that have a weight alike",
            most / least
        )
    })
}
