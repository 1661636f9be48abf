//! Past states and the readings between them.
//!
//! A node is the state at the end of a step. Readings are sorted between nodes by the
//! time of measurement. After an old reading, all states from the node before it are
//! computed again. So the result equals that of readings without latency.
//!
//! If the log is full, its oldest reading is dropped. States before that reading can
//! then not be computed again, so readings that are older are rejected as too old.

mod past;

pub(crate) use past::Past;

use super::DeckSighting;
use super::RelativeFilter;
use super::belief::Belief;
use super::clearer;
use super::health::{Fate, Monitors};
use super::reading::{RangeReading, Reading};
use touchdown_flight::real::Real;
use touchdown_flight::space::{Attitude, Vector};

/// The state at the end of a step, and what was measured during the step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node<R> {
    pub(super) belief: Belief<R>,
    /// Acceleration over the step before, world axes, gravity removed, with its
    /// bias, m/s².
    pub(super) acceleration_mps2: Vector<R>,
    pub(super) attitude: Attitude<R>,
    /// Length of the step before, s.
    pub(super) dt: R,
}

/// A reading and its time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Entry<R> {
    /// Number of the node before it.
    node: u64,
    /// Time since that node, s; zero for a reading at the node.
    offset: R,
    reading: Reading<R>,
    /// Age of the reading when it was first used, s.
    age_s: R,
    /// No state contains the reading yet.
    new: bool,
    /// The reading is outside the sensor's usable range and need not be kept.
    useless: bool,
}

/// Values that a restart of the states does not erase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Accounts<R: Real> {
    pub(super) monitors: Monitors<R>,
    /// Reading of the barometer at zero altitude, m.
    pub(super) barometer_origin_m: Option<R>,
}

/// Result of the insertion of a reading.
pub(super) enum Insertion {
    /// The log contains the reading.
    Logged,
    /// Rejected: it is older than the oldest node.
    TooOld,
    /// Rejected: the log is full of readings that no state contains yet.
    NoRoom,
}

/// The last N nodes and up to M readings between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct History<R, const N: usize, const M: usize> {
    nodes: [Node<R>; N],
    /// Number of the newest node, from 0.
    head: u64,
    /// Readings in the order of their times, in a ring from `start` on.
    log: [Entry<R>; M],
    start: usize,
    length: usize,
    /// The first node whose successors must be computed again.
    dirty: u64,
    /// The last node whose state is computed.
    computed: u64,
    /// The first node from which all readings are still in the log.
    complete: u64,
}

impl<R: Real> Node<R> {
    const BLANK: Self = Self {
        belief: Belief::BLANK,
        acceleration_mps2: Vector::ZERO,
        attitude: Attitude::BLANK,
        dt: R::ZERO,
    };
}

impl<R: Real> Entry<R> {
    const BLANK: Self = Self {
        node: 0,
        offset: R::ZERO,
        reading: Reading::Range(RangeReading {
            distance_m: R::ZERO,
            deck_normal: Vector::ZERO,
            age_s: R::ZERO,
        }),
        age_s: R::ZERO,
        new: false,
        useless: false,
    };
}

impl<R: Real, const N: usize, const M: usize> History<R, N, M> {
    /// Zeros, for [`Self::reset`].
    pub(super) const BLANK: Self = {
        assert!(N >= 2 && M >= 1, "room for two states and a reading");
        Self {
            nodes: [Node::BLANK; N],
            head: 0,
            log: [Entry::BLANK; M],
            start: 0,
            length: 0,
            dirty: 0,
            computed: 0,
            complete: 0,
        }
    };

    /// The first state alone, without readings.
    pub(super) fn reset(&mut self, first: &Node<R>) {
        for node in &mut self.nodes {
            *node = *first;
        }
        self.clear();
    }

    /// Drops all readings, and numbers the nodes from 0.
    fn clear(&mut self) {
        for entry in &mut self.log {
            *entry = Entry::BLANK;
        }
        (self.start, self.length) = (0, 0);
        (self.head, self.dirty, self.computed, self.complete) = (0, 0, 0, 0);
    }

    fn slot(node: u64) -> usize {
        // Below N: the cast loses nothing.
        #[allow(clippy::cast_possible_truncation)]
        let slot = (node % N as u64) as usize;
        slot
    }

    /// The place of the ring that holds a reading of the log.
    fn place(&self, number: usize) -> usize {
        let place = self.start + number;
        if place >= M { place - M } else { place }
    }

