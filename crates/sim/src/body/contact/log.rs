//! Record of the contact between legs and deck.

use serde::Serialize;

use super::{DEEPEST_M, Foot, LegSettings};

/// Record of the contact between legs and deck, updated in every step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ContactLog {
    /// Time of the first touch, s.
    pub first_touch_s: Option<f64>,
    /// Number of times that all feet left the deck after a touch.
    pub bounces: u32,
    /// Distance that a foot has slid, the largest of the four, m.
    pub slide_m: f64,
    /// Greatest normal force on a foot, N.
    pub greatest_normal_n: f64,
    /// Greatest tilt from the deck's normal after the first touch, rad.
    pub greatest_tilt_rad: f64,
    /// Time at which the tilt passed the limit: the vehicle has tipped over, s.
    pub tipped_s: Option<f64>,
    /// Time at which the vehicle fell off the deck, s: after a touch, no foot was on the
    /// deck and one was more than [`DEEPEST_M`] below its plane.
    pub fell_s: Option<f64>,
    /// Distance that each foot has slid, m.
    pub slid_m: [f64; 4],
    /// Number of feet on the deck at the last step.
    pub feet_down: u32,
    /// Positions of the feet on the deck at the last step.
    #[serde(skip)]
    before: [Option<[f64; 2]>; 4],
}

impl ContactLog {
    /// Adds the feet after a step at the time t; `tilt_rad` is the angle
    /// between the body's z axis and the deck's normal.
    pub fn add(&mut self, time_s: f64, feet: &[Foot; 4], tilt_rad: f64, settings: &LegSettings) {
        let on = feet.map(|foot| (foot.force_n[2] > 0.0).then_some(foot.place_m));
        let down = on.iter().flatten().count() as u32;
        if down > 0 && self.first_touch_s.is_none() {
            self.first_touch_s = Some(time_s);
        }
        if self.first_touch_s.is_none() {
            return;
        }
        self.bounces += u32::from(self.feet_down > 0 && down == 0);
        self.feet_down = down;
        let deepest = feet.iter().map(|f| f.depth_m).fold(f64::MIN, f64::max);
        self.greatest_tilt_rad = self.greatest_tilt_rad.max(tilt_rad);
        for i in 0..4 {
            self.greatest_normal_n = self.greatest_normal_n.max(feet[i].force_n[2]);
            if let (true, Some([x, y]), Some([a, b])) = (feet[i].slides, on[i], self.before[i]) {
                self.slid_m[i] += (x - a).hypot(y - b);
                self.slide_m = self.slide_m.max(self.slid_m[i]);
            }
        }
        self.before = on;
        if tilt_rad > settings.tipped_rad && self.tipped_s.is_none() {
            self.tipped_s = Some(time_s);
        }
        if down == 0 && deepest > DEEPEST_M && self.fell_s.is_none() {
            self.fell_s = Some(time_s);
        }
    }
}
