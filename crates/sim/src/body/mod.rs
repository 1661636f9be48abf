//! The vehicle: motors, rotors, rigid body, legs, attitude control; and the vertical vehicle.

pub mod cascade;
pub mod contact;
pub mod motor;
pub mod plant;
pub mod rigid;
pub mod rotors;
mod settings;
pub mod vertical;

pub use settings::BodySettings;
