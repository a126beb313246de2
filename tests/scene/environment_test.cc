// A sky from a picture of all directions, and its suns.
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/grid/select.h"
#include "vdbcloud/scatter/sky_inflow.h"
#include "vdbcloud/scene/colour.h"
#include "vdbcloud/scene/light.h"
#include "vdbcloud/scene/panorama.h"
#include "vdbcloud/scene/sky.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace vdbcloud {
namespace {

constexpr double degrees = M_PI / 180;

/// Texels from a field over (left, up, ahead).
std::shared_ptr<const Panorama> painted(int width, const std::function<Vec3d(const Vec3d&)>& field)
{
    const int height = width / 2;
    std::vector<float> rgb;
    for (int row = 0; row < height; ++row)
        for (int column = 0; column < width; ++column) {
            const double up = M_PI * (0.5 - (row + 0.5) / height), turn = 2 * M_PI * (0.5 - (column + 0.5) / width);
            const Vec3d L = field({std::cos(up) * std::sin(turn), std::sin(up), std::cos(up) * std::cos(turn)});
            for (int c = 0; c < 3; ++c) rgb.push_back(float(L[c]));
        }
    return std::make_shared<Panorama>(width, height, std::move(rgb));
}

Vec3d smooth(const Vec3d& w) { return Vec3d(2 + w[0], 2 + w[1] * w[2], 3 - w[2] - w[1]); }

TEST(Environment, ShowsItsPictureInWorldSpace)
{
    // Bilinear between texels of 1.4 degrees: an error of at most h^2 / 4 of the second derivatives, here 2.
    const auto map = painted(256, smooth);
    const double bound = 0.5 * std::pow(2 * M_PI / 256, 2);
    const Vec3d w = Vec3d(0.3, -0.5, 0.7).unit();
    const auto near = [&](const Sky& sky, const Vec3d& world) {
        EXPECT_LT((sky.radiance(world) - smooth(w)).length(), 4 * bound) << world;
    };
    near(environment_sky(map, 0, 1, Vec3d(0, 1, 0)), w);                          // y up: ahead is z, left is x
    near(environment_sky(map, 0, 1, Vec3d(0, 0, 1)), Vec3d(w[2], w[0], w[1]));    // z up: ahead is x, left is y
    near(environment_sky(map, 90, 1, Vec3d(0, 1, 0)), Vec3d(w[2], w[1], -w[0]));  // counterclockwise: z goes to x
    const Sky bright = environment_sky(map, 0, 3, Vec3d(0, 1, 0));
    EXPECT_LT((bright.radiance(w) / 3 - smooth(w)).length(), 4 * bound);
    EXPECT_EQ(bright.above_horizon().radiance(Vec3d(0.6, -0.8, 0)), Vec3d(0.0));
    // Continuous where the picture's sides meet, behind.
    EXPECT_LT((bright.radiance(Vec3d(1e-9, 0, -1)) - bright.radiance(Vec3d(-1e-9, 0, -1))).length(), 1e-6);
}

TEST(Environment, InflowIsThatOfItsIntegral)
{
    // Of L = 2 + w_x about the normal n: 2 + (2/3) n_x; 64 rows of parts: below 1e-3.
    const Sky sky = environment_sky(painted(512, [](const Vec3d& w) { return Vec3d(2 + w[0]); }), 0, 1, Vec3d(0, 1, 0));
    for (const Vec3d& n :
         {Vec3d(1, 0, 0), Vec3d(-1, 0, 0), Vec3d(0, 1, 0), Vec3d(0.6, 0, -0.8), Vec3d(0.48, -0.6, 0.64)})
        EXPECT_NEAR(sky.mean_inflow(n)[1], 2 + 2.0 / 3 * n[0], 2e-3) << n;
    const Sky half = environment_sky(painted(64, [](const Vec3d&) { return Vec3d(1.0); }), 0, 1, Vec3d(0, 1, 0));
    EXPECT_NEAR(half.mean_inflow(Vec3d(0, -1, 0))[0], 1, 1e-6);
    EXPECT_NEAR(half.above_horizon().mean_inflow(Vec3d(1, 0, 0))[0], 0.5, 1e-6);
    EXPECT_NEAR(half.above_horizon().mean_inflow(Vec3d(0, -1, 0))[0], 0, 1e-12);
}

/// A disc of `diameter` degrees towards `centre`, its edge soft over a texel, on a sky of 1.
std::shared_ptr<const Panorama> with_disc(int width, const Vec3d& centre, double diameter, double radiance)
{
    const double soft = 2 * M_PI / width;
    return painted(width, [=](const Vec3d& w) {
        const double angle = std::acos(std::min(1.0, w.dot(centre)));
        return Vec3d(1.0) +
               Vec3d(radiance, radiance / 2, 0) * std::clamp((diameter * degrees / 2 - angle) / soft + 0.5, 0.0, 1.0);
    });
}

TEST(Environment, SunsBecomeLightsOfTheSamePower)
{
    const Vec3d centre = Vec3d(-0.4, 0.5, 0.6).unit();
    const auto map = with_disc(1024, centre, 3, 5e3);
    ASSERT_EQ(map->suns().size(), 1u);
    const auto lights = environment_suns(*map, 0, 2, Vec3d(0, 1, 0));
    ASSERT_EQ(lights.size(), 1u);
    EXPECT_EQ(lights[0].name, "environment");
    // The disc's solid angle; texels of 0.35 degrees at its edge count by halves, so to 5 %.
    const double size = 2 * M_PI * (1 - std::cos(1.5 * degrees));
    EXPECT_NEAR(lights[0].strength()[0] / (2 * 5e3 * size), 1, 0.05);
    EXPECT_LT(lights[0].place().cross(centre).length(), 0.1 * degrees);
    EXPECT_GT(lights[0].place().dot(centre), 0);
    EXPECT_NEAR(lights[0].parameters()[1][0], 3, 0.15);
    // What is drawn has the sun; what lights has not; together they have what the picture has.
    const Sky sky = environment_sky(map, 0, 2, Vec3d(0, 1, 0));
    EXPECT_NEAR(sky.drawn().radiance(centre)[0], 2 * 5001, 1);
    EXPECT_LT(sky.radiance(centre)[0], 2 * 1e2);
    EXPECT_FALSE(sky == sky.drawn());
    double all = 0, left = 0;
    for (const Panorama::Part& part : map->parts()) left += part.radiance[0] * part.solid_angle;
    for (int row = 0; row < 512; ++row)
        for (int column = 0; column < 1024; ++column)
            all += double(map->rgb()[3 * size_t(row * 1024 + column)]) * 2 * M_PI / 1024 *
                   (std::sin(M_PI * (0.5 - row / 512.0)) - std::sin(M_PI * (0.5 - (row + 1) / 512.0)));
    EXPECT_NEAR((left + map->suns()[0].irradiance[0]) / all, 1, 2e-3);
}

TEST(Environment, LargeOrFaintSpotsStaySky)
{
    EXPECT_TRUE(with_disc(256, Vec3d(0, 1, 0), 20, 5e3)->suns().empty()) << "a softbox";
    EXPECT_TRUE(with_disc(256, Vec3d(0, 1, 0), 3, 15)->suns().empty()) << "below the contrast";
    EXPECT_EQ(with_disc(256, Vec3d(0, 0, -1), 6, 5e3)->suns().size(), 1u) << "across the picture's sides";
    EXPECT_EQ(with_disc(256, Vec3d(0, 1, 0), 6, 5e3)->suns().size(), 1u) << "at the pole";
    const auto spots = painted(512, [](const Vec3d& w) {
        double sum = 0.01;
        for (int k = 0; k < 12; ++k) {
            const double turn = 2 * M_PI * k / 12;
            if (w.dot(Vec3d(std::cos(turn), 0, std::sin(turn))) > std::cos(1.5 * degrees)) sum += 100 + k;
        }
        return Vec3d(sum);
    });
    ASSERT_EQ(spots->suns().size(), Panorama::most_suns);
    for (size_t n = 1; n < spots->suns().size(); ++n)
        EXPECT_GE(spots->suns()[n - 1].irradiance[0], spots->suns()[n].irradiance[0]);
}

TEST(Environment, FewDirectionsSeeMeansOfTheirCells)
{
    // A checker of texels has the mean 1: six directions see it, where single texels would be 0 or 2.
    std::vector<float> rgb;
    for (int n = 0; n < 128 * 64; ++n) rgb.insert(rgb.end(), 3, float(2 * ((n / 128 + n) % 2)));
    const Sky sky = environment_sky(std::make_shared<Panorama>(128, 64, rgb), 0, 1, Vec3d(0, 1, 0));
    auto grid = FloatGrid::create(0.0f);
    grid->tree().setValueOn(openvdb::Coord(0, 0, 0), 1.0f);
    const VoxelIndex index(*grid);
    std::vector<Vec3d> travel;
    for (int face = 0; face < 6; ++face) {
        Vec3d s(0);
        s[face / 2] = face % 2 ? 1 : -1;
        travel.push_back(s);
    }
    for (const float radiance : sky_along(index, sky, 1, travel)) EXPECT_NEAR(radiance, 1, 0.01);
    // A panel between the six directions is in the cells of all three beside it.
    const Vec3d corner = Vec3d(1, 1, 1).unit();
    const Sky panel = environment_sky(
        painted(256, [&](const Vec3d& w) { return Vec3d(w.dot(corner) > std::cos(15 * degrees) ? 10.0 : 0.0); }), 0, 1,
        Vec3d(0, 1, 0));
    ASSERT_TRUE(panel.map()->suns().empty());
    double power = 0;
    for (const float radiance : sky_along(index, panel, 0, travel)) power += 4 * M_PI / 6 * double(radiance);
    EXPECT_NEAR(power / (10 * 2 * M_PI * (1 - std::cos(15 * degrees))), 1, 0.03);
    EXPECT_EQ(panel.radiance(Vec3d(1, 0, 0)), Vec3d(0.0));
    // And each its own side.
    const Sky halves =
        environment_sky(painted(128, [](const Vec3d& w) { return Vec3d(w[1] > 0 ? 3.0 : 1.0); }), 0, 1, Vec3d(0, 1, 0));
    const auto seen = sky_along(index, halves, 0, travel);
    EXPECT_NEAR(seen[2], 3, 1e-5) << "light that travels down comes from above";
    EXPECT_NEAR(seen[3], 1, 1e-5);
}

TEST(Environment, TravelsInAFile)
{
    const auto map = with_disc(64, Vec3d(0, 1, 0), 12, 5e3);
    const Sky sky = environment_sky(map, 30, 2, Vec3d(0, 0, 1));
    GridFile file;
    put_panorama(file, map);
    MetaMap meta;
    write_sky(meta, sky);
    const auto back = read_sky(meta, &file);
    ASSERT_TRUE(back);
    EXPECT_TRUE(*back == sky);
    EXPECT_EQ(back->map()->rgb(), map->rgb());
    EXPECT_THROW(read_sky(meta), InputError);
    put_panorama(file, with_disc(64, Vec3d(0, 1, 0), 12, 4e3));
    EXPECT_EQ(file.grids.size(), 1u);
    EXPECT_THROW(read_sky(meta, &file), InputError) << "other texels";
    put_panorama(file, nullptr);
    EXPECT_TRUE(file.grids.empty());
    EXPECT_THROW(read_sky(meta, &file), InputError);
}

TEST(Environment, RefusesOtherShapesAndValues)
{
    EXPECT_THROW(Panorama(64, 64, std::vector<float>(64 * 64 * 3)), InputError);
    EXPECT_THROW(Panorama(4, 2, std::vector<float>(24)), InputError);
    EXPECT_THROW(Panorama(16, 8, std::vector<float>(3)), InputError);
    std::vector<float> rgb(16 * 8 * 3, 1.0f);
    rgb[5] = std::numeric_limits<float>::infinity();
    EXPECT_THROW(Panorama(16, 8, rgb), InputError);
    rgb[5] = -1;
    EXPECT_EQ(Panorama(16, 8, rgb).rgb()[5], 0);
    EXPECT_TRUE(environment_sky(std::make_shared<Panorama>(16, 8, std::vector<float>(16 * 8 * 3)), 0, 1, Vec3d(0, 1, 0))
                    .dark());
    EXPECT_EQ(painted(16, [](const Vec3d&) { return Vec3d(2, 1, 0); })->tones().size(), 1u);
    EXPECT_EQ(painted(16, smooth)->tones().size(), 3u);
}

}  // namespace
}  // namespace vdbcloud
