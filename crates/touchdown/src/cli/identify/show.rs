//! Tables of fits as text for a terminal.

use touchdown_identify::forms::FormScore;
use touchdown_pages::identify::summary::Summary;
pub(crate) use touchdown_pages::identify::summary::{csv, digits, form};
use touchdown_terminal::escape;

/// The summary of fits. Coefficients are left out where there are too many of them for a line; of the remarks the first
/// words stand there, the rest went to standard error.
pub(super) fn summary(of: &Summary) -> String {
    const MOST_COLUMNS: usize = 13;
    let last = of.header.len() - 1;
    let wide = of.header.len() > MOST_COLUMNS;
    let keep = |i: usize| !wide || i < 2 || i + 5 >= of.header.len();
    let pick = |row: &[String]| -> Vec<String> {
        row.iter()
            .enumerate()
            .filter(|(i, _)| keep(*i))
            .map(|(i, cell)| {
                if i == last {
                    shortened(cell)
                } else {
                    cell.clone()
                }
            })
            .collect()
    };
    let rows: Vec<Vec<String>> = of.rows.iter().map(|r| pick(r)).collect();
    text_table(&pick(&of.header), &rows)
}

/// The forms that were tried, as text for a terminal.
pub(crate) fn forms(scores: &[FormScore]) -> String {
    let header = FORMS_HEADER.map(String::from);
    let rows: Vec<Vec<String>> = scores.iter().map(form_row).collect();
    text_table(&header, &rows)
}

/// Columns of the table of forms.
const FORMS_HEADER: [&str; 6] = [
    "form",
    "parameters",
    "held-out RMSE (N)",
    "standard error (N)",
    "chosen",
    "why not",
];

fn form_row(score: &FormScore) -> Vec<String> {
    let number = |v: Option<f64>| v.map_or_else(|| "–".to_string(), digits);
    vec![
        score.name(),
        score.parameters.to_string(),
        number(score.held_out_rmse_n),
        number(score.std_error_n),
        if score.chosen { "yes" } else { "" }.to_string(),
        score
            .error
            .clone()
            .map_or_else(String::new, |e| shortened(&e)),
    ]
}

/// The first line of a remark, at most 60 letters.
fn shortened(text: &str) -> String {
    const MOST: usize = 60;
    let line = text.lines().next().unwrap_or_default();
    if line.chars().count() <= MOST && !text.contains('\n') {
        return line.to_string();
    }
    let cut: String = line.chars().take(MOST).collect();
    format!("{}…", cut.trim_end())
}

/// Columns side by side: numbers at the right, words at the left.
pub(crate) fn text_table(header: &[String], rows: &[Vec<String>]) -> String {
    // A cell may be a name from a file, and stays in its row.
    let shown = |cells: &[String]| -> Vec<String> {
        let cells = cells.iter().map(|cell| escape::line(cell).into_owned());
        cells.collect()
    };
    let header = &shown(header)[..];
    let rows: Vec<Vec<String>> = rows.iter().map(|row| shown(row)).collect();
    let length = |cell: &String| cell.chars().count();
    let widths: Vec<usize> = (0..header.len())
        .map(|i| {
            rows.iter()
                .filter_map(|r| r.get(i))
                .chain([&header[i]])
                .map(length)
                .max()
                .unwrap_or(0)
        })
        .collect();
    let number = |cell: &String| cell.is_empty() || cell == "–" || cell.parse::<f64>().is_ok();
    let right: Vec<bool> = (0..header.len())
        .map(|i| !rows.is_empty() && rows.iter().filter_map(|r| r.get(i)).all(number))
        .collect();
    let line = |cells: &[String]| {
        let mut out = String::new();
        for (i, cell) in cells.iter().enumerate() {
            let pad = " ".repeat(widths[i].saturating_sub(length(cell)));
            if right[i] {
                out.push_str(&pad);
                out.push_str(cell);
            } else {
                out.push_str(cell);
                out.push_str(&pad);
            }
            out.push_str("  ");
        }
        out.trim_end().to_string()
    };
    let mut lines = vec![line(header)];
    lines.extend(rows.iter().map(|r| line(r)));
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_cells_are_quoted_and_aligned() {
        let header = ["a".to_string(), "b".to_string()];
        let rows = [vec!["x,\"y\"".to_string(), "1.5".to_string()]];
        assert_eq!(csv(&header, &rows), "a,b\n\"x,\"\"y\"\"\",1.5\n");
        assert_eq!(text_table(&header, &rows), "a        b\nx,\"y\"  1.5");
    }
}
