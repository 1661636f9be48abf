//! The position of the deck, from the companion's own camera.

use touchdown_flight::Vector;
use touchdown_lander::computer::NormalReading;
use touchdown_lander::estimate::relative::{Reading, TagReading};

use super::{Inbox, Source};
use crate::camera::report::FrameReport;

impl Inbox {
    /// Takes what was found in a frame. A frame without a stamp is as old at its arrival as `camera.latency_s` says.
    pub fn take_frame(&mut self, frame: &FrameReport, now_us: i64) {
        let Some(deck) = &frame.deck else {
            return;
        };
        let unstamped = frame.arrived_us.saturating_sub(self.camera_latency_us);
        let at = frame.exposed_us.unwrap_or(unstamped);
        let reading = Reading::Tag(TagReading {
            position_m: Vector::from_array(deck.position_m),
            covariance_m2: deck.covariance_m2,
            age_s: 0.0,
        });
        let normal = Vector::from_array(deck.normal);
        let age = now_us.saturating_sub(at);
        if !reading.is_finite() || !normal.is_finite() {
            self.ignored.unusable += 1;
        } else if age > self.greatest_age_us {
            self.ignored.too_old += 1;
        } else if age < -super::FUTURE_US {
            self.ignored.from_the_future += 1;
        } else if self.newest_us[Source::Target as usize].is_some_and(|newest| at <= newest) {
            self.ignored.repeated += 1;
        } else if self.queue_at(Source::Target, reading, at) {
            self.normal = Some((at, normal));
        }
    }

    /// The deck's normal, body axes, if a frame has shown it since the last call.
    pub fn take_normal(&mut self, now_us: i64) -> Option<NormalReading<f64>> {
        let (at, normal) = self.normal.take()?;
        Some(NormalReading {
            normal,
            age_s: (now_us - at).max(0) as f64 * 1e-6,
        })
    }
}
