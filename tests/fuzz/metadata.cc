// Lines "KEY = VALUE" become metadata: numbers, x,y,z, else text. Every reader of it is called.
#include "fuzz.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/accuracy.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/grid/sources.h"
#include "vdbcloud/grid/up_axis.h"
#include "vdbcloud/optics/delta_scaling.h"
#include "vdbcloud/optics/medium.h"
#include "vdbcloud/scene/light.h"
#include "vdbcloud/scene/sky.h"

#include <cmath>
#include <functional>
#include <sstream>

namespace vdbcloud::test {
namespace {

MetaMap metadata_of(std::string_view bytes)
{
    MetaMap map;
    std::istringstream lines{std::string(bytes)};
    for (std::string line; std::getline(lines, line);) {
        const size_t equals = line.find(" = ");
        if (equals == std::string::npos || equals == 0) continue;
        const std::string key = line.substr(0, equals), value = line.substr(equals + 3);
        double x[3];
        char rest;
        const int read = std::sscanf(value.c_str(), "%lf,%lf,%lf%c", x, x + 1, x + 2, &rest);
        map.removeMeta(key);
        if (read == 3)
            set_vector(map, key, Vec3d(x));
        else if (read == 1 && value.find(' ') == std::string::npos)
            set_number(map, key, x[0]);
        else
            set_text(map, key, value);
    }
    return map;
}

}  // namespace

void judge(std::string_view bytes)
{
    const MetaMap map = metadata_of(bytes);
    const std::function<void()> readers[] = {
        [&] {
            const Medium medium = read_medium(map);
            for (int c = 0; c < 3; ++c)
                demand(medium.albedo[c] >= 0 && medium.albedo[c] <= 1 && medium.sigma_t_per_density[c] >= 0,
                       "coefficients of a medium");
            demand(std::abs(medium.phase.mean_cosine()) <= 1, "a mean cosine");
        },
        [&] {
            const DeltaScaling scaling = read_delta_scaling(map, PhaseFunction::henyey_greenstein(0.85));
            demand(scaling.moments.size() == size_t(scaling.degree) + 1, "a moment of each degree");
            for (const double m : scaling.moments) demand(std::isfinite(m), "finite moments");
        },
        [&] {
            if (const auto light = read_light(map, "transmittance_sun"))
                for (int c = 0; c < 3; ++c)
                    demand(std::isfinite(light->place()[c]) && light->strength()[c] >= 0, "a light");
        },
        [&] {
            if (const auto sky = read_sky(map)) demand(std::abs(sky->up().length() - 1) < 1e-6, "a unit vector");
        },
        [&] { read_accuracy(map); },
        [&] { read_periodic(map); },
        [&] {
            if (const auto albedo = read_ground(map)) demand(*albedo >= 0 && *albedo <= 1, "an albedo");
        },
        [&] { read_up_axis(map); },
        [&] { other_lights(map, {}); },
        [&] { get_numbers(map, schema::series_table); },
        [&] { passed_over(map); }};
    std::string first;
    for (const auto& reader : readers) try {
            reader();
        } catch (const InputError& e) {
            first = first.empty() ? e.what() : first;
        }
    if (!first.empty()) throw InputError(first);
}

}  // namespace vdbcloud::test
