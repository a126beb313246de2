// A cloud and its light, rotated and reflected in the world: phi is invariant, flux and moments rotate.
#include "vdbcloud/optics/spherical_harmonics.h"
#include "vdbcloud/scatter/multiple_scattering.h"

#include "scatter/fields.h"
#include "vdbcloud/core/vdb.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

/// Images of the world's axes.
struct Turn {
    const char* name;
    Vec3d x, y, z;
    Vec3d shift{0, 0, 0};  ///< of the whole cloud
    Vec3d operator()(const Vec3d& v) const { return v[0] * x + v[1] * y + v[2] * z; }
};

/// A rotation by `angle` about `axis` (Rodrigues).
Turn rotation(const char* name, Vec3d axis, double angle)
{
    axis = axis.unit();
    const auto turned = [&](const Vec3d& v) {
        return std::cos(angle) * v + std::sin(angle) * axis.cross(v) + (1 - std::cos(angle)) * axis.dot(v) * axis;
    };
    return {name, turned(Vec3d(1, 0, 0)), turned(Vec3d(0, 1, 0)), turned(Vec3d(0, 0, 1))};
}

constexpr double h = 0.1;

/// A lump without any symmetry, in boxes of unequal sides.
double lump(const Vec3i& p)
{
    const Vec3d x = Vec3d(p.x() - 4.5, p.y() - 5.5, p.z() - 3.5) / Vec3d(5, 6, 4);
    const double r = 1 - x.dot(x);
    return r > 0 ? r * (1 + 0.5 * x[0] - 0.4 * x[1] * x[2]) : 0.0;
}

CollidedLight solved(const Turn& turn, int iterations)
{
    const Vec3d stretched(h, 0.9 * h, 1.1 * h);
    const auto grid = test::voxel_field(Vec3i(10, 12, 8), turn(Vec3d(stretched[0], 0, 0)),
                                        turn(Vec3d(0, stretched[1], 0)), turn(Vec3d(0, 0, stretched[2])), lump);
    grid->transform().postTranslate(turn.shift);
    Medium medium;
    medium.sigma_t_per_density = Vec3d(6);
    medium.albedo = Vec3d(0.98);
    medium.phase = PhaseFunction("double-henyey-greenstein", {0.8, -0.2, 0.8});
    const Light sun = make_sun(turn(Vec3d(0.5, 0.8, -0.3)));
    ScatterOptions options;
    options.up = turn(Vec3d(0, 1, 0));
    options.closure.iterations = iterations;
    options.closure.directions = 64;
    options.closure.degree = 3;
    options.closure.change = 1e-7;
    options.solve.tolerance = 1e-10;
    options.reentry_rays = options.line_rays = 0;
    ScatterReport report;
    return scatter_p1(*grid, nullptr, nullptr, medium, {sun}, options, {}, report);
}

/// Sum of the moments of degree 2 and 3 times Y_lm(s), at one voxel.
double higher(const CollidedLight& fields, const openvdb::Coord& at, const Vec3d& s)
{
    double y[16], sum = 0;
    evaluate_harmonics(3, s, y);
    for (size_t k = 0; k < fields.moments[0].size(); ++k)
        sum += double(fields.moments[0][k]->tree().getValue(at)) * y[k + 4];
    return sum;
}

const FloatGrid& phi_of(const CollidedLight& light) { return static_cast<const FloatGrid&>(*light.phi); }

class TurnedGrid : public testing::TestWithParam<Turn> {};

TEST_P(TurnedGrid, PhiIsInvariantAndFluxAndMomentsRotate)
{
    // Single precision, and a solver that stops at 1e-10: 1e-4 of the largest value.
    const Turn none{"none", Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)}, &turn = GetParam();
    for (int iterations : {0, 6}) {
        const CollidedLight plain = solved(none, iterations), turned = solved(turn, iterations);
        double phi_error = 0, flux_error = 0, moment_error = 0, phi_size = 0, flux_size = 0, moment_size = 0;
        for (auto v = phi_of(plain).cbeginValueOn(); v; ++v) {
            const auto at = v.getCoord();
            const double phi = double(*v);
            phi_size = std::max(phi_size, phi);
            phi_error = std::max(phi_error, std::abs(double(phi_of(turned).tree().getValue(at)) - phi));
            const Vec3d flux = turn(Vec3d(plain.flux[0]->tree().getValue(at)));
            flux_size = std::max(flux_size, flux.length());
            flux_error = std::max(flux_error, (Vec3d(turned.flux[0]->tree().getValue(at)) - flux).length());
            for (const Vec3d& s : {Vec3d(0.6, 0, 0.8), Vec3d(-0.36, 0.48, 0.8), Vec3d(0, -1, 0)}) {
                const double sum = higher(plain, at, s);
                moment_size = std::max(moment_size, std::abs(sum));
                moment_error = std::max(moment_error, std::abs(higher(turned, at, turn(s)) - sum));
            }
        }
        EXPECT_LT(phi_error, 1e-4 * phi_size) << turn.name << ' ' << iterations;
        EXPECT_LT(flux_error, 1e-4 * flux_size) << turn.name << ' ' << iterations;
        EXPECT_GT(flux_size, 0.05 * phi_size);
        EXPECT_EQ(plain.moments[0].size(), iterations ? 12u : 0u);
        if (!iterations) continue;
        EXPECT_LT(moment_error, 1e-4 * moment_size) << turn.name;
        EXPECT_GT(moment_size, 0.003 * phi_size);
    }
}

INSTANTIATE_TEST_SUITE_P(Turns, TurnedGrid,
                         testing::Values(rotation("odd rotation", Vec3d(0.3, 1, -0.5), 37 * M_PI / 180),
                                         rotation("quarter turn about x", Vec3d(1, 0, 0), M_PI / 2),
                                         rotation("quarter turn about y", Vec3d(0, 1, 0), M_PI / 2),
                                         rotation("quarter turn about z", Vec3d(0, 0, 1), M_PI / 2),
                                         Turn{"far from the origin", Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1),
                                              Vec3d(1e7, -1e7, 1e7)},
                                         Turn{"mirror", Vec3d(-1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)},
                                         Turn{"axes exchanged", Vec3d(0, 0, 1), Vec3d(1, 0, 0), Vec3d(0, 1, 0)}),
                         [](const auto& test) { return "Turn" + std::to_string(test.index); });

}  // namespace
}  // namespace vdbcloud
