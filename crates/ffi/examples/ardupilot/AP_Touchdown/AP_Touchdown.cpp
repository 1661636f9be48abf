#include "AP_Touchdown.h"

bool AP_Touchdown::start(float height_m, float throttle)
{
    td_vertical_settings settings;
    _controller = nullptr;
    _error = td_vertical_settings_default(&settings);
    // Your vehicle, and the coefficients of its cards in settings.models.
    settings.vehicle.mass_kg = 1.37f;
    settings.start_height_m = height_m;
    td_measurement start {};
    start.height_m = height_m;
    if (_error == TD_ERROR_NONE) {
        _error = td_vertical_init(_memory, sizeof(_memory), &settings, &start, throttle, &_controller, &_refused);
    }
    return _error == TD_ERROR_NONE;
}

bool AP_Touchdown::update(float height_m, float climb_rate_mps, float acceleration_mps2, float dt_s, float &throttle)
{
    td_measurement measurement {};
    measurement.height_m = height_m;
    // Over a deck that moves, the relative velocity is that of the height, not of the vehicle.
    measurement.relative_velocity_mps = climb_rate_mps;
    measurement.vehicle_velocity_mps = climb_rate_mps;
    measurement.acceleration_mps2 = acceleration_mps2;
    td_command command {};
    // Before start() the handle is null, which is an error and not a crash.
    _error = td_vertical_step(_controller, &measurement, dt_s, &command);
    if (_error != TD_ERROR_NONE && _error != TD_ERROR_SENSOR_NOT_FINITE) {
        return false;
    }
    throttle = command.throttle;
    return true;
}
