// Declarations that the template module uses of PX4, enough to check its syntax.
#pragma once
#include <cmath>
#include <cstdint>

#define PX4_OK 0
#define PX4_ERROR (-1)
#define PX4_ERR(...) stub_log(__VA_ARGS__)
#define PX4_WARN(...) stub_log(__VA_ARGS__)
#define PRINT_MODULE_USAGE_NAME(name, category) stub_log(name, category)
#define PRINT_MODULE_USAGE_COMMAND(name) stub_log(name)
#define PRINT_MODULE_USAGE_DEFAULT_COMMANDS() stub_log("")
#define MODULE_NAME "stub"
#define __EXPORT

inline int stub_logs = 0;
template<typename... Values> void stub_log(Values...) { ++stub_logs; }

template<typename T> struct StubAtomic {
	void store(T *) {}
};

template<class T> class ModuleBase
{
public:
	virtual ~ModuleBase() = default;
	static int main(int, char **) { return 0; }
	static constexpr int task_id_is_work_queue = -2;

protected:
	bool should_exit() { return false; }
	void exit_and_cleanup() {}
	static inline StubAtomic<T> _object;
	static inline int _task_id = -1;
};
