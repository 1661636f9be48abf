//! Identifiability: what the data support, before anything is fitted.
//!
//! - *condition*: the ratio of the largest to the smallest singular value of `Θ` with columns of unit
//!   length. Above 30 coefficients trade off against each other, above 1000 they mean nothing.
//! - *collinear groups*: the terms that share the directions of small singular values, by the variance
//!   decomposition of Belsley, Kuh and Welsch ("Regression Diagnostics", 1980). A group names every term most of whose
//!   variance comes from its directions, but for what closer dependences take: these do not hide a member.
//! - *excitation*: mean, spread and range of every column, and whether it moved at all.
//! - *variance inflation*: by how much the other terms inflate a coefficient's variance, `1/(1 - R²)`.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use crate::data::samples::{BlockSource, passed};
use crate::error::SindyError;
use crate::library::Library;
use crate::statistics::gram::{Gram, check};

/// Condition index from which a direction counts as near dependence: the value of Belsley, Kuh and Welsch.
const DEPENDENT_INDEX: f64 = 30.0;
/// Share of a coefficient's variance from which its term belongs to a dependence: half, as in the same source.
const DEPENDENT_SHARE: f64 = 0.5;
/// Directions whose condition indices differ by less than this factor are one space, for its basis is arbitrary. Noise of
/// a thousand rows moves an index by a few percent.
const ALIKE: f64 = 1.1;
/// Terms whose part in such a space is less than this of each other's are not coupled: it lies far above rounding and far
/// below one.
const APART: f64 = 1e-3;
/// A column whose standard deviation is below this share of its root mean square hardly moved: it is nearly a multiple of
/// the constant. A warning only.
const HARDLY_EXCITED: f64 = 0.01;
/// Share of the largest eigenvalue of the Gram matrix below which an eigenvalue is rounding.
const ROUNDING: f64 = 1e-14;
/// Share of the largest inflation that rounding leaves, from which a term counts as dependent.
const DEPENDENT_INFLATION: f64 = 0.1;

/// How much one column moved.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Excitation {
    /// The column.
    pub name: String,
    /// Its mean.
    pub mean: f64,
    /// Its standard deviation.
    pub sd: f64,
    /// Its smallest value.
    pub min: f64,
    /// Its largest value.
    pub max: f64,
    /// Whether it hardly moved: a standard deviation below 1 % of its root mean square.
    pub hardly_excited: bool,
}

/// Condition, collinear terms and excitation of a library on data.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Identifiability {
    /// Rows that can be used.
    pub rows: usize,
    /// Condition of the scaled library, over the terms that are not zero throughout; infinite where
    /// terms are exactly dependent.
    pub condition: f64,
    /// Terms that are zero throughout.
    pub zero_terms: Vec<String>,
    /// Groups of terms that are nearly dependent, with the condition index of the dependence.
    pub collinear: Vec<(f64, Vec<String>)>,
    /// Variance inflation of each term (infinite where it is dependent on the others).
    pub variance_inflation: Vec<(String, f64)>,
    /// The columns that the terms use.
    pub inputs: Vec<Excitation>,
}

/// Examines `library` on the data of `source`, with the statistics `gram` of the same data.
///
/// # Errors
/// A term that names no column, statistics that are empty or not finite, terms that are all zero, or a pass that failed.
pub fn examine(
    library: &Library,
    gram: &Gram,
    source: &dyn BlockSource,
) -> Result<Identifiability, SindyError> {
    check(gram)?;
    let names = library.names();
    let live: Vec<usize> = (0..names.len())
        .filter(|&j| gram.xtx[(j, j)] > 0.0)
        .collect();
    let zero_terms = (0..names.len())
        .filter(|j| !live.contains(j))
        .map(|j| names[j].clone())
        .collect();
    let k = live.len();
    let r = DMatrix::from_fn(k, k, |a, b| {
        let (i, j) = (live[a], live[b]);
        // One after the other: the product of two squares may be beyond the largest number.
        gram.xtx[(i, j)] / gram.xtx[(i, i)].sqrt() / gram.xtx[(j, j)].sqrt()
    });
    if k == 0 {
        return Err(SindyError::Singular {
            what: "a library whose terms are all zero on the data",
        });
    }
    let directions = Directions::of(r);
    let inputs = library
        .variables()
        .iter()
        .map(|name| excitation(name, source))
        .collect::<Result<Vec<_>, _>>()?;
    let named = |terms: &[usize]| terms.iter().map(|&j| names[live[j]].clone()).collect();
    let groups = directions.collinear().into_iter();
    let inflation = directions.variance_inflation().into_iter();
    Ok(Identifiability {
        rows: gram.rows,
        condition: directions.condition(),
        zero_terms,
        collinear: groups
            .map(|(index, terms)| (index, named(&terms)))
            .collect(),
        variance_inflation: inflation
            .zip(&live)
            .map(|(v, &j)| (names[j].clone(), v))
            .collect(),
        inputs,
    })
}

