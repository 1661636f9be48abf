//! The camera's items of the checklist.

use super::{Facts, Item, Verdict, item};

impl Facts<'_> {
    /// What the camera gives; none for a companion without one.
    pub(super) fn camera(&self) -> Option<Item> {
        let camera = self.camera?;
        let judged = match (&camera.gone, camera.rates_hz, &camera.newest) {
            (Some(why), _, _) => (Verdict::Refused, format!("gone: {why}.")),
            (_, None, _) | (_, _, None) => (Verdict::Waiting, "waits for frames.".to_string()),
            (_, Some([hz, with_tag_hz]), Some(frame)) => {
                let asked = self.settings.camera.rate_hz;
                let least = self.settings.rates.least_share * asked;
                let verdict = if hz >= least {
                    Verdict::Good
                } else {
                    Verdict::Refused
                };
                let [width, height] = frame.size_px;
                let latency = match camera.latency_s {
                    Some(latency_s) => format!("{:.0} ms from exposure to here", latency_s * 1e3),
                    None => format!(
                        "no stamps: taken as exposed {:.0} ms before their arrival, the rest is found in flight",
                        self.settings.camera.latency_s * 1e3
                    ),
                };
                let tag = if with_tag_hz > 0.0 {
                    format!("a tag in {:.0} % of them", 100.0 * with_tag_hz / hz)
                } else {
                    "no tag in view".to_string()
                };
                let sentence = format!(
                    "{width} x {height} pixels, {hz:.0} Hz of {asked:.0} Hz (at least {least:.0} Hz are needed), {latency}, {tag}; {} dropped, {} unreadable.",
                    frame.dropped, frame.unreadable
                );
                (verdict, sentence)
            }
        };
        Some(item("camera", judged))
    }
}
