//! Detection of tags by `locus-core`.

use locus_core::{DetectorConfig, ImageView, TagFamily};
use serde::{Deserialize, Serialize};

use crate::error::{VisionError, ensure, setting};
use crate::image::GrayImage;

/// How tags are looked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DetectorSettings {
    /// Shrinks the image by this factor to find quadrangles (corners are then
    /// refined in the whole image): 2 halves the time and doubles the smallest
    /// cell that is found.
    pub decimation: usize,
    /// Bits of a code that may be wrong; the family's codes are 11 apart.
    pub max_hamming: u32,
    /// Least contrast between black and white cells, grey levels.
    pub min_contrast: f64,
    /// Threads within a frame. The result is the same for any number.
    pub threads: usize,
}

impl Default for DetectorSettings {
    fn default() -> Self {
        Self {
            decimation: 1,
            max_hamming: 4,
            min_contrast: 20.0,
            threads: 1,
        }
    }
}

impl DetectorSettings {
    /// Checks the settings.
    ///
    /// # Errors
    /// Decimation is 1..8, at most 5 bits may be wrong, the contrast is within
    /// 0..255 and there are 1..64 threads.
    pub fn validate(&self) -> Result<(), VisionError> {
        ensure(
            (1..=8).contains(&self.decimation),
            "decimation",
            "a whole number from 1 to 8",
            &self.decimation,
        )?;
        ensure(
            self.max_hamming <= 5,
            "max_hamming",
            "at most 5, for the codes are 11 apart",
            &self.max_hamming,
        )?;
        ensure(
            (0.0..=255.0).contains(&self.min_contrast),
            "min_contrast",
            "a number from 0 to 255",
            &self.min_contrast,
        )?;
        ensure(
            (1..=64).contains(&self.threads),
            "threads",
            "a whole number from 1 to 64",
            &self.threads,
        )
    }
}

/// A tag in an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Detection {
    /// Its id in the family 36h11.
    pub id: u32,
    /// Its corners (the outer edge of the black border), px with pixel centres
    /// at +½: top left, top right, bottom right, bottom left of the print.
    pub corners_px: [[f64; 2]; 4],
    /// Bits of its code that were wrong.
    pub hamming: u32,
}

impl Detection {
    /// Mean length of the sides, px.
    #[must_use]
    pub fn mean_side_px(&self) -> f64 {
        let side = |i: usize| {
            let ([ax, ay], [bx, by]) = (self.corners_px[i], self.corners_px[(i + 1) % 4]);
            (bx - ax).hypot(by - ay)
        };
        (0..4).map(side).sum::<f64>() / 4.0
    }
}

/// Finds tags. Holds the memory that it works in: one for each thread.
pub struct Detector {
    inner: locus_core::Detector,
}

impl std::fmt::Debug for Detector {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Detector")
            .field("config", &self.inner.config())
            .finish_non_exhaustive()
    }
}

impl Detector {
    /// Checks the settings and builds a detector.
    ///
    /// # Errors
    /// Names the bad key, what is expected and the offending number.
    pub fn new(settings: &DetectorSettings) -> Result<Self, VisionError> {
        settings.validate()?;
        let config = DetectorConfig {
            decimation: settings.decimation,
            max_hamming_error: Some(settings.max_hamming),
            decoder_min_contrast: settings.min_contrast,
            nthreads: settings.threads,
            ..DetectorConfig::default()
        };
        let builder = locus_core::Detector::builder();
        let inner = builder
            .with_config(config)
            .with_family(TagFamily::AprilTag36h11)
            .validated_build()
            .map_err(|error| setting("detector", "a valid configuration", &error))?;
        Ok(Self { inner })
    }

    /// The tags in an image, by id; of tags that are seen more than once the
    /// largest first.
    ///
    /// # Errors
    /// When the detector refuses the image.
    pub fn detect(&mut self, image: &GrayImage<'_>) -> Result<Vec<Detection>, VisionError> {
        let refused = |message: String| VisionError::Detector { message };
        let view = ImageView::new(
            image.pixels(),
            image.width_px(),
            image.height_px(),
            image.stride(),
        )
        .map_err(refused)?;
        let found = self
            .inner
            .detect(&view, None, None, false)
            .map_err(|error| refused(error.to_string()))?;
        let mut detections: Vec<Detection> = (0..found.len())
            .map(|i| {
                // The detector's first corner is the one of the lowest bit: the
                // bottom right of the print.
                let corner = |k: usize| {
                    let point = found.corners[i][(k + 2) % 4];
                    [f64::from(point.x), f64::from(point.y)]
                };
                Detection {
                    id: found.ids[i],
                    corners_px: [corner(0), corner(1), corner(2), corner(3)],
                    // A small count kept as a float.
                    hamming: found.error_rates[i] as u32,
                }
            })
            .filter(|tag| tag.corners_px.iter().flatten().all(|x| x.is_finite()))
            .collect();
        detections.sort_by(|a, b| {
            let sides = b.mean_side_px().total_cmp(&a.mean_side_px());
            a.id.cmp(&b.id).then(sides)
        });
        Ok(detections)
    }
}
