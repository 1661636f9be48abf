//! A figure as data and layout for plotly.js.

use serde_json::{Map, Value, json};

use crate::Result;
use crate::figure::{Figure, Kind, Series};
use crate::layout::{Layout, layout};
use crate::plotly_trace::{Rounding, Sheet, text};
use crate::series::BAR_FILL;

/// Where a series went: a trace, or lines across the panel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Place {
    Trace(usize),
    /// First shape and number of shapes.
    Shapes(usize, usize),
}

/// What plotly.js gets, and where to find each series of each panel in it.
pub(crate) struct Described {
    pub(crate) value: Value,
    pub(crate) places: Vec<Vec<Place>>,
}

impl Figure {
    /// `{ "data": [...], "layout": {...} }` for `Plotly.newPlot` (plotly.js 3). Gaps are null; long series are thinned
    /// as in the pictures; numbers are rounded to a millionth of the axis. Width is left to the page.
    ///
    /// # Errors
    /// As [`Figure::svg`].
    pub fn plotly_json(&self) -> Result<Value> {
        Ok(self.describe()?.value)
    }

    pub(crate) fn describe(&self) -> Result<Described> {
        self.check()?;
        let layout = layout(self, false);
        let mut traces = Vec::new();
        let mut shapes = Vec::new();
        let mut places = Vec::new();
        for (index, panel) in self.panels.iter().enumerate() {
            let sheet = Sheet {
                panel,
                x: axis("x", if self.share_x { 0 } else { index }),
                y: axis("y", index),
            };
            let place = &layout.panels[index];
            let rounding = [Rounding::of(&place.x), Rounding::of(&place.y)];
            let mut of_panel = vec![Place::Shapes(0, 0); panel.series.len()];
            for number in panel.drawing_order() {
                of_panel[number] = if panel.series[number].is_reference() {
                    let first = shapes.len();
                    shapes.extend(sheet.reference(number));
                    Place::Shapes(first, shapes.len() - first)
                } else {
                    traces.push(sheet.trace(number, rounding));
                    Place::Trace(traces.len() - 1)
                };
            }
            places.push(of_panel);
        }
        let layout = self.describe_layout(&layout, shapes);
        Ok(Described {
            value: json!({ "data": traces, "layout": layout }),
            places,
        })
    }

    fn describe_layout(&self, layout: &Layout, shapes: Vec<Value>) -> Value {
        let first = &layout.panels[0].plot;
        let last = &layout.panels[layout.panels.len() - 1].plot;
        let span = last.bottom - first.top;
        let mut all = Map::new();
        let margin = json!({
            "l": first.left.round(), "r": layout_right(self, layout), "t": first.top.round(),
            "b": (layout.height as f32 - last.bottom).round(), "pad": 0,
        });
        let font =
            json!({ "family": "Inter, system-ui, sans-serif", "size": 12, "color": "#1f2328" });
        let hover = if self.shares_hover() {
            "x unified"
        } else {
            "closest"
        };
        for (key, value) in [
            ("height", json!(layout.height)),
            ("margin", margin),
            ("font", font),
            ("paper_bgcolor", json!("#fff")),
            ("plot_bgcolor", json!("#fff")),
            ("hovermode", json!(hover)),
            ("hoversubplots", json!("axis")),
            ("dragmode", json!("zoom")),
            ("barmode", json!("group")),
            ("bargap", json!(1.0 - BAR_FILL)),
            (
                "legend",
                json!({ "orientation": "h", "y": 1.02, "yanchor": "bottom" }),
            ),
            (
                "modebar",
                json!({ "bgcolor": "rgba(255,255,255,0.7)", "color": "#8a929c", "activecolor": "#1f2328" }),
            ),
            ("shapes", Value::Array(shapes)),
        ] {
            all.insert(key.to_owned(), value);
        }
        let count = self.panels.len();
        for (index, (panel, place)) in self.panels.iter().zip(&layout.panels).enumerate() {
            let top = 1.0 - (place.plot.top - first.top) / span;
            let bottom = 1.0 - (place.plot.bottom - first.top) / span;
            let mut y = axis_layout(&panel.y_label, panel.log_y, (place.y.low, place.y.high));
            y.insert("domain".to_owned(), json!([bottom.max(0.0), top.min(1.0)]));
            y.insert(
                "anchor".to_owned(),
                json!(axis("x", if self.share_x { 0 } else { index })),
            );
            y.insert("automargin".to_owned(), json!(true));
            let mut x = axis_layout(&panel.x_label, panel.log_x, (place.x.low, place.x.high));
            if panel.equal_aspect && !self.share_x && !panel.log_x && !panel.log_y {
                y.insert("scaleanchor".to_owned(), json!(axis("x", index)));
                x.insert("constrain".to_owned(), json!("domain"));
            }
            if !panel.categories.is_empty() {
                let positions: Vec<usize> = (0..panel.categories.len()).collect();
                x.insert("tickmode".to_owned(), json!("array"));
                x.insert("tickvals".to_owned(), json!(positions));
                x.insert(
                    "ticktext".to_owned(),
                    json!(panel.categories.iter().map(|c| text(c)).collect::<Vec<_>>()),
                );
                x.insert("showgrid".to_owned(), json!(false));
            }
            all.insert(axis("yaxis", index), Value::Object(y));
            if !self.share_x || index + 1 == count {
                x.insert("anchor".to_owned(), json!(axis("y", index)));
                let spikes = [
                    ("showspikes", json!(true)),
                    ("spikemode", json!("across")),
                    ("spikesnap", json!("cursor")),
                ];
                let style = [
                    ("spikethickness", json!(1)),
                    ("spikedash", json!("dot")),
                    ("spikecolor", json!("#8a929c")),
                ];
                x.extend(
                    spikes
                        .into_iter()
                        .chain(style)
                        .map(|(key, value)| (key.to_owned(), value)),
                );
                all.insert(
                    axis("xaxis", if self.share_x { 0 } else { index }),
                    Value::Object(x),
                );
            }
        }
        all.insert("annotations".to_owned(), self.panel_titles(layout));
        Value::Object(all)
    }

