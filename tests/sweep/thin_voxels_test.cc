// The fast sweep keeps its digits where voxels are thin.
#include "support/voxel_field.h"
#include "swept_medium.h"

#include <gtest/gtest.h>

namespace vdbcloud {
namespace {

void expect_digits(const std::function<double(const Vec3i&)>& density, bool emission)
{
    test::SweptMedium m(test::voxel_field(Vec3i(11, 10, 9), Vec3d(1.0, 0.5, 0.7), density));
    m.add_source([&](const Vec3i& p) { return emission ? 1 / density(p) : 1.0; });
    m.emission = emission;
    const SweepSet set = test::set_of(ordinates(OrdinateKind::Product, 32, 1), 0, 0, 0.0);
    SweepResult fast, slow;
    TransportSweep(m.index, m.faces).run(set, m.fields(), fast);
    reference_sweep(m.index, m.faces, set, m.fields(), slow);
    for (size_t n = 0; n < slow.moments[0].size(); ++n)
        EXPECT_NEAR(fast.moments[0][n], slow.moments[0][n], 1e-5 * slow.moments[0][n]) << n;
}

TEST(ThinVoxels, ScatterWithTheRoundingOfTheirOwnLight)
{
    // The light of a voxel is 1 - e^-t = 1e-5 of q. By way of e^-t single precision would keep two digits.
    expect_digits([](const Vec3i&) { return 1e-5; }, false);
}

TEST(ThinVoxels, EmitBesideDenseVoxelsWithTheRoundingOfTheirOwnLight)
{
    // In q = S / sigma_t of a thin voxel beside a dense one all but 1e-5 cancels.
    expect_digits([](const Vec3i& p) { return (p.x() + p.y() + p.z()) % 2 ? 1e-5 : 3.0; }, true);
}

}  // namespace
}  // namespace vdbcloud
