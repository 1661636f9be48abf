//! The camera without images: poses with the errors of a detector.
//!
//! For every tag in view, the tables of an [`ErrorModel`] give the probability that it is found and
//! the distribution of its corners' errors. The pose is then fitted to these corners by weighted
//! least squares, which starts from the true pose:
//!
//! ```text
//! minimise χ² = Σ |corner - projection|²/σ²,   covariance = (Jᵀ W J)⁻¹ max(1, χ²/(2n - 6))
//! ```
//!
//! The geometry then determines how errors depend on distance, tilt, place in the image and speed,
//! and how they correlate. The model contains neither the detector's search for single wrong corners
//! nor poses mistaken for their mirror image.

use serde::{Deserialize, Serialize};

use crate::check;
use crate::error::SimError;
use crate::number::vector::{add, axes_of, cross, normalised, sub, to_world};
use crate::random::Stream;
use crate::sensors::camera::CameraSettings;
use crate::sensors::camera::errors::{ErrorModel, Modes};
use crate::sensors::camera::normal_equations::{NormalEquations, Vector6};
use crate::sensors::camera::view::View;

/// Cells along a tag's side, of AprilTag's family 36h11.
pub const CELLS: usize = 8;

/// A tag on the deck.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeckTag {
    /// Side of the tag, m.
    pub size_m: f64,
    /// Its centre on the deck x, y (forward, to port), m.
    pub centre_m: [f64; 2],
    /// Turn of the print from "top is forward", to port, rad.
    pub yaw_rad: f64,
    /// It stands inside a larger tag.
    pub nested: bool,
}

impl DeckTag {
    /// Its corners on the deck: top left, top right, bottom right, bottom left of the print.
    fn corners_m(&self) -> [[f64; 2]; 4] {
        let half = 0.5 * self.size_m;
        let (sin, cos) = self.yaw_rad.sin_cos();
        let [x, y] = self.centre_m;
        [[half, half], [half, -half], [-half, -half], [-half, half]]
            .map(|[a, b]| [x + cos * a - sin * b, y + sin * a + cos * b])
    }
}

/// How location weights corners: what `touchdown-vision` calls
/// `LocatorSettings`, with its defaults.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LocationSettings {
    /// Standard deviation of a corner of a tag with cells of at least
    /// `fine_cell_px`, px.
    pub fine_sd_px: f64,
    /// The same for smaller cells, px.
    pub coarse_sd_px: f64,
    /// Where one goes over to the other, px.
    pub fine_cell_px: f64,
    /// Motion during the exposure that does no harm, px.
    pub motion_free_px: f64,
    /// Further standard deviation for each pixel of motion beyond that.
    pub motion_gain: f64,
    /// Tags with a corner nearer than this to the image's edge are ignored, px.
    pub border_px: f64,
    /// A pose whose corners are further off than this (root mean square) is
    /// none, px.
    pub gate_px: f64,
}

impl Default for LocationSettings {
    fn default() -> Self {
        Self {
            fine_sd_px: 0.03,
            coarse_sd_px: 0.45,
            fine_cell_px: 3.7,
            motion_free_px: 3.5,
            motion_gain: 0.12,
            border_px: 5.0,
            gate_px: 2.0,
        }
    }
}

impl LocationSettings {
    /// Checks the settings.
    ///
    /// # Errors
    /// Standard deviations and the gate are positive; none is negative.
    pub fn validate(&self) -> Result<(), SimError> {
        check::positive("fine_sd_px", self.fine_sd_px)?;
        check::positive("coarse_sd_px", self.coarse_sd_px)?;
        check::positive("gate_px", self.gate_px)?;
        check::not_negative("fine_cell_px", self.fine_cell_px)?;
        check::not_negative("motion_free_px", self.motion_free_px)?;
        check::not_negative("motion_gain", self.motion_gain)?;
        check::not_negative("border_px", self.border_px)
    }

    fn sd_px(&self, cell_px: f64, motion_px: f64) -> f64 {
        let still = if cell_px < self.fine_cell_px {
            self.coarse_sd_px
        } else {
            self.fine_sd_px
        };
        still.hypot(self.motion_gain * (motion_px - self.motion_free_px).max(0.0))
    }
}

