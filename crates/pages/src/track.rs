//! A landing over time in panels: the true state, what the landing computer estimates, and what it follows.

use touchdown_report::{Color, Panel, Series};
use touchdown_sim::landing::space::{SpaceTrace, TraceRow};

use super::colors::{DECK, ESTIMATED, FEET, FORECAST, REFERENCE, TRUTH, of_controller};

/// Standard deviation of the estimated height below which the estimate is drawn (m). Above it the computer has not
/// seen the deck yet, and the curve would leave the axes.
const KNOWN_M: f64 = 0.3;

/// The record of a landing.
pub struct Track<'a> {
    rows: &'a [TraceRow],
    time_s: Vec<f64>,
}

impl<'a> Track<'a> {
    /// The panels of a landing.
    #[must_use]
    pub fn of(trace: &'a SpaceTrace) -> Self {
        let rows = &trace.rows;
        let time_s = rows.iter().map(|r| r.time_s).collect();
        Self { rows, time_s }
    }

    fn column(&self, pick: impl Fn(&TraceRow) -> f64) -> Vec<f64> {
        self.rows.iter().map(pick).collect()
    }

    fn line(&self, name: &str, color: Color, pick: impl Fn(&TraceRow) -> f64) -> Series {
        Series::line(name, &self.time_s, &self.column(pick)).color(color)
    }

    /// A value of the estimated state; none until the deck was observed.
    fn estimate(&self, name: &str, pick: impl Fn(&TraceRow) -> f64) -> Series {
        self.line(name, ESTIMATED, |r| {
            if r.estimated_sd_m[2] < KNOWN_M {
                pick(r)
            } else {
                f64::NAN
            }
        })
    }

    fn target(&self, name: &str, part: usize) -> Series {
        let wanted = self.column(|r| r.target.map_or(f64::NAN, |t| t[part]));
        Series::dashed(name, &self.time_s, &wanted).color(REFERENCE)
    }

    /// Altitudes of vehicle and deck.
    #[must_use]
    pub fn altitude(&self) -> Panel {
        panel("Altitude (m)")
            .series(self.line("vehicle", TRUTH, |r| r.position_m[2]))
            .series(self.line("deck", DECK, |r| r.deck_m[2]))
    }

    /// Height above the deck.
    #[must_use]
    pub fn height(&self) -> Panel {
        panel("Height z (m)")
            .series(self.line("true", TRUTH, |r| r.relative_m[2]))
            .series(self.estimate("estimated", |r| r.estimated_m[2]))
            .series(self.target("reference", 0))
    }

    /// Vertical velocities.
    #[must_use]
    pub fn velocity(&self) -> Panel {
        panel("Velocity v (m/s)")
            .series(self.line("", TRUTH, |r| r.relative_mps[2]))
            .series(self.estimate("", |r| r.estimated_mps[2]))
            .series(self.target("", 1))
    }

    /// Distance from the deck's centre.
    #[must_use]
    pub fn lateral(&self) -> Panel {
        panel("Forward, port (m)")
            .series(self.line("forward", Color::Cycle(2), |r| r.relative_m[0]))
            .series(self.line("port", Color::Cycle(3), |r| r.relative_m[1]))
    }

    /// The deck's heave. The computer reports zero until it has found a harmonic; those rows are omitted.
    pub fn deck(&self) -> Panel {
        let known = |value: f64| if value == 0.0 { f64::NAN } else { value };
        panel("Deck's heave (m/s)")
            .series(self.line("true heave", DECK, |r| r.deck_mps[2]))
            .series(self.line("estimated heave", ESTIMATED, |r| {
                known(r.estimated_deck_mps)
            }))
    }

    /// The forecast of the deck's heave, at the time that it is for, with a band of two standard deviations.
    pub fn forecast(&self) -> [Series; 2] {
        let end = self.time_s.last().copied().unwrap_or(0.0);
        let shown = |r: &&TraceRow| r.time_s + TraceRow::FORECAST_S <= end;
        let rows: Vec<&TraceRow> = self.rows.iter().filter(shown).collect();
        let of = |deviations: f64| -> Vec<f64> {
            let at = |r: &&TraceRow| match r.forecast_deck_mps {
                0.0 => f64::NAN,
                forecast => forecast + deviations * r.forecast_deck_sd_mps,
            };
            rows.iter().map(at).collect()
        };
        let time_s: Vec<f64> = rows
            .iter()
            .map(|r| r.time_s + TraceRow::FORECAST_S)
            .collect();
        [
            Series::band("forecast ± 2 sd", &time_s, &of(-2.0), &of(2.0)).color(FORECAST),
            Series::dashed("forecast 1 s before", &time_s, &of(0.0)).color(FORECAST),
        ]
    }

    /// The ground-effect force and what the controller feeds forward for it.
    pub fn ground_effect(&self) -> Panel {
        let model = of_controller("dynamic").unwrap_or(Color::GREY);
        panel("Ground effect (N)")
            .series(self.line("true force", TRUTH, |r| r.ground_effect_n))
            .series(self.line("fed forward", model, |r| r.counted_ground_effect_n))
    }

    /// The force of the feet, which is many times the ground effect, so it has a scale of its own.
    pub fn feet(&self) -> Panel {
        panel("Feet (N)")
            .height_weight(0.6)
            .series(self.line("", FEET, |r| r.feet_n.iter().sum()))
    }
}

fn panel(label: &str) -> Panel {
    Panel::new("Time (s)", label)
}
