//! A report: blocks of text, tables and figures in reading order.

use crate::Result;
use crate::chart::Chart;
use crate::figure::Figure;
use crate::scene::{Player, Scene};
use crate::table::Table;
use crate::words::Term;

/// A report in the making. Every call adds a block below the last one.
///
/// Text is plain, apart from two marks: `` `code` `` and `**strong**`. Everything else is shown as written.
///
/// | call | what it adds |
/// | --- | --- |
/// | [`verdict`](Self::verdict) | the result in a sentence or two, above all else |
/// | [`section`](Self::section), [`subsection`](Self::subsection) | a heading, listed in the table of contents |
/// | [`paragraph`](Self::paragraph), [`list`](Self::list), [`code`](Self::code), [`callout`](Self::callout) | text |
/// | [`highlights`](Self::highlights) | a row of key numbers |
/// | [`table`](Self::table) | a table, numbered `Table 1`, … |
/// | [`figure`](Self::figure) | an interactive figure, numbered `Figure 1`, … |
/// | [`scene`](Self::scene) | landings to watch in three dimensions, numbered as figures |
/// | [`folded`](Self::folded) | blocks behind a line that a click unfolds |
///
/// The report is one HTML file without references to anything outside. Its figures can be zoomed and hovered offline,
/// and printed as they stand. [`glossary`](Self::glossary) gives the terms that the page explains at their first use.
#[derive(Debug, Clone)]
pub struct Report {
    pub(crate) title: String,
    pub(crate) subtitle: String,
    pub(crate) facts: Vec<(String, String)>,
    pub(crate) terms: &'static [Term],
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
    Figure(Box<Chart>),
    Scene(Box<Player>),
    Verdict(Callout, String),
    FoldBegin(String),
    FoldEnd,
}

impl Report {
    /// An empty report.
    pub fn new(title: impl Into<String>) -> Self {
        Self {
            title: title.into(),
            subtitle: String::new(),
            facts: Vec::new(),
            terms: &[],
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

    /// Sets the terms that the page explains where each first stands. Text inside folds explains none.
    pub fn glossary(&mut self, terms: &'static [Term]) -> &mut Self {
        self.terms = terms;
        self
    }

    /// Adds the result in a sentence or two. It belongs above all other blocks.
    pub fn verdict(&mut self, kind: Callout, text: impl Into<String>) -> &mut Self {
        self.push(Block::Verdict(kind, text.into()))
    }

    /// Adds what `fill` adds, folded away behind the line `summary`.
    ///
    /// # Errors
    /// Those of `fill`.
    pub fn folded<E>(
        &mut self,
        summary: impl Into<String>,
        fill: impl FnOnce(&mut Self) -> std::result::Result<(), E>,
    ) -> std::result::Result<&mut Self, E> {
        self.push(Block::FoldBegin(summary.into()));
        fill(self)?;
        Ok(self.push(Block::FoldEnd))
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
        Ok(self.push(Block::Figure(Box::new(Chart::of(figure)?))))
    }

    /// Adds landings to watch.
    ///
    /// # Errors
    /// An id that holds anything but letters, digits, `-` and `_`.
    pub fn scene(&mut self, scene: Scene) -> Result<&mut Self> {
        Ok(self.push(Block::Scene(Box::new(Player::of(scene)?))))
    }

    fn push(&mut self, block: Block) -> &mut Self {
        self.blocks.push(block);
        self
    }
}
