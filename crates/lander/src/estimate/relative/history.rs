//! Past states and the readings between them.
//!
//! A node is the state at the end of a step; readings stand between nodes at
//! their own times. A late reading is put in its place, and everything from the
//! node before it on is computed again: the result is that of readings taken in
//! at the moments they were made.
//!
//! Where the log is full, its oldest reading leaves it, and with it the states
//! from which it would have to be computed again: what arrives later and is older
//! than that is too old.

use super::DeckSighting;
use super::RelativeFilter;
use super::belief::Belief;
use super::health::{Fate, Monitors};
use super::reading::Reading;
use touchdown_flight::real::{Real, r};
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
    /// Time since that node, s; zero: at the node.
    offset: R,
    reading: Reading<R>,
    /// Its age when it was taken in, s.
    age_s: R,
    /// Not yet in any state.
    new: bool,
    /// Outside the range in which the sensor is believed: it need not be kept.
    useless: bool,
}

/// What outlives the past states.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Accounts<R: Real> {
    pub(super) monitors: Monitors<R>,
    /// What the barometer shows at the altitude zero.
    pub(super) barometer_origin_m: Option<R>,
}

/// Where a reading was put.
pub(super) enum Place {
    /// Into the log.
    Logged,
    /// Nowhere: it is older than the oldest node.
    TooOld,
    /// Nowhere: the log is full of readings that are in no state yet.
    NoRoom,
}

/// The last N nodes and up to M readings between them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct History<R, const N: usize, const M: usize> {
    nodes: [Node<R>; N],
    /// Number of the newest node, from 0.
    head: u64,
    /// Readings in the order of their times.
    log: [Option<Entry<R>>; M],
    length: usize,
    /// The first node whose successors must be computed again.
    dirty: u64,
    /// The last node whose state is computed.
    computed: u64,
    /// The first node from which all readings are still in the log.
    complete: u64,
}

impl<R: Real, const N: usize, const M: usize> History<R, N, M> {
    pub(super) fn new(first: Node<R>) -> Self {
        const { assert!(N >= 2 && M >= 1, "room for two states and a reading") };
        Self {
            nodes: [first; N],
            head: 0,
            log: [None; M],
            length: 0,
            dirty: 0,
            computed: 0,
            complete: 0,
        }
    }

