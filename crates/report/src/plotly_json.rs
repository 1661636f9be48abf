//! A figure as data and layout for plotly.js.

use serde_json::{Map, Value, json};

use crate::Result;
use crate::figure::{Figure, Kind, Panel, Series};
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
    pub(crate) height_px: u32,
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
                x: axis("x", self.x_of(index)),
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
        Ok(Described {
            value: json!({ "data": traces, "layout": self.describe_layout(&layout, &shapes) }),
            height_px: layout.height,
            places,
        })
    }

    fn describe_layout(&self, layout: &Layout, shapes: &[Value]) -> Value {
        let first = &layout.panels[0].plot;
        let last = layout.panels.len() - 1;
        let bottom = layout.height as f32 - layout.panels[last].plot.bottom;
        let hover = if self.shares_hover() {
            "x unified"
        } else {
            "closest"
        };
        let mut all = object(json!({
            "height": layout.height,
            "margin": {
                "l": first.left.round(), "r": (self.width_px as f32 - first.right).round(),
                "t": first.top.round(), "b": bottom.round(), "pad": 0,
            },
            "font": { "family": "Inter, system-ui, sans-serif", "size": 12, "color": "#1f2328" },
            "paper_bgcolor": "#fff",
            "plot_bgcolor": "#fff",
            "hovermode": hover,
            "hoversubplots": "axis",
            "dragmode": "zoom",
            "barmode": "group",
            "bargap": 1.0 - BAR_FILL,
            "modebar": { "bgcolor": "rgba(255,255,255,0.7)", "color": "#8a929c", "activecolor": "#1f2328" },
            "shapes": shapes,
            "annotations": self.panel_titles(layout),
        }));
        for index in 0..=last {
            all.insert(axis("yaxis", index), self.describe_y(layout, index));
            if !self.share_x || index == last {
                let name = axis("xaxis", self.x_of(index));
                all.insert(name, self.describe_x(layout, index));
            }
        }
        Value::Object(all)
    }

    /// The number of the x axis of a panel.
    fn x_of(&self, panel: usize) -> usize {
        if self.share_x { 0 } else { panel }
    }

    /// Whether a unit is as long on x as on y.
    fn has_equal_scale(&self, panel: &Panel) -> bool {
        panel.equal_aspect && !self.share_x && !panel.log_x && !panel.log_y
    }

    fn describe_x(&self, layout: &Layout, index: usize) -> Value {
        let (panel, place) = (&self.panels[index], &layout.panels[index]);
        let mut x = axis_layout(&panel.x_label, panel.log_x, (place.x.low, place.x.high));
        x.extend(object(json!({
            "anchor": axis("y", index), "showspikes": true, "spikemode": "across", "spikesnap": "cursor",
            "spikethickness": 1, "spikedash": "dot", "spikecolor": "#8a929c",
        })));
        if self.has_equal_scale(panel) {
            x.insert("constrain".to_owned(), json!("domain"));
        }
        if !panel.categories.is_empty() {
            let positions: Vec<usize> = (0..panel.categories.len()).collect();
            let names: Vec<String> = panel.categories.iter().map(|c| text(c)).collect();
            x.extend(object(json!({
                // On a narrow page names turn, up to the right, and the axis takes the room that they need.
                "automargin": true, "autotickangles": [0, -30, -90], "ticklabeloverflow": "allow",
                "tickmode": "array", "tickvals": positions, "ticktext": names, "showgrid": false,
            })));
        }
        Value::Object(x)
    }

    fn describe_y(&self, layout: &Layout, index: usize) -> Value {
        let (panel, place) = (&self.panels[index], &layout.panels[index]);
        let mut y = axis_layout(&panel.y_label, panel.log_y, (place.y.low, place.y.high));
        let [bottom, top] = [place.plot.bottom, place.plot.top].map(|v| share_above(layout, v));
        y.extend(object(json!({
            "domain": [bottom.max(0.0), top.min(1.0)], "anchor": axis("x", self.x_of(index)), "automargin": true,
        })));
        if self.has_equal_scale(panel) {
            y.insert("scaleanchor".to_owned(), json!(axis("x", index)));
        }
        Value::Object(y)
    }

    /// The panels' titles, above them.
    fn panel_titles(&self, layout: &Layout) -> Value {
        let panels = self.panels.iter().zip(&layout.panels);
        let titles = panels.filter_map(|(panel, place)| {
            let title = panel.title.as_ref()?;
            Some(json!({
                "text": format!("<b>{}</b>", text(title)), "showarrow": false,
                "xref": "paper", "x": 0, "xanchor": "left",
                "yref": "paper", "y": share_above(layout, place.plot.top), "yanchor": "bottom",
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

/// Where a pixel row lies between the bottom (0) and the top (1) of all panels.
fn share_above(layout: &Layout, y: f32) -> f32 {
    let (top, last) = (layout.panels[0].plot.top, layout.panels.len() - 1);
    1.0 - (y - top) / (layout.panels[last].plot.bottom - top)
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
    object(json!({
        "title": { "text": text(label), "standoff": 10, "font": { "size": 13 } },
        "type": if log { "log" } else { "linear" },
        "range": range,
        "gridcolor": "#e4e6ea", "linecolor": "#9aa1ab", "showline": true, "zeroline": false,
        "ticks": "", "tickfont": { "color": "#555b63" }, "exponentformat": "power", "hoverformat": ".5~g",
        // Fewer ticks on logarithmic axes: otherwise all of 2 to 9 are labelled.
        "nticks": if log { 6 } else { 0 },
    }))
}

fn object(value: Value) -> Map<String, Value> {
    match value {
        Value::Object(map) => map,
        _ => Map::new(),
    }
}
