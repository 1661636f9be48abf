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
    /// Largest relative difference of the steady thrust over the range.
    pub worst: f64,
    /// The range of throttle.
    pub throttles: [f64; 2],
}

/// Throttles from 0 to 1 at which thrust is looked at.
pub(super) fn throttles() -> impl Iterator<Item = f64> {
    (0..=POINTS).map(|i| f64::from(i) / f64::from(POINTS))
}

/// `s (1 - k s) = b x + c x²` by least squares over the card's throttles, exact where the vehicle hovers, with the time
/// constant of the card's model there.
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
            .map(|[s, x]| ((motor.rest(*s) / x).powi(2) - 1.0).abs())
            .fold(0.0, f64::max);
        if best.as_ref().is_none_or(|b| worst < b.worst) {
            best = Some(MotorFit {
                motor: settings,
                worst,
                throttles,
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
