#pragma once
#include <cstdint>

struct vehicle_status_s {
	static constexpr uint8_t NAVIGATION_STATE_OFFBOARD = 14;
	uint8_t nav_state;
};