/// Pose of the deck in the camera as it is found, with its covariance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraFix {
    /// The pose, at the middle of the exposure.
    pub view: View,
    /// Covariance of the translation's error (m) and of the rotation's, a small
    /// turn about the camera's axes (rad): `R = exp(θ×) R_true`.
    pub covariance: [[f64; 6]; 6],
    /// Tags that had a part in it.
    pub tags: usize,
}

/// The camera in its fast mode.
#[derive(Clone, Debug, PartialEq)]
pub struct FastCamera {
    camera: CameraSettings,
    tags: Vec<DeckTag>,
    location: LocationSettings,
    errors: ErrorModel,
}

/// A corner of a tag that is found.
#[derive(Clone, Copy, Debug)]
struct CornerSighting {
    place_m: [f64; 2],
    at_px: [f64; 2],
    weight: f64,
}

/// Steps of the least squares at most; two or three are usual.
const STEPS: usize = 12;

impl FastCamera {
    /// Checks camera, tags and settings.
    ///
    /// # Errors
    /// Names the bad key, what is expected and the offending number.
    pub fn new(
        camera: &CameraSettings,
        tags: &[DeckTag],
        location: &LocationSettings,
        errors: &ErrorModel,
    ) -> Result<Self, SimError> {
        camera.validate()?;
        for tag in tags {
            check::positive("tags.size_m", tag.size_m)?;
        }
        location.validate()?;
        Ok(Self {
            camera: *camera,
            tags: tags.to_vec(),
            location: *location,
            errors: errors.clone(),
        })
    }

    /// What is found in an exposure from the view `open` to the view `shut`.
    /// Takes as many numbers from the stream whatever is in view.
    ///
    /// # Errors
    /// When a view is no pose ([`View::validate`]).
    pub fn look(
        &self,
        open: &View,
        shut: &View,
        stream: &mut Stream,
    ) -> Result<Option<CameraFix>, SimError> {
        open.validate()?;
        shut.validate()?;
        let view = open.towards(shut, 0.5);
        // Location knows the motion of the image from the vehicle's own motion.
        let image_px = open.motion_px(shut, &self.camera);
        let mut seen: Vec<CornerSighting> = Vec::with_capacity(4 * self.tags.len());
        for tag in &self.tags {
            let chance = stream.uniform();
            let draws: [f64; 8] = std::array::from_fn(|_| stream.normal());
            let places = tag.corners_m();
            let Some(corners) = self.in_view(&view, &places) else {
                continue;
            };
            let cell_px = mean_side(&corners) / CELLS as f64;
            let motion_px = self.motion_px(open, shut, &places);
            let errors = self.errors.at(tag.nested, cell_px, motion_px);
            if chance >= errors.found {
                continue;
            }
            let mut at_px = corners;
            for ((mode, moves), draw) in Modes::of(&corners).all().into_iter().zip(draws) {
                let mean = if mode == 1 { errors.scale_mean_px } else { 0.0 };
                let size = mean + errors.sd_px[mode] * draw;
                for k in 0..4 {
                    at_px[k][0] += size * moves[k][0];
                    at_px[k][1] += size * moves[k][1];
                }
            }
            let weight = self.location.sd_px(cell_px, image_px).powi(-2);
            seen.extend((0..4).map(|k| CornerSighting {
                place_m: places[k],
                at_px: at_px[k],
                weight,
            }));
        }
        Ok(if seen.is_empty() {
            None
        } else {
            self.fix(view, &seen)
        })
    }

    /// The corners on the screen, when all are ahead and clear of its edge.
    fn in_view(&self, view: &View, places: &[[f64; 2]; 4]) -> Option<[[f64; 2]; 4]> {
        let (width, height) = (self.camera.width_px as f64, self.camera.height_px as f64);
        // From behind there is nothing to see.
        if view.camera_in_deck_m()[2] <= 0.0 {
            return None;
        }
        let mut corners = [[0.0; 2]; 4];
        for (corner, &place) in corners.iter_mut().zip(places) {
            let [u, v] = self.camera.project(view.point(place))?;
            let margin = u.min(v).min(width - u).min(height - v);
            if !(margin >= self.location.border_px) {
                return None;
            }
            *corner = [u, v];
        }
        Some(corners)
    }

