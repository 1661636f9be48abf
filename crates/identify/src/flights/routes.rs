//! Routes to the ground effect: each takes the thrust from another sensor, so routes of the same flights check one another.
//!
//! | route | thrust from |
//! | --- | --- |
//! | accelerometer | specific force |
//! | poses | the motion of the height, without the accelerometer |
//! | rotor speed | its square, in hovers at rest |
//! | card | a thrust card and the throttle, in hovers at rest |
//!
//! Two routes differ where a quantity differs by more than the root of the sum of their squared half intervals. Routes share
//! heights and turbulence, so their errors correlate and this bound is not exceeded by chance more often than one in twenty.

use serde::Serialize;
use touchdown_model::Card;
use touchdown_trial::Trial;

use super::ground::{
    Basis, GroundEffect, from_force, ground_effect_with, radius_of_flights_with_height,
    slowest_throttle_s,
};
use super::hover::{self, ThrustLaw};
use super::{Flight, FlightSettings, ForceFrom};
use crate::error::{Error, Result};
use crate::estimate::Estimate;
use crate::refusal::NoForce;
use crate::warning::{Warning, sentences};

/// Heights at which routes are compared, in rotor radii.
const COMPARED_RADII: [f64; 3] = [0.5, 1.0, 2.0];
/// Share of a route's interval below which another route that agrees with it is taken although it lacks numbers that the first
/// has: hovers give neither lag nor climb damping, poses no damping, so a few per cent of certainty are no gain. At 1 chance decides
/// whether there is a lag; at a quarter a range finder of 10 mm would keep an interval that rotor speed makes four times narrower.
const MORE_CERTAIN: f64 = 0.5;

/// Extra lift at one height over that out of ground effect.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct LiftAt {
    /// Height (rotor radii).
    pub radii: f64,
    /// Height (m).
    pub height_m: f64,
    /// Thrust over that out of ground effect, minus one.
    #[serde(flatten)]
    pub lift: Estimate,
}

/// What one route found.
#[derive(Clone, Debug, Serialize)]
pub struct Route {
    /// What the thrust is from.
    pub basis: Basis,
    /// Whether the results are those of this route.
    pub taken: bool,
    /// Extra lift at the heights that its data reach.
    pub extra_lift: Vec<LiftAt>,
    /// Lag of the wake (s), where it was identified.
    pub lag_s: Option<Estimate>,
    /// Why the route has no result.
    pub refused: Option<String>,
}

impl Route {
    /// Its numbers with their intervals, in words.
    #[must_use]
    pub fn numbers(&self) -> Vec<String> {
        let lifts = self.extra_lift.iter().map(|at| {
            let [value, low, high] =
                [at.lift.value, at.lift.ci95[0], at.lift.ci95[1]].map(|v| 100.0 * v);
            format!(
                "extra lift {value:.1} % ({low:.1} to {high:.1}) at {:.3} m",
                at.height_m
            )
        });
        let lag = self.lag_s.map(|lag| {
            let [low, high] = lag.ci95;
            format!("lag of the wake {:.3} s ({low:.3} to {high:.3})", lag.value)
        });
        lifts.chain(lag).collect()
    }
}

/// The ground effect by the route that was taken, with all routes.
#[derive(Clone, Debug)]
pub struct Routed {
    /// The flights as the taken route read them.
    pub flights: Vec<Flight>,
    /// The ground effect by that route.
    pub found: GroundEffect,
    /// All routes that the logs allow, the preferred one first.
    pub routes: Vec<Route>,
    /// Where routes differ by more than their errors.
    pub warnings: Vec<Warning>,
}

