//! How many rotors the thrust of logs is of.

use touchdown_trial::Trial;

use crate::settings::VehicleSettings;

/// Channels that only a whole vehicle has, in flight or on a force rig.
const OF_A_VEHICLE: [&str; 6] = [
    "height_m",
    "deck_height_m",
    "deck_velocity_mps",
    "vehicle_velocity_mps",
    "specific_force_mps2",
    "acceleration_mps2",
];

/// Rotors whose thrust was measured together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MeasuredRotors {
    /// As stated, or as many as the logs have throttles or speeds of.
    Counted(u32),
    /// All rotors of a vehicle, whose number may not be known.
    OfVehicle,
    /// Nothing says how many: a stand, whose usual number is one.
    OneAssumed,
}

impl MeasuredRotors {
    /// What settings and channels say.
    pub(super) fn of(trials: &[Trial], vehicle: &VehicleSettings) -> Self {
        if let Some(count) = vehicle.measured_rotors {
            return Self::Counted(count);
        }
        let counted = ["throttle", "rotor_rpm"].map(|stem| {
            let counts = trials.iter().map(|trial| numbered(trial, stem));
            counts.min().unwrap_or(0)
        });
        match counted.into_iter().max() {
            Some(count) if count > 1 => Self::Counted(count),
            _ if trials.iter().all(of_a_vehicle) => Self::OfVehicle,
            _ => Self::OneAssumed,
        }
    }

    /// The number in a card; none for all rotors of a vehicle of unknown number.
    pub(super) fn in_card(self, vehicle: &VehicleSettings) -> Option<u32> {
        match self {
            Self::Counted(count) => Some(count),
            Self::OfVehicle => vehicle.rotors,
            Self::OneAssumed => Some(1),
        }
    }
}

/// How many channels `stem_1`, `stem_2`, … there are.
fn numbered(trial: &Trial, stem: &str) -> u32 {
    let has = |k: &u32| trial.channel(&format!("{stem}_{k}")).is_some();
    (1..).take_while(has).count() as u32
}

fn of_a_vehicle(trial: &Trial) -> bool {
    OF_A_VEHICLE
        .iter()
        .any(|name| trial.channel(name).is_some())
}

#[cfg(test)]
mod tests {
    use std::slice::from_ref;

    use super::*;

    fn log(channels: &[&str]) -> Trial {
        let empty = Trial::new("log", vec![0.0, 1.0]).unwrap();
        channels.iter().fold(empty, |trial, name| {
            trial.with_channel(*name, vec![0.5, 0.6]).unwrap()
        })
    }

    #[test]
    fn analytic_rotors_are_stated_counted_or_assumed() {
        let unknown = VehicleSettings::default();
        let of = |logs: &[Trial], vehicle| MeasuredRotors::of(logs, vehicle);
        let stand = log(&["thrust_n", "throttle", "rotor_rpm"]);
        assert_eq!(of(from_ref(&stand), &unknown), MeasuredRotors::OneAssumed);
        let stated = VehicleSettings {
            measured_rotors: Some(2),
            rotors: Some(4),
            ..unknown
        };
        assert_eq!(of(from_ref(&stand), &stated), MeasuredRotors::Counted(2));
        let scale = log(&["thrust_n", "throttle", "rotor_rpm_1", "rotor_rpm_2"]);
        assert_eq!(of(from_ref(&scale), &unknown), MeasuredRotors::Counted(2));
        // One log of a single rotor among them decides.
        assert_eq!(of(&[scale, stand], &unknown), MeasuredRotors::OneAssumed);
        let rig = MeasuredRotors::of(&[log(&["thrust_n", "throttle", "height_m"])], &unknown);
        assert_eq!(rig, MeasuredRotors::OfVehicle);
        assert_eq!(rig.in_card(&unknown), None);
        assert_eq!(rig.in_card(&stated), Some(4));
    }
}
