// Touchdown's vertical controller as a library of ArduPilot. A template: nobody has flown it.
#pragma once

#include "touchdown.h"

class AP_Touchdown {
public:
    // Begins a descent at this height (m) with this throttle. False where the settings are refused.
    bool start(float height_m, float throttle);

    // One period of dt_s seconds; z is up. The throttle in [0, 1]; false keeps the last one.
    bool update(float height_m, float climb_rate_mps, float acceleration_mps2, float dt_s, float &throttle);

    // Why start or update returned false.
    const char *error_text() const { return td_error_text(_error); }

    // The setting that start refused: its field, what is expected there, and the number found.
    const td_setting &refused() const { return _refused; }

private:
    alignas(TD_VERTICAL_ALIGN) unsigned char _memory[TD_VERTICAL_SIZE] {};
    td_vertical *_controller = nullptr;
    td_setting _refused {};
    td_error _error = TD_ERROR_NONE;
};
