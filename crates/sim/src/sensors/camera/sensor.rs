//! The camera as a sensor: the times of its frames, and the poses of the deck that it reports.

use touchdown_flight::Vector;
use touchdown_lander::estimate::relative::TagReading;

use super::CameraSettings;
use super::fast::FastCamera;
use super::pipeline::CameraPipeline;
use super::tags::TagSettings;
use super::view::View;
use crate::body::rigid::RigidState;
use crate::deck::rigid::DeckPose;
use crate::number::vector::{add, cross, normalised, product, scale};
use crate::random::Stream;
use crate::sensors::inertial::InertialUnit;
use crate::sensors::schedule::{Clock, Transit};
use crate::sensors::suite::{Message, Truth, vector};

/// A vector that is no reading.
const NOTHING: Vector<f64> = Vector::new(f64::NAN, f64::NAN, f64::NAN);

/// The camera during one landing.
pub(crate) struct TagCamera {
    settings: TagSettings,
    clock: Clock,
    model: FastCamera,
    /// Frames that were taken so far.
    frames: u64,
    /// Replaces the error model where images are rendered.
    pub(crate) pipeline: Option<Box<dyn CameraPipeline>>,
}

impl TagCamera {
    pub(in crate::sensors) fn new(
        settings: &TagSettings,
        model: &FastCamera,
        stream: Stream,
    ) -> Self {
        Self {
            settings: settings.clone(),
            clock: Clock::new(settings.schedule, stream),
            model: model.clone(),
            frames: 0,
            pipeline: None,
        }
    }

    /// The reading of a step, if one is due, and its way.
    pub(in crate::sensors) fn read(
        &mut self,
        truth: &Truth<'_>,
        inertial: &InertialUnit,
    ) -> Option<(Message, Transit)> {
        let transit = self.clock.reading(truth)?;
        let faults = &truth.faults;
        let frame = self.frames;
        self.frames += 1;
        let (mut tag, mut normal) = self.see(truth, inertial)?;
        if transit.lost || faults.tag_lost {
            return None;
        }
        if faults.nan.tag {
            (tag.position_m, normal) = (NOTHING, NOTHING);
            tag.covariance_m2 = [[f64::NAN; 3]; 3];
        }
        Some((Message::Tag(tag, normal, frame), transit))
    }

    /// Place of the deck's centre and the deck's normal in camera axes.
    fn see(
        &mut self,
        truth: &Truth<'_>,
        inertial: &InertialUnit,
    ) -> Option<(TagReading<f64>, Vector<f64>)> {
        let of = &self.settings;
        let (view, covariance) = if of.errors {
            let half_s = 0.5 * of.camera.exposure_s;
            let [open, shut] = [-half_s, half_s].map(|t| view_at(&of.camera, truth, t));
            let up = self.up(inertial.believed(truth.state.attitude));
            let stream = &mut self.clock.stream;
            let look = match &mut self.pipeline {
                Some(pipeline) => pipeline.locate(&open, &shut, up, stream),
                None => self.model.look(&open, &shut, stream),
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
    fn up(&self, believed: [f64; 4]) -> [f64; 3] {
        let state = RigidState {
            attitude: believed,
            ..RigidState::default()
        };
        let level = View::of(&self.settings.camera, &state, &DeckPose::default());
        level.rotation.map(|row| row[2])
    }
}

/// The camera's view a short time `t` before or after now, extrapolated from the present motion.
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
