//! The terminal view of a flight, in a thread of its own: a terminal that is stopped does not stop the flight.

use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};

use serde::Serialize;
use touchdown_lander::state_machine::{Phase, Reason};
use touchdown_link::checklist::{Checklist, Verdict};
use touchdown_link::companion::{Companion, Ending, Stage};
use touchdown_link::timing::Quantiles;

use crate::cli::context::Context;

/// News that wait for the terminal at most; more are not shown.
const WAITING: usize = 256;
/// Time between two states, µs.
const PERIOD_US: u64 = 1_000_000;

/// The state, once a second: an object of `--json`.
#[derive(Clone, Copy, Debug, Serialize)]
struct State {
    /// Time since the start, s.
    time_s: f64,
    stage: Stage,
    ending: Option<Ending>,
    phase: Option<Phase>,
    /// What keeps the vehicle from its descent.
    waits_for: Option<Reason>,
    /// Height above the deck, m.
    height_m: Option<f64>,
    /// Setpoints sent in control.
    setpoints: u64,
    /// Estimated latency of the readings beyond their stamped ages, s.
    latency_s: Option<f64>,
    /// Deviations of the period from 10 ms so far.
    jitter: Option<Quantiles>,
    /// The worst verdict of the checklist.
    checklist: Verdict,
}

/// Something to show.
enum News {
    Note(String),
    /// The checklist, and the verdicts that were shown before.
    Checklist(Arc<Checklist>, Vec<Verdict>),
    State(State),
}

/// The loop's side.
pub(super) struct View {
    news: SyncSender<News>,
    shown: Vec<Verdict>,
    next_us: u64,
}

/// The terminal's side.
pub(super) struct Shown(Receiver<News>);

/// Both sides.
pub(super) fn view() -> (View, Shown) {
    let (news, shown) = sync_channel(WAITING);
    let view = View {
        news,
        shown: Vec::new(),
        next_us: 0,
    };
    (view, Shown(shown))
}

impl View {
    /// Shows the end.
    pub(super) fn end(mut self, companion: &mut Companion, at_us: u64) {
        self.next_us = at_us;
        let _ = self.update(companion, at_us);
    }

    /// Shows news. Returns the checklist if a verdict has changed.
    pub(super) fn update(
        &mut self,
        companion: &mut Companion,
        at_us: u64,
    ) -> Option<Arc<Checklist>> {
        let mut changed = None;
        for note in companion.take_notes() {
            self.show(News::Note(note));
        }
        let list = companion.checklist();
        let verdicts = || list.items.iter().map(|item| item.verdict);
        if !verdicts().eq(self.shown.iter().copied()) {
            let before = std::mem::replace(&mut self.shown, verdicts().collect());
            let list = Arc::new(list.clone());
            changed = Some(Arc::clone(&list));
            self.show(News::Checklist(list, before));
        }
        if at_us >= self.next_us {
            self.next_us = at_us.saturating_add(PERIOD_US);
            self.show(News::State(State {
                time_s: at_us as f64 * 1e-6,
                stage: companion.stage(),
                ending: companion.ending(),
                phase: companion.phase(),
                waits_for: companion.waits_for(),
                height_m: companion.height_m(),
                setpoints: companion.setpoints(),
                latency_s: companion.latency_s(),
                jitter: companion.jitter(),
                checklist: companion.checklist().verdict(),
            }));
        }
        changed
    }

    fn show(&self, news: News) {
        // A terminal that does not keep up misses some of them.
        let _ = self.news.try_send(news);
    }
}

impl Shown {
    /// Shows everything until the flight has ended.
    pub(super) fn show(self, context: &Context) {
        for news in self.0 {
            match news {
                News::Note(note) => context.say(&note),
                News::Checklist(list, before) => context.say(&list.changes(&before)),
                News::State(state) => {
                    context.busy(&line(&state));
                    context.line_object(&state);
                }
            }
        }
        context.finish();
    }
}

/// The state on a line.
fn line(state: &State) -> String {
    let stage = format!("{:?}", state.stage);
    let (Some(phase), Some(height_m)) = (state.phase, state.height_m) else {
        return stage;
    };
    let waits = state.waits_for.map(|reason| format!(" ({reason:?})"));
    let waits = waits.unwrap_or_default();
    format!("{stage}: {phase:?}{waits}, {height_m:.2} m above the deck")
}
