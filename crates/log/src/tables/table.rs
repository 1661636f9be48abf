/// A table of a file: named columns of numbers, without conversion.
#[derive(Debug, Clone)]
pub struct Table {
    pub(crate) path: String,
    pub(crate) sha256: String,
    /// The size of the file.
    pub(crate) bytes: u64,
    pub(crate) row_numbers: Vec<usize>,
    pub(crate) columns: Vec<Column>,
    /// Names of all columns of the file, also of those that were not asked for.
    pub(crate) names: Vec<String>,
}

/// One column of a [`Table`].
#[derive(Debug, Clone)]
pub struct Column {
    pub(crate) name: String,
    pub(crate) kind: ColumnKind,
    /// Its cell in a row of units.
    pub(crate) unit: Option<String>,
    pub(crate) values: Vec<f64>,
}

/// Type of a column.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub enum ColumnKind {
    /// Numbers in the source's unit; NaN is a gap. A column of empty cells counts as numbers.
    Number,
    /// Date-time stamps, turned into seconds from the first.
    Stamp,
    /// Text; there are no values.
    Text {
        /// One of the cells.
        example: String,
    },
}

impl Table {
    /// The path by which the file was opened.
    #[must_use]
    pub fn path(&self) -> &str {
        &self.path
    }

    /// SHA-256 of the file's bytes in lower-case hexadecimal.
    #[must_use]
    pub fn sha256(&self) -> &str {
        &self.sha256
    }

    /// Number of rows.
    #[must_use]
    pub fn len(&self) -> usize {
        self.row_numbers.len()
    }

    /// Whether there is no row. A table from a reader has at least one.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.row_numbers.is_empty()
    }

    /// For each row its number in the file, from 0; rows that were dropped leave a step.
    #[must_use]
    pub fn row_numbers(&self) -> &[usize] {
        &self.row_numbers
    }

    /// The columns in the file's order.
    #[must_use]
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// The column of this name.
    #[must_use]
    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }
}

impl Column {
    /// The name in the header, without the spaces around it.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The column's type.
    #[must_use]
    pub fn kind(&self) -> &ColumnKind {
        &self.kind
    }

    /// The unit that a row of units below the header states, as it is written there.
    #[must_use]
    pub fn unit(&self) -> Option<&str> {
        self.unit.as_deref()
    }

    /// One value for each row, NaN for a gap. For a column of text all are NaN.
    #[must_use]
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Whether the column holds text.
    #[must_use]
    pub fn is_text(&self) -> bool {
        matches!(self.kind, ColumnKind::Text { .. })
    }
}
