//! What a figure is: panels of series.

use crate::color::Color;

/// One picture: stacked panels with a title.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    /// File stem and anchor: ASCII letters, digits, `-` and `_`.
    pub id: String,
    /// One line, drawn above the panels.
    pub title: String,
    /// What to see, for the report and for readers that hear instead of see.
    pub caption: String,
    /// From top to bottom.
    pub panels: Vec<Panel>,
    /// Width in CSS pixels, 240 to 4000.
    pub width_px: u32,
    /// Height in CSS pixels, at most 8000; `None` gives every panel a comfortable height.
    /// The picture grows where panels would otherwise be lower than 48 px.
    pub height_px: Option<u32>,
    /// One x axis for all panels: same range, labelled once, below the last panel.
    pub share_x: bool,
}

/// One pair of axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Short title above the panel.
    pub title: Option<String>,
    /// Label of the horizontal axis, with the unit: `Time (s)`.
    pub x_label: String,
    /// Label of the vertical axis, with the unit.
    pub y_label: String,
    /// Drawn in this order, bands first.
    pub series: Vec<Series>,
    /// Limits of x; `None` fits the data. With a shared x, the first panel that has limits decides.
    pub x_range: Option<(f64, f64)>,
    /// Limits of y; `None` fits the data within the limits of x.
    pub y_range: Option<(f64, f64)>,
    /// Logarithmic x; values that are not positive are gaps.
    pub log_x: bool,
    /// Logarithmic y; values that are not positive are gaps.
    pub log_y: bool,
    /// One unit of x is as long as one unit of y (trajectories seen from above). Needs an x that is not shared
    /// and linear axes; elsewhere it has no effect.
    pub equal_aspect: bool,
    /// Height relative to the other panels; 1 is usual.
    pub height_weight: f64,
    /// Names of the positions 0, 1, 2, … on x in place of numbers (bars by method); empty for a numeric axis.
    pub categories: Vec<String>,
}

/// One curve, set of points, bars or band.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    /// Name in the legend; empty keeps it out of the legend.
    pub name: String,
    /// How it is drawn.
    pub kind: Kind,
    /// Abscissae. Not used by [`Kind::HorizontalLine`].
    pub x: Vec<f64>,
    /// Ordinates. Not used by [`Kind::VerticalLine`] and [`Kind::Band`].
    pub y: Vec<f64>,
    /// Colour of line, points or area; `None` takes the next colour of the palette, and grey for reference lines.
    pub color: Option<Color>,
    /// Width of the line in pixels; points have a radius of 1.5 times that.
    pub width: f64,
}

/// How a series is drawn.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Kind {
    /// Solid line through the points.
    Line,
    /// Dashed line.
    Dashed,
    /// Dotted line.
    Dotted,
    /// Points only.
    Points,
    /// Line with points.
    LinesPoints,
    /// Vertical bars from zero; several bar series of one panel stand side by side.
    Bars,
    /// A line that holds each value until the next point.
    Steps,
    /// Translucent area between two curves over x.
    Band {
        /// Lower edge.
        lower: Vec<f64>,
        /// Upper edge.
        upper: Vec<f64>,
    },
    /// Points with symmetric vertical bars.
    ErrorBars {
        /// Half length of each bar, in units of y.
        plus_minus: Vec<f64>,
    },
    /// A dashed line across the panel at every y.
    HorizontalLine,
    /// A dashed line across the panel at every x.
    VerticalLine,
}

impl Figure {
    /// A figure of 900 px width without panels.
    pub fn new(id: impl Into<String>, title: impl Into<String>) -> Self {
        Self {
            id: id.into(),
            title: title.into(),
            caption: String::new(),
            panels: Vec::new(),
            width_px: 900,
            height_px: None,
            share_x: false,
        }
    }

    /// Sets the caption.
    #[must_use]
    pub fn caption(mut self, caption: impl Into<String>) -> Self {
        self.caption = caption.into();
        self
    }

    /// Adds a panel below the others.
    #[must_use]
    pub fn panel(mut self, panel: Panel) -> Self {
        self.panels.push(panel);
        self
    }

    /// Sets width and height in pixels.
    #[must_use]
    pub fn size(mut self, width_px: u32, height_px: u32) -> Self {
        self.width_px = width_px;
        self.height_px = Some(height_px);
        self
    }

    /// Lets all panels share one x axis.
    #[must_use]
    pub fn share_x(mut self) -> Self {
        self.share_x = true;
        self
    }

    /// Height that is asked for, in pixels, before growing for low panels.
    pub(crate) fn wanted_height_px(&self) -> f64 {
        let sum: f64 = self.panels.iter().map(|p| p.height_weight).sum();
        let automatic = if self.panels.len() == 1 {
            420.0
        } else {
            130.0 + 200.0 * sum
        };
        self.height_px.map_or(automatic.min(8000.0), f64::from)
    }
}

impl Panel {
    /// An empty panel with labelled, linear axes that fit the data.
    pub fn new(x_label: impl Into<String>, y_label: impl Into<String>) -> Self {
        Self {
            title: None,
            x_label: x_label.into(),
            y_label: y_label.into(),
            series: Vec::new(),
            x_range: None,
            y_range: None,
            log_x: false,
            log_y: false,
            equal_aspect: false,
            height_weight: 1.0,
            categories: Vec::new(),
        }
    }

    /// Sets the short title above the panel.
    #[must_use]
    pub fn title(mut self, title: impl Into<String>) -> Self {
        self.title = Some(title.into());
        self
    }

    /// Adds a series.
    #[must_use]
    pub fn series(mut self, series: Series) -> Self {
        self.series.push(series);
        self
    }

