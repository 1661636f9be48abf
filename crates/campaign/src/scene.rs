//! A landing as it can be watched: what stands in the scene, and how it moves.

use serde::Serialize;
use touchdown_lander::state_machine::Phase;
use touchdown_sim::body::plant::Surface;
use touchdown_sim::landing::space::{SpaceScenario, SpaceTrace, TraceRow};

/// What stands in the scene. Lengths in m, forces in N; x, y and z are those of the simulation, z up.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Scene {
    /// Half the side of the deck; none where it has no edge.
    pub deck_half_side_m: Option<f64>,
    /// Radius of a rotor.
    pub rotor_radius_m: f64,
    /// Distance of neighbouring rotor axes.
    pub rotor_spacing_m: f64,
    /// Height of the rotors above the reference point.
    pub rotor_height_m: f64,
    /// Distance of the feet from the vertical axis, and their depth below the reference point.
    pub feet_m: [f64; 2],
    /// Weight of the vehicle.
    pub weight_n: f64,
}

impl Scene {
    /// Vehicle and deck of a scenario.
    #[must_use]
    pub fn of(scenario: &SpaceScenario) -> Self {
        let plant = &scenario.plant;
        Self {
            deck_half_side_m: (plant.surface == Surface::Plate).then_some(0.5 * plant.plate_side_m),
            rotor_radius_m: plant.rotor_radius_m,
            rotor_spacing_m: plant.rotor_spacing_m,
            rotor_height_m: plant.rotor_height_m,
            feet_m: [scenario.legs.radius_m, scenario.legs.depth_m],
            weight_n: plant.mass_kg * plant.gravity_mps2,
        }
    }
}

/// How it moves, row by row.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Motion {
    /// Time.
    pub time_s: Vec<f64>,
    /// Reference point of the vehicle.
    pub position_m: Vec<[f64; 3]>,
    /// Attitude of the vehicle: w, x, y, z.
    pub attitude: Vec<[f64; 4]>,
    /// Middle of the deck.
    pub deck_m: Vec<[f64; 3]>,
    /// Its upward normal.
    pub deck_normal: Vec<[f64; 3]>,
    /// Height above the deck along its normal.
    pub height_m: Vec<f64>,
    /// Force on each foot.
    pub feet_n: Vec<[f64; 4]>,
    /// Extra thrust by the ground effect.
    pub ground_effect_n: Vec<f64>,
    /// Phase of the landing.
    pub phase: Vec<Phase>,
}

impl Motion {
    /// Every so many rows of a record, from a time on.
    #[must_use]
    pub fn of(trace: &SpaceTrace, every: usize, from_s: f64) -> Self {
        let mut motion = Self::default();
        let rows = trace.rows.iter().step_by(every);
        let rows = rows.filter(|row| row.time_s >= from_s);
        rows.for_each(|row| motion.push(row));
        motion
    }

    /// Adds a row.
    pub fn push(&mut self, row: &TraceRow) {
        self.time_s.push(row.time_s);
        self.position_m.push(row.position_m);
        self.attitude.push(row.attitude);
        self.deck_m.push(row.deck_m);
        self.deck_normal.push(row.deck_normal);
        self.height_m.push(row.relative_m[2]);
        self.feet_n.push(row.feet_n);
        self.ground_effect_n.push(row.ground_effect_n);
        self.phase.push(row.phase);
    }
}