    /// Farthest motion of a corner, px.
    fn motion_px(&self, open: &View, shut: &View, places: &[[f64; 2]; 4]) -> f64 {
        let moved = places.iter().map(|&place| {
            let (from, to) = (open.point(place), shut.point(place));
            match (self.camera.project(from), self.camera.project(to)) {
                (Some(a), Some(b)) => (b[0] - a[0]).hypot(b[1] - a[1]),
                _ => f64::INFINITY,
            }
        });
        moved.fold(0.0, f64::max)
    }

    /// χ², normal equations and the sum of squared residuals (px²) at a pose.
    fn linearise(
        &self,
        view: &View,
        seen: &[CornerSighting],
    ) -> Option<(f64, NormalEquations, f64)> {
        let (mut chi2, mut squares) = (0.0, 0.0);
        let mut normal = NormalEquations::default();
        for corner in seen {
            let point = view.point(corner.place_m);
            let at = self.camera.project(point)?;
            let arm = sub(point, view.translation_m);
            for k in 0..2 {
                let residual = corner.at_px[k] - at[k];
                squares += residual * residual;
                chi2 += corner.weight * residual * residual;
                // By the point, then by a turn θ × arm.
                let mut by_point = [0.0; 3];
                by_point[k] = self.camera.focal_px[k] / point[2];
                by_point[2] = -self.camera.focal_px[k] * point[k] / (point[2] * point[2]);
                let [a, b, c] = by_point;
                let [d, e, f] = cross(arm, by_point);
                normal.add(&[a, b, c, d, e, f], residual, corner.weight);
            }
        }
        chi2.is_finite().then_some((chi2, normal, squares))
    }

    fn fix(&self, mut view: View, seen: &[CornerSighting]) -> Option<CameraFix> {
        let mut here = self.linearise(&view, seen)?;
        // Levenberg's and Marquardt's damping.
        let mut damping = 1e-6;
        for _ in 0..STEPS {
            let (step, _) = here.1.solve(damping)?;
            let next = moved(&view, &step);
            match self.linearise(&next, seen) {
                Some(there) if there.0 <= here.0 => {
                    // The step is far below the uncertainty of the corners.
                    let done = here.0 - there.0 < 1e-6 * (1.0 + here.0);
                    (view, here) = (next, there);
                    damping *= 0.1;
                    if done {
                        break;
                    }
                }
                _ => damping *= 100.0,
            }
        }
        let (chi2, normal, squares) = here;
        if (squares / seen.len() as f64).sqrt() > self.location.gate_px {
            return None;
        }
        let (_, inverse) = normal.solve(0.0)?;
        let scale = (chi2 / (2 * seen.len() - 6) as f64).max(1.0);
        Some(CameraFix {
            view,
            covariance: inverse.map(|row| row.map(|x| scale * x)),
            tags: seen.len() / 4,
        })
    }
}

/// A view moved by a translation and a turn about the camera's axes.
fn moved(view: &View, step: &Vector6) -> View {
    let [x, y, z, a, b, c] = *step;
    // The quaternion of a rotation vector.
    let angle = (a * a + b * b + c * c).sqrt();
    let (sin, cos) = (0.5 * angle).sin_cos();
    let part = if angle > 0.0 { sin / angle } else { 0.5 };
    let turn = axes_of(normalised([cos, part * a, part * b, part * c]));
    let columns = [0, 1, 2].map(|k| to_world(&turn, [0, 1, 2].map(|i| view.rotation[i][k])));
    View {
        rotation: [0, 1, 2].map(|i| columns.map(|column| column[i])),
        translation_m: add(view.translation_m, [x, y, z]),
    }
}

fn mean_side(corners: &[[f64; 2]; 4]) -> f64 {
    let side = |i: usize| {
        let ([ax, ay], [bx, by]) = (corners[i], corners[(i + 1) % 4]);
        (bx - ax).hypot(by - ay)
    };
    (0..4).map(side).sum::<f64>() / 4.0
}
