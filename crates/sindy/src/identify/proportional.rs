//! Terms that are a multiple of a simpler one on every row of the data.
//!
//! Under an input that only switches between -2 and 2, `u^2` is 4 throughout, and `v u^2` is not
//! identifiable beside `v`: the fit would pick either. The earlier of two such terms stays, the later leaves the library.

use crate::data::dataset::{Dataset, Stretch};
use crate::error::SindyError;
use crate::library::Library;

/// Rows that pairs are looked for on, for speed alone: what is found is checked on all.
const LOOKED_AT: usize = 512;
/// Relative rounding of a term's value: some thousand units in the last place.
const ROUNDING: f64 = 1e-12;

/// A term that is a multiple of an earlier one on every row.
struct Multiple {
    term: usize,
    of: usize,
    factor: f64,
}

/// The library without such terms, and a warning that names them.
pub(super) fn without_multiples(
    library: Library,
    data: &Dataset,
    stretches: &[Stretch<'_>],
    warnings: &mut Vec<String>,
) -> Result<Library, SindyError> {
    if library.is_empty() {
        return Ok(library);
    }
    let multiples = multiples(&library, &data.names(), stretches)?;
    if multiples.is_empty() {
        return Ok(library);
    }
    let names = library.names();
    let equations: Vec<String> = multiples
        .iter()
        .map(|m| {
            let factor = rounded(m.factor);
            format!("{} = {factor} x {}", names[m.term], names[m.of])
        })
        .collect();
    warnings.push(format!(
        "collinear terms are left out: every row has the same multiple of a simpler term: {}",
        equations.join(", ")
    ));
    let terms: Vec<usize> = multiples.iter().map(|m| m.term).collect();
    Ok(library.without(&terms))
}

/// All such terms of a library over columns in the order of `names`.
fn multiples(
    library: &Library,
    names: &[String],
    stretches: &[Stretch<'_>],
) -> Result<Vec<Multiple>, SindyError> {
    let p = library.len();
    let program = library.compile(names)?;
    let mut scratch = sindy_expr::Scratch::new();
    let mut value = vec![0.0; p];
    let rows: usize = stretches.iter().map(|s| s.time.len()).sum();
    let stride = rows.div_ceil(LOOKED_AT).max(1);
    let mut each = |stride: usize, take: &mut dyn FnMut(&[f64])| {
        for s in stretches {
            for row in (0..s.time.len()).step_by(stride) {
                let input: Vec<f64> = s.columns.iter().map(|c| c[row]).collect();
                program.eval_row(&input, &mut value, &mut scratch);
                take(&value);
            }
        }
    };
    // The factor to each earlier term, while all rows agree on it.
    let mut columns: Vec<Vec<f64>> = vec![Vec::new(); p];
    each(stride, &mut |theta| {
        columns.iter_mut().zip(theta).for_each(|(c, v)| c.push(*v));
    });
    let nowhere = |c: &Vec<f64>| !c.is_empty() && !c.iter().any(|v| v.is_finite());
    if let Some(j) = columns.iter().position(nowhere) {
        return Err(SindyError::setting(
            "library",
            "terms that are finite on the data",
            format!(
                "`{}`, which is finite on none of {} rows",
                library.names()[j],
                columns[j].len()
            ),
        ));
    }
    // Pairs that other rows refuted.
    let mut refuted: Vec<(usize, usize)> = Vec::new();
    loop {
        let found = candidates(&columns, &refuted);
        if stride == 1 || found.is_empty() {
            return Ok(found);
        }
        let mut holds = vec![true; found.len()];
        each(1, &mut |theta| {
            for (m, holds) in found.iter().zip(&mut holds) {
                *holds &= same(theta[m.term], m.factor * theta[m.of]);
            }
        });
        if holds.iter().all(|h| *h) {
            return Ok(found);
        }
        let wrong = found.iter().zip(&holds).filter(|(_, h)| !**h);
        refuted.extend(wrong.map(|(m, _)| (m.term, m.of)));
    }
}

/// Each term with the first before it that it is a multiple of, by the rows that are looked at.
fn candidates(columns: &[Vec<f64>], refuted: &[(usize, usize)]) -> Vec<Multiple> {
    let mut found: Vec<Multiple> = Vec::new();
    for j in 0..columns.len() {
        let twin = (0..j)
            .filter(|&i| !refuted.contains(&(j, i)) && !found.iter().any(|m| m.term == i))
            .find_map(|i| factor(&columns[j], &columns[i]).map(|factor| (i, factor)));
        if let Some((of, factor)) = twin {
            found.push(Multiple {
                term: j,
                of,
                factor,
            });
        }
    }
    found
}

/// The factor of `column` to `other`, if there is one and neither vanishes throughout.
fn factor(column: &[f64], other: &[f64]) -> Option<f64> {
    let (a, b) = column
        .iter()
        .zip(other)
        .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    let factor = a / b;
    let usable = factor.is_finite() && factor != 0.0;
    let all = || column.iter().zip(other).all(|(a, b)| same(*a, factor * b));
    (usable && all()).then_some(factor)
}

/// A factor as messages print it: six digits.
pub(super) fn rounded(factor: f64) -> f64 {
    format!("{factor:.5e}").parse().unwrap_or(factor)
}

fn same(a: f64, b: f64) -> bool {
    (a - b).abs() <= ROUNDING * a.abs().max(b.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_multiples_are_found_and_near_multiples_are_not() {
        let names: Vec<String> = ["x", "u"].map(String::from).into();
        let library = Library::polynomial(&["x", "u"], 3).unwrap();
        let time: Vec<f64> = (0..3000).map(f64::from).collect();
        let x: Vec<f64> = time.iter().map(|t| (0.01 * t).sin()).collect();
        let mut u: Vec<f64> = time
            .iter()
            .map(|t| if (0.3 * t).cos() < 0.0 { -2.0 } else { 2.0 })
            .collect();
        let found = |u: &[f64]| -> Vec<String> {
            let stretch = Stretch {
                trajectory: 0,
                time: &time,
                columns: vec![&x, u],
                weights: None,
                seen: Vec::new(),
            };
            let n = library.names();
            multiples(&library, &names, &[stretch])
                .unwrap()
                .iter()
                .map(|m| format!("{} = {} {}", n[m.term], m.factor, n[m.of]))
                .collect()
        };
        assert_eq!(found(&u), ["u^2 = 4 1", "x*u^2 = 4 x", "u^3 = 4 u"]);
        // One row in three thousand that is otherwise, and none of the rows that are looked at first.
        u[1501] = 2.1;
        assert!(found(&u).is_empty());
        // One row at which nothing is applied: u² is no constant there, but u³ is four times u still.
        u[1501] = 0.0;
        assert_eq!(found(&u), ["u^3 = 4 u"]);
        // Constant but for the seventh digit: little, but not nothing.
        let nearly: Vec<f64> = time.iter().map(|t| 2.0 + 1e-7 * t.sin()).collect();
        assert!(found(&nearly).is_empty());
        // Nothing is a multiple of nothing.
        let zero = vec![0.0; 3000];
        assert!(found(&zero).is_empty());
    }
}
