// Shapes against closed forms: volumes of envelopes, coverage, where the edge lies, and what may not matter.
#include "vdbcloud/fractal/cloud_shape.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/fractal/cloud_grid.h"
#include "vdbcloud/fractal/cumulus.h"
#include "vdbcloud/fractal/noise.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>

namespace vdbcloud {
namespace {

const Box domain{{-2, 1, 3}, {2, 5, 6}};

fft::RealField<float> noise_for(const Vec3i& size, uint64_t seed = 1)
{
    Spectrum s;
    s.seed = seed;
    return synthesize(size, domain.sides(), s);
}

ShapeOptions smooth()  // nothing but the envelope, its edge as sharp as may be
{
    ShapeOptions o;
    o.roughness = o.warp = o.edge = 0;
    return o;
}

/// Sum of f(density) over all voxels, times their volume; f(0) = 0.
template<typename F>
double integral(const CloudBlocks& cloud, F f)
{
    double sum = 0;
    for (const auto& block : cloud.blocks)
        for (int q = 0; q < 512; ++q) sum += f(block.values ? block.values[q] : 1.0f);
    return sum * cloud.domain.sides().product() / cloud.size.product();
}

/// Volume within the envelope: density rises as a smoothstep over 1.5 voxels inside, with mean 1/2 at half of
/// that, so voxels above 1/2 fill the envelope less a skin of 0.75 voxels.
double volume(const CloudBlocks& cloud)
{
    return integral(cloud, [](float d) { return d > 0.5f; });
}

const Vec3i size(80, 80, 60);  // cubes of edge 0.05
constexpr double skin = 0.75 * 0.05;

TEST(CloudShape, SphereHasItsVolume)
{
    const auto cloud = shape_cloud(noise_for(size), domain, *sphere_envelope(domain.inset(0.2)), smooth());
    const double r = 1.3 - skin;
    // Counting cells of a ball of 25 voxels' radius: about 1e-3 off.
    EXPECT_NEAR(volume(cloud) / (4 * M_PI / 3 * r * r * r), 1, 3e-3);
}

TEST(CloudShape, EllipsoidHasItsVolume)
{
    const auto cloud = shape_cloud(noise_for(size), domain, *ellipsoid_envelope(domain.inset(0.2)), smooth());
    const double q = 1 - skin / 1.3;  // its depth is that fraction of the smallest semi-axis
    EXPECT_NEAR(volume(cloud) / (4 * M_PI / 3 * 1.8 * 1.8 * 1.3 * q * q * q), 1, 3e-3);
}

TEST(CloudShape, BoxAndSlabHaveTheirVolume)
{
    // Faces between voxel centres: counted exactly. 0.75 voxels in from 0.225 = 4.5 voxels is 5.25: centre
    // 5.5 is the first.
    const auto box = shape_cloud(noise_for(size), domain, *box_envelope(domain.inset(0.225)), smooth());
    EXPECT_NEAR(volume(box), 3.5 * 3.5 * 2.5, 1e-6);
    Box layer = domain;
    layer.low[2] = 4.025, layer.high[2] = 5.025;  // through centres 20 and 40: 21 to 39 are above 1/2
    const auto slab = shape_cloud(noise_for(size), domain, *slab_envelope(layer, 2), smooth());
    EXPECT_NEAR(volume(slab), (4 - 0.1) * (4 - 0.1) * 0.95,
                1e-6);  // a voxel fades at each face of the domain
}

TEST(CloudShape, EdgeIsASmoothstepOfItsWidth)
{
    auto o = smooth();
    o.edge = 0.2;  // of the longest side, 4: 0.8
    const auto grid = cloud_grid(shape_cloud(noise_for(size), domain, *box_envelope(domain.inset(0.4)), o));
    const auto density = grid->getConstAccessor();
    for (int i = 0; i < 40; ++i) {
        const double depth = (i + 0.5) * 0.05 - 0.4, t = std::clamp(depth / 0.8, 0.0, 1.0);
        EXPECT_NEAR(density.getValue({i, 40, 30}), t * t * (3 - 2 * t), 1e-5) << i;
    }
}

TEST(CloudShape, FillsTheFractionOfTheEnvelopeThatCoverageAsksFor)
{
    const auto noise = noise_for(size, 5);
    const auto envelope = sphere_envelope(domain.inset(0.2));
    const double whole = 4 * M_PI / 3 * std::pow(1.3, 3);
    for (double coverage : {0.0, 0.1, 0.35, 0.8, 1.0}) {
        ShapeOptions o;
        o.roughness = 0.3;
        o.warp = 0.02;
        o.coverage = coverage;
        const auto cloud = shape_cloud(noise, domain, *envelope, o);
        // The noise displaces the envelope, which changes its volume little and its voxels at random: 1 %.
        const double filled = integral(cloud, [](float d) { return d > 0; });
        EXPECT_NEAR(filled / whole, coverage, 0.01) << coverage;
    }
}

/// The density of one voxel by the formula of the header, all parts of the envelope looked at.
double formula(const fft::RealField<float>& noise, const Envelope& envelope, const ShapeOptions& o, const Vec3i& ijk,
               double threshold)
{
    const Vec3i n = noise.size();
    const Vec3d h(domain.sides()[0] / n[0], domain.sides()[1] / n[1], domain.sides()[2] / n[2]);
    const auto at = [&](int si, int sj) {
        return std::clamp(double(noise((ijk[0] + si) % n[0], (ijk[1] + sj) % n[1], ijk[2])), -4.0, 4.0);
    };
    const Vec3d x(domain.low + h * (Vec3d(ijk) + Vec3d(0.5)));
    const Vec3f y(x +
                  o.warp * 4 * Vec3d(at(n[0] / 3, n[1] / 2), at(n[0] / 2, n[1] / 5), at(n[0] * 5 / 6, n[1] * 3 / 4)));
    const float px = y[0], py = y[1], pz = y[2];
    float depth;
    envelope.depth(envelope.all(), 1, &px, &py, &pz, &depth);
    const double b = (1 - o.billow) * at(0, 0) + o.billow * 2 * (std::abs(at(0, 0)) - std::sqrt(2 / M_PI));
    double v = depth + 4 * o.roughness * b - threshold;
    if (o.coverage) v = std::min(v, double(depth));
    v = std::min(v, x[o.up] - envelope.base() + 0.2 * 4 * o.roughness * b);
    for (int d = 0; d < 3; ++d) v = std::min({v, x[d] - domain.low[d], domain.high[d] - x[d]});
    const double t = std::clamp(v / std::max(4 * o.edge, 1.5 * h[0]), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

TEST(CloudShape, HasTheDensityOfItsFormulaInEveryVoxel)
{
    // Bounds over blocks decide most voxels and skip parts of the envelope: every density must still be exact.
    const auto noise = noise_for(size, 3);
    CumulusOptions c;
    c.up = 2;
    const auto cumulus = cumulus_envelope(domain.inset(0.15), c);
    const auto sphere = sphere_envelope(domain.inset(0.3)), slab = slab_envelope(domain.inset(0.8), 2);
    ShapeOptions fine, rough, bare;
    fine.roughness = 0.01, fine.warp = 0.01, fine.edge = 0.01;
    rough.roughness = 0.1, rough.warp = 0.05, rough.billow = 1, rough.coverage = 0.4, rough.edge = 0.05;
    bare.roughness = bare.warp = 0;
    for (const Envelope* envelope : {cumulus.get(), sphere.get(), slab.get()})
        for (ShapeOptions o : {fine, rough, bare}) {
            o.up = 2;
            const auto cloud = shape_cloud(noise, domain, *envelope, o);
            const auto grid = cloud_grid(cloud);
            const auto density = grid->getConstAccessor();
            double most = 0, mass = 0;
            for (int i = 0; i < size[0]; ++i)
                for (int j = 0; j < size[1]; ++j)
                    for (int k = (3 * i + 5 * j) % 7; k < size[2]; k += 7) {  // a seventh, in every place of a block
                        const double expected = formula(noise, *envelope, o, {i, j, k}, cloud.threshold);
                        most = std::max(most, std::abs(density.getValue({i, j, k}) - expected));
                        mass += expected;
                    }
            EXPECT_LT(most,
                      5e-5);  // single precision against double, over an edge of 0.075 at coordinates of 6
            EXPECT_GT(mass, 1000);
        }
    ShapeOptions o;
    o.up = 2;
    o.roughness = o.warp = 0.003;
    EXPECT_GT(cloud_grid(shape_cloud(noise, domain, *cumulus, o))->tree().activeTileCount(), 5u);
}

TEST(CloudShape, HasEqualBitsForAnyThreadCountAndOthersForAnotherSeed)
{
    const Vec3i odd(45, 53, 39);
    const auto make = [&](uint64_t seed) {
        CumulusOptions c;
        c.seed = seed;
        ShapeOptions o;
        o.coverage = 0.8;
        return shape_cloud(noise_for(odd, seed), domain, *cumulus_envelope(domain.inset(0.1), c), o);
    };
    const auto sum = [](const CloudBlocks& cloud) {
        std::vector<float> all;
        for (const auto& block : cloud.blocks) {
            all.insert(all.end(), {float(block.origin[0]), float(block.origin[1]), float(block.origin[2])});
            if (block.values) all.insert(all.end(), block.values, block.values + 512);
        }
        return all;
    };
    const auto first = sum(make(1));
    ASSERT_GT(first.size(), 10000u);
    for (int threads : {1, 2, 4}) {
        tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        EXPECT_EQ(sum(make(1)), first) << threads << " threads";
    }
    EXPECT_NE(sum(make(2)), first);
}

TEST(CloudShape, RefusesOptionsOutsideTheirRange)
{
    const auto noise = noise_for({8, 8, 8});
    const auto envelope = sphere_envelope(domain);
    for (double ShapeOptions::*member :
         {&ShapeOptions::roughness, &ShapeOptions::warp, &ShapeOptions::edge, &ShapeOptions::billow})
        for (double value : {-0.1, 11.0, std::nan("")}) {
            ShapeOptions o;
            o.*member = value;
            EXPECT_THROW(shape_cloud(noise, domain, *envelope, o), InputError);
        }
    ShapeOptions o;
    o.coverage = 1.5;
    EXPECT_THROW(shape_cloud(noise, domain, *envelope, o), InputError);
    EXPECT_THROW(sphere_envelope({{0, 0, 0}, {1, 0, 1}}), InputError);
    EXPECT_THROW(shape_cloud(noise, domain, *envelope, {}, [](double) { return false; }), Cancelled);
}

TEST(CloudGrid, HasItsFirstVoxelCentreHalfAVoxelInsideTheDomain)
{
    const auto grid = cloud_grid(shape_cloud(noise_for(size), domain, *sphere_envelope(domain.inset(0.2)), smooth()));
    EXPECT_TRUE(grid->indexToWorld(openvdb::Coord(0, 0, 0)).eq(Vec3d(-1.975, 1.025, 3.025), 1e-12));
    EXPECT_TRUE(grid->indexToWorld(openvdb::Coord(79, 79, 59)).eq(Vec3d(1.975, 4.975, 5.975), 1e-12));
    EXPECT_TRUE(grid->hasUniformVoxels());
    EXPECT_EQ(grid->getName(), "density");
    EXPECT_EQ(grid->getGridClass(), openvdb::GRID_FOG_VOLUME);
    EXPECT_EQ(grid->background(), 0);
    // The centre of mass is the centre of the sphere: a shift by half a voxel, 0.025, would show.
    Vec3d sum(0);
    double mass = 0;
    grid->tree().voxelizeActiveTiles();
    for (auto it = grid->cbeginValueOn(); it; ++it) {
        sum += double(*it) * grid->indexToWorld(it.getCoord());
        mass += *it;
        ASSERT_TRUE(*it > 0 && *it <= 1);
    }
    EXPECT_LT((sum / mass - domain.centre()).length(), 1e-3);
    const auto uneven = cloud_grid(shape_cloud(noise_for({20, 40, 60}), domain, *sphere_envelope(domain), smooth()));
    EXPECT_TRUE(uneven->voxelSize().eq(Vec3d(0.2, 0.1, 0.05), 1e-12));
}

}  // namespace
}  // namespace vdbcloud
