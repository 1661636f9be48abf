//! Landings that are known, and what sensors read of them.

use touchdown_flight::{Attitude, Vector};
use touchdown_lander::estimate::relative::{
    DeckPrior, GnssVelocity, ImuSample, RangeModel, RangeReading, Reading, RelativeEstimate,
    RelativeFilter, RelativeState, TagModel, TagReading,
};

pub(crate) const G: f64 = 9.81;
pub(crate) const DT: f64 = 0.01;

pub(crate) type V = Vector<f64>;
pub(crate) type State = RelativeState<f64, 32, 64>;

/// A landing that is known: a descent with a sway, over a heaving deck.
pub(crate) struct Truth {
    pub(crate) heave_m: f64,
    pub(crate) heave_rad_s: f64,
}

/// What is true at a moment.
#[derive(Clone, Copy)]
pub(crate) struct Moment {
    pub(crate) position: V,
    pub(crate) velocity: V,
    pub(crate) deck_velocity: f64,
    pub(crate) deck_height: f64,
    pub(crate) attitude: Attitude<f64>,
}

impl Truth {
    pub(crate) fn at(&self, t: f64) -> Moment {
        let (w, a) = (self.heave_rad_s, self.heave_m);
        let altitude = 1.5 + 0.8 * (0.4 * t).cos();
        let deck_height = a * (w * t).sin();
        Moment {
            position: V::new(
                0.3 * (0.9 * t).sin(),
                0.2 * (1.3 * t).cos(),
                altitude - deck_height,
            ),
            velocity: V::new(
                0.27 * (0.9 * t).cos(),
                -0.26 * (1.3 * t).sin(),
                -0.32 * (0.4 * t).sin(),
            ),
            deck_velocity: a * w * (w * t).cos(),
            deck_height,
            attitude: Attitude::from_rotation_vector(V::new(
                0.1 * (1.1 * t).sin(),
                0.08 * (0.7 * t).cos(),
                0.3,
            )),
        }
    }

    /// The IMU over the step that ends at t: the mean force, seen at its end.
    pub(crate) fn imu(&self, t: f64, bias: V) -> ImuSample<f64> {
        let (before, now) = (self.at(t - DT), self.at(t));
        let mean = (now.velocity - before.velocity) * (1.0 / DT);
        ImuSample {
            specific_force_mps2: now.attitude.unrotate(mean + V::UP * G + bias),
            attitude: now.attitude,
        }
    }

    /// The range finder of the filter, over a level deck.
    pub(crate) fn range(
        &self,
        filter: &RelativeFilter<f64>,
        t: f64,
        age_s: f64,
    ) -> RangeReading<f64> {
        let now = self.at(t);
        let sensor = now.position + now.attitude.rotate(filter.range.position_m);
        let beam = now.attitude.rotate(filter.range.direction);
        RangeReading::level(sensor.z / -beam.z, age_s)
    }

    /// The tag as the filter's camera sees it.
    pub(crate) fn tag(&self, filter: &RelativeFilter<f64>, t: f64, age_s: f64) -> TagReading<f64> {
        let now = self.at(t);
        let body = now.attitude.unrotate(-now.position) - filter.tag.position_m;
        TagReading {
            position_m: filter.tag.attitude.unrotate(body),
            covariance_m2: [[1e-6, 0.0, 0.0], [0.0, 1e-6, 0.0], [0.0, 0.0, 1e-6]],
            age_s,
        }
    }
}

pub(crate) const PAPER_DECK: Truth = Truth {
    heave_m: 0.05,
    heave_rad_s: std::f64::consts::PI,
};
pub(crate) const STILL: Truth = Truth {
    heave_m: 0.0,
    heave_rad_s: 1.0,
};

pub(crate) fn mounted() -> RelativeFilter<f64> {
    RelativeFilter {
        range: RangeModel {
            position_m: V::new(0.05, -0.02, -0.04),
            quantum_m: 0.0,
            ..RangeModel::default()
        },
        tag: TagModel {
            position_m: V::new(-0.03, 0.01, -0.05),
            ..TagModel::default()
        },
        ..RelativeFilter::default()
    }
}

pub(crate) fn still(filter: RelativeFilter<f64>) -> RelativeFilter<f64> {
    RelativeFilter {
        deck: DeckPrior {
            heave_velocity_sd_mps: 0.0,
            ..DeckPrior::default()
        },
        ..filter
    }
}

/// Every `every` steps.
pub(crate) fn due(step: usize, every: usize) -> bool {
    step.is_multiple_of(every)
}

pub(crate) fn worst(estimate: &RelativeEstimate<f64>, truth: &Moment) -> [f64; 2] {
    let velocity = truth.velocity - V::UP * truth.deck_velocity;
    [
        (estimate.position_m - truth.position).norm(),
        (estimate.relative_velocity_mps() - velocity).norm(),
    ]
}

/// Readings without noise at 50, 30 and 5 Hz, as old as given.
pub(crate) fn readings(
    truth: &Truth,
    filter: &RelativeFilter<f64>,
    step: usize,
    ages: [f64; 3],
) -> Vec<Reading<f64>> {
    let t = step as f64 * DT;
    let mut all = Vec::new();
    if due(step, 2) {
        all.push(Reading::Range(truth.range(filter, t - ages[0], ages[0])));
    }
    if due(step, 3) {
        all.push(Reading::Tag(truth.tag(filter, t - ages[1], ages[1])));
    }
    if due(step, 20) {
        all.push(Reading::Gnss(GnssVelocity {
            velocity_mps: truth.at(t - ages[2]).velocity,
            age_s: ages[2],
        }));
    }
    all
}
