#pragma once
// What of a node's light leaves the node's own neighbourhood, by direction. Private to scatter/.
#include "vdbcloud/scatter/emission_tree.h"
#include "vdbcloud/scatter/segment_depth.h"

#include <atomic>
#include <memory>
#include <mutex>

namespace vdbcloud {

/// -ln of the mean over a node's parts of e^-tau, tau the depth from the part along a direction to the plane across it
/// at the node's reach. Parts are the nodes below that are optically thin, or at most 160.
///
/// Values are computed when first asked for, at directions through the vertices of a grid on the faces of a cube, and
/// interpolated between: a node serves many receivers. Threads: any number may ask; values do not depend on who asks
/// first.
class EmissionParts {
public:
    /// Keeps references to all arguments.
    EmissionParts(const VoxelIndex&, const EmissionTree&, const SegmentDepth&);

    /// `towards`: unit, from the node, along the index axes.
    double operator()(const EmissionNode&, const Vec3d& towards) const;

    /// Radius about the node's mean position that holds the node and a voxel about it [world unit].
    double reach(const EmissionNode&) const;
    /// From a point of the node [world unit] along a direction to the plane at the node's reach [world unit].
    Vec3d way_out(const EmissionNode&, const Vec3d& from, const Vec3d& towards) const;
    /// World position of a point in world units along the index axes.
    Vec3d world(const Vec3d& metric) const;

    /// Optical size above which a node's own extinction is taken by parts.
    static constexpr double thin = 0.2;

private:
    struct Node {
        std::once_flag once;
        std::vector<const EmissionNode*> parts;
        std::unique_ptr<std::atomic<float>[]> value;  // not a number: not computed
    };
    void start(const EmissionNode&, Node&) const;
    double at(const EmissionNode&, const Node&, const Vec3d& towards) const;

    const VoxelIndex& index_;
    const EmissionTree& tree_;
    const SegmentDepth& depth_;
    std::unique_ptr<Node[]> nodes_;
};

}  // namespace vdbcloud
