//! What a user should know of a fit: the data of each warning, and its sentence.

use crate::map_line::map_line;
use std::fmt;

use crate::estimate::Estimate;
use crate::refusal::Refusal;

/// What a user should know of a fit.
#[derive(Clone, Debug, PartialEq)]
pub enum Warning {
    /// Thrust falls towards the highest throttle.
    SupplyLimit {
        /// Greatest thrust (N).
        most_n: f64,
        /// Its throttle.
        at: f64,
        /// Thrust at the highest throttle (N).
        top_n: f64,
        /// The highest throttle.
        top: f64,
    },
    /// Points on the way up and on the way down lie on different curves.
    Hysteresis {
        /// Mean residual of ascending and of descending points.
        residuals: [f64; 2],
        /// Their unit.
        unit: &'static str,
    },
    /// The rotor's lag could not be fitted.
    NoRotorLag {
        /// Why.
        why: String,
    },
    /// The sparse fit kept the whole library.
    NoTermEliminated {
        /// Terms of the library.
        terms: usize,
    },
    /// A lag is at a bound of its search.
    LagAtBound {
        /// The lag (s).
        lag_s: f64,
    },
    /// The thrust answers before its command is logged.
    AnswersEarly {
        /// By how much (s).
        early_s: f64,
    },
    /// The answer to steps is not that of one lag.
    NotOneLag {
        /// Residuals after steps in units of those on plateaus.
        ratio: f64,
    },
    /// A lag that sampling and excitation do not resolve.
    LagBelow {
        /// Its 95 % upper bound (s).
        bound_s: f64,
    },
    /// A dead time is at a bound of its search.
    DeadTimeAtBound {
        /// The dead time (s).
        dead_time_s: f64,
    },
    /// A thrust that no stand of one rotor measures, unless it is in grams.
    Grams {
        /// Greatest thrust (N).
        most_n: f64,
    },
    /// A thrust that falls while the throttle rises.
    ThrottleInverted {
        /// The lowest and the highest throttle.
        throttle: [f64; 2],
        /// The fitted thrust at rest at both (N).
        thrust_n: [f64; 2],
    },
    /// Single thrusts that no rotor explains, left out.
    ThrustSpikes {
        /// How many.
        count: usize,
        /// Time of the first (s).
        at_s: f64,
    },
    /// A load cell stands at the end of its range; its rows are left out.
    LoadCellSaturated {
        /// Thrust at which it stands (N).
        limit_n: f64,
        /// How many rows.
        rows: usize,
    },
    /// Thrust changes along a log at the same throttle.
    ThrustDrifts {
        /// Change from its start to its end, as a share of the thrust.
        share: f64,
        /// Duration of the log (s).
        over_s: f64,
    },
    /// A log repeats the thrust of a slower sensor.
    ThrustRepeats {
        /// Time between measurements (s).
        period_s: f64,
    },
    /// Rows count as points at rest while the thrust still settles.
    UnsettledRows {
        /// Time for which a throttle stays (s).
        held_s: f64,
        /// Time after a change until the thrust counts as settled (s).
        settle_s: f64,
    },
    /// A log joins the thrust of a slower sensor by lines.
    ThrustJoined {
        /// Time between measurements (s).
        period_s: f64,
    },
    /// Nothing says how many rotors a stand measured.
    OneRotorAssumed,
    /// A search ended before its minimum.
    NotConverged,
    /// A model whose free run leaves its data.
    Diverged {
        /// Greatest value of the free run.
        most: f64,
        /// Its unit.
        unit: &'static str,
    },
    /// There are no intervals, because there are not more logs than coefficients.
    TooFewLogs {
        /// How many there are.
        logs: usize,
        /// Coefficients that they estimate.
        coefficients: usize,
    },
    /// A lag and an effect of the deck's velocity are confounded.
    LagConfounded {
        /// The two parameters.
        pair: [String; 2],
        /// The correlation of their estimates.
        correlation: f64,
    },
    /// Terms that are zero throughout the data.
    ZeroTerms(Vec<String>),
    /// Errors of the force bias a regression on its derivative.
    Attenuated {
        /// The force's own coefficient (1/s).
        pole_per_s: f64,
        /// Share of the derivative's variance that is explained.
        r_squared: f64,
    },
    /// The card's rationals miss the fitted curve.
    CurveMissed {
        /// The curve's name.
        curve: &'static str,
        /// Greatest error over greatest value.
        share: f64,
    },
    /// The card takes the vehicle's climb for the deck's velocity.
    ClimbForDeckVelocity,
    /// A quantity that the flights do not identify.
    NotIdentified(Refusal),
    /// No noise of a sensor explains the errors of the heights, so the fit is along the heights as logged.
    HeightsOfFilter,
    /// The ground moved below flights that do not show the wake's lag.
    MovingGroundWithoutLag,
    /// A throttle that was logged less often than the acceleration.
    ThrottleBetweenRows {
        /// Time between two values of the throttle (s).
        period_s: f64,
    },
    /// Commands that act earlier than their log and its period explain.
    ThrottleLoggedLate {
        /// How long before the log (s).
        late_s: f64,
    },
    /// An accelerometer whose latency is longer than what is harmless behind a filter.
    AccelerometerLate {
        /// As found (s).
        latency_s: f64,
    },
    /// A range whose latency is longer than what range finders and their links take.
    RangeLate {
        /// As found (s).
        latency_s: f64,
    },
    /// Thrust at one throttle differs from one armed interval to the next.
    ThrustScatter {
        /// Standard deviation over mean.
        share: f64,
    },
    /// Thrust drifts with time.
    DriftWithTime {
        /// Relative change in `over_s`.
        share: f64,
        /// Time (s).
        over_s: f64,
    },
    /// Thrust depends on the battery's voltage.
    DriftWithVoltage {
        /// Relative change for each volt.
        share_per_v: f64,
    },
    /// A log without throttle has the speed of the rotors.
    SpeedForThrottle,
    /// Poses are too noisy for an acceleration.
    NoisyPoses {
        /// Standard deviation that it would have (gravities).
        noise_g: f64,
        /// The greatest that is used.
        most_g: f64,
    },
    /// The accelerometer's mean over a flight is not the vehicle's weight.
    ForceOffWeight {
        /// Mean vertical specific force (gravities).
        mean_g: f64,
        /// What it is between (gravities).
        expected: [f64; 2],
    },
    /// Heights that were dropped as spikes of the sensor.
    HeightSpikes(usize),
    /// In all data the vehicle stood still.
    VehicleStoodStill,
    /// Two routes to the ground effect of the same flights differ by more than their errors.
    RoutesDiffer {
        /// Height of an extra lift (rotor radii); absent for the lag of the wake.
        radii: Option<f64>,
        /// The route that was taken.
        taken: (&'static str, Estimate),
        /// The other one.
        other: (&'static str, Estimate),
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::SupplyLimit {
                most_n,
                at,
                top_n,
                top,
            } => write!(
                f,
                "falls at the highest throttles: supply limit ({most_n:.2} N at throttle {at:.3}, {top_n:.2} N at {top:.3})"
            ),
            Self::Hysteresis {
                residuals: [up, down],
                unit,
            } => write!(
                f,
                "ascending points lie {up:+.4} {unit} off the fit on average, descending ones {down:+.4} {unit}"
            ),
            Self::NoRotorLag { why } => write!(f, "no lag of the rotor was fitted: {why}"),
            Self::NoTermEliminated { terms } => write!(
                f,
                "no term was eliminated: all {terms} of the library are kept"
            ),
            Self::LagAtBound { lag_s } => write!(
                f,
                "the lag {lag_s:.4} s is at its bound: the data do not identify it"
            ),
            Self::AnswersEarly { early_s } => write!(
                f,
                "the thrust answers about {early_s:.3} s before its throttle is logged: the lag is not known, and the static curve may \
                 err. Log the throttle when it is sent, and by the clock of the load cell"
            ),
            Self::NotOneLag { ratio } => write!(
                f,
                "after steps the thrust errs {ratio:.1} times as much as on plateaus: it does not answer with one lag, and the lag \
                 found may err beyond its interval. Causes are hysteresis, a speed controller that limits how fast its output changes, \
                 a filter of the load cell, throttle that changes between the rows of the log"
            ),
            Self::LagBelow { bound_s } => write!(
                f,
                "the lag is below {bound_s:.4} s: sampling and excitation show no more. Log steps of throttle at 100 Hz or more"
            ),
            Self::DeadTimeAtBound { dead_time_s } => write!(
                f,
                "the dead time {dead_time_s:.4} s is at its bound: the data do not identify it"
            ),
            Self::Grams { most_n } => write!(
                f,
                "thrust of up to {most_n:.0} N from one rotor: is it in grams? Then {}",
                map_line("thrust_n", "9.80665e-3 * ", "")
            ),
            Self::ThrottleInverted {
                throttle: [low, high],
                thrust_n: [at_low_n, at_high_n],
            } => write!(
                f,
                "thrust falls from {at_low_n:.2} N at throttle {low:.3} to {at_high_n:.2} N at {high:.3}: is the throttle inverted? \
                 Then {}",
                map_line("throttle", "1 - ", "")
            ),
            Self::ThrustSpikes { count, at_s } => write!(
                f,
                "{count} thrusts leap away and back faster than any rotor, the first at {at_s:.3} s: spikes of the load cell, left out"
            ),
            Self::LoadCellSaturated { limit_n, rows } => write!(
                f,
                "the thrust stands at {limit_n} N in {rows} rows: the load cell is at the end of its range. These rows are left out, and the \
                 card ends at the throttle of that thrust"
            ),
            Self::ThrustDrifts { share, over_s } => write!(
                f,
                "at the same throttle the thrust changes by {:+.1} % in the {over_s:.0} s of a log: the load cell drifts, the battery sags, or the form \
                 misses a throttle that becomes quicker. Curve, lag and dead time may lie outside their intervals. Set the load cell to zero before each run \
                 and check it after, log battery_v, or use a supply",
                100.0 * share
            ),
            Self::ThrustRepeats { period_s } => write!(
                f,
                "the log repeats each thrust until the next measurement, {period_s:.3} s later; only the first row of each counts"
            ),
            Self::UnsettledRows { held_s, settle_s } => write!(
                f,
                "each throttle stays for {held_s:.2} s, and the thrust counts as settled {settle_s} s after a change: rows count as points at rest \
                 while it still settles, so the curve and its intervals are wrong by that. Hold each throttle for a second and more, log the thrust \
                 at 20 Hz or more and let the form be chosen, or lower settle_s where the rotor is faster"
            ),
            Self::ThrustJoined { period_s } => write!(
                f,
                "the log joins thrusts that are measured every {period_s:.3} s by lines; only the measurements count, where the lines meet"
            ),
            Self::OneRotorAssumed => f.write_str(
                "the thrust is taken for that of one rotor, because nothing says how many were measured. If it is that of more, \
                 state `measured_rotors` in the table [vehicle] of the map or of the settings, and identify again",
            ),
            Self::NotConverged => f.write_str(
                "the fit ended before its minimum: its coefficients have no intervals",
            ),
            Self::Diverged { most, unit } => write!(
                f,
                "the model diverges in free run ({most:.3e} {unit}): it does not fly"
            ),
            Self::TooFewLogs { logs, coefficients } => write!(
                f,
                "no intervals: errors are correlated within a log, so each log counts once, and {logs} are too few for {coefficients} \
                 coefficients. Record at least {}",
                coefficients + 1
            ),
            Self::LagConfounded {
                pair: [a, b],
                correlation,
            } => write!(
                f,
                "lag and deck velocity are confounded: the estimates of `{a}` and `{b}` correlate with {correlation:.2}"
            ),
            Self::ZeroTerms(terms) => write!(
                f,
                "left out, for they are zero throughout the data: {}",
                terms.join(", ")
            ),
            Self::Attenuated {
                pole_per_s,
                r_squared,
            } => write!(
                f,
                "regression on derivatives: errors in the measured force pull its coefficient towards zero (here \
                 {pole_per_s:.3} 1/s); R² of the derivative is {r_squared:.2}"
            ),
            Self::CurveMissed { curve, share } => write!(
                f,
                "the bounded rationals of the card miss the fitted {curve} curve by {:.0} % of its greatest value",
                100.0 * share
            ),
            Self::ClimbForDeckVelocity => f.write_str(
                "k is the climb damping of the vehicle, the same at all heights; the card uses it for the deck's velocity, \
                 reversed: an approximation where the deck moves",
            ),
            Self::NotIdentified(refusal) => refusal.fmt(f),
            Self::SpeedForThrottle => f.write_str(
                "no throttle: the speed of the rotors over its greatest value stands in its place",
            ),
            Self::NoisyPoses { noise_g, most_g } => write!(
                f,
                "no acceleration from poses: their noise would be {noise_g:.2} g in it, above {most_g} g"
            ),
            Self::ForceOffWeight {
                mean_g,
                expected: [low, high],
            } => write!(
                f,
                "the specific force is {mean_g:.3} g on average with motors on, expected {low} to {high} g: thrust in newtons is as \
                 far off. Check the scale of the accelerometer and the mapping of `specific_force_mps2`"
            ),
            Self::HeightSpikes(count) => write!(
                f,
                "{count} heights leap away and back faster than anything flies: spikes of the sensor, left out"
            ),
            Self::VehicleStoodStill => f.write_str(
                "The vehicle stood still in all data, so only the deck's velocity v_p was identified. In flight \
                 `negative_relative` feeds v_p - v_q in its place: an approximation, for the deck's upwash decays with height \
                 and the damping of the vehicle's own climb does not.",
            ),
            Self::RoutesDiffer {
                radii,
                taken,
                other,
            } => routes_differ(f, *radii, [*taken, *other]),
            Self::HeightsOfFilter => f.write_str(
                "the errors of the heights are not those of a sensor, but of an estimate: the motor lag, the lag of the wake, the climb damping, \
                 the decay and the extra lift may lie outside their intervals. Log the range or the motion capture as the \
                 sensor gives it",
            ),
            Self::MovingGroundWithoutLag => f.write_str(
                "the ground moved, and the lag of the wake is not known: a vehicle that only descends meets the extra lift late, which may then lie above its \
                 interval, most of all beyond one rotor radius. Fly quick climbs and descents below two rotor radii",
            ),
            Self::ThrottleBetweenRows { period_s } => write!(
                f,
                "throttle was logged every {period_s:.3} s, less often than the acceleration: where commands changed in between, the motor lag is too \
                 short by up to {:.3} s, and the climb damping and the lag of the wake may lie outside their intervals. Log the throttle as often \
                 as the controller commands it",
                period_s / 3.0
            ),
            Self::ThrottleLoggedLate { late_s } => write!(
                f,
                "the motors answer {late_s:.3} s before the throttle is logged: its stamps are late, and the dead time is not known. Log the \
                 throttle and the acceleration with stamps of one clock"
            ),
            Self::AccelerometerLate { latency_s } => write!(
                f,
                "the accelerometer comes about {latency_s:.3} s after the height: if a low-pass filter delays it, the climb damping, the extra \
                 lift and the lags of motors and wake may lie outside their intervals; if the throttle is not as late, so may the dead time. Log \
                 height, throttle and acceleration with stamps of one clock, and the acceleration before low-pass filters"
            ),
            Self::RangeLate { latency_s } => write!(
                f,
                "the height comes about {latency_s:.3} s after acceleration and throttle: the lag of the wake, the climb damping and the lag of \
                 the motors may lie outside their intervals. Log the range with the stamp of its measurement, by the clock of the accelerometer"
            ),
            Self::ThrustScatter { share } => write!(
                f,
                "thrust at one throttle differs from run to run by {:.1} % (standard deviation)",
                100.0 * share
            ),
            Self::DriftWithTime { share, over_s } => write!(
                f,
                "thrust changes by {:.1} % in {over_s} s; the card is for the start of the logs",
                100.0 * share
            ),
            Self::DriftWithVoltage { share_per_v } => write!(
                f,
                "thrust changes by {:.1} % per volt of the battery; the card is for the mean voltage of the flights",
                100.0 * share_per_v
            ),
        }
    }
}

/// Where two routes differ, and what may be wrong.
fn routes_differ(
    f: &mut fmt::Formatter<'_>,
    radii: Option<f64>,
    routes: [(&'static str, Estimate); 2],
) -> fmt::Result {
    let (what, by, unit, digits) = match radii {
        Some(radii) => (format!("extra lift at {radii} rotor radii"), 100.0, " %", 1),
        None => ("lag of the wake".to_string(), 1.0, " s", 3),
    };
    let [taken, other] = routes.map(|(route, e)| {
        let [value, low, high] = [e.value, e.ci95[0], e.ci95[1]].map(|v| by * v);
        format!("{value:.digits$}{unit} ({low:.digits$} to {high:.digits$}) by {route}")
    });
    write!(
        f,
        "{what}: {taken}, but {other}; they differ by more than their errors, so one of the two is wrong. Check the scale of \
         the accelerometer and of the height, that the ground below stood still, and that a thrust card is of this vehicle"
    )
}

/// The sentences of warnings.
#[must_use]
pub fn sentences(warnings: &[Warning]) -> Vec<String> {
    warnings.iter().map(ToString::to_string).collect()
}
