#include "plan.h"

#include "shared.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/memory.h"
#include "vdbcloud/core/vdb.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud::app {

namespace {

/// An estimate in words: three digits, or whole seconds.
std::string rounded(double seconds)
{
    const double unit = seconds > 0 ? std::pow(10.0, std::min(std::floor(std::log10(seconds)) - 2, 0.0)) : 1;
    return brief(unit * std::round(seconds / unit));
}

/// A size in MB, or in GB from 1 GB on.
std::string size_text(double bytes)
{
    return bytes < 1e9 ? brief(std::ceil(bytes / 1e6)) + " MB" : brief(std::ceil(bytes / 1e8) / 10) + " GB";
}

/// Memory of code and buffers that a program touches after its plan is made [bytes].
constexpr double besides = 6e6;

/// How much too large an estimate of memory may be.
constexpr double doubt = 1.3;

}  // namespace

Plan::Plan() : held_(memory_held()), most_(most_memory_held()) {}

double Plan::peak() const { return std::max(most_, held_ + besides + bytes); }

std::string Plan::lack() const
{
    const auto left = memory_left();
    if (!left || bytes <= doubt * left->bytes) return {};
    return "not enough memory: this run needs about " + size_text(bytes) + " more, and " + left->limit + " leaves " +
           size_text(left->bytes) + ": expected " + way_out + ", or more memory";
}

void tell(App& app, const Plan& plan, const std::string& task)
{
    Workload all = app.take_work();
    all += plan.work;
    all.add(app.get_name() + "_start", 1);
    nlohmann::json events = all.events();
    app.report()["estimate"].update({{"memory_bytes", plan.peak()},
                                     {"seconds", all.seconds()},
                                     {"events", events},
                                     {"machine", unit_cost_machine()}});
    app.say("would " + task + ": about " + rounded(all.seconds()) + " s of processor time on " + unit_cost_machine() +
            ", and " + size_text(plan.peak()));
    if (const std::string lack = plan.lack(); !lack.empty()) app.warnings()(lack);
}

void require_memory(const Plan& plan)
{
    if (const std::string lack = plan.lack(); !lack.empty()) throw InputError(lack);
}

}  // namespace vdbcloud::app
