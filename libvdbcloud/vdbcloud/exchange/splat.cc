#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/core/voxel_transform.h"
#include "vdbcloud/exchange/particles.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

using openvdb::Coord;

/// The voxels that a particle reaches: low to high, both included.
struct Reach {
    int low[3], high[3];
};

/// What the particles weigh, voxel by voxel.
class Kernel {
public:
    Kernel(const Particles& particles, const SplatOptions& options)
        : particles_(particles), cell_(options.cell), otherwise_(options.radius)
    {
        smallest_ = 2 * std::max({cell_[0], cell_[1], cell_[2]});
    }

    double radius(size_t p) const { return particles_.radius.empty() ? otherwise_ : double(particles_.radius[p]); }

    double mass(size_t p) const
    {
        if (!particles_.mass.empty()) return double(particles_.mass[p]);
        if (particles_.density.empty()) return 1;
        return double(particles_.density[p]) * 4 / 3 * M_PI * std::pow(radius(p), 3);
    }

    Reach reach(size_t p) const
    {
        const double r = radius(p);
        Reach reach;
        for (int a = 0; a < 3; ++a) {
            const double at = particles_.position[p][a] / cell_[a];
            const bool small = r < smallest_;
            reach.low[a] = int(small ? std::floor(at) : std::ceil(at - r / cell_[a]));
            reach.high[a] = small ? reach.low[a] + 1 : int(std::floor(at + r / cell_[a]));
        }
        return reach;
    }

    /// Not yet divided by the sum over all voxels.
    double weight(size_t p, const Coord& voxel) const
    {
        const double r = radius(p);
        double product = 1, squares = 0;
        for (int a = 0; a < 3; ++a) {
            const double d = particles_.position[p][a] - voxel[a] * cell_[a];
            product *= std::max(0.0, 1 - std::abs(d) / cell_[a]);
            squares += d * d;
        }
        if (r < smallest_) return product;
        const double q = std::sqrt(squares) / r;
        if (q >= 1) return 0;
        const double s = (1 - q) * (1 - q);
        return s * s * (4 * q + 1);
    }

    /// Sum of the weights.
    double sum(size_t p) const
    {
        const Reach to = reach(p);
        double all = 0;
        for (int i = to.low[0]; i <= to.high[0]; ++i)
            for (int j = to.low[1]; j <= to.high[1]; ++j)
                for (int k = to.low[2]; k <= to.high[2]; ++k) all += weight(p, Coord(i, j, k));
        return all;
    }

private:
    const Particles& particles_;
    Vec3d cell_;
    double otherwise_;
    double smallest_;  // radius that the voxels sample well; trilinear weights have the variance of 1.6 voxels
};

/// A particle in a block of 8^3 voxels.
struct Pair {
    uint64_t block;  // of its place, in the order of the tree
    uint32_t particle;

    bool operator<(const Pair& other) const
    {
        return block != other.block ? block < other.block : particle < other.particle;
    }
};

constexpr int bits = 21;  // of a block's number along an axis

uint64_t key_of(int i, int j, int k)
{
    constexpr int64_t middle = 1 << (bits - 1);
    return (uint64_t(i + middle) << (2 * bits)) | (uint64_t(j + middle) << bits) | uint64_t(k + middle);
}

Coord origin_of(uint64_t key)
{
    constexpr int64_t middle = 1 << (bits - 1), mask = (1 << bits) - 1;
    return {int((int64_t(key >> (2 * bits)) & mask) - middle) * 8, int((int64_t(key >> bits) & mask) - middle) * 8,
            int((int64_t(key) & mask) - middle) * 8};
}

template<typename F>
void each_block(const Reach& to, const F& f)
{
    for (int i = to.low[0] >> 3; i <= to.high[0] >> 3; ++i)
        for (int j = to.low[1] >> 3; j <= to.high[1] >> 3; ++j)
            for (int k = to.low[2] >> 3; k <= to.high[2] >> 3; ++k) f(i, j, k);
}

void check_options(const Particles& particles, const SplatOptions& options)
{
    constexpr double farthest = double(1 << (bits + 1));  // voxels from the origin, half of what a block's number holds
    if (particles.position.size() >= uint64_t(1) << 32) throw InputError("expected at most 2^32 particles");
    if (particles.mass.empty() && !particles.density.empty() && particles.radius.empty() && !(options.radius > 0))
        throw InputError("particles with a density and no radius: expected --radius, for their mass");
    for (size_t p = 0; p < particles.position.size(); ++p)
        for (int a = 0; a < 3; ++a) {
            const double r = particles.radius.empty() ? options.radius : double(particles.radius[p]);
            if (!((std::abs(particles.position[p][a]) + r) / options.cell[a] < farthest))
                throw InputError("particle " + std::to_string(p) +
                                 " lies or reaches more than 2^22 voxels from the origin: use larger cells (--cell)");
        }
}

std::vector<Pair> pairs_of(const Kernel& kernel, size_t count)
{
    std::vector<Pair> pairs;
    for (size_t p = 0; p < count; ++p)
        each_block(kernel.reach(p), [&](int i, int j, int k) { pairs.push_back({key_of(i, j, k), uint32_t(p)}); });
    tbb::parallel_sort(pairs.begin(), pairs.end());
    return pairs;
}

/// Sums of one block, in double precision: floats would lose small particles beside large ones.
struct Block {
    std::array<double, 512> mass{}, heat{};
    std::array<std::array<double, 3>, 512> momentum{};
};

