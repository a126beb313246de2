// Media that overlap and keep their phase functions: extinction, scattering and every moment of it are sums.
#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/optics/joined_medium.h"
#include "vdbcloud/scatter/multiple_scattering.h"

#include "support/fields.h"
#include "support/slab_exact.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

using openvdb::Coord;

MediumPart part(const FloatGridPtr& density, const Vec3d& sigma_t, const Vec3d& albedo, const PhaseFunction& phase)
{
    MediumPart part{"part", density, {}, nullptr, nullptr};
    part.medium.sigma_t_per_density = sigma_t;
    part.medium.albedo = albedo;
    part.medium.phase = phase;
    return part;
}

struct Solved {
    CollidedLight light;
    ScatterReport report;
};

Solved solve(const JoinedMedium& joined, const std::vector<Light>& lights, ScatterOptions options)
{
    options.parts = joined.parts;
    options.solve.tolerance = 1e-8;
    options.reentry_rays = 0;
    Solved solved;
    solved.light =
        scatter_p1(*joined.density, joined.colour.get(), nullptr, joined.medium, lights, options, {}, solved.report);
    EXPECT_TRUE(solved.report.converged);
    return solved;
}

ScatterOptions sweeps(int degree, int iterations = 30)
{
    ScatterOptions options;
    options.closure.iterations = iterations;
    options.closure.directions = 64;
    options.closure.degree = degree;
    options.closure.change = 1e-6;
    return options;
}

/// Largest difference of phi over its largest value, at the active voxels of `at`.
double difference(const CollidedLight& a, const CollidedLight& b, const FloatGrid& at)
{
    const auto p = fluence(a), q = fluence(b);
    double most = 0, largest = 0;
    for (auto v = at.cbeginValueOn(); v; ++v)
        for (int c = 0; c < 3; ++c) {
            const double x = p->tree().getValue(v.getCoord())[c], y = q->tree().getValue(v.getCoord())[c];
            largest = std::max(largest, std::abs(x));
            most = std::max(most, std::abs(x - y));
        }
    return most / largest;
}

FloatGridPtr body(uint64_t seed, int n = 20)
{
    return test::box({n, n, n}, 1.0 / n, [&](Coord ijk) { return 0.02 + test::clumps(ijk, seed, 1.0); });
}

const PhaseFunction rayleigh("rayleigh"), forward = PhaseFunction::henyey_greenstein(0.8),
                                          blunt = PhaseFunction::henyey_greenstein(0.4);
const std::vector<Light> sun{make_sun(Vec3d(0.3, 1, 0.2))};

TEST(Overlap, ChannelsOfTwoPhaseFunctionsAreMediaOfTheirMixture)
{
    // Two lobes whose weights in the scattering are 0.7 and 0.3 everywhere, in red; 0.4 and 0.6 in blue.
    const auto density = body(1);
    const Vec3d first(7, 7, 4), second(6, 6, 12);
    const JoinedMedium joined =
        joined_medium({part(density, first, Vec3d(1), forward), part(density, second, Vec3d(0.5), blunt)}, true);
    ASSERT_EQ(joined.parts.size(), 2u);
    for (const int degree : {0, 3}) {
        // P1 knows no more of a phase function than its first moments. Of sweeps the first scattering of each medium is
        // fitted apart (first_scattering.h), which moves phi by less than 0.5 % of the sun's irradiance.
        const ScatterOptions options = degree ? sweeps(degree) : ScatterOptions();
        const Solved mixed = solve(joined, sun, options);
        for (const int c : {0, 2}) {
            const double w1 = first[c], w2 = 0.5 * second[c], all = first[c] + second[c];
            const PhaseFunction lobes("double-henyey-greenstein", {0.8, 0.4, w1 / (w1 + w2)});
            const Solved single =
                solve(joined_medium({part(density, Vec3d(all), Vec3d((w1 + w2) / all), lobes)}), sun, options);
            const auto own = fluence(mixed.light), of_one = fluence(single.light);
            for (auto v = density->cbeginValueOn(); v; ++v) {
                const double x = own->tree().getValue(v.getCoord())[c], y = of_one->tree().getValue(v.getCoord())[c];
                ASSERT_NEAR(x, y, degree ? 5e-3 : 2e-6) << v.getCoord() << ' ' << c;
            }
        }
    }
}

TEST(Overlap, PartsOfOnePhaseFunctionAreTheirSum)
{
    std::vector<MediumPart> parts{part(body(1), Vec3d(9, 8, 7), Vec3d(1, 0.9, 0.8), forward),
                                  part(body(2), Vec3d(18, 16, 14), Vec3d(0.6), forward)};
    const JoinedMedium sum = joined_medium(parts);
    // A third medium that overlaps but is too thin to matter keeps the parts apart.
    parts.push_back(part(body(3), Vec3d(1e-9, 2e-9, 1e-9), Vec3d(1), blunt));
    const JoinedMedium apart = joined_medium(parts, true);
    ASSERT_EQ(apart.parts.size(), 3u);
    // Exposed faces are weighted by the gradient of all media's mean extinction, which is that of the sum.
    for (const ScatterOptions& options : {ScatterOptions(), sweeps(1), sweeps(3)}) {
        const Solved one = solve(sum, sun, options), three = solve(apart, sun, options);
        EXPECT_LT(difference(one.light, three.light, *sum.density), 2e-5) << options.closure.degree;
    }
}

