#pragma once
// Where rays meet solids.
#include "vdbcloud/core/affine.h"
#include "vdbcloud/scene/solid.h"

#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace vdbcloud {

/// The first point of a ray on a solid.
struct SolidHit {
    double t;       ///< [world unit]
    Vec3d normal;   ///< unit, outward, never along the ray
    Vec3d outside;  ///< the point, moved off the surface: rays from it start in the open
    size_t solid;   ///< its number
};

/// Solids, prepared for rays. A ray that starts within a solid meets it at once, at t = 0.
///
/// Planes, balls and boxes are met in closed form. The surface of a level set is where its trilinear interpolant is 0,
/// and a ray inside one cell meets it at a root of a cubic, found to rounding: no step size, any affine transform. The
/// interpolant is that of the values within the band; deeper inside and farther outside it is the band's width. The
/// normal of a level set is the gradient by central differences over a voxel to each side, so shading is continuous
/// from cell to cell.
/// OpenVDB's LevelSetRayIntersector is not used: it demands cubic voxels, one object a thread, takes a root by linear
/// interpolation between steps, and passes a surface that it does not begin outside of.
///
/// Threads: immutable.
class SolidRays {
public:
    /// Throws InputError as check() of each solid.
    explicit SolidRays(const std::vector<Solid>&);
    ~SolidRays();
    SolidRays(SolidRays&&) noexcept;

    bool empty() const { return solids_.empty(); }
    size_t count() const { return solids_.size(); }
    const Material& material(size_t solid) const { return solids_[solid].material; }

    /// The nearest hit before t1.
    std::optional<SolidHit> nearest(const WorldRay&, double t1 = std::numeric_limits<double>::infinity()) const;
    /// Whether any solid lies on the ray's first t1.
    bool blocked(const WorldRay&, double t1) const;
    /// Whether a point lies within a solid.
    bool inside(const Vec3d&) const;

    struct Shape;  ///< of each kind, in solid_rays.cc

private:
    std::vector<Solid> solids_;
    std::vector<std::unique_ptr<Shape>> shapes_;
};

}  // namespace vdbcloud