void add(const Particles& particles, const Kernel& kernel, size_t p, double scale, const Coord& origin, Block& block)
{
    Reach to = kernel.reach(p);
    for (int a = 0; a < 3; ++a) {
        to.low[a] = std::max(to.low[a], origin[a]);
        to.high[a] = std::min(to.high[a], origin[a] + 7);
    }
    for (int i = to.low[0]; i <= to.high[0]; ++i)
        for (int j = to.low[1]; j <= to.high[1]; ++j)
            for (int k = to.low[2]; k <= to.high[2]; ++k) {
                const double share = scale * kernel.weight(p, Coord(i, j, k));
                const auto at = size_t(((i & 7) << 6) | ((j & 7) << 3) | (k & 7));
                block.mass[at] += share;
                if (!particles.temperature.empty()) block.heat[at] += share * double(particles.temperature[p]);
                if (!particles.velocity.empty())
                    for (int a = 0; a < 3; ++a)
                        block.momentum[at][size_t(a)] += share * double(particles.velocity[p][a]);
            }
}

/// The grids of the result, whose leaves are there before threads fill them.
class Grids {
public:
    Grids(const Particles& particles, const SplatOptions& options, const std::vector<Pair>& pairs)
        : volume_(options.cell[0] * options.cell[1] * options.cell[2])
    {
        const auto transform = voxel_transform(options.cell);
        result.density = FloatGrid::create(0.0f);
        if (!particles.temperature.empty()) result.temperature = FloatGrid::create(0.0f);
        if (!particles.velocity.empty()) result.velocity = Vec3SGrid::create(Vec3f(0));
        result.density->setTransform(transform);
        result.density->setGridClass(openvdb::GRID_FOG_VOLUME);
        if (result.temperature) result.temperature->setTransform(transform->copy());
        if (result.temperature) result.temperature->setGridClass(openvdb::GRID_FOG_VOLUME);
        if (result.velocity) result.velocity->setTransform(transform->copy());
        for (size_t k = 0; k < pairs.size(); ++k) {
            if (k > 0 && pairs[k].block == pairs[k - 1].block) continue;
            starts.push_back(k);
            const Coord origin = origin_of(pairs[k].block);
            density_.push_back(result.density->tree().touchLeaf(origin));
            if (result.temperature) temperature_.push_back(result.temperature->tree().touchLeaf(origin));
            if (result.velocity) velocity_.push_back(result.velocity->tree().touchLeaf(origin));
        }
        starts.push_back(pairs.size());
    }

    void set(size_t b, const Block& block)
    {
        for (openvdb::Index at = 0; at < 512; ++at) {
            const double mass = block.mass[at];
            const auto density = float(mass / volume_);
            if (!(density > 0)) continue;
            density_[b]->setValueOn(at, density);
            if (result.temperature) temperature_[b]->setValueOn(at, float(block.heat[at] / mass));
            if (result.velocity)
                velocity_[b]->setValueOn(at,
                                         Vec3f(float(block.momentum[at][0] / mass), float(block.momentum[at][1] / mass),
                                               float(block.momentum[at][2] / mass)));
        }
    }

    Splats result;
    std::vector<size_t> starts;  ///< of the pairs of each block, and the end

private:
    double volume_;
    std::vector<openvdb::FloatTree::LeafNodeType*> density_, temperature_;
    std::vector<openvdb::Vec3STree::LeafNodeType*> velocity_;
};

}  // namespace

SplatWork splat_work(const Particles& particles, const SplatOptions& options)
{
    constexpr double most_keys = 1 << 27;  // that are counted exactly
    check_options(particles, options);
    const Kernel kernel(particles, options);
    SplatWork work;
    for (size_t p = 0; p < particles.position.size(); ++p) {
        const Reach reach = kernel.reach(p);
        double voxels = 1, blocks = 1;
        for (int a = 0; a < 3; ++a) {
            voxels *= double(reach.high[a]) - reach.low[a] + 1;
            blocks *= double(reach.high[a] >> 3) - (reach.low[a] >> 3) + 1;
        }
        work.voxels += voxels;
        work.pairs += blocks;
    }
    work.blocks = work.nodes = work.pairs;
    if (work.pairs > most_keys) return work;
    for (const int shift : {0, 4}) {  // blocks of 8^3, and nodes of 16^3 blocks
        std::vector<uint64_t> keys;
        for (size_t p = 0; p < particles.position.size(); ++p)
            each_block(kernel.reach(p),
                       [&](int i, int j, int k) { keys.push_back(key_of(i >> shift, j >> shift, k >> shift)); });
        tbb::parallel_sort(keys.begin(), keys.end());
        (shift ? work.nodes : work.blocks) = double(std::unique(keys.begin(), keys.end()) - keys.begin());
    }
    return work;
}

Splats splat(const Particles& particles, const SplatOptions& options)
{
    check_options(particles, options);
    const Kernel kernel(particles, options);
    const size_t count = particles.position.size();
    std::vector<double> scale(count);  // mass over the sum of weights
    tbb::parallel_for(size_t(0), count, [&](size_t p) { scale[p] = kernel.mass(p) / kernel.sum(p); });
    const std::vector<Pair> pairs = pairs_of(kernel, count);
    Grids grids(particles, options, pairs);
    tbb::parallel_for(size_t(0), grids.starts.size() - 1, [&](size_t b) {
        Block block;
        const Coord origin = origin_of(pairs[grids.starts[b]].block);
        for (size_t k = grids.starts[b]; k < grids.starts[b + 1]; ++k)
            add(particles, kernel, pairs[k].particle, scale[pairs[k].particle], origin, block);
        grids.set(b, block);
    });
    for (size_t p = 0; p < count; ++p) grids.result.mass += kernel.mass(p);
    for (GridBase* grid :
         {static_cast<GridBase*>(grids.result.density.get()), static_cast<GridBase*>(grids.result.temperature.get()),
          static_cast<GridBase*>(grids.result.velocity.get())})
        if (grid) grid->pruneGrid();
    return grids.result;
}

}  // namespace vdbcloud
