//! Values of a map's expressions, block by block.

use super::rows::Rows;
use super::{Map, Rule};
use crate::LogError;
use sindy_expr::{Expr, Program, Scratch};
use std::collections::HashSet;

/// Rows that are evaluated at once, for the processor's caches. The value affects only speed.
const BLOCK: usize = 4096;
/// The name under which expressions know the row's number.
const ROW: &str = "row";
/// The name under which expressions know the vehicle's mass.
const MASS: &str = "mass_kg";

/// Whether expressions know the name for any table.
pub(crate) fn is_known(map: &Map, name: &str) -> bool {
    name == ROW || (name == MASS && map.mass_kg().is_some())
}

/// The values of an expression, one for each row.
enum Input {
    Row,
    Mass,
    Column(usize),
}

/// Appends the rows to all channels in the map's order, then to the row filter if there is one. Columns that are not there yet begin
/// with these rows.
pub(super) fn evaluate(
    source: &mut dyn Rows,
    map: &Map,
    columns: &mut Vec<(String, Vec<f64>)>,
) -> Result<(), LogError> {
    let rules: Vec<&Rule> = map.channels.iter().chain(&map.keep).collect();
    // There is always one input, so that a constant expression knows its number of rows.
    let row = source.place(ROW).map_or(Input::Row, Input::Column);
    let mut inputs: Vec<(&str, Input)> = vec![(ROW, row)];
    let mut known = HashSet::from([ROW]);
    for rule in &rules {
        for name in rule.expr.variables() {
            if !known.insert(name) {
                continue;
            }
            let input = match source.place(name) {
                Some(place) => Input::Column(place),
                None if name == MASS && map.mass_kg().is_some() => Input::Mass,
                None => return Err(source.lacks(rule, name)),
            };
            inputs.push((name, input));
        }
    }
    let expressions: Vec<Expr> = rules.iter().map(|rule| rule.expr.clone()).collect();
    let names: Vec<&str> = inputs.iter().map(|(name, _)| *name).collect();
    let program = Program::compile(&expressions, &names).map_err(|error| LogError::MapValue {
        at: Box::new(rules[0].place.clone()),
        expected: "expressions over the table's columns".to_owned(),
        found: error.to_string(),
    })?;
    let rows = source.len();
    if columns.is_empty() {
        let column = |rule: &&Rule| (rule.channel.clone(), Vec::with_capacity(rows));
        columns.extend(rules.iter().map(column));
    }
    let mut blocks = vec![vec![0.0; BLOCK.min(rows)]; inputs.len()];
    let mut output = vec![0.0; BLOCK.min(rows) * columns.len()];
    let mut scratch = Scratch::new();
    for first in (0..rows).step_by(BLOCK) {
        let length = BLOCK.min(rows - first);
        for ((_, input), block) in inputs.iter().zip(&mut blocks) {
            let block = &mut block[..length];
            match *input {
                Input::Row => (first..)
                    .zip(block)
                    .for_each(|(row, value)| *value = source.row_number(row) as f64),
                Input::Mass => block.fill(map.mass_kg().unwrap_or(f64::NAN)),
                Input::Column(place) => source.fill(place, first, block),
            }
        }
        let given: Vec<&[f64]> = blocks.iter().map(|block| &block[..length]).collect();
        let output = &mut output[..length * columns.len()];
        program.eval_block(&given, output, &mut scratch);
        for ((_, column), values) in columns.iter_mut().zip(output.chunks_exact(length)) {
            column.extend_from_slice(values);
        }
    }
    Ok(())
}