/// Identifies the ground effect by every route that the logs allow; see [`super::ground_effect_with`] for the preferred one.
///
/// Of routes that differ, the one that agrees with most others is taken, the preferred one if there are several. Of routes that
/// agree, the one with the narrowest interval is taken; one that lacks a number only where it is less than half as wide.
///
/// # Errors
/// Logs that identify no ground effect by any route: the message is that of the preferred route.
pub fn ground_effect_by_routes(
    trials: &[&Trial],
    settings: &FlightSettings,
    card: Option<&Card>,
) -> Result<Routed> {
    let flights: Vec<Flight> = trials
        .iter()
        .map(|trial| Flight::of(trial, settings))
        .collect::<Result<_>>()?;
    let radius_m = radius_of_flights_with_height(&flights, settings)?;
    let first = ground_effect_with(&flights, settings, card);
    let possible = possible(&flights, settings, card);
    let preferred = match (&first, possible.first()) {
        (Ok(found), _) => found.basis,
        (Err(_), Some(basis)) => *basis,
        (Err(_), None) => return first.map(|found| Routed::alone(flights, found)),
    };
    let mut tried = vec![Tried {
        basis: preferred,
        flights: flights.clone(),
        found: first,
    }];
    for basis in possible.into_iter().filter(|b| *b != preferred) {
        tried.push(Tried::of(basis, trials, &flights, settings, radius_m, card));
    }
    taken(tried, settings)
}

/// One route that was tried.
struct Tried {
    basis: Basis,
    flights: Vec<Flight>,
    found: Result<GroundEffect>,
}

impl Tried {
    fn of(
        basis: Basis,
        trials: &[&Trial],
        flights: &[Flight],
        settings: &FlightSettings,
        radius_m: f64,
        card: Option<&Card>,
    ) -> Self {
        let (flights, found) = match basis {
            Basis::Accelerometer => (
                flights.to_vec(),
                from_force(flights, settings, radius_m, basis),
            ),
            Basis::Poses => {
                let read = trials.iter().map(|t| without_accelerometer(t, settings));
                match read.collect::<Result<Vec<Flight>>>() {
                    Ok(flights) => {
                        let found = by_poses(&flights, settings, radius_m);
                        (flights, found)
                    }
                    Err(error) => (flights.to_vec(), Err(error)),
                }
            }
            Basis::Hovers { law } => {
                let card = card.filter(|_| law == ThrustLaw::Card);
                let found =
                    hover::ground_effect(flights, settings, radius_m, card, NoForce::Beside);
                (flights.to_vec(), found)
            }
        };
        Self {
            basis,
            flights,
            found,
        }
    }

    fn route(&self, settings: &FlightSettings, taken: bool) -> Route {
        let (extra_lift, lag_s) = self.found.as_ref().map_or_else(
            |_| (Vec::new(), None),
            |found| (lifts(found, settings), found.lag_s()),
        );
        Route {
            basis: self.basis,
            taken,
            extra_lift,
            lag_s,
            refused: self.found.as_ref().err().map(ToString::to_string),
        }
    }
}

impl Routed {
    fn alone(flights: Vec<Flight>, found: GroundEffect) -> Self {
        Self {
            flights,
            found,
            routes: Vec::new(),
            warnings: Vec::new(),
        }
    }
}

/// The routes that the sensors of the logs allow, the preferred one first.
fn possible(flights: &[Flight], settings: &FlightSettings, card: Option<&Card>) -> Vec<Basis> {
    let all = |of: fn(&Flight) -> bool| flights.iter().all(of);
    let quick = slowest_throttle_s(flights) * settings.least_rate_hz <= 1.0;
    let measured = all(|f| f.force_from == ForceFrom::Accelerometer);
    let by = |law| Basis::Hovers { law };
    let of_card = card.map(|_| by(ThrustLaw::Card));
    let of_speed = all(|f| !f.rotor_rpm.is_empty()).then(|| by(ThrustLaw::RotorSpeed));
    let of_poses = quick.then_some(Basis::Poses);
    if measured {
        let of_force = quick.then_some(Basis::Accelerometer);
        let routes = [of_force, of_poses, of_speed, of_card];
        routes.into_iter().flatten().collect()
    } else {
        let routes = [of_card, of_speed, of_poses];
        routes.into_iter().flatten().collect()
    }
}

/// The flight as it is read where the log has no accelerometer.
fn without_accelerometer(trial: &Trial, settings: &FlightSettings) -> Result<Flight> {
    let mut trial = trial.clone();
    if trial.channel("specific_force_mps2").is_some() {
        trial.insert("specific_force_mps2", vec![f64::NAN; trial.len()])?;
    }
    Flight::of(&trial, settings)
}

