// Where the integrators steps and romberg evaluate the medium.
#include "pictures.h"

namespace vdbcloud {
namespace {

using openvdb::Coord;
using test::constant_like;
using test::medium;
using test::one_pixel;
using test::Picture;
using test::volume_of;

TEST(Points, DoNotDependOnLeafBlocks)
{
    // One body at one place, by indices that differ: 6 voxels are 7 cells, a whole number of steps of 0.2 and 0.1.
    const auto make = [](const Coord& shift) {
        const auto density = openvdb::FloatGrid::create(0.0f);
        for (int n = 0; n < 216; ++n)
            density->tree().setValue(Coord(n % 6, n / 6 % 6, n / 36) + shift, 0.3f + 0.1f * float(n % 5));
        density->setTransform(openvdb::math::Transform::createLinearTransform(0.3));
        density->transform().postTranslate(-0.3 * shift.asVec3d());
        Scene scene;
        scene.volumes.push_back(volume_of(density, medium(Vec3d(2), Vec3d(0), 0)));
        scene.volumes[0].emission = constant_like<Vec3SGrid>(*density, Vec3f(1.0f));
        return scene;
    };
    for (const Integrator kind : {Integrator::Steps, Integrator::Romberg})
        for (const double step : {0.2, 0.1, 0.23})
            for (const Vec3d& s : {Vec3d(0, 0, 1), Vec3d(-1, 0, 0), Vec3d(0.36, 0.48, 0.8)}) {
                IntegratorOptions o;
                o.kind = kind;
                o.step = step;
                const auto view = one_pixel(Vec3d(0.76, 0.73, 0.79), -s);
                const Picture here(make(Coord(0)), view, o);
                for (int shift = 1; shift < 12; ++shift) {
                    const Picture there(make(Coord(shift, 5 * shift, 2 * shift)), view, o);
                    EXPECT_EQ(there.cost.cells, here.cost.cells) << step << ' ' << s << ' ' << shift;
                    for (const char* layer : {"transmittance", "emission"})  // rounding of float
                        EXPECT_NEAR(there.at(layer, 0), here.at(layer, 0), 1e-6) << step << ' ' << s << ' ' << shift;
                }
            }
}

TEST(Points, RombergMissesNoVoxelOfALongRay)
{
    // One voxel of optical depth 1 at any place of a ray of 200 voxels that is empty but for it. Rules of a table look
    // at points that are evenly spaced: with 32 intervals nine voxels of ten are between them.
    for (int place = 1; place < 199; place += 3) {
        const auto density = openvdb::FloatGrid::create(0.0f);
        for (const int end : {0, 199}) density->tree().setValue(Coord(end, 6, 0), 1.0f);  // beside the ray
        density->tree().setValue(Coord(place, 0, 0), 1.0f);
        Scene scene;
        scene.volumes.push_back(volume_of(density, medium(Vec3d(1), Vec3d(0), 0)));
        IntegratorOptions exact, o;
        o.kind = Integrator::Romberg;
        o.tolerance = 1e-3;
        const auto view = one_pixel(Vec3d(100, 0.25, 0.1), Vec3d(1, 0, 0));
        const double cells = Picture(scene, view, exact).at("transmittance", 0);
        ASSERT_NEAR(cells, std::exp(-0.75 * 0.9), 1e-5) << place;  // trilinear weights beside the voxel's centre
        EXPECT_NEAR(Picture(scene, view, o).at("transmittance", 0), cells, 2e-3) << place;  // two tolerances
    }
}

}  // namespace
}  // namespace vdbcloud
