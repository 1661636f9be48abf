//! A report: blocks of text, tables and figures in reading order.

use std::path::Path;

use crate::figure::Figure;
use crate::plotly_json::Place;
use crate::table::Table;
use crate::{Result, files, html};

/// A report in the making. Every call adds a block below the last one.
///
/// Text is plain, apart from two marks: `` `code` `` and `**strong**`. Everything else is shown as written.
///
/// | call | what it adds |
/// | --- | --- |
/// | [`section`](Self::section), [`subsection`](Self::subsection) | a heading, listed in the table of contents |
/// | [`paragraph`](Self::paragraph), [`list`](Self::list), [`code`](Self::code), [`callout`](Self::callout) | text |
/// | [`highlights`](Self::highlights) | a row of key numbers |
/// | [`table`](Self::table) | a table, numbered `Table 1`, … |
/// | [`figure`](Self::figure) | an interactive figure, numbered `Figure 1`, … |
///
/// The report is one HTML file without references to anything outside: figures can be zoomed and hovered offline,
/// and stand as plain pictures on paper and where scripts are off.
#[derive(Debug, Clone)]
pub struct Report {
    pub(crate) title: String,
    pub(crate) subtitle: String,
    pub(crate) facts: Vec<(String, String)>,
    pub(crate) blocks: Vec<Block>,
}

/// How much a remark matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Callout {
    /// Good to know.
    Note,
    /// It went as hoped.
    Success,
    /// Read before relying on the result.
    Warning,
    /// Something is wrong.
    Failure,
}

#[derive(Debug, Clone)]
pub(crate) enum Block {
    Section(String),
    Subsection(String),
    Paragraph(String),
    List(Vec<String>),
    Code(String),
    Callout(Callout, String),
    Highlights(Vec<[String; 3]>),
    Table(Table),
    Figure(Box<Drawn>),
}

/// A figure as the page needs it.
#[derive(Debug, Clone)]
pub(crate) struct Drawn {
    pub(crate) figure: Figure,
    pub(crate) still: String,
    pub(crate) live: String,
    pub(crate) places: Vec<Vec<Place>>,
    pub(crate) height_px: u64,
}

impl Report {
    /// An empty report.
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            subtitle: String::new(),
            facts: Vec::new(),
            blocks: Vec::new(),
        }
    }

    /// Sets the line below the title.
    pub fn subtitle(&mut self, subtitle: impl Into<String>) -> &mut Self {
        self.subtitle = subtitle.into();
        self
    }

    /// Adds a name and a value to the head of the report: version, seed, date, file.
    pub fn fact(&mut self, name: impl Into<String>, value: impl Into<String>) -> &mut Self {
        self.facts.push((name.into(), value.into()));
        self
    }

    /// Begins a section.
    pub fn section(&mut self, title: impl Into<String>) -> &mut Self {
        self.push(Block::Section(title.into()))
    }

    /// Begins a part of a section.
    pub fn subsection(&mut self, title: impl Into<String>) -> &mut Self {
        self.push(Block::Subsection(title.into()))
    }

    /// Adds a paragraph.
    pub fn paragraph(&mut self, text: impl Into<String>) -> &mut Self {
        self.push(Block::Paragraph(text.into()))
    }

    /// Adds a bulleted list.
    pub fn list<S: Into<String>>(&mut self, items: impl IntoIterator<Item = S>) -> &mut Self {
        self.push(Block::List(items.into_iter().map(Into::into).collect()))
    }

    /// Adds text as it would stand in a file, in letters of equal width.
    pub fn code(&mut self, text: impl Into<String>) -> &mut Self {
        self.push(Block::Code(text.into()))
    }

    /// Adds a remark that stands out.
    pub fn callout(&mut self, kind: Callout, text: impl Into<String>) -> &mut Self {
        self.push(Block::Callout(kind, text.into()))
    }

    /// Adds a row of key numbers, each a name, a value with its unit, and a remark (may be empty).
    pub fn highlights<S: Into<String>>(
        &mut self,
        items: impl IntoIterator<Item = [S; 3]>,
    ) -> &mut Self {
        self.push(Block::Highlights(
            items.into_iter().map(|item| item.map(Into::into)).collect(),
        ))
    }

    /// Adds a table.
    ///
    /// # Errors
    /// When a row has another number of cells than there are columns.
    pub fn table(&mut self, table: Table) -> Result<&mut Self> {
        table.check()?;
        Ok(self.push(Block::Table(table)))
    }

    /// Adds a figure, drawn at once: later changes of `figure` do not show.
    ///
    /// # Errors
    /// As [`Figure::svg`].
    pub fn figure(&mut self, figure: &Figure) -> Result<&mut Self> {
        let number = self
            .blocks
            .iter()
            .filter(|b| matches!(b, Block::Figure(_)))
            .count()
            + 1;
        let described = figure.describe()?;
        let drawn = Drawn {
            still: figure.inline_svg(&format!("f{number}-"))?,
            height_px: described.value["layout"]["height"].as_u64().unwrap_or(420),
            live: described.value.to_string(),
            places: described.places,
            // Only names and styles are needed from here on: the data are in the pictures.
            figure: without_data(figure),
        };
        Ok(self.push(Block::Figure(Box::new(drawn))))
    }

    /// The whole page.
    pub fn html(&self) -> String {
        html::page(self)
    }

    /// Writes the page, whole or not at all.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn write(&self, path: impl AsRef<Path>) -> Result<()> {
        files::write_atomic(path.as_ref(), self.html().as_bytes())
    }

    fn push(&mut self, block: Block) -> &mut Self {
        self.blocks.push(block);
        self
    }
}

fn without_data(figure: &Figure) -> Figure {
    let mut figure = figure.clone();
    for series in figure.panels.iter_mut().flat_map(|panel| &mut panel.series) {
        series.x = Vec::new();
        series.y = Vec::new();
    }
    figure
}
