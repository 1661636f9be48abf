//! The tests in one program: what they share is compiled once. Those that keep time are in `links.rs`.

mod common;
#[path = "common/flights.rs"]
mod flights;
#[path = "../../identify/tests/common/vertical.rs"]
mod vertical;

mod bars;
mod campaign;
mod campaign_bad_input;
mod campaign_parts;
mod campaign_tables;
mod default_models;
mod exit_status;
mod export;
mod flight;
mod flight_faults;
mod flight_hover;
mod flight_thrust;
mod flight_truth;
mod front;
mod hostile;
mod identify;
mod inspect;
mod land_and_rig;
mod one_definition;
mod reproduce;
mod sea;
mod second_plant;
mod settings;
mod space;
mod stand_to_landing;
mod validate;
