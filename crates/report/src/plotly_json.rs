//! A figure as data and layout for plotly.js.

use serde_json::{Map, Value, json};

use crate::Result;
use crate::decimate::keep;
use crate::figure::{Figure, Kind, Panel, Series};
use crate::layout::{Layout, layout};
use crate::series::{BAND_ALPHA, BAR_FILL, has_points};

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
        Value::Object(all)
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
    });
    match value {
        Value::Object(map) => map,
        _ => Map::new(),
    }
}

/// plotly.js reads a little HTML in names; ours are plain.
fn text(plain: &str) -> String {
    plain
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

/// How finely numbers are written.
#[derive(Debug, Clone, Copy)]
struct Rounding(Option<usize>);

impl Rounding {
    /// A millionth of a linear axis; logarithmic ones are written in full.
    fn of(axis: &crate::scale::Axis) -> Self {
        let decimals = (6.0 - (axis.high - axis.low).log10()).ceil();
        Self((!axis.log && (0.0..=15.0).contains(&decimals)).then_some(decimals as usize))
    }

    fn number(self, value: f64) -> Value {
        if !value.is_finite() {
            return Value::Null;
        }
        let rounded = self
            .0
            .and_then(|decimals| format!("{value:.decimals$}").parse().ok())
            .unwrap_or(value);
        // Without the fraction of whole numbers: "12" for "12.0".
        if rounded.fract() == 0.0 && rounded.abs() < 1e15 {
            json!(rounded as i64)
        } else {
            json!(rounded)
        }
    }

    fn column(self, values: &[f64], kept: &[usize]) -> Value {
        kept.iter().map(|i| self.number(values[*i])).collect()
    }
}

/// One panel while it is described.
struct Sheet<'a> {
    panel: &'a Panel,
    x: String,
    y: String,
}

impl Sheet<'_> {
    fn trace(&self, number: usize, [rx, ry]: [Rounding; 2]) -> Value {
        let series = &self.panel.series[number];
        let color = self.panel.color_of(number);
        let Series { x, y, width, .. } = series;
        let mut trace = Map::new();
        let mut put = |key: &str, value: Value| {
            trace.insert(key.to_owned(), value);
        };
        put("name", json!(text(&series.name)));
        put("showlegend", json!(!series.name.is_empty()));
        put("xaxis", json!(self.x));
        put("yaxis", json!(self.y));
        put(
            "type",
            json!(if series.kind == Kind::Bars {
                "bar"
            } else {
                "scatter"
            }),
        );
        if let Kind::Band { lower, upper } = &series.kind {
            let (xs, ys) = band_outline(x, lower, upper, [rx, ry]);
            let [r, g, b] = color.rgb();
            put("x", xs);
            put("y", ys);
            put("mode", json!("lines"));
            put("fill", json!("toself"));
            put(
                "fillcolor",
                json!(format!("rgba({r},{g},{b},{BAND_ALPHA})")),
            );
            put("line", json!({ "width": 0, "color": color.hex() }));
            put("hoverinfo", json!("skip"));
            return Value::Object(trace);
        }
        let kept = match &series.kind {
            Kind::ErrorBars { plus_minus } => keep(&[x, y, plus_minus]),
            _ => keep(&[x, y]),
        };
        put("x", rx.column(x, &kept));
        put("y", ry.column(y, &kept));
        if series.kind == Kind::Bars {
            put("marker", json!({ "color": color.hex() }));
            return Value::Object(trace);
        }
        if let Kind::ErrorBars { plus_minus } = &series.kind {
            let lengths = Rounding(None).column(plus_minus, &kept);
            put(
                "error_y",
                json!({ "type": "data", "array": lengths, "thickness": 0.75 * width, "width": 4 }),
            );
        }
        let mode = match series.kind {
            Kind::Points | Kind::ErrorBars { .. } => "markers",
            Kind::LinesPoints => "lines+markers",
            _ => "lines",
        };
        put("mode", json!(mode));
        if has_points(&series.kind) {
            put(
                "marker",
                json!({ "color": color.hex(), "size": 3.0 * width }),
            );
        }
        let dash = match series.kind {
            Kind::Dashed => "dash",
            Kind::Dotted => "dot",
            _ => "solid",
        };
        let shape = if series.kind == Kind::Steps {
            "hv"
        } else {
            "linear"
        };
        put(
            "line",
            json!({ "color": color.hex(), "width": width, "dash": dash, "shape": shape }),
        );
        put("connectgaps", json!(false));
        Value::Object(trace)
    }

    /// Lines across the panel.
    fn reference(&self, number: usize) -> Vec<Value> {
        let series = &self.panel.series[number];
        let line = json!({ "color": self.panel.color_of(number).hex(), "width": series.width, "dash": "6px,4px" });
        let horizontal = series.kind == Kind::HorizontalLine;
        let log = if horizontal {
            self.panel.log_y
        } else {
            self.panel.log_x
        };
        let values = if horizontal { &series.y } else { &series.x };
        let shape = |value: &f64| {
            let (across, along) = if horizontal {
                (&self.x, &self.y)
            } else {
                (&self.y, &self.x)
            };
            let refs = if horizontal {
                ["xref", "yref"]
            } else {
                ["yref", "xref"]
            };
            let ends = if horizontal {
                ["x0", "x1", "y0", "y1"]
            } else {
                ["y0", "y1", "x0", "x1"]
            };
            json!({
                "type": "line", "line": line, "layer": "above",
                refs[0]: format!("{across} domain"), refs[1]: along,
                ends[0]: 0, ends[1]: 1, ends[2]: value, ends[3]: value,
            })
        };
        values
            .iter()
            .filter(|v| v.is_finite() && (!log || **v > 0.0))
            .map(shape)
            .collect()
    }
}

/// Closed outlines of a band, one for each run without a gap, nulls between.
fn band_outline(
    x: &[f64],
    lower: &[f64],
    upper: &[f64],
    [rx, ry]: [Rounding; 2],
) -> (Value, Value) {
    let kept = keep(&[x, lower, upper]);
    let whole = |i: &usize| x[*i].is_finite() && lower[*i].is_finite() && upper[*i].is_finite();
    let (mut xs, mut ys) = (Vec::new(), Vec::new());
    for run in kept.split(|i| !whole(i)).filter(|run| run.len() > 1) {
        if !xs.is_empty() {
            xs.push(Value::Null);
            ys.push(Value::Null);
        }
        xs.extend(run.iter().chain(run.iter().rev()).map(|i| rx.number(x[*i])));
        ys.extend(run.iter().map(|i| ry.number(lower[*i])));
        ys.extend(run.iter().rev().map(|i| ry.number(upper[*i])));
    }
    (Value::Array(xs), Value::Array(ys))
}
