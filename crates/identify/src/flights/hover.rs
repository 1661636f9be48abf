//! Ground effect from hovers at rest, for logs without specific force. In hover thrust is weight, so what the motors are asked
//! for at a height, against what they are asked for far above, is the ratio of thrusts.
//!
//! ```text
//! T0(u) (1 + G(z)) = m g (1 + a/g)/cos(tilt),    T0 ∝ n² (rotor speed), a thrust card's, or s^e (throttle)
//! ```
//!
//! Scale and height error of each armed interval are free, as everywhere in [`super`]. Neither a lag nor an effect of
//! climb shows in hovers: they are refused.

use rand_distr::{Distribution as _, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng as _;
use touchdown_model::Card;

use super::drift::{Drift, drift_name};
use super::fit::{Fit, fit};
pub use super::rest::{Hover, ThrustLaw};
use super::selection::{Candidate, ModelSelection};

use super::ground::{Basis, GroundEffect, slowest_throttle_s};
use super::model::{Curve, ModelTerms, Segment};
use super::phases::Phases;
use super::resampling::{FEWEST, Resampling, below};
use super::rest::{REST_MPS, SHORTEST_S, hovers, roots};
use super::segments::{Excluded, left_out};
use super::{Flight, FlightSettings};
use crate::error::{Error, Result};
use crate::refusal::{NoForce, Refusal};
use crate::thrust::plateau::median;

/// Hovers below this number of rotor radii are near the ground: more than for a curve, for each
/// hover gives a single height. Half would leave vehicles with legs one height at most.
const HOVER_NEAR_RADII: f64 = 3.0;
/// Two hovers this far apart are at different heights (R).
/// The effect changes by a fifth over it. Half takes two readings of one hover for a slope.
const APART_RADII: f64 = 0.3;
/// Exponent of thrust by throttle where nothing else is known: about that of rotor speed, 2.
/// Two standard deviations reach from 0.9 (thrust commands) to 2.9 (speed commands above a dead zone of 0.15, in hover at 0.5).
const EXPONENT: [f64; 2] = [1.9, 0.5];
/// Standard deviation of an exponent that is known.
/// Small against everything else, yet not singular.
const KNOWN: f64 = 1e-3;
/// Draws for intervals at most: each is a fit.
/// The standard error is then known to 4 %; four times the draws, and the time, give 2 %.
const MOST_DRAWS: usize = 400;

/// Identifies the ground effect from hovers at rest. `card` gives the thrust out of ground effect; without it, rotor speed
/// does, and without that throttle, by a power that is hardly known.
///
/// # Errors
/// Logs without hovers near the ground and out of its effect: the message says what was found, and what to record.
pub(super) fn ground_effect(
    flights: &[Flight],
    settings: &FlightSettings,
    rotor_radius_m: f64,
    card: Option<&Card>,
    why: NoForce,
) -> Result<GroundEffect> {
    let name = super::ground::label(flights);
    let phases: Vec<Phases> = flights.iter().map(|f| Phases::of(f, settings)).collect();
    let (law, mut hovers) = all_hovers(flights, &phases, card, settings)?;
    check(&name, &hovers, rotor_radius_m, settings, why)?;
    let of_time = hovers.iter().any(|h| h.battery_v.is_none());
    let (pieces, hover_throttle) = segments(flights, &phases, &hovers, rotor_radius_m, settings);
    // Hovers cannot tell the exponent from the curve: it stays where it is, and every draw takes another.
    let [exponent, exponent_sd] = match law {
        ThrustLaw::Throttle => EXPONENT,
        ThrustLaw::RotorSpeed | ThrustLaw::Card => [2.0, KNOWN],
    };
    let (fit, tried) = select(&name, &pieces, exponent, of_time, settings)?;
    let spread = spread(&fit, &pieces, exponent_sd, settings);
    put_ratios(&mut hovers, &pieces, &fit);
    let range = crate::fitted::range(hovers.iter().map(|h| h.height_m));
    let found = GroundEffect {
        basis: Basis::Hovers { law },
        drift_of_time: of_time,
        rotor_radius_m,
        lag: None,
        noise: None,
        range_latency_s: None,
        left_out: outside(flights, &phases, &hovers),
        phases,
        pieces,
        hover_throttle,
        throttle_period_s: slowest_throttle_s(flights),
        fit,
        spread,
        tried,
        refused: refused(law, why),
        heights_m: range.unwrap_or([0.0, 0.0]),
        hovers,
    };
    found.check_significant(&name, settings)?;
    Ok(found)
}

/// The hovers of all flights, and what thrust out of ground effect is taken from.
fn all_hovers(
    flights: &[Flight],
    phases: &[Phases],
    card: Option<&Card>,
    settings: &FlightSettings,
) -> Result<(ThrustLaw, Vec<Hover>)> {
    let mut all = Vec::new();
    let mut laws = Vec::new();
    for (index, (flight, phases)) in flights.iter().zip(phases).enumerate() {
        let (law, root) = roots(flight, card)?;
        all.extend(hovers(index, flight, phases, &root, settings));
        laws.push(law);
    }
    let law = laws.first().copied().unwrap_or(ThrustLaw::Throttle);
    if laws.iter().all(|l| *l == law) {
        return Ok((law, all));
    }
    Err(Error::data(
        super::ground::label(flights),
        "rotor speeds in all logs or in none",
        "some with and some without: identify them separately",
    ))
}

/// Hovers as the rows of segments, and the throttle of hover out of ground effect.
fn segments(
    flights: &[Flight],
    phases: &[Phases],
    hovers: &[Hover],
    rotor_radius_m: f64,
    settings: &FlightSettings,
) -> (Vec<Segment>, f64) {
    let far = |h: &&Hover| h.height_m > settings.reference_radii * rotor_radius_m;
    let of_far = |value: fn(&Hover) -> f64| median(hovers.iter().filter(far).map(value));
    let reference = of_far(|h| h.root).unwrap_or(1.0);
    let volts = median(hovers.iter().filter_map(|h| h.battery_v));
    let all_volts = hovers.iter().all(|h| h.battery_v.is_some());
    let segment = |ours: &[Hover]| {
        let of = |value: &dyn Fn(&Hover) -> f64| ours.iter().map(value).collect::<Vec<f64>>();
        let (flight, run) = (ours[0].flight, ours[0].run);
        let drift_m = phases[flight].runs[run].drift_m;
        let time_s = of(&|h| 0.5 * (h.from_s + h.to_s));
        let drift = match volts.filter(|_| all_volts) {
            Some(mean) => Drift::Voltage(of(&|h| h.battery_v.unwrap_or(mean) - mean)),
            None => Drift::of_time(&time_s, flights[flight].time_s[0]),
        };
        Segment {
            flight,
            run,
            throttle: of(&|h| h.root / reference),
            logged_throttle: Vec::new(),
            height: of(&|h| h.height_m / rotor_radius_m),
            climb_mps: Vec::new(),
            drift,
            on_s: None,
            force: of(&|h| h.load),
            accelerometer: false,
            range_m: Vec::new(),
            climb_measured_mps: Vec::new(),
            tilt_rad: Vec::new(),
            rows: (0..ours.len()).collect(),
            bias_sd: settings.height_bias_radii.hypot(drift_m / rotor_radius_m),
            time_s,
        }
    };
    let same = |a: &Hover, b: &Hover| (a.flight, a.run) == (b.flight, b.run);
    let pieces = hovers.chunk_by(same).map(segment).collect();
    (pieces, of_far(|h| h.throttle).unwrap_or(0.5))
}

/// The model that predicts held-out flights best, and all that were tried.
fn select(
    name: &str,
    pieces: &[Segment],
    exponent: f64,
    of_time: bool,
    settings: &FlightSettings,
) -> Result<(Fit, Vec<Candidate>)> {
    let mut plain = ModelTerms::plain(Curve::Exponential, false, false);
    plain.exponent = [exponent, KNOWN];
    let mut choice = ModelSelection::start(pieces, plain, settings.reference_radii);
    let shape = ModelTerms {
        battery: true,
        ..plain
    };
    choice.offer(drift_name(of_time), shape, false);
    // Bounded rationals reach far beyond the heights of hovers: a tail there is the same as another scale.
    let shape = ModelTerms {
        curve: Curve::Empirical,
        ..choice.best.shape
    };
    choice.offer(Curve::Empirical.name(), shape, true);
    let fit = choice.best;
    if fit.converged && fit.theta.iter().all(|v| v.is_finite()) {
        return Ok((fit, choice.tried));
    }
    Err(Error::data(
        name,
        "hovers that identify a model",
        format!("no convergence after {} steps", fit.steps),
    ))
}

/// The ratio of thrusts of each hover: what is measured, on the curve of the model.
fn put_ratios(hovers: &mut [Hover], pieces: &[Segment], fit: &Fit) {
    let values = fit.values();
    let modelled = fit.predict(pieces).concat();
    let heights = pieces
        .iter()
        .zip(&fit.locals)
        .flat_map(|(p, l)| p.height.iter().map(|z| z + l.bias));
    for ((hover, model), z) in hovers.iter_mut().zip(modelled).zip(heights) {
        hover.ratio = hover.load / model * (1.0 + values.at_rest(z));
    }
}

/// Hovers near the ground at two heights, and out of its effect, in one run.
fn check(
    name: &str,
    hovers: &[Hover],
    rotor_radius_m: f64,
    settings: &FlightSettings,
    why: NoForce,
) -> Result<()> {
    let m = |radii: f64| radii * rotor_radius_m;
    let reference_m = m(settings.reference_radii);
    let whole = |near: &&Hover| {
        near.height_m < m(HOVER_NEAR_RADII)
            && hovers.iter().any(|far| {
                (far.flight, far.run) == (near.flight, near.run) && far.height_m > reference_m
            })
    };
    let near = crate::fitted::range(hovers.iter().filter(whole).map(|h| h.height_m));
    if near.is_some_and(|[lo, hi]| hi - lo > m(APART_RADII)) {
        return Ok(());
    }
    let found = if hovers.is_empty() {
        "none: no steady segment".to_string()
    } else {
        let mut heights: Vec<f64> = hovers.iter().map(|h| h.height_m).collect();
        heights.sort_by(f64::total_cmp);
        heights.dedup_by(|a, b| (*a - *b).abs() < m(APART_RADII));
        let text: Vec<String> = heights.iter().take(8).map(|h| format!("{h:.3}")).collect();
        format!("{} hovers, at {} m", hovers.len(), text.join(", "))
    };
    Err(Error::data(
        name,
        format!(
            "steady hovers of {SHORTEST_S} s or more (climb below {REST_MPS} m/s), without landing in between: at two heights or more \
             below {:.3} m ({HOVER_NEAR_RADII} rotor radii) and above {reference_m:.3} m ({} rotor radii), {}: record some seconds of hover at 0.5, 1, 2 and {} rotor radii in one flight, or {}",
            m(HOVER_NEAR_RADII),
            settings.reference_radii,
            why.only_hovers(),
            settings.reference_radii + 2.0,
            why.record()
        ),
        found,
    ))
}

/// Resampled hovers, and the exponent and the zero of heights within what is known of them; each draw is fitted. From three flights
/// on, resampled flights beside them tell how much flights differ beyond their hovers.
fn spread(
    found: &Fit,
    pieces: &[Segment],
    exponent_sd: f64,
    settings: &FlightSettings,
) -> Resampling {
    let mut random = Pcg64::seed_from_u64(settings.seed);
    let count = pieces.iter().map(|p| p.rows.len()).sum();
    let mut refitted = |draw: &dyn Fn(&mut Pcg64) -> Vec<Segment>| -> Vec<Vec<f64>> {
        (0..settings.resamples.min(MOST_DRAWS))
            .filter_map(|_| {
                let drawn = draw(&mut random);
                let mut shape = found.shape;
                let white: f64 = StandardNormal.sample(&mut random);
                shape.exponent[0] = (shape.exponent[0] + exponent_sd * white).max(0.5);
                let from = Fit {
                    locals: Vec::new(),
                    ..found.clone()
                };
                let again = fit(&drawn, shape, Some(&from));
                again.converged.then_some(again.theta)
            })
            .collect()
    };
    let of_hovers = refitted(&|random| pieces.iter().map(|p| drawn(p, random)).collect());
    let mut flights: Vec<usize> = pieces.iter().map(|p| p.flight).collect();
    flights.dedup();
    let of_flights = (flights.len() >= FEWEST).then(|| {
        refitted(&|random| {
            let chosen = (0..flights.len()).map(|_| flights[below(random, flights.len())]);
            let mut chosen: Vec<Segment> = chosen
                .flat_map(|f| pieces.iter().filter(move |p| p.flight == f).cloned())
                .collect();
            chosen.iter_mut().for_each(|p| shift(p, random));
            chosen
        })
    });
    Resampling::of_hovers(count, of_hovers, flights.len(), of_flights)
}

/// An armed interval with its hovers resampled.
fn drawn(piece: &Segment, random: &mut Pcg64) -> Segment {
    let n = piece.rows.len();
    let mut rows: Vec<usize> = (0..n).map(|_| below(random, n)).collect();
    rows.sort_unstable();
    let pick = |c: &[f64]| rows.iter().map(|&i| c[i]).collect::<Vec<_>>();
    let mut out = Segment {
        time_s: pick(&piece.time_s),
        throttle: pick(&piece.throttle),
        height: pick(&piece.height),
        drift: piece.drift.pick(&rows),
        force: pick(&piece.force),
        ..piece.clone()
    };
    shift(&mut out, random);
    out
}

/// Draws the zero of an armed interval's heights. A fit puts it where its prior is, for hovers tell a common error of all heights
/// from another curve hardly at all.
fn shift(piece: &mut Segment, random: &mut Pcg64) {
    let white: f64 = StandardNormal.sample(random);
    piece
        .height
        .iter_mut()
        .for_each(|z| *z += piece.bias_sd * white);
}

/// What hovers do not identify.
fn refused(law: ThrustLaw, why: NoForce) -> Vec<Refusal> {
    let mut refused = vec![Refusal::LagsFromHovers(why), Refusal::ClimbFromHovers(why)];
    if law == ThrustLaw::Throttle {
        let [exponent, exponent_sd] = EXPONENT;
        refused.push(Refusal::ThrustLawAssumed {
            exponent,
            exponent_sd,
        });
    }
    refused
}

/// The unused rows: those without flight, and flight that is not at rest.
fn outside(flights: &[Flight], phases: &[Phases], hovers: &[Hover]) -> Vec<Excluded> {
    let mut out = Vec::new();
    for (index, (flight, phases)) in flights.iter().zip(phases).enumerate() {
        out.extend(left_out(flight, phases));
        for (number, run) in phases.runs.iter().enumerate() {
            let mut from_s = flight.time_s[run.rows[0]];
            let to_s = flight.time_s[run.rows[1]];
            let ours = hovers
                .iter()
                .filter(|h| (h.flight, h.run) == (index, number));
            for (a, b) in ours.map(|h| (h.from_s, h.to_s)).chain([(to_s, to_s)]) {
                if a - from_s > SHORTEST_S {
                    out.push(Excluded {
                        log: flight.name.clone(),
                        from_s,
                        to_s: a,
                        why: "not at rest, or the height is not known".into(),
                    });
                }
                from_s = b;
            }
        }
    }
    out
}
