#pragma once
// The ground beneath a layer, as P1 and sweeps see it. Private to scatter/.
#include "vdbcloud/scatter/beam_medium.h"
#include "vdbcloud/scatter/planes.h"
#include "vdbcloud/sweep/transport_sweep.h"

namespace vdbcloud {

/// The face (Blocks::Face) of the index axis that looks down. Throws InputError for a grid without an axis along `up`.
int face_down(const VoxelIndex&, const Vec3d& up);

/// A Lambertian ground under a medium that repeats along both axes across `up`: the plane of the ActiveBox that faces
/// down. Cells are those of that plane (ActiveBox::cell). With D the direct and E the diffuse irradiance of a cell, the
/// cell's radiance is albedo (D + E) / pi.
///
/// P1: partial currents on the faces that lie on the ground. With J+ the diffuse light that leaves a face,
/// J- = albedo (J+ + D) comes back; Marshak's condition F = phi_b / 2 - 2 J- and F = J+ - J- give
///
///     F = (1 - albedo) / (1 + albedo) phi_b / 2 - 2 albedo D / (1 + albedo)
///
/// so a weight and a correction of the boundary (p1_problem.h). P1 takes no light to the ground through voids.
class GroundPlane {
public:
    /// Keeps a reference to `index`. Throws InputError for an albedo outside 0..1, for a grid without an axis along
    /// `up`, and for a medium that does not repeat along the other two axes, or repeats along `up`.
    GroundPlane(const VoxelIndex& index, const Vec3d& up, double albedo);

    int face() const { return face_; }  ///< Blocks::Face
    double albedo() const { return albedo_; }

    /// Sets ExposedVoxel::grounded.
    void mark(std::vector<ExposedVoxel>&) const;
    /// Throws InputError unless the medium's own faces cover the whole ground: P1 alone needs that.
    void require_cover() const;

    /// D of each cell from lights without extent, in channel c. Throws InputError for a light that is not above.
    std::vector<float> direct(const BeamMedium&, const std::vector<Light>&, int c) const;
    /// Adds the correction of the boundary: the beams' light that comes back. For P1 alone; sweeps bring their own.
    void add_direct(const P1Operator&, const std::vector<float>& direct, P1Source&) const;
    /// E of each cell in P1: J+.
    std::vector<float> irradiance(const P1Operator&, const P1Source&, const std::vector<double>& phi,
                                  const std::vector<float>& direct) const;
    /// The cells' sum times the area of a cell [radiance x (world unit)^2].
    double power(const std::vector<float>& cells) const;
    /// albedo (D + E) / pi.
    std::vector<float> radiance(const std::vector<float>& direct, const std::vector<float>& diffuse) const;
    /// The radiance of r, g, b, each times its scale, at the voxels of the layer beneath the medium's lowest, where the
    /// trilinear medium ends; repeated as far as grids of a periodic medium are. `transform`: the density's.
    Vec3SGridPtr grid(const std::array<const std::vector<float>*, 3>& radiance, const Vec3d& scale,
                      const Transform&) const;

private:
    const VoxelIndex& index_;
    ActiveBox box_;
    double albedo_;
    int face_;
};

}  // namespace vdbcloud
