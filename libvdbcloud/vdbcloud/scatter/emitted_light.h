#pragma once
// Emission as a first-collision source: its light up to the first collision by rays, the rest for P1 and sweeps.
// Private to scatter/.
#include "vdbcloud/scatter/beam_medium.h"
#include "vdbcloud/scatter/planes.h"

namespace vdbcloud {

/// One channel's light of emission j up to its first collision, by rays (emission_gather.h).
///
/// Light that emitting voxels scatter comes from a small bright source too. So the rays' source Q is j and the
/// isotropic part of light that has collided within emitting voxels only, up to `collisions` times.
///
/// All of it is multiplied by 1 + scaled_by, so that the power that leaves through the planes of the box and the power
/// that collides add up to the power of Q.
struct EmittedLight {
    /// Moments of the light by harmonic, degree 0 to the last that scatters, at least 1, about the index axes.
    std::vector<std::vector<float>> moments;
    std::vector<float> fluence;    ///< sqrt(4 pi) times moments[0]
    std::vector<float> scattered;  ///< power that is scattered and not part of Q, per volume
    std::vector<float> absorbed;   ///< power that is absorbed, per volume
    /// What sweeps must scatter less than `moments` [radiance / world unit], so that their source has the power of
    /// `scattered`: Q - j, and the difference of the voxel's mean from its centre.
    std::vector<float> followed;
    /// w0' g' sigma_t' times the flux, along the index axes; empty where scattering is isotropic.
    std::array<std::vector<float>, 3> forward;
    std::array<std::vector<float>, 6> planes;  ///< power per area out through the cells of each plane
    std::array<double, 6> out_by_plane{};      ///< their powers
    std::array<double, 6> out_by_face{};       ///< the same power by the way that exposed faces look
    double reflected = 0;                      ///< of the same power: into the hemisphere of PlanePower::reflected
    double emitted = 0;                        ///< power of j
    double scaled_by = 0;
    int collisions = 0;
};

/// share_by_rays() of emission_cost.h; a voxel emits where one of the channels does.
double share_by_rays(const Blocks&, const std::vector<const std::vector<float>*>& emission);

/// The light of one to three channels of emission [radiance / world unit, by slot] in one medium. `scaled`: the
/// operator whose scaling separates collided and uncollided light; `medium`: of the same operator. Depths are shared by
/// the channels. Requires a medium that ends on all sides. Threads: parallel; values do not depend on their number.
std::vector<EmittedLight> emitted_light(const P1Operator& scaled, const BeamMedium& medium,
                                        const std::vector<const std::vector<float>*>& emission,
                                        const Hemisphere& reflected_into);

/// Adds the first-collision source and what the power balance needs. Keeps a reference to
/// `light.fluence`. The scaling of `p1` may be another than that of the light.
void add_emitted(const P1Operator& p1, const EmittedLight& light, P1Source&);

}  // namespace vdbcloud
