#pragma once
// A scene's grids, prepared for sampling along rays by the integrators. Private to render/.
#include "vdbcloud/optics/cell_march.h"
#include "vdbcloud/optics/phase_function.h"
#include "vdbcloud/optics/solid_rays.h"
#include "vdbcloud/render/forward_peak.h"
#include "vdbcloud/render/integrator.h"
#include "vdbcloud/voxels/brick_map.h"
#include "vdbcloud/voxels/field_bricks.h"

#include <deque>
#include <memory>
#include <optional>
#include <vector>

namespace vdbcloud {

/// One volume of the scene, shared by all rays. Pointers are null where the scene has no such grid.
struct PreparedVolume {
    explicit PreparedVolume(BrickMap map) : density(std::move(map)) {}
    /// False for a volume of emission only.
    bool is_medium() const { return sigma_t != Vec3d(0); }

    /// For a volume of emission only: the region where emission is nonzero, without extinction.
    BrickMap density;
    /// First and last cell (inclusive) of the box about the active voxels, one period along periodic axes. Unlike the
    /// box about the map's bricks, this box does not depend on where leaf blocks cut the medium.
    Vec3i first_cell{0, 0, 0}, last_cell{-1, -1, -1};
    Vec3d sigma_t{0, 0, 0};  ///< extinction at density 1 [1/world unit]
    Vec3d albedo{1, 1, 1};
    PhaseFunction phase;
    DeltaScaling scaling;  ///< of the medium that phi, flux and moments belong to
    std::unique_ptr<BrickMap> colour, emission;
    /// Collided light: phi, flux and moments of degree 2 and higher of r, g, b, each r, g, b times channel_scale. Where
    /// channels share a solution phi has one channel and only r's flux and moments are there.
    /// Volumes that overlap share them.
    std::shared_ptr<const BrickMap> phi, flux[3];
    std::vector<std::shared_ptr<const BrickMap>> moments[3];
    Vec3d channel_scale{1, 1, 1};
    double flux_limit = 0;  ///< largest |flux| / phi that is gathered; 0: any
    int degree = 1;         ///< highest degree of the moments
    /// Factor of single scattering, for a scaled medium with collided light.
    std::unique_ptr<ForwardPeak> peak;
    /// -log T towards each light through all volumes; known where density differs from 0.
    std::vector<std::shared_ptr<const BrickMap>> light_depth;
    /// Of each light that a solid hides from some voxel: 1 where the light is seen, 0 where it is hidden; light_depth
    /// is then 0 at hidden voxels. Null for others.
    std::vector<std::unique_ptr<BrickMap>> seen;
    /// In a plain scene (plain_cells.h), instead of light_depth, phi, flux and moments: depths of the lights, phi,
    /// fluxes and moments. Where flux and moments of the channels begin; -1: there is none.
    std::unique_ptr<FieldBricks> fields;
    int field_channels = 0, field_flux[3] = {-1, -1, -1}, field_moments = -1;
};

/// Albedo of a volume at a point of the colour grid's index space: the medium's, tinted by Cd, within [0, 1].
Vec3d albedo_at(const PreparedVolume&, const Vec3d& colour_index);

struct PreparedScene {
    PreparedScene(const Scene&, const IntegratorOptions&);

    std::deque<PreparedVolume> volumes;
    bool repeats = false;  ///< along some axes, without end
    std::vector<Light> lights;
    std::vector<std::vector<Light>> points;  ///< of each light: lights without extent whose sum is the light
    /// Of each light: where it is if it is a lamp. Within `near` of it depth comes from rays, not from grids: depth has
    /// a cusp at the lamp, and its interpolant exceeds it by h^2 / (6 r) in the mean, 2 % of a voxel at the distance
    /// near.
    std::vector<std::optional<Vec3d>> lamp;
    std::shared_ptr<const SolidRays> solids;  ///< null: none
    double near = 0;                          ///< [world]; 0 where rays do not know the extinction along their way
    bool grey = true;                         ///< all channels share one extinction: one exponential suffices
    bool scaled = false;                      ///< at least one volume is rendered delta-scaled
    bool shadow_rays = false;                 ///< depth towards lights by shadow rays, not from grids
};

/// The scene along one ray. Holds an index-space ray per grid: keep one object per thread and call set() for each ray.
class RayMedia {
public:
    explicit RayMedia(const PreparedScene&);
    void set(const WorldRay&);

    const WorldRay& ray() const { return ray_; }
    /// Where the ray ends on a solid, and the distance to there: infinity where it does not.
    const std::optional<SolidHit>& hit() const { return hit_; }
    double stop() const { return hit_ ? hit_->t : std::numeric_limits<double>::infinity(); }
    const IndexRay& index_ray(size_t volume) const { return rays_[first_[volume]]; }
    /// The part of the ray, t >= 0, within which any volume can differ from 0; false if there is none. t1 is at most
    /// end().
    bool bounds(double& t0, double& t1) const;
    /// Beyond this distance no source is visible: stop(), and in media that repeat where the optical depth of a volume
    /// exceeds `opaque`.
    double end() const;

