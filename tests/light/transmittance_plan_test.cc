// What a light's grid would cost, against what it counts and holds.
#include "vdbcloud/light/transmittance_grid.h"

#include "vdbcloud/core/vdb.h"

#include "support/fields.h"

#include "vdbcloud/grid/tree_size.h"

#include <gtest/gtest.h>

namespace vdbcloud {
namespace {

using openvdb::Coord;
using test::box;

/// Lumps and holes of some voxels, in blocks of which many are part empty.
FloatGridPtr lumps(int n)
{
    return box({n, n, n}, 0.1, [](Coord p) {
        return std::max(0.0, std::sin(0.3 * p[0]) + std::sin(0.37 * p[1] + 1) + std::sin(0.41 * p[2] + 2) - 0.4);
    });
}

TEST(TransmittancePlan, CountsWhatTheLatticeCounts)
{
    const auto density = lumps(48);
    Medium medium;
    medium.sigma_t_per_density = Vec3d(3);
    for (const Vec3d& to : {Vec3d(0, 1, 0), Vec3d(0.3, 1, 0.2), Vec3d(-1, 0.8, 0.9)})
        for (const int rays : {1, 3})
            for (const int refine : {1, 2}) {
                TransmittanceOptions o;
                o.rays_per_voxel = rays;
                o.refine = refine;
                const Light light = make_sun(to);
                const TransmittancePlan plan = transmittance_plan(*density, medium, light, o, true);
                TransmittanceReport report;
                const auto grid = transmittance_grid(*density, medium, light, o, {}, &report);
                EXPECT_EQ(plan.work.of("light_point"), report.work.of("light_point"));
                // Taps are the mean of 16 places, and a plane's part that reaches rays is cut at the tile's edge.
                const double said = plan.work.of("lattice_product"), taken = report.work.of("lattice_product");
                EXPECT_GT(taken, 1e4);
                EXPECT_NEAR(said / taken, 1, 0.2) << to << " rays " << rays << " refine " << refine;
                EXPECT_EQ(plan.value_bytes, tree_size(*grid).values(4));
                EXPECT_GT(plan.grid_bytes, plan.value_bytes);
                EXPECT_GT(plan.bytes, plan.grid_bytes);
            }
}

TEST(TransmittancePlan, CountsEachPointOfADiscAndExactRaysOfALamp)
{
    const auto density = lumps(32);
    Medium medium;
    TransmittanceOptions o;
    o.disc_samples = 7;
    const Light disc = make_sun(Vec3d(0.2, 1, 0.1), Vec3d(1.0), 5);
    TransmittanceReport report;
    transmittance_grid(*density, medium, disc, o, {}, &report);
    const TransmittancePlan plan = transmittance_plan(*density, medium, disc, o, true);
    EXPECT_EQ(plan.work.of("light_point"), report.work.of("light_point"));
    EXPECT_NEAR(plan.work.of("lattice_product") / report.work.of("lattice_product"), 1, 0.2);

    // From a lamp far above each voxel's ray crosses the cells above it: of a full cube half of its edge in the mean.
    // A ray that is not quite upright crosses a few more. Bricks of one value would count once.
    const auto cube = box({24, 24, 24}, 1, [](Coord ijk) { return ijk[0] % 2 ? 1.0 : 0.5; });
    const TransmittancePlan lamp = transmittance_plan(*cube, medium, make_lamp(Vec3d(11.5, 1e5, 11.5)), o, true);
    EXPECT_EQ(lamp.work.of("lattice_product"), 0);
    EXPECT_NEAR(lamp.work.of("exact_cell") / std::pow(26, 3), 12.5, 2);
    const TransmittancePlan memory = transmittance_plan(*cube, medium, disc, o, false);
    EXPECT_TRUE(memory.work.events().empty());
    EXPECT_GT(memory.bytes, 24. * 24 * 24 * 4);
}

}  // namespace
}  // namespace vdbcloud
