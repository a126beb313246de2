// Depths of envelopes against their definitions, and the cumulus: where it stands, how high, and what it does not
// depend on.
#include "vdbcloud/fractal/cumulus.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/random.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud {
namespace {

const Box box{{-2, 1, 3}, {4, 5, 8}};  // sides 6, 4, 5

double depth_at(const Envelope& envelope, const Vec3d& p)
{
    const float x = float(p[0]), y = float(p[1]), z = float(p[2]);
    float out = 0;
    envelope.depth(envelope.all(), 1, &x, &y, &z, &out);
    return out;
}

Vec3d random_point(uint64_t k, const Box& in)
{
    Vec3d p;
    for (int a = 0; a < 3; ++a) p[a] = in.low[a] + in.sides()[a] * uniform(hash_bits(5, k, uint64_t(a)));
    return p;
}

TEST(Envelope, OfASphereIsTheDistanceToTheLargestInTheBox)
{
    const auto sphere = sphere_envelope(box);
    for (uint64_t k = 0; k < 50; ++k) {
        const Vec3d p = random_point(k, box);
        EXPECT_NEAR(depth_at(*sphere, p), 2 - (p - Vec3d(1, 3, 5.5)).length(), 1e-5);
    }
}

TEST(Envelope, OfAnEllipsoidIsItsShortestSemiAxisTimesTheRadialDepth)
{
    const auto ellipsoid = ellipsoid_envelope(box);
    for (uint64_t k = 0; k < 50; ++k) {
        const Vec3d p = random_point(k, box), q = (p - Vec3d(1, 3, 5.5)) / Vec3d(3, 2, 2.5);
        EXPECT_NEAR(depth_at(*ellipsoid, p), 2 * (1 - q.length()), 1e-5);
    }
}

TEST(Envelope, OfABoxAndASlabIsTheDistanceToTheNearestFace)
{
    const auto cuboid = box_envelope(box);
    for (uint64_t k = 0; k < 50; ++k) {
        const Vec3d p = random_point(k, {{-3, 0, 2}, {5, 6, 9}});
        double nearest[3];
        for (int a = 0; a < 3; ++a) {
            nearest[a] = std::min(p[a] - box.low[a], box.high[a] - p[a]);
            EXPECT_NEAR(depth_at(*slab_envelope(box, a), p), nearest[a], 1e-5);
        }
        EXPECT_NEAR(depth_at(*cuboid, p), std::min({nearest[0], nearest[1], nearest[2]}), 1e-5);
    }
}

// ---- cumulus ----

/// A grid of points over a box, and the depth at each.
struct Samples {
    Samples(const Envelope& envelope, const Box& in, int n)
    {
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j)
                for (int k = 0; k < n; ++k) {
                    point.push_back(in.low + in.sides() * Vec3d((i + 0.5) / n, (j + 0.5) / n, (k + 0.5) / n));
                    depth.push_back(depth_at(envelope, point.back()));
                }
    }
    std::vector<Vec3d> point;
    std::vector<double> depth;
};

TEST(Cumulus, TouchesTheBoxAndStandsOnItsBase)
{
    for (int up : {0, 1, 2}) {
        CumulusOptions o;
        o.up = up;
        const auto cloud = cumulus_envelope(box, o);
        EXPECT_FLOAT_EQ(cloud->base(), float(box.low[up]));
        const Samples samples(*cloud, {box.low - Vec3d(1), box.high + Vec3d(1)}, 40);
        Vec3d low(1e9), high(-1e9);
        for (size_t n = 0; n < samples.point.size(); ++n)
            if (samples.depth[n] > 0)
                for (int a = 0; a < 3; ++a) {
                    low[a] = std::min(low[a], samples.point[n][a]);
                    high[a] = std::max(high[a], samples.point[n][a]);
                }
        // Scaled alike on all axes until it meets a pair of sides or the top; points are 0.2 apart at most.
        double widest = 0;
        for (int a = 0; a < 3; ++a) {
            if (a != up) {
                EXPECT_GT(low[a], box.low[a] - 1e-4);
            }
            EXPECT_LT(high[a], box.high[a] + 1e-4);
            widest = std::max(widest, (high[a] - (a == up ? box.low[a] : low[a])) / box.sides()[a]);
        }
        EXPECT_GT(widest, 0.9);
        EXPECT_LT(low[up], box.low[up]);  // spheres reach below the base, where base() cuts them
        EXPECT_GT(depth_at(*cloud, box.centre() - Vec3d(up == 0, up == 1, up == 2) * (0.45 * box.sides()[up])), 0);
    }
}

TEST(Cumulus, DependsOnTheSeedAndOnTheBoxsProportionsAlone)
{
    const Box larger{{10, -5, 2}, {22, 3, 12}};  // sides twice those of `box`
    CumulusOptions o;
    const auto one = cumulus_envelope(box, o), two = cumulus_envelope(larger, o);
    o.seed = 2;
    const auto other = cumulus_envelope(box, o);
    double same = 0, different = 0;
    for (uint64_t k = 0; k < 300; ++k) {
        const Vec3d p = random_point(k, box), q = larger.low + 2.0 * (p - box.low);
        same = std::max(same, std::abs(depth_at(*one, p) - depth_at(*two, q) / 2));
        different = std::max(different, std::abs(depth_at(*one, p) - depth_at(*other, p)));
    }
    EXPECT_LT(same, 1e-4);
    EXPECT_GT(different, 0.2);
}

