//! Sensors of the force rig and of the vehicle: noise, latency, losses.

pub mod camera;
mod clock;
mod inertial;
mod load_cell;
pub(crate) mod readings;
mod settings;
mod sight;
mod vertical;

pub use camera::tags::TagSettings;
pub use load_cell::LoadCellSettings;
pub use settings::{
    BarometerSettings, CameraMode, GnssSettings, ImuSettings, RangeSettings, Schedule,
    SensorSettings,
};
pub use vertical::FlightSensorSettings;
