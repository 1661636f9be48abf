//! Corrections of the state's distribution by readings.

use super::belief::{Belief, H, P, VD, VQ, VX, ZQ};
use super::health::Fate;
use super::reading::{
    BarometerReading, BeaconReading, GnssVelocity, RangeReading, Reading, TagReading,
};
use super::{DeckSighting, RelativeFilter};
use touchdown_flight::real::{Real, r};
use touchdown_flight::space::{Attitude, Vector};

/// Least vertical component of the deck's normal: a deck tilted by more than 60° is a
/// false normal, and no ship's deck comes near this limit.
const LEAST_NORMAL_Z: f64 = 0.5;

impl<R: Real> Belief<R> {
    /// Corrects by a reading of the present time. Returns the result and the deck's
    /// height that follows from the reading.
    pub(super) fn correct(
        &mut self,
        filter: &RelativeFilter<R>,
        reading: &Reading<R>,
        attitude: Attitude<R>,
        barometer_origin_m: &mut Option<R>,
    ) -> (Fate<R>, Option<DeckSighting<R>>) {
        match reading {
            Reading::Range(range) => self.correct_range(filter, range, attitude),
            Reading::Tag(tag) => self.correct_tag(filter, tag, attitude),
            Reading::Gnss(gnss) => (self.correct_gnss(filter, gnss), None),
            Reading::Barometer(barometer) => {
                let fate = self.correct_barometer(filter, barometer, barometer_origin_m);
                (fate, None)
            }
            Reading::Beacon(beacon) => (self.correct_beacon(filter, beacon), None),
        }
    }

    /// The beam from s in the direction d meets the plane through the deck's
    /// reference point: `n · (p + s) = ρ (-n · d)`.
    fn correct_range(
        &mut self,
        filter: &RelativeFilter<R>,
        reading: &RangeReading<R>,
        attitude: Attitude<R>,
    ) -> (Fate<R>, Option<DeckSighting<R>>) {
        let model = &filter.range;
        let distance = reading.distance_m;
        let directions = (reading.deck_normal.direction(), model.direction.direction());
        let (Some(n), Some(beam)) = directions else {
            return (Fate::Unusable, None);
        };
        let cosine = -n.dot(attitude.rotate(beam));
        let distance_fits = model.reaches(distance);
        let angle_fits = cosine >= model.greatest_angle_rad.cos() && n.z > r(LEAST_NORMAL_Z);
        if !(distance_fits && angle_fits) {
            return (Fate::Unusable, None);
        }
        let [x, y] = &self.horizontal;
        let sideways = n.x * x.mean[P] + n.y * y.mean[P];
        let value = distance * cosine - n.dot(attitude.rotate(model.position_m)) - sideways;
        let square = |a: R| a * a;
        let noise = square(model.noise_sd_m + model.noise_share * distance)
            + square(model.quantum_m) * r(1.0 / 12.0);
        let sine2 = (R::ONE - cosine * cosine).max(R::ZERO);
        let rate = self.velocity().z - self.deck_velocity().z;
        // Where the beam meets the deck, from the reference point.
        let spot =
            self.position() + attitude.rotate(model.position_m) + attitude.rotate(beam) * distance;
        let variance = cosine * cosine * noise
            + sine2 * square(distance * filter.imu.attitude_sd_rad)
            + square(n.z * rate * model.jitter_s)
            + square(n.x * x.sd(P))
            + square(n.y * y.sd(P))
            + square(model.normal_sd_rad * spot.horizontal().norm());
        let innovation = self.vertical.innovation(H, n.z, value, variance);
        let sighting = DeckSighting {
            displacement_m: self.climbed - value / n.z,
            sd_m: variance.sqrt() / n.z,
            age_s: reading.age_s,
        };
        let nis = innovation.nis();
        if !within_gate(filter, nis) {
            return (Fate::Rejected, None);
        }
        self.vertical.correct(&innovation);
        (Fate::Used(nis), Some(sighting))
    }

    /// The reference point at c in camera axes: `p = -R (m + A c)`.
    fn correct_tag(
        &mut self,
        filter: &RelativeFilter<R>,
        reading: &TagReading<R>,
        attitude: Attitude<R>,
    ) -> (Fate<R>, Option<DeckSighting<R>>) {
        let model = &filter.tag;
        let camera = attitude * model.attitude;
        let to_deck = attitude.rotate(model.position_m) + camera.rotate(reading.position_m);
        let position = (-to_deck).to_array();
        let speed = (self.velocity() - self.deck_velocity()).to_array();
        let distance2 = to_deck.dot(to_deck);
        let axes = [
            Vector::new(R::ONE, R::ZERO, R::ZERO),
            Vector::new(R::ZERO, R::ONE, R::ZERO),
            Vector::UP,
        ];
        let mut variance = [R::ZERO; 3];
        let values = axes.into_iter().zip(speed).zip(position);
        for (variance, ((axis, speed), position)) in variance.iter_mut().zip(values) {
            let along = camera.unrotate(axis);
            let own = reading
                .covariance_m2
                .map(|row| Vector::from_array(row).dot(along));
            let own = Vector::from_array(own).dot(along);
            if !(own >= R::ZERO) {
                return (Fate::Unusable, None);
            }
            let square = |a: R| a * a;
            let levelling = square(filter.imu.attitude_sd_rad);
            *variance = own
                + square(model.noise_sd_m)
                + square(speed * model.jitter_s)
                + levelling * (distance2 - position * position).max(R::ZERO);
        }
        let [x, y] = &mut self.horizontal;
        let of_x = x.innovation(P, R::ONE, position[0], variance[0]);
        let of_y = y.innovation(P, R::ONE, position[1], variance[1]);
        let of_z = self
            .vertical
            .innovation(H, R::ONE, position[2], variance[2]);
        let nis = [of_x.nis(), of_y.nis(), of_z.nis()];
        if !nis.iter().all(|&nis| within_gate(filter, nis)) {
            return (Fate::Rejected, None);
        }
        let sighting = DeckSighting {
            displacement_m: self.climbed - position[2],
            sd_m: variance[2].sqrt(),
            age_s: reading.age_s,
        };
        x.correct(&of_x);
        y.correct(&of_y);
        self.vertical.correct(&of_z);
        (Fate::Used(mean(nis)), Some(sighting))
    }

