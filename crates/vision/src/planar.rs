//! Pose of a plane from points in it: start by homography, least squares, and
//! the second pose that a plane nearly always has.
//!
//! A plane seen under a small angle or from far away looks almost the same
//! when its normal is mirrored at the line of sight (Schweighofer & Pinz 2006;
//! Collins & Bartoli 2014). Both poses are therefore refined.

use nalgebra::{Matrix3, Matrix6, SMatrix, SVector, Vector3, Vector6};

use crate::camera::CameraSettings;

/// A point of the deck, where it is seen, and how well.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sighting {
    /// Its place x, y on the deck, m.
    pub(crate) deck_m: [f64; 2],
    /// Where it is seen, px.
    pub(crate) seen_px: [f64; 2],
    /// Standard deviation of each coordinate, px.
    pub(crate) sd_px: f64,
    /// The tag that it is a corner of.
    pub(crate) tag: u32,
    /// That tag's mean side, px.
    pub(crate) side_px: f64,
}

/// A pose that explains the sightings as well as any near it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlanePose {
    /// From deck to camera axes.
    pub(crate) rotation: Matrix3<f64>,
    /// The deck's origin in camera axes, m.
    pub(crate) translation: Vector3<f64>,
    /// Sum of squared residuals over their variances.
    pub(crate) chi2: f64,
    /// JᵀWJ of (translation, rotation vector in camera axes).
    pub(crate) information: Matrix6<f64>,
}

/// Steps of the least squares before it is given up.
const STEPS: usize = 50;

/// The best pose, and the other branch where there is one.
pub(crate) fn locate(
    camera: &CameraSettings,
    sightings: &[Sighting],
) -> Option<(PlanePose, Option<PlanePose>)> {
    let (rotation, translation) = start(camera, sightings)?;
    let first = refine(camera, sightings, rotation, translation)?;
    let second = mirrored(sightings, &first)
        .and_then(|(rotation, translation)| refine(camera, sightings, rotation, translation))
        // The same pose again when both starts lead to it.
        .filter(|other| (other.rotation - first.rotation).norm() > 1e-4);
    Some(match second {
        Some(second) if second.chi2 < first.chi2 => (second, Some(first)),
        second => (first, second),
    })
}

fn centroid(sightings: &[Sighting]) -> [f64; 2] {
    let n = sightings.len() as f64;
    let mean = |k: usize| sightings.iter().map(|s| s.deck_m[k]).sum::<f64>() / n;
    [mean(0), mean(1)]
}

/// Pose from the homography of least algebraic error, with the deck's points
/// centred and scaled so that its last element may be set to 1.
fn start(camera: &CameraSettings, sightings: &[Sighting]) -> Option<(Matrix3<f64>, Vector3<f64>)> {
    if sightings.len() < 4 {
        return None;
    }
    let centre = centroid(sightings);
    let radius = sightings
        .iter()
        .map(|s| (s.deck_m[0] - centre[0]).hypot(s.deck_m[1] - centre[1]))
        .fold(0.0, f64::max);
    let mut normal = SMatrix::<f64, 8, 8>::zeros();
    let mut right = SVector::<f64, 8>::zeros();
    for s in sightings {
        let x = (s.deck_m[0] - centre[0]) / radius;
        let y = (s.deck_m[1] - centre[1]) / radius;
        let ray = |k: usize| (s.seen_px[k] - camera.principal_px[k]) / camera.focal_px[k];
        let (u, v) = (ray(0), ray(1));
        for (row, value) in [
            ([x, y, 1.0, 0.0, 0.0, 0.0, -u * x, -u * y], u),
            ([0.0, 0.0, 0.0, x, y, 1.0, -v * x, -v * y], v),
        ] {
            let row = SVector::<f64, 8>::from(row);
            normal += row * row.transpose();
            right += row * value;
        }
    }
    let h = normal.cholesky()?.solve(&right);
    let (a, b) = (
        Vector3::new(h[0], h[3], h[6]),
        Vector3::new(h[1], h[4], h[7]),
    );
    let depth = 0.5 * (a.norm() + b.norm()) / radius;
    let (a, b) = (a.normalize(), b.normalize());
    // The two axes turned apart evenly until they are at right angles.
    let (sum, difference) = ((a + b).normalize(), (a - b).normalize());
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let (a, b) = ((sum + difference) * half, (sum - difference) * half);
    let rotation = Matrix3::from_columns(&[a, b, a.cross(&b)]);
    let middle = Vector3::new(h[2], h[5], 1.0) / depth;
    let translation = middle - rotation * Vector3::new(centre[0], centre[1], 0.0);
    let finite = rotation
        .iter()
        .chain(translation.iter())
        .all(|x| x.is_finite());
    finite.then_some((rotation, translation))
}

