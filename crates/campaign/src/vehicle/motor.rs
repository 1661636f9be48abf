//! The motor law of the plant that follows from a thrust card.

use touchdown_flight::thrust::ThrustModel;
use touchdown_model::Card;
use touchdown_sim::body::motor::{Motor, MotorSettings};

use crate::error::{Error, Result};

/// Throttles at which the card and the law are compared.
const POINTS: u32 = 40;
/// Sags that are tried, up to the greatest that the law takes, 0.5.
const SAGS: u32 = 50;
/// Least losses, for the law needs both.
const LEAST: f64 = 1e-6;

/// A motor law in a card's place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MotorFit {
    /// The motors.
    pub motor: MotorSettings,
    /// Largest difference of the steady thrust over the range, over the weight.
    pub worst: f64,
    /// The range of throttle.
    pub throttles: [f64; 2],
    /// Steady thrust at the highest throttle: of these motors, and of the card (N).
    pub greatest_n: [f64; 2],
}

/// Relative difference from the card's greatest thrust up to which the text does not mention it.
const SAME_GREATEST: f64 = 0.02;

impl MotorFit {
    /// How near the motors are to the card's, in words.
    #[must_use]
    pub fn text(&self) -> String {
        let [low, high] = self.throttles;
        let near = format!(
            "within {:.1} % of the weight over throttle {low:.2} to {high:.2}",
            100.0 * self.worst
        );
        let [own_n, card_n] = self.greatest_n;
        match (own_n / card_n - 1.0).abs() > SAME_GREATEST {
            true => format!("{near}, at most {own_n:.3} N where the card gives {card_n:.3} N"),
            false => near,
        }
    }
}

/// Throttles from 0 to 1 at which thrust is looked at.
pub(super) fn throttles() -> impl Iterator<Item = f64> {
    (0..=POINTS).map(|i| f64::from(i) / f64::from(POINTS))
}

/// `s (1 - k s) = b x + c x²` by least squares over the card's throttles, exact where the vehicle hovers, with the time
/// constant of the card's model there. Of all sags, the one is taken whose thrust differs least anywhere. Differences count over the
/// weight: in proportion to the thrust, low throttles that no flight has would decide, and the greatest thrust would not count.
pub(super) fn fit(card: &Card, model: &ThrustModel<f64>, weight_n: f64) -> Result<MotorFit> {
    let x_hover = weight_n.sqrt();
    let hover = model.throttle_for(weight_n);
    let [low, high] = card.validity.inputs.get("s").copied().unwrap_or([0.1, 1.0]);
    let throttles = [
        low.clamp(0.02, 1.0).min(hover),
        high.clamp(0.02, 1.0).max(hover),
    ];
    let points: Vec<[f64; 2]> = self::throttles()
        .map(|share| {
            let s = throttles[0] + (throttles[1] - throttles[0]) * share;
            [s, model.rest(s)]
        })
        .collect();
    let slope = |h: f64| model.derivative(x_hover + h, hover);
    let lag_s = -2e-3 / (slope(1e-3) - slope(-1e-3));
    let time_constant_s = if lag_s.is_finite() && lag_s > 0.0 {
        lag_s
    } else {
        MotorSettings::default().time_constant_s
    };
    let mut best: Option<MotorFit> = None;
    for i in 0..=SAGS {
        let sag = 0.5 * f64::from(i) / f64::from(SAGS);
        let [b, c] = losses(&points, sag);
        let exact = hover * (1.0 - sag * hover) / (b * x_hover + c * x_hover * x_hover);
        let settings = MotorSettings {
            time_constant_s,
            linear_loss: (b * exact).max(LEAST),
            quadratic_loss: (c * exact).max(LEAST),
            sag,
        };
        let motor = Motor::new(&settings, weight_n)?;
        let worst = points
            .iter()
            .map(|[s, x]| (motor.rest(*s).powi(2) - x * x).abs() / weight_n)
            .fold(0.0, f64::max);
        if best.as_ref().is_none_or(|b| worst < b.worst) {
            best = Some(MotorFit {
                motor: settings,
                worst,
                throttles,
                greatest_n: [motor.rest(throttles[1]), model.rest(throttles[1])].map(|x| x * x),
            });
        }
    }
    best.ok_or_else(|| Error::Arguments(format!("thrust card `{}`: no thrust", card.name)))
}

