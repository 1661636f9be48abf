//! The truth that identification and control are tried on: rotors, air, deck, force rig, sensors
//! and landings.
//!
//! | folder | what it holds |
//! | --- | --- |
//! | [`air`] | ground effect, also that of a second plant; turbulence; wind |
//! | [`body`] | motor, plant (motor and ground effect), four rotors, rigid body, legs, attitude control; the vertical vehicle |
//! | [`deck`] | heave of a deck; decks that surge, sway, heave, roll and pitch by sines, a sea or a measured series |
//! | [`rig`] | the force rig, its signals, its standard trials |
//! | [`sensors`] | noise, latency and losses of load cell, inertial unit, range finder, camera, satellite navigation and barometer |
//! | [`landing`] | landings of the vertical vehicle and in six degrees of freedom; faults; many landings in SIMD lanes |
//! | [`number`] | what the vehicle is computed with: one `f64`, or one for each lane |
//! | [`random`] | random streams by seed, trial and purpose |
//!
//! A folder uses those that stand above it in the list `number`, `random`, `deck`, `air`, `body`,
//! `sensors`, `rig`, `landing`, never the reverse (`tests/independence.rs`).
//!
//! * No module of the plant holds a model that is fitted anywhere. The default plant is a wake
//!   model with two lags ([`air::ground`]), the second an exponential with one
//!   ([`air::exponential`]). Both run on the same rig and through the same landings.
//! * z is up. The height of the vehicle's reference point above the deck is `z = z_q - z_p`, its
//!   rate `v = v_q - v_p`. SI units; throttle in [0, 1].
//! * Every run is a pure function of settings, seed and trial: the same bits for any order and
//!   any number of threads.
//! * Integration is classical Runge–Kutta of order four with a fixed step of [`STEP_S`].
//!
//! The vertical force of the default plant; the vehicle in six degrees of freedom has the same
//! law for each rotor:
//!
//! ```text
//! J x' = s (1 - k s) - b x - c x²                      motor, x = √T
//! q1' = (q1*(z) - q1)/t1,  q2' = (q2*(z) - q2)/t2      image rotors, fountain
//! f = x² (1/(1 - q1 - q2) - 1) - k_v (x/√W) (v_q - P(z) v_p) + turbulence
//! ```
//!
//! # Speed
//!
//! Million steps of 1 ms per second of processor time, one core of an AMD EPYC (Zen 5), best of
//! several runs; the vehicle alone, landings with ideal sensors and the cold start while others
//! were busy on it, the rest not:
//!
//! | what | steps | command |
//! | --- | --- | --- |
//! | the vehicle alone | 3.4 | `cargo bench -p touchdown-sim --bench rigid` |
//! | whole landings: sensors, estimators, planner, turbulence | 1.08 | `… --bench space` |
//! | landings with ideal sensors, one at a time | 2.3 | `… --bench batch` |
//! | the same by the lane ([`landing::space::Batch`]) | 8.2 (median 8.0) | `… --bench batch` |
//! | the same with turbulence | 7.4 | `… --bench batch` |
//! | the same in a sea of 100 waves, with turbulence and gusts | 4.8 | `… --bench batch` |
//!
//! `crates/sim/benches/peng_quad/run.sh` prints them beside the published `peng_quad` 0.5.6 (f32,
//! neither motors nor ground effect), which reaches 5.0. `crates/sim/benches/campaign.sh` prints
//! the cold start (34 ms to the end of the first landing, 4.7 MB) and a campaign of 10 000
//! landings (53 s on two cores). [`body::rigid::RigidVehicle::step`] and [`landing::space::Batch`]
//! say what is held constant over a step, and what that costs.
//!
//! A trial of the rig, the load cell's readings beside the truth:
//!
//! ```
//! use touchdown_sim::rig::{RigSettings, run};
//! use touchdown_sim::rig::sets::{Extent, ground_effect_paper};
//!
//! let settings = RigSettings::default();
//! let trial = &ground_effect_paper(Extent::Quick)[0]; // constant throttle, plate up and down
//! let recorded = run(&settings, trial, 1)?;
//! let measured = recorded.require("thrust_n")?;
//! let truth = recorded.require("truth_thrust_n")?;
//! let noise: f64 = measured.iter().zip(truth).map(|(m, t)| (m - t).abs()).sum();
//! assert!(noise / (measured.len() as f64) < 0.2); // newtons
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! A landing, with any controller that turns a measurement into a command:
//!
//! ```
//! use touchdown_flight::types::Command;
//! use touchdown_sim::landing::vertical::{Outcome, land};
//! use touchdown_sim::landing::vertical::LandingScenario;
//!
//! let scenario = LandingScenario::default(); // from 0.8 m to a plate at rest
//! let hover = scenario.nominal_start()?.throttle;
//! let mut controller = |m: &touchdown_flight::types::Measurement<f64>| Command {
//!     // Sink at 0.2 m/s, down to a firm touchdown.
//!     throttle: hover - 0.3 * (m.relative_velocity_mps + 0.2),
//!     ..Command::default()
//! };
//! let landing = land(&scenario, 0, 1, &mut controller, false)?;
//! assert_eq!(landing.outcome, Outcome::Landed);
//! assert!(landing.v_l_mps.is_some_and(|v| v < 0.3));
//! # Ok::<(), touchdown_sim::SimError>(())
//! ```
//!
//! The whole vehicle, dropped from 0.12 m onto a deck in a sea, rotors stopped:
//!
//! ```
//! use touchdown_sim::STEP_S;
//! use touchdown_sim::body::BodySettings;
//! use touchdown_sim::body::contact::{ContactLog, LegSettings};
//! use touchdown_sim::deck::rigid::{RigidMotion, SeaSettings};
//! use touchdown_sim::body::plant::PlantSettings;
//! use touchdown_sim::body::rigid::{Disturbance, RigidState, RigidVehicle};
//!
//! let plant = PlantSettings::default();
//! let vehicle = RigidVehicle::new(&plant, &BodySettings::default())?
//!     .with_legs(&LegSettings::default(), &plant)?;
//! let sea = RigidMotion::Sea(SeaSettings::default()).build(plant.gravity_mps2, 1, 0)?;
//! let deck = sea.splined(0.0, 3.1, 0.1)?; // as fast for 100 waves as for one
//! let start = deck.at(0.0);
//! let [x, y, z] = start.origin_m;
//! let mut state = RigidState {
//!     position_m: [x, y, z + 0.12],
//!     velocity_mps: start.velocity_mps,
//!     ..RigidState::default()
//! };
//! let mut log = ContactLog::default();
//! for step in 0..3_000 {
//!     let t = f64::from(step) * STEP_S;
//!     let poses = [t, t + 0.5 * STEP_S, t + STEP_S].map(|t| deck.at(t));
//!     vehicle.step(&mut state, &poses, &[0.0; 4], &Disturbance::default(), STEP_S);
//!     vehicle.log_contact(&mut log, t + STEP_S, &state, &poses[2]);
//! }
//! assert!(log.feet_down == 4 && log.tipped_s.is_none() && log.fell_s.is_none());
//! # Ok::<(), touchdown_sim::SimError>(())
//! ```

pub mod air;
pub mod body;
mod check;
pub mod deck;
pub mod error;
pub mod landing;
pub mod number;
pub mod random;
pub mod rig;
pub mod sensors;

pub use error::SimError;

/// Step of the integration, s.
pub const STEP_S: f64 = 0.001;
