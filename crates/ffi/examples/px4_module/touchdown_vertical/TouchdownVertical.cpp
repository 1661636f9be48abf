#include "TouchdownVertical.hpp"

#include <drivers/drv_hrt.h>

static constexpr uint32_t PERIOD_US = 10000;

TouchdownVertical::TouchdownVertical() :
	ScheduledWorkItem(MODULE_NAME, px4::wq_configurations::nav_and_controllers)
{
}

bool TouchdownVertical::init()
{
	ScheduleOnInterval(PERIOD_US);
	return true;
}

bool TouchdownVertical::start(const td_measurement &measurement)
{
	td_vertical_settings settings;
	td_setting setting{};
	td_vertical_settings_default(&settings);
	// Your vehicle, and the coefficients of its cards in settings.models.
	settings.vehicle.mass_kg = 1.37f;
	settings.start_height_m = measurement.height_m;
	float throttle = 0.f;
	td_error error = td_hover_throttle(&settings.vehicle, &settings.models, &throttle, &setting);

	if (error == TD_ERROR_NONE) {
		error = td_vertical_init(_memory, sizeof(_memory), &settings, &measurement, throttle, &_controller, &setting);
	}

	if (error != TD_ERROR_NONE) {
		// Run() tries again in each period, for example until a distance arrives. It prints once for each entry.
		if (!_refused) {
			PX4_ERR("%s: %s: expected %s, found %g", td_error_text(error), setting.name, setting.expected, setting.found);
		}

		_refused = true;
		_controller = nullptr;
	}

	return _controller != nullptr;
}

void TouchdownVertical::publish(float throttle)
{
	vehicle_attitude_s attitude{};
	_attitude_sub.copy(&attitude);
	// Level, with the present heading. This holds no position: put your horizontal controller's attitude here.
	const float heading = atan2f(2.f * (attitude.q[0] * attitude.q[3] + attitude.q[1] * attitude.q[2]),
				     1.f - 2.f * (attitude.q[2] * attitude.q[2] + attitude.q[3] * attitude.q[3]));
	vehicle_attitude_setpoint_s setpoint{};
	setpoint.timestamp = hrt_absolute_time();
	setpoint.q_d[0] = cosf(0.5f * heading);
	setpoint.q_d[3] = sinf(0.5f * heading);
	// The throttle of the thrust card, where THR_MDL_FAC is 0.
	setpoint.thrust_body[2] = -throttle;
	_setpoint_pub.publish(setpoint);
}

void TouchdownVertical::Run()
{
	if (should_exit()) {
		ScheduleClear();
		exit_and_cleanup();
		return;
	}

	// Offboard mode needs these setpoints before the operator may switch to it.
	offboard_control_mode_s offboard{};
	offboard.timestamp = hrt_absolute_time();
	offboard.attitude = true;
	_offboard_pub.publish(offboard);

	vehicle_status_s status{};
	_status_sub.copy(&status);

	if (status.nav_state != vehicle_status_s::NAVIGATION_STATE_OFFBOARD) {
		_controller = nullptr;
		_refused = false;
		return;
	}

	vehicle_local_position_s position{};
	_local_position_sub.copy(&position);
	// PX4's z is down. Over a deck that moves, the relative velocity is that of the height, not of the vehicle.
	td_measurement measurement{};
	measurement.height_m = position.dist_bottom_valid ? position.dist_bottom : NAN;
	measurement.relative_velocity_mps = position.v_z_valid ? -position.vz : NAN;
	measurement.vehicle_velocity_mps = measurement.relative_velocity_mps;
	measurement.acceleration_mps2 = -position.az;

	if (_controller == nullptr && !start(measurement)) {
		return;
	}

	// A value that is not finite is replaced by the last one; the command is finite always.
	td_command command{};
	const td_error error = td_vertical_step(_controller, &measurement, 1e-6f * PERIOD_US, &command);

	if (error == TD_ERROR_NONE || error == TD_ERROR_SENSOR_NOT_FINITE) {
		publish(command.throttle);
	}
}

int TouchdownVertical::task_spawn(int argc, char *argv[])
{
	TouchdownVertical *instance = new TouchdownVertical();

	if (instance != nullptr) {
		_object.store(instance);
		_task_id = task_id_is_work_queue;

		if (instance->init()) {
			return PX4_OK;
		}
	}

	delete instance;
	_object.store(nullptr);
	_task_id = -1;
	return PX4_ERROR;
}

int TouchdownVertical::custom_command(int argc, char *argv[])
{
	return print_usage("unknown command");
}

int TouchdownVertical::print_usage(const char *reason)
{
	if (reason != nullptr) {
		PX4_WARN("%s\n", reason);
	}

	PRINT_MODULE_USAGE_NAME("touchdown_vertical", "controller");
	PRINT_MODULE_USAGE_COMMAND("start");
	PRINT_MODULE_USAGE_DEFAULT_COMMANDS();
	return 0;
}

extern "C" __EXPORT int touchdown_vertical_main(int argc, char *argv[])
{
	return TouchdownVertical::main(argc, argv);
}
