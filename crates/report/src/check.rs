//! Everything that can be wrong with a figure, checked once before drawing.

use crate::figure::{Figure, Kind, Panel, Series};
use crate::{Error, Result};

/// Checks that an id can be the name of a file.
pub(crate) fn check_id(id: &str) -> Result<()> {
    let legal = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    if id.is_empty() || !id.chars().all(legal) {
        return Err(Error::Id {
            found: id.to_owned(),
        });
    }
    Ok(())
}

impl Figure {
    /// Checks everything that could be wrong, once, before drawing.
    pub(crate) fn check(&self) -> Result<()> {
        check_id(&self.id)?;
        if self.panels.is_empty() {
            return Err(Error::NoPanels {
                figure: self.id.clone(),
            });
        }
        if !(240..=4000).contains(&self.width_px) {
            return Err(self.setting("width_px", "240 to 4000", self.width_px));
        }
        if let Some(height) = self.height_px
            && !(120..=8000).contains(&height)
        {
            return Err(self.setting("height_px", "120 to 8000", height));
        }
        if self.share_x && self.panels.iter().any(|p| p.log_x != self.panels[0].log_x) {
            return Err(self.setting("log_x", "the same in all panels that share x", "different"));
        }
        self.panels
            .iter()
            .try_for_each(|panel| self.check_panel(panel))
    }

    fn check_panel(&self, panel: &Panel) -> Result<()> {
        let weight = panel.height_weight;
        if !(0.05..=20.0).contains(&weight) {
            return Err(self.setting("height_weight", "0.05 to 20", weight));
        }
        for (key, range, log) in [
            ("x_range", panel.x_range, panel.log_x),
            ("y_range", panel.y_range, panel.log_y),
        ] {
            let Some((low, high)) = range else { continue };
            let found = format!("({low}, {high})");
            if !(low.is_finite() && high.is_finite() && low < high) {
                return Err(self.setting(key, "two finite numbers, the lower first", found));
            }
            if log && low <= 0.0 {
                return Err(self.setting(key, "positive on a logarithmic axis", found));
            }
        }
        panel
            .series
            .iter()
            .try_for_each(|series| self.check_series(series))
    }

    fn check_series(&self, series: &Series) -> Result<()> {
        if !(0.1..=40.0).contains(&series.width) {
            return Err(self.setting("width", "0.1 to 40", series.width));
        }
        let expected = series.x.len();
        let length = |column: &'static str, found: usize| {
            if found == expected {
                return Ok(());
            }
            Err(Error::Length {
                figure: self.id.clone(),
                series: series.name.clone(),
                column,
                expected,
                found,
            })
        };
        match &series.kind {
            Kind::HorizontalLine | Kind::VerticalLine => Ok(()),
            Kind::Band { lower, upper } => {
                length("lower", lower.len()).and(length("upper", upper.len()))
            }
            Kind::ErrorBars { plus_minus } => {
                length("y", series.y.len()).and(length("plus_minus", plus_minus.len()))
            }
            _ => length("y", series.y.len()),
        }
    }

    pub(crate) fn setting(
        &self,
        key: &'static str,
        expected: &'static str,
        found: impl std::fmt::Display,
    ) -> Error {
        Error::Setting {
            figure: self.id.clone(),
            key,
            expected,
            found: format!("{found}"),
        }
    }
}
