#pragma once
// Where a scene emits, and directions that lead there. Private to render/.
#include "vdbcloud/optics/cell_march.h"
#include "vdbcloud/render/light_sampling.h"
#include "vdbcloud/render/media.h"

#include <vector>

namespace vdbcloud {

/// Points in proportion to emission: the mean of the eight corners of each cell, of the largest channel. Points in a
/// cell are uniform, so the density of a direction is a sum over the cells that a ray crosses.
/// Holds a pointer to the scene, which must outlive it. Immutable: share it between threads.
class EmissionField {
public:
    explicit EmissionField(const PreparedScene&);

    /// No volume emits.
    bool dark() const { return volumes_.empty(); }
    /// Whether rays from x meet emission often enough by chance: emission fills a tenth or more of the box about all
    /// emission, and x is closer to the box's centre than the box's diagonal. From beyond, the box covers 7 % of all
    /// directions or less.
    bool often_met(const Vec3d& x) const;
    /// Emission fills a tenth or more of its box, and nothing repeats: points that it lights are worth sampling by the
    /// distance from the box's centre.
    bool compact() const { return diagonal_ > 0; }
    const Vec3d& centre() const { return centre_; }
    /// Such points of t0..t1: by equal angles about the centre, as if the ray passed it at a quarter of the diagonal or
    /// more.
    EquiangularSampler lit(const WorldRay&, double t0, double t1) const;

    /// Whether point() and density() are worth calling for rays from x. False in a scene that repeats without end.
    bool sampled(const Vec3d& x) const { return total_ > 0 && !often_met(x); }
    /// The emitting volumes, as indices into the scene's volumes. `density` of such a volume is nonzero where it emits.
    const std::vector<size_t>& volumes() const { return volumes_; }

    /// A point, for numbers uniform in [0, 1): `u` chooses the cell, `in_cell` the place within.
    Vec3d point(double u, const Vec3d& in_cell) const;
    /// Density per solid angle with which the direction of `ray` is that from its origin to a point() [1/sr].
    double density(const WorldRay& ray) const;

private:
    struct Brick {
        size_t volume;
        Vec3i first;           // cell
        const float* corners;  // of its volume's `density`
        double cell_volume;    // [(world unit)^3]
    };

    const PreparedScene* scene_;
    std::vector<size_t> volumes_;
    std::vector<Brick> bricks_;
    std::vector<double> cumulative_;  // of bricks_, emission x (world unit)^3
    double total_ = 0;
    Vec3d centre_{0, 0, 0};  // of the box about all emission [world unit]
    double diagonal_ = 0;    // of the box; 0: emission fills less than a tenth
};

}  // namespace vdbcloud