fn by_poses(flights: &[Flight], settings: &FlightSettings, radius_m: f64) -> Result<GroundEffect> {
    let moved = |f: &&Flight| f.force_from != ForceFrom::Poses;
    if let Some(still) = flights.iter().find(moved) {
        let found = match sentences(&still.notes) {
            notes if notes.is_empty() => "none".to_string(),
            notes => notes.join("; "),
        };
        return Err(Error::data(
            &still.name,
            "heights that give an acceleration",
            found,
        ));
    }
    from_force(flights, settings, radius_m, Basis::Poses)
}

/// Extra lift at the heights of comparison that the data reach.
fn lifts(found: &GroundEffect, settings: &FlightSettings) -> Vec<LiftAt> {
    let r = found.rotor_radius_m;
    let [lowest, highest] = found.heights_m;
    let far_m = (settings.reference_radii * r).min(highest);
    let at = |radii: f64| {
        let height_m = radii * r;
        let lift = found.extra_lift([height_m; 2], [far_m; 2])?;
        let known = lift.ci95.iter().all(|v| v.is_finite());
        (height_m >= lowest && known).then_some(LiftAt {
            radii,
            height_m,
            lift,
        })
    };
    COMPARED_RADII.into_iter().filter_map(at).collect()
}

/// Pairs of lifts at the heights that both routes have.
fn common<'a>(a: &'a Route, b: &'a Route) -> impl Iterator<Item = (f64, Estimate, Estimate)> + 'a {
    let same = |l: &LiftAt| {
        let other = b.extra_lift.iter().find(|o| o.radii == l.radii)?;
        Some((l.radii, l.lift, other.lift))
    };
    a.extra_lift.iter().filter_map(same)
}

fn half_width(e: Estimate) -> f64 {
    0.5 * (e.ci95[1] - e.ci95[0])
}

/// Difference of two estimates of one quantity over their errors.
fn distance(a: Estimate, b: Estimate) -> f64 {
    (a.value - b.value).abs() / half_width(a).hypot(half_width(b))
}

/// What two routes differ in by more than their errors: the lift where it does so most, and the lag.
fn differences(a: &Route, b: &Route) -> Vec<Warning> {
    let lift = common(a, b)
        .map(|(radii, a, b)| (Some(radii), a, b))
        .max_by(|(_, a, b), (_, c, d)| distance(*a, *b).total_cmp(&distance(*c, *d)));
    let lag = a.lag_s.zip(b.lag_s).map(|(a, b)| (None, a, b));
    let all = lift.into_iter().chain(lag);
    all.filter(|(_, a, b)| distance(*a, *b) > 1.0)
        .map(|(radii, ours, theirs)| Warning::RoutesDiffer {
            radii,
            taken: (a.basis.name(), ours),
            other: (b.basis.name(), theirs),
        })
        .collect()
}

/// Whether the first gives every number that the second gives: lifts, lag, climb damping.
fn gives_as_much(a: &Route, b: &Route) -> bool {
    let damping = |r: &Route| r.basis == Basis::Accelerometer;
    common(a, b).count() == b.extra_lift.len()
        && a.lag_s.is_some() >= b.lag_s.is_some()
        && damping(a) >= damping(b)
}

/// Whether the first is the more certain one; by far, where it gives fewer numbers.
fn more_certain(a: &Route, b: &Route) -> bool {
    let (ours, theirs) = common(a, b).fold((0.0, 0.0), |(ours, theirs), (_, a, b)| {
        (ours + half_width(a), theirs + half_width(b))
    });
    let share = if gives_as_much(a, b) {
        1.0
    } else {
        MORE_CERTAIN
    };
    ours < share * theirs
}

/// Index of the route that is taken, among those with a result.
fn best(routes: &[Route]) -> Option<usize> {
    let valid: Vec<usize> = (0..routes.len())
        .filter(|&k| routes[k].refused.is_none())
        .collect();
    let agree = |a: usize, b: usize| {
        common(&routes[a], &routes[b]).next().is_some()
            && differences(&routes[a], &routes[b]).is_empty()
    };
    let friends = |&k: &usize| valid.iter().filter(|&&o| o != k && agree(k, o)).count();
    let most = valid.iter().map(friends).max()?;
    let mut best = valid.iter().copied().find(|k| friends(k) == most)?;
    for &k in &valid {
        if agree(k, best) && more_certain(&routes[k], &routes[best]) {
            best = k;
        }
    }
    Some(best)
}

