//! What is shown of columns and channels.

use touchdown_log::Inspection;

use crate::cli::identify::show;

/// The time base in half a line.
pub(super) fn time(inspection: &Inspection) -> String {
    let Some(t) = &inspection.time else {
        return String::new();
    };
    let steps = match (t.period_s, t.shortest_step_s, t.longest_step_s) {
        (Some(period), Some(shortest), Some(longest)) => format!(
            ", median step {} s ({} to {} s)",
            show::digits(period),
            show::digits(shortest),
            show::digits(longest)
        ),
        _ => String::new(),
    };
    format!(
        "; time base {:?}, {} s{steps}",
        t.column,
        show::digits(t.duration_s)
    )
}

/// A row a column.
pub(super) fn table(title: &str, inspection: &Inspection) -> (Vec<String>, Vec<Vec<String>>) {
    let names = [
        title, "unit", "values", "gaps", "rate Hz", "min", "median", "max", "note",
    ];
    let number = |v: Option<f64>| v.map_or_else(String::new, show::digits);
    let rows = inspection.columns.iter().map(|c| {
        let note = match (&c.text, c.constant, c.count) {
            (Some(text), ..) => format!("text, such as {text:?}"),
            (_, _, 0) => "empty".to_string(),
            (_, true, _) => "constant".to_string(),
            _ => String::new(),
        };
        vec![
            c.name.clone(),
            unit(c),
            c.count.to_string(),
            c.gaps.to_string(),
            number(c.rate_hz),
            number(c.min),
            number(c.median),
            number(c.max),
            note,
        ]
    });
    (names.map(String::from).into(), rows.collect())
}

/// The unit of a channel; of a foreign column only where its name is one of ours.
fn unit(column: &touchdown_log::ColumnSummary) -> String {
    match &column.unit {
        Some(unit) => unit.clone(),
        None if column.name == touchdown_trial::TIME_CHANNEL => "s".to_string(),
        None => match touchdown_trial::unit_of(&column.name) {
            touchdown_trial::Unit::Dimensionless => String::new(),
            unit => unit.symbol().to_string(),
        },
    }
}
