//! What range finder and camera see of the deck.

use touchdown_flight::Vector;
use touchdown_lander::estimate::relative::TagReading;

use super::readings::{Sensing, Truth, vector};
use crate::body::rigid::RigidState;
use crate::deck::rigid::DeckPose;
use crate::number::vector::{add, along, cross, dot, normalised, product, scale, sub, to_world};
use crate::sensors::camera::CameraSettings;
use crate::sensors::camera::view::View;

impl Sensing {
    /// The distance along the beam to the deck.
    pub(super) fn distance(
        &self,
        truth: &Truth<'_>,
        axes: &[[f64; 3]; 3],
        noise: f64,
    ) -> Option<f64> {
        let of = &self.settings.range;
        let from = add(truth.state.position_m, to_world(axes, of.place_m));
        let beam = scale(axes[2], -1.0);
        let from_centre = sub(from, truth.deck.origin_m);
        let above = dot(truth.deck.axes[2], from_centre);
        let closing = -dot(truth.deck.axes[2], beam);
        if !(closing > 0.1 && above > 0.0) {
            return None;
        }
        let distance = above / closing;
        let hit = along(&truth.deck.axes, add(from_centre, scale(beam, distance)));
        let beside = |l: f64| hit[0].abs() > l || hit[1].abs() > l;
        if truth.half_side_m.is_some_and(beside) {
            return None;
        }
        let noisy = distance + of.noise_sd_m * noise;
        let read = if of.quantum_m > 0.0 {
            (noisy / of.quantum_m).round() * of.quantum_m
        } else {
            noisy
        };
        (read >= of.least_m && read <= of.greatest_m).then_some(read)
    }

    /// Place of the deck's centre and the deck's normal in camera axes.
    pub(super) fn see(&mut self, truth: &Truth<'_>) -> Option<(TagReading<f64>, Vector<f64>)> {
        let of = &self.settings.tag;
        let (view, covariance) = if of.errors {
            let half_s = 0.5 * of.camera.exposure_s;
            let [open, shut] = [-half_s, half_s].map(|t| view_at(&of.camera, truth, t));
            let up = self.up(truth);
            let stream = &mut self.tag.stream;
            let look = match &mut self.pipeline {
                Some(pipeline) => pipeline.locate(&open, &shut, up, stream),
                None => self.camera.look(&open, &shut, stream),
            };
            // A view that is no pose shows nothing.
            let fix = look.ok().flatten()?;
            (fix.view, fix.covariance)
        } else {
            let view = View::of(&of.camera, truth.state, truth.deck);
            let [u, v] = of.camera.project(view.translation_m)?;
            let within = |x: f64, most: usize| x >= 0.0 && x <= most as f64;
            if !(within(u, of.camera.width_px) && within(v, of.camera.height_px)) {
                return None;
            }
            (view, [[0.0; 6]; 6])
        };
        let tag = TagReading {
            position_m: vector(view.translation_m),
            covariance_m2: [0, 1, 2].map(|i| [0, 1, 2].map(|j| covariance[i][j])),
            age_s: 0.0,
        };
        // Rows of the rotation are the camera's axes in the deck's.
        Some((tag, vector(view.rotation.map(|row| row[2]))))
    }

    /// Up in camera axes, by the attitude that the vehicle believes.
    fn up(&self, truth: &Truth<'_>) -> [f64; 3] {
        let believed = RigidState {
            attitude: self.believed(truth.state.attitude),
            ..RigidState::default()
        };
        let level = View::of(&self.settings.tag.camera, &believed, &DeckPose::default());
        level.rotation.map(|row| row[2])
    }
}

/// What the camera sees a little before or after, by the motion now.
fn view_at(camera: &CameraSettings, truth: &Truth<'_>, t: f64) -> View {
    let (mut state, mut deck) = (*truth.state, *truth.deck);
    let [p, q, r] = scale(state.rates, 0.5 * t);
    state.attitude = normalised(product(state.attitude, [1.0, p, q, r]));
    state.position_m = add(state.position_m, scale(state.velocity_mps, t));
    deck.origin_m = add(deck.origin_m, scale(deck.velocity_mps, t));
    let turn = scale(deck.angular_velocity, t);
    // Orthonormal to the square of the turn during half an exposure.
    deck.axes = deck.axes.map(|axis| add(axis, cross(turn, axis)));
    View::of(camera, &state, &deck)
}
