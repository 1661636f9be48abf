//! Coefficients side by side.

use touchdown_model::{Card, published};
use touchdown_report::{Cell, Table};

use crate::error::Result;

/// One column of a table of coefficients.
pub(super) struct Column<'a> {
    pub(super) title: &'a str,
    pub(super) card: &'a Card,
}

/// One row for each term that any of the cards has; half the 95 % interval after ±.
pub(super) fn table(caption: &str, columns: &[Column<'_>]) -> Table {
    let mut rows: Vec<(&str, &str)> = Vec::new();
    for term in columns.iter().flat_map(|c| &c.card.terms) {
        let row = (term.of.as_str(), term.expression.as_str());
        if !rows.contains(&row) {
            rows.push(row);
        }
    }
    let mut table = Table::new(caption).text_column("Part").text_column("Term");
    for column in columns {
        table = table.number_column(column.title, "");
    }
    for (of, expression) in rows {
        let mut cells = vec![Cell::text(of), Cell::text(expression)];
        for column in columns {
            let term = column
                .card
                .terms
                .iter()
                .find(|t| t.of == of && t.expression == expression);
            cells.push(term.map_or_else(Cell::missing, |t| {
                let half = t.ci95.map_or(f64::NAN, |[low, high]| 0.5 * (high - low));
                let decimals = decimals(if half.is_finite() { half } else { t.value });
                Cell::plus_minus(t.value, half, decimals)
            }));
        }
        table = table.row(cells);
    }
    table
}

/// Decimals that leave two digits of an uncertainty, at least three.
fn decimals(error: f64) -> usize {
    if error > 0.0 && error < 0.01 {
        (1.0 - error.log10().floor()).clamp(3.0, 6.0) as usize
    } else {
        3
    }
}

/// Eq. (11) as printed.
pub(super) fn eq_11() -> Result<Card> {
    Ok(Card::parse(published::EQ_11, "paper-eq11.toml")?)
}

/// Eq. (12) as printed.
pub(super) fn eq_12() -> Result<Card> {
    Ok(Card::parse(published::EQ_12, "paper-eq12.toml")?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_two_digits_of_the_error_are_shown() {
        // 0.0086: two digits are four decimals.
        assert_eq!(
            [decimals(0.0086), decimals(0.27), decimals(0.00012)],
            [4, 3, 5]
        );
    }

    #[test]
    fn prop_every_term_of_every_card_has_one_row() {
        let (a, b) = (eq_11().unwrap(), eq_12().unwrap());
        let columns = [
            Column {
                title: "a",
                card: &a,
            },
            Column {
                title: "b",
                card: &b,
            },
        ];
        assert_eq!(
            table("t", &columns).rows.len(),
            a.terms.len() + b.terms.len()
        );
    }
}