/// b and c of least squares for a sag, neither below [`LEAST`].
fn losses(points: &[[f64; 2]], sag: f64) -> [f64; 2] {
    let sum = |f: &dyn Fn(f64, f64) -> f64| points.iter().map(|[s, x]| f(*s, *x)).sum::<f64>();
    let (x2, x3, x4) = (
        sum(&|_, x| x * x),
        sum(&|_, x| x.powi(3)),
        sum(&|_, x| x.powi(4)),
    );
    let (y1, y2) = (
        sum(&|s, x| x * s * (1.0 - sag * s)),
        sum(&|s, x| x * x * s * (1.0 - sag * s)),
    );
    let det = x2 * x4 - x3 * x3;
    let (b, c) = ((y1 * x4 - y2 * x3) / det, (x2 * y2 - x3 * y1) / det);
    // A zero determinant (one single throttle) gives no numbers: all is quadratic loss then, as of rotors without friction.
    if !b.is_finite() || b < LEAST {
        [LEAST, y2 / x4]
    } else if c < LEAST {
        [y1 / x2, LEAST]
    } else {
        [b, c]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A card of `√T = c0 + c1 s + c2 s²` behind a lag of 0.04 s.
    fn card([c0, c1, c2]: [f64; 3]) -> Card {
        let term = |of: &str, expression: &str, value: f64, unit: &str| {
            format!(
                "[[terms]]\nof = \"{of}\"\nexpression = \"{expression}\"\nvalue = {value}\nunit = \"{unit}\"\n"
            )
        };
        let text = format!(
            "schema = 1\nname = \"t\"\nkind = \"thrust\"\nform = \"static_sqrt\"\nstatus = \"fitted\"\nequation = \"x\"\n\
             description = \"\"\n[vehicle]\nname = \"\"\n[validity]\noutside = \"clamp\"\n[validity.inputs]\ns = [0.1, 1.0]\n\
             [provenance]\nsource = \"t\"\n{}{}{}{}",
            term("x", "1", c0, "√N"),
            term("x", "s", c1, "√N"),
            term("x", "s^2", c2, "√N"),
            term("T_m", "1", 0.04, "s"),
        );
        Card::parse(&text, "t").unwrap()
    }

    #[test]
    fn analytic_motors_reach_the_greatest_thrust_of_a_card() {
        // Four motors, each of 9 (0.25 s + 0.75 s²) N: its root is nearly a line above zero. Low throttles of small thrust are the
        // worst in proportion; when they decided, a third was missing at full throttle.
        let card = card([0.577, 5.68, -0.266]);
        let model = card.thrust_model().unwrap();
        for weight_n in [9.0, 18.0, 26.5] {
            let fit = fit(&card, &model, weight_n).unwrap();
            let [own_n, card_n] = fit.greatest_n;
            assert!((card_n - 5.991_f64.powi(2)).abs() < 1e-9);
            // The law has no thrust without throttle, and is exact in hover.
            assert!((own_n / card_n - 1.0).abs() < 0.07, "{fit:?}");
            let motor = Motor::new(&fit.motor, weight_n).unwrap();
            let hover = model.throttle_for(weight_n);
            assert!((motor.rest(hover).powi(2) / weight_n - 1.0).abs() < 1e-9);
            let text = fit.text();
            assert!(
                text.contains("of the weight over throttle 0.10 to 1.00, at most"),
                "{text}"
            );
            assert!((fit.motor.time_constant_s - 0.04).abs() < 1e-6);
        }
    }

    #[test]
    fn analytic_a_law_of_a_card_is_found_again() {
        // √T = 5 s is the law without sag and quadratic loss.
        let card = card([0.0, 5.0, 0.0]);
        let fit = fit(&card, &card.thrust_model().unwrap(), 9.0).unwrap();
        assert!(fit.worst < 1e-3, "{fit:?}");
        assert!(!fit.text().contains("at most"), "{}", fit.text());
    }
}