    /// A reading of the log.
    fn logged(&self, number: usize) -> Option<&Entry<R>> {
        let entry = self.log.get(self.place(number))?;
        (number < self.length).then_some(entry)
    }

    /// Moves a reading of the log to another place of it.
    fn shift(&mut self, from: usize, to: usize) {
        let (from, to) = (self.place(from), self.place(to));
        let Some(entry) = self.log.get_mut(from) else {
            return;
        };
        let moved = core::mem::replace(entry, Entry::BLANK);
        if let Some(place) = self.log.get_mut(to) {
            *place = moved;
        }
    }

    /// Drops the oldest reading.
    fn drop_oldest(&mut self) {
        if let Some(entry) = self.log.get_mut(self.start) {
            *entry = Entry::BLANK;
        }
        self.start = self.place(1);
        self.length -= 1;
    }

    pub(super) fn newest(&self) -> &Node<R> {
        &self.nodes[Self::slot(self.head)]
    }

    /// The first node that is remembered.
    fn oldest(&self) -> u64 {
        self.head.saturating_sub(N as u64 - 1)
    }

    /// The first node from which states can be computed again.
    fn first(&self) -> u64 {
        self.oldest().max(self.complete)
    }

    /// Adds a step without computing its state.
    pub(super) fn push(&mut self, acceleration_mps2: Vector<R>, attitude: Attitude<R>, dt: R) {
        let last = self.head;
        let belief = self.newest().belief;
        self.head += 1;
        self.dirty = last;
        let node = &mut self.nodes[Self::slot(self.head)];
        node.belief = belief;
        node.acceleration_mps2 = acceleration_mps2;
        node.attitude = attitude;
        node.dt = dt;
        // Readings that are newer than this step move on to the next.
        for number in 0..self.length {
            let place = self.place(number);
            let Some(entry) = self.log.get_mut(place) else {
                continue;
            };
            if entry.new {
                entry.age_s += dt;
            }
            if entry.node == last && entry.offset > dt {
                entry.node = self.head;
                entry.offset -= dt;
            }
        }
        self.forget();
    }

    /// Drops the readings that no state needs: the state of the first node contains those before it.
    fn forget(&mut self) {
        let first = self.first();
        while self.logged(0).is_some_and(|entry| entry.node < first) {
            self.drop_oldest();
        }
        let mut kept = 0;
        for number in 0..self.length {
            if self.logged(number).is_none_or(|entry| entry.useless) {
                continue;
            }
            if kept < number {
                self.shift(number, kept);
            }
            kept += 1;
        }
        for number in kept..self.length {
            let place = self.place(number);
            if let Some(entry) = self.log.get_mut(place) {
                *entry = Entry::BLANK;
            }
        }
        self.length = kept;
    }

    /// Drops the oldest reading of a full log, if a computed state contains it. Returns
    /// whether there is room.
    fn make_room(&mut self) -> bool {
        if self.length < M {
            return true;
        }
        let Some(oldest) = self.logged(0) else {
            return true;
        };
        let from = oldest.node + u64::from(oldest.offset > R::ZERO);
        if oldest.new || from > self.computed {
            return false;
        }
        self.complete = self.complete.max(from);
        self.dirty = self.dirty.max(from);
        self.drop_oldest();
        true
    }

    /// Inserts a reading `back` seconds before the newest node.
    #[inline(never)]
    pub(super) fn insert(&mut self, reading: &Reading<R>, back: R) -> Insertion {
        let place = self.time_at(&mut self.now(), back);
        let within = |place: &(u64, R), first: u64| place.0 >= first;
        if !place.is_some_and(|place| within(&place, self.first())) {
            return Insertion::TooOld;
        }
        if !self.make_room() {
            return Insertion::NoRoom;
        }
        let Some((node, offset)) = place.filter(|place| within(place, self.first())) else {
            return Insertion::TooOld;
        };
        // Readings of the same time are sorted by sensor, in any order of arrival.
        let sensor = reading.sensor();
        let later = |entry: &Entry<R>| {
            (entry.node, entry.offset, entry.reading.sensor()) > (node, offset, sensor)
        };
        // Most readings are newer than those of the log.
        let mut number = self.length;
        while number > 0 && self.logged(number - 1).is_some_and(later) {
            self.shift(number - 1, number);
            number -= 1;
        }
        let place = self.place(number);
        if let Some(entry) = self.log.get_mut(place) {
            *entry = Entry {
                node,
                offset,
                reading: *reading,
                age_s: reading.age_s(),
                new: true,
                useless: false,
            };
        }
        self.length += 1;
        // Readings at the same node are applied together, in order.
        let from = if offset > R::ZERO || node == self.first() {
            node
        } else {
            node - 1
        };
        self.dirty = self.dirty.min(from);
        Insertion::Logged
    }