    /// Indices of the series, bands first: what is drawn later lies on top.
    pub(crate) fn drawing_order(&self) -> Vec<usize> {
        let band = |index: &usize| matches!(self.series[*index].kind, Kind::Band { .. });
        let (mut bands, others): (Vec<usize>, Vec<usize>) = (0..self.series.len()).partition(band);
        bands.extend(others);
        bands
    }

    /// Colour of the `index`-th series: its own, or grey for a reference line, or the next of the palette.
    pub(crate) fn color_of(&self, index: usize) -> Color {
        let open = |s: &&Series| s.color.is_none() && !s.is_reference();
        match &self.series[index] {
            Series {
                color: Some(color), ..
            } => *color,
            series if series.is_reference() => Color::GREY,
            _ => Color::Cycle(self.series[..index].iter().filter(open).count()),
        }
    }

    /// Sets the limits of x.
    #[must_use]
    pub fn x_range(mut self, low: f64, high: f64) -> Self {
        self.x_range = Some((low, high));
        self
    }

    /// Sets the limits of y.
    #[must_use]
    pub fn y_range(mut self, low: f64, high: f64) -> Self {
        self.y_range = Some((low, high));
        self
    }

    /// Makes x logarithmic.
    #[must_use]
    pub fn log_x(mut self) -> Self {
        self.log_x = true;
        self
    }

    /// Makes y logarithmic.
    #[must_use]
    pub fn log_y(mut self) -> Self {
        self.log_y = true;
        self
    }

    /// Gives x and y the same scale.
    #[must_use]
    pub fn equal_aspect(mut self) -> Self {
        self.equal_aspect = true;
        self
    }

    /// Sets the height relative to the other panels.
    #[must_use]
    pub fn height_weight(mut self, weight: f64) -> Self {
        self.height_weight = weight;
        self
    }

    /// Names the positions 0, 1, 2, … of x.
    #[must_use]
    pub fn categories<S: Into<String>>(mut self, names: impl IntoIterator<Item = S>) -> Self {
        self.categories = names.into_iter().map(Into::into).collect();
        self
    }
}

impl Series {
    fn new(name: impl Into<String>, kind: Kind, x: &[f64], y: &[f64]) -> Self {
        Self {
            name: name.into(),
            kind,
            x: x.to_vec(),
            y: y.to_vec(),
            color: None,
            width: 1.75,
        }
    }

    /// A solid line.
    pub fn line(name: impl Into<String>, x: &[f64], y: &[f64]) -> Self {
        Self::new(name, Kind::Line, x, y)
    }

    /// A dashed line.
    pub fn dashed(name: impl Into<String>, x: &[f64], y: &[f64]) -> Self {
        Self::new(name, Kind::Dashed, x, y)
    }

    /// A dotted line.
    pub fn dotted(name: impl Into<String>, x: &[f64], y: &[f64]) -> Self {
        Self::new(name, Kind::Dotted, x, y)
    }

    /// Points.
    pub fn points(name: impl Into<String>, x: &[f64], y: &[f64]) -> Self {
        Self::new(name, Kind::Points, x, y)
    }

    /// A line with points.
    pub fn lines_points(name: impl Into<String>, x: &[f64], y: &[f64]) -> Self {
        Self::new(name, Kind::LinesPoints, x, y)
    }

    /// Bars from zero.
    pub fn bars(name: impl Into<String>, x: &[f64], y: &[f64]) -> Self {
        Self::new(name, Kind::Bars, x, y)
    }

    /// A line of steps.
    pub fn steps(name: impl Into<String>, x: &[f64], y: &[f64]) -> Self {
        Self::new(name, Kind::Steps, x, y)
    }

    /// The area between `lower` and `upper`.
    pub fn band(name: impl Into<String>, x: &[f64], lower: &[f64], upper: &[f64]) -> Self {
        Self::new(
            name,
            Kind::Band {
                lower: lower.to_vec(),
                upper: upper.to_vec(),
            },
            x,
            &[],
        )
    }

    /// Points with bars of ± `plus_minus`.
    pub fn error_bars(name: impl Into<String>, x: &[f64], y: &[f64], plus_minus: &[f64]) -> Self {
        Self::new(
            name,
            Kind::ErrorBars {
                plus_minus: plus_minus.to_vec(),
            },
            x,
            y,
        )
    }

    /// A line across the panel at height `y`.
    pub fn horizontal(name: impl Into<String>, y: f64) -> Self {
        Self {
            width: 1.25,
            ..Self::new(name, Kind::HorizontalLine, &[], &[y])
        }
    }

    /// A line across the panel at `x`.
    pub fn vertical(name: impl Into<String>, x: f64) -> Self {
        Self {
            width: 1.25,
            ..Self::new(name, Kind::VerticalLine, &[x], &[])
        }
    }

    /// Whether any sample can be drawn.
    pub(crate) fn has_data(&self) -> bool {
        let finite = |column: &[f64]| column.iter().any(|v| v.is_finite());
        match &self.kind {
            Kind::HorizontalLine => finite(&self.y),
            Kind::VerticalLine => finite(&self.x),
            Kind::Band { lower, upper } => finite(&self.x) && finite(lower) && finite(upper),
            _ => finite(&self.x) && finite(&self.y),
        }
    }

    /// Whether this is a line across the panel and not data.
    pub(crate) fn is_reference(&self) -> bool {
        matches!(self.kind, Kind::HorizontalLine | Kind::VerticalLine)
    }

    /// Sets the colour.
    #[must_use]
    pub fn color(mut self, color: Color) -> Self {
        self.color = Some(color);
        self
    }

    /// Sets the width of the line in pixels.
    #[must_use]
    pub fn width(mut self, width: f64) -> Self {
        self.width = width;
        self
    }
}
