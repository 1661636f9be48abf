//! The landing pad: which tags stand where on the deck.
//!
//! Deck axes: x forward, y to port (left), z up along the deck's normal; the
//! origin is the deck's centre, where the vehicle is to land. Seen from above
//! with x up, y is to the left.

use serde::{Deserialize, Serialize};

use crate::error::{VisionError, ensure, finite, positive, setting};
use crate::family::{IDS, NEST};

/// A tag on the deck.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PadTag {
    /// Its id in the family 36h11.
    pub id: u32,
    /// Side of the black border's outer edge, m.
    pub size_m: f64,
    /// Its centre on the deck x, y, m.
    #[serde(default)]
    pub centre_m: [f64; 2],
    /// Turn of the print from "top is forward", to port, rad.
    #[serde(default)]
    pub yaw_rad: f64,
}

impl PadTag {
    /// The corners on the deck x, y, m, in the order of
    /// [`Detection::corners_px`](crate::detect::Detection::corners_px).
    #[must_use]
    pub fn corners_m(&self) -> [[f64; 2]; 4] {
        let half = 0.5 * self.size_m;
        let (sin, cos) = self.yaw_rad.sin_cos();
        let [x, y] = self.centre_m;
        [[half, half], [half, -half], [-half, -half], [-half, half]]
            .map(|[a, b]| [x + cos * a - sin * b, y + sin * a + cos * b])
    }
}

/// The tags of a pad.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pad {
    /// The tags; each id once.
    pub tags: Vec<PadTag>,
}

impl Default for Pad {
    /// Three tags, each in the middle of the next larger one: 0.4 m, 80 mm and
    /// 16 mm. With the default camera the first is seen from above 5 m down to
    /// 0.4 m, the last from 0.25 m down to 0.03 m.
    fn default() -> Self {
        let tag = |id, size_m| PadTag {
            id,
            size_m,
            centre_m: [0.0; 2],
            yaw_rad: 0.0,
        };
        Self {
            tags: vec![
                tag(77, 0.4),
                tag(323, 0.4 * NEST),
                tag(25, 0.4 * NEST * NEST),
            ],
        }
    }
}

impl Pad {
    /// Checks the pad.
    ///
    /// # Errors
    /// There is at least one tag; ids are in the family and differ; sizes are
    /// positive; places are finite.
    pub fn validate(&self) -> Result<(), VisionError> {
        ensure(!self.tags.is_empty(), "tags", "at least one tag", &0)?;
        for (i, tag) in self.tags.iter().enumerate() {
            let key = |name: &str| format!("tags[{i}].{name}");
            ensure(
                tag.id < IDS,
                &key("id"),
                "an id of the family, 0 to 586",
                &tag.id,
            )?;
            if self.tags[..i].iter().any(|other| other.id == tag.id) {
                return Err(setting(&key("id"), "an id that no other tag has", &tag.id));
            }
            positive(&key("size_m"), tag.size_m)?;
            for x in tag.centre_m {
                finite(&key("centre_m"), x)?;
            }
            finite(&key("yaw_rad"), tag.yaw_rad)?;
        }
        Ok(())
    }

    /// The tag of an id.
    #[must_use]
    pub fn tag(&self, id: u32) -> Option<&PadTag> {
        self.tags.iter().find(|tag| tag.id == id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_corners_of_a_turned_tag() {
        let tag = PadTag {
            id: 0,
            size_m: 0.2,
            centre_m: [1.0, 2.0],
            yaw_rad: std::f64::consts::FRAC_PI_2,
        };
        // The top of the print is to port, so its top left is rear and to port.
        let expected = [[0.9, 2.1], [1.1, 2.1], [1.1, 1.9], [0.9, 1.9]];
        for (corner, expected) in tag.corners_m().iter().zip(expected) {
            // Rounding only.
            assert!((corner[0] - expected[0]).abs() < 1e-15);
            assert!((corner[1] - expected[1]).abs() < 1e-15);
        }
    }

    #[test]
    fn prop_pads_without_sense_are_refused() {
        assert_eq!(Pad::default().validate(), Ok(()));
        let change = |f: fn(&mut Pad)| {
            let mut pad = Pad::default();
            f(&mut pad);
            pad.validate().unwrap_err().to_string()
        };
        assert!(change(|pad| pad.tags.clear()).contains("tags"));
        let twice = change(|pad| pad.tags[1].id = 77);
        assert!(twice.contains("tags[1].id") && twice.contains("77"));
        assert!(change(|pad| pad.tags[0].id = 587).contains("587"));
        assert!(change(|pad| pad.tags[2].size_m = -1.0).contains("tags[2].size_m"));
        assert!(change(|pad| pad.tags[0].centre_m[1] = f64::NAN).contains("NaN"));
    }
}
