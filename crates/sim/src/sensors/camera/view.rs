//! Where the deck is in the camera.

use crate::body::rigid::RigidState;
use crate::check;
use crate::deck::rigid::DeckPose;
use crate::error::SimError;
use crate::number::vector::{add, along, axes_of, dot, scale, sub, to_world};
use crate::sensors::camera::CameraSettings;

/// Farthest that the image moves from one instant of an exposure to the next, px: a third of a pixel,
/// so that instants blend into an even smear.
const INSTANT_PX: f64 = 1.0 / 3.0;
/// Most instants of an exposure, for time: beyond 21 px of motion they are further apart.
const INSTANTS: usize = 64;

/// The deck's pose in camera axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Rotation from deck to camera axes, row by row.
    pub rotation: [[f64; 3]; 3],
    /// The deck's centre in camera axes, m.
    pub translation_m: [f64; 3],
}

impl View {
    /// The camera's view of the deck at one time.
    #[must_use]
    pub fn of(camera: &CameraSettings, vehicle: &RigidState, deck: &DeckPose) -> Self {
        let body = axes_of(vehicle.attitude);
        let place = add(vehicle.position_m, to_world(&body, camera.place_m));
        let (sin, cos) = camera.turn_rad.sin_cos();
        // Down in the image is against the direction of its top; right is to
        // starboard of it; ahead is down.
        let right = to_world(&body, [sin, -cos, 0.0]);
        let down = to_world(&body, [-cos, -sin, 0.0]);
        let ahead = scale(body[2], -1.0);
        let axes = [right, down, ahead];
        Self {
            rotation: axes.map(|axis| deck.axes.map(|d| dot(axis, d))),
            translation_m: along(&axes, sub(deck.origin_m, place)),
        }
    }

    /// Checks that it is a pose.
    ///
    /// # Errors
    /// All numbers are finite and the rotation is one, to 1e-6.
    pub fn validate(&self) -> Result<(), SimError> {
        for x in self.translation_m {
            check::finite("view.translation_m", x)?;
        }
        let [a, b, c] = self.rotation;
        let volume = dot(a, crate::number::vector::cross(b, c));
        let errors = [
            dot(a, a) - 1.0,
            dot(b, b) - 1.0,
            dot(c, c) - 1.0,
            dot(a, b),
            dot(b, c),
            dot(c, a),
            volume - 1.0,
        ];
        for error in errors {
            check::that(
                error.abs() < 1e-6,
                "view.rotation",
                "an orthonormal right-handed matrix, found one off by",
                error,
            )?;
        }
        Ok(())
    }

    /// A point of the deck's plane in camera axes, m.
    #[inline]
    #[must_use]
    pub fn point(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        let at =
            |k: usize| self.rotation[k][0] * x + self.rotation[k][1] * y + self.translation_m[k];
        [at(0), at(1), at(2)]
    }

    /// The camera's place in deck axes, m.
    #[must_use]
    pub fn camera_in_deck_m(&self) -> [f64; 3] {
        // Rows of the rotation are the camera's axes in deck axes.
        scale(to_world(&self.rotation, self.translation_m), -1.0)
    }

    /// The deck's point that is seen at a place in the image, m; `None` where
    /// there is none.
    #[must_use]
    pub fn on_deck(&self, seen_px: [f64; 2], camera: &CameraSettings) -> Option<[f64; 2]> {
        let ray = |k: usize| (seen_px[k] - camera.principal_px[k]) / camera.focal_px[k];
        let [dx, dy, dz] = to_world(&self.rotation, [ray(0), ray(1), 1.0]);
        let [x, y, z] = self.camera_in_deck_m();
        let far = -z / dz;
        let ahead = far.is_finite() && far > 0.0;
        ahead.then_some([x + far * dx, y + far * dy])
    }

    /// How far the image moves from this view to another, px: the farthest of
    /// the deck's points that are seen in its corners and its middle.
    #[must_use]
    pub fn motion_px(&self, other: &Self, camera: &CameraSettings) -> f64 {
        let [width, height] = [camera.width_px as f64, camera.height_px as f64];
        let [across, down] = [0.5 * width, 0.5 * height];
        let corners = [
            [0.0, 0.0],
            [width, 0.0],
            [width, height],
            [0.0, height],
            [across, down],
        ];
        let moved = corners.into_iter().filter_map(|corner| {
            let place = self.on_deck(corner, camera)?;
            let [u, v] = camera.project(other.point(place))?;
            Some((u - corner[0]).hypot(v - corner[1]))
        });
        moved.fold(0.0, f64::max)
    }

