//! News of the camera.

use super::Companion;
use crate::camera::report::CameraReport;

impl Companion {
    /// Takes news of the camera.
    pub(super) fn take_camera(&mut self, report: &CameraReport) {
        let now = self.times.now;
        match (report, &mut self.camera) {
            (CameraReport::Frame(frame), Some(camera)) => {
                camera.take(frame, now);
                self.inbox.take_frame(frame, now);
            }
            (CameraReport::Gone(why), Some(camera)) => {
                self.notes.push(format!("the camera is gone: {why}"));
                camera.gone.get_or_insert_with(|| why.clone());
            }
            (_, None) => {}
        }
    }
}
