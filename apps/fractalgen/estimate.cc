#include "estimate.h"

#include "envelope_grid.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/fractal/cloud_grid.h"
#include "vdbcloud/grid/tree_size.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace vdbcloud::app {

namespace {

using Leaf = openvdb::FloatTree::LeafNodeType;

constexpr int pilot_edge = 48;  // voxels along the longest side that a pilot needs at least

double voxels_of(const Vec3i& size) { return double(size[0]) * size[1] * size[2]; }

/// Voxels of the domain along each axis for one of the pilot: 1, 2 or 4.
int coarseness_of(const Domain& domain)
{
    const int longest = std::max({domain.size[0], domain.size[1], domain.size[2]});
    return longest >= 6 * pilot_edge ? 4 : longest >= 2 * pilot_edge ? 2 : 1;
}

Domain pilot_of(const Domain& domain, int coarseness)
{
    Domain pilot = domain;
    for (int a = 0; a < 3; ++a) {
        pilot.size[a] = (domain.size[a] + coarseness - 1) / coarseness;
        // Whole voxels of the same shape: a mountain's have to be cubes.
        pilot.box.high[a] = domain.box.low[a] + domain.box.sides()[a] / domain.size[a] * coarseness * pilot.size[a];
    }
    return pilot;
}

/// Blocks of a cloud: those on its surface, which have 512 values, and those of density 1.
struct BlockCount {
    double mixed = 0, full = 0;
};

BlockCount count_blocks(const CloudBlocks& cloud)
{
    BlockCount count;
    for (const CloudBlocks::Block& block : cloud.blocks) ++(block.values ? count.mixed : count.full);
    return count;
}

/// The value of smoothstep at the depth below which a block of the domain is not yet of density 1. Edges are at least
/// 1.5 voxels wide, and the pilot's voxels are larger.
float full_from(const Options& o, const Domain& domain, const Domain& pilot)
{
    const auto edge = [&](const Domain& of) {
        const Vec3d sides = of.box.sides();
        double coarsest = 0;
        for (int a = 0; a < 3; ++a) coarsest = std::max(coarsest, sides[a] / of.size[a]);
        return std::max(o.shape.edge * std::max({sides[0], sides[1], sides[2]}), 1.5 * coarsest);
    };
    const double t = edge(domain) / edge(pilot);
    return float(t * t * (3 - 2 * t));
}

/// The values of a cloud, the third index fastest.
std::vector<float> values_of(const CloudBlocks& cloud)
{
    const Vec3i& n = cloud.size;
    std::vector<float> values(size_t(voxels_of(n)), 0.0f);
    for (const CloudBlocks::Block& block : cloud.blocks)
        for (int k = 0; k < 512; ++k) {
            const Vec3i p = block.origin + Vec3i(k >> 6, k >> 3 & 7, k & 7);
            if (p[0] < n[0] && p[1] < n[1] && p[2] < n[2])
                values[(size_t(p[0]) * size_t(n[1]) + size_t(p[1])) * size_t(n[2]) + size_t(p[2])] =
                    block.values ? block.values[k] : 1.0f;
        }
    return values;
}

/// Blocks of the domain of which the pilot has `edge` voxels along each axis, each widened by `rim` voxels of the
/// pilot.
BlockCount blocks_between(const std::vector<float>& values, const Vec3i& n, int edge, int rim, float full)
{
    BlockCount count;
    for (int i = 0; i < n[0]; i += edge)
        for (int j = 0; j < n[1]; j += edge)
            for (int k = 0; k < n[2]; k += edge) {
                float least = 1, most = 0;
                for (int x = std::max(0, i - rim); x < std::min(n[0], i + edge + rim); ++x)
                    for (int y = std::max(0, j - rim); y < std::min(n[1], j + edge + rim); ++y)
                        for (int z = std::max(0, k - rim); z < std::min(n[2], k + edge + rim); ++z) {
                            const float value =
                                values[(size_t(x) * size_t(n[1]) + size_t(y)) * size_t(n[2]) + size_t(z)];
                            least = std::min(least, value);
                            most = std::max(most, value);
                        }
                if (most > 0) ++(least >= full ? count.full : count.mixed);
            }
    return count;
}

/// Blocks of the domain. The outermost samples of a block stand half a voxel of the pilot within its faces, and with
/// another layer half a voxel outside. Blocks that a surface crosses are as many as blocks are wide, so the mean of
/// both counts is that of the block itself.
BlockCount blocks_by_pilot(const CloudBlocks& pilot, int coarseness, float full)
{
    if (coarseness == 1) return count_blocks(pilot);
    const std::vector<float> values = values_of(pilot);
    const BlockCount within = blocks_between(values, pilot.size, 8 / coarseness, 0, full),
                     around = blocks_between(values, pilot.size, 8 / coarseness, 1, full);
    // shape_cloud() fills a block at once only where bounds on depth and noise say so: where a rim is full, too.
    const double any = (within.mixed + within.full + around.mixed + around.full) / 2;
    const BlockCount beyond = blocks_between(values, pilot.size, 8 / coarseness, coarseness / 2, full);
    return {any - beyond.full, beyond.full};
}

/// A tree of `leaves` leaves in a box.
TreeSize tree_in_box(double leaves, const Vec3i& size)
{
    const auto nodes = [&](int edge) {
        double count = 1;
        for (int a = 0; a < 3; ++a) count *= std::ceil(size[a] / double(edge));
        return count;
    };
    return {leaves, nodes(128), nodes(4096)};
}

Plan plan_of_mountain(const Options& o, const Domain& domain)
{
    Plan plan = least_plan(o, domain);
    const int coarseness = coarseness_of(domain);
    const Domain pilot = pilot_of(domain, coarseness);
    const auto grid = mountain_grid(mountain_heights(pilot.box, pilot.size, o.spectrum, o.relief), o.relief.half_width);
    const double more = coarseness * coarseness;  // a band around a surface
    plan.work.add("mountain_voxel", more * double(grid->activeVoxelCount()));
    const TreeSize size = tree_in_box(double(grid->tree().leafCount()) * more, domain.size);
    plan.work.add("write_byte", size.values(4));
    plan.bytes += 2 * size.memory(4);
    return plan;
}

}  // namespace

