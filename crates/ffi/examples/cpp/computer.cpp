// Lands the simulator's quadrotor on a deck that heaves, flown by the landing computer.
#include <cstdint>
#include <cstdio>
#include <memory>
#include <stdexcept>
#include <string>

#include "touchdown.h"

namespace {

// Throws where a call has failed. Exceptions are for this program: they must not leave a function that C or Rust calls.
void check(const char *what, td_error error, const td_setting *setting = nullptr)
{
    if (error != TD_ERROR_NONE) {
        std::string text = std::string(what) + ": " + td_error_text(error);
        if (setting != nullptr && setting->name[0] != '\0') {
            text += std::string(": ") + setting->name + ": expected " + setting->expected + ", found "
                + std::to_string(setting->found);
        }
        throw std::runtime_error(text);
    }
}

// A landing computer with its memory. The handle points into the object, so it is not copied.
class LandingComputer {
public:
    LandingComputer(const td_computer_settings &settings, float throttle)
    {
        td_setting setting;
        check("td_computer_init",
              td_computer_init(memory_, sizeof memory_, &settings, throttle, &handle_, &setting), &setting);
    }
    LandingComputer(const LandingComputer &) = delete;
    LandingComputer &operator=(const LandingComputer &) = delete;

    td_error step(const td_sensed &sensed, float dt_s, td_computer_output &output)
    {
        return td_computer_step(handle_, &sensed, dt_s, &output);
    }

private:
    alignas(TD_COMPUTER_ALIGN) unsigned char memory_[TD_COMPUTER_SIZE] = {};
    td_computer *handle_ = nullptr;
};

struct Flight {
    Flight(const td_computer_settings &settings, float throttle) : computer(settings, throttle) {}

    LandingComputer computer;
    int steps = 0;
    int without_sensors = 0;
};

// One step: on a vehicle, a timer calls this at 100 Hz with what its drivers have read.
extern "C" std::uint32_t fly(void *user, const td_sensed *sensed, float dt_s, td_computer_output *output)
{
    Flight &flight = *static_cast<Flight *>(user);
    const td_error error = flight.computer.step(*sensed, dt_s, *output);
    flight.steps += 1;
    flight.without_sensors += error == TD_ERROR_SENSOR_NOT_FINITE ? 1 : 0;
    return error;
}

int land(const char *name)
{
    td_world *made = nullptr;
    check("td_world_new", td_world_new(name, &made));
    const std::unique_ptr<td_world, decltype(&td_world_free)> world(made, td_world_free);

    td_computer_settings settings;
    check("td_computer_settings_default", td_computer_settings_default(&settings));
    settings.start_height_m = td_world_start_height_m(world.get());

    // TD_COMPUTER_SIZE bytes: on the heap here, in a static variable on a chip.
    const std::unique_ptr<Flight> flight(new Flight(settings, td_world_start_throttle(world.get())));
    td_landing landing;
    const std::uint64_t trial = 0, seed = 1;
    check("td_world_land", td_world_land(world.get(), trial, seed, fly, flight.get(), &landing));

    const bool landed = landing.outcome == TD_OUTCOME_LANDED;
    std::printf("%s: T_L = %.17g s, V_L = %.17g m/s\n", landed ? "landed" : "not landed",
                landing.landing_time_s, landing.touch_speed_mps);
    std::printf("%d steps, %d of them with values that are not finite\n", flight->steps, flight->without_sensors);
    return landed ? 0 : 1;
}

} // namespace

int main(int count, char **arguments)
{
    try {
        return land(count > 1 ? arguments[1] : "paper");
    } catch (const std::exception &error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
