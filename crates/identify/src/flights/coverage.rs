//! Whether flights contain enough heights near the ground and out of its effect.

use super::model::Segment;
use super::{Flight, FlightSettings};
use crate::error::{Error, Result};

/// A curve needs heights below this number of rotor radii, where the effect is several per cent of thrust. Half refuses vehicles
/// with long legs; twice accepts flights without ground effect, which fail later.
pub(super) const CURVE_NEAR_RADII: f64 = 2.0;
/// Least time near the ground (s): a few take-offs.
/// Half is a single bounce; twice refuses quick take-offs that do identify the effect together.
const LEAST_NEAR_S: f64 = 0.5;
/// Least spread of heights near the ground, in rotor radii.
/// The effect falls by a quarter to a third over it. Half leaves slope and height error confounded.
const LEAST_SPREAD_RADII: f64 = 0.5;
/// Standing height, in rotor radii, above which the zero of heights is in question. Half names the noise of a range finder,
/// twice is silent about legs whose effect is a third.
const STANDS_RADII: f64 = 0.5;
/// Least time out of ground effect (s).
/// Sixteen lags of the motors, so that the scale is of settled thrust.
const LEAST_FAR_S: f64 = 1.0;

/// How long, and over which heights (in R), segments fly near the ground and out of its effect.
struct Coverage {
    heights: [f64; 2],
    near_s: f64,
    far_s: f64,
    /// Time near the ground, and its heights, in segments that fly out of ground effect as well: every segment has a scale
    /// of its own, and only one that has both identifies scale and curve.
    whole_s: f64,
    near_heights: [f64; 2],
}

impl Coverage {
    fn of(flights: &[Flight], pieces: &[Segment], settings: &FlightSettings) -> Self {
        const NONE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];
        let mut out = Self {
            heights: NONE,
            near_s: 0.0,
            far_s: 0.0,
            whole_s: 0.0,
            near_heights: NONE,
        };
        for piece in pieces {
            let step_s = flights[piece.flight].step_s();
            let (mut near, mut far) = (0.0, 0.0);
            let mut near_heights = NONE;
            for z in piece.rows.iter().map(|&i| piece.height[i]) {
                widen(&mut out.heights, [z, z]);
                if z < CURVE_NEAR_RADII {
                    near += step_s;
                    widen(&mut near_heights, [z, z]);
                }
                far += if z > settings.reference_radii {
                    step_s
                } else {
                    0.0
                };
            }
            out.near_s += near;
            out.far_s += far;
            if far >= LEAST_FAR_S {
                out.whole_s += near;
                widen(&mut out.near_heights, near_heights);
            }
        }
        out
    }
}

/// Where the vehicle stands in the logs, and the setting that makes it zero; nothing where that is zero already.
fn standing(stood_m: Option<f64>, rotor_radius_m: f64, settings: &FlightSettings) -> String {
    let stood_m = stood_m.filter(|m| m.abs() > STANDS_RADII * rotor_radius_m);
    stood_m.map_or_else(String::new, |m| {
        format!(
            "; the vehicle stands at {m:.3} m: set `flight.height_offset_m = {:.3}`, so that heights count from there",
            settings.height_offset_m - m
        )
    })
}

fn widen(range: &mut [f64; 2], by: [f64; 2]) {
    *range = [range[0].min(by[0]), range[1].max(by[1])];
}

/// Heights near the ground and out of its effect, both for long enough; gives the least and the greatest (m). `stood_m` is the
/// height at which the vehicle stands.
pub(super) fn check_heights(
    name: &str,
    flights: &[Flight],
    pieces: &[Segment],
    rotor_radius_m: f64,
    stood_m: Option<f64>,
    settings: &FlightSettings,
) -> Result<[f64; 2]> {
    let m = |radii: f64| radii * rotor_radius_m;
    let (near_m, far_m) = (m(CURVE_NEAR_RADII), m(settings.reference_radii));
    let flown = Coverage::of(flights, pieces, settings);
    let Coverage {
        near_s,
        far_s,
        whole_s,
        ..
    } = flown;
    let [lo, hi] = flown.heights.map(m);
    let [near_lo, near_hi] = flown.near_heights.map(m);
    let (expected, found) = if near_s < LEAST_NEAR_S {
        (
            format!(
                "flight below {near_m:.3} m (two rotor radii) for {LEAST_NEAR_S} s or more: record hover of some seconds at 0.5, 1 and 2 \
                 rotor radii, or slow landings"
            ),
            format!(
                "{near_s:.1} s; heights {lo:.3} to {hi:.3} m{}",
                standing(stood_m, rotor_radius_m, settings)
            ),
        )
    } else if far_s < LEAST_FAR_S {
        (
            format!(
                "flight above {far_m:.3} m ({} rotor radii) for {LEAST_FAR_S} s or more, as the reference out of ground effect: \
                 record some seconds of hover there",
                settings.reference_radii
            ),
            format!("{far_s:.1} s; heights {lo:.3} to {hi:.3} m"),
        )
    } else if whole_s < LEAST_NEAR_S {
        (
            format!(
                "flights both below {near_m:.3} m and above {far_m:.3} m for {LEAST_NEAR_S} s and {LEAST_FAR_S} s without landing in between: thrust \
                 differs from run to run of the motors, and near and far of different runs do not compare"
            ),
            format!(
                "{near_s:.1} s near and {far_s:.1} s far, of which {whole_s:.1} s near in runs that have both"
            ),
        )
    } else if near_hi - near_lo < m(LEAST_SPREAD_RADII) {
        (
            format!(
                "heights below {near_m:.3} m (two rotor radii) that differ by {:.3} m or more: record hover at 0.5, 1 and 2 rotor radii, \
                 or slow landings",
                m(LEAST_SPREAD_RADII)
            ),
            format!("{near_lo:.3} to {near_hi:.3} m"),
        )
    } else {
        return Ok([lo, hi]);
    };
    Err(Error::data(name, expected, found))
}