    double density(size_t volume, double t) const;
    /// Optical depth from the ray's point at t to a light, through all volumes, for light that `volume` scatters.
    /// Without shadow rays the point must lie where the density of `volume` differs from 0.
    Vec3d light_depth(size_t light, size_t volume, double t) const;
    /// Where to cut the stretch [t0, t1] of the ray, ascending, so that no part is longer than `longest` times its
    /// distance from any lamp: irradiance, direction and depth of a lamp change little within a part. Empty far away.
    void cuts_by_lamps(double t0, double t1, double longest, std::vector<double>& cuts) const;
    Vec3d albedo(size_t volume, double t) const;
    Vec3d emission(size_t volume, double t) const;
    /// Collided light scattered towards the eye, per scattering coefficient: (phi + 3 m_1' s.F) / (4 pi), F shortened
    /// to flux_limit x phi, and, where there are higher moments, + sum over l >= 2 of m_l' Y_lm(s) M_lm; s towards the
    /// eye, m_l' the scaled moments of the phase function.
    Vec3d collided(size_t volume, double t) const;
    /// Extinction per density of the medium (scaled where delta scaling applies) at the given albedo.
    Vec3d extinction(size_t volume, const Vec3d& albedo) const;
    /// Mean over [t0, t1] of a light's irradiance times the phase function of one volume, its mean over the disc. The
    /// inverse square of a point light is integrated in closed form.
    Vec3d arriving(size_t light, size_t volume, double t0, double t1) const;
    /// Cosine of the angle between a light at infinity's light and its way to the eye.
    double cosine(size_t light) const { return cosine(scene_.lights[light], 0); }
    /// Factor of single scattering at t that accounts for repeated scattering by the forward peak (forward_peak.h).
    /// x: scattering depth from the light to the point at t and on to the eye, of a medium with the volume's peak.
    Vec3d peak(size_t light, size_t volume, double t, const Vec3d& x) const;

private:
    const IndexRay& ray_of(size_t volume, size_t map) const { return rays_[first_[volume] + map]; }
    double cosine(const Light&, double t) const;
    /// As light_depth(), by rays to each point of the light, the mean of their transmittances.
    Vec3d shadow_depth(size_t light, double t) const;

    const PreparedScene& scene_;
    WorldRay ray_;
    std::optional<SolidHit> hit_;
    std::vector<IndexRay> rays_;  // for each volume: density, colour, emission, phi, flux r g b, then the lights
    std::vector<size_t> first_;
    std::vector<std::vector<double>> weights_;  // m_l' Y_lm(s) of each volume's moments
};

/// Result of one ray. Radiances are premultiplied and exclude the background.
struct RayResult {
    std::vector<Vec3d> direct;  ///< single scattering, by light
    Vec3d multiple{0, 0, 0};
    Vec3d emission{0, 0, 0};
    Vec3d ground{0, 0, 0};        ///< from the ground
    Vec3d solid{0, 0, 0};         ///< from solids
    std::optional<SolidHit> hit;  ///< where the ray meets a solid
    double to_ground =
        1e30;            ///< t at which the ray meets the ground or a solid, which hide what is behind; 1e30: nowhere
    Vec3d tau{0, 0, 0};  ///< optical depth of the whole ray, scaled where delta scaling applies
    Vec3d true_tau{0, 0, 0};           ///< optical depth of the whole ray, unscaled
    double half_way = 1e30;            ///< t at which the mean transmittance falls to 0.5
    uint64_t cells = 0, lit = 0;       ///< as RenderCost
    uint64_t ends = 0, end_cells = 0;  ///< as RenderCost
    uint64_t further = 0;              ///< rays from solids, whose cells are among `cells`
    bool converged = true;

    void clear(size_t lights);
};

/// Integrates light along rays. Use one object per thread.
class RayIntegrator {
public:
    virtual ~RayIntegrator() = default;
    virtual void operator()(const WorldRay&, RayResult&) = 0;
};

/// Any of those below, by `kind`.
std::unique_ptr<RayIntegrator> make_integrator(const PreparedScene&, const IntegratorOptions&);
std::unique_ptr<RayIntegrator> make_cells_integrator(const PreparedScene&, const IntegratorOptions&);
std::unique_ptr<RayIntegrator> make_romberg_integrator(const PreparedScene&, const IntegratorOptions&);
std::unique_ptr<RayIntegrator> make_steps_integrator(const PreparedScene&, const IntegratorOptions&);

}  // namespace vdbcloud
