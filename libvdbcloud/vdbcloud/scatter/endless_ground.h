#pragma once
// The endless ground beneath a medium that ends on all sides, as P1 and sweeps see it. Private to scatter/.
#include "vdbcloud/scatter/beam_medium.h"
#include "vdbcloud/scatter/ordinates.h"
#include "vdbcloud/scatter/p1_problem.h"
#include "vdbcloud/scene/sky.h"
#include "vdbcloud/sweep/transport_sweep.h"

namespace vdbcloud {

/// A Lambertian ground, without end, one voxel below the centres of the medium's lowest voxels. Without the medium its
/// irradiance E0 is that of the suns and of the sky, the same everywhere, and its radiance albedo E0 / pi lights the
/// medium as a sky below the horizon does. The medium changes the irradiance on a patch: suns by T - 1, T their
/// transmittance, and diffuse light by the medium's own less the sky's that it hides. The patch reaches `margin`
/// heights of the medium beyond the medium's box, and to the end of the suns' shadows, as far as `longest_shadow`
/// heights. What the medium changes beyond the patch is left out.
///
/// Cells of the patch have an edge of 1, 2, 4 ... voxels: the least with which they are no more than the medium's
/// voxels, or than `least_cells`.
class EndlessGround {
public:
    static constexpr double margin = 2, longest_shadow = 16;
    static constexpr size_t least_cells = size_t(1) << 16;

    /// Keeps references to `index` and `lights`. Throws InputError for an albedo outside 0..1, for a grid without an
    /// axis along `up`, and for a light that is no sun above the ground.
    EndlessGround(const VoxelIndex& index, const Vec3d& up, double albedo, const std::vector<Light>& lights,
                  const Sky& sky);

    double albedo() const { return albedo_; }
    const GroundPatch& patch() const { return patch_; }
    const Vec3d& radiance() const { return radiance_; }  ///< albedo E0 / pi

    /// Adds J / pi of that radiance on faces of each orientation: radiance (1 - n.up) / 2.
    void add_on_faces(int channel, std::array<double, 6>& radiance) const;
    /// Adds that radiance along the directions of travel (components along the index axes) that go up.
    void add_along(int channel, const std::vector<Vec3d>& travel, std::vector<float>& radiance) const;

    /// Rays that swept() follows towards the suns.
    double rays() const { return double(patch_.cells()) * parts() * parts() * double(lights_.size()); }

    /// The ground as a sweep meets it; `direct` is the change of the suns' irradiance.
    SweepGround swept(const BeamMedium&, int channel) const;
    /// albedo / pi times the change of direct and diffuse irradiance.
    std::vector<float> radiance_change(const std::vector<float>& direct, const std::vector<float>& diffuse) const;
    /// Adds the patch's light to P1's boundary: J on each exposed face, by the directions of `set`. The medium itself
    /// is not in its way, as P1's sky knows no shadow.
    void add_to(const P1Operator&, const std::vector<float>& radiance_change, const Ordinates& set, P1Source&) const;
    /// The cells' sum times the area of a cell [radiance x (world unit)^2].
    double power(const std::vector<float>& cells) const;
    /// The radiance of r, g, b at the middles of the cells, from its changes, each times its scale. Background is
    /// radiance(). `transform`: the density's.
    Vec3SGridPtr grid(const std::array<const std::vector<float>*, 3>& change, const Vec3d& scale,
                      const Transform&) const;

private:
    void set_patch(const Vec3d& up);
    /// Rays along the edge of a cell: a shadow may be smaller than a cell.
    int parts() const { return patch_.edge < 4 ? patch_.edge : 4; }

    const VoxelIndex& index_;
    const std::vector<Light>& lights_;
    double albedo_;
    Vec3d up_, radiance_{0, 0, 0};
    GroundPatch patch_;
};

}  // namespace vdbcloud
