#pragma once
#include <cstdint>

struct offboard_control_mode_s {
	uint64_t timestamp;
	bool attitude;
};
