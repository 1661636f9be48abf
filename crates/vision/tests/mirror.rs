//! Two poses that explain the corners about as well: which one is told, and that it is said.

use touchdown_vision::camera::CameraSettings;
use touchdown_vision::locate::LocatorSettings;
use touchdown_vision::pad::{Pad, PadTag};
use touchdown_vision::{Detection, Fix, Hints, Locator};

/// Nine small tags, so far away that their perspective is lost in the noise of the corners.
fn pad() -> Pad {
    let tag = |k: u32| PadTag {
        id: k,
        size_m: 0.06,
        centre_m: [
            0.12 * f64::from(k % 3) - 0.12,
            0.12 * f64::from(k / 3) - 0.12,
        ],
        yaw_rad: 0.0,
    };
    Pad {
        tags: (0..9).map(tag).collect(),
    }
}

/// Nearly normal numbers: sums of twelve uniform ones of a linear congruential generator (Knuth's MMIX).
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        let mut sum = -6.0;
        for _ in 0..12 {
            self.0 = self
                .0
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            sum += (self.0 >> 11) as f64 / (1_u64 << 53) as f64;
        }
        sum
    }
}

/// The deck's normal in camera axes: it leans by 0.3 rad.
fn normal() -> [f64; 3] {
    [0.0, 0.3_f64.sin(), -0.3_f64.cos()]
}

/// What the corners are seen at, `sd_px` off.
fn seen(camera: &CameraSettings, noise: &mut Noise, sd_px: f64) -> Vec<Detection> {
    let n = normal();
    // Forward and port of the deck, across from its normal.
    let (forward, port) = ([0.0, -n[2].abs(), -n[1]], [-1.0, 0.0, 0.0]);
    let corner = |noise: &mut Noise, [x, y]: [f64; 2]| {
        let point = [0, 1, 2].map(|k| x * forward[k] + y * port[k] + [0.1, -0.2, 7.0][k]);
        let [u, v] = camera.project(point).expect("ahead of the camera");
        [u + sd_px * noise.next(), v + sd_px * noise.next()]
    };
    let detected = |tag: &PadTag| Detection {
        id: tag.id,
        corners_px: tag.corners_m().map(|place| corner(noise, place)),
        hamming: 0,
    };
    pad().tags.iter().map(detected).collect()
}

/// Cosine of the angle between the normal that was found and the true one.
fn right(fix: &Fix) -> f64 {
    (0..3).map(|k| fix.normal()[k] * normal()[k]).sum()
}

#[test]
fn prop_a_hint_chooses_though_corners_are_worse_than_expected() {
    let camera = CameraSettings::default();
    for (assumed_px, is_px) in [(0.3, 0.3), (0.03, 0.3), (0.01, 0.3)] {
        let settings = LocatorSettings {
            fine_sd_px: assumed_px,
            coarse_sd_px: assumed_px,
            ..LocatorSettings::default()
        };
        let locator = Locator::new(&camera, &pad(), &settings).expect("valid settings");
        let mut noise = Noise(5);
        let mut mirrored = 0;
        for frame in 0..200 {
            let tags = seen(&camera, &mut noise, is_px);
            let up = Some(normal());
            let hinted = locator
                .locate(
                    &tags,
                    &Hints {
                        up,
                        ..Hints::default()
                    },
                )
                .expect("a pose");
            // The mirrored normal leans the other way: 0.6 rad off, cosine 0.83.
            assert!(
                right(&hinted) > 0.9,
                "frame {frame}, {assumed_px} px: {hinted:?}"
            );
            assert!(!hinted.ambiguous);
            let alone = locator.locate(&tags, &Hints::default()).expect("a pose");
            if right(&alone) < 0.9 {
                mirrored += 1;
                assert!(alone.ambiguous, "frame {frame}, {assumed_px} px: {alone:?}");
                // The distance to the other pose is in its covariance.
                let sd = alone.covariance[3][3].sqrt();
                assert!(sd > 0.05, "frame {frame}: {sd} rad");
            }
        }
        // Else nothing was tested.
        assert!(mirrored > 5, "{assumed_px} px: {mirrored} of 200 mirrored");
    }
}