/// The eigenvectors of the scaled Gram matrix, and what each contributes to the variance of every coefficient.
struct Directions {
    eigenvalues: DVector<f64>,
    vectors: DMatrix<f64>,
    /// The largest eigenvalue, and that below which an eigenvalue is rounding.
    largest: f64,
    floor: f64,
    /// `φ_jm = v_jm² / λ_m`, coefficients x directions.
    share: DMatrix<f64>,
}

impl Directions {
    fn of(gram: DMatrix<f64>) -> Self {
        let k = gram.nrows();
        let eigen = gram.symmetric_eigen();
        let largest = eigen.eigenvalues.iter().copied().fold(0.0, f64::max);
        let floor = ROUNDING * largest;
        let share = DMatrix::from_fn(k, k, |j, m| {
            eigen.eigenvectors[(j, m)].powi(2) / eigen.eigenvalues[m].max(floor)
        });
        Self {
            eigenvalues: eigen.eigenvalues,
            vectors: eigen.eigenvectors,
            largest,
            floor,
            share,
        }
    }

    /// The condition index of an eigenvalue.
    fn index(&self, eigenvalue: f64) -> f64 {
        if eigenvalue > self.floor {
            (self.largest / eigenvalue).sqrt()
        } else {
            f64::INFINITY
        }
    }

    fn condition(&self) -> f64 {
        let all = self.eigenvalues.iter().map(|&l| self.index(l));
        all.fold(1.0, f64::max)
    }

    /// Infinite for terms that are dependent on the others.
    fn variance_inflation(&self) -> Vec<f64> {
        let inflation = |j: usize| match self.share.row(j).sum() {
            v if v * self.floor > DEPENDENT_INFLATION => f64::INFINITY,
            v => v,
        };
        (0..self.share.nrows()).map(inflation).collect()
    }

    /// Groups of nearly dependent terms with the condition index of the dependence, the closest first.
    fn collinear(&self) -> Vec<(f64, Vec<usize>)> {
        let k = self.eigenvalues.len();
        let mut order: Vec<usize> = (0..k).collect();
        order.sort_by(|&a, &b| self.eigenvalues[a].total_cmp(&self.eigenvalues[b]));
        order.retain(|&m| self.index(self.eigenvalues[m]) >= DEPENDENT_INDEX);
        let alike = |a: &usize, b: &usize| {
            let of = |m: usize| self.eigenvalues[m].max(self.floor).sqrt();
            of(*b) < ALIKE * of(*a)
        };
        let mut groups = Vec::new();
        for space in order.chunk_by(alike) {
            let closest = self.eigenvalues[space[0]];
            let own = |j: usize| space.iter().map(|&m| self.share[(j, m)]).sum::<f64>();
            // What closer dependences leave of a variance.
            let left = |j: usize| {
                let directions = (0..k).filter(|&m| self.eigenvalues[m] >= closest);
                directions.map(|m| self.share[(j, m)]).sum::<f64>()
            };
            let members: Vec<usize> = (0..k)
                .filter(|&j| own(j) > DEPENDENT_SHARE * left(j))
                .collect();
            let found = together(&members, &self.vectors.select_columns(space));
            groups.extend(found.into_iter().map(|group| (self.index(closest), group)));
        }
        groups.sort_by(|a, b| b.0.total_cmp(&a.0));
        groups
    }
}

