//! The vector fields that keep given invariants, as sums of candidate terms.
//!
//! With `k = (i, θ)` for the candidate θ in the equation of the state i, an invariant E is kept if
//!
//! ```text
//! Σ_i ∂E/∂x_i f_i = Σ_k ∂E/∂x_i(x) θ_k(x) ξ_k = 0     for all x
//! ```
//!
//! This is linear in ξ. Rows of the matrix `A` are points x, its columns are candidates, and the null space of `A` holds all
//! models that keep E. It is spanned by *circuits*: fields of which no term can be left out. Every model is a sum of circuits in
//! which no terms cancel; those of few equations are computed, and of more as many as span the space.
//!
//! Source of circuits: R. T. Rockafellar, "The elementary vectors of a subspace of R^N" (1969).

use nalgebra::{DMatrix, DVector};

/// A vector field: candidates (numbered equation by equation) with their factors. The first factor is 1.
pub(crate) type Field = Vec<(usize, f64)>;

/// Singular values (columns of unit length) below this count as zero: a hundred times the rounding of matrices of hundreds of
/// columns, which leaves up to 1e-14.
const ZERO: f64 = 1e-12;
/// The smallest singular value that counts as none must lie above this, or the dimension of the null space is not certain.
/// In the tests it is 1e-5 and more.
const CERTAIN: f64 = 1e-9;
/// Entries of a circuit below this, columns of unit length, are rounding. A field without a term that is needed breaks [`KEPT`].
const ROUNDING: f64 = 1e-10;
/// Change of an invariant by a field, as a share of its largest part, above which the field does not keep it.
const KEPT: f64 = 1e-12;
/// A field of which others leave less than this share depends on them. The product of rounding and the condition of a basis of
/// circuits is far below.
const DEPENDENT: f64 = 1e-8;
/// Fields above which those that depend on simpler ones are left out: the time of a search grows as the cube of their number.
const MOST_FIELDS: usize = 400;
/// Equations that circuits are looked for in, at most, before all together: their number of combinations grows as its power.
const TOGETHER: usize = 3;

/// Why there is no basis.
#[derive(Debug, PartialEq)]
pub(super) enum NoFields {
    /// No combination but zero keeps the invariants.
    Empty,
    /// The dimension is not certain: candidates depend on each other too nearly.
    Unclear,
}

/// Fields whose combinations are all those that keep the invariants and the relations, those of few terms first. There may be more than
/// the dimension: a model that is one field of two equations is then not made of others that cancel each other in a third. `changes` has
/// a row for each point and invariant, `relations` one for each relation, and both a column for each candidate; `equations` holds the
/// candidates of each equation.
pub(super) fn conserving(
    changes: &DMatrix<f64>,
    relations: &DMatrix<f64>,
    equations: &[Vec<usize>],
) -> Result<Vec<Field>, NoFields> {
    let candidates = changes.ncols();
    let rows = changes.nrows() + relations.nrows();
    // As many rows as columns at least: a decomposition has no more directions than rows.
    let mut unit = DMatrix::zeros(rows.max(candidates), candidates);
    unit.rows_mut(0, changes.nrows()).copy_from(changes);
    unit.rows_mut(changes.nrows(), relations.nrows())
        .copy_from(relations);
    let length: Vec<f64> = unit.column_iter().map(|c| c.norm()).collect();
    for (mut column, length) in unit.column_iter_mut().zip(&length) {
        if *length > 0.0 {
            column /= *length;
        }
    }
    let all: Vec<usize> = (0..candidates).collect();
    let dimension = null_space(&unit, &all)?.nrows();
    if dimension == 0 {
        return Err(NoFields::Empty);
    }
    let mut pool: Vec<Field> = Vec::new();
    let mut rank = 0;
    for size in 1..=equations.len() {
        // Above three equations of many, all together.
        let every = size == equations.len() || size > TOGETHER;
        let sets = match every {
            true => vec![(0..equations.len()).collect()],
            false => combinations(equations.len(), size),
        };
        for set in sets {
            let columns: Vec<usize> = set.iter().flat_map(|&i| equations[i].clone()).collect();
            pool.extend(circuits(&unit, &columns)?);
        }
        let terms = |f: &Field| f.iter().map(|(j, _)| *j).collect::<Vec<_>>();
        pool.sort_by_key(|f| (f.len(), terms(f)));
        pool.dedup_by_key(|f| terms(f));
        rank = independent(&pool, candidates).len();
        // Fields of pairs always: they are the simplest that keep one invariant.
        if every || (rank == dimension && size > 1) {
            break;
        }
    }
    if rank < dimension {
        return Err(NoFields::Unclear);
    }
    if pool.len() > MOST_FIELDS {
        pool = independent(&pool, candidates);
    }
    // In one equation alone an invariant that depends on its state is kept by nothing: candidates that depend on each other.
    let is_zero = |f: &Field| {
        let own = equations.iter().find(|own| own.contains(&f[0].0));
        let alone = own.is_some_and(|own| f.iter().all(|(j, _)| own.contains(j)));
        alone && f.iter().all(|(j, _)| changes.column(*j).amax() > 0.0)
    };
    pool.retain(|f| !is_zero(f));
    match pool.is_empty() {
        true => Err(NoFields::Empty),
        false => Ok(pool.iter().map(|f| scaled(f, &length)).collect()),
    }
}