TEST(Cumulus, TurnsWithTheUpAxis)
{
    // Axes in cyclic order: what was (u, v, up) = (2, 0, 1) is (0, 1, 2).
    const auto turned = [](const Vec3d& p) { return Vec3d(p[2], p[0], p[1]); };
    CumulusOptions y_up, z_up;
    y_up.up = 1;
    z_up.up = 2;
    const auto y = cumulus_envelope(box, y_up), z = cumulus_envelope({turned(box.low), turned(box.high)}, z_up);
    for (uint64_t k = 0; k < 100; ++k) {
        const Vec3d p = random_point(k, box);
        EXPECT_NEAR(depth_at(*y, p), depth_at(*z, turned(p)), 1e-5);
    }
}

TEST(Cumulus, DepthHasSlopeOneAtItsSurface)
{
    // (r^2 - d^2) / (2 r) of a sphere has the slope d / r: 1 where it is 0, and 1 - 2 x / r to first order at depth x.
    const auto cloud = cumulus_envelope(box, {});
    int crossings = 0, unit = 0;
    for (uint64_t k = 0; k < 400; ++k) {
        Vec3d inside = random_point(k, box), outside = inside + Vec3d(0, 20, 0);
        if (depth_at(*cloud, inside) <= 0) continue;
        for (int n = 0; n < 40; ++n) {
            const Vec3d middle = 0.5 * (inside + outside);
            (depth_at(*cloud, middle) > 0 ? inside : outside) = middle;
        }
        const double e = 2e-3;
        Vec3d slope;
        for (int a = 0; a < 3; ++a) {
            Vec3d step(0);
            step[a] = e;
            slope[a] = (depth_at(*cloud, inside + step) - depth_at(*cloud, inside - step)) / (2 * e);
        }
        ++crossings;
        unit += std::abs(slope.length() - 1) < 5e-3;  // floats of 1e-6 over 4e-3, and e / r
    }
    EXPECT_GT(crossings, 60);
    EXPECT_GT(unit, 0.9 * crossings);  // on a crease between two bulges the slope is that of neither
}

TEST(Cumulus, GrowsBulgesOnTheOutsideOfItsSpheres)
{
    // Parts are spheres; a generation's radii are a stated share of their parents'. More towers, more spheres.
    CumulusOptions o;
    o.towers = 1;
    int before = 0;
    double smallest = 1e9, largest[5] = {};
    for (int generations : {1, 2, 3, 4}) {
        o.generations = generations;
        const auto cloud = cumulus_envelope(box, o);
        const Envelope::Parts& parts = cloud->all();
        EXPECT_GT(parts.count, before);
        before = parts.count;
        const size_t row = (size_t(parts.count) + 7) / 8 * 8;
        double least = 1e9;
        for (int i = 0; i < parts.count; ++i) {
            const double r = 2 * parts.data[3 * row + size_t(i)];
            EXPECT_NEAR(parts.data[4 * row + size_t(i)] * 2 * r, 1, 1e-5);
            least = std::min(least, r);
            largest[generations] = std::max(largest[generations], r);
        }
        EXPECT_LT(least / largest[generations], 0.75 * smallest);  // relative: the whole is scaled to the box
        smallest = least / largest[generations];
    }
    o.generations = 2;
    o.towers = 12;
    EXPECT_GT(cumulus_envelope(box, o)->all().count, 80);
}

TEST(Cumulus, SelectsThePartsThatMatterInABall)
{
    const auto cloud = cumulus_envelope(box, {});
    Envelope::Parts near;
    int fewer = 0;
    for (uint64_t k = 0; k < 200; ++k) {
        const Vec3d c = random_point(k, box);
        const Envelope::Ball ball{Vec3f(c), 0.3f};
        const auto range = cloud->select(cloud->all(), ball, -1e30f, near);
        fewer += near.count < cloud->all().count / 2;
        for (uint64_t n = 0; n < 20; ++n) {
            Vec3d d = random_point(n, {Vec3d(-0.3), Vec3d(0.3)});
            if (d.length() > 0.3) continue;
            const Vec3d p = c + d;
            const float x = float(p[0]), y = float(p[1]), z = float(p[2]);
            float depth;
            cloud->depth(near, 1, &x, &y, &z, &depth);
            ASSERT_NEAR(depth, depth_at(*cloud, p), 1e-5);
            ASSERT_LE(range.low, depth + 1e-5);
            ASSERT_GE(range.high, depth - 1e-5);
        }
    }
    EXPECT_GT(fewer, 150);
}

TEST(Cumulus, RefusesOptionsOutsideTheirRange)
{
    CumulusOptions o;
    o.towers = 0;
    EXPECT_THROW(cumulus_envelope(box, o), InputError);
    o.towers = 1;
    o.generations = 5;
    EXPECT_THROW(cumulus_envelope(box, o), InputError);
}

}  // namespace
}  // namespace vdbcloud