    /// The panels' titles, above them.
    fn panel_titles(&self, layout: &Layout) -> Value {
        let (first, last) = (&layout.panels[0].plot, layout.panels.len() - 1);
        let span = layout.panels[last].plot.bottom - first.top;
        let panels = self.panels.iter().zip(&layout.panels);
        let titles = panels.filter_map(|(panel, place)| {
            let title = panel.title.as_ref()?;
            Some(json!({
                "text": format!("<b>{}</b>", text(title)), "showarrow": false,
                "xref": "paper", "x": 0, "xanchor": "left",
                "yref": "paper", "y": 1.0 - (place.plot.top - first.top) / span, "yanchor": "bottom",
                "font": { "size": 13 },
            }))
        });
        titles.collect()
    }

    /// One box with the values of all curves makes sense where all run over one ordered abscissa.
    fn shares_hover(&self) -> bool {
        let series = || {
            self.panels
                .iter()
                .flat_map(|p| &p.series)
                .filter(|s| !s.is_reference())
        };
        let ordered = |s: &Series| s.x.iter().filter(|v| v.is_finite()).is_sorted();
        series().all(ordered)
            && series().any(|s| !matches!(s.kind, Kind::Points | Kind::ErrorBars { .. }))
    }
}

fn layout_right(figure: &Figure, layout: &Layout) -> f32 {
    (figure.width_px as f32 - layout.panels[0].plot.right).round()
}

/// plotly.js counts `x`, `x2`, `x3`, ….
fn axis(letter: &str, index: usize) -> String {
    if index == 0 {
        letter.to_owned()
    } else {
        format!("{letter}{}", index + 1)
    }
}

fn axis_layout(label: &str, log: bool, (low, high): (f64, f64)) -> Map<String, Value> {
    let range = if log {
        json!([low.log10(), high.log10()])
    } else {
        json!([low, high])
    };
    let value = json!({
        "title": { "text": text(label), "standoff": 10, "font": { "size": 13 } },
        "type": if log { "log" } else { "linear" },
        "range": range,
        "gridcolor": "#e4e6ea", "linecolor": "#9aa1ab", "showline": true, "zeroline": false,
        "ticks": "", "tickfont": { "color": "#555b63" }, "exponentformat": "power", "hoverformat": ".5~g",
        // Fewer ticks on logarithmic axes: otherwise all of 2 to 9 are labelled.
        "nticks": if log { 6 } else { 0 },
    });
    match value {
        Value::Object(map) => map,
        _ => Map::new(),
    }
}
