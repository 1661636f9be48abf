//! Scenarios by name.

use touchdown_lander::models::FlightModels;

use super::faults::{FaultGust, FaultySensor, NanBurst, TimeSpan, WeakRotor};
use super::scenario::SpaceScenario;
use crate::deck::rigid::{Axis, RigidMotion, SeaSettings, Tone};

/// A landing by its name: what the deck does, or what goes wrong above the paper's deck.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Case {
    /// A deck at rest.
    Still,
    /// The paper's deck: heave of 0.05 m at 0.5 Hz.
    Paper,
    /// The same, with 60 % more ground effect than the models predict.
    Strong,
    /// Heave of 0.3 m at 0.2 Hz with 3° of roll.
    Heave,
    /// A work boat in the default sea.
    Sea,
    /// No tag is found for 1 s.
    TagLost,
    /// A tenth of the range readings is missing.
    RangeMissing,
    /// Readings of range, tag and GNSS are 100 ms older; their time stamps tell.
    Late,
    /// The same, without time stamps.
    LateUnknown,
    /// A rotor at 80 % of its thrust.
    Rotor,
    /// A gust of 8 m/s.
    Gust,
    /// All sensors give NaN for 0.2 s.
    Nan,
}

impl Case {
    /// All of them.
    pub const ALL: [Self; 12] = [
        Self::Still,
        Self::Paper,
        Self::Strong,
        Self::Heave,
        Self::Sea,
        Self::TagLost,
        Self::RangeMissing,
        Self::Late,
        Self::LateUnknown,
        Self::Rotor,
        Self::Gust,
        Self::Nan,
    ];
    /// Decks that move.
    pub const DECKS: [Self; 4] = [Self::Paper, Self::Strong, Self::Heave, Self::Sea];
    /// What goes wrong, above the paper's deck.
    pub const FAULTS: [Self; 7] = [
        Self::TagLost,
        Self::RangeMissing,
        Self::Late,
        Self::LateUnknown,
        Self::Rotor,
        Self::Gust,
        Self::Nan,
    ];

    /// The name in results.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Still => "still",
            Self::Paper => "paper",
            Self::Strong => "strong",
            Self::Heave => "heave",
            Self::Sea => "sea",
            Self::TagLost => "tag_lost",
            Self::RangeMissing => "range_missing",
            Self::Late => "late",
            Self::LateUnknown => "late_unknown",
            Self::Rotor => "rotor",
            Self::Gust => "gust",
            Self::Nan => "nan",
        }
    }

    /// The case in a few words: what the deck does, or what goes wrong.
    #[must_use]
    pub fn description(self) -> &'static str {
        match self {
            Self::Still => "deck at rest",
            Self::Paper => "heave of 0.05 m at 0.5 Hz",
            Self::Strong => {
                "the deck of `paper`, with 60 % more ground effect than the models predict"
            }
            Self::Heave => "heave of 0.3 m at 0.2 Hz with 3° of roll",
            Self::Sea => "a work boat in the default sea",
            Self::TagLost => "tag lost for 1 s",
            Self::RangeMissing => "10 % of range readings missing",
            Self::Late => "100 ms more latency, stamped",
            Self::LateUnknown => "100 ms more latency, unknown",
            Self::Rotor => "a rotor at 80 %",
            Self::Gust => "a gust of 8 m/s",
            Self::Nan => "NaN from all sensors for 0.2 s",
        }
    }

    /// The case of a name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|case| case.name() == name)
    }

    /// The scenario: the default one with this case's deck and fault. Above the paper's deck the
    /// ground effect is the paper's. Faults count from the start of the first descent.
    #[must_use]
    pub fn scenario(self) -> SpaceScenario {
        let tone = |axis, amplitude, frequency_hz, phase_rad| Tone {
            axis,
            amplitude,
            frequency_hz,
            phase_rad,
        };
        let deck = match self {
            Self::Still => RigidMotion::Still {},
            Self::Heave => RigidMotion::Sines {
                tones: vec![
                    tone(Axis::Heave, 0.3, 0.2, 0.0),
                    // Three degrees, out of step with the heave.
                    tone(Axis::Roll, 0.0524, 0.2, 1.0),
                ],
            },
            Self::Sea => RigidMotion::Sea(SeaSettings::default()),
            _ => RigidMotion::Sines {
                tones: vec![tone(Axis::Heave, 0.05, 0.5, 0.0)],
            },
        };
        let mut scenario = SpaceScenario {
            deck,
            ..SpaceScenario::default()
        };
        if !matches!(self, Self::Still | Self::Heave | Self::Sea) {
            scenario.ground_effect_strength = 1.0;
            scenario.models = FlightModels::paper();
        }
        let faults = &mut scenario.faults;
        match self {
            Self::Still | Self::Paper | Self::Heave | Self::Sea => {}
            Self::Strong => scenario.ground_effect_strength = 1.6,
            Self::TagLost => {
                faults.tag_lost = vec![TimeSpan {
                    from_s: 0.5,
                    to_s: 1.5,
                }];
            }
            Self::RangeMissing => faults.range_missing_share = 0.1,
            Self::Late => faults.extra_latency_s = 0.1,
            Self::LateUnknown => {
                faults.extra_latency_s = 0.1;
                faults.extra_latency_known = false;
            }
            Self::Rotor => {
                faults.rotor = Some(WeakRotor {
                    rotor: 0,
                    share: 0.8,
                    from_s: 0.5,
                });
            }
            Self::Gust => {
                faults.gust = Some(FaultGust {
                    velocity_mps: [8.0, 0.0, 0.0],
                    from_s: 0.3,
                    rise_s: 0.5,
                    hold_s: 1.0,
                });
            }
            Self::Nan => {
                faults.nan = vec![NanBurst {
                    sensor: FaultySensor::All,
                    from_s: 0.5,
                    to_s: 0.7,
                }];
            }
        }
        scenario
    }
}
