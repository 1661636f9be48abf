//! What the data identify, before anything is fitted.

use std::borrow::Borrow;

use touchdown_report::{Cell, Table};

use crate::error::Result;
use crate::experiments::ground_effect::{DataSet, GroundEffectExperiment};
use touchdown_pages::page::{Page, show};

pub(super) fn write(page: &mut Page, ge: &GroundEffectExperiment) -> Result<()> {
    page.report
        .subsection("Before the fit: what the data can identify");
    let yes = |b: bool| Cell::text(if b { "yes" } else { "no" });
    let row = |what: &str, cell: &dyn Fn(&DataSet) -> Cell| {
        let mut row = vec![Cell::text(what)];
        row.extend(ge.sets.iter().map(cell));
        row
    };
    let groups = |set: &DataSet| {
        let groups = &set.before.library.collinear;
        let shown = groups
            .iter()
            .map(|(condition, terms)| format!("{} ({})", terms.join(", "), show(*condition, 0)));
        Cell::text(if groups.is_empty() {
            "none".to_string()
        } else {
            shown.collect::<Vec<_>>().join("; ")
        })
    };
    let quiet = |set: &DataSet| {
        let inputs = set.before.library.inputs.iter();
        let names: Vec<&str> = inputs
            .filter(|i| i.hardly_excited)
            .map(|i| i.name.as_str())
            .collect();
        names_or_none(&names)
    };
    let mut table = Table::new("Identifiability.").text_column("Question");
    for set in &ge.sets {
        table = table.text_column(title(set));
    }
    let table = table
        .row(row("trials", &|s| Cell::count(s.recorded.len())))
        .row(row("rows of the library of eq. (9)", &|s| Cell::count(s.before.library.rows)))
        .row(row("its condition, columns scaled", &|s| Cell::number(s.before.library.condition, 0)))
        .row(row("terms that trade off against each other (condition)", &groups))
        .row(row("terms that are zero throughout the data, removed", &|s| names_or_none(&s.before.left_out)))
        .row(row("inputs that were hardly excited", &quiet))
        .row(row("variance inflation of the lag by the deck's velocity", &|s| {
            Cell::number(s.before.lag_inflation, 1)
        }))
        .row(row("lag and deck velocity confounded", &|s| yes(s.before.confounded)))
        .row(row("apparent delay of the force behind its static value [s]", &|s| {
            Cell::maybe(s.before.force_delay_s, 3)
        }))
        .note("Confounded from a variance inflation of 10, judged at a lag of 0.2 s. The apparent delay holds dead time and lag together.");
    page.table(table)?;
    page.folded_tables("Inputs of eq. (9)", vec![input_table(ge)])?;
    for set in &ge.sets {
        if !set.before.advice.is_empty() {
            page.text(format!(
                "What to record, after the {}:",
                title(set).to_lowercase()
            ));
            page.report
                .list(set.before.advice.iter().map(|a| sentence(&a.to_string())));
        }
    }
    Ok(())
}

/// Names with commas between them.
fn names_or_none<S: Borrow<str>>(names: &[S]) -> Cell {
    Cell::text(if names.is_empty() {
        "none".to_string()
    } else {
        names.join(", ")
    })
}

/// Mean, scatter and range of every input of eq. (9).
fn input_table(ge: &GroundEffectExperiment) -> Table {
    let mut inputs = Table::new("Inputs of eq. (9).")
        .text_column("Data")
        .text_column("Input")
        .number_column("Mean", "")
        .number_column("Standard deviation", "")
        .number_column("Least", "")
        .number_column("Largest", "");
    for set in &ge.sets {
        for i in &set.before.library.inputs {
            inputs = inputs.row([
                title(set).into(),
                i.name.as_str().into(),
                Cell::number(i.mean, 3),
                Cell::number(i.sd, 3),
                Cell::number(i.min, 3),
                Cell::number(i.max, 3),
            ]);
        }
    }
    inputs
}

/// What a data set is called.
pub(super) fn title(set: &DataSet) -> &'static str {
    if set.name == "paper_data" {
        "Paper's data"
    } else {
        "Rich data"
    }
}

/// With a capital and a full stop.
fn sentence(text: &str) -> String {
    let mut rest = text.chars();
    let first = rest.next().map(char::to_uppercase);
    first
        .into_iter()
        .flatten()
        .chain(rest)
        .chain(['.'])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn prop_sentences_begin_and_end() {
        assert_eq!(sentence("äb c"), "Äb c.");
        assert_eq!(sentence("`x` moved"), "`x` moved.");
    }
}
