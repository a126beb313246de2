#pragma once
// Transmittance at points: depths through media, what solids hide, and the comparison with exact rays. Private to
// light/.
#include "vdbcloud/light/transmittance_grid.h"
#include "vdbcloud/optics/solid_rays.h"
#include "vdbcloud/voxels/brick_map.h"

#include <atomic>
#include <optional>

namespace vdbcloud {

/// Where transmittance is wanted, in the light grid's own index space, `refine` points a voxel of density: at the
/// leaves of `grid`, whose values mean nothing. Point n of leaf b is wanted where its bit is set.
struct WantedPoints {
    FloatGridPtr grid;
    int refine;
    std::vector<Vec3i> leaf;     // origins / 8
    std::vector<uint64_t> bits;  // 8 words of 64 a leaf
    int64_t voxels = 0;

    WantedPoints(const FloatGrid& density, int refine, const Period&);

    bool has(size_t n) const { return bits[n / 64] >> (n % 64) & 1; }

    /// Point n in the light grid's index space, integers.
    Vec3i point(size_t n) const
    {
        const int o = int(n % 512);
        return leaf[n / 512] * 8 + Vec3i(o >> 6, (o >> 3) & 7, o & 7);
    }
    Vec3d world(size_t n, const BrickMap& density) const
    {
        const Vec3i p = point(n);
        return density.world_from_index().point(Vec3d(p[0], p[1], p[2]) / refine);
    }
};

/// A medium that light crosses, as rays need it.
struct Crossed {
    const BrickMap& density;
    Vec3d sigma_t;  ///< extinction at density 1 [1/world unit]
    /// From a voxel of the wanted points' density to that place in `density`'s lattice; none: another lattice.
    std::optional<Vec3d> shift;
};

/// The mean over the light's parts of exp(-tau), 0 for those that solids hide, at all wanted points, `channels` values
/// a point. media[0] is the medium that the points belong to. Empty if `only_if_shaded` and no other medium shades a
/// point.
std::vector<float> find_transmittance(const std::vector<Crossed>& media,
                                      const std::vector<std::shared_ptr<const LightModel>>& parts, size_t channels,
                                      bool only_if_shaded, const SolidRays& solids, const TransmittanceOptions& o,
                                      const WantedPoints& wanted, const Progress& progress,
                                      std::atomic<size_t>* products = nullptr);

/// Compares with exact rays at voxels spread evenly over the targets.
void compare_with_rays(const BrickMap& density, const Medium& medium,
                       const std::vector<std::shared_ptr<const LightModel>>& parts, const SolidRays& solids,
                       const TransmittanceOptions& o, const WantedPoints& wanted,
                       const std::vector<float>& transmittance, size_t channels, TransmittanceReport& report);

/// WantedPoints points that none of the light reaches.
int64_t dark_points(const std::vector<float>& transmittance, size_t channels, const WantedPoints& wanted);

}  // namespace vdbcloud