/// The pose with its normal mirrored at the line of sight to the points' middle.
fn mirrored(sightings: &[Sighting], pose: &PlanePose) -> Option<(Matrix3<f64>, Vector3<f64>)> {
    let [x, y] = centroid(sightings);
    let centre = Vector3::new(x, y, 0.0);
    let middle = pose.rotation * centre + pose.translation;
    let sight = middle.try_normalize(0.0)?;
    let normal: Vector3<f64> = pose.rotation.column(2).into();
    let axis = normal.cross(&sight);
    let sine = axis.norm();
    if sine < 1e-6 {
        return None;
    }
    // Normal and mirrored normal enclose twice the angle to the line of sight.
    let cosine = normal.dot(&sight);
    let angle = 2.0 * sine.atan2(cosine.abs()) * cosine.signum();
    let turn = rotation_of(&(axis / sine * angle));
    let rotation = turn * pose.rotation;
    Some((rotation, middle - rotation * centre))
}

/// Rodrigues' formula.
fn rotation_of(vector: &Vector3<f64>) -> Matrix3<f64> {
    nalgebra::Rotation3::new(*vector).into_inner()
}

/// χ² and, where wanted, its normal equations at a pose; `None` where a point
/// is not ahead of the camera.
fn linearise(
    camera: &CameraSettings,
    sightings: &[Sighting],
    rotation: &Matrix3<f64>,
    translation: &Vector3<f64>,
) -> Option<(f64, Matrix6<f64>, Vector6<f64>)> {
    let mut chi2 = 0.0;
    let mut information = Matrix6::zeros();
    let mut gradient = Vector6::zeros();
    for s in sightings {
        let arm = rotation * Vector3::new(s.deck_m[0], s.deck_m[1], 0.0);
        let point = arm + translation;
        let seen = camera.project(point.into())?;
        let weight = 1.0 / (s.sd_px * s.sd_px);
        for k in 0..2 {
            let residual = s.seen_px[k] - seen[k];
            chi2 += weight * residual * residual;
            // ∂(f x/z)/∂point, then ∂point/∂θ of a turn θ × arm.
            let mut by_point = Vector3::zeros();
            by_point[k] = camera.focal_px[k] / point.z;
            by_point[2] = -camera.focal_px[k] * point[k] / (point.z * point.z);
            let by_turn = arm.cross(&by_point);
            let row = Vector6::new(
                by_point.x, by_point.y, by_point.z, by_turn.x, by_turn.y, by_turn.z,
            );
            information += weight * row * row.transpose();
            gradient += weight * residual * row;
        }
    }
    chi2.is_finite().then_some((chi2, information, gradient))
}

/// Levenberg–Marquardt on the reprojection error.
fn refine(
    camera: &CameraSettings,
    sightings: &[Sighting],
    mut rotation: Matrix3<f64>,
    mut translation: Vector3<f64>,
) -> Option<PlanePose> {
    let (mut chi2, mut information, mut gradient) =
        linearise(camera, sightings, &rotation, &translation)?;
    let mut damping = 1e-6;
    for _ in 0..STEPS {
        let mut damped = information;
        for k in 0..6 {
            damped[(k, k)] *= 1.0 + damping;
        }
        let step = damped.cholesky()?.solve(&gradient);
        let moved: Vector3<f64> = step.fixed_rows::<3>(0).into();
        let turn: Vector3<f64> = step.fixed_rows::<3>(3).into();
        let next = (rotation_of(&turn) * rotation, translation + moved);
        match linearise(camera, sightings, &next.0, &next.1) {
            Some((better, i, g)) if better <= chi2 => {
                // Far below what corners can tell: about 1e-6 of their variance.
                let done = chi2 - better < 1e-9 * (1.0 + chi2);
                (rotation, translation) = next;
                (chi2, information, gradient) = (better, i, g);
                damping = (damping * 0.1).max(1e-9);
                if done {
                    break;
                }
            }
            _ => {
                damping *= 10.0;
                if damping > 1e6 {
                    break;
                }
            }
        }
    }
    Some(PlanePose {
        rotation,
        translation,
        chi2,
        information,
    })
}
