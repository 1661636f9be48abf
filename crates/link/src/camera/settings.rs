//! Settings of the camera, `[camera]` of `FLIGHT.toml`.

use std::path::PathBuf;

use serde::{Deserialize, Serialize};
use touchdown_flight::Vector;
use touchdown_vision::VisionError;
use touchdown_vision::camera::CameraSettings as Intrinsics;
use touchdown_vision::detect::DetectorSettings;
use touchdown_vision::locate::LocatorSettings;
use touchdown_vision::pad::Pad;

use super::folder::Times;
use super::stream::StreamFormat;

/// The camera: where its images come from, its lens, how it is mounted, and the pad that it looks for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CameraSettings {
    /// A V4L2 device, which `v4l2-ctl` reads.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub device: Option<PathBuf>,
    /// A folder of images, relative to the settings file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub folder: Option<PathBuf>,
    /// Where the times of these images stand.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub times: Option<Times>,
    /// A program and its arguments, which writes frames to its standard output.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub command: Option<Vec<String>>,
    /// How the frames of the command follow each other.
    pub format: StreamFormat,
    /// Frames a second: a device is asked for them.
    pub rate_hz: f64,
    /// Width of the image, px.
    pub width_px: usize,
    /// Height of the image, px.
    pub height_px: usize,
    /// Focal lengths f_x, f_y, px.
    pub focal_px: [f64; 2],
    /// Principal point c_x, c_y, px; pixel centres are at +½.
    pub principal_px: [f64; 2],
    /// Distortion of the lens k₁, k₂, p₁, p₂, k₃, as OpenCV's.
    pub distortion: [f64; 5],
    /// Place of the lens, forward-left-up from the vehicle's reference point, m.
    pub position_m: [f64; 3],
    /// Turn of the image's top from forward to the left, rad.
    pub turn_rad: f64,
    /// How far the camera looks forward and to the left of straight down, rad.
    pub lean_rad: [f64; 2],
    /// Time that the shutter is open, s.
    pub exposure_s: f64,
    /// Age at arrival of a frame without a stamp, as far as it is known, s.
    pub latency_s: f64,
    /// Frames a second that go to the recording; 0 for none.
    pub record_hz: f64,
    /// How tags are looked for.
    pub detector: DetectorSettings,
    /// How corners become a pose.
    pub locator: LocatorSettings,
    /// The tags on the deck.
    pub pad: Pad,
}

impl Default for CameraSettings {
    /// No camera; the lens and the mounting of the simulated one.
    fn default() -> Self {
        let lens = Intrinsics::default();
        Self {
            device: None,
            folder: None,
            times: None,
            command: None,
            format: StreamFormat::default(),
            rate_hz: 30.0,
            width_px: lens.width_px,
            height_px: lens.height_px,
            focal_px: lens.focal_px,
            principal_px: lens.principal_px,
            distortion: [0.0; 5],
            position_m: [0.0, 0.0, -0.02],
            turn_rad: 0.0,
            lean_rad: [0.0; 2],
            exposure_s: 0.004,
            latency_s: 0.0,
            record_hz: 0.0,
            detector: DetectorSettings::default(),
            locator: LocatorSettings::default(),
            pad: pad(),
        }
    }
}

/// The standard pad, with sizes as they are printed.
fn pad() -> Pad {
    let mut pad = Pad::default();
    for (tag, size_m) in pad.tags.iter_mut().zip([0.4, 0.08, 0.016]) {
        tag.size_m = size_m;
    }
    pad
}

