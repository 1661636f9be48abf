//! What thrust may have beside its elasticity and its lag, wherever it was flown.

use super::ModelSelection;
use crate::fitted::range;
use crate::flights::drift::drift_name;
use crate::flights::fit::Fit;
use crate::flights::model::{ModelTerms, Segment};

impl ModelSelection<'_> {
    /// Offers the settling after the start, a drift and the second term of throttle, one after the other.
    pub(in crate::flights) fn offer_motors(&mut self, drift_of_time: bool) {
        if self.pieces.iter().any(|p| p.on_s.is_some()) {
            let shape = ModelTerms {
                settling: true,
                ..self.best.shape
            };
            self.offer("settling after the start", shape, false);
        }
        let shape = ModelTerms {
            battery: true,
            ..self.best.shape
        };
        self.offer(drift_name(drift_of_time), shape, false);
        let before = self.best.clone();
        let shape = ModelTerms {
            curvature: true,
            ..before.shape
        };
        if self.offer("second term of throttle", shape, false) && !rises(&self.best, self.pieces) {
            self.replace(
                "without it: thrust would fall with throttle",
                before.shape,
                &before,
            );
        }
    }
}

/// Whether thrust rises with throttle over all throttles of the rows that count.
fn rises(fit: &Fit, pieces: &[Segment]) -> bool {
    let used = pieces
        .iter()
        .flat_map(|p| p.rows.iter().map(|&i| p.throttle[i]));
    let Some(range) = range(used) else {
        return true;
    };
    let (half, c) = (
        0.5 * fit.value("elasticity").unwrap_or(0.0),
        fit.value("curvature").unwrap_or(0.0),
    );
    range.iter().all(|s| half + 2.0 * c * (s - 1.0) > 0.0)
}