    /// The views of an exposure from this view to `shut`: at the middles of equal intervals in
    /// which the image moves by at most `INSTANT_PX`.
    ///
    /// # Errors
    /// A view is no pose ([`Self::validate`]).
    pub fn exposure(&self, shut: &Self, camera: &CameraSettings) -> Result<Vec<Self>, SimError> {
        self.validate()?;
        shut.validate()?;
        let steps = self.motion_px(shut, camera) / INSTANT_PX;
        // A cast of a large number saturates.
        let instants = (steps.ceil() as usize).clamp(1, INSTANTS);
        let share = 1.0 / instants as f64;
        let at = |i: usize| self.towards(shut, (i as f64 + 0.5) * share);
        Ok((0..instants).map(at).collect())
    }

    /// The view a share `s` of the way to `other`, for two that are close.
    #[must_use]
    pub fn towards(&self, other: &Self, s: f64) -> Self {
        let mix = |a: [f64; 3], b: [f64; 3]| add(scale(a, 1.0 - s), scale(b, s));
        let unit = |a: [f64; 3]| scale(a, 1.0 / dot(a, a).sqrt());
        let across = |a, b| crate::number::vector::cross(a, b);
        // The third axis, then the first made orthogonal to it.
        let ahead = unit(mix(self.rotation[2], other.rotation[2]));
        let right = mix(self.rotation[0], other.rotation[0]);
        let right = unit(sub(right, scale(ahead, dot(right, ahead))));
        Self {
            rotation: [right, across(ahead, right), ahead],
            translation_m: mix(self.translation_m, other.translation_m),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_level_above_the_deck() {
        let camera = CameraSettings::default();
        let vehicle = RigidState {
            position_m: [0.1, 0.2, 1.02],
            ..RigidState::default()
        };
        let view = View::of(&camera, &vehicle, &DeckPose::default());
        assert_eq!(view.validate(), Ok(()));
        // Ahead of the vehicle is up in the image, port is left.
        let [u, v] = camera.project(view.point([0.6, 0.2])).unwrap();
        // Rounding only, here and below.
        assert!((u - 320.0).abs() < 1e-9 && (v - (240.0 - 400.0 * 0.5)).abs() < 1e-9);
        let [u, v] = camera.project(view.point([0.1, 0.7])).unwrap();
        assert!((u - (320.0 - 400.0 * 0.5)).abs() < 1e-9 && (v - 240.0).abs() < 1e-9);
        let place = view.camera_in_deck_m();
        for (found, expected) in place.into_iter().zip([0.1, 0.2, 1.0]) {
            assert!((found - expected).abs() < 1e-12);
        }
    }

    #[test]
    fn prop_views_that_are_no_poses_are_refused() {
        let camera = CameraSettings::default();
        let mut vehicle = RigidState::default();
        vehicle.position_m[1] = f64::NAN;
        let view = View::of(&camera, &vehicle, &DeckPose::default());
        let error = view.validate().unwrap_err().to_string();
        assert!(
            error.contains("translation_m") && error.contains("NaN"),
            "{error}"
        );
        vehicle = RigidState {
            attitude: [f64::NAN, 0.0, 0.0, 0.0],
            ..RigidState::default()
        };
        assert!(
            View::of(&camera, &vehicle, &DeckPose::default())
                .validate()
                .is_err()
        );
        let mut view = View::of(&camera, &RigidState::default(), &DeckPose::default());
        view.rotation[0] = [
            -view.rotation[0][0],
            -view.rotation[0][1],
            -view.rotation[0][2],
        ];
        let error = view.validate().unwrap_err().to_string();
        assert!(error.contains("right-handed"), "{error}");
    }

    #[test]
    fn analytic_between_two_views() {
        let camera = CameraSettings::default();
        let at = |x: f64, half_turn: f64| {
            let vehicle = RigidState {
                position_m: [x, 0.0, 1.0],
                attitude: [half_turn.cos(), half_turn.sin(), 0.0, 0.0],
                ..RigidState::default()
            };
            View::of(&camera, &vehicle, &DeckPose::default())
        };
        let half = at(0.0, 0.0).towards(&at(0.02, 0.01), 0.5);
        assert_eq!(half.validate(), Ok(()));
        let expected = at(0.01, 0.005);
        let (a, b) = (half.point([0.3, 0.1]), expected.point([0.3, 0.1]));
        for k in 0..3 {
            // Rotation and translation mix in second order: 0.02 m × 0.02 rad / 8.
            assert!((a[k] - b[k]).abs() < 6e-5);
        }
    }
}
