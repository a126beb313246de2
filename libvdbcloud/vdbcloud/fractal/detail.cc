#include "vdbcloud/fractal/detail.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/core/tiles.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/fractal/noise.h"

#include <openvdb/tools/Interpolation.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace vdbcloud {

namespace {

using openvdb::Coord;

constexpr int noise_edge = 128;         // fine voxels of the noise, which repeats
constexpr double least_amount = 0.15;   // in even matter, of that where matter ends
constexpr double most_filled = 0x1p24;  // coarse voxels of tiles
constexpr int deconvolutions = 4;

/// Noise of variance 1 that repeats, at places in fine voxels.
class Pattern {
public:
    Pattern(int factor, const Vec3d& voxel, uint64_t seed) : field_(make(factor, voxel, seed))
    {
        double sum = 0;
        for (int i = 0; i < noise_edge; ++i)
            for (int j = 0; j < noise_edge; ++j)
                for (int k = 0; k < noise_edge; ++k) sum += double(field_(i, j, k)) * double(field_(i, j, k));
        scale_ = 1 / std::sqrt(sum / (double(noise_edge) * noise_edge * noise_edge));
    }

    double operator()(const Vec3d& at) const
    {
        int low[3];
        double part[3];
        for (int a = 0; a < 3; ++a) {
            const double f = std::floor(at[a]);
            part[a] = at[a] - f;
            low[a] = int(int64_t(f) & (noise_edge - 1));
        }
        double sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
            int c[3];
            double weight = 1;
            for (int a = 0; a < 3; ++a) {
                const int up = corner >> a & 1;
                c[a] = (low[a] + up) & (noise_edge - 1);
                weight *= up ? part[a] : 1 - part[a];
            }
            sum += weight * double(field_(c[0], c[1], c[2]));
        }
        return scale_ * sum;
    }

private:
    static fft::RealField<float> make(int factor, const Vec3d& voxel, uint64_t seed)
    {
        Spectrum spectrum;
        spectrum.seed = seed;
        spectrum.low_cut = noise_edge / (2.0 * factor);
        return synthesize({noise_edge, noise_edge, noise_edge}, double(noise_edge) * voxel, spectrum);
    }
    fft::RealField<float> field_;
    double scale_ = 1;
};

/// One of the two patterns at a time.
struct Phase {
    double age, weight;  // age from the middle of its life [s]
    Vec3d place;         // of the pattern
};

std::array<Phase, 2> phases_at(const DetailOptions& o)
{
    std::array<Phase, 2> phases;
    double squares = 0;
    for (int p = 0; p < 2; ++p) {
        const double lives = o.time / o.period + 0.5 * p, life = std::floor(lives), part = lives - life;
        Phase& phase = phases[size_t(p)];
        phase.age = (part - 0.5) * o.period;
        phase.weight = 1 - std::abs(2 * part - 1);
        squares += phase.weight * phase.weight;
        for (int a = 0; a < 3; ++a)
            phase.place[a] = noise_edge * uniform(hash_bits(o.seed, uint64_t(int64_t(life)), uint64_t(p), uint64_t(a)));
    }
    for (Phase& phase : phases) phase.weight /= std::sqrt(squares);
    return phases;
}

/// Velocity in coarse voxels a second. One object per thread.
class Flow {
public:
    Flow(const Vec3SGrid* velocity, const openvdb::math::Transform& coarse) : coarse_(coarse)
    {
        if (!velocity) return;
        at_.emplace(velocity->getConstAccessor());
        own_ = velocity->transformPtr();
        staggered_ = velocity->getGridClass() == openvdb::GRID_STAGGERED;
    }
    Vec3d operator()(const Vec3d& coarse_place) const
    {
        if (!at_) return Vec3d(0.0);
        const Vec3d place = own_->worldToIndex(coarse_.indexToWorld(coarse_place));
        const openvdb::Vec3f v = staggered_ ? openvdb::tools::StaggeredBoxSampler::sample(*at_, place)
                                            : openvdb::tools::BoxSampler::sample(*at_, place);
        return coarse_.baseMap()->applyInverseJacobian(Vec3d(v));
    }

private:
    const openvdb::math::Transform& coarse_;
    std::optional<Vec3SGrid::ConstAccessor> at_;
    openvdb::math::Transform::ConstPtr own_;
    bool staggered_ = false;
};

