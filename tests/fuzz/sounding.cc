#include "fuzz.h"

#include "vdbcloud/sim/sounding.h"

#include <cmath>

void vdbcloud::test::judge(std::string_view bytes)
{
    const sim::Sounding sounding = sim::read_sounding("fuzz", std::string(bytes));
    const std::vector<double>* const columns[] = {&sounding.z, &sounding.theta, &sounding.water, &sounding.u,
                                                  &sounding.v};
    demand(!sounding.z.empty(), "a level");
    for (const auto* column : columns) {
        demand(column->size() == sounding.z.size(), "columns of one length");
        for (const double x : *column) demand(std::isfinite(x), "finite numbers");
    }
    for (size_t k = 1; k < sounding.z.size(); ++k) demand(sounding.z[k] > sounding.z[k - 1], "rising heights");
    demand(sounding.pressure >= 0 && std::isfinite(sounding.pressure), "a pressure");
}
