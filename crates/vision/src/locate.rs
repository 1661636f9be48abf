//! Where the deck is: one pose from all tags of the pad that are seen.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use serde::{Deserialize, Serialize};

use crate::camera::CameraSettings;
use crate::detect::Detection;
use crate::error::{VisionError, ensure, positive};
use crate::family::CELLS;
use crate::pad::Pad;
use crate::planar::{self, PlanePose, Sighting};

/// How corners become a pose. The defaults were measured on rendered images
/// with a lens blur of 0.6 px and noise of 2 grey levels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LocatorSettings {
    /// Standard deviation of a corner of a tag whose cells are at least
    /// `fine_cell_px` wide on average, px. The detector refines those by their
    /// surroundings.
    pub fine_sd_px: f64,
    /// The same for smaller cells, px.
    pub coarse_sd_px: f64,
    /// Where one goes over to the other, px.
    pub fine_cell_px: f64,
    /// Motion during the exposure that does no harm, px.
    pub motion_free_px: f64,
    /// Further standard deviation for each pixel of motion beyond that.
    pub motion_gain: f64,
    /// Tags with a corner nearer than this to the image's edge are left out, px:
    /// the detector may have taken the edge for one of their sides.
    pub border_px: f64,
    /// A pose whose corners are further off than this (root mean square) is
    /// none, px.
    pub gate_px: f64,
}

impl Default for LocatorSettings {
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

impl LocatorSettings {
    /// Checks the settings.
    ///
    /// # Errors
    /// Standard deviations and the gate are positive; none is negative.
    pub fn validate(&self) -> Result<(), VisionError> {
        positive("fine_sd_px", self.fine_sd_px)?;
        positive("coarse_sd_px", self.coarse_sd_px)?;
        positive("gate_px", self.gate_px)?;
        for (key, value) in [
            ("fine_cell_px", self.fine_cell_px),
            ("motion_free_px", self.motion_free_px),
            ("motion_gain", self.motion_gain),
            ("border_px", self.border_px),
        ] {
            let ok = value.is_finite() && value >= 0.0;
            ensure(ok, key, "a finite number of at least 0", &value)?;
        }
        Ok(())
    }

    /// Standard deviation of each coordinate of a tag's corners, px, for its
    /// mean side and the motion during the exposure.
    #[must_use]
    pub fn sd_px(&self, mean_side_px: f64, motion_px: f64) -> f64 {
        let still = if mean_side_px < self.fine_cell_px * CELLS as f64 {
            self.coarse_sd_px
        } else {
            self.fine_sd_px
        };
        // A motion that is no number counts as none.
        still.hypot(self.motion_gain * (motion_px - self.motion_free_px).max(0.0))
    }
}

/// What the vehicle knows beside the image.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Hints {
    /// Roughly the deck's normal in camera axes (of any length), from an
    /// attitude estimate. It only chooses between two poses where the corners
    /// cannot; values that are not finite count as none.
    pub up: Option<[f64; 3]>,
    /// How far the image moved during the exposure, px: angular rate times focal
    /// length, and velocity over height times it, times the exposure.
    pub motion_px: f64,
}

/// Pose of the deck in the camera, with its uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// Rotation from deck to camera axes, row by row.
    pub rotation: [[f64; 3]; 3],
    /// The deck's origin in camera axes, m.
    pub translation_m: [f64; 3],
    /// Covariance of the translation's error (m) and of the rotation's, a small
    /// turn about the camera's axes (rad): `R = exp(θ×) R_true`.
    pub covariance: [[f64; 6]; 6],
    /// Root mean square of the corners' residuals, px.
    pub residual_px: f64,
    /// Tags that had a part in it.
    pub tags: usize,
    /// The mirrored pose explains the corners about as well, and no hint decides
    /// between them; the covariance then holds the distance to it.
    pub ambiguous: bool,
}

impl Fix {
    fn matrix(&self) -> Matrix3<f64> {
        Matrix3::from_fn(|row, column| self.rotation[row][column])
    }

    /// Place of the camera in deck axes, m: `-Rᵀ t`.
    #[must_use]
    pub fn camera_in_deck_m(&self) -> [f64; 3] {
        (-self.matrix().transpose() * Vector3::from(self.translation_m)).into()
    }

    /// The deck's normal in camera axes.
    #[must_use]
    pub fn normal(&self) -> [f64; 3] {
        [
            self.rotation[0][2],
            self.rotation[1][2],
            self.rotation[2][2],
        ]
    }