/// Values of coarse voxels within one of them: in its middle its own, in the middles of its faces and edges and at its
/// corners the mean of the voxels that touch there, linear between these 27 nodes.
class Within {
public:
    enum class Voids { DoNotCount, AreZero };  // AreZero: at nodes that touch an inactive voxel the value is 0
    Within(const FloatGrid::ConstAccessor& at, const Coord& voxel, Voids voids)
    {
        double value[27];
        bool on[27];
        for (int n = 0; n < 27; ++n) {
            float found;
            on[n] = at.probeValue(voxel.offsetBy(n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1), found);
            value[n] = double(found);
        }
        for (int n = 0; n < 27; ++n) {
            const int node[3] = {n / 9, n / 3 % 3, n % 3};
            double sum = 0;
            int touching = 0, counted = 0;
            for (int x = std::min(node[0], 1); x <= std::max(node[0], 1); ++x)
                for (int y = std::min(node[1], 1); y <= std::max(node[1], 1); ++y)
                    for (int z = std::min(node[2], 1); z <= std::max(node[2], 1); ++z) {
                        const int m = 9 * x + 3 * y + z;
                        ++touching;
                        if (on[m]) sum += value[m], ++counted;
                    }
            node_[n] = voids == Voids::AreZero && counted < touching ? 0 : sum / counted;
        }
    }
    /// `from_middle`: from -0.5 to 0.5 along each axis.
    double at(const Vec3d& from_middle) const
    {
        double sum = 0;
        for (int corner = 0; corner < 8; ++corner) {
            int n = 0;
            double weight = 1;
            for (int a = 0; a < 3; ++a) {
                const double u = 2 * from_middle[a] + 1;
                const int low = u < 1 ? 0 : 1, up = corner >> a & 1;
                n = 3 * n + low + up;
                weight *= up ? u - low : 1 - (u - low);
            }
            sum += weight * node_[n];
        }
        return sum;
    }
    double mean() const
    {
        double sum = 0;
        for (int n = 0; n < 27; ++n)
            sum += node_[n] * (n / 9 == 1 ? 0.5 : 0.25) * (n / 3 % 3 == 1 ? 0.5 : 0.25) * (n % 3 == 1 ? 0.5 : 0.25);
        return sum;
    }

private:
    double node_[27];
};

template<typename F>
void each_leaf(FloatGrid& grid, const F& f)
{
    std::vector<openvdb::FloatTree::LeafNodeType*> leaves;
    grid.tree().getNodes(leaves);
    tbb::parallel_for(size_t(0), leaves.size(), [&](size_t n) { f(*leaves[n]); });
}

/// Voxels above 0 alone are active; no tiles.
FloatGridPtr matter_of(const FloatGrid& coarse)
{
    double filled = 0;
    for_each_active_tile(coarse, [&](const auto& tile) {
        openvdb::CoordBBox box;
        tile.getBoundingBox(box);
        if (*tile > 0) filled += double(box.volume());
    });
    if (filled > most_filled)
        throw InputError("grid '" + printable(coarse.getName()) +
                         "': tiles of more than 2^24 voxels of one density: expected a simulation");
    const FloatGridPtr matter = coarse.deepCopy();
    for_each_active_tile(*matter, [](const auto& tile) {
        if (!(*tile > 0)) tile.setActiveState(false);
    });
    matter->tree().voxelizeActiveTiles();
    each_leaf(*matter, [](auto& leaf) {
        for (auto v = leaf.beginValueOn(); v; ++v)
            if (!(*v > 0)) v.setValueOff();
    });
    return matter;
}

/// Values that have the mean of `matter` over each voxel, as Within joins them, but for what a voxel beside much denser
/// ones cannot have.
FloatGridPtr sharpened(const FloatGrid& matter)
{
    const FloatGridPtr out = matter.deepCopy();
    for (int n = 0; n < deconvolutions; ++n) {
        const FloatGridPtr before = out->deepCopy();
        each_leaf(*out, [&](auto& leaf) {
            const auto of = matter.getConstAccessor(), from = before->getConstAccessor();
            for (auto v = leaf.beginValueOn(); v; ++v) {
                const double mean = Within(from, v.getCoord(), Within::Voids::AreZero).mean();
                if (mean > 0) v.setValue(float(double(*v) * (double(of.getValue(v.getCoord())) / mean)));
            }
        });
    }
    return out;
}

/// a(x) at coarse voxels.
FloatGridPtr amounts(const FloatGrid& matter, double amount)
{
    const FloatGridPtr out = matter.deepCopy();
    each_leaf(*out, [&](auto& leaf) {
        const auto at = matter.getConstAccessor();
        for (auto v = leaf.beginValueOn(); v; ++v) {
            const double own = double(at.getValue(v.getCoord()));
            double jump = least_amount;
            for (int a = 0; a < 3; ++a)
                for (const int side : {-1, 1}) {
                    Coord c = v.getCoord();
                    c[a] += side;
                    const double other = at.isValueOn(c) ? double(at.getValue(c)) : 0;
                    jump = std::max(jump, std::abs(own - other) / std::max(own, other));
                }
            v.setValue(float(amount * jump));
        }
    });
    return out;
}

/// The finer lattice: `factor` voxels in each coarse one, which they fill.
openvdb::math::Transform::Ptr finer(const openvdb::math::Transform& coarse, int factor)
{
    const auto out = coarse.copy();
    out->preTranslate(Vec3d(-0.5));
    out->preScale(1.0 / factor);
    out->preTranslate(Vec3d(0.5));
    return out;
}