/// Where images come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source<'a> {
    /// A V4L2 device.
    Device(&'a PathBuf),
    /// A folder, and where its times stand.
    Folder(&'a PathBuf, &'a Times),
    /// A program and its arguments.
    Command(&'a [String]),
}

/// A setting of the camera that cannot be used, in one sentence.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct CameraError(String);

impl CameraError {
    /// The error of a key of `[camera]`.
    #[must_use]
    pub fn new(key: &str, reason: &dyn std::fmt::Display) -> Self {
        Self(format!("camera.{key}: {reason}"))
    }

    pub(super) fn of_vision(section: &str, error: &VisionError) -> Self {
        match error {
            VisionError::Setting {
                key,
                expected,
                found,
            } => Self(format!(
                "camera{section}.{key}: expected {expected}, found {found}"
            )),
            other => Self(format!("camera{section}: {other}")),
        }
    }
}

fn refuse<T>(key: &str, expected: &str, found: &dyn std::fmt::Display) -> Result<T, CameraError> {
    Err(CameraError(format!(
        "camera.{key}: expected {expected}, found {found}"
    )))
}

fn within(
    key: &str,
    value: f64,
    [least, greatest]: [f64; 2],
    unit: &str,
) -> Result<(), CameraError> {
    if (least..=greatest).contains(&value) {
        Ok(())
    } else {
        refuse(key, &format!("{least} to {greatest}{unit}"), &value)
    }
}

impl CameraSettings {
    /// The source of images; none for a vehicle whose deck others find.
    ///
    /// # Errors
    /// More than one source, a folder without times, or a command without a program.
    pub fn source(&self) -> Result<Option<Source<'_>>, CameraError> {
        let device = self.device.as_ref().map(Source::Device);
        let command = self.command.as_deref().map(Source::Command);
        let folder = match (&self.folder, &self.times) {
            (Some(folder), Some(times)) => Some(Source::Folder(folder, times)),
            (Some(_), None) => {
                let expected = "\"names\" for times in the images' names, or the name of a CSV file in the folder";
                return refuse("times", expected, &"none");
            }
            (None, Some(_)) => return refuse("folder", "a folder beside `times`", &"none"),
            (None, None) => None,
        };
        if self
            .command
            .as_ref()
            .is_some_and(|command| command.first().is_none_or(String::is_empty))
        {
            return refuse("command", "a program and its arguments", &"an empty list");
        }
        let raw = matches!(self.format, StreamFormat::Grey | StreamFormat::Yuyv);
        if device.is_some() && !raw {
            return refuse(
                "format",
                "\"grey\" or \"yuyv\" for a device",
                &"another format",
            );
        }
        let mut sources = [device, folder, command].into_iter().flatten();
        let source = sources.next();
        if sources.next().is_some() {
            let expected = "one of `device`, `folder` and `command`";
            return refuse("device", expected, &"more than one");
        }
        Ok(source)
    }

    /// The lens.
    #[must_use]
    pub fn intrinsics(&self) -> Intrinsics {
        Intrinsics {
            width_px: self.width_px,
            height_px: self.height_px,
            focal_px: self.focal_px,
            principal_px: self.principal_px,
            distortion: self.distortion,
        }
    }

    /// Width and height, px.
    #[must_use]
    pub fn size_px(&self) -> [usize; 2] {
        [self.width_px, self.height_px]
    }

    /// Directions of the camera's axes (right in the image, down, ahead) in body axes.
    #[must_use]
    pub fn axes(&self) -> [Vector<f64>; 3] {
        let [forward, left] = self.lean_rad;
        let ahead = Vector::new(forward.tan(), left.tan(), -1.0);
        let ahead = ahead.direction().unwrap_or(Vector::new(0.0, 0.0, -1.0));
        let (sin, cos) = self.turn_rad.sin_cos();
        // The top of the image, made orthogonal to the view.
        let top = Vector::new(cos, sin, 0.0);
        let top = top - ahead * ahead.dot(top);
        let down = top.direction().unwrap_or(Vector::new(1.0, 0.0, 0.0)) * -1.0;
        [down.cross(ahead), down, ahead]
    }

    /// Checks all but the source.
    ///
    /// # Errors
    /// Names the first setting that is not usable.
    pub fn check(&self) -> Result<(), CameraError> {
        self.source()?;
        let of_vision = |section| move |e| CameraError::of_vision(section, &e);
        self.intrinsics().validate().map_err(of_vision(""))?;
        self.detector.validate().map_err(of_vision(".detector"))?;
        self.locator.validate().map_err(of_vision(".locator"))?;
        self.pad.validate().map_err(of_vision(".pad"))?;
        within("rate_hz", self.rate_hz, [1.0, 1000.0], " Hz")?;
        for x in self.distortion {
            within("distortion", x, [-10.0, 10.0], "")?;
        }
        for x in self.position_m {
            within("position_m", x, [-10.0, 10.0], " m")?;
        }
        within("turn_rad", self.turn_rad, [-7.0, 7.0], " rad")?;
        for x in self.lean_rad {
            // A camera that looks farther from straight down does not see the deck in the descent.
            within("lean_rad", x, [-1.0, 1.0], " rad")?;
        }
        within("exposure_s", self.exposure_s, [0.0, 0.1], " s")?;
        within("latency_s", self.latency_s, [0.0, 0.3], " s")?;
        within("record_hz", self.record_hz, [0.0, 1000.0], " Hz")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_axes_of_a_camera_that_looks_down_and_of_one_that_is_turned_and_leans() {
        let close = |a: Vector<f64>, b: [f64; 3]| {
            assert!((a - Vector::from_array(b)).norm() < 1e-12, "{a:?} {b:?}");
        };
        let [right, down, ahead] = CameraSettings::default().axes();
        close(right, [0.0, -1.0, 0.0]);
        close(down, [-1.0, 0.0, 0.0]);
        close(ahead, [0.0, 0.0, -1.0]);
        let turned = CameraSettings {
            turn_rad: std::f64::consts::FRAC_PI_2,
            ..CameraSettings::default()
        };
        let [right, down, _] = turned.axes();
        close(right, [1.0, 0.0, 0.0]);
        close(down, [0.0, -1.0, 0.0]);
        let leaning = CameraSettings {
            lean_rad: [0.3, 0.0],
            ..CameraSettings::default()
        };
        let [right, down, ahead] = leaning.axes();
        close(right, [0.0, -1.0, 0.0]);
        close(down, [-(0.3_f64.cos()), 0.0, -(0.3_f64.sin())]);
        close(ahead, [0.3_f64.sin(), 0.0, -(0.3_f64.cos())]);
        let both = CameraSettings {
            lean_rad: [0.4, -0.7],
            turn_rad: 1.0,
            ..CameraSettings::default()
        };
        let [right, down, ahead] = both.axes();
        // Right-handed and orthonormal, to rounding.
        close(right.cross(down), ahead.to_array());
        assert!((right.norm() - 1.0).abs() < 1e-12 && right.dot(ahead).abs() < 1e-12);
    }

    #[test]
    fn prop_settings_without_sense_are_refused_in_one_sentence() {
        let check = |text: &str| {
            let settings: Result<CameraSettings, _> = toml::from_str(text);
            settings.expect("a table").check()
        };
        check("").unwrap();
        check("device = \"/dev/video0\"\nformat = \"yuyv\"").unwrap();
        check("folder = \"frames\"\ntimes = \"names\"").unwrap();
        check("command = [\"ffmpeg\"]\nformat = \"pgm\"").unwrap();
        for (text, part) in [
            ("folder = \"frames\"", "camera.times: expected \"names\""),
            ("times = \"names\"", "camera.folder"),
            ("command = []", "camera.command"),
            ("command = [\"\"]", "camera.command"),
            ("device = \"a\"", "camera.format"),
            (
                "device = \"a\"\nformat = \"grey\"\ncommand = [\"b\"]",
                "more than one",
            ),
            ("width_px = 1", "width_px"),
            ("focal_px = [0.0, 400.0]", "focal_px"),
            (
                "distortion = [nan, 0.0, 0.0, 0.0, 0.0]",
                "camera.distortion",
            ),
            ("position_m = [0.0, 11.0, 0.0]", "found 11"),
            ("lean_rad = [1.5, 0.0]", "camera.lean_rad"),
            ("exposure_s = 1.0", "0 to 0.1 s"),
            ("latency_s = -0.1", "camera.latency_s"),
            ("rate_hz = 0.0", "camera.rate_hz"),
            ("[detector]\nthreads = 0", "camera.detector"),
            ("[locator]\ngate_px = 0.0", "camera.locator"),
            ("[pad]\ntags = []", "camera.pad"),
        ] {
            let said = check(text).unwrap_err().to_string();
            assert!(said.contains(part), "{text}: {said}");
        }
        assert!(toml::from_str::<CameraSettings>("focal = 3").is_err());
    }
}