    /// Covariance of [`Self::camera_in_deck_m`], m². With errors δ and θ of
    /// translation and rotation it moves by `-Rᵀ (δ + t × θ)`.
    #[must_use]
    pub fn camera_covariance_m2(&self) -> [[f64; 3]; 3] {
        let rotation = self.matrix().transpose();
        let across = Vector3::from(self.translation_m).cross_matrix();
        let mut by = nalgebra::Matrix3x6::zeros();
        by.fixed_view_mut::<3, 3>(0, 0).copy_from(&-rotation);
        by.fixed_view_mut::<3, 3>(0, 3)
            .copy_from(&(-rotation * across));
        let covariance = by * Matrix6::from(self.covariance) * by.transpose();
        covariance.into()
    }
}

/// A difference in χ² below which corners do not decide between two poses: three standard deviations of one corner; to be scaled by the χ² per degree
/// of freedom.
const UNDECIDED: f64 = 9.0;

/// χ² per degree of freedom above which a corner or a tag may be wrong: five
/// standard deviations. About one tag in 2000 has a corner that is pixels off.
const SUSPECT: f64 = 25.0;

/// Leaving something out has to lower it by this factor to be believed.
const BETTER: f64 = 0.1;

/// A pose and, where there is one, its mirror image.
type Poses = (PlanePose, Option<PlanePose>);

/// Turns detections into poses of the deck.
#[derive(Clone, Debug, PartialEq)]
pub struct Locator {
    camera: CameraSettings,
    pad: Pad,
    settings: LocatorSettings,
}

impl Locator {
    /// Checks camera, pad and settings.
    ///
    /// # Errors
    /// Names the bad key, what is expected and the offending value.
    pub fn new(
        camera: &CameraSettings,
        pad: &Pad,
        settings: &LocatorSettings,
    ) -> Result<Self, VisionError> {
        camera.validate()?;
        pad.validate()?;
        settings.validate()?;
        Ok(Self {
            camera: *camera,
            pad: pad.clone(),
            settings: *settings,
        })
    }

    /// The camera.
    #[must_use]
    pub fn camera(&self) -> &CameraSettings {
        &self.camera
    }

    /// The pad.
    #[must_use]
    pub fn pad(&self) -> &Pad {
        &self.pad
    }

    /// The pose that all of the pad's tags agree on; `None` when there are none
    /// or they fit no pose. Where two tags or more are seen, a single corner or
    /// a tag that contradicts the rest is left out.
    #[must_use]
    pub fn locate(&self, detections: &[Detection], hints: &Hints) -> Option<Fix> {
        let mut seen: Vec<Sighting> = Vec::with_capacity(4 * detections.len());
        for (i, tag) in detections.iter().enumerate() {
            // Detections come with the largest of an id first.
            let first = detections[..i].iter().all(|other| other.id != tag.id);
            if let Some(corners) = self.sightings(tag, hints).filter(|_| first) {
                seen.extend(corners);
            }
        }
        let mut poses = planar::locate(&self.camera, &seen)?;
        while reduced(&poses.0, seen.len()) > SUSPECT && seen.len() > 4 {
            let Some((kept, better)) = self.without_the_worst(&seen, &poses.0) else {
                break;
            };
            (seen, poses) = (kept, better);
        }
        self.fix(&seen, poses.0, poses.1, hints.up)
    }