fn taken(mut tried: Vec<Tried>, settings: &FlightSettings) -> Result<Routed> {
    let mut routes: Vec<Route> = tried.iter().map(|t| t.route(settings, false)).collect();
    let Some(best) = best(&routes) else {
        let first = tried.swap_remove(0);
        return first.found.map(|found| Routed::alone(first.flights, found));
    };
    routes[best].taken = true;
    let others = routes.iter().filter(|r| !r.taken);
    let warnings = others.flat_map(|other| differences(&routes[best], other));
    let warnings = warnings.collect();
    let chosen = tried.swap_remove(best);
    Ok(Routed {
        found: chosen.found?,
        flights: chosen.flights,
        routes,
        warnings,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn route(basis: Basis, lifts: [f64; 3], half: f64) -> Route {
        let lift = |(radii, value): (f64, f64)| LiftAt {
            radii,
            height_m: 0.1 * radii,
            lift: Estimate {
                value,
                std_error: 0.5 * half,
                ci95: [value - half, value + half],
            },
        };
        Route {
            basis,
            taken: false,
            extra_lift: COMPARED_RADII.into_iter().zip(lifts).map(lift).collect(),
            lag_s: None,
            refused: None,
        }
    }

    const SPEED: Basis = Basis::Hovers {
        law: ThrustLaw::RotorSpeed,
    };
    const LIFTS: [f64; 3] = [0.09, 0.05, 0.02];

    #[test]
    fn analytic_routes_that_agree_and_the_one_that_is_far_more_certain() {
        let wide = route(Basis::Accelerometer, LIFTS, 0.010);
        let narrow = route(SPEED, LIFTS.map(|l| l + 0.005), 0.004);
        assert!(differences(&wide, &narrow).is_empty());
        assert_eq!(best(&[wide.clone(), narrow.clone()]), Some(1));
        // As certain as the other, nearly: the preferred route keeps its climb damping.
        let as_narrow = route(SPEED, LIFTS, 0.006);
        assert_eq!(best(&[wide, as_narrow]), Some(0));
    }

    #[test]
    fn analytic_of_routes_with_the_same_numbers_the_more_certain_one_is_taken() {
        let speed = route(SPEED, LIFTS, 0.006);
        let poses = route(Basis::Poses, LIFTS, 0.005);
        assert_eq!(best(&[speed.clone(), poses.clone()]), Some(1));
        // Poses that give a lag of the wake, or a lift that hovers do not give, are given up for half the interval only.
        let lag = Route {
            lag_s: Some(poses.extra_lift[0].lift),
            ..poses.clone()
        };
        let narrower = route(SPEED, LIFTS, 0.004);
        assert_eq!(best(&[lag.clone(), narrower.clone()]), Some(0));
        let mut higher = narrower.clone();
        higher.extra_lift.remove(0);
        assert_eq!(best(&[poses.clone(), higher]), Some(0));
        assert_eq!(best(&[poses, narrower]), Some(1));
        assert_eq!(best(&[speed, lag]), Some(1));
    }

    #[test]
    fn analytic_a_route_that_differs_is_outvoted_and_named() {
        let wrong = route(Basis::Accelerometer, LIFTS.map(|l| 2.0 * l), 0.004);
        let poses = route(Basis::Poses, LIFTS, 0.010);
        let speed = route(SPEED, LIFTS.map(|l| l + 0.002), 0.006);
        // 0.02 to 0.09 apart, the root of the sum of squares is 0.011. The greatest is at half a radius.
        assert_eq!(differences(&poses, &wrong).len(), 1);
        // Of the two that agree, the more certain one.
        assert_eq!(best(&[wrong.clone(), poses.clone(), speed]), Some(2));
        // Of two, nobody knows which is wrong, however certain one is.
        let certain = route(SPEED, LIFTS, 0.001);
        assert_eq!(best(&[wrong, certain]), Some(0));
    }

    #[test]
    fn analytic_a_refused_route_is_neither_taken_nor_compared() {
        let mut refused = route(Basis::Accelerometer, LIFTS, 0.004);
        refused.extra_lift.clear();
        refused.refused = Some("noise".into());
        let poses = route(Basis::Poses, LIFTS, 0.010);
        assert_eq!(best(&[refused.clone(), poses.clone()]), Some(1));
        assert!(differences(&poses, &refused).is_empty());
        assert_eq!(best(&[refused]), None);
    }
}
