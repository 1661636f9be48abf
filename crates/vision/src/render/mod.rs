//! Images of the deck as a camera takes them, for tests and simulations of detection.
//!
//! ```text
//! grey = white_level · L(u, v) · (G * mean over the exposure of ρ) + noise
//! ```
//!
//! ρ is the reflectance averaged over each pixel's square, exact for every
//! instant (the raster sums signed areas along rows); the exposure is the mean of the instants
//! that the caller gives; G is the lens's Gaussian point spread; L the
//! illumination, linear in the image's coordinates; noise is white. Levels are
//! rounded and cut to 0..255.

pub mod print;
mod raster;

use self::print::DeckPrint;
use self::raster::Coverage;
use crate::camera::{CameraSettings, Pose};
use crate::error::{VisionError, ensure};

/// Lens, light and noise of an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageSettings {
    /// Blur of the lens: standard deviation of its point spread, px.
    pub lens_sd_px: f64,
    /// Grey level of a perfectly white surface in the image's middle, 0..255.
    pub white_level: f64,
    /// How much brighter the right and the lower edge of the image are than the
    /// left and the upper one, as a share.
    pub gradient: [f64; 2],
    /// Noise of a pixel, standard deviation, grey levels.
    pub noise_sd: f64,
}

impl ImageSettings {
    /// Checks the settings.
    ///
    /// # Errors
    /// The lens blurs by 20 px at most, gradients are within ±1, noise is not negative.
    pub fn validate(&self) -> Result<(), VisionError> {
        for (key, value, [low, high]) in [
            ("lens_sd_px", self.lens_sd_px, [0.0, 20.0]),
            ("white_level", self.white_level, [1.0, 1e4]),
            ("gradient", self.gradient[0], [-1.0, 1.0]),
            ("gradient", self.gradient[1], [-1.0, 1.0]),
            ("noise_sd", self.noise_sd, [0.0, 255.0]),
        ] {
            let expected = format!("a number from {low} to {high}");
            ensure((low..=high).contains(&value), key, &expected, &value)?;
        }
        Ok(())
    }
}

/// Takes images. Holds the memory that it works in.
#[derive(Clone, Debug)]
pub struct Renderer {
    camera: CameraSettings,
    image: ImageSettings,
    print: DeckPrint,
    coverage: Coverage,
    light: Vec<f32>,
    blurred: Vec<f32>,
    kernel: Vec<f32>,
    pixels: Vec<u8>,
}

impl Renderer {
    /// Checks camera, image and print.
    ///
    /// # Errors
    /// Names the bad key, what is expected and the offending number.
    pub fn new(
        camera: &CameraSettings,
        image: &ImageSettings,
        print: &DeckPrint,
    ) -> Result<Self, VisionError> {
        camera.validate()?;
        let pinhole = camera.distortion == [0.0; 5];
        let found = format!("{:?}", camera.distortion);
        ensure(
            pinhole,
            "distortion",
            "zeros: images are those of a pinhole",
            &found,
        )?;
        image.validate()?;
        print.validate()?;
        let pixels = camera.width_px * camera.height_px;
        Ok(Self {
            camera: *camera,
            image: *image,
            print: print.clone(),
            coverage: Coverage::new(camera.width_px, camera.height_px),
            light: vec![0.0; pixels],
            blurred: vec![0.0; pixels],
            kernel: half_kernel(image.lens_sd_px),
            pixels: vec![0; pixels],
        })
    }

    /// The image of an exposure, row by row: the mean over `instants`, poses that move by less than
    /// a pixel from one to the next. `normal` draws the noise, numbers of the distribution N(0, 1).
    pub fn expose(&mut self, instants: &[Pose], normal: impl FnMut() -> f64) -> &[u8] {
        let [focal, principal] = [self.camera.focal_px, self.camera.principal_px];
        let project = |[x, y, z]: [f64; 3]| {
            [
                focal[0] * x / z + principal[0],
                focal[1] * y / z + principal[1],
            ]
        };
        self.coverage.clear();
        let share = 1.0 / instants.len() as f64;
        // From below there is no deck to see.
        for pose in instants.iter().filter(|pose| pose.height_m() > 0.0) {
            self.print.draw(&mut self.coverage, pose, &project, share);
        }
        self.coverage.sum_into(&mut self.light);
        self.blur();
        self.develop(normal);
        &self.pixels
    }

    /// The lens's point spread, first along rows, then along columns. The
    /// image goes on as it ends.
    fn blur(&mut self) {
        let (width, height) = (self.camera.width_px, self.camera.height_px);
        let reach = self.kernel.len() - 1;
        if reach == 0 {
            return;
        }
        let kernel = &self.kernel;
        let rows = self.light.chunks_exact(width);
        for (line, out) in rows.zip(self.blurred.chunks_exact_mut(width)) {
            for (x, out) in out.iter_mut().enumerate() {
                let mut sum = kernel[0] * line[x];
                if x >= reach && x + reach < width {
                    for (k, weight) in kernel.iter().enumerate().skip(1) {
                        sum += weight * (line[x - k] + line[x + k]);
                    }
                } else {
                    for (k, weight) in kernel.iter().enumerate().skip(1) {
                        sum += weight * (line[x.saturating_sub(k)] + line[(x + k).min(width - 1)]);
                    }
                }
                *out = sum;
            }
        }
        let row = |y: usize| &self.blurred[y * width..(y + 1) * width];
        for (y, out) in self.light.chunks_exact_mut(width).enumerate() {
            for (out, value) in out.iter_mut().zip(row(y)) {
                *out = kernel[0] * value;
            }
            for (k, weight) in kernel.iter().enumerate().skip(1) {
                let (above, below) = (row(y.saturating_sub(k)), row((y + k).min(height - 1)));
                for (out, (a, b)) in out.iter_mut().zip(above.iter().zip(below)) {
                    *out += weight * (a + b);
                }
            }
        }
    }

    /// Grey levels of the light, with noise.
    fn develop(&mut self, mut normal: impl FnMut() -> f64) {
        let (camera, image) = (&self.camera, &self.image);
        let (width, height) = (camera.width_px as f64, camera.height_px as f64);
        let rows = self.light.chunks_exact(camera.width_px);
        let out = self.pixels.chunks_exact_mut(camera.width_px);
        for (y, (line, out)) in rows.zip(out).enumerate() {
            let lit = 1.0 + image.gradient[1] * ((y as f64 + 0.5) / height - 0.5);
            for (x, (light, out)) in line.iter().zip(out).enumerate() {
                let lit = lit + image.gradient[0] * ((x as f64 + 0.5) / width - 0.5);
                let reflectance = self.print.beside + f64::from(*light);
                let mut grey = image.white_level * lit * reflectance;
                if image.noise_sd > 0.0 {
                    grey += image.noise_sd * normal();
                }
                // Casts saturate at 0 and 255.
                *out = grey.round() as u8;
            }
        }
    }
}

/// Middle and one side of a Gaussian that sums to 1, out to four standard deviations.
fn half_kernel(sd_px: f64) -> Vec<f32> {
    let reach = (4.0 * sd_px).ceil() as usize;
    let weight = |k: usize| (-0.5 * (k as f64 / sd_px).powi(2)).exp();
    let sides: f64 = (1..=reach).map(weight).sum();
    let total = 1.0 + 2.0 * sides;
    let mut kernel = vec![(1.0 / total) as f32];
    kernel.extend((1..=reach).map(|k| (weight(k) / total) as f32));
    kernel
}