    /// What is left without the corner or the tag that contradicts the others.
    fn without_the_worst(
        &self,
        seen: &[Sighting],
        pose: &PlanePose,
    ) -> Option<(Vec<Sighting>, Poses)> {
        let limit = BETTER * reduced(pose, seen.len());
        let without = |out: &dyn Fn(usize) -> bool| {
            let kept: Vec<Sighting> = (0..seen.len())
                .filter(|&i| !out(i))
                .map(|i| seen[i])
                .collect();
            let poses = planar::locate(&self.camera, &kept)?;
            let rest = reduced(&poses.0, kept.len());
            (rest < limit).then_some((rest, kept, poses))
        };
        let corner = (0..seen.len())
            .filter_map(|corner| without(&|i| i == corner))
            .min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, kept, poses)) = corner {
            return Some((kept, poses));
        }
        // Smallest tags first: the largest contains most information.
        let mut tags: Vec<(f64, u32)> = seen.iter().map(|s| (s.side_px, s.tag)).collect();
        tags.sort_by(|a, b| a.0.total_cmp(&b.0));
        tags.dedup_by_key(|tag| tag.1);
        let mut tags = tags.iter();
        let (_, kept, poses) = tags.find_map(|&(_, tag)| without(&|i| seen[i].tag == tag))?;
        Some((kept, poses))
    }

    fn sightings(&self, tag: &Detection, hints: &Hints) -> Option<[Sighting; 4]> {
        let place = self.pad.tag(tag.id)?;
        let side_px = tag.mean_side_px();
        let (width, height) = (self.camera.width_px as f64, self.camera.height_px as f64);
        let margin = |[u, v]: [f64; 2]| u.min(v).min(width - u).min(height - v);
        // Both also refuse corners that are no numbers.
        let whole = tag
            .corners_px
            .iter()
            .all(|&corner| corner[0].is_finite() && margin(corner) >= self.settings.border_px);
        if !(side_px > 0.0 && whole) {
            return None;
        }
        let sd_px = self.settings.sd_px(side_px, hints.motion_px);
        let corners = place.corners_m();
        let mut sightings = [Sighting {
            deck_m: [0.0; 2],
            seen_px: [0.0; 2],
            sd_px,
            tag: tag.id,
            side_px,
        }; 4];
        for (k, sighting) in sightings.iter_mut().enumerate() {
            sighting.deck_m = corners[k];
            sighting.seen_px = self.camera.undistorted(tag.corners_px[k])?;
        }
        Some(sightings)
    }

    fn residual_px(&self, seen: &[Sighting], pose: &PlanePose) -> f64 {
        let squares = seen.iter().map(|s| {
            let place = Vector3::new(s.deck_m[0], s.deck_m[1], 0.0);
            let point = pose.rotation * place + pose.translation;
            self.camera
                .project(point.into())
                .map_or(f64::INFINITY, |[u, v]| {
                    (u - s.seen_px[0]).powi(2) + (v - s.seen_px[1]).powi(2)
                })
        });
        (squares.sum::<f64>() / seen.len() as f64).sqrt()
    }

    fn fix(
        &self,
        seen: &[Sighting],
        mut best: PlanePose,
        other: Option<PlanePose>,
        up: Option<[f64; 3]>,
    ) -> Option<Fix> {
        let up = up
            .map(Vector3::from)
            .filter(|up| up.iter().all(|x| x.is_finite()) && up.norm() > 0.0);
        // Corners that fit worse than expected say that all are worse, and that they
        // tell two poses apart less well.
        let mut scale = reduced(&best, seen.len()).max(1.0);
        let mut rival = other.filter(|other| other.chi2 - best.chi2 < UNDECIDED * scale);
        if let (Some(other), Some(up)) = (rival, up) {
            if other.rotation.column(2).dot(&up) > best.rotation.column(2).dot(&up) {
                best = other;
                scale = reduced(&best, seen.len()).max(1.0);
            }
            rival = None;
        }
        let residual_px = self.residual_px(seen, &best);
        if !(residual_px <= self.settings.gate_px) {
            return None;
        }
        let mut covariance = best.information.cholesky()?.inverse() * scale;
        if let Some(other) = rival {
            // Two peaks, weighted by their likelihood: moments about the better one.
            let weight = 1.0 / (1.0 + (0.5 * (other.chi2 - best.chi2) / scale).exp());
            let turn = nalgebra::Rotation3::from_matrix_unchecked(
                other.rotation * best.rotation.transpose(),
            )
            .scaled_axis();
            let moved = other.translation - best.translation;
            let apart = Vector6::new(moved.x, moved.y, moved.z, turn.x, turn.y, turn.z);
            covariance += weight * apart * apart.transpose();
        }
        let mut tags: Vec<u32> = seen.iter().map(|s| s.tag).collect();
        tags.dedup();
        let fix = Fix {
            rotation: best.rotation.transpose().into(),
            translation_m: best.translation.into(),
            covariance: covariance.into(), // symmetric
            residual_px,
            tags: tags.len(),
            ambiguous: rival.is_some(),
        };
        let numbers = fix.rotation.iter().flatten().chain(&fix.translation_m);
        let numbers = numbers.chain(fix.covariance.iter().flatten());
        numbers.copied().all(f64::is_finite).then_some(fix)
    }
}

/// χ² per degree of freedom: two coordinates a corner, six of the pose.
fn reduced(pose: &PlanePose, corners: usize) -> f64 {
    pose.chi2 / (2 * corners - 6) as f64
}