/// All sets of `size` of the numbers below `n`.
fn combinations(n: usize, size: usize) -> Vec<Vec<usize>> {
    let mut sets: Vec<Vec<usize>> = vec![Vec::new()];
    for _ in 0..size {
        let longer = |set: &Vec<usize>| {
            let next = set.last().map_or(0, |last| last + 1);
            let with = |i| set.iter().copied().chain([i]).collect();
            (next..n).map(with).collect::<Vec<Vec<usize>>>()
        };
        sets = sets.iter().flat_map(longer).collect();
    }
    sets
}

/// An orthonormal basis of the null space of these columns, in rows.
fn null_space(unit: &DMatrix<f64>, columns: &[usize]) -> Result<DMatrix<f64>, NoFields> {
    let own = unit.select_columns(columns);
    let decomposed = own.svd(false, true);
    let v_t = decomposed.v_t.ok_or(NoFields::Unclear)?;
    let values = decomposed.singular_values;
    let is_zero = |j: &usize| values[*j] <= ZERO;
    let rows: Vec<usize> = (0..columns.len()).filter(is_zero).collect();
    let kept = values.iter().filter(|v| **v > ZERO);
    match kept.fold(f64::INFINITY, |least, v| least.min(*v)) < CERTAIN {
        true => Err(NoFields::Unclear),
        false => Ok(v_t.select_rows(&rows)),
    }
}

/// Circuits among these columns, for columns of unit length: rows of the null space, reduced with pivots in several orders. Each row
/// lacks the pivots of all others.
fn circuits(unit: &DMatrix<f64>, columns: &[usize]) -> Result<Vec<Field>, NoFields> {
    if columns.is_empty() {
        return Ok(Vec::new());
    }
    let space = null_space(unit, columns)?;
    if space.nrows() == 0 {
        return Ok(Vec::new());
    }
    let forward: Vec<usize> = (0..columns.len()).collect();
    let backward: Vec<usize> = forward.iter().rev().copied().collect();
    let mut out = Vec::new();
    for order in [backward, forward] {
        for row in reduced(space.clone(), &order).row_iter() {
            let entries = row.iter().zip(columns).filter(|(v, _)| **v != 0.0);
            let mut field: Field = entries.map(|(v, j)| (*j, *v)).collect();
            field.sort_unstable_by_key(|(j, _)| *j);
            out.extend(refined(unit, &field));
        }
    }
    Ok(out)
}

/// The same field with all its digits, from its own columns alone; `None` if it does not keep the invariants.
fn refined(unit: &DMatrix<f64>, field: &Field) -> Option<Field> {
    let columns: Vec<usize> = field.iter().map(|(j, _)| *j).collect();
    let own = unit.select_columns(&columns);
    let decomposed = own.clone().svd(false, true);
    let (v_t, values) = (decomposed.v_t?, decomposed.singular_values);
    let (least, value) = values.argmin();
    let vector = v_t.row(least).transpose();
    let whole = value <= KEPT && (own * &vector).amax() <= KEPT;
    let needed = |(_, v): &(usize, f64)| v.abs() > ROUNDING;
    let entries = columns.into_iter().zip(vector.iter().copied());
    whole.then(|| entries.filter(needed).collect())
}

/// Of the fields in their order those that do not depend on fields before them.
fn independent(pool: &[Field], size: usize) -> Vec<Field> {
    let mut directions: Vec<DVector<f64>> = Vec::new();
    let mut is_new = |field: &&Field| {
        let mut vector = DVector::zeros(size);
        field.iter().for_each(|&(j, v)| vector[j] = v);
        let before = vector.norm();
        // Twice: what rounding leaves of the first time.
        for _ in 0..2 {
            for direction in &directions {
                let along = vector.dot(direction);
                vector.axpy(-along, direction, 1.0);
            }
        }
        let left = vector.norm();
        let new = left > DEPENDENT * before;
        if new {
            directions.push(vector / left);
        }
        new
    };
    pool.iter().filter(|f| is_new(f)).cloned().collect()
}

/// A field in the units of the data, its first factor 1.
fn scaled(field: &Field, length: &[f64]) -> Field {
    let factor = |j: usize, v: f64| match length[j] > 0.0 {
        true => v / length[j],
        false => v,
    };
    let first = field.first().map_or(1.0, |&(j, v)| factor(j, v));
    let of = |&(j, v): &(usize, f64)| (j, factor(j, v) / first);
    field.iter().map(of).collect()
}

/// Gauss and Jordan's elimination with pivots in the columns of `order`, as far as there are rows.
fn reduced(mut rows: DMatrix<f64>, order: &[usize]) -> DMatrix<f64> {
    let mut done = 0;
    for &column in order {
        if done == rows.nrows() {
            break;
        }
        let pivot = done
            + rows
                .view((done, column), (rows.nrows() - done, 1))
                .column(0)
                .iamax();
        let size = rows.row(pivot).amax();
        if rows[(pivot, column)].abs() <= ROUNDING * size {
            continue;
        }
        rows.swap_rows(done, pivot);
        let scale = rows[(done, column)];
        rows.row_mut(done).scale_mut(1.0 / scale);
        let own = rows.row(done).into_owned();
        for other in (0..rows.nrows()).filter(|r| *r != done) {
            let by = rows[(other, column)];
            let mut row = rows.row_mut(other);
            row -= by * &own;
            row[column] = 0.0;
        }
        done += 1;
    }
    for mut row in rows.row_iter_mut() {
        let size = row.amax();
        row.apply(|v| {
            if v.abs() <= ROUNDING * size {
                *v = 0.0;
            }
        });
    }
    rows
}