Plan least_plan(const Options& o, const Domain& domain)
{
    Plan plan;
    plan.way_out = "a smaller --size";
    if (o.mountain) {
        const double longest = std::max({domain.size[0], domain.size[1], domain.size[2]});
        plan.work.add("noise_point", longest * longest);
        plan.bytes = 16 * longest * longest;
        return plan;
    }
    plan.work.add("noise_point", voxels_of(domain.size));
    plan.bytes = double(fft::RealField<float>::bytes(domain.size));
    return plan;
}

Plan plan_of(const Options& o, const Domain& domain, const FloatGrid* mask)
{
    if (o.mountain) return plan_of_mountain(o, domain);
    Plan plan = least_plan(o, domain);
    const int coarseness = coarseness_of(domain);
    const Domain pilot = pilot_of(domain, coarseness);
    const auto noise = synthesize(pilot.size, pilot.box.sides(), o.spectrum);
    const CloudBlocks cloud = shape_cloud(noise, pilot.box, *envelope_of(o, pilot, mask), o.shape);
    const BlockCount blocks = blocks_by_pilot(cloud, coarseness, full_from(o, domain, pilot));
    plan.work.add("shape_block", blocks.mixed);
    if (mask) plan.work.add("mask_point", voxels_of(domain.size));
    plan.work.add("write_byte", tree_in_box(blocks.mixed, domain.size).values(4));
    const double values = blocks.mixed * double(4 * Leaf::SIZE), field = plan.bytes;
    // The distances of a mask are there while the cloud is shaped; the grid is made when the noise is gone.
    const double distances = mask ? 1.25 * field : 0;
    plan.bytes = std::max(field + distances + values, 2.2 * values);
    return plan;
}

Workload work_of(const CloudBlocks& cloud, bool masked)
{
    Workload work;
    work.add("noise_point", voxels_of(cloud.size));
    if (masked) work.add("mask_point", voxels_of(cloud.size));
    work.add("shape_block", count_blocks(cloud).mixed);
    return work;
}

}  // namespace vdbcloud::app
