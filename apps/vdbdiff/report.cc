#include "report.h"

#include "vdbcloud/core/error.h"

#include <cmath>
#include <cstdio>

namespace vdbcloud {

namespace {

/// JSON has no infinity.
nlohmann::json number(double x) { return std::isfinite(x) ? nlohmann::json(x) : nlohmann::json("infinite"); }

}  // namespace

nlohmann::json described(const FileDifference& difference)
{
    nlohmann::json grids = nlohmann::json::array();
    for (const auto& d : difference.grids) {
        nlohmann::json grid = {{"name", d.label}, {"type", d.types}, {"comparable", d.comparable}};
        if (d.comparable)
            grid.update({{"by_value", d.by_value},
                         {"max", number(d.max)},
                         {"where", d.where},
                         {"rms", number(d.rms)},
                         {"relative", number(d.relative)},
                         {"voxels", d.voxels},
                         {"only_a", d.only_a},
                         {"only_b", d.only_b},
                         {"transform", number(d.transform)}});
        grid["metadata"] = d.metadata;
        grids.push_back(grid);
    }
    return {{"grids", grids},
            {"only_a", difference.only_a},
            {"only_b", difference.only_b},
            {"metadata", difference.metadata}};
}

void print_difference(app::App& app, const FileDifference& difference)
{
    for (const auto& d : difference.grids) {
        if (!d.comparable || !d.by_value) continue;
        char line[256];
        std::snprintf(line, sizeof line,
                      ": max %.6g at %d,%d,%d, rms %.6g, relative %.6g, active in one alone %llu of %llu", d.max,
                      d.where[0], d.where[1], d.where[2], d.rms, d.relative,
                      static_cast<unsigned long long>(d.only_a + d.only_b), static_cast<unsigned long long>(d.voxels));
        app.say("grid '" + printable(d.label) + "'" + line);
    }
}

}  // namespace vdbcloud
