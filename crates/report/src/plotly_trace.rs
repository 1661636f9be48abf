//! Series as traces and shapes for plotly.js.

use serde_json::{Map, Value, json};

use crate::color::Color;
use crate::decimate::keep;
use crate::figure::{Kind, Panel, Series};
use crate::scale::Axis;
use crate::series::{BAND_ALPHA, has_points};

/// plotly.js reads a little HTML in names; ours are plain.
pub(crate) fn text(plain: &str) -> String {
    plain
        .replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
}

/// How finely numbers are written.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Rounding(Option<usize>);

impl Rounding {
    /// A millionth of a linear axis; logarithmic ones are written in full.
    pub(crate) fn of(axis: &Axis) -> Self {
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
pub(crate) struct Sheet<'a> {
    pub(crate) panel: &'a Panel,
    pub(crate) x: String,
    pub(crate) y: String,
}

impl Sheet<'_> {
    /// A series as a trace.
    pub(crate) fn trace(&self, number: usize, [rx, ry]: [Rounding; 2]) -> Value {
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
        put("line", line_style(series, color));
        put("connectgaps", json!(false));
        Value::Object(trace)
    }

    /// Lines across the panel.
    pub(crate) fn reference(&self, number: usize) -> Vec<Value> {
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

/// Colour, width, dashes and shape of a line.
fn line_style(series: &Series, color: Color) -> Value {
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
    json!({ "color": color.hex(), "width": series.width, "dash": dash, "shape": shape })
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
