#include "add_series.h"

#include "scaled_light.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/scatter/series_grids.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

/// || a - b || / || b || over the voxels and channels of b.
double difference(const Vec3SGrid& a, const Vec3SGrid& b)
{
    auto at = a.getConstAccessor();
    double sum = 0, norm = 0;
    for (auto v = b.cbeginValueOn(); v; ++v) {
        sum += double((at.getValue(v.getCoord()) - *v).lengthSqr());
        norm += double(v->lengthSqr());
    }
    return norm > 0 ? std::sqrt(sum / norm) : 0;
}

}  // namespace

void add_series(app::App& app, P1solveOptions& o, GridFile& file, const FloatGrid& density, const Vec3SGrid* emission,
                const Medium& medium, const std::vector<Light>& lights, ScatterFields& fields)
{
    const auto phase = app.phase("series");
    if (find_grid(file, schema::colour))
        throw InputError(file.path + ": the series in albedo needs one albedo for all voxels, and there is a Cd");
    SeriesReport report;
    o.series.solve.progress = app.progress("series");
    for (const auto& grid : series_p1(density, emission, medium, lights, o.scatter, o.series, o.series_raw, report))
        put_grid(file, grid);
    const double worst = std::max({report.estimate[0], report.estimate[1], report.estimate[2]});
    auto& r = app.report()["series"] = {{"norms", report.norm},
                                        {"ratio", report.ratio},
                                        {"convergence_estimate", worst},
                                        {"galerkin", o.series.galerkin},
                                        {"least_albedo", report.least_albedo},
                                        {"iterations", report.iterations}};
    const double least = std::min({medium.albedo[0], medium.albedo[1], medium.albedo[2]});
    if (!o.series.galerkin && least < report.least_albedo)
        throw ConvergenceError("the series does not converge at albedo " + app::shortest(least) + ": each order is " +
                               app::brief(worst) + " times the one before; it needs an albedo above " +
                               app::brief(report.least_albedo) + ", or --galerkin");
    std::vector<GridBasePtr> transmittance;
    for (const Light& light : lights)
        transmittance.push_back(app::scaled_light_grid(app, density, nullptr, medium, fields.scaling, light));
    const ScatterFields relit = relight(file, medium, lights, transmittance);
    r["error_against_direct_solve"] = difference(*relit.phi, *fields.phi);
    fields.phi = relit.phi;
    if (relit.flux[0]) fields.flux = relit.flux;
}

}  // namespace vdbcloud
