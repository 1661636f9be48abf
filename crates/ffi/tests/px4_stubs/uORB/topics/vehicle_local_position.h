#pragma once

struct vehicle_local_position_s {
	bool v_z_valid;
	float vz;
	float az;
	bool dist_bottom_valid;
	float dist_bottom;
};
