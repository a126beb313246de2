#pragma once
// Diffuse power through the planes of the box about a medium's voxels: where light goes, not which way a face looks.
#include "vdbcloud/scatter/p1_problem.h"
#include "vdbcloud/scene/sky.h"
#include "vdbcloud/sweep/plane_light.h"

#include <numeric>
#include <optional>

namespace vdbcloud {

/// The hemisphere of directions about an axis.
class Hemisphere {
public:
    /// `axis`: along the index axes, of any length above 0.
    explicit Hemisphere(const Vec3d& axis) : axis_(axis.unit()) {}

    /// 1 for a direction within, 0 for one outside, 1/2 on the rim. [unit, along the index axes]
    double of_direction(const Vec3d& s) const
    {
        const double cosine = s.dot(axis_);
        return cosine > 1e-9 ? 1 : cosine < -1e-9 ? 0 : 0.5;
    }
    /// The part of the power of an even radiance that leaves through a face into the hemisphere: (1 + n.axis) / 2.
    double of_face(int face) const { return (1 + (face % 2 ? 1 : -1) * axis_[face / 2]) / 2; }

private:
    Vec3d axis_;
};

/// The hemisphere that light is reflected into: that about the direction to the sun, without a sun about `up` [world].
/// A medium that repeats sends no light out along its periodic axes, so its hemisphere is about the direction's part
/// across them: beneath any sun above it, a layer reflects what leaves upward.
Hemisphere reflected_into(const VoxelIndex&, const std::optional<Vec3d>& to_sun, const Vec3d& up);

/// Diffuse power through the planes of the ActiveBox, by Blocks::Face of the index axes [radiance x (world unit)^2].
/// Light of the sky that crosses the box without a collision counts on both sides; the beams of lights do not count. 0
/// across periodic axes. The powers balance as P1Budget does:
///
///     sum of out + reentered = sum of P1Budget::out - P1Budget::sky_in + sum of sky_in + from_ground
struct PlanePower {
    bool known = false;
    std::array<double, 6> out{};
    std::array<double, 6> sky_in{};
    /// P1 alone: power that leaves the medium and meets the medium again. P1 loses this power, sweeps carry it on.
    double reentered = 0;
    /// By a sweep: the light from the medium was multiplied by 1 + this so that the powers balance, for a sweep is not
    /// conservative.
    double scaled_by = 0;
    /// Of all `out`: into the hemisphere of reflected_into(). How much of light from the medium that is does not depend
    /// on the box. By sweeps the error is that of the quadrature over a half of its directions.
    double reflected = 0;
    double transmitted() const { return std::accumulate(out.begin(), out.end(), 0.0) - reflected; }
    /// Power that the ground sends up; of an endless ground what of it enters the box.
    double from_ground = 0;
};

/// The ground beneath a medium, for the powers of its plane.
struct PlaneGround {
    int face = -1;  ///< Blocks::Face; -1: no ground
    double albedo = 0;
    double direct = 0;    ///< power of the beams on the ground
    double diffuse = -1;  ///< power of diffuse light on the ground; below 0: that of the plane

    double up(double on_plane) const { return albedo * (direct + (diffuse < 0 ? on_plane : diffuse)); }
};

/// Where light goes that leaves a medium through its exposed faces, as shares of its power.
struct OutflowRays {
    double reentry = -1;  ///< meets an active voxel again; -1: not measured
    /// By plane: share that leaves through the plane, less the share that leaves the medium through faces that look the
    /// same way. The sum over the planes is -reentry.
    std::array<double, 6> moved{};
    /// The same for the sky's light on its straight way on from the exposed faces that it enters.
    std::array<double, 6> sky_moved{};
    /// The same of the hemisphere of `reflected`, less what would go there if each face shone evenly.
    double moved_ahead = 0, sky_moved_ahead = 0;
    size_t steps = 0;  ///< cells that the rays crossed: voxels, and empty cells of 8 x 16^k voxels
};

/// Traces `rays` rays from exposed faces, cosine-distributed about the surface normal; of all exposed voxels evenly
/// many are taken. With `flux` (cell_flux()) each ray has the weight of P1's radiance phi + 3 s.F along it, F shortened
/// to longest_flux x phi. `sky`, `channel`: the sky's radiance along the rays; null: no sky.
///
/// Error of a share q: statistical, sqrt(q (1 - q) / rays) at most, 0.0035 at 20000 rays; 0 for a layer, all of whose
/// light leaves through the faces that look its way. Deterministic.
OutflowRays trace_outflow(const P1Operator&, const P1Source&, const std::vector<double>& phi,
                          const std::array<std::vector<float>, 3>* flux, const Sky* sky, int channel, const Hemisphere&,
                          int rays);

/// P1's planes from the powers through its exposed faces and the way of the light from there. Requires a measured
/// OutflowRays.
PlanePower planes_by_rays(const P1Operator&, const P1Source&, const P1Budget&, const OutflowRays&, const Sky& sky,
                          int channel, const Hemisphere&, const PlaneGround& = {});

/// The planes of a sweep. The sum is that of the budget; how it is divided comes from the sweep. `reentry`: share of
/// the budget's outflow that is lost (P1 alone), 0 where the budget is that of sweeps. `scaled`: not beside solids,
/// which take light and send some into the planes: the sum is then the sweep's own.
PlanePower planes_by_sweep(const VoxelIndex&, const PlaneLight&, const P1Budget&, double reentry, const Hemisphere&,
                           const PlaneGround& = {}, bool scaled = true);

/// Power per area of the planes' cells as `power` has it: the light of a sweep, scaled. Requires PlaneLight::by_cell.
std::vector<float> plane_flux(const PlaneLight&, const PlanePower&, int face);

}  // namespace vdbcloud
