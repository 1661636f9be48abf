//! The fast camera against detection on freshly rendered images.

mod common;

use common::compare::{AGAIN, BANDS, NAMES, both};
use touchdown_sim::sensors::camera::fast::LocationSettings;
use touchdown_vision::locate::LocatorSettings;

#[test]
fn xval_fast_camera_agrees_with_rendered_detection() {
    let frames = 240;
    for (heights_m, fast) in BANDS {
        let [seen, drawn] = both(heights_m, fast, frames);
        let band = format!("{heights_m:?} m, speed {fast}");
        let n = frames as f64;
        let (a, b) = (
            seen.fixes as f64 / n,
            drawn.fixes as f64 / (AGAIN as f64 * n),
        );
        // Three standard deviations of 240 draws, and 0.05 for what the tables do
        // not know: the way that a tag is turned, and the way that it moves.
        let chance = (0.5 * (a * (1.0 - a) + b * (1.0 - b)) / n).sqrt();
        assert!(
            (a - b).abs() < 0.05 + 3.0 * chance,
            "{band}: found {a} and {b}"
        );
        for (k, name) in NAMES.iter().enumerate() {
            let (a, b) = (seen.figures(k), drawn.figures(k));
            let what = format!("{band}, {name}: {a:?} and {b:?}");
            // Means: four standard errors, and a fifth of the spread, for corners
            // have means of their own beyond that of scale.
            let spread = a[1].max(b[1]);
            assert!(
                (a[0] - b[0]).abs() < spread * (4.0 / n.sqrt() + 0.2),
                "{what}"
            );
            // The median of 240 errors of one size is known to a tenth, of a mixture to
            // two; the rest is what tables
            // over size and motion alone do not know. A standard deviation hangs on
            // the one or two frames that are worst. A hundredth of a pixel, 1e-4 of
            // the range, is nobody's.
            for (figure, most) in [(1, 2.0), (2, 1.6)] {
                let ratio = (b[figure] + 1e-4) / (a[figure] + 1e-4);
                assert!((1.0 / most..most).contains(&ratio), "{what}: {ratio}");
            }
        }
    }
}

#[test]
fn xval_location_is_weighted_alike() {
    let (a, b) = (LocatorSettings::default(), LocationSettings::default());
    assert_eq!(
        (a.fine_sd_px, a.coarse_sd_px),
        (b.fine_sd_px, b.coarse_sd_px)
    );
    assert_eq!(a.fine_cell_px, b.fine_cell_px);
    assert_eq!(
        (a.motion_free_px, a.motion_gain),
        (b.motion_free_px, b.motion_gain)
    );
    assert_eq!((a.border_px, a.gate_px), (b.border_px, b.gate_px));
}
