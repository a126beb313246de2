#pragma once
// Opaque surfaces that end the light of a sweep and send light of their own into it.
#include "vdbcloud/core/fwd.h"
#include "vdbcloud/voxels/blocks.h"

#include <cstdint>
#include <limits>
#include <vector>

namespace vdbcloud {

/// Surfaces of opaque bodies on the blocks of a medium: voxels that light does not pass, and elements of surface.
///
/// A sweep gives an opaque voxel the radiance that its elements send along a direction s: the mean of theirs, weighted
/// with max(0, s.n); where all of them look away, their plain mean; 0 for a voxel without elements, deep inside. So a
/// body that is thinner than two voxels has the light of either side on that side. Bodies between the centres of voxels
/// are not seen. The light on an element is that at the centre of the voxel before it: first order in the voxel.
struct SweepWalls {
    static constexpr uint32_t nowhere = std::numeric_limits<uint32_t>::max();
    struct Element {
        Vec3d normal;      ///< unit, outward, components along the index axes
        uint32_t outside;  ///< slot of the voxel before it; nowhere: it gathers no light
    };
    struct Voxel {
        uint32_t slot, first, count;  ///< its elements, in `seen`
    };
    std::vector<Element> elements;
    std::vector<Voxel> voxels;   ///< by slot, none of them active
    std::vector<uint32_t> seen;  ///< elements, voxel by voxel

    /// Fills what follows from the above.
    void sort(const Blocks&);
    std::vector<uint32_t> voxels_of,
        elements_of;               ///< where each block's begin in `voxels` and in `before`, and the end
    std::vector<uint32_t> before;  ///< elements that gather light, by the block of `outside`
};

/// One channel's light on walls: radiance that elements send, alike into all directions; and, of the last sweep, what
/// they receive, the sum over directions of weight x max(0, -s.n) x L, times pi over that of L = 1.
struct WallLight {
    const SweepWalls* walls = nullptr;
    std::vector<float> radiance, irradiance;

    /// Of an opaque voxel along a direction of travel (components along the index axes).
    float along(const SweepWalls::Voxel&, const Vec3d& direction) const;
};

/// The sums of a sweep. Threads: add() for different blocks.
class WallSums {
public:
    explicit WallSums(WallLight& of) : of_(of), sum_(of.walls->elements.size(), 0.0), unit_(sum_) {}
    const WallLight& light() const { return of_; }
    bool any(size_t block) const
    {
        const auto& walls = *of_.walls;
        return walls.voxels_of[block] != walls.voxels_of[block + 1] ||
               walls.elements_of[block] != walls.elements_of[block + 1];
    }
    /// `radiance(slot in the block)` along a direction.
    template<typename Radiance>
    void add(size_t block, const Vec3d& direction, double weight, const Radiance& radiance)
    {
        const auto& walls = *of_.walls;
        for (uint32_t n = walls.elements_of[block]; n < walls.elements_of[block + 1]; ++n) {
            const uint32_t e = walls.before[n];
            const double power = -weight * direction.dot(walls.elements[e].normal);
            if (!(power > 0)) continue;
            sum_[e] += power * radiance(walls.elements[e].outside % Blocks::size);
            unit_[e] += power;
        }
    }
    /// Sets WallLight::irradiance; that of elements that gather nothing is kept.
    void write();

private:
    WallLight& of_;
    std::vector<double> sum_, unit_;
};

}  // namespace vdbcloud
