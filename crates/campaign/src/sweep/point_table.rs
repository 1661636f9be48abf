//! Figures of every point as a table.

use super::policy::CONTROLLER;
use super::row::text;
use super::summary::{CampaignResults, PointFigures};
use crate::csv::line;
use crate::error::{Error, Result};

impl CampaignResults {
    /// The figures as a table (CSV), a row for every point.
    ///
    /// # Errors
    /// A value that a table cannot hold.
    pub fn csv(&self) -> Result<String> {
        let mut out = String::new();
        for (i, point) in self.points.iter().enumerate() {
            let cells = cells(point, self.autopilot.is_some())?;
            if i == 0 {
                line(&mut out, cells.iter().map(|(name, _)| name.as_str()));
            }
            line(&mut out, cells.iter().map(|(_, value)| value.as_str()));
        }
        Ok(out)
    }
}

fn cells(point: &PointFigures, with_autopilot: bool) -> Result<Vec<(String, String)>> {
    let mut cells = vec![("point".to_string(), point.of.point.to_string())];
    for (key, value) in &point.of.settings {
        cells.push((key.clone(), text(value)));
    }
    if !point.of.settings.contains_key(CONTROLLER) {
        cells.push((CONTROLLER.into(), point.of.controller.clone()));
    }
    cells.push(("trials".into(), point.figures.trials.to_string()));
    if with_autopilot {
        cells.push(("not_flown".into(), point.figures.not_flown.to_string()));
    }
    let object =
        serde_json::to_value(point).map_err(|e| Error::Arguments(format!("the summary: {e}")))?;
    for share in ["landed", "hard", "landed_at_first", "crashed"] {
        let of = &object[share];
        cells.push((share.to_string(), of["count"].to_string()));
        cells.push((format!("{share}_share"), of["share"].to_string()));
        cells.push((format!("{share}_low"), of["ci95"][0].to_string()));
        cells.push((format!("{share}_high"), of["ci95"][1].to_string()));
    }
    cells.push((
        "crashed_without_abort".into(),
        point.figures.crashed_without_abort.to_string(),
    ));
    for outcome in ["given_up", "timed_out"] {
        let count = point.figures.outcomes.get(outcome).unwrap_or(&0);
        cells.push((outcome.to_string(), count.to_string()));
    }
    for name in [
        "t_l_s",
        "waited_s",
        "v_l_mps",
        "s_l_m",
        "lateral_m",
        "lateral_mps",
        "impact_mps",
        "tilt_rad",
        "impact_tilt_rad",
    ] {
        let of = &object[name];
        let figures =
            ["mean", "sd", "p5", "p50", "p95", "p99", "max"].map(|figure| (figure, &of[figure]));
        let interval = [("low", &of["ci95"][0]), ("high", &of["ci95"][1])];
        for (figure, value) in figures.into_iter().chain(interval) {
            let shown = if value.is_null() {
                String::new()
            } else {
                value.to_string()
            };
            cells.push((format!("{name}_{figure}"), shown));
        }
    }
    Ok(cells)
}
