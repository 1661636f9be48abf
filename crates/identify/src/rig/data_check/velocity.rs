//! Velocities: the height changes by the vehicle's velocity less the deck's.

use super::DataWarning;
use crate::rig::GroundTrial;

/// Time over which changes of height are compared with the path by the velocities (s): noise of the height counts once over
/// it, and motions of up to 1 Hz do not return within it.
const WINDOW_S: f64 = 0.3;
/// Stretches of a log that are compared at least: of ten, a correlation of 0.7 by chance has a probability of 2 %.
const LEAST_WINDOWS: usize = 10;
/// Rate of the height below which a velocity of the deck matters little (m/s): it changes the thrust by a few tenths of
/// a per cent there.
const LEAST_RATE_MPS: f64 = 0.03;
/// How much more the height changes over a window than from row to row, if it moves: noise changes it as much over both.
const MOVES: f64 = 1.5;
/// Correlation of two motions that are the same: half of the variance is common.
const SAME: f64 = 0.7;
/// Factor between the two that is no other unit.
const SAME_UNIT: [f64; 2] = [0.5, 2.0];

const DECK: &str = "deck_velocity_mps";
const VEHICLE: &str = "vehicle_velocity_mps";

/// What the velocities of one log have to do with its height.
#[derive(Debug, PartialEq)]
enum Verdict {
    /// They fit, or the log does not show whether they do.
    Fits,
    /// Both are zero, while the height moves with this rate (m/s, root mean square).
    Missing(f64),
    /// The height moves by them with the other sign of these channels.
    Flipped(Vec<&'static str>),
    /// Their path over the change of height.
    Unit(f64),
    /// They have nothing to do with it.
    Unrelated,
}

/// Warns of velocities that are missing, of another sign or unit, or unrelated, by kind with the number of logs.
pub(super) fn check(trials: &[GroundTrial]) -> Vec<DataWarning> {
    let verdicts: Vec<Verdict> = trials.iter().map(Verdict::of).collect();
    let mut warnings = Vec::new();
    let rates: Vec<f64> = verdicts.iter().filter_map(Verdict::missing).collect();
    if !rates.is_empty() {
        let squares: f64 = rates.iter().map(|r| r * r).sum();
        warnings.push(DataWarning::VelocitiesMissing {
            logs: rates.len(),
            rate_mps: (squares / rates.len() as f64).sqrt(),
        });
    }
    let count = |kind: &Verdict| verdicts.iter().filter(|v| *v == kind).count();
    for channels in [vec![DECK], vec![VEHICLE], vec![DECK, VEHICLE]] {
        let logs = count(&Verdict::Flipped(channels.clone()));
        if logs > 0 {
            warnings.push(DataWarning::VelocityFlipped { logs, channels });
        }
    }
    let factors = || verdicts.iter().filter_map(Verdict::factor);
    if let Some(factor) = crate::thrust::plateau::median(factors()) {
        let logs = factors().count();
        warnings.push(DataWarning::VelocityUnit { logs, factor });
    }
    let logs = count(&Verdict::Unrelated);
    if logs > 0 {
        warnings.push(DataWarning::VelocitiesUnrelated { logs });
    }
    warnings
}

/// Changes of height, and the paths of deck and vehicle in the same windows (m).
struct Windows {
    height_m: Vec<f64>,
    deck_m: Vec<f64>,
    vehicle_m: Vec<f64>,
}

impl Windows {
    fn of(trial: &GroundTrial) -> Self {
        let time = &trial.time_s;
        let path = |velocity: &[f64], from: usize, to: usize| -> f64 {
            let step = |i: usize| 0.5 * (velocity[i] + velocity[i + 1]) * (time[i + 1] - time[i]);
            (from..to).map(step).sum()
        };
        let mut windows = Self {
            height_m: Vec::new(),
            deck_m: Vec::new(),
            vehicle_m: Vec::new(),
        };
        let mut from = 0;
        while from < time.len() {
            let to = time.partition_point(|t| *t < time[from] + WINDOW_S);
            if to >= time.len() {
                break;
            }
            // A window over a hole in the log is longer.
            if time[to] - time[from] < 2.0 * WINDOW_S {
                windows
                    .height_m
                    .push(trial.height_m[to] - trial.height_m[from]);
                windows
                    .deck_m
                    .push(path(&trial.deck_velocity_mps, from, to));
                windows
                    .vehicle_m
                    .push(path(&trial.vehicle_velocity_mps, from, to));
            }
            from = to;
        }
        windows
    }

    /// Change of height by the velocities, with a sign of each.
    fn path(&self, deck: f64, vehicle: f64) -> Vec<f64> {
        let pairs = self.deck_m.iter().zip(&self.vehicle_m);
        pairs.map(|(p, q)| vehicle * q - deck * p).collect()
    }
}

impl Verdict {
    fn of(trial: &GroundTrial) -> Self {
        let windows = Windows::of(trial);
        let changes = trial.height_m.windows(2).map(|w| w[1] - w[0]);
        let (moved, noise) = (rms(windows.height_m.iter().copied()), rms(changes));
        let few = windows.height_m.len() < LEAST_WINDOWS;
        if few || moved < LEAST_RATE_MPS * WINDOW_S || moved < MOVES * noise {
            return Self::Fits;
        }
        let fit = |deck, vehicle| correlation(&windows.path(deck, vehicle), &windows.height_m);
        let path = windows.path(1.0, 1.0);
        if path.iter().all(|p| *p == 0.0) {
            return Self::Missing(moved / WINDOW_S);
        }
        if fit(1.0, 1.0) > SAME {
            let factor = rms(path.into_iter()) / moved;
            return match (SAME_UNIT[0]..=SAME_UNIT[1]).contains(&factor) {
                true => Self::Fits,
                false => Self::Unit(factor),
            };
        }
        let flips = [
            (fit(-1.0, 1.0), vec![DECK]),
            (fit(1.0, -1.0), vec![VEHICLE]),
            (fit(-1.0, -1.0), vec![DECK, VEHICLE]),
        ];
        // A channel that is zero has no sign; of equal fits the first is taken, of one channel.
        let zero = [&windows.deck_m, &windows.vehicle_m].map(|c| c.iter().all(|p| *p == 0.0));
        let best = flips.into_iter().filter(|(_, channels)| {
            !(zero[0] && channels.contains(&DECK) || zero[1] && channels.contains(&VEHICLE))
        });
        match best.max_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((fit, channels)) if fit > SAME => Self::Flipped(channels),
            _ => Self::Unrelated,
        }
    }

    fn missing(&self) -> Option<f64> {
        match self {
            Self::Missing(rate_mps) => Some(*rate_mps),
            _ => None,
        }
    }

    fn factor(&self) -> Option<f64> {
        match self {
            Self::Unit(factor) => Some(*factor),
            _ => None,
        }
    }
}

/// Root mean square; 0 of nothing.
fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0_usize), |(s, n), v| (s + v * v, n + 1));
    (sum / count.max(1) as f64).sqrt()
}

/// Correlation of two changes about zero; 0 where one of them is none.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let product: f64 = a.iter().zip(b).map(|(x, y)| x * y).sum();
    let scale = a.len() as f64 * rms(a.iter().copied()) * rms(b.iter().copied());
    if scale > 0.0 { product / scale } else { 0.0 }
}