/// Splits the members of a nearly dependent space into uncoupled groups. `vectors` are a basis of the space, and its
/// projector `V Vᵀ`, which does not depend on the basis, couples members of one group. Groups of one are omitted.
fn together(members: &[usize], vectors: &DMatrix<f64>) -> Vec<Vec<usize>> {
    let part = |i: usize, j: usize| vectors.row(i).dot(&vectors.row(j));
    let coupled = |i: usize, j: usize| part(i, j).abs() > APART * (part(i, i) * part(j, j)).sqrt();
    let mut rest = members.to_vec();
    let mut groups = Vec::new();
    while let Some(first) = rest.first().copied() {
        let mut group = vec![first];
        rest.retain(|&j| j != first);
        let mut next = 0;
        while next < group.len() {
            let (with, without): (Vec<usize>, Vec<usize>) =
                rest.iter().partition(|&&j| coupled(group[next], j));
            group.extend(with);
            rest = without;
            next += 1;
        }
        if group.len() > 1 {
            group.sort_unstable();
            groups.push(group);
        }
    }
    groups
}

fn excitation(name: &str, source: &dyn BlockSource) -> Result<Excitation, SindyError> {
    let column = crate::data::samples::position(source.names(), name)?;
    let (mut n, mut sum, mut min, mut max) = (0.0, 0.0, f64::INFINITY, f64::NEG_INFINITY);
    source.for_each_block(&mut |block| {
        for &v in block.columns[column].iter().filter(|v| v.is_finite()) {
            n += 1.0;
            sum += v;
            min = v.min(min);
            max = v.max(max);
        }
    });
    passed(source)?;
    let mean = if n > 0.0 { sum / n } else { f64::NAN };
    let mut squares = 0.0;
    source.for_each_block(&mut |block| {
        let finite = block.columns[column].iter().filter(|v| v.is_finite());
        squares += finite.map(|v| (v - mean).powi(2)).sum::<f64>();
    });
    passed(source)?;
    let sd = (squares / n).sqrt();
    let hardly_excited = !(sd > HARDLY_EXCITED * (sd * sd + mean * mean).sqrt());
    Ok(Excitation {
        name: name.to_string(),
        mean,
        sd,
        min,
        max,
        hardly_excited,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Samples;

    fn examine_terms(terms: &[&str], columns: Vec<Vec<f64>>) -> Identifiability {
        let mut samples = Samples::new(&["a", "b", "y"]);
        samples.push_group(columns).unwrap();
        let library = Library::parse(terms).unwrap();
        let gram = Gram::total(&Gram::accumulate(&library, "y", &samples).unwrap());
        examine(&library, &gram, &samples).unwrap()
    }

    #[test]
    fn analytic_orthogonal_columns_have_condition_one() {
        // Whole periods of sine and cosine are orthogonal.
        let angle = |i: i32| std::f64::consts::TAU * f64::from(i) / 64.0;
        let a: Vec<f64> = (0..128).map(|i| angle(i).sin()).collect();
        let b: Vec<f64> = (0..128).map(|i| angle(i).cos()).collect();
        let report = examine_terms(&["a", "b"], vec![a.clone(), b, a]);
        // Sums of 128 rounded sines.
        assert!((report.condition - 1.0).abs() < 1e-12);
        assert!(report.collinear.is_empty() && report.zero_terms.is_empty());
        assert!(
            report
                .variance_inflation
                .iter()
                .all(|(_, v)| (v - 1.0).abs() < 1e-12)
        );
        assert!(report.inputs.iter().all(|i| !i.hardly_excited));
    }

    #[test]
    fn analytic_condition_of_two_columns_at_an_angle() {
        // Unit columns with inner product r have singular values √(1 ± r) and variance inflation 1/(1 - r²).
        let angle = |i: i32| std::f64::consts::TAU * f64::from(i) / 64.0;
        let r: f64 = 0.96;
        let a: Vec<f64> = (0..128).map(|i| angle(i).sin()).collect();
        let b = (0..128)
            .map(|i| r * angle(i).sin() + (1.0 - r * r).sqrt() * angle(i).cos())
            .collect();
        let report = examine_terms(&["a", "b"], vec![a.clone(), b, a]);
        // Sums of 128 rounded numbers.
        assert!((report.condition - ((1.0 + r) / (1.0 - r)).sqrt()).abs() < 1e-10);
        let inflation = 1.0 / (1.0 - r * r);
        assert!(
            report
                .variance_inflation
                .iter()
                .all(|(_, v)| (v - inflation).abs() < 1e-9)
        );
    }

    #[test]
    fn prop_a_library_of_zeros_is_refused() {
        let mut samples = Samples::new(&["a", "y"]);
        samples
            .push_group(vec![vec![0.0; 5], vec![1.0; 5]])
            .unwrap();
        let library = Library::parse(&["a"]).unwrap();
        let gram = Gram::total(&Gram::accumulate(&library, "y", &samples).unwrap());
        assert!(matches!(
            examine(&library, &gram, &samples),
            Err(SindyError::Singular { .. })
        ));
    }

    #[test]
    fn analytic_dependent_and_still_columns_are_named() {
        let a: Vec<f64> = (0..100).map(|i| f64::from(i) / 100.0).collect();
        let b = vec![0.0; 100];
        let report = examine_terms(&["1", "a", "2*a+1", "b"], vec![a.clone(), b, a]);
        assert!(report.condition.is_infinite());
        assert_eq!(report.zero_terms, ["b"]);
        assert_eq!(report.collinear.len(), 1);
        assert_eq!(report.collinear[0].1, ["1", "a", "2*a+1"]);
        assert!(
            report
                .inputs
                .iter()
                .find(|i| i.name == "b")
                .unwrap()
                .hardly_excited
        );
    }

    /// The groups of an infinite condition, sorted.
    fn exact_groups(report: &Identifiability) -> Vec<Vec<String>> {
        let exact = report.collinear.iter().filter(|c| c.0.is_infinite());
        let mut groups: Vec<Vec<String>> = exact.map(|c| c.1.clone()).collect();
        groups.sort();
        groups
    }

    #[test]
    fn analytic_two_states_that_are_one_are_named_degree_by_degree() {
        // The dependences of b = a: all monomials of one degree are one column, and a basis of six directions mixes them.
        let a: Vec<f64> = (0..200).map(|i| (0.37 * f64::from(i)).sin()).collect();
        let terms = [
            "a", "b", "a^2", "a*b", "b^2", "a^3", "a^2*b", "a*b^2", "b^3",
        ];
        let report = examine_terms(&terms, vec![a.clone(), a.clone(), a]);
        assert_eq!(
            exact_groups(&report),
            [
                vec!["a", "b"],
                vec!["a^2", "a*b", "b^2"],
                vec!["a^3", "a^2*b", "a*b^2", "b^3"]
            ]
        );
    }

    #[test]
    fn analytic_a_member_that_a_closer_dependence_hides_is_named() {
        // The first two differ by a part in 1e6, which takes nearly all of their variance; the third by one in 1e3.
        let angle = |i: i32| std::f64::consts::TAU * f64::from(i) / 64.0;
        let a: Vec<f64> = (0..128).map(|i| angle(i).sin()).collect();
        let b: Vec<f64> = (0..128).map(|i| (3.0 * angle(i)).cos()).collect();
        let report = examine_terms(
            &["a", "a + 1e-6*cos(50*b)", "a + 0.003*b^2"],
            vec![a.clone(), b, a],
        );
        assert_eq!(report.collinear.len(), 2, "{:?}", report.collinear);
        assert_eq!(report.collinear[0].1.len(), 2);
        // The third is near to both of the others.
        assert_eq!(report.collinear[1].1.len(), 3, "{:?}", report.collinear);
    }

    #[test]
    fn prop_the_unit_of_a_column_means_nothing() {
        let base: Vec<f64> = (0..100).map(|i| 1.0 + (0.3 * f64::from(i)).sin()).collect();
        for exponent in [-160, -100, -50, 30, 50, 100, 160] {
            let scale = 10f64.powi(exponent);
            let a: Vec<f64> = base.iter().map(|v| v * scale).collect();
            let mut samples = Samples::new(&["a", "b", "y"]);
            samples
                .push_group(vec![a, base.clone(), base.clone()])
                .unwrap();
            let library = Library::parse(&["1", "a", "b^2", "2*a + 3*a"]).unwrap();
            let said = Gram::accumulate(&library, "y", &samples)
                .and_then(|parts| examine(&library, &Gram::total(&parts), &samples));
            match said {
                Ok(report) => {
                    assert!(exponent.abs() < 150, "{exponent}");
                    assert_eq!(
                        exact_groups(&report),
                        [vec!["a", "2*a + 3*a"]],
                        "{exponent}"
                    );
                    assert!(report.variance_inflation.iter().all(|(_, v)| !v.is_nan()));
                    assert!(
                        report.inputs.iter().all(|i| !i.hardly_excited),
                        "{exponent}"
                    );
                }
                Err(error) => {
                    assert!(exponent.abs() > 150, "{exponent}: {error}");
                    assert!(error.to_string().contains("`a`"), "{error}");
                }
            }
        }
    }
}
