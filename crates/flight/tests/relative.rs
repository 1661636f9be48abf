//! The relative estimator against truth.

mod common;

use common::noise::Noise;
use proptest::prelude::*;
use touchdown_flight::estimate::relative::{
    BarometerReading, DeckPrior, GnssVelocity, ImuModel, ImuSample, RangeModel, RangeReading,
    Reading, RelativeEstimate, RelativeFilter, RelativeState, TagModel, TagReading,
};
use touchdown_flight::{Attitude, Real, Vector};

const G: f64 = 9.81;
const DT: f64 = 0.01;

type V = Vector<f64>;
type State = RelativeState<f64, 32, 64>;

/// A landing that is known: a descent with a sway, over a heaving deck.
struct Truth {
    heave_m: f64,
    heave_rad_s: f64,
}

/// What is true at a moment.
#[derive(Clone, Copy)]
struct Moment {
    position: V,
    velocity: V,
    deck_velocity: f64,
    deck_height: f64,
    attitude: Attitude<f64>,
}

impl Truth {
    fn at(&self, t: f64) -> Moment {
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
    fn imu(&self, t: f64, bias: V) -> ImuSample<f64> {
        let (before, now) = (self.at(t - DT), self.at(t));
        let mean = (now.velocity - before.velocity) * (1.0 / DT);
        ImuSample {
            specific_force_mps2: now.attitude.unrotate(mean + V::UP * G + bias),
            attitude: now.attitude,
        }
    }

    /// The range finder of the filter, over a level deck.
    fn range(&self, filter: &RelativeFilter<f64>, t: f64, age_s: f64) -> RangeReading<f64> {
        let now = self.at(t);
        let sensor = now.position + now.attitude.rotate(filter.range.position_m);
        let beam = now.attitude.rotate(filter.range.direction);
        RangeReading::level(sensor.z / -beam.z, age_s)
    }

    /// The tag as the filter's camera sees it.
    fn tag(&self, filter: &RelativeFilter<f64>, t: f64, age_s: f64) -> TagReading<f64> {
        let now = self.at(t);
        let body = now.attitude.unrotate(-now.position) - filter.tag.position_m;
        TagReading {
            position_m: filter.tag.attitude.unrotate(body),
            covariance_m2: [[1e-6, 0.0, 0.0], [0.0, 1e-6, 0.0], [0.0, 0.0, 1e-6]],
            age_s,
        }
    }
}

const PAPER_DECK: Truth = Truth {
    heave_m: 0.05,
    heave_rad_s: std::f64::consts::PI,
};
const STILL: Truth = Truth {
    heave_m: 0.0,
    heave_rad_s: 1.0,
};

fn mounted() -> RelativeFilter<f64> {
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

fn still(filter: RelativeFilter<f64>) -> RelativeFilter<f64> {
    RelativeFilter {
        deck: DeckPrior {
            heave_velocity_sd_mps: 0.0,
            ..DeckPrior::default()
        },
        ..filter
    }
}

/// Every `every` steps.
fn due(step: usize, every: usize) -> bool {
    step.is_multiple_of(every)
}

fn worst(estimate: &RelativeEstimate<f64>, truth: &Moment) -> [f64; 2] {
    let velocity = truth.velocity - V::UP * truth.deck_velocity;
    [
        (estimate.position_m - truth.position).norm(),
        (estimate.relative_velocity_mps() - velocity).norm(),
    ]
}

/// Readings without noise at 50, 30 and 5 Hz, as old as given.
fn readings(
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

#[test]
fn analytic_noise_free_over_a_deck_at_rest() {
    let filter = still(mounted());
    filter.validate().unwrap();
    let mut state: State = filter.initial();
    let bias = V::new(0.02, -0.03, 0.04);
    let mut last = None;
    for step in 1..=2000 {
        let t = step as f64 * DT;
        let all = readings(&STILL, &filter, step, [0.02, 0.055, 0.12]);
        let estimate = filter.step(&mut state, &STILL.imu(t, bias), &all, DT);
        if step > 500 {
            let [position, velocity] = worst(&estimate, &STILL.at(t));
            // The mean force of a step moves the place by j dt³/12 less than 1e-7 m a
            // step; the biases are still settling at 5 s.
            assert!(
                position < 3e-4 && velocity < 2e-3,
                "{t}: {position} {velocity}"
            );
        }
        last = Some(estimate);
    }
    let estimate = last.unwrap();
    // Learnt from the place alone, within what its standard deviation leaves.
    assert!((estimate.bias_mps2 - bias).norm() < 1e-3);
    let health = filter.health(&state);
    assert!(!health.diverged && health.range.fresh && health.tag.fresh && health.gnss.fresh);
    assert_eq!(
        health.range.rejected + health.tag.rejected + health.gnss.rejected,
        0
    );
}

#[test]
fn analytic_noise_free_over_the_heaving_deck() {
    let filter = mounted();
    let mut state: State = filter.initial();
    let mut sum = [0.0; 3];
    for step in 1..=2000 {
        let t = step as f64 * DT;
        let all = readings(&PAPER_DECK, &filter, step, [0.02, 0.055, 0.12]);
        let estimate = filter.step(&mut state, &PAPER_DECK.imu(t, V::ZERO), &all, DT);
        if step > 500 {
            let truth = PAPER_DECK.at(t);
            let [position, velocity] = worst(&estimate, &truth);
            // The prior's acceleration 0.6 m/s² that is not known over the age of 20 ms
            // and the filter's lag of twice as much: a t²/2 = 1 mm, a t = 36 mm/s.
            assert!(
                position < 2e-3 && velocity < 0.03,
                "{t}: {position} {velocity}"
            );
            sum[0] += position * position;
            sum[1] += velocity * velocity;
            sum[2] += (estimate.deck_velocity_mps.z - truth.deck_velocity).powi(2);
        }
    }
    // Two thirds of the largest; the deck's velocity has the error of the difference.
    let rms = sum.map(|s| (s / 1500.0).sqrt());
    assert!(rms[0] < 1.4e-3 && rms[1] < 0.02 && rms[2] < 0.02, "{rms:?}");
}

/// The same readings, delivered `late` after they were made.
fn delivered(late: [usize; 3], until: usize) -> RelativeEstimate<f64> {
    let filter = mounted();
    let mut state: State = filter.initial();
    let mut estimate = None;
    let mut noise = Noise::new(7);
    // Noise belongs to the reading, not to its delivery.
    let noisy: Vec<f64> = (0..=until).map(|_| 0.01 * noise.normal()).collect();
    for step in 1..=until {
        let t = step as f64 * DT;
        let mut all = Vec::new();
        for (kind, (late, every)) in late.into_iter().zip([2, 3, 20]).enumerate() {
            if step <= late + 5 {
                continue;
            }
            let made = step - late;
            if !due(made, every) || made > until - 20 {
                continue;
            }
            let (then, age) = (made as f64 * DT, late as f64 * DT);
            all.push(match kind {
                0 => {
                    let mut range = PAPER_DECK.range(&filter, then, age);
                    range.distance_m += noisy[made];
                    Reading::Range(range)
                }
                1 => Reading::Tag(PAPER_DECK.tag(&filter, then, age)),
                _ => Reading::Gnss(GnssVelocity {
                    velocity_mps: PAPER_DECK.at(then).velocity,
                    age_s: age,
                }),
            });
        }
        estimate = Some(filter.step(&mut state, &PAPER_DECK.imu(t, V::ZERO), &all, DT));
    }
    estimate.unwrap()
}

#[test]
fn analytic_delays_are_compensated_exactly() {
    // Late readings, out of order, lead to where punctual ones do.
    let punctual = delivered([0, 0, 0], 500);
    for late in [[2, 0, 0], [0, 6, 0], [2, 6, 12], [13, 5, 1]] {
        let estimate = delivered(late, 500);
        let apart = (estimate.position_m - punctual.position_m).norm()
            + (estimate.velocity_mps - punctual.velocity_mps).norm()
            + (estimate.deck_velocity_mps - punctual.deck_velocity_mps).norm();
        // Readings of one moment are taken in another order, and times are sums of
        // steps: rounding of the filter's numbers, 1e-16 over 500 steps.
        assert!(apart < 1e-12, "{late:?}: {apart}");
    }
}

#[test]
fn analytic_a_wrong_delay_costs_speed_times_error() {
    // At a steady descent the place is wrong by the way of 50 ms.
    let filter = RelativeFilter {
        imu: ImuModel {
            bias_sd_mps2: 0.0,
            bias_walk: 0.0,
            ..ImuModel::default()
        },
        ..still(mounted())
    };
    let run = |claimed: f64| {
        let mut state: State = filter.initial();
        let imu = ImuSample {
            specific_force_mps2: V::UP * G,
            attitude: Attitude::LEVEL,
        };
        let mut height = 0.0;
        for step in 1..=600 {
            let t = f64::from(step) * DT;
            let distance = 5.0 - 0.5 * (t - 0.05) - 0.04;
            let range = Reading::Range(RangeReading::level(distance, claimed));
            height = filter.step(&mut state, &imu, &[range], DT).height_m();
        }
        height - (5.0 - 0.5 * 6.0)
    };
    // Steady motion: the filter has forgotten its start to 1e-6.
    assert!(run(0.05).abs() < 1e-5, "{}", run(0.05));
    assert!((run(0.0) - 0.025).abs() < 1e-4, "{}", run(0.0));
}

#[test]
fn analytic_readings_between_steps_and_ahead_of_the_imu() {
    let filter = mounted();
    let (a, b) = (0.004, 0.006);
    let accelerated = |t: f64| ImuSample {
        specific_force_mps2: V::new(0.3, -0.2, G + 0.5 + 0.0 * t),
        attitude: Attitude::LEVEL,
    };
    let range = |t: f64, age: f64| Reading::Range(RangeReading::level(2.0 + 0.3 * t, age));
    // Steps cut at the reading's time ...
    let mut cut: State = filter.initial();
    // ... and a reading that is 6 ms old at the end of a whole step.
    let mut whole: State = filter.initial();
    // ... and one that is newer than the IMU, which is 10 ms old.
    let delayed = RelativeFilter {
        imu: ImuModel {
            delay_s: DT,
            ..filter.imu
        },
        ..filter
    };
    let mut ahead: State = delayed.initial();
    let mut ends = [None; 3];
    for step in 0..300 {
        let t = f64::from(step) * DT;
        let imu = accelerated(t);
        let last = step == 299;
        filter.step(&mut cut, &imu, &[range(t + a, 0.0)], a);
        ends[0] = Some(filter.step(&mut cut, &imu, &[], b));
        ends[1] = Some(filter.step(&mut whole, &imu, &[range(t + a, b)], DT));
        // The sample over [t, t + dt] arrives at t + 2 dt; the reading of the next
        // interval is already there.
        let early = if step == 0 {
            vec![range(a, DT + b), range(DT + a, b)]
        } else {
            vec![range(t + DT + a, b)]
        };
        let early = if last { Vec::new() } else { early };
        ends[2] = Some(delayed.step(&mut ahead, &imu, &early, DT));
    }
    let [cut, whole, ahead] = ends.map(Option::unwrap);
    // Noise over cut steps is exact for the integrators and right to ω dt = 3 % of
    // the deck's share of a step otherwise.
    assert!((cut.height_m() - whole.height_m()).abs() < 1e-5);
    assert!((cut.velocity_mps - whole.velocity_mps).norm() < 1e-4);
    // The same computation.
    assert!((ahead.height_m() - whole.height_m()).abs() < 1e-12);
    assert!((ahead.velocity_mps - whole.velocity_mps).norm() < 1e-12);
}

#[test]
fn analytic_precision_of_a_fitted_line() {
    // No process noise: the filter is the least-squares line through the readings,
    // whose standard errors are known (here also the Cramér–Rao bound).
    let filter = RelativeFilter {
        imu: ImuModel {
            noise_density: 0.0,
            bias_sd_mps2: 0.0,
            bias_walk: 0.0,
            attitude_sd_rad: 0.0,
            ..ImuModel::default()
        },
        range: RangeModel {
            noise_sd_m: 0.02,
            quantum_m: 0.0,
            jitter_s: 0.0,
            ..RangeModel::default()
        },
        ..still(RelativeFilter::default())
    };
    let mut state: State = filter.initial();
    let mut noise = Noise::new(3);
    let imu = ImuSample {
        specific_force_mps2: V::UP * G,
        attitude: Attitude::LEVEL,
    };
    let n = 200;
    let (mut sums, mut last) = ([0.0; 2], None);
    for step in 1..=n {
        let x = f64::from(step) * DT;
        let y = 5.0 - 0.4 * x + 0.02 * noise.normal();
        let centred = x - DT * 0.5 * f64::from(n + 1);
        sums[0] += y;
        sums[1] += y * centred;
        let range = Reading::Range(RangeReading::level(y, 0.0));
        last = Some(filter.step(&mut state, &imu, &[range], DT));
    }
    let n = f64::from(n);
    let spread = DT * DT * n * (n * n - 1.0) / 12.0;
    let slope = sums[1] / spread;
    let end = sums[0] / n + slope * DT * 0.5 * (n - 1.0);
    let estimate = last.unwrap();
    // The prior of 10 m and 2 m/s weighs (0.02/10)²/200 and (0.017/2)².
    assert!((estimate.velocity_mps.z / slope - 1.0).abs() < 2e-4);
    assert!((estimate.height_m() - end).abs() < 1e-5);
    let sd = [
        0.02 * (2.0 * (2.0 * n - 1.0) / (n * (n + 1.0))).sqrt(),
        0.02 / spread.sqrt(),
    ];
    assert!((estimate.position_sd_m.z / sd[0] - 1.0).abs() < 1e-4);
    assert!((estimate.relative_velocity_sd_mps.z / sd[1] - 1.0).abs() < 1e-4);
}

#[test]
fn analytic_errors_are_as_large_as_the_filter_says() {
    // The filter's own model: white force noise, constant bias, a deck at rest,
    // delays. Normalised squared errors of 60 landings, mean 1.
    let filter = RelativeFilter {
        imu: ImuModel {
            bias_walk: 0.0,
            attitude_sd_rad: 0.0,
            ..ImuModel::default()
        },
        ..still(mounted())
    };
    let (mut sum, runs, mut outside) = ([0.0; 4], 100, 0);
    for seed in 0..runs {
        let mut noise = Noise::new(seed);
        let bias = V::from_array([(); 3].map(|()| 0.05 * noise.normal()));
        let mut state: State = filter.initial();
        let mut last = None;
        for step in 1..=600 {
            let t = step as f64 * DT;
            let mut imu = STILL.imu(t, bias);
            let white = [(); 3].map(|()| 0.02 / DT.sqrt() * noise.normal());
            imu.specific_force_mps2 += V::from_array(white);
            let mut all = readings(&STILL, &filter, step, [0.02, 0.05, 0.12]);
            for reading in &mut all {
                match reading {
                    Reading::Range(range) => range.distance_m += 0.005 * noise.normal(),
                    Reading::Tag(tag) => {
                        // Own 1 mm and 2 mm beside it, axis by axis.
                        let white = [(); 3].map(|()| 5e-6_f64.sqrt() * noise.normal());
                        tag.position_m += V::from_array(white);
                    }
                    Reading::Gnss(gnss) => {
                        gnss.velocity_mps += V::new(
                            0.1 * noise.normal(),
                            0.1 * noise.normal(),
                            0.15 * noise.normal(),
                        );
                    }
                    Reading::Barometer(_) => {}
                }
            }
            last = Some(filter.step(&mut state, &imu, &all, DT));
        }
        let (estimate, truth) = (last.unwrap(), STILL.at(6.0));
        let squares = [
            (estimate.height_m() - truth.position.z) / estimate.position_sd_m.z,
            (estimate.velocity_mps.z - truth.velocity.z) / estimate.velocity_sd_mps.z,
            (estimate.position_m.x - truth.position.x) / estimate.position_sd_m.x,
            (estimate.velocity_mps.x - truth.velocity.x) / estimate.velocity_sd_mps.x,
        ];
        for k in 0..4 {
            sum[k] += squares[k] * squares[k];
            outside += usize::from(squares[k].abs() > 1.96);
        }
        let health = filter.health(&state);
        for nis in [health.range.nis, health.tag.nis] {
            // Mean of about 39 squares: 1 ± 0.23 or less.
            assert!(nis > 0.2 && nis < 2.2, "{nis}");
        }
    }
    for mean in sum.map(|s| s / runs as f64) {
        // χ² of 100 degrees: 1 ± 0.14, four of them.
        assert!((mean - 1.0).abs() < 0.57, "{sum:?}");
    }
    // Binomial 400, 5 %: 20 ± 4.4 (pairs correlate: up to 6), four of them.
    assert!(outside < 44, "{outside}");
}

#[test]
fn analytic_geometry_of_range_and_tag() {
    // One exact reading, tilted vehicle, tilted deck, mounted sensors.
    let mut filter = still(mounted());
    filter.range.direction = V::new(0.1, -0.05, -1.0).direction().unwrap();
    filter.imu.attitude_sd_rad = 0.0;
    let attitude = Attitude::from_rotation_vector(V::new(0.15, -0.1, 0.7));
    let position = V::new(0.12, -0.3, 1.1);
    let normal = V::new(0.04, -0.03, 1.0).direction().unwrap();
    let sensor = position + attitude.rotate(filter.range.position_m);
    let beam = attitude.rotate(filter.range.direction);
    let distance_m = -normal.dot(sensor) / normal.dot(beam);
    let body = attitude.unrotate(-position) - filter.tag.position_m;
    let mut state: State = filter.initial();
    let imu = ImuSample {
        specific_force_mps2: attitude.unrotate(V::UP * G),
        attitude,
    };
    let tag = Reading::Tag(TagReading {
        position_m: filter.tag.attitude.unrotate(body),
        covariance_m2: [[1e-12; 3]; 3],
        age_s: 0.0,
    });
    let estimate = filter.step(&mut state, &imu, &[tag], DT);
    // Prior 10 m against noise 2 mm: (2e-4)² of 1 m.
    assert!((estimate.position_m - position).norm() < 1e-7);
    // The range agrees: nothing moves.
    let range = Reading::Range(RangeReading {
        distance_m,
        deck_normal: normal,
        age_s: 0.0,
    });
    let mut alone: State = filter.initial();
    for reading in [[tag, range], [range, tag]] {
        let estimate = filter.step(&mut alone, &imu, &reading, 0.0);
        assert!((estimate.position_m - position).norm() < 1e-6);
    }
    let health = filter.health(&alone);
    // Had one disagreed, the gate would have left it out.
    assert_eq!((health.range.used, health.tag.used), (2, 2));
    // The camera looks down: image right is the body's right, image down its rear.
    let camera = TagModel::<f64>::looking_down();
    let down = camera.rotate(V::UP);
    assert!((down + V::UP).norm() < 1e-15);
    assert!((camera.rotate(V::new(1.0, 0.0, 0.0)) - V::new(0.0, -1.0, 0.0)).norm() < 1e-15);
}

#[test]
fn analytic_outliers_divergence_and_restart() {
    let filter = mounted();
    let mut state: State = filter.initial();
    let run = |state: &mut State, steps: std::ops::Range<usize>, jump: f64| {
        for step in steps {
            let t = step as f64 * DT;
            let mut all = readings(&PAPER_DECK, &filter, step, [0.02, 0.05, 0.12]);
            for reading in &mut all {
                if let Reading::Range(range) = reading {
                    range.distance_m += jump;
                }
            }
            filter.step(state, &PAPER_DECK.imu(t, V::ZERO), &all, DT);
        }
        filter.health(state)
    };
    assert!(!run(&mut state, 1..300, 0.0).diverged);
    // One wild reading is left out and forgotten.
    let one = run(&mut state, 300..301, 1.0);
    assert_eq!((one.range.rejected, one.range.rejected_in_a_row), (1, 1));
    assert!(!one.diverged);
    assert_eq!(run(&mut state, 301..400, 0.0).range.rejected_in_a_row, 0);
    // A sensor that has jumped for good: ten readings of 50 Hz.
    let jumped = run(&mut state, 400..420, 1.0);
    assert!(jumped.diverged && !jumped.range.fresh);
    filter.restart(&mut state);
    let anew = run(&mut state, 420..600, 0.0);
    assert!(!anew.diverged && anew.range.fresh && anew.range.nis < 2.0);
    let estimate = filter.ahead(&state, 0.0);
    assert!((estimate.position_m - PAPER_DECK.at(5.99).position).norm() < 2e-3);
}

#[test]
fn analytic_nothing_not_finite_gets_in() {
    let filter = mounted();
    let mut state: State = filter.initial();
    for step in 1..200 {
        let all = readings(&STILL, &filter, step, [0.0; 3]);
        filter.step(&mut state, &STILL.imu(step as f64 * DT, V::ZERO), &all, DT);
    }
    let before = filter.ahead(&state, DT);
    let bad = [f64::NAN, f64::INFINITY];
    let mut all = Vec::new();
    for value in bad {
        all.push(Reading::Range(RangeReading::level(value, 0.0)));
        all.push(Reading::Range(RangeReading::level(1.0, value)));
        all.push(Reading::Tag(TagReading {
            position_m: V::new(0.0, value, 1.0),
            covariance_m2: [[0.0; 3]; 3],
            age_s: 0.0,
        }));
        all.push(Reading::Gnss(GnssVelocity {
            velocity_mps: V::new(value, 0.0, 0.0),
            age_s: 0.0,
        }));
        all.push(Reading::Barometer(BarometerReading {
            altitude_m: value,
            age_s: 0.0,
        }));
    }
    let imu = ImuSample {
        specific_force_mps2: V::new(0.0, 0.0, f64::NAN),
        attitude: Attitude::LEVEL,
    };
    let after = filter.step(&mut state, &imu, &all, DT);
    // The last acceleration is held, nothing else happened.
    assert_eq!(after, before);
    let health = filter.health(&state);
    assert_eq!(
        [
            health.imu.not_finite,
            health.range.not_finite,
            health.tag.not_finite
        ],
        [1, 4, 2]
    );
    assert_eq!(
        [health.gnss.not_finite, health.barometer.not_finite],
        [2, 2]
    );
    for _ in 0..10 {
        filter.step(&mut state, &imu, &[], DT);
    }
    let health = filter.health(&state);
    assert!(!health.imu.fresh && !health.diverged);
    // Ages grow by the time that passes.
    assert!((health.imu.age_s - 0.11).abs() < 1e-12);
}

#[test]
fn analytic_barometer_only_far_from_the_ground() {
    let filter = still(mounted());
    let imu = ImuSample {
        specific_force_mps2: V::UP * G,
        attitude: Attitude::LEVEL,
    };
    for (height, expected) in [(2.0, (0, 50)), (8.0, (50, 0))] {
        let mut state: State = filter.initial();
        for _ in 0..50 {
            let all = [
                Reading::Range(RangeReading::level(height, 0.0)),
                Reading::Barometer(BarometerReading {
                    altitude_m: 431.0,
                    age_s: 0.0,
                }),
            ];
            filter.step(&mut state, &imu, &all, DT);
        }
        let barometer = filter.health(&state).barometer;
        assert_eq!((barometer.used, barometer.unusable), expected);
    }
}

#[test]
fn analytic_too_old_and_too_many() {
    let filter = mounted();
    let mut state: RelativeState<f64, 8, 4> = filter.initial();
    let imu = STILL.imu(0.0, V::ZERO);
    for _ in 0..20 {
        filter.step(&mut state, &imu, &[], DT);
    }
    let range = |age: f64| Reading::Range(RangeReading::level(1.5, age));
    // Seven steps back are remembered, more are not.
    filter.step(&mut state, &imu, &[range(0.0699), range(0.0701)], DT);
    let health = filter.health(&state).range;
    assert_eq!((health.used, health.too_old), (1, 1));
    filter.step(&mut state, &imu, &[range(0.0); 6], DT);
    let health = filter.health(&state).range;
    // Six more in a log of four: those that are in the state have given way.
    assert_eq!((health.used, health.no_room), (7, 0));
    // What they stood for is no longer known apart: readings of that time are too late.
    filter.step(
        &mut state,
        &imu,
        &[range(0.03), range(0.01), range(0.0)],
        DT,
    );
    let health = filter.health(&state).range;
    assert_eq!((health.used, health.too_old), (9, 2));
}

#[test]
fn analytic_readings_that_give_way_stay_in_the_state() {
    // On time, a log of two gives what a log of sixty does; late by 20 ms and two a
    // step, one of six does.
    let filter = mounted();
    let (mut small, mut middle, mut large): (
        RelativeState<f64, 16, 2>,
        RelativeState<f64, 16, 6>,
        RelativeState<f64, 16, 60>,
    ) = (filter.initial(), filter.initial(), filter.initial());
    let imu = STILL.imu(0.0, V::ZERO);
    let readings = |i: u32, age: f64| {
        let noise = 0.01 * f64::from(i * 7 % 5);
        [0.0, 1e-3].map(|early| Reading::Range(RangeReading::level(1.5 + noise, age + early)))
    };
    for i in 0..100 {
        let a = filter.step(&mut small, &imu, &readings(i, 0.0), DT);
        let b = filter.step(&mut large, &imu, &readings(i, 0.0), DT);
        assert_eq!(a, b, "{i}");
    }
    let mut large: RelativeState<f64, 16, 60> = filter.initial();
    for i in 0..100 {
        let a = filter.step(&mut middle, &imu, &readings(i, 0.02), DT);
        let b = filter.step(&mut large, &imu, &readings(i, 0.02), DT);
        assert_eq!(a, b, "{i}");
    }
}

#[test]
fn analytic_zero_noise() {
    // Perfect sensors as the filter believes, nothing divides by zero.
    let mut filter = still(mounted());
    filter.imu = ImuModel {
        noise_density: 0.0,
        bias_sd_mps2: 0.0,
        bias_walk: 0.0,
        attitude_sd_rad: 0.0,
        ..filter.imu
    };
    filter.range.noise_sd_m = 0.0;
    filter.range.jitter_s = 0.0;
    filter.validate().unwrap();
    let mut state: State = filter.initial();
    let imu = ImuSample {
        specific_force_mps2: V::UP * G,
        attitude: Attitude::LEVEL,
    };
    let mut estimate = filter.step(&mut state, &imu, &[], DT);
    for step in 1..100 {
        let height = 2.0 - 0.5 * f64::from(step) * DT;
        let range = Reading::Range(RangeReading::level(height + filter.range.position_m.z, 0.0));
        estimate = filter.step(&mut state, &imu, &[range], DT);
    }
    assert!((estimate.height_m() - 1.505).abs() < 1e-12);
    assert!((estimate.velocity_mps.z + 0.5).abs() < 1e-9);
    assert!(estimate.position_sd_m.z < 1e-9);
}

#[test]
fn analytic_deck_sightings_show_the_heave() {
    let filter = mounted();
    let mut state: State = filter.initial();
    let (mut seen, mut sum) = (0, 0.0);
    for step in 1..1500 {
        let t = step as f64 * DT;
        let all = readings(&PAPER_DECK, &filter, step, [0.02, 0.05, 0.12]);
        filter.step(&mut state, &PAPER_DECK.imu(t, V::ZERO), &all, DT);
        let sighting = filter.deck_sighting(&state);
        // The first readings are older than the filter.
        assert!(step < 10 || sighting.is_some() == (due(step, 2) || due(step, 3)));
        if let (Some(sighting), true) = (sighting, step > 500) {
            let then = PAPER_DECK.at(t - sighting.age_s);
            // Altitude starts at zero, its own error is constant.
            let constant = sighting.displacement_m - then.deck_height;
            seen += 1;
            sum += constant;
            let mean = sum / f64::from(seen);
            // Vertical velocity from GNSS at 0.15 m/s and the prior let the altitude
            // wander; over 10 s within this, a fifth of the heave.
            assert!((constant - mean).abs() < 0.01, "{t} {constant} {mean}");
        }
    }
}

fn convert<R: Real>(v: V) -> Vector<R> {
    Vector::from_array(v.to_array().map(R::from_f64))
}

#[test]
fn prop_single_precision_follows_double() {
    // Every number of the settings is rounded to single precision in both.
    let filter = mounted();
    let coarse = RelativeFilter::<f32> {
        range: RangeModel {
            position_m: convert(filter.range.position_m),
            quantum_m: 0.0,
            ..RangeModel::default()
        },
        tag: TagModel {
            position_m: convert(filter.tag.position_m),
            ..TagModel::default()
        },
        ..RelativeFilter::default()
    };
    let mut state: State = filter.initial();
    let mut single: RelativeState<f32, 32, 64> = coarse.initial();
    for step in 1..=6000 {
        let t = step as f64 * DT;
        let all = readings(&PAPER_DECK, &filter, step, [0.02, 0.055, 0.12]);
        let narrow: Vec<Reading<f32>> = all
            .iter()
            .map(|reading| match reading {
                Reading::Range(range) => Reading::Range(RangeReading::level(
                    range.distance_m as f32,
                    range.age_s as f32,
                )),
                Reading::Tag(tag) => Reading::Tag(TagReading {
                    position_m: convert(tag.position_m),
                    covariance_m2: tag.covariance_m2.map(|row| row.map(|c| c as f32)),
                    age_s: tag.age_s as f32,
                }),
                Reading::Gnss(gnss) => Reading::Gnss(GnssVelocity {
                    velocity_mps: convert(gnss.velocity_mps),
                    age_s: gnss.age_s as f32,
                }),
                Reading::Barometer(_) => unreachable!(),
            })
            .collect();
        let imu = PAPER_DECK.imu(t, V::ZERO);
        let fine = filter.step(&mut state, &imu, &all, DT);
        let imu = ImuSample {
            specific_force_mps2: convert(imu.specific_force_mps2),
            attitude: Attitude::from_quaternion(imu.attitude.to_quaternion().map(|c| c as f32))
                .unwrap(),
        };
        let narrow = coarse.step(&mut single, &imu, &narrow, DT as f32);
        if step > 100 {
            let apart = f64::from(narrow.position_m.z) - fine.position_m.z;
            let speed =
                f64::from(narrow.relative_velocity_mps().z) - fine.relative_velocity_mps().z;
            // Rounding 6e-8 of metres and of g (6e-7 m/s²), amplified by the filter's
            // memory of some seconds; a hundredth of the sensors' noise.
            assert!(
                apart.abs() < 5e-5 && speed.abs() < 5e-4,
                "{t} {apart} {speed}"
            );
            let ratio = f64::from(narrow.position_sd_m.z) / fine.position_sd_m.z;
            // Variances keep three digits after the 10 m of the start.
            assert!((ratio - 1.0).abs() < 1e-2, "{t} {ratio}");
        }
    }
    assert!(!coarse.health(&single).diverged);
}

fn any_number() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => -5.0_f32..5.0,
        1 => Just(f32::NAN),
        1 => Just(f32::INFINITY),
        1 => Just(0.0),
        1 => prop::num::f32::ANY,
    ]
}

fn any_reading() -> impl Strategy<Value = Reading<f32>> {
    let vector = || prop::array::uniform3(any_number()).prop_map(Vector::from_array);
    let age = || prop_oneof![3 => 0.0_f32..0.1, 1 => any_number()];
    prop_oneof![
        (any_number(), vector(), age()).prop_map(|(distance_m, deck_normal, age_s)| {
            Reading::Range(RangeReading {
                distance_m,
                deck_normal,
                age_s,
            })
        }),
        (any_number(), age())
            .prop_map(|(distance_m, age_s)| Reading::Range(RangeReading::level(distance_m, age_s))),
        (
            vector(),
            prop::array::uniform3(prop::array::uniform3(any_number())),
            age()
        )
            .prop_map(|(position_m, covariance_m2, age_s)| {
                Reading::Tag(TagReading {
                    position_m,
                    covariance_m2,
                    age_s,
                })
            }),
        (vector(), age()).prop_map(|(velocity_mps, age_s)| Reading::Gnss(GnssVelocity {
            velocity_mps,
            age_s
        })),
        (any_number(), age()).prop_map(|(altitude_m, age_s)| {
            Reading::Barometer(BarometerReading { altitude_m, age_s })
        }),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn prop_whatever_comes_the_estimate_is_finite(
        steps in prop::collection::vec(
            (
                prop::collection::vec(any_reading(), 0..4),
                prop::array::uniform3(any_number()),
                any_number(),
            ),
            1..60,
        )
    ) {
        let filter = RelativeFilter::<f32>::default();
        let mut state: RelativeState<f32, 8, 8> = filter.initial();
        for (readings, force, dt) in steps {
            let imu = ImuSample {
                specific_force_mps2: Vector::from_array(force),
                attitude: Attitude::LEVEL,
            };
            let e = filter.step(&mut state, &imu, &readings, dt.min(0.1));
            for v in [
                e.position_m, e.velocity_mps, e.deck_velocity_mps, e.bias_mps2,
                e.position_sd_m, e.relative_velocity_sd_mps, e.velocity_sd_mps,
            ] {
                prop_assert!(v.is_finite(), "{e:?}");
            }
            prop_assert!(e.deck_acceleration_mps2.is_finite() && e.altitude_m.is_finite());
        }
    }
}

#[test]
fn analytic_settings_are_refused_by_name() {
    let refused = |change: fn(&mut RelativeFilter<f64>)| {
        let mut filter = RelativeFilter::<f64>::default();
        change(&mut filter);
        filter.validate().unwrap_err().to_string()
    };
    assert_eq!(
        refused(|f| f.range.noise_sd_m = -0.1),
        "relative.range.noise_sd_m: expected a finite number not below 0, found -0.1"
    );
    assert_eq!(
        refused(|f| f.range.direction = V::ZERO),
        "relative.range.direction: expected a finite number greater than 0, found 0"
    );
    assert_eq!(
        refused(|f| f.gate.rejections = 0),
        "relative.gate.rejections: expected a number of readings not below 1, found 0"
    );
    assert_eq!(
        refused(|f| f.imu.stale_s = f64::NAN),
        "relative.imu.stale_s: expected a finite number greater than 0, found NaN"
    );
}
