#include "add_series.h"

#include "accuracy_line.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/registry.h"
#include "vdbcloud/scatter/series_grids.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

/// Sums over voxels and channels of the squares of b, and of a - b.
struct Squares {
    double difference = 0, norm = 0;

    void add(const Vec3SGrid& a, const Vec3SGrid& b, double weight = 1)
    {
        auto at = a.getConstAccessor();
        for (auto v = b.cbeginValueOn(); v; ++v) {
            difference += weight * double((at.getValue(v.getCoord()) - *v).lengthSqr());
            norm += weight * double(v->lengthSqr());
        }
    }
    double relative() const { return norm > 0 ? std::sqrt(difference / norm) : 0; }
};

/// What the picture sees is phi + 3 m_1' s.F: the mean of its square over all directions s of the eye is
/// phi^2 + 3 m_1'^2 F^2. The shortening of long fluxes is left out.
Squares seen(const CollidedLight& a, const CollidedLight& b)
{
    Squares squares;
    squares.add(*fluence(a), *fluence(b));
    const double m1 = b.scaling.mean_cosine();
    for (int c = 0; c < 3 && m1 != 0; ++c) {
        const auto of_a = flux_of(a, c), of_b = flux_of(b, c);
        if (of_a && of_b) squares.add(*of_a, *of_b, 3 * m1 * m1);
    }
    return squares;
}

}  // namespace

void add_series(app::App& app, P1solveOptions& o, GridFile& file, const FloatGrid& density, const Vec3SGrid* emission,
                const Medium& medium, const std::vector<Light>& lights, const CollidedLight& fields)
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
    ScatterReport at_this_albedo;
    const CollidedLight relit = relight(file, density, emission, medium, lights, o.scatter, at_this_albedo);
    app.add_work(report.work);
    app.add_work(at_this_albedo.work);
    Squares phi;
    phi.add(*fluence(relit), *fluence(fields));
    r["phi_error_against_direct_solve"] = phi.relative();
    const double error = seen(relit, fields).relative();
    r["error_against_direct_solve"] = error;
    Accuracy accuracy;
    accuracy.add("series_phi_error", phi.relative());
    accuracy.add("series_error", error);
    app::tell_accuracy(app, "series", accuracy, *find_grid(file, schema::series_phi_name(0)));
    if (error > 0.01)
        app.warnings()(
            "a picture made from the series at albedo " + app::shortest(least) + " errs by " + app::brief(100 * error) +
            " % of its multiple scattering, in the mean square over voxels and views; at other albedos expect "
            "as much");
}

}  // namespace vdbcloud
