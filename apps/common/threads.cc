#include "threads.h"

#include "vdbcloud/core/control_groups.h"

#include <sched.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace vdbcloud::app {

namespace {

int by_affinity()
{
    // More processors than fit a cpu_set_t are possible: EINVAL asks for a larger set.
    for (int most = CPU_SETSIZE; most <= 1 << 16; most *= 2) {
        cpu_set_t* set = CPU_ALLOC(most);
        if (!set) break;
        const size_t bytes = CPU_ALLOC_SIZE(most);
        const int count = ::sched_getaffinity(0, bytes, set) == 0 ? CPU_COUNT_S(bytes, set) : 0;
        CPU_FREE(set);
        if (count > 0) return count;
    }
    return std::max(1, int(::sysconf(_SC_NPROCESSORS_ONLN)));
}

/// Processors that quota and period of one control group come to, or `otherwise`.
int by_quota(const std::string& folder, int otherwise)
{
    double quota = 0, period = 0;
    if (std::ifstream two(folder + "/cpu.max"); two >> quota >> period && quota > 0 && period > 0)
        return std::max(1, int(std::ceil(quota / period)));
    std::ifstream q(folder + "/cpu.cfs_quota_us"), p(folder + "/cpu.cfs_period_us");
    if (q >> quota && p >> period && quota > 0 && period > 0) return std::max(1, int(std::ceil(quota / period)));
    return otherwise;
}

}  // namespace

int allowed_threads()
{
    int count = by_affinity();
    for (const std::string& folder : control_groups("cpu")) count = std::min(count, by_quota(folder, count));
    if (const char* slurm = std::getenv("SLURM_CPUS_PER_TASK")) {
        const long given = std::strtol(slurm, nullptr, 10);
        if (given > 0) count = int(std::min<long>(count, given));
    }
    return std::max(1, count);
}

int startable_threads(int wanted)
{
    rlimit memory = {};
    if (wanted < 2 || (::getrlimit(RLIMIT_AS, &memory) == 0 && memory.rlim_cur == RLIM_INFINITY)) return wanted;
    // Each thread waits, so that all of them exist at once, as those of the work will.
    std::mutex wait;
    std::vector<std::thread> started;
    {
        const std::lock_guard<std::mutex> held(wait);
        try {
            while (int(started.size()) + 1 < wanted)
                started.emplace_back([&wait] { const std::lock_guard<std::mutex> turn(wait); });
        } catch (const std::exception&) {  // no room for another thread
        }
    }
    for (std::thread& thread : started) thread.join();
    return int(started.size()) + 1;
}

}  // namespace vdbcloud::app
