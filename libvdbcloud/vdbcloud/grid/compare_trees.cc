#include "vdbcloud/grid/compare_trees.h"

#include "vdbcloud/core/vdb.h"

#include <openvdb/tree/ValueAccessor.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

namespace vdbcloud {

namespace {

using openvdb::Coord;

double square(double x) { return x * x; }

template<typename T>
double square_of(const T& x)
{
    return square(double(x));
}
template<typename T>
double square_of(const openvdb::math::Vec3<T>& x)
{
    return square(double(x[0])) + square(double(x[1])) + square(double(x[2]));
}

double component_difference(double a, double b)
{
    if (a == b || (std::isnan(a) && std::isnan(b))) return 0;
    const double d = std::abs(a - b);
    return std::isfinite(d) ? d : std::numeric_limits<double>::infinity();
}

template<typename T>
double difference(const T& a, const T& b)
{
    return component_difference(double(a), double(b));
}
template<typename T>
double difference(const openvdb::math::Vec3<T>& a, const openvdb::math::Vec3<T>& b)
{
    double sum = 0;
    for (int c = 0; c < 3; ++c) sum += square(component_difference(double(a[c]), double(b[c])));
    return std::sqrt(sum);
}

/// Visits boxes of the standard tree (4096, 128 and 8 voxels wide) and descends until both trees are constant.
template<typename TreeT>
class Walk {
public:
    using Value = typename TreeT::ValueType;
    using Leaf = typename TreeT::LeafNodeType;
    static_assert(TreeT::DEPTH == 4 && Leaf::DIM == 8 && TreeT::RootNodeType::ChildNodeType::DIM == 4096);

    Walk(const TreeT& a, const TreeT& b, TreeDifference& result) : a_(a), b_(b), result_(result)
    {
        std::set<Coord> origins;
        for (const TreeT* tree : {&a, &b}) {
            for (auto it = tree->root().cbeginChildOn(); it; ++it) origins.insert(it.getCoord());
            for (auto it = tree->root().cbeginValueOn(); it; ++it) origins.insert(it.getCoord());
        }
        for (const Coord& origin : origins) box(origin, 3);
        result_.background = difference(a.background(), b.background());
    }

private:
    /// `level` 3, 2, 1: a box of 4096^3, 128^3 or 8^3 voxels, the extent of a node at this level of the tree.
    void box(const Coord& origin, int level)
    {
        static constexpr int width[] = {1, 8, 128, 4096};
        if (a_.getValueDepth(origin) <= 3 - level && b_.getValueDepth(origin) <= 3 - level) {
            add(origin, a_.getValue(origin), b_.getValue(origin), a_.isValueOn(origin), b_.isValueOn(origin),
                uint64_t(width[level]) * width[level] * width[level]);
        } else if (level == 1) {
            leaf(origin);
        } else {
            const int step = width[level - 1], count = width[level] / step;
            for (int i = 0; i < count; ++i)
                for (int j = 0; j < count; ++j)
                    for (int k = 0; k < count; ++k) box(origin.offsetBy(i * step, j * step, k * step), level - 1);
        }
    }

    void leaf(const Coord& origin)
    {
        const Leaf *p = a_.probeConstLeaf(origin), *q = b_.probeConstLeaf(origin);
        const Value constant_a = a_.getValue(origin), constant_b = b_.getValue(origin);
        const bool on_a = a_.isValueOn(origin), on_b = b_.isValueOn(origin);
        const TreeDifference before = result_;
        result_.sum_squares = result_.sum_squares_a = 0;  // partial sums per leaf, against rounding in large grids
        for (openvdb::Index n = 0; n < Leaf::SIZE; ++n)
            add(p ? p->offsetToGlobalCoord(n) : q->offsetToGlobalCoord(n), p ? p->getValue(n) : constant_a,
                q ? q->getValue(n) : constant_b, p ? p->isValueOn(n) : on_a, q ? q->isValueOn(n) : on_b, 1);
        result_.sum_squares += before.sum_squares;
        result_.sum_squares_a += before.sum_squares_a;
    }

    void add(const Coord& at, const Value& a, const Value& b, bool on_a, bool on_b, uint64_t voxels)
    {
        if (!on_a && !on_b) return;
        const double d = difference(a, b);
        result_.voxels += voxels;
        result_.only_a += on_b ? 0 : voxels;
        result_.only_b += on_a ? 0 : voxels;
        result_.sum_squares += square(d) * double(voxels);
        result_.sum_squares_a += square_of(a) * double(voxels);
        if (d > result_.max) {
            result_.max = d;
            result_.where = {at.x(), at.y(), at.z()};
        }
    }

    openvdb::tree::ValueAccessor<const TreeT> a_, b_;
    TreeDifference& result_;
};

template<typename TreeT>
bool compared(const openvdb::TreeBase& a, const openvdb::TreeBase& b, TreeDifference& result)
{
    const auto *p = dynamic_cast<const TreeT*>(&a), *q = dynamic_cast<const TreeT*>(&b);
    if (!p || !q) return false;
    const Walk<TreeT> walk(*p, *q, result);
    return true;
}

template<typename... Trees>
bool any(const openvdb::TreeBase& a, const openvdb::TreeBase& b, TreeDifference& result)
{
    return (compared<Trees>(a, b, result) || ...);
}

}  // namespace

bool compare_trees(const openvdb::TreeBase& a, const openvdb::TreeBase& b, TreeDifference& result)
{
    using namespace openvdb;
    return any<FloatTree, Vec3STree, DoubleTree, BoolTree, MaskTree, Int32Tree, Int64Tree, Vec3DTree, Vec3ITree>(
        a, b, result);
}

}  // namespace vdbcloud
