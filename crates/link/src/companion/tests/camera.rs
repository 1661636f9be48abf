//! A companion with a camera of its own: what it uses, what the checklist says, and a camera that goes.

use super::*;
use crate::camera::report::{CameraReport, DeckFix, FrameReport};
use crate::checklist::Verdict;
use touchdown_lander::state_machine::Phase;

/// Message id of `LANDING_TARGET`.
const LANDING_TARGET: u32 = 149;

/// A bench whose companion has a camera of 33 Hz.
struct CameraBench {
    bench: Bench,
    /// Whether a tag is in view.
    sees: bool,
    /// Whether frames come.
    films: bool,
    /// Time from the exposure to the companion, µs; none for frames without stamps.
    latency_us: Option<i64>,
}

impl CameraBench {
    fn new() -> Self {
        let mut bench = Bench::new();
        let mut settings = bench.companion.settings.clone();
        settings.camera.command = Some(vec!["film".to_string()]);
        bench.companion = Companion::new(&settings, &Session::default()).unwrap();
        bench.mute.push(LANDING_TARGET);
        Self {
            bench,
            sees: true,
            films: true,
            latency_us: Some(30_000),
        }
    }

    fn frame(&self) -> FrameReport {
        let now = self.bench.now_us as i64;
        let tick = self.bench.now_us / 10_000;
        let noise = f64::from(self.bench.noise(LANDING_TARGET, tick));
        FrameReport {
            exposed_us: self.latency_us.map(|latency_us| now - latency_us),
            arrived_us: now - 5_000,
            size_px: [640, 480],
            dropped: 1,
            unreadable: 0,
            deck: self.sees.then_some(DeckFix {
                position_m: [noise, 0.0, -self.bench.height_m],
                covariance_m2: [[1e-5, 0.0, 0.0], [0.0, 1e-5, 0.0], [0.0, 0.0, 1e-5]],
                normal: [0.0, 0.0, 1.0],
                tags: 2,
                residual_px: 0.1,
            }),
        }
    }

    fn run(&mut self, seconds: f64) {
        for _ in 0..(seconds * 100.0).round() as u64 {
            self.bench.run(0.01);
            if self.films && (self.bench.now_us / 10_000).is_multiple_of(3) {
                let report = CameraReport::Frame(self.frame());
                self.bench.event(Event::Camera(&report));
            }
        }
    }

    fn ready() -> Self {
        let mut camera = Self::new();
        camera.run(8.0);
        let companion = &camera.bench.companion;
        assert_eq!(
            companion.stage(),
            Stage::Ready,
            "{}",
            companion.checklist().changes(&[])
        );
        camera
    }

    fn flying() -> Self {
        let mut camera = Self::ready();
        camera.bench.mode = OFFBOARD;
        camera.run(1.5);
        assert_eq!(camera.bench.companion.stage(), Stage::InControl);
        camera
    }

    fn item(&self) -> (Verdict, String) {
        let items = &self.bench.companion.checklist().items;
        let item = items.iter().find(|item| item.name == "camera");
        item.map(|item| (item.verdict, item.sentence.clone()))
            .expect("a camera's item")
    }

    fn gone(&mut self) {
        self.films = false;
        let report = CameraReport::Gone("unplugged".to_string());
        self.bench.event(Event::Camera(&report));
    }
}

