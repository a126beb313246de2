// The mean wind of every level returns to the environment's; eddies are left alone.
#include "vdbcloud/sim/air.h"
#include "vdbcloud/sim/effect.h"

#include <cmath>
#include <memory>

namespace vdbcloud::sim::effect {

namespace {

template<typename T>
std::vector<double> level_means(const Lattice& lattice, const Field<T>& field)
{
    const auto [nx, ny, nz] = lattice.n;
    std::vector<double> means(static_cast<size_t>(nz), 0.0);
    for_chunks(nz, plane_grain(nz), [&, nx = nx, ny = ny](int k0, int k1) {
        for (int k = k0; k < k1; ++k) {
            double sum = 0;
            for (int j = 0; j < ny; ++j) {
                const T* row = field.row(j, k);
                for (int i = 0; i < nx; ++i) sum += double(row[i]);
            }
            means[size_t(k)] = sum / (double(nx) * ny);
        }
    });
    return means;
}

template<typename T>
void add(Air<T>& air)
{
    if (!air.parameters.momentum) return;
    const double time = air.parameters.wind_relaxation;
    for (const size_t c : {0, 1}) {
        Variable<T>& v = air.wind[c];
        if (!v) continue;
        const auto mean = std::make_shared<std::vector<double>>();
        air.before_stage.push_back([&air, &v, mean](int in) { *mean = level_means(air.lattice, v.a[size_t(in)]); });
        v.stiff.push_back(
            [mean, time, &env = c == 0 ? air.column.u : air.column.v, width = air.width(v)](int, int, int k, T* out) {
                const T push = T((env[size_t(k)] - (*mean)[size_t(k)]) / time);
                for (int i = 0; i < width; ++i) out[i] += push;
            });
    }
    air.limit_step(1 / time);
}

}  // namespace

Effect wind_relaxation()
{
    return {"wind relaxation",
            "level means",
            {Setting::time("wind-relaxation", "time in which the mean wind of a level returns to the sounding's",
                           above_zero(never), [](Parameters& p) -> double& { return p.wind_relaxation; })},
            [](const Parameters& p) { return std::isfinite(p.wind_relaxation); },
            nullptr,
            nullptr,
            {add<float>, add<double>}};
}

}  // namespace vdbcloud::sim::effect
