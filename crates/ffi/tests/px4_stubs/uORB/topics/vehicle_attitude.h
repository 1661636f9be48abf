#pragma once

struct vehicle_attitude_s {
	float q[4];
};
