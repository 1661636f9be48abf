//! Lines of a table (CSV, RFC 4180).

/// Appends a line of cells, those with commas, quotes or ends of lines in quotes.
pub fn line<S: AsRef<str>>(out: &mut String, cells: impl IntoIterator<Item = S>) {
    for (i, cell) in cells.into_iter().enumerate() {
        let cell = cell.as_ref();
        if i > 0 {
            out.push(',');
        }
        if cell.contains([',', '"', '\n', '\r']) {
            out.push('"');
            out.push_str(&cell.replace('"', "\"\""));
            out.push('"');
        } else {
            out.push_str(cell);
        }
    }
    out.push('\n');
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_cells_that_would_not_stay_one_are_quoted() {
        let mut out = String::new();
        line(&mut out, ["a", "b, \"c\"", "", "d\re"]);
        line(&mut out, [String::from("f\ng")]);
        assert_eq!(out, "a,\"b, \"\"c\"\"\",,\"d\re\"\n\"f\ng\"\n");
    }
}
