// Opaque voxels under slanting light: the power that a body takes from a beam is that of its voxels' faces.
#include "vdbcloud/scatter/exposed_beam.h"

#include "scatter/fields.h"
#include "vdbcloud/core/vdb.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud {
namespace {

struct Body : test::P1Case {
    explicit Body(const FloatGridPtr& of) : P1Case(of), bricks(*of) {}

    P1Operator p1(double sigma_t, double albedo = 1) const
    {
        return P1Operator(index, density, exposed, {sigma_t, albedo, nullptr, PhaseFunction(), false});
    }
    BeamDepths depths(const P1Operator& of, const Light& light) const
    {
        BeamDepths all = beam_depths(index, exposed, bricks, light);
        add_boxed_depths(of, all);
        return all;
    }
    /// Power that a beam of irradiance 1 deposits.
    double taken(double sigma_t, const Light& light) const
    {
        const P1Operator of = p1(sigma_t);
        P1Source source(of);
        add_beam(of, depths(of, light), sigma_t, {{&source, 1.0}});
        return source.deposited;
    }
    BrickMap bricks;
};

FloatGridPtr box(const Vec3i& n, const Vec3d& edges)
{
    return test::voxel_field(n, edges, [](const Vec3i&) { return 1.0; });
}

FloatGridPtr diagonal(int n, const Vec3d& edges)
{
    return test::voxel_field(Vec3i(n, n, n), edges, [](const Vec3i& v) { return v[0] == v[1] && v[1] == v[2]; });
}

TEST(ExposedBeam, AnOpaqueBoxTakesAllLightThatFallsOnIt)
{
    // E times the sum over its lit faces of area x cosine. The trilinear fringe of the box over its own side that the
    // light grazes took 31 % of it at 1000 mean free paths a voxel. The weight leaves 1 / (2 x)^2 of that.
    const Vec3i n(6, 5, 7);
    const Vec3d h(1.0, 1.5, 0.7);
    const Body body(box(n, h));
    for (const Vec3d& to_sun : {Vec3d(0.3, 1, 0.2), Vec3d(1, 1, 1), Vec3d(-0.05, 0.1, 1)}) {
        const Vec3d s = to_sun.unit(), size = Vec3d(n[0], n[1], n[2]) * h;
        const double area = std::abs(s[0]) * size[1] * size[2] + std::abs(s[1]) * size[0] * size[2] +
                            std::abs(s[2]) * size[0] * size[1];
        for (const double sigma : {30.0, 1e3, 1e6})
            EXPECT_NEAR(body.taken(sigma, make_sun(to_sun)) / area, 1, 0.31 / std::pow(2 * 0.7 * sigma, 2) + 1e-3)
                << to_sun << ' ' << sigma;
    }
}

TEST(ExposedBeam, ADiagonalLineTakesNoLessLightWhereItIsDenser)
{
    // Each voxel is in the fringe of the next: 8 voxels took as much as one at 1e4 mean free paths a voxel, a fifth of
    // their silhouette. Light shadows four points of each of the three lit faces, so the power errs by an eighth of
    // the mean face at most.
    const Vec3d h(0.6214627822017005, 1.5157719139015224, 0.8458471442768124);
    const Body body(diagonal(8, h));
    const Light sun = make_sun(Vec3d(-1, -1, -1));
    double before = 0;
    for (double sigma = 1e-2; sigma < 1e5; sigma *= 1.7) {
        const double taken = body.taken(sigma, sun);
        EXPECT_GE(taken, before * (1 - 1e-5)) << sigma;
        before = taken;
    }
    const double silhouette = lost_power(line_depths(body.index, body.density, sun), 1e6);
    EXPECT_NEAR(before / silhouette, 1, 0.125);
}

TEST(ExposedBeam, LinesSeeTheSilhouetteOfAVoxel)
{
    // An opaque box loses the light of its projection. Lines are a 32nd of a voxel apart: each cuts off the edge of the
    // projection, 6 sides of one voxel, within half a spacing, with signs that cancel.
    const Vec3d h(0.5, 1, 2);
    const Body body(test::voxel_field(Vec3i(1), h, [](const Vec3i&) { return 1.0; }));
    for (const Vec3d& to : {Vec3d(1, 2, 3), Vec3d(-3, 1, 0.2), Vec3d(1, 1, 1), Vec3d(0, 1, 0)}) {
        const Vec3d s = to.unit();
        const double area = std::abs(s[0]) * h[1] * h[2] + std::abs(s[1]) * h[0] * h[2] + std::abs(s[2]) * h[0] * h[1];
        const double lost = lost_power(line_depths(body.index, body.density, make_sun(to)), 1e9);
        EXPECT_NEAR(lost / area, 1, 3 * 0.5 / 32) << to;
    }
}

TEST(ExposedBeam, DepthsAreThoseOfChordsThroughVoxels)
{
    // Against a search of every voxel for the chord of the ray, from the same points, also across emptiness and for a
    // lamp at a finite distance.
    FloatGridPtr grid = test::voxel_field(Vec3i(9, 4, 5), Vec3d(1.0, 0.5, 2.0), [](const Vec3i& v) {
        return (v[0] * 7 + v[1] * 5 + v[2] * 3) % 4 == 0 ? 0.0 : 1.0 + v[0] + 0.1 * v[1];
    });
    grid->tree().setValue(openvdb::Coord(5000, 3000, 2), 3.0f);
    const Body body(grid);
    const P1Operator p1 = body.p1(10);
    const Blocks& blocks = body.index.blocks();
    for (const Light& light : {make_sun(Vec3d(5000, 1500, 1)), make_sun(Vec3d(-1, 0.4, 0.3)), make_sun(Vec3d(0, -1, 0)),
                               make_lamp(Vec3d(4.3, 1.1, 3.9))}) {
        const BeamDepths depths = body.depths(p1, light);
        ASSERT_EQ(depths.boxed.size(), body.exposed.size());
        for (size_t k = 0; k < body.exposed.size(); ++k)
            for (int face = 0; face < 6; ++face) {
                if (!(body.exposed[k].faces >> face & 1)) continue;
                for (int n = 0; n < BeamDepths::points; ++n) {
                    const Vec3i v = blocks.voxel(body.exposed[k].slot);
                    Vec3d from(v[0], v[1], v[2]);
                    from[face / 2] += face % 2 ? 0.5 : -0.5;
                    from[(face / 2 + 1) % 3] += n & 1 ? 0.25 : -0.25;
                    from[(face / 2 + 2) % 3] += n & 2 ? 0.25 : -0.25;
                    const Sight sight = depths.light->towards(body.index.world(from));
                    double expected = 0;
                    for (size_t slot = 0; slot < blocks.count() * Blocks::size; ++slot) {
                        if (!blocks.active(slot)) continue;
                        const Vec3i cell = blocks.voxel(slot);
                        double t0 = 0, t1 = sight.distance;
                        for (int a = 0; a < 3; ++a) {
                            const double s = sight.direction.dot(body.index.axis(a)) / body.index.spacing()[a];
                            const double below = cell[a] - 0.5 - from[a], above = cell[a] + 0.5 - from[a];
                            if (std::abs(s) < 1e-12) {
                                if (below > 0 || above < 0) t1 = 0;
                                continue;
                            }
                            t0 = std::max(t0, std::min(below / s, above / s));
                            t1 = std::min(t1, std::max(below / s, above / s));
                        }
                        expected += body.density[slot] * std::max(t1 - t0, 0.0);
                    }
                    // A ray along a plane between voxels is in either of them; no power passes there.
                    if (std::abs(sight.direction[face / 2]) < 1e-12) continue;
                    EXPECT_NEAR(depths.boxed[k][size_t(face)][size_t(n)], expected, 1e-6 * expected + 1e-9)
                        << v << ' ' << face << ' ' << n;
                }
            }
    }
}

TEST(ExposedBeam, ThinVoxelsKeepTheTrilinearDepth)
{
    const Body body(box(Vec3i(5, 5, 5), Vec3d(1.0)));
    const Light sun = make_sun(Vec3d(0.3, 1, 0.2));
    const P1Operator thin = body.p1(0.2), thick = body.p1(5);
    EXPECT_TRUE(body.depths(thin, sun).boxed.empty());
    // Depths of a dense channel serve a thin one.
    const BeamDepths all = body.depths(thick, sun), own = body.depths(thin, sun);
    for (size_t k = 0; k < body.exposed.size(); ++k)
        for (int face = 0; face < 6; ++face) {
            if (!(body.exposed[k].faces >> face & 1)) continue;
            EXPECT_EQ(ExposedBeam(thin, all, 0.2)(k, face).part, ExposedBeam(thin, own, 0.2)(k, face).part);
        }
}

}  // namespace
}  // namespace vdbcloud