TEST(Overlap, SlabOfRayleighAndDropletsMatchesAddingDoubling)
{
    // A slab along y; the air's extinction differs over the channels. Tolerances as of one phase function
    // (phase_slab_test.cc): delta-M at degree 5 and voxels of tau / 64.
    constexpr int n = 64, order = 24;
    const auto density = test::box({8, n, 8}, 1.0 / n, [](Coord) { return 1.0; });
    const Vec3d air(0.5, 1, 2);
    const double droplets = 3;
    const JoinedMedium joined = joined_medium(
        {part(density, air, Vec3d(1), rayleigh), part(density, Vec3d(droplets), Vec3d(0.98), forward)}, true);
    ScatterOptions options = sweeps(5, 40);
    options.closure.directions = 128;
    options.periodic = {true, false, true};
    options.line_rays = 0;
    const Light above = make_sun(Vec3d(0, 1, 0));
    const Solved solved = solve(joined, {above}, options);
    const double in = 64.0 / n / n;
    for (int c = 0; c < 3; ++c) {
        const double w1 = air[c], w2 = 0.98 * droplets, all = air[c] + droplets;
        const DeltaScaling fine = delta_scaling(forward, 2 * order - 1);
        const double f = w2 * fine.delta_f / (w1 + w2), w0 = (w1 + w2) / all;
        test::SlabExact::Options o;
        o.n = order;
        o.tau = all * (1 - w0 * f);
        o.w0 = w0 * (1 - f) / (1 - w0 * f);
        for (int l = 0; l < 2 * order; ++l)
            o.moments.push_back((w1 * rayleigh.moment(l) + w2 * (forward.moment(l) - fine.delta_f)) /
                                ((w1 + w2) * (1 - f)));
        const test::SlabExact truth(o);
        const double swept_tau = air[c] + droplets * delta_scaling(forward, 5).extinction(0.98);
        const PlanePower& planes = solved.report.channel[size_t(c)].planes;
        EXPECT_NEAR(planes.reflected / in / truth.reflected(), 1, 0.006) << c;
        EXPECT_NEAR((planes.transmitted() / in + std::exp(-swept_tau)) / (truth.transmitted() + std::exp(-o.tau)), 1,
                    0.003)
            << c;
        // Either phase function alone reflects otherwise by far more than that.
        for (const double only : {0.0, 1.0}) {
            test::SlabExact::Options other = o;
            for (int l = 0; l < 2 * order; ++l)
                other.moments[size_t(l)] =
                    only * rayleigh.moment(l) + (1 - only) * (forward.moment(l) - fine.delta_f) / (1 - fine.delta_f);
            EXPECT_GT(std::abs(test::SlabExact(other).reflected() / truth.reflected() - 1), 0.02) << c << only;
        }
        EXPECT_LT(solved.report.channel[size_t(c)].budget.defect, 1e-6);
    }
}

TEST(Overlap, WhiteMediaUnderAUniformSkyAreAFurnace)
{
    const JoinedMedium joined =
        joined_medium({part(body(1), Vec3d(20), Vec3d(1), forward), part(body(2), Vec3d(2, 5, 11), Vec3d(1), rayleigh),
                       part(body(3), Vec3d(9, 5, 1), Vec3d(1), blunt)},
                      true);
    for (ScatterOptions options : {ScatterOptions(), sweeps(1, 5), sweeps(3, 5)}) {
        options.sky = Sky::constant(Vec3d(1));
        const auto phi = fluence(solve(joined, {}, options).light);
        for (auto v = joined.density->cbeginValueOn(); v; ++v)
            for (int c = 0; c < 3; ++c)
                ASSERT_NEAR(phi->tree().getValue(v.getCoord())[c] / (4 * pi), 1, 1e-5) << v.getCoord();
    }
}

TEST(Overlap, PowerOfColouredMediaBalances)
{
    const JoinedMedium joined = joined_medium(
        {part(body(1), Vec3d(20), Vec3d(0.99, 1, 0.9), forward), part(body(2), Vec3d(2, 5, 11), Vec3d(0.5), rayleigh)},
        true);
    for (const ScatterOptions& options : {ScatterOptions(), sweeps(3, 6)}) {
        const Solved solved = solve(joined, sun, options);
        EXPECT_EQ(solved.report.solves, 3);
        for (const ChannelReport& channel : solved.report.channel) {
            EXPECT_LT(channel.budget.defect, 1e-6);
            EXPECT_GT(channel.budget.absorbed, 0);
        }
    }
}

}  // namespace
}  // namespace vdbcloud
