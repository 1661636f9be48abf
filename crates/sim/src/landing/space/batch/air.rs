//! The air of all lanes: turbulence and gusts, for several steps at once.

use super::Batch;
use super::lane_flight::LaneFlight;
use crate::STEP_S;
use crate::air::turbulence::RotorTurbulence;
use crate::body::rigid::Input;
use crate::number::{MOST_LANES, Number};

/// Steps whose air is computed together, for locality of memory; it divides the number of
/// steps between two knots. The value affects only computing time.
pub(super) const BLOCK_STEPS: u64 = 20;

/// A value of each lane.
type Row = [f64; MOST_LANES];

/// Gusts and turbulence of the steps of a block.
pub(super) struct Air {
    /// Whether there is turbulence, and whether the wind changes.
    turbulent: bool,
    gusty: bool,
    decay: f64,
    gain: f64,
    /// Noise of the four rotors, and the wind, step by step.
    noise: [[Row; 4]; BLOCK_STEPS as usize],
    wind_mps: [[Row; 3]; BLOCK_STEPS as usize],
}

impl Air {
    pub(super) fn new(batch: &Batch) -> Self {
        let scenario = &batch.lander.scenario;
        let correlation_s = scenario.plant.turbulence_correlation_s;
        let (decay, gain) = RotorTurbulence::decay_and_gain(correlation_s, STEP_S);
        Self {
            turbulent: scenario.turbulence,
            gusty: false,
            decay,
            gain,
            noise: [[[0.0; MOST_LANES]; 4]; BLOCK_STEPS as usize],
            wind_mps: [[[0.0; MOST_LANES]; 3]; BLOCK_STEPS as usize],
        }
    }

    /// Draws the air of the next [`BLOCK_STEPS`] steps.
    pub(super) fn draw(&mut self, flights: &mut [Option<LaneFlight>]) {
        for (lane, flight) in flights.iter_mut().enumerate() {
            let Some(flight) = flight else { continue };
            if let Some(turbulence) = &mut flight.turbulence {
                for step in &mut self.noise {
                    let noise = turbulence.draw();
                    for i in 0..4 {
                        step[i][lane] = noise[i];
                    }
                }
            }
            if flight.wind.changes() {
                self.gusty = true;
                for step in &mut self.wind_mps {
                    flight.wind.step();
                    let wind_mps = flight.wind.velocity_mps();
                    for k in 0..3 {
                        step[k][lane] = wind_mps[k];
                    }
                }
            }
        }
    }

    /// Advances the air of all lanes by one step of the block; `sd_n` is the standard deviation of the
    /// turbulence force at rest.
    #[inline(always)]
    pub(super) fn act<N: Number>(
        &self,
        step: u64,
        input: &mut Input<N>,
        sd_n: impl FnOnce() -> [N; 4],
    ) {
        let step = (step % BLOCK_STEPS) as usize;
        if self.turbulent {
            let sd_n = sd_n();
            for i in 0..4 {
                let value = &mut input.turbulence_n[i];
                let noise = value.of_lanes(&self.noise[step][i]);
                *value = *value * self.decay + sd_n[i] * self.gain * noise;
            }
        }
        if self.gusty {
            for k in 0..3 {
                let value = &mut input.wind_mps[k];
                *value = value.of_lanes(&self.wind_mps[step][k]);
            }
        }
    }
}