    fn slot(node: u64) -> usize {
        // Below N: the cast loses nothing.
        #[allow(clippy::cast_possible_truncation)]
        let slot = (node % N as u64) as usize;
        slot
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

    /// Adds a step. Its state is not computed yet.
    pub(super) fn push(&mut self, acceleration_mps2: Vector<R>, attitude: Attitude<R>, dt: R) {
        let last = self.head;
        let belief = self.newest().belief;
        self.head += 1;
        self.dirty = last;
        self.nodes[Self::slot(self.head)] = Node {
            belief,
            acceleration_mps2,
            attitude,
            dt,
        };
        // Readings that are newer than this step go on to the next.
        for entry in self.log.iter_mut().flatten() {
            if entry.new {
                entry.age_s += dt;
            }
            if entry.node == last && entry.offset > dt {
                entry.node = self.head;
                entry.offset -= dt;
            }
        }
        // Readings before the first node are in its state.
        let first = self.first();
        self.retain(|entry| entry.node >= first && !entry.useless);
    }

    /// Keeps the readings of the log for which `keep` holds.
    fn retain(&mut self, keep: impl Fn(&Entry<R>) -> bool) {
        let mut kept = 0;
        for place in 0..self.length {
            if self.log[place].as_ref().is_some_and(&keep) {
                if kept < place {
                    self.log[kept] = self.log[place].take();
                }
                kept += 1;
            }
        }
        self.log[kept..self.length].fill(None);
        self.length = kept;
    }

    /// Makes room by leaving out the oldest reading, if it is in a state that is
    /// computed. Says if there is room.
    fn make_room(&mut self) -> bool {
        if self.length < M {
            return true;
        }
        let Some(oldest) = self.log[0] else {
            return true;
        };
        let from = oldest.node + u64::from(oldest.offset > R::ZERO);
        if oldest.new || from > self.computed {
            return false;
        }
        self.complete = self.complete.max(from);
        self.dirty = self.dirty.max(from);
        self.log.copy_within(1..self.length, 0);
        self.length -= 1;
        self.log[self.length] = None;
        true
    }

    /// Puts a reading in its place, `back` seconds before the newest node.
    pub(super) fn insert(&mut self, reading: Reading<R>, back: R) -> Place {
        let place = self.time_at(back);
        let within = |place: &(u64, R), first: u64| place.0 >= first;
        if !place.is_some_and(|place| within(&place, self.first())) {
            return Place::TooOld;
        }
        if !self.make_room() {
            return Place::NoRoom;
        }
        let Some((node, offset)) = place.filter(|place| within(place, self.first())) else {
            return Place::TooOld;
        };
        // At one moment always in the order of the sensors, however they arrive.
        let sensor = reading.sensor();
        let later = |entry: &Entry<R>| {
            (entry.node, entry.offset, entry.reading.sensor()) > (node, offset, sensor)
        };
        let place = self.log[..self.length]
            .iter()
            .flatten()
            .position(later)
            .unwrap_or(self.length);
        self.log.copy_within(place..self.length, place + 1);
        self.log[place] = Some(Entry {
            node,
            offset,
            reading,
            age_s: reading.age_s(),
            new: true,
            useless: false,
        });
        self.length += 1;
        // A reading at a node goes in together with the others there, in order.
        let from = if offset > R::ZERO || node == self.first() {
            node
        } else {
            node - 1
        };
        self.dirty = self.dirty.min(from);
        Place::Logged
    }

    /// The node at or before the time, and the time since it. A time within a
    /// share of 1e-5 of a step from a node (rounding of ages) is the node's.
    fn time_at(&self, back: R) -> Option<(u64, R)> {
        let mut node = self.head;
        let mut left = back;
        if left <= R::ZERO {
            return Some((node, -left));
        }
        loop {
            let dt = self.nodes[Self::slot(node)].dt;
            let close = dt * r(1e-5);
            if left <= close {
                return Some((node, R::ZERO));
            }
            if node == self.oldest() {
                return None;
            }
            node -= 1;
            if left < dt - close {
                return Some((node, dt - left));
            }
            left = (left - dt).max(R::ZERO);
        }
    }

    /// The attitude `back` seconds before the newest node, or the oldest known.
    pub(super) fn attitude(&self, back: R) -> Attitude<R> {
        let Some((node, offset)) = self.time_at(back.finite_or(R::ZERO).max(R::ZERO)) else {
            return self.nodes[Self::slot(self.oldest())].attitude;
        };
        let here = self.nodes[Self::slot(node)];
        if offset > R::ZERO && node < self.head {
            let after = self.nodes[Self::slot(node + 1)];
            here.attitude.between(after.attitude, offset / after.dt)
        } else {
            here.attitude
        }
    }

    /// What the acceleration adds to velocity and place between two times, `from` and
    /// `to` seconds before the newest node; none where it is not remembered. It is
    /// held beyond the newest node.
    pub(super) fn moved(&self, from: R, to: R) -> Option<[Vector<R>; 2]> {
        let (mut faster, mut farther) = (Vector::ZERO, Vector::ZERO);
        let mut add = |acceleration: Vector<R>, start: R, end: R| {
            let (start, end) = (start.min(from), end.max(to));
            if start > end {
                let middle = (start + end) * r(0.5);
                faster += acceleration * (start - end);
                farther += acceleration * ((start - end) * (middle - to));
            }
        };
        add(self.newest().acceleration_mps2, R::ZERO, to.min(R::ZERO));
        let (mut node, mut end) = (self.head, R::ZERO);
        while end < from {
            if node == self.oldest() {
                return None;
            }
            let here = &self.nodes[Self::slot(node)];
            add(here.acceleration_mps2, end + here.dt, end);
            end += here.dt;
            node -= 1;
        }
        (from >= to).then_some([faster, farther])
    }

    /// Computes the states anew from the first that changed.
    pub(super) fn replay(
        &mut self,
        filter: &RelativeFilter<R>,
        accounts: &mut Accounts<R>,
    ) -> Option<DeckSighting<R>> {
        let mut sighting = None;
        let mut next = self.log[..self.length]
            .iter()
            .flatten()
            .position(|entry| entry.node >= self.dirty)
            .unwrap_or(self.length);
        let mut belief = self.nodes[Self::slot(self.dirty)].belief;
        for number in self.dirty..=self.head {
            let here = self.nodes[Self::slot(number)];
            while let Some(entry) = self.entry(next, number) {
                if entry.offset > R::ZERO {
                    break;
                }
                // What stands at the first node is in its state, unless it is new.
                if number > self.dirty || entry.new {
                    let seen = self.apply(next, filter, &mut belief, here.attitude, accounts);
                    sighting = clearer(sighting, seen);
                }
                next += 1;
            }
            if !belief.is_finite() {
                belief = here.belief;
            }
            self.nodes[Self::slot(number)].belief = belief;
            if number == self.head {
                break;
            }
            let after = self.nodes[Self::slot(number + 1)];
            let mut done = R::ZERO;
            while let Some(entry) = self.entry(next, number) {
                belief.propagate(filter, after.acceleration_mps2, entry.offset - done);
                done = done.max(entry.offset);
                let attitude = here.attitude.between(after.attitude, done / after.dt);
                let seen = self.apply(next, filter, &mut belief, attitude, accounts);
                sighting = clearer(sighting, seen);
                next += 1;
            }
            belief.propagate(filter, after.acceleration_mps2, after.dt - done);
        }
        self.dirty = self.head;
        self.computed = self.head;
        sighting
    }

    /// The reading at a place of the log, if it comes after the node `number`.
    fn entry(&self, place: usize, number: u64) -> Option<Entry<R>> {
        let entry = *self.log.get(place)?;
        entry.filter(|entry| entry.node == number)
    }

    /// Takes a reading of the log in; the first time it enters the accounts.
    fn apply(
        &mut self,
        place: usize,
        filter: &RelativeFilter<R>,
        belief: &mut Belief<R>,
        attitude: Attitude<R>,
        accounts: &mut Accounts<R>,
    ) -> Option<DeckSighting<R>> {
        let entry = self.log[place].as_mut()?;
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

    /// Starts from a new belief at the newest node; past states and readings
    /// are dropped.
    pub(super) fn restart(&mut self, belief: Belief<R>) {
        let node = Node {
            belief,
            dt: R::ZERO,
            ..*self.newest()
        };
        *self = Self::new(node);
    }
}

/// The clearer of two sightings.
pub(super) fn clearer<R: Real>(
    a: Option<DeckSighting<R>>,
    b: Option<DeckSighting<R>>,
) -> Option<DeckSighting<R>> {
    match (a, b) {
        (Some(a), Some(b)) => Some(if b.sd_m <= a.sd_m { b } else { a }),
        _ => a.or(b),
    }
}
