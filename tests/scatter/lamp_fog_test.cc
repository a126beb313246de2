// A lamp in fog: light close to it, against the closed form of an infinite medium.
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/scatter/multiple_scattering.h"

#include "support/voxel_field.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace vdbcloud {
namespace {

constexpr double w0 = 0.8;

/// Fluence of collided light at `r` mean free paths from a lamp of power 1 in isotropically scattering matter without
/// end: 1 / (2 pi^2 r) int k sin(kr) w0 A^2 / (1 - w0 A) dk, A = atan(k) / k. The tail of the integrand, (pi / 2)^2 w0
/// sin(kr) / k, is known. Source: Case, de Hoffmann & Placzek 1953.
double collided(double r)
{
    const auto rest = [](double k) {
        const double a = std::atan(k) / k, tail = k > 1 ? pi / 2 / k : 0.0;
        return k * w0 * (a * a / (1 - w0 * a) - tail * tail);
    };
    const double dk = std::min(0.02, 0.02 / r);
    double sum = 0, si = 0;  // si: int over 0 to 1 of sin(kr) / k
    for (double k = dk / 2; k < 1; k += dk) si += std::sin(k * r) / k * dk;
    for (double k = dk / 2; k < 400; k += dk) sum += rest(k) * std::sin(k * r) * dk;
    return (sum + w0 * pi * pi / 4 * (pi / 2 - si)) / (2 * pi * pi * r);
}

/// collided() from a table: within 1e-4 for r from 0.1 to 3.2.
double collided_at(double r)
{
    static const auto table = [] {
        std::vector<double> of;
        for (int k = 0; k <= 100; ++k) of.push_back(std::log(collided(0.1 * std::exp2(k / 20.0))));
        return of;
    }();
    const double at = 20 * std::log2(r / 0.1);
    const size_t k = std::min(size_t(at), table.size() - 2);
    return std::exp(table[k] + (at - double(k)) * (table[k + 1] - table[k]));
}

/// phi of a cube of ten mean free paths about a lamp, in voxels of edge h.
struct Fog {
    Fog(double edge, ScatterOptions options) : h(edge)
    {
        const int n = 2 * int(5 / h);
        const auto grid = test::voxel_field(Vec3i(n), Vec3d(h), [](const Vec3i&) { return 1.0; });
        lamp = Vec3d(h * (n / 2 - 0.5)) + h * Vec3d(0.37, 0.21, 0.44);  // nowhere in particular
        Medium medium;
        medium.sigma_t_per_density = Vec3d(1);
        medium.albedo = Vec3d(w0);
        options.reentry_rays = options.line_rays = 0;
        ScatterReport report;
        phi = scatter_p1(*grid, nullptr, nullptr, medium, {make_lamp(lamp, Vec3d(1 / (4 * pi)))}, options, {}, report)
                  .phi;
    }
    double h;
    Vec3d lamp;
    GridBasePtr phi;
};

/// Relative errors of phi at voxels from `near` to `far` mean free paths from the lamp.
struct Errors {
    double mean = 0, rms = 0;
    int voxels = 0;
};

Errors errors(const Fog& fog, double near, double far)
{
    Errors e;
    for (auto v = static_cast<const FloatGrid&>(*fog.phi).cbeginValueOn(); v; ++v) {
        const auto at = fog.phi->indexToWorld(v.getCoord());
        const double r = (Vec3d(at[0], at[1], at[2]) - fog.lamp).length();
        if (r < near || r > far) continue;
        const double error = double(*v) / collided_at(r) - 1;
        e.mean += error;
        e.rms += error * error;
        ++e.voxels;
    }
    e.mean /= e.voxels;
    e.rms = std::sqrt(e.rms / e.voxels);
    return e;
}

TEST(LampInFog, SweepsHaveItsLightFromTheNextVoxelOn)
{
    // The source is taken at voxels' centres and falls to a quarter from one voxel to the second: errors of (h / r)^2 /
    // 4 and less, of either sign about the lamp, so the mean is nearer. From three voxels on the directions show, by 4
    // %.
    ScatterOptions options;
    options.closure.iterations = 10;
    options.closure.directions = 64;
    const Fog coarse(0.5, options), fine(0.25, options);
    for (const auto& [near, far, mean, rms] :
         {std::tuple(0.8, 1.5, 0.06, 0.16), {1.5, 3.0, 0.02, 0.11}, {3.0, 6.0, 0.02, 0.06}})
        for (const Fog* fog : {&coarse, &fine}) {
            const Errors e = errors(*fog, near * fog->h, far * fog->h);
            EXPECT_GT(e.voxels, 10);
            EXPECT_LT(std::abs(e.mean), mean) << fog->h << ' ' << near;
            EXPECT_LT(e.rms, rms) << fog->h << ' ' << near;
        }
    EXPECT_LT(errors(fine, 0.75, 1.5).rms, 0.5 * errors(coarse, 0.75, 1.5).rms) << "half the voxel";
}

TEST(LampInFog, P1AloneIsTooDimWithinAMeanFreePath)
{
    // P1's light close to a source is not that of transport, whatever the voxel. A mean free path and more away it is.
    for (const double h : {0.5, 0.25}) {
        const Fog fog(h, {});
        const Errors close = errors(fog, 0.2, 0.5), beyond = errors(fog, 1.3, 2);
        EXPECT_LT(close.mean, -0.2) << h;
        EXPECT_GT(close.mean, -0.5) << h;
        EXPECT_NEAR(beyond.mean, 0.04, 0.05) << h;
    }
}

}  // namespace
}  // namespace vdbcloud
