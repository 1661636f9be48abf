//! Statistics that rows go into, by equation and cluster.

use std::ops::Range;

use super::clusters::ClusterSums;
use crate::data::samples::Samples;
use crate::error::SindyError;
use crate::identify::prepare::{WEIGHT, slope_name};
use crate::library::Library;
use crate::statistics::gram::{Accumulate, Gram};
use crate::statistics::tsqr::CONDITION_LIMIT;
use crate::weak::WeakForm;

/// The name of the time column of the weak form.
const TIME: &str = "(time)";

/// A library and the equations that share it.
#[derive(Clone, Debug)]
pub(super) struct Shared {
    pub library: Library,
    pub states: Vec<usize>,
    /// Whether the triangular factor is accumulated.
    triangle: bool,
}

/// Equations by their libraries.
pub(super) fn shared(libraries: &[Library]) -> Vec<Shared> {
    let mut all: Vec<Shared> = Vec::new();
    for (i, library) in libraries.iter().enumerate() {
        match all.iter_mut().find(|s| s.library == *library) {
            Some(one) => one.states.push(i),
            None => all.push(Shared {
                library: library.clone(),
                states: vec![i],
                triangle: false,
            }),
        }
    }
    all
}

/// The target of a regression.
#[derive(Clone, Debug)]
pub(super) enum RegressionTarget {
    /// Slopes (in discrete time the next samples); with weights or without.
    Slopes { weighted: bool },
    /// The weak form with this half-width, of the named states.
    Weak(f64, Vec<String>),
}

/// Statistics of one kind.
pub(super) struct Sums {
    kind: RegressionTarget,
    shared: Vec<Shared>,
    names: Vec<String>,
    /// Rows that wait, and the cluster of each of their groups.
    waiting: Samples,
    places: Vec<usize>,
    rows: usize,
    /// Whether it is decided where the triangular factor is accumulated.
    decided: bool,
    pub clusters: ClusterSums,
}

impl Sums {
    /// `triangles` says by library where the triangular factor is accumulated; without it the first rows decide.
    pub(super) fn new(
        kind: RegressionTarget,
        shared: &[Shared],
        data: &[String],
        clusters: ClusterSums,
        triangles: Option<&[bool]>,
    ) -> Self {
        let mut names = Vec::new();
        match &kind {
            RegressionTarget::Slopes { weighted } => {
                names.extend_from_slice(data);
                names.extend((0..clusters.grams.len()).map(slope_name));
                names.extend(weighted.then(|| WEIGHT.to_owned()));
            }
            RegressionTarget::Weak(..) => {
                names.push(TIME.to_owned());
                names.extend_from_slice(data);
            }
        }
        let mut shared = shared.to_vec();
        for (one, &triangle) in shared.iter_mut().zip(triangles.into_iter().flatten()) {
            one.triangle = triangle;
        }
        Self {
            kind,
            shared,
            waiting: samples(&names),
            names,
            places: Vec::new(),
            rows: 0,
            decided: triangles.is_some(),
            clusters,
        }
    }

    /// By library, whether the triangular factor is accumulated, where that is decided.
    pub(super) fn triangles(&self) -> Option<Vec<bool>> {
        self.decided
            .then(|| self.shared.iter().map(|s| s.triangle).collect())
    }

    /// Takes rows of a stretch, in blocks.
    pub(super) fn add(&mut self, columns: &[&[f64]], rows: Range<usize>) -> Result<(), SindyError> {
        let n = rows.len();
        if n == 0 {
            return Ok(());
        }
        let parts = (n / self.clusters.block).max(1);
        for k in 0..parts {
            let part = rows.start + k * n / parts..rows.start + (k + 1) * n / parts;
            self.places.push(self.clusters.deal(part.len()));
            let own = columns.iter().map(|c| c[part.clone()].to_vec()).collect();
            self.waiting.push_group(own)?;
        }
        self.rows += n;
        Ok(())
    }

    /// Rows that wait.
    pub(super) fn waiting(&self) -> usize {
        self.rows
    }

    /// Sums the rows that wait.
    pub(super) fn flush(&mut self) -> Result<(), SindyError> {
        if self.rows == 0 {
            return Ok(());
        }
        for k in 0..self.shared.len() {
            let mut parts = self.sums(k)?;
            // The condition of the first rows decides for all rows, because there is no second pass.
            if !self.decided && matches!(self.kind, RegressionTarget::Slopes { .. }) {
                let total = parts.first().map(|p| Gram::total(p));
                if total.is_some_and(|t| t.condition() > CONDITION_LIMIT) {
                    self.shared[k].triangle = true;
                    parts = self.sums(k)?;
                }
            }
            for (&i, groups) in self.shared[k].states.iter().zip(&parts) {
                for (&place, gram) in self.places.iter().zip(groups) {
                    self.clusters.grams[i][place].merge(gram);
                }
            }
        }
        self.decided = true;
        self.waiting = samples(&self.names);
        self.places.clear();
        self.rows = 0;
        Ok(())
    }

    /// Statistics of the rows that wait, for the equations of one library: by equation, then group.
    fn sums(&self, k: usize) -> Result<Vec<Vec<Gram>>, SindyError> {
        let one = &self.shared[k];
        match &self.kind {
            RegressionTarget::Slopes { weighted } => {
                let targets: Vec<String> = one.states.iter().map(|&i| slope_name(i)).collect();
                let targets: Vec<&str> = targets.iter().map(String::as_str).collect();
                let mut of = Accumulate::new(&one.library, "").triangle(one.triangle);
                if *weighted {
                    of = of.weights(WEIGHT);
                }
                of.targets(&targets, &self.waiting)
            }
            RegressionTarget::Weak(half_width, states) => {
                let own: Vec<&str> = one.states.iter().map(|&i| states[i].as_str()).collect();
                let form = WeakForm::default().half_width(*half_width)?;
                match form.system(&one.library, TIME, &own, &self.waiting) {
                    Ok(system) => Ok(system.grams),
                    Err(SindyError::TooShort { .. }) => Ok(vec![Vec::new(); own.len()]),
                    Err(other) => Err(other),
                }
            }
        }
    }
}

fn samples(names: &[String]) -> Samples {
    Samples::new(&names.iter().map(String::as_str).collect::<Vec<_>>())
}
