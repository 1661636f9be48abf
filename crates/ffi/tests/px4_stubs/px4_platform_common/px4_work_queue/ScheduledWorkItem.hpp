#pragma once
#include <cstdint>

namespace px4
{
struct wq_config_t {};

namespace wq_configurations
{
static constexpr wq_config_t nav_and_controllers {};
}

class ScheduledWorkItem
{
public:
	ScheduledWorkItem(const char *, const wq_config_t &) {}
	virtual ~ScheduledWorkItem() = default;
	void ScheduleOnInterval(uint32_t) {}
	void ScheduleClear() {}

private:
	virtual void Run() = 0;
};
}
