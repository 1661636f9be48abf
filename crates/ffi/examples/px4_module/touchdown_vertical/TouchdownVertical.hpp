// A PX4 module that lands with Touchdown's vertical controller. A template: nobody has flown it.
#pragma once

#include <px4_platform_common/module.h>
#include <px4_platform_common/px4_work_queue/ScheduledWorkItem.hpp>
#include <uORB/Publication.hpp>
#include <uORB/Subscription.hpp>
#include <uORB/topics/offboard_control_mode.h>
#include <uORB/topics/vehicle_attitude.h>
#include <uORB/topics/vehicle_attitude_setpoint.h>
#include <uORB/topics/vehicle_local_position.h>
#include <uORB/topics/vehicle_status.h>

#include "touchdown.h"

class TouchdownVertical : public ModuleBase<TouchdownVertical>, public px4::ScheduledWorkItem
{
public:
	TouchdownVertical();
	~TouchdownVertical() override = default;

	static int task_spawn(int argc, char *argv[]);
	static int custom_command(int argc, char *argv[]);
	static int print_usage(const char *reason = nullptr);

	bool init();

private:
	void Run() override;
	bool start(const td_measurement &measurement);
	void publish(float throttle);

	uORB::Subscription _local_position_sub{ORB_ID(vehicle_local_position)};
	uORB::Subscription _attitude_sub{ORB_ID(vehicle_attitude)};
	uORB::Subscription _status_sub{ORB_ID(vehicle_status)};
	uORB::Publication<offboard_control_mode_s> _offboard_pub{ORB_ID(offboard_control_mode)};
	uORB::Publication<vehicle_attitude_setpoint_s> _setpoint_pub{ORB_ID(vehicle_attitude_setpoint)};

	alignas(TD_VERTICAL_ALIGN) unsigned char _memory[TD_VERTICAL_SIZE] {};
	td_vertical *_controller{nullptr};
	// Since the mode was entered, the start has been refused, and the reason printed.
	bool _refused{false};
};
