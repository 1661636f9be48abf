#pragma once
#include <cstdint>

struct vehicle_attitude_setpoint_s {
	uint64_t timestamp;
	float q_d[4];
	float thrust_body[3];
};
