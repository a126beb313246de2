// Solids beside a medium as P1 and sweeps see them: what they hide of a sun, and what they take of the medium.
#include "support/fields.h"
#include "support/grids.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/grid/metadata.h"
#include "vdbcloud/grid/schema.h"
#include "vdbcloud/scatter/multiple_scattering.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace vdbcloud {
namespace {

using namespace test;

FloatGridPtr cube()
{
    return box({16, 16, 16}, 1, [](openvdb::Coord) { return 1.0; });
}

Medium medium(double sigma_t, double albedo, double g)
{
    Medium m;
    m.sigma_t_per_density = Vec3d(sigma_t);
    m.albedo = Vec3d(albedo);
    m.phase = PhaseFunction::henyey_greenstein(g);
    return m;
}

CollidedLight solved(const FloatGrid& density, const Medium& m, const std::vector<Light>& lights,
                     const ScatterOptions& o, ScatterReport& report)
{
    return scatter_p1(density, nullptr, nullptr, m, lights, o, {}, report);
}

double at(const CollidedLight& light, int i, int j, int k)
{
    return openvdb::gridPtrCast<FloatGrid>(light.phi)->tree().getValue(openvdb::Coord(i, j, k));
}

/// Hides the sun from the columns x = 8 .. 15.
Solid half_roof() { return make_box(Vec3d(7.5, 40, -50), Vec3d(50, 41, 50)); }

TEST(Solids, HideOneHalfOfTheSunsPower)
{
    const auto density = cube();
    for (const int iterations : {0, 2}) {
        ScatterOptions o;
        o.closure.iterations = iterations;
        const std::vector<Light> sun{make_sun(Vec3d(0, 1, 0))};
        ScatterReport all, half, none;
        solved(*density, medium(0.2, 0.9, 0.5), sun, o, all);
        o.solids = {half_roof()};
        const CollidedLight light = solved(*density, medium(0.2, 0.9, 0.5), sun, o, half);
        // Columns of voxels are lit or hidden, each whole: to the rounding of float depths.
        EXPECT_NEAR(half.channel[0].deposited, all.channel[0].deposited / 2, 1e-6 * all.channel[0].deposited);
        EXPECT_NEAR(half.channel[0].beam_in, all.channel[0].beam_in / 2, 1e-6 * all.channel[0].beam_in);
        EXPECT_GT(at(light, 2, 8, 8), 3 * at(light, 13, 8, 8)) << "light diffuses into the shadow from its edge alone";
        EXPECT_EQ(half.channel[0].lines, -1) << "lines do not know shadows";
        ASSERT_TRUE(half.solids);
        EXPECT_EQ(get_text(*light.phi, schema::solids, ""), solids_digest(o.solids, true));

        o.solids = {make_box(Vec3d(-50, 40, -50), Vec3d(50, 41, 50))};
        const CollidedLight dark = solved(*density, medium(0.2, 0.9, 0.5), sun, o, none);
        EXPECT_EQ(none.channel[0].deposited, 0);
        EXPECT_EQ(at(dark, 8, 8, 8), 0);
    }
}

TEST(Solids, ShadowedLightIsThatOfTheLitHalfAlone)
{
    // Light is linear in its sources: the light of the lit half and, mirrored, that of the other half make up the light
    // without a roof.
    const auto density = cube();
    ScatterOptions o;
    o.solve.tolerance = 1e-9;
    const std::vector<Light> sun{make_sun(Vec3d(0, 1, 0))};
    ScatterReport report;
    const CollidedLight all = solved(*density, medium(0.2, 0.9, 0.5), sun, o, report);
    o.solids = {half_roof()};
    ScatterReport shadowed;
    const CollidedLight half = solved(*density, medium(0.2, 0.9, 0.5), sun, o, shadowed);
    for (const int i : {0, 3, 7, 8, 12, 15})
        EXPECT_NEAR(at(half, i, 5, 6) + at(half, 15 - i, 5, 6), at(all, i, 5, 6), 1e-5 * at(all, i, 5, 6)) << i;
}

TEST(Solids, TakeTheirVoxelsAndKeepTheFurnace)
{
    const auto density = cube();
    for (const int iterations : {0, 3}) {
        ScatterOptions o;
        o.closure.iterations = iterations;
        o.solve.tolerance = 1e-9;
        o.sky = Sky::constant(Vec3d(2.0));
        Material white;
        white.colour = Vec3d(1.0);
        // Within the medium, half within it, and beside it; sweeps meet them all as walls.
        o.solids = {make_ball(Vec3d(8, 8, 8), 3.2, white)};
        if (iterations > 0) {
            o.solids.push_back(make_box(Vec3d(-5, -4, 3), Vec3d(-0.7, 9, 12), white));
            o.solids.push_back(make_ball(Vec3d(8, 21, 9), 3, white));
        }
        ScatterReport report;
        const CollidedLight light = solved(*density, medium(0.3, 1, 0.6), {}, o, report);
        size_t within = 0;
        for (int i = 0; i < 16; ++i)
            for (int j = 0; j < 16; ++j)
                for (int k = 0; k < 16; ++k) within += (Vec3d(i, j, k) - Vec3d(8, 8, 8)).length() <= 3.2;
        EXPECT_EQ(report.voxels, 4096 - within);
        EXPECT_GT(within, 100u);
        for (const int i : {0, 4, 12}) EXPECT_NEAR(at(light, i, 8, 8), 8 * pi, 1e-5 * 8 * pi) << i;
    }
}

/// Solid angle of a rectangle, from a point at the height h above its middle: edges 2a, 2b.
double rectangle(double a, double b, double h) { return 4 * std::atan(a * b / (h * std::sqrt(a * a + b * b + h * h))); }

/// Fluence in a cube 0 .. 16 of `count` voxels along an edge, so thin that its own light does not count, by many
/// directions. `place` lies between voxels, whose mean it is.
double fluence_at(const Vec3d& place, int count, const std::vector<Solid>& solids, const std::vector<Light>& lights,
                  const Sky& sky)
{
    const double h = 16.0 / count;
    const auto density = box({count, count, count}, h, [](openvdb::Coord) { return 1.0; });
    auto from_corner = density->transform().copy();
    from_corner->postTranslate(Vec3d(h / 2));
    density->setTransform(from_corner);
    ScatterOptions o;
    o.closure.iterations = 2;
    o.closure.directions = 2048;
    o.sky = sky;
    o.solids = solids;
    ScatterReport report;
    const CollidedLight light = solved(*density, medium(1e-6, 0.5, 0), lights, o, report);
    const Vec3d p = density->worldToIndex(place);
    double sum = 0;
    for (int n = 0; n < 8; ++n)
        sum += at(light, int(std::floor(p[0])) + (n & 1), int(std::floor(p[1])) + (n >> 1 & 1),
                  int(std::floor(p[2])) + (n >> 2));
    return sum / 8;
}

/// Errors of 16 and 32 voxels relative to a closed form. Walls are first order in the voxel: half a voxel of 6.5 in the
/// distance of a plate, and the spread of light from plane to plane.
void expect_first_order(const std::function<double(int)>& found, double expected, double most)
{
    const double coarse = found(16) / expected - 1, fine = found(32) / expected - 1;
    EXPECT_LT(std::abs(coarse), most);
    EXPECT_LT(std::abs(fine), 0.7 * std::abs(coarse) + 0.01) << coarse << ' ' << fine;
    EXPECT_LT(std::abs(2 * fine - coarse), 0.05)
        << "twice the finer less the coarser has no first order: " << coarse << ' ' << fine;
}

Material reflecting(double colour)
{
    Material m;
    m.colour = Vec3d(colour);
    return m;
}

TEST(Solids, HideTheSkyThatTheyStandBefore)
{
    const Sky sky = Sky::constant(Vec3d(1.0));
    const Solid plate = make_box(Vec3d(2, -5, 2), Vec3d(14, -2, 14), reflecting(0));
    expect_first_order([&](int count) { return 4 * pi - fluence_at(Vec3d(8, 5, 8), count, {plate}, {}, sky); },
                       rectangle(6, 6, 7), 0.2);
    // Light that passes close to a round body meets its voxels in several planes: it is hidden within a part of a voxel
    // more, which falls slower than the voxel. 16, 32 and 64 voxels: 11.5, 10.0, 7.0 % too much.
    const Solid ball = make_ball(Vec3d(-5, 8, 8), 4, reflecting(0));
    const double beside = 2 * pi * (1 - std::sqrt(1 - std::pow(4.0 / 9, 2)));
    const auto hidden = [&](int count) { return 4 * pi - fluence_at(Vec3d(4, 8, 8), count, {ball}, {}, sky); };
    const double coarse = hidden(16) / beside - 1, fine = hidden(32) / beside - 1;
    EXPECT_GT(coarse, fine);
    EXPECT_GT(fine, 0.05);
    EXPECT_LT(coarse, 0.15);
    EXPECT_NEAR(fluence_at(Vec3d(8, 5, 8), 16, {}, {}, sky), 4 * pi, 1e-4);
}

TEST(Solids, AreLitByWhatIsLeftOfTheSkyBehindTheMedium)
{
    // In a medium that only absorbs, 4.5 mean free paths deep at the ball's top, some hundredths of the sky are left. A
    // white ball sends back what it receives of that, not what it would receive without the medium.
    const auto density = cube();
    const auto fluence = [&](double colour) {
        ScatterOptions o;
        o.closure.iterations = 3;
        o.closure.directions = 128;
        o.sky = Sky::constant(Vec3d(1.0));
        o.solids = {make_ball(Vec3d(7.5, 7.5, 7.5), 3.5, reflecting(colour))};
        ScatterReport report;
        return at(solved(*density, medium(1, 0, 0), {}, o, report), 7, 12, 7);
    };
    const double black = fluence(0), white = fluence(1);
    EXPECT_GT(black, 0.01);
    EXPECT_LT(black, 0.1);
    // From below comes at most what comes from above, and that is weaker than the light from the sides.
    EXPECT_GT(white / black, 1.02);
    EXPECT_LT(white / black, 1.8);
}

TEST(Solids, HideTheSkyInTurnedAndStretchedGridsToo)
{
    // A thin ball of density about the origin on a lattice that is turned about two axes, of voxels 1 x 0.6 x 0.8; the
    // solid is where it was. Bounds as above.
    const auto density = FloatGrid::create(0.0f);
    const auto turned = openvdb::math::Transform::createLinearTransform();
    turned->preScale(Vec3d(1, 0.6, 0.8));
    turned->postRotate(0.5, openvdb::math::Z_AXIS);
    turned->postRotate(-0.8, openvdb::math::X_AXIS);
    density->setTransform(turned);
    for (int i = -9; i <= 9; ++i)
        for (int j = -14; j <= 14; ++j)
            for (int k = -11; k <= 11; ++k)
                if (density->indexToWorld(openvdb::Coord(i, j, k)).length() < 8)
                    density->tree().setValueOn(openvdb::Coord(i, j, k), 1.0f);
    ScatterOptions o;
    o.closure.iterations = 2;
    o.closure.directions = 2048;
    o.sky = Sky::constant(Vec3d(1.0));
    for (const Vec3d& towards : {Vec3d(-1, 0, 0), Vec3d(0.6, 0, 0.8), Vec3d(0, 1, 0)}) {
        o.solids = {make_ball(10 * towards, 4, reflecting(0))};
        ScatterReport report;
        const CollidedLight light = solved(*density, medium(1e-6, 0.5, 0), {}, o, report);
        const double beside = 2 * pi * (1 - std::sqrt(1 - std::pow(4.0 / 10, 2)));
        const double hidden = (4 * pi - at(light, 0, 0, 0)) / beside - 1;
        EXPECT_GT(hidden, 0.0) << towards;
        EXPECT_LT(hidden, 0.25) << towards;
    }
}

TEST(Solids, SendLightBackThatTheyReceive)
{
    // A plate in the sun has the radiance rho E cos / pi. A thin one shows each side its own light.
    const std::vector<Light> high{make_sun(Vec3d(0.6, 0.8, 0), Vec3d(3.0))},
        low{make_sun(Vec3d(0.6, -0.8, 0), Vec3d(3.0))};
    const double expected = 0.8 * 3 * 0.8 / pi * rectangle(6, 6, 7);
    const Solid below = make_box(Vec3d(2, -5, 2), Vec3d(14, -2, 14), reflecting(0.8)),
                above = make_box(Vec3d(2, 18, 2), Vec3d(14, 19.3, 14), reflecting(0.8));
    const Vec3d over(8, 5, 8), under(8, 11, 8);
    expect_first_order([&](int count) { return fluence_at(over, count, {below}, high, Sky()); }, expected, 0.2);
    expect_first_order([&](int count) { return fluence_at(under, count, {above}, low, Sky()); }, expected, 0.2);
    EXPECT_LT(fluence_at(over, 16, {below}, low, Sky()), 0.02 * expected);
    EXPECT_LT(fluence_at(under, 16, {above}, high, Sky()), 0.02 * expected);
}

TEST(Solids, MirrorsSendTheSkyAndNoSun)
{
    Material mirror = reflecting(0.8), glossy = mirror;
    mirror.finish = Finish::Mirror;
    glossy.finish = Finish::Glossy;
    const std::vector<Light> sun{make_sun(Vec3d(0.6, 0.8, 0), Vec3d(3.0))};
    const auto plate = [](const Material& m) { return make_box(Vec3d(2, -5, 2), Vec3d(14, -2, 14), m); };
    const Vec3d over(8, 5, 8);
    const double diffuse = fluence_at(over, 16, {plate(reflecting(0.8))}, {}, Sky::constant(Vec3d(1.0)));
    for (const Material& m : {mirror, glossy}) {
        EXPECT_LT(fluence_at(over, 16, {plate(m)}, sun, Sky()), 1e-4) << "what the medium itself scatters";
        EXPECT_EQ(fluence_at(over, 16, {plate(m)}, {}, Sky::constant(Vec3d(1.0))), diffuse);
    }
}

TEST(Solids, HideEmissionAndSendItBack)
{
    // The lowest layer glows; a plate parts the cube. Emission that is so compact would go by rays, which know no
    // walls.
    const auto density = cube();
    const auto glow = Vec3SGrid::create(Vec3f(0.0f));
    glow->setTransform(density->transform().copy());
    for (int i = 0; i < 16; ++i)
        for (int k = 0; k < 16; ++k) glow->tree().setValueOn(openvdb::Coord(i, 0, k), Vec3f(1.0f));
    const auto fluence = [&](const std::vector<Solid>& solids, int height) {
        ScatterOptions o;
        o.closure.iterations = 3;
        o.solids = solids;
        o.emission_by_rays = !solids.empty();  // beside none by sweeps, too, to compare
        ScatterReport report;
        const CollidedLight light = scatter_p1(*density, nullptr, glow.get(), medium(1e-4, 0, 0), {}, o, {}, report);
        return at(light, 8, height, 8);
    };
    const auto plate = [](double colour) {
        return make_box(Vec3d(-3, 6.6, -3), Vec3d(18, 8.4, 18), reflecting(colour));
    };
    EXPECT_LT(fluence({plate(0)}, 12), 1e-3 * fluence({}, 12));
    const double below = fluence({plate(0)}, 3);
    // It takes nothing that comes from below; the balance that closes sweeps is of all voxels together: to 10 %.
    EXPECT_NEAR(below, fluence({}, 3), 0.1 * below);
    EXPECT_GT(fluence({plate(1)}, 3), 1.05 * below);
    EXPECT_LT(fluence({plate(1)}, 3), 2 * below);
}

TEST(Solids, ColourTheLightThatTheySendBack)
{
    Material red;
    red.colour = Vec3d(0.9, 0.3, 0.0);
    ScatterOptions o;
    o.closure.iterations = 3;
    o.solids = {make_box(Vec3d(-20, -8, -20), Vec3d(40, -1.5, 40), red)};
    ScatterReport report;
    const CollidedLight light = solved(*cube(), medium(1e-6, 0.5, 0), {make_sun(Vec3d(0, 1, 0))}, o, report);
    const auto phi = openvdb::gridPtrCast<Vec3SGrid>(light.phi);
    ASSERT_TRUE(phi) << "channels differ by the solid alone";
    const Vec3f value = phi->tree().getValue(openvdb::Coord(8, 4, 8));
    EXPECT_NEAR(value[1] / value[0], 1.0 / 3, 1e-3);
    EXPECT_LT(value[2], 1e-3 * value[0]);
}

TEST(Solids, AreRefusedBesideAMediumThatRepeats)
{
    ScatterOptions o;
    o.periodic = {true, false, true};
    o.solids = {half_roof()};
    ScatterReport report;
    EXPECT_NE(sentence<InputError>([&] {
                  solved(*cube(), medium(0.2, 0.9, 0), {make_sun(Vec3d(0, 1, 0))}, o, report);
              }).find("solids beside a medium that repeats"),
              std::string::npos);
}

}  // namespace
}  // namespace vdbcloud