    fn correct_gnss(&mut self, filter: &RelativeFilter<R>, reading: &GnssVelocity<R>) -> Fate<R> {
        let model = &filter.gnss;
        let horizontal = model.horizontal_sd_mps * model.horizontal_sd_mps;
        let vertical = model.vertical_sd_mps * model.vertical_sd_mps;
        let [x, y] = &mut self.horizontal;
        let of_x = x.innovation(VX, R::ONE, reading.velocity_mps.x, horizontal);
        let of_y = y.innovation(VX, R::ONE, reading.velocity_mps.y, horizontal);
        let of_z = self
            .vertical
            .innovation(VQ, R::ONE, reading.velocity_mps.z, vertical);
        let nis = [of_x.nis(), of_y.nis(), of_z.nis()];
        if !nis.iter().all(|&nis| within_gate(filter, nis)) {
            return Fate::Rejected;
        }
        x.correct(&of_x);
        y.correct(&of_y);
        self.vertical.correct(&of_z);
        Fate::Used(mean(nis))
    }

    /// The deck's broadcast velocity, and its place where nothing knows it better.
    ///
    /// Errors of a place by satellites change within minutes, so many readings do not know it better
    /// than one: its standard deviation stays at that of a reading.
    fn correct_beacon(
        &mut self,
        filter: &RelativeFilter<R>,
        reading: &BeaconReading<R>,
    ) -> Fate<R> {
        let sd_mps = filter.beacon.velocity_sd_mps;
        let [x, y] = &mut self.horizontal;
        let of_x = x.innovation(VD, R::ONE, reading.deck_velocity_mps.x, sd_mps * sd_mps);
        let of_y = y.innovation(VD, R::ONE, reading.deck_velocity_mps.y, sd_mps * sd_mps);
        let nis = [of_x.nis(), of_y.nis(), of_x.nis().max(of_y.nis())];
        if !within_gate(filter, nis[2]) {
            return Fate::Rejected;
        }
        x.correct(&of_x);
        y.correct(&of_y);
        let place = reading.position_m.to_array();
        let aside_m2 = filter.beacon.horizontal_sd_m * filter.beacon.horizontal_sd_m;
        for (axis, place) in [x, y].into_iter().zip(place) {
            axis.learn_at_most(P, place, aside_m2);
        }
        let up_m2 = filter.beacon.vertical_sd_m * filter.beacon.vertical_sd_m;
        self.vertical.learn_at_most(H, place[2], up_m2);
        Fate::Used(mean(nis))
    }

    fn correct_barometer(
        &mut self,
        filter: &RelativeFilter<R>,
        reading: &BarometerReading<R>,
        origin_m: &mut Option<R>,
    ) -> Fate<R> {
        let model = &filter.barometer;
        // A height that is not certain may be too low for a first reading. After that it is uncertain for the deck's motion, and the
        // vehicle's own is known by the barometer alone.
        let doubt = match origin_m {
            Some(_) => R::ZERO,
            None => self.vertical.sd(H),
        };
        if !(self.vertical.mean[H] - doubt >= model.trusted_above_m) {
            return Fate::Unusable;
        }
        let variance = model.noise_sd_m * model.noise_sd_m;
        // The first usable reading defines the barometer's zero.
        let altitude = reading.altitude_m;
        let value = altitude - *origin_m.get_or_insert(altitude - self.vertical.mean[ZQ]);
        let innovation = self.vertical.innovation(ZQ, R::ONE, value, variance);
        let nis = innovation.nis();
        if !within_gate(filter, nis) {
            return Fate::Rejected;
        }
        self.vertical.correct(&innovation);
        Fate::Used(nis)
    }
}

fn within_gate<R: Real>(filter: &RelativeFilter<R>, nis: R) -> bool {
    nis <= filter.gate.gate_sd * filter.gate.gate_sd
}

fn mean<R: Real>(nis: [R; 3]) -> R {
    (nis[0] + nis[1] + nis[2]) * r(1.0 / 3.0)
}
