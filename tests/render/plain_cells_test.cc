// The plain path against the general path of the cells rule, with each kind of field that a ray can read.
#include "vdbcloud/render/lane_math.h"
#include "vdbcloud/render/media.h"

#include "support/fields.h"
#include "vdbcloud/voxels/extend.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

using openvdb::Coord;

/// A smooth field of an index that differs from field to field.
double wave(const Coord& c, int field)
{
    return std::sin(0.3 * c[0] + 0.7 * field) * std::cos(0.2 * c[1] - field) + std::sin(0.25 * c[2] + 2 * field);
}

/// A ball of density with holes, so that bricks and rows end within the body.
FloatGridPtr holed_ball()
{
    auto grid = FloatGrid::create(0.0f);
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.1));
    for (int x = -13; x <= 13; ++x)
        for (int y = -13; y <= 13; ++y)
            for (int z = -13; z <= 13; ++z) {
                const Coord c(x, y, z);
                if (x * x + y * y + z * z > 170 || wave(c, 3) > 1.2) continue;
                grid->tree().setValueOn(c, float(2 + wave(c, 0)));
            }
    return grid;
}

FloatGridPtr scalar(const FloatGrid& like, int field)
{
    auto grid = FloatGrid::create(0.0f);
    grid->setTransform(like.transform().copy());
    for (auto v = like.cbeginValueOn(); v; ++v) grid->tree().setValueOn(v.getCoord(), float(wave(v.getCoord(), field)));
    return grid;
}

Vec3SGridPtr vectors(const FloatGrid& like, int field, float base)
{
    auto grid = Vec3SGrid::create(Vec3f(0.0f));
    grid->setTransform(like.transform().copy());
    for (auto v = like.cbeginValueOn(); v; ++v) {
        const Coord c = v.getCoord();
        grid->tree().setValueOn(c, Vec3f(float(wave(c, field)), float(wave(c, field + 1)), float(wave(c, field + 2))) +
                                       Vec3f(base));
    }
    return grid;
}

/// Depths towards a light, as a transmittance grid.
FloatGridPtr transmittance(const FloatGrid& like, int field)
{
    auto grid = FloatGrid::create(1.0f);
    grid->setTransform(like.transform().copy());
    for (auto v = like.cbeginValueOn(); v; ++v)
        grid->tree().setValueOn(v.getCoord(), float(std::exp(-2.5 - wave(v.getCoord(), field))));
    return grid;
}

struct Case {
    const char* name;
    double g;
    int degree;
    bool rgb, scaled;
    double flux_limit;
    int suns;
};

Scene scene_of(const Case& c)
{
    Scene scene;
    const auto density = holed_ball();
    scene.volumes.resize(1);
    Volume& v = scene.volumes[0];
    v.density = density;
    v.medium.sigma_t_per_density = Vec3d(0.7);
    v.medium.albedo = c.scaled ? Vec3d(0.97) : Vec3d(0.97, 0.9, 0.8);
    v.medium.phase = PhaseFunction::henyey_greenstein(c.g);
    v.collided.scaling = c.scaled ? delta_scaling(v.medium.phase, c.degree) : no_scaling(v.medium.phase, c.degree);
    v.collided.flux_limit = c.flux_limit;
    if (c.rgb)
        v.collided.phi = vectors(*density, 5, 2.5f);
    else {
        v.collided.phi = scalar(*density, 5);
        v.collided.channel_scale = Vec3d(1, 0.5, 2);
    }
    for (int k = 0; k < 3; ++k) {
        const int of = c.rgb ? k : 0;
        v.collided.flux[size_t(k)] = vectors(*density, 11 + 3 * of, 0.5f);
        for (int m = 4; m < (c.degree + 1) * (c.degree + 1); ++m)
            v.collided.moments[size_t(k)].push_back(scalar(*density, 20 + m + 50 * of));
    }
    const Vec3d to_light[] = {Vec3d(0.3, 0.4, 1), Vec3d(-1, 0.2, 0.1)};
    for (int l = 0; l < c.suns; ++l) {
        scene.lights.push_back(make_sun(to_light[l], Vec3d(3, 2, 1), 0, l == 0 ? "sun" : "second"));
        v.transmittance.push_back(transmittance(*density, 40 + l));
    }
    return scene;
}

class PlainPath : public testing::TestWithParam<Case> {};