/// The fine voxels of a coarse one. Those of two leaves of coarse voxels are in leaves of their own, so that threads
/// may have one such leaf each.
class FineVoxels {
public:
    FineVoxels(FloatGrid& fine, int factor) : tree_(fine.tree()), factor_(factor) {}
    double count() const { return double(factor_) * factor_ * factor_; }
    void touch(const Coord& voxel) const
    {
        for (int corner = 0; corner < 8; ++corner) {
            Coord at;
            for (int a = 0; a < 3; ++a) at[a] = voxel[a] * factor_ + (corner >> a & 1 ? factor_ - 1 : 0);
            tree_.touchLeaf(at);
        }
    }
    /// Sets each to f(value, place), `place` in coarse voxels. Returns the sum.
    template<typename F>
    double set(const Coord& voxel, const F& f) const
    {
        double sum = 0;
        for (int x = 0; x < factor_; ++x)
            for (int y = 0; y < factor_; ++y)
                for (int z = 0; z < factor_; ++z) {
                    const Coord at(voxel[0] * factor_ + x, voxel[1] * factor_ + y, voxel[2] * factor_ + z);
                    const auto place = [&](int a, int k) { return voxel[a] + (k + 0.5) / factor_ - 0.5; };
                    openvdb::FloatTree::LeafNodeType& leaf = *tree_.probeLeaf(at);
                    const auto value =
                        float(f(double(leaf.getValue(at)), Vec3d(place(0, x), place(1, y), place(2, z))));
                    leaf.setValueOnly(at, value);
                    leaf.setActiveState(at, value > 0);
                    sum += double(value);
                }
        return sum;
    }

private:
    openvdb::FloatTree& tree_;
    int factor_;
};

}  // namespace

FloatGridPtr add_detail(const FloatGrid& coarse, const Vec3SGrid* velocity, const DetailOptions& o,
                        const Progress& progress)
{
    for (const GridBase* grid : {static_cast<const GridBase*>(&coarse), static_cast<const GridBase*>(velocity)})
        if (grid && !grid->transform().isLinear())
            throw InputError("grid '" + printable(grid->getName()) +
                             "' has a frustum (non-linear) transform: expected an affine one");
    const FloatGridPtr matter = matter_of(coarse), sharp = sharpened(*matter), amount = amounts(*matter, o.amount);
    const FloatGridPtr gain = matter->deepCopy();
    const Pattern pattern(o.factor, coarse.voxelSize() / double(o.factor), o.seed);
    const std::array<Phase, 2> phases = phases_at(o);
    report(progress, 0.1);

    const auto fine = FloatGrid::create(0.0f);
    fine->insertMeta(coarse);
    fine->setName(coarse.getName());
    fine->setGridClass(coarse.getGridClass());
    fine->setTransform(finer(coarse.transform(), o.factor));
    const FineVoxels voxels(*fine, o.factor);
    for (auto v = matter->cbeginValueOn(); v; ++v) voxels.touch(v.getCoord());

    // Detail, and what keeps the mean of each voxel.
    each_leaf(*gain, [&](auto& leaf) {
        const auto of_density = sharp->getConstAccessor(), of_amount = amount->getConstAccessor();
        const Flow flow(velocity, coarse.transform());
        for (auto v = leaf.beginValueOn(); v; ++v) {
            const Vec3d middle = v.getCoord().asVec3d();
            const Within density(of_density, v.getCoord(), Within::Voids::AreZero);
            const Within size(of_amount, v.getCoord(), Within::Voids::DoNotCount);
            const double sum = voxels.set(v.getCoord(), [&](double, const Vec3d& place) {
                const Vec3d speed = flow(place);
                double noise = 0;
                for (const Phase& phase : phases)
                    if (phase.weight > 0)
                        noise += phase.weight * pattern((place - phase.age * speed) * double(o.factor) + phase.place);
                return density.at(place - middle) * std::exp(size.at(place - middle) * noise);
            });
            v.setValue(sum > 0 ? float(std::log(double(*v) * voxels.count() / sum)) : 0.0f);
        }
    });
    report(progress, 0.7);
    each_leaf(*matter, [&](auto& leaf) {
        const auto of_gain = gain->getConstAccessor();
        for (auto v = leaf.cbeginValueOn(); v; ++v) {
            const Within factor(of_gain, v.getCoord(), Within::Voids::DoNotCount);
            const Vec3d middle = v.getCoord().asVec3d();
            const double sum = voxels.set(v.getCoord(), [&](double value, const Vec3d& place) {
                return value * std::exp(factor.at(place - middle));
            });
            const double rest = double(*v) * voxels.count() / sum;
            // Where all is lost to rounding, of the least densities that a float has, matter is even.
            voxels.set(v.getCoord(),
                       [&](double value, const Vec3d&) { return std::isfinite(rest) ? value * rest : double(*v); });
        }
    });
    report(progress, 1);
    return fine;
}

}  // namespace vdbcloud
