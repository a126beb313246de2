#include "vdbcloud/core/memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <functional>
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
std::optional<double> left_in_group(const std::string& folder, const char* limit, const char* used)
{
    const auto most = number_in(folder + "/" + limit), now = number_in(folder + "/" + used);
    if (!most || !now || *most > 0x1p60) return std::nullopt;
    double cached = 0;
    std::ifstream statistics(folder + "/memory.stat");
    std::string name;
    for (double value = 0; statistics >> name >> value;)
        if (name == "inactive_file" || name == "total_inactive_file") cached = value;
    return std::max(0.0, *most - *now + cached);
}

/// Over this process's control group and those that hold it.
void limit_by_control_groups(const std::function<void(double)>& limit)
{
    std::ifstream groups("/proc/self/cgroup");
    for (std::string line; std::getline(groups, line);) {
        std::istringstream fields(line);
        std::string id, controllers, path;
        std::getline(fields, id, ':');
        std::getline(fields, controllers, ':');
        std::getline(fields, path);
        const bool second = controllers.empty();
        if (!second && controllers.find("memory") == std::string::npos) continue;
        const std::string root = second ? "/sys/fs/cgroup" : "/sys/fs/cgroup/memory";
        for (;;) {
            const auto left = second ? left_in_group(root + path, "memory.max", "memory.current")
                                     : left_in_group(root + path, "memory.limit_in_bytes", "memory.usage_in_bytes");
            if (left) limit(*left);
            if (path.empty() || path == "/") break;
            path.erase(path.rfind('/'));
        }
    }
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
    limit_by_control_groups([&](double bytes) { limit(bytes, "the control group"); });
    return left;
}

}  // namespace vdbcloud
