//! The markup of an interactive figure: legend, chart, caption, data.

use maud::{Markup, PreEscaped, html};

use crate::Result;
use crate::figure::{Figure, Kind, Panel};
use crate::pack::pack;
use crate::plotly_json::Place;
use crate::series::{BAND_ALPHA, LEAST_DOT, has_points};
use crate::words::Words;

/// A figure as the page needs it: names, styles, and the description for plotly.js.
#[derive(Debug, Clone)]
pub(crate) struct Chart {
    figure: Figure,
    places: Vec<Vec<Place>>,
    height_px: u32,
    /// JSON that cannot end the script element that holds it.
    description: String,
}

impl Chart {
    pub(crate) fn of(figure: &Figure) -> Result<Self> {
        let mut described = figure.describe()?;
        pack(&mut described.value);
        Ok(Self {
            figure: without_data(figure),
            places: described.places,
            height_px: described.height_px,
            description: described.value.to_string().replace('<', "\\u003c"),
        })
    }

    pub(crate) fn markup(&self, number: usize, words: &Words<'_>) -> Markup {
        let Figure {
            id,
            title,
            caption,
            panels,
            ..
        } = &self.figure;
        html! {
            figure.chart id=(format!("figure-{number}")) data-name=(id) {
                div.keys {
                    @for (panel, places) in panels.iter().zip(&self.places) { (keys(panel, places, panels.len() > 1)) }
                }
                div.plot role="img" aria-label=(title) style=(format!("height:{}px", self.height_px)) {}
                noscript { p.remark {
                    "Charts need scripts. Beside most reports, the folder " code { "figures" } " holds this one as "
                    code { (id) ".svg" } "."
                } }
                figcaption {
                    b { "Figure " (number) ". " (title) @if !title.ends_with('.') { "." } } " " (words.set(caption))
                }
                script type="application/json" { (PreEscaped(&self.description)) }
            }
        }
    }
}

/// The legend and the title need names and styles only.
fn without_data(figure: &Figure) -> Figure {
    let mut figure = figure.clone();
    for series in figure.panels.iter_mut().flat_map(|panel| &mut panel.series) {
        series.x = Vec::new();
        series.y = Vec::new();
    }
    figure
}

/// The legend of a panel; each name switches its series on and off.
fn keys(panel: &Panel, places: &[Place], several: bool) -> Markup {
    let named = || {
        let series = panel.series.iter().zip(places).enumerate();
        series.filter(|(_, (series, _))| !series.name.is_empty())
    };
    let heading = panel.title.as_ref().or(several.then_some(&panel.y_label));
    html! {
        @if named().next().is_some() {
            div.group {
                @if let Some(heading) = heading { span.heading { (heading) } }
                @for (index, (series, place)) in named() {
                    @let (kind, at) = match place {
                        Place::Trace(trace) => ("trace", trace.to_string()),
                        Place::Shapes(first, count) => ("shapes", format!("{first},{count}")),
                    };
                    button.key type="button" aria-pressed="true" data-kind=(kind) data-at=(at) {
                        (sample(panel, index)) (series.name)
                    }
                }
            }
        }
    }
}

/// A sample of a series for the legend.
fn sample(panel: &Panel, index: usize) -> Markup {
    let series = &panel.series[index];
    let (color, width) = (panel.color_of(index).hex(), series.width.min(6.0));
    let area = matches!(series.kind, Kind::Band { .. } | Kind::Bars);
    let opacity = if series.kind == Kind::Bars {
        1.0
    } else {
        BAND_ALPHA
    };
    let line = !area && !matches!(series.kind, Kind::Points | Kind::ErrorBars { .. });
    let dash = match series.kind {
        Kind::Dashed => "7 4",
        Kind::Dotted => "2 3",
        Kind::HorizontalLine | Kind::VerticalLine => "5 3",
        _ => "none",
    };
    html! {
        svg width="26" height="10" viewBox="0 0 26 10" aria-hidden="true" {
            @if area { rect width="26" height="10" fill=(color) fill-opacity=(opacity) {} }
            @if line {
                path d="M0 5h26" fill="none" stroke=(color) stroke-width=(width) stroke-dasharray=(dash) {}
            }
            @if has_points(&series.kind) { circle cx="13" cy="5" r=((1.5 * width).max(LEAST_DOT)) fill=(color) {} }
        }
    }
}
