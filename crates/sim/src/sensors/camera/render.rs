//! The image.
//!
//! ```text
//! grey = white_level · L(u, v) · (G * mean over the exposure of ρ) + noise
//! ```
//!
//! ρ is the reflectance averaged over each pixel's square, exact for every
//! instant (the raster sums signed areas along rows); the exposure is the mean of instants no more
//! than a third of a pixel apart; G is the lens's Gaussian point spread; L the
//! illumination, linear in the image's coordinates; noise is white. Levels are
//! rounded and cut to 0..255.

use crate::error::SimError;
use crate::random::Stream;
use crate::sensors::camera::CameraSettings;
use crate::sensors::camera::print::DeckPrint;
use crate::sensors::camera::raster::Coverage;
use crate::sensors::camera::view::View;

/// Farthest that anything moves from one instant of an exposure to the next, px.
const INSTANT_PX: f64 = 1.0 / 3.0;

/// Most instants of an exposure: beyond 21 px of motion they are further apart.
const INSTANTS: usize = 64;

/// Takes images. Holds the memory that it works in.
#[derive(Clone, Debug)]
pub struct Renderer {
    camera: CameraSettings,
    print: DeckPrint,
    coverage: Coverage,
    light: Vec<f32>,
    blurred: Vec<f32>,
    kernel: Vec<f32>,
    pixels: Vec<u8>,
}

impl Renderer {
    /// Checks camera and print.
    ///
    /// # Errors
    /// Names the bad key, what is expected and the offending number.
    pub fn new(camera: &CameraSettings, print: &DeckPrint) -> Result<Self, SimError> {
        camera.validate()?;
        print.validate()?;
        let pixels = camera.width_px * camera.height_px;
        Ok(Self {
            camera: *camera,
            print: print.clone(),
            coverage: Coverage::new(camera.width_px, camera.height_px),
            light: vec![0.0; pixels],
            blurred: vec![0.0; pixels],
            kernel: half_kernel(camera.lens_sd_px),
            pixels: vec![0; pixels],
        })
    }

    /// The camera.
    #[must_use]
    pub fn camera(&self) -> &CameraSettings {
        &self.camera
    }

    /// The deck and its print.
    #[must_use]
    pub fn print(&self) -> &DeckPrint {
        &self.print
    }

    /// The image of an exposure from the view `open` to the view `shut`, row by
    /// row, with noise from the stream.
    ///
    /// # Errors
    /// When a view is no pose ([`View::validate`]).
    pub fn expose(
        &mut self,
        open: &View,
        shut: &View,
        stream: &mut Stream,
    ) -> Result<&[u8], SimError> {
        open.validate()?;
        shut.validate()?;
        let instants = self.instants(open, shut);
        let [focal, principal] = [self.camera.focal_px, self.camera.principal_px];
        let project = |[x, y, z]: [f64; 3]| {
            [
                focal[0] * x / z + principal[0],
                focal[1] * y / z + principal[1],
            ]
        };
        self.coverage.clear();
        let share = 1.0 / instants as f64;
        for i in 0..instants {
            let view = open.towards(shut, (i as f64 + 0.5) * share);
            // From below there is no deck to see.
            if view.camera_in_deck_m()[2] > 0.0 {
                self.print.draw(&mut self.coverage, &view, &project, share);
            }
        }
        self.coverage.sum_into(&mut self.light);
        self.blur();
        self.develop(stream);
        Ok(&self.pixels)
    }

    fn instants(&self, open: &View, shut: &View) -> usize {
        let steps = open.motion_px(shut, &self.camera) / INSTANT_PX;
        // A cast of a large number saturates.
        (steps.ceil() as usize).clamp(1, INSTANTS)
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

    fn develop(&mut self, stream: &mut Stream) {
        let camera = &self.camera;
        let (width, height) = (camera.width_px as f64, camera.height_px as f64);
        let rows = self.light.chunks_exact(camera.width_px);
        let out = self.pixels.chunks_exact_mut(camera.width_px);
        for (y, (line, out)) in rows.zip(out).enumerate() {
            let lit = 1.0 + camera.gradient[1] * ((y as f64 + 0.5) / height - 0.5);
            for (x, (light, out)) in line.iter().zip(out).enumerate() {
                let lit = lit + camera.gradient[0] * ((x as f64 + 0.5) / width - 0.5);
                let reflectance = self.print.beside + f64::from(*light);
                let mut grey = camera.white_level * lit * reflectance;
                if camera.noise_sd > 0.0 {
                    grey += camera.noise_sd * stream.normal();
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
