#include "vdbcloud/core/memory.h"

#include "vdbcloud/core/control_groups.h"

#include <stdlib.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <sstream>

namespace vdbcloud {

namespace {

/// Field n of /proc/self/statm [bytes]: 0 the address space, 1 resident.
double statm(int n)
{
    std::ifstream file("/proc/self/statm");
    double pages = 0;
    for (int k = 0; k <= n; ++k)
        if (!(file >> pages)) return 0;
    return pages * double(::sysconf(_SC_PAGESIZE));
}

/// The value of a line "Name:   123 kB" of a file of /proc [bytes]; none if there is no such line.
std::optional<double> kilobytes(const char* path, const std::string& name)
{
    std::ifstream file(path);
    for (std::string line; std::getline(file, line);) {
        std::istringstream words(line);
        std::string first;
        double value = 0;
        if (words >> first >> value && first == name + ":") return 1024 * value;
    }
    return std::nullopt;
}

std::optional<double> number_in(const std::string& path)
{
    std::ifstream file(path);
    double value = 0;
    if (file >> value) return value;
    return std::nullopt;
}

/// What one control group leaves: pages of files that it caches are given back on demand.
std::optional<double> left_in_group(const std::string& folder)
{
    auto most = number_in(folder + "/memory.max"), now = number_in(folder + "/memory.current");
    if (!now) most = number_in(folder + "/memory.limit_in_bytes"), now = number_in(folder + "/memory.usage_in_bytes");
    if (!most || !now || *most > 0x1p60) return std::nullopt;
    double cached = 0;
    std::ifstream statistics(folder + "/memory.stat");
    std::string name;
    for (double value = 0; statistics >> name >> value;)
        if (name == "inactive_file" || name == "total_inactive_file") cached = value;
    return std::max(0.0, *most - *now + cached);
}

}  // namespace

double memory_held() { return statm(1); }

double most_memory_held()
{
    rusage usage = {};
    return ::getrusage(RUSAGE_SELF, &usage) == 0 ? 1024.0 * double(usage.ru_maxrss) : 0;
}

std::optional<MemoryLeft> memory_left()
{
    std::optional<MemoryLeft> left;
    const auto limit = [&](double bytes, const char* by) {
        if (!left || bytes < left->bytes) left = MemoryLeft{bytes, by};
    };
    if (const auto available = kilobytes("/proc/meminfo", "MemAvailable"))
        limit(*available + kilobytes("/proc/meminfo", "SwapFree").value_or(0), "the machine");
    rlimit space = {};
    for (const auto resource : {RLIMIT_AS, RLIMIT_DATA})
        if (::getrlimit(resource, &space) == 0 && space.rlim_cur != RLIM_INFINITY) {
            const double used = resource == RLIMIT_AS ? statm(0) : kilobytes("/proc/self/status", "VmData").value_or(0);
            limit(std::max(0.0, double(space.rlim_cur) - used), "the limit of this process (ulimit -v or -d)");
        }
    for (const std::string& folder : control_groups("memory"))
        if (const auto in_group = left_in_group(folder)) limit(*in_group, "the control group");
    return left;
}

void give_back_free_memory()
{
#ifdef __GLIBC__
    malloc_trim(0);
#endif
}

}  // namespace vdbcloud
