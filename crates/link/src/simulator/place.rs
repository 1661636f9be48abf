//! Where on Earth the simulated deck is, and what that means for GNSS, barometer and magnetometer.

use touchdown_flight::Vector;

/// Latitude of the deck's mean place, degrees: Zurich, the place that the autopilots' own simulators use.
pub const LATITUDE_DEG: f64 = 47.397_742;
/// Longitude of the deck's mean place, degrees.
pub const LONGITUDE_DEG: f64 = 8.545_594;
/// Height of the deck's mean place above mean sea level, m.
pub const ALTITUDE_M: f64 = 488.0;
/// Magnetic field there, east-north-up, gauss: an inclination of 63° and a declination of 2°, by which autopilots check
/// their magnetometers. Within 2 % of the World Magnetic Model.
pub const MAGNETIC_FIELD_GAUSS: [f64; 3] = [0.007_71, 0.215_23, -0.427_41];

/// Mean radius of the Earth, m. Over the 20 m of a landing an ellipsoid differs by less than 7 cm.
const EARTH_M: f64 = 6_371_000.0;

/// Latitude and longitude (1e-7 degrees), height above mean sea level (mm) of a place (east-north-up, m).
#[must_use]
pub fn geodetic(position_m: Vector<f64>) -> (i32, i32, i32) {
    let north = (position_m.y / EARTH_M).to_degrees();
    let east = (position_m.x / (EARTH_M * LATITUDE_DEG.to_radians().cos())).to_degrees();
    let scaled = |degrees: f64| (degrees * 1e7).round() as i32;
    (
        scaled(LATITUDE_DEG + north),
        scaled(LONGITUDE_DEG + east),
        ((ALTITUDE_M + position_m.z) * 1e3).round() as i32,
    )
}

/// Air pressure at a height above the deck's mean place, hPa: `p = 1013.25 (1 - 0.0065 h / 288.15)^5.25588`, the
/// International Standard Atmosphere below 11 km, h above mean sea level in m.
#[must_use]
pub fn pressure_hpa(height_m: f64) -> f64 {
    1013.25 * (1.0 - 0.0065 * (ALTITUDE_M + height_m) / 288.15).powf(5.255_88)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn analytic_a_metre_north_is_90_nanodegrees_times_a_hundred() {
        let (lat, lon, alt) = geodetic(Vector::ZERO);
        let (north, same, higher) = geodetic(Vector::new(0.0, 1.0, 0.5));
        // 1 m is 1e7 · 180/π / 6 371 000 = 89.93 units.
        assert_eq!((north - lat, same - lon, higher - alt), (90, 0, 500));
        // At 47.4° a metre east is 1/cos larger: 132.9 units.
        assert_eq!(geodetic(Vector::new(1.0, 0.0, 0.0)).1 - lon, 133);
    }

    #[test]
    fn analytic_pressure_is_that_of_the_standard_atmosphere() {
        // Tables of the ISA: 1013.25 hPa at sea level, 954.61 hPa at 500 m, each with two decimals.
        assert!((pressure_hpa(-ALTITUDE_M) - 1013.25).abs() < 0.005);
        assert!((pressure_hpa(500.0 - ALTITUDE_M) - 954.61).abs() < 0.02);
    }
}