TEST_P(PlainPath, EqualsTheGeneralPath)
{
    const Scene scene = scene_of(GetParam());
    IntegratorOptions plain, general;
    general.plain_path = false;
    const PreparedScene fast(scene, plain), simple(scene, general);
    ASSERT_TRUE(fast.volumes[0].fields);
    ASSERT_FALSE(simple.volumes[0].fields);
    ASSERT_FALSE(fast.volumes[0].phi) << "a grid must not be repacked twice";
    const auto a = make_cells_integrator(fast, plain), b = make_cells_integrator(simple, general);
    RayResult p, q;
    int hits = 0;
    for (int n = 0; n < 400; ++n) {
        // Towards a point of the ball, from all sides; the first three along the axes, through edges of cells.
        Vec3d direction(std::sin(1.3 * n), std::cos(2.1 * n), -1 + 2 * std::fmod(0.618 * n, 1.0));
        if (n < 3) direction = Vec3d(n == 0, n == 1, n == 2);
        direction.normalize();
        const Vec3d target = n < 3 ? Vec3d(0.2) : 0.6 * Vec3d(std::sin(0.7 * n), std::sin(0.9 * n), std::cos(1.1 * n));
        const WorldRay ray{target - (n % 7 == 0 ? 0.3 : 4.0) * direction, direction};
        (*a)(ray, p);
        (*b)(ray, q);
        hits += q.tau[0] > 0;
        ASSERT_EQ(p.cells, q.cells) << n;
        ASSERT_EQ(p.lit, q.lit) << n;
        // The same sums in another order: some hundred terms of rounding 2e-16 each, where terms of both signs are 10
        // times their sum.
        const auto expect_near = [&](const Vec3d& x, const Vec3d& y, double scale) {
            for (int c = 0; c < 3; ++c) EXPECT_NEAR(x[c], y[c], 1e-12 * (scale + std::abs(y[c]))) << n;
        };
        expect_near(p.tau, q.tau, 0);
        expect_near(p.true_tau, q.true_tau, 0);
        expect_near(p.multiple, q.multiple, 1);
        for (size_t l = 0; l < p.direct.size(); ++l) expect_near(p.direct[l], q.direct[l], 1);
        // part_to_half() interpolates the logarithm of the mean of three equal channels.
        EXPECT_NEAR(p.half_way / q.half_way, 1, 1e-9) << n;
    }
    EXPECT_GT(hits, 300);
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, PlainPath,
    testing::Values(Case{"Isotropic", 0, 1, false, false, 0, 1}, Case{"IsotropicColours", 0, 1, true, false, 0, 2},
                    Case{"WithoutLights", 0.5, 1, false, true, 0, 0}, Case{"GreyFlux", 0.85, 1, false, true, 0, 1},
                    Case{"ShortenedFlux", 0.85, 1, false, true, 0.3, 1},
                    Case{"ColouredShortenedFlux", 0.85, 1, true, true, 0.3, 2},
                    Case{"BackwardFlux", -0.4, 1, true, false, 0, 1}, Case{"DegreeThree", 0.85, 3, false, true, 0, 1},
                    Case{"ColouredDegreeThree", 0.7, 3, true, true, 0.3, 1},
                    Case{"DegreeSeven", 0.85, 7, false, false, 0, 2}),
    [](const auto& of) { return std::string(of.param.name); });

/// Corners of FieldBricks are the floats of the brick maps of each grid: of the fringed grid, and of mapped values.
TEST(FieldBricks, HoldTheCornersOfBrickMaps)
{
    const auto density = holed_ball(), less = scalar(*density, 7);
    for (auto v = less->beginValueOn(); v; ++v)
        if (wave(v.getCoord(), 9) > 0.5) v.setValueOff();
    const auto more = vectors(*density, 8, 1);
    more->tree().fill(openvdb::CoordBBox(Coord(8, -8, 0), Coord(15, -1, 7)), Vec3f(1, 2, 3));  // a tile
    const auto depth = [](float x) { return 2 * x + 1; };
    const BrickMap map(*density), one(*with_fringe(*less)), three(*with_fringe(*more)), mapped(*density, 0, depth);
    const FieldBricks fields(map, {{density, depth, false}, {more, {}, true}, {less, {}, true}});
    ASSERT_EQ(fields.count(), 5);
    int compared = 0;
    for (const Vec3i& b : map.bricks()) {
        const float* found = fields.brick(map.number(b));
        if (!found) continue;
        for (int n = 0; n < 729; ++n, ++compared) {
            const auto at = [&](const BrickMap& of, int c) {
                const float* corner = of.find(b);
                return corner ? corner[729 * c + n] : 0.0f;
            };
            ASSERT_EQ(found[5 * n], at(mapped, 0)) << n;
            for (int c = 0; c < 3; ++c) ASSERT_FLOAT_EQ(found[5 * n + 1 + c], at(three, c)) << n;
            ASSERT_FLOAT_EQ(found[5 * n + 4], at(one, 0)) << n;
        }
    }
    EXPECT_GT(compared, 20 * 729);
}

TEST(LaneMath, ExponentialAndLogarithmHaveTheStatedErrors)
{
    for (int n = 0; n < 200000; ++n) {
        const double x = -700 + 0.00699 * n, y = std::exp(n * 1e-4);
        const lanes4::Lanes e = lanes4::exponential(lanes4::all(x)), l = lanes4::logarithm(lanes4::all(y));
        ASSERT_NEAR(e[1] / std::exp(x), 1, 5e-16) << x;  // half a unit of the last place of the library's beside
        ASSERT_NEAR(l[2], std::log(y), 1e-15 * (1 + std::log(y))) << y;
    }
    EXPECT_EQ(lanes4::exponential(lanes4::all(0.0))[0], 1);
    EXPECT_LT(lanes4::exponential(lanes4::all(-1e9))[3], 1e-300);
}

}  // namespace
}  // namespace vdbcloud