    /// Computes the states again from the first changed one.
    #[inline(never)]
    pub(super) fn replay(
        &mut self,
        filter: &RelativeFilter<R>,
        accounts: &mut Accounts<R>,
    ) -> Option<DeckSighting<R>> {
        let mut sighting = None;
        let mut next = 0;
        while next < self.length && self.logged(next).is_some_and(|e| e.node < self.dirty) {
            next += 1;
        }
        // Transitions over whole steps, and over their parts.
        let (mut steps, mut parts) = (None, None);
        let mut belief = self.nodes[Self::slot(self.dirty)].belief;
        for number in self.dirty..=self.head {
            let attitude = self.nodes[Self::slot(number)].attitude;
            // The first state is as it is stored, unless new readings have come.
            let mut changed = number > self.dirty;
            while let Some((offset, new)) = self.entry(next, number) {
                if offset > R::ZERO {
                    break;
                }
                // The state of the first node contains its readings, unless they are new.
                if number > self.dirty || new {
                    let seen = self.apply(next, filter, &mut belief, attitude, accounts);
                    sighting = clearer(sighting, seen);
                    changed = true;
                }
                next += 1;
            }
            let here = &mut self.nodes[Self::slot(number)];
            if !belief.is_finite() {
                belief = here.belief;
            } else if changed {
                here.belief = belief;
            }
            if number == self.head {
                break;
            }
            let after = &self.nodes[Self::slot(number + 1)];
            let (acceleration, later, dt) = (after.acceleration_mps2, after.attitude, after.dt);
            let mut done = R::ZERO;
            while let Some((offset, _)) = self.entry(next, number) {
                belief.propagate(filter, &mut parts, acceleration, offset - done);
                done = done.max(offset);
                let attitude = attitude.between(later, done / dt);
                let seen = self.apply(next, filter, &mut belief, attitude, accounts);
                sighting = clearer(sighting, seen);
                next += 1;
            }
            let known = if done > R::ZERO {
                &mut parts
            } else {
                &mut steps
            };
            belief.propagate(filter, known, acceleration, dt - done);
        }
        self.dirty = self.head;
        self.computed = self.head;
        sighting
    }

    /// Time since its node and newness of a reading of the log, if it comes after the node `number`.
    fn entry(&self, place: usize, number: u64) -> Option<(R, bool)> {
        let entry = self.logged(place).filter(|_| place < self.length)?;
        (entry.node == number).then_some((entry.offset, entry.new))
    }

    /// Takes a reading of the log in; the first time it enters the accounts.
    fn apply(
        &mut self,
        number: usize,
        filter: &RelativeFilter<R>,
        belief: &mut Belief<R>,
        attitude: Attitude<R>,
        accounts: &mut Accounts<R>,
    ) -> Option<DeckSighting<R>> {
        let place = self.place(number);
        let entry = self.log.get_mut(place)?;
        let origin = &mut accounts.barometer_origin_m;
        let (fate, seen) = belief.correct(filter, &entry.reading, attitude, origin);
        if !entry.new {
            return None;
        }
        entry.new = false;
        entry.useless = matches!(fate, Fate::Unusable);
        let monitor = accounts.monitors.of(entry.reading.sensor());
        monitor.note(fate, entry.age_s, &filter.gate);
        let age_s = entry.age_s;
        seen.map(|seen| DeckSighting { age_s, ..seen })
    }

    /// [`Belief::rest_deck`] of all states.
    pub(super) fn rest_deck(&mut self, sd: R) {
        for node in &mut self.nodes {
            node.belief.rest_deck(sd);
        }
    }

    /// Starts from a new belief at the newest node; past states and readings
    /// are dropped.
    #[inline(never)]
    pub(super) fn restart(&mut self, belief: &Belief<R>) {
        let newest = self.newest();
        let (acceleration_mps2, attitude) = (newest.acceleration_mps2, newest.attitude);
        self.clear();
        let first = &mut self.nodes[Self::slot(0)];
        first.belief = *belief;
        first.acceleration_mps2 = acceleration_mps2;
        first.attitude = attitude;
        first.dt = R::ZERO;
    }
}
