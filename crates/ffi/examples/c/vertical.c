/* Lands the vertical vehicle of the simulator on a deck that heaves, flown by the vertical controller. */
#include <stdio.h>
#include <string.h>

#include "touchdown.h"

/* Zero until it is initialised. Its type has the size and alignment that the controller needs on every target. */
static union {
    uint8_t bytes[TD_VERTICAL_SIZE];
    uint64_t alignment;
} memory;

/* Ends the program's part with a text if a call has failed. */
static int failed(const char *what, td_error error, const td_setting *setting)
{
    if (error == TD_ERROR_NONE) {
        return 0;
    }
    fprintf(stderr, "%s: %s", what, td_error_text(error));
    if (setting != NULL && setting->name[0] != '\0') {
        fprintf(stderr, ": %s: expected %s, found %g", setting->name, setting->expected, setting->found);
    }
    fprintf(stderr, "\n");
    return 1;
}

/* One control period: on a vehicle, a timer calls this at 100 Hz. */
static float fly(void *user, const td_measurement *measurement)
{
    td_vertical *controller = (td_vertical *)user;
    td_command command;
    memset(&command, 0, sizeof command);
    /* A value that is not finite is replaced, and the command holds. */
    td_error error = td_vertical_step(controller, measurement, 0.01f, &command);
    if (error != TD_ERROR_NONE && error != TD_ERROR_SENSOR_NOT_FINITE) {
        fprintf(stderr, "td_vertical_step: %s\n", td_error_text(error));
    }
    return command.throttle;
}

int main(void)
{
    td_vertical_settings settings;
    td_setting setting;
    td_vertical *controller = NULL;
    td_error error = td_vertical_settings_default(&settings);
    if (failed("td_vertical_settings_default", error, NULL)) {
        return 1;
    }
    /* The simulated air has the paper's ground effect. Models of another vehicle come from its cards. */
    error = td_models_paper(&settings.models);
    if (failed("td_models_paper", error, NULL)) {
        return 1;
    }
    settings.method = TD_METHOD_DYNAMIC;
    settings.start_height_m = 0.5f;
    settings.descent_rate_per_s = 0.5566f; /* reaches 0.1 m after 5.4 s */
    settings.deck_frequency_hz = 0.5f;

    /* What is measured and sent when the descent begins: a hover. */
    td_measurement start = {0.0f, 0.0f, 0.0f, 0.0f};
    float throttle = 0.0f;
    start.height_m = settings.start_height_m;
    error = td_hover_throttle(&settings.vehicle, &settings.models, &throttle, &setting);
    if (failed("td_hover_throttle", error, &setting)) {
        return 1;
    }
    error = td_vertical_init(&memory, sizeof memory, &settings, &start, throttle, &controller, &setting);
    if (failed("td_vertical_init", error, &setting)) {
        return 1;
    }

    td_vertical_world world = {0.5, 0.05, 0.5, 0, 1}; /* height, amplitude, frequency, trial, seed */
    td_landing landing;
    error = td_world_land_vertical(&world, fly, controller, &landing);
    if (failed("td_world_land_vertical", error, NULL)) {
        return 1;
    }
    printf("%s: T_L = %.17g s, V_L = %.17g m/s\n", landing.outcome == TD_OUTCOME_LANDED ? "landed" : "not landed",
           landing.landing_time_s, landing.touch_speed_mps);
    return landing.outcome == TD_OUTCOME_LANDED ? 0 : 1;
}
