//! Long columns of a figure's description in few bytes.

use std::collections::HashMap;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

/// Columns of at most this many numbers stay plain: they are the ones that a reader looks up one by one. Twice as many
/// would save no more than 1 % of a page.
const PLAIN: usize = 256;
/// Steps between the ends of a column. A step is 0.01 pixels of a chart, so a zoom by 100 shows it.
const STEPS: u16 = u16::MAX - 1;
/// What is written for a gap.
const GAP: u16 = u16::MAX;

/// Replaces the long columns of all traces by `{ "low", "step", "packed" }`: 16-bit steps, little-endian, in base64.
/// Columns on logarithmic axes stay as they are, because equal steps would be coarse at their small end.
///
/// Curves of one figure share their times: a packed column that equals an earlier one becomes `{ "trace", "axis" }` of it.
pub(crate) fn pack(description: &mut Value) {
    let layout = description["layout"].take();
    let mut stored: HashMap<String, Value> = HashMap::new();
    let traces = description["data"].as_array_mut().into_iter().flatten();
    for (index, trace) in traces.enumerate() {
        for letter in ["x", "y"] {
            if on_log_axis(&layout, trace, letter) {
                continue;
            }
            let column = trace[letter].as_array();
            if let Some(packed) = column.and_then(|column| pack_column(column)) {
                let place = json!({ "trace": index, "axis": letter });
                trace[letter] = match stored.get(&packed.to_string()) {
                    Some(earlier) => earlier.clone(),
                    None => {
                        stored.insert(packed.to_string(), place);
                        packed
                    }
                };
            }
        }
    }
    description["layout"] = layout;
}

/// Replaces the long columns of any value: numbers as in [`pack`], lists of equally many numbers by `{ "columns" }`, names by
/// `{ "names", "of" }` with a column of their places in the list.
pub(crate) fn pack_rows(value: &mut Value) {
    match value {
        Value::Object(members) => members.values_mut().for_each(pack_rows),
        Value::Array(rows) => {
            if let Some(packed) = pack_column_of_rows(rows) {
                *value = packed;
            } else {
                rows.iter_mut().for_each(pack_rows);
            }
        }
        _ => {}
    }
}

fn pack_column_of_rows(rows: &[Value]) -> Option<Value> {
    let are = |kind: fn(&Value) -> bool| rows.iter().all(kind);
    if are(|v| v.is_number() || v.is_null()) {
        return pack_column(rows);
    }
    if are(Value::is_string) {
        let mut names: Vec<&Value> = Vec::new();
        let place = |name| {
            let known = names.iter().position(|n| *n == name);
            json!(known.unwrap_or_else(|| {
                names.push(name);
                names.len() - 1
            }))
        };
        let places: Vec<Value> = rows.iter().map(place).collect();
        return Some(json!({ "of": pack_column(&places)?, "names": names }));
    }
    let width = rows.first()?.as_array()?.len();
    let columns = (0..width).map(|k| {
        let column = rows
            .iter()
            .map(|row| row.as_array().filter(|r| r.len() == width)?.get(k).cloned());
        pack_column_of_rows(&column.collect::<Option<Vec<Value>>>()?)
    });
    Some(json!({ "columns": columns.collect::<Option<Vec<Value>>>()? }))
}

fn on_log_axis(layout: &Value, trace: &Value, letter: &str) -> bool {
    let axis = trace[format!("{letter}axis")].as_str().unwrap_or(letter);
    layout[axis.replacen(letter, &format!("{letter}axis"), 1)]["type"] == "log"
}

fn pack_column(column: &[Value]) -> Option<Value> {
    if column.len() <= PLAIN {
        return None;
    }
    let numbers = || column.iter().filter_map(Value::as_f64);
    let low = numbers().fold(f64::INFINITY, f64::min);
    let high = numbers().fold(f64::NEG_INFINITY, f64::max);
    let step = (high - low) / f64::from(STEPS);
    if !step.is_finite() {
        return None;
    }
    let code = |value: &Value| match value.as_f64() {
        // The quotient is between 0 and STEPS; a constant column has none.
        Some(number) if step > 0.0 => ((number - low) / step).round() as u16,
        Some(_) => 0,
        None => GAP,
    };
    let bytes: Vec<u8> = column.iter().flat_map(|v| code(v).to_le_bytes()).collect();
    Some(json!({ "low": low, "step": step, "packed": STANDARD.encode(bytes) }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_rows_and_names_are_packed_by_column_and_short_ones_stay() {
        let rows = |n: i32| -> Vec<Value> { (0..n).map(|i| json!([i, 2 * i])).collect() };
        let phases: Vec<Value> = (0..300).map(|i| json!(["wait", "land"][i / 200])).collect();
        let mut value = json!({ "few": rows(3), "many": rows(300), "phase": phases, "mass": 1.4 });
        pack_rows(&mut value);
        assert_eq!(value["few"], json!(rows(3)));
        assert_eq!(value["mass"], 1.4);
        let second = &value["many"]["columns"][1];
        assert_eq!(second["low"], 0.0);
        // 598 over the steps.
        assert!((second["step"].as_f64().unwrap() - 598.0 / 65_534.0).abs() < 1e-12);
        assert_eq!(value["phase"]["names"], json!(["wait", "land"]));
        let mut uneven: Value = (0..400).map(|k| json!(vec![1.0; 1 + k % 2])).collect();
        let before = uneven.clone();
        pack_rows(&mut uneven);
        assert_eq!(uneven, before, "rows of different lengths are no columns");
    }

    #[test]
    fn analytic_packed_columns_keep_ends_and_gaps() {
        let mut y: Vec<Value> = (0..=1000).map(|i| json!(f64::from(i) - 500.0)).collect();
        y[7] = Value::Null;
        let short = json!([1.0, 2.0]);
        let mut description = json!({
            "data": [
                { "x": y, "y": y, "xaxis": "x2", "yaxis": "y" },
                { "x": short, "y": short },
                { "x": short, "y": y },
            ],
            "layout": { "xaxis2": { "type": "log" }, "yaxis": { "type": "linear" } },
        });
        pack(&mut description);
        assert!(description["data"][0]["x"].is_array(), "logarithmic");
        assert_eq!(description["data"][1]["y"], short);
        let again = json!({ "trace": 0, "axis": "y" });
        assert_eq!(description["data"][2]["y"], again, "stored once");
        let column = &description["data"][0]["y"];
        let bytes = STANDARD.decode(column["packed"].as_str().unwrap()).unwrap();
        let codes: Vec<u16> = bytes
            .chunks(2)
            .map(|b| u16::from_le_bytes([b[0], b[1]]))
            .collect();
        assert_eq!((codes[0], codes[7], codes[1000]), (0, GAP, STEPS));
        let number = |k: usize| {
            column["low"].as_f64().unwrap() + column["step"].as_f64().unwrap() * f64::from(codes[k])
        };
        // Half a step of 1000 / 65 534.
        assert!((number(333) + 167.0).abs() < 0.008);
    }
}