#[test]
fn prop_the_checklist_says_what_the_camera_gives() {
    let mut camera = CameraBench::ready();
    let (verdict, said) = camera.item();
    assert_eq!(verdict, Verdict::Good);
    // The newest count is of 2 s.
    for part in [
        "640 x 480",
        "Hz of 30 Hz",
        "30 ms from exposure",
        "a tag in 100 %",
        "1 dropped",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    (camera.sees, camera.latency_us) = (false, None);
    let mut camera = CameraBench {
        bench: CameraBench::new().bench,
        ..camera
    };
    camera.run(8.0);
    let (_, said) = camera.item();
    assert!(
        said.contains("no tag in view") && said.contains("no stamps"),
        "{said}"
    );
    // Without a position of the deck nothing is ready.
    assert_eq!(camera.bench.companion.stage(), Stage::Checking);
    camera.films = false;
    camera.run(5.0);
    let (verdict, said) = camera.item();
    assert!(
        verdict == Verdict::Refused && said.contains(" 0 Hz of 30 Hz"),
        "{said}"
    );
}

#[test]
fn regress_positions_by_the_camera_are_judged_by_its_rate() {
    let mut camera = CameraBench::new();
    let mut settings = camera.bench.companion.settings.clone();
    // Half of it would be needed; the camera gives 33 Hz of its own 30 Hz.
    settings.rates.target_hz = 100.0;
    camera.bench.companion = Companion::new(&settings, &Session::default()).unwrap();
    camera.run(8.0);
    let companion = &camera.bench.companion;
    let text = companion.checklist().changes(&[]);
    assert_eq!(companion.stage(), Stage::Ready, "{text}");
}

#[test]
fn prop_beside_a_camera_positions_of_others_are_ignored() {
    let mut camera = CameraBench::ready();
    camera.bench.mute.clear();
    camera.films = false;
    camera.run(3.0);
    assert_ne!(camera.bench.companion.stage(), Stage::Ready);
    assert!(camera.bench.companion.inbox.ignored.beside_camera > 0);
}

#[test]
fn prop_a_camera_that_goes_before_control_is_refused_and_no_setpoint_follows() {
    let mut camera = CameraBench::ready();
    camera.gone();
    camera.run(1.0);
    assert_eq!(camera.bench.companion.stage(), Stage::Checking);
    assert_eq!(
        camera.item(),
        (Verdict::Refused, "gone: unplugged.".to_string())
    );
    let setpoints = camera.bench.setpoints();
    camera.bench.mode = OFFBOARD;
    camera.run(2.0);
    assert_eq!(camera.bench.setpoints(), setpoints);
    assert_eq!(
        camera
            .bench
            .companion
            .summary()
            .camera
            .unwrap()
            .gone
            .as_deref(),
        Some("unplugged")
    );
}

#[test]
fn prop_a_camera_that_goes_or_sees_nothing_in_control_ends_in_no_descent() {
    let faults: [fn(&mut CameraBench); 3] = [
        CameraBench::gone,
        |camera| camera.films = false,
        |camera| camera.sees = false,
    ];
    for fault in faults {
        let mut camera = CameraBench::flying();
        fault(&mut camera);
        // Half a second is the age at which a tag counts as lost, with its tolerance.
        camera.run(1.0);
        for _ in 0..40 {
            camera.run(0.25);
            let companion = &camera.bench.companion;
            let phase = companion.phase();
            let descends = matches!(phase, Some(Phase::Descend | Phase::Touchdown));
            let flies = companion.stage() == Stage::InControl;
            assert!(!(flies && descends), "{phase:?}");
        }
    }
}

#[test]
fn prop_reports_that_make_no_sense_are_ignored_and_counted() {
    let mut camera = CameraBench::ready();
    let ignored = |camera: &CameraBench| camera.bench.companion.inbox.ignored;
    let before = ignored(&camera);
    let good = camera.frame();
    let deck = good.deck.unwrap();
    let now = camera.bench.now_us as i64;
    let with = |exposed_us, deck| FrameReport {
        exposed_us,
        deck: Some(deck),
        ..good
    };
    for frame in [
        with(Some(now - 2_000_000), deck),
        with(Some(now + 1_000_000), deck),
        with(Some(i64::MIN), deck),
        with(Some(i64::MAX), deck),
        with(Some(now - 100_000), deck),
        with(
            Some(now),
            DeckFix {
                position_m: [f64::NAN; 3],
                ..deck
            },
        ),
        with(
            Some(now),
            DeckFix {
                normal: [f64::INFINITY; 3],
                ..deck
            },
        ),
    ] {
        camera
            .bench
            .event(Event::Camera(&CameraReport::Frame(frame)));
    }
    let after = ignored(&camera);
    assert_eq!(after.too_old - before.too_old, 2);
    assert_eq!(after.from_the_future - before.from_the_future, 2);
    assert_eq!(after.repeated - before.repeated, 1);
    assert_eq!(after.unusable - before.unusable, 2);
    camera.run(1.0);
    assert_eq!(camera.bench.companion.stage(), Stage::Ready);
}

#[test]
fn prop_a_companion_without_a_camera_hears_nothing_of_one() {
    let mut bench = Bench::ready();
    let report = CameraReport::Gone("unplugged".to_string());
    bench.event(Event::Camera(&report));
    bench.run(1.0);
    assert_eq!(bench.companion.stage(), Stage::Ready);
    assert!(bench.companion.summary().camera.is_none());
}
