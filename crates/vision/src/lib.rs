//! AprilTags of a landing pad: detection in an image, the pad's pose and its covariance; rendering.
//!
//! ```text
//! grey image ── detect ──> tags' corners ── locate ──> pose of the deck in the camera, with covariance
//! ```
//!
//! The tags are found by `locus-core`. The pose is the one that explains the
//! corners of *all* tags of the [`Pad`](pad::Pad) that are seen, and its
//! covariance says how well; tags are nested so that one is in view from metres
//! away down to contact. Nothing here knows of simulation: the same code looks
//! at a camera's images and at rendered ones.
//!
//! | module | what it holds |
//! | --- | --- |
//! | [`camera`] | the pinhole, its axes, and where pixel centres are |
//! | [`mod@image`] | a view of somebody's grey image |
//! | [`detect`] | tags in an image |
//! | [`pad`], [`family`] | which tags stand where; what they look like |
//! | [`mod@render`] | images of a pad, for simulation and tests of detection |
//! | [`locate`] | from corners to the deck's pose and its covariance |
//! | [`error`] | what can be wrong |
//!
//! No tag in view is an answer (`None`), not an error.
//!
//! ```
//! use touchdown_vision::{Detector, GrayImage, Locator};
//! use touchdown_vision::{camera::CameraSettings, detect::DetectorSettings};
//! use touchdown_vision::{locate::{Hints, LocatorSettings}, pad::Pad};
//!
//! let camera = CameraSettings::default(); // 640 × 480 pixels, pixel centres at +½
//! let mut detector = Detector::new(&DetectorSettings::default())?;
//! let locator = Locator::new(&camera, &Pad::default(), &LocatorSettings::default())?;
//!
//! let pixels = vec![128; 640 * 480]; // a camera's image; this one is empty
//! let image = GrayImage::new(&pixels, 640, 480, 640)?;
//! let tags = detector.detect(&image)?;
//! let hints = Hints {
//!     up: Some([0.0, 0.0, -1.0]), // the vehicle is about level, the camera looks down
//!     ..Hints::default()
//! };
//! match locator.locate(&tags, &hints) {
//!     Some(fix) => assert!(fix.camera_in_deck_m()[2] > 0.0),
//!     None => assert!(tags.is_empty()),
//! }
//! # Ok::<(), touchdown_vision::VisionError>(())
//! ```

pub mod camera;
pub mod detect;
pub mod error;
pub mod family;
pub mod image;
pub mod locate;
pub mod pad;
mod planar;
pub mod render;

pub use detect::{Detection, Detector};
pub use error::VisionError;
pub use image::GrayImage;
pub use locate::{Fix, Hints, Locator};
