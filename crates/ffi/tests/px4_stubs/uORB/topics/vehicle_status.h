#pragma once
#include <cstdint>

inline uint8_t stub_nav_state = 0;

struct vehicle_status_s {
	static constexpr uint8_t NAVIGATION_STATE_OFFBOARD = 14;
	uint8_t nav_state = stub_nav_state;
};
