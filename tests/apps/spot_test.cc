// A spot inside a medium, from illuminate to the picture.
#include "in_folder.h"
#include "support/picture_file.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/file/io.h"
#include "vdbcloud/grid/grid_file.h"
#include "vdbcloud/scene/light.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud::test {
namespace {

constexpr double half = 2, h = 0.125, sigma = 0.05, albedo = 0.8;

/// A folder with box.vdb: density 1 within 2 of the origin along each axis, in voxels of 1/8.
class SpotProgram : public InFolder<SpotProgram> {
public:
    static constexpr const char* made = "true";

protected:
    void SetUp() override
    {
        auto density = FloatGrid::create(0.0f);
        density->setName("density");
        density->setGridClass(openvdb::GRID_FOG_VOLUME);
        density->setTransform(Transform::createLinearTransform(h));
        density->transform().postTranslate(Vec3d(h / 2));
        const int n = int(half / h);
        density->denseFill(openvdb::CoordBBox(openvdb::Coord(-n), openvdb::Coord(n - 1)), 1.0f, true);
        density->tree().voxelizeActiveTiles();
        GridFile file;
        file.metadata = std::make_shared<MetaMap>();
        file.grids = {density};
        write_grid_file(*folder_ / "box.vdb", file);
    }
    static double green(const std::string& options)
    {
        expect_done("render -q " + options + " --resolution 1 --fov 0.01 --aov none -o one.exr");
        return picture(*folder_ / "one.exr").at(0, 0, "G");
    }
};

/// Single scattering along the ray from z = 20 through x, 0: the integral, by the midpoint rule.
double scattered_once(const Light& light, double x)
{
    const int n = 20000;
    double sum = 0;
    for (int k = 0; k < n; ++k) {
        const Vec3d p(x, 0, half - 2 * half * (k + 0.5) / n);
        sum += light->irradiance(p) * std::exp(-sigma * (half - p[2] + light->towards(p).distance)) * 2 * half / n;
    }
    return sum * sigma * albedo / (4 * M_PI) * light.strength()[1];
}

TEST_F(SpotProgram, PicturesAreTheDirectIntegral)
{
    const Light light = make_spot(Vec3d(-1.2, 0.05, 0.1), Vec3d(1, 0, 0.2), 50, 0.4, Vec3d(7));
    expect_done("illuminate -q box.vdb --extinction 0.05 --albedo 0.8 --spot=-1.2,0.05,0.1 --spot-direction 1,0,0.2 "
                "--spot-angle 50 --spot-blend 0.4 --spot-intensity 7 -o lit.vdb");
    const auto stored = lights_of(read_grid_file(*folder_ / "lit.vdb"));
    ASSERT_EQ(stored.size(), 1u);
    EXPECT_TRUE(same_light(stored[0], light));
    for (const double x : {-0.5, 0.3, 1.5}) {
        const std::string view = "lit.vdb --camera " + std::to_string(x) + ",0,20 --direction 0,0,-1 ";
        const double expected = scattered_once(light, x);
        EXPECT_NEAR(green(view) / expected, 1, 0.01) << x;
        EXPECT_NEAR(green(view + "--shadow-rays") / expected, 1, 0.01) << x;
        // Paths add what is scattered more than once: up to 0.8 of the optical thickness of 0.2.
        const double paths = green(view + "--integrator path --spp 40000") / expected;
        EXPECT_GT(paths, 0.99) << x;
        EXPECT_LT(paths, 1.2) << x;
    }
    // Behind the spot there is no light but what others scatter.
    EXPECT_EQ(green("lit.vdb --camera -1.6,0,20 --direction 0,0,-1"), 0);
}

TEST_F(SpotProgram, MultipleScatteringHasItsPowerAndAgreesWithPaths)
{
    const std::string spot = "--spot=-1.2,0.05,0.1 --spot-direction 1,0,0.2 --spot-angle 90 --spot-intensity 7 ";
    expect_done("p1solve -q box.vdb --extinction 2 --albedo 0.9 " + spot +
                "--iterations 6 --directions 96 --degree 3 -o solved.vdb");
    const std::string view = " solved.vdb --camera 0.4,0,20 --direction 0,0,-1 --fov 9 --resolution 6 --aov none ";
    expect_done("render -q" + view + "--samples 16 -o swept.exr");
    expect_done("render -q" + view + "--integrator path --spp 2000 -o paths.exr");
    double swept = 0, paths = 0;
    const PictureFile a = picture(*folder_ / "swept.exr"), b = picture(*folder_ / "paths.exr");
    for (int j = 0; j < 6; ++j)
        for (int i = 0; i < 6; ++i) swept += a.at(i, j, "G"), paths += b.at(i, j, "G");
    EXPECT_NEAR(swept / paths, 1, 0.05);
}

}  // namespace
}  // namespace vdbcloud::test
