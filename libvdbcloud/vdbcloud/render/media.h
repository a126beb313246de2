#pragma once
// A scene's grids made ready for rays: what the integrators sample.
#include "vdbcloud/optics/cell_march.h"
#include "vdbcloud/optics/phase_function.h"
#include "vdbcloud/render/forward_peak.h"
#include "vdbcloud/render/integrator.h"
#include "vdbcloud/voxels/brick_map.h"

#include <deque>
#include <memory>
#include <vector>

namespace vdbcloud {

/// One grid of the scene, shared by all rays. Members are null where the scene has no such grid.
struct PreparedVolume {
    explicit PreparedVolume(BrickMap map) : density(std::move(map)) {}

    BrickMap density;        ///< for emission alone: where it is not 0, with no extinction
    Vec3d sigma_t{0, 0, 0};  ///< extinction at density 1 [1/world unit]
    Vec3d albedo{1, 1, 1};
    PhaseFunction phase;
    DeltaScaling scaling;  ///< of the medium that phi, flux and moments belong to
    std::unique_ptr<BrickMap> colour, emission, phi, flux[3];
    /// Of degree 2 and more, sampled where phi is: r, g, b; r alone where all share one.
    std::vector<std::unique_ptr<BrickMap>> moments[3];
    Vec3d moment_scale{1, 1, 1};
    int degree = 1;                     ///< of the last of them
    std::unique_ptr<ForwardPeak> peak;  ///< of single scattering in a scaled medium with collided light
    std::vector<std::unique_ptr<BrickMap>> light_depth;  ///< -log T towards each light
};

struct PreparedScene {
    PreparedScene(const Scene&, const IntegratorOptions&);

    std::deque<PreparedVolume> volumes;
    std::vector<Light> lights;
    bool grey = true;          ///< one extinction for all channels, so one exponential
    bool scaled = false;       ///< some volume is seen delta-scaled
    bool shadow_rays = false;  ///< the light's depth by a ray at each point, not from a grid
};

/// The scene along one ray. Holds an index-space ray for each grid, so keep one per thread and set() it.
class RayMedia {
public:
    explicit RayMedia(const PreparedScene&);
    void set(const WorldRay&);

    const WorldRay& ray() const { return ray_; }
    const IndexRay& index_ray(size_t volume) const { return rays_[first_[volume]]; }
    /// The part of the ray, t >= 0, within which any volume can differ from 0; false if there is none.
    bool bounds(double& t0, double& t1) const;

    double density(size_t volume, double t) const;
    /// Optical depth from the ray's point at t to a light, over all volumes.
    Vec3d light_depth(size_t light, double t) const;
    Vec3d albedo(size_t volume, double t) const;
    Vec3d emission(size_t volume, double t) const;
    /// Collided light scattered towards the eye, per scattering coefficient: (phi + 3 m_1' s.F) / (4 pi) and, where
    /// there are higher moments, + sum over l >= 2 of m_l' Y_lm(s) M_lm; s towards the eye, m_l' the scaled moments of
    /// the phase function.
    Vec3d collided(size_t volume, double t) const;
    /// Extinction of the (scaled) medium per density, given its albedo there.
    Vec3d extinction(size_t volume, const Vec3d& albedo) const;
    /// Irradiance times phase function of a light for one volume, its mean over [t0, t1]. The inverse square of a point
    /// light is integrated in closed form.
    Vec3d arriving(size_t light, size_t volume, double t0, double t1) const;
    /// By what single scattering at t is multiplied for what the forward peak scatters again (forward_peak.h); y is the
    /// scaled optical depth from the light by way of t to the eye.
    Vec3d peak(size_t light, size_t volume, double t, const Vec3d& albedo, const Vec3d& y) const;

private:
    const IndexRay& ray_of(size_t volume, size_t map) const { return rays_[first_[volume] + map]; }
    double cosine(const Light&, double t) const;

    const PreparedScene& scene_;
    WorldRay ray_;
    std::vector<IndexRay> rays_;  // for each volume: density, colour, emission, phi, flux r g b, then the lights
    std::vector<size_t> first_;
    std::vector<std::vector<double>> weights_;  // of each volume's moments for this ray
};

/// What one ray gathers. Radiances are premultiplied and without background.
struct RayResult {
    std::vector<Vec3d> direct;  ///< one for each light
    Vec3d multiple{0, 0, 0};
    Vec3d emission{0, 0, 0};
    Vec3d tau{0, 0, 0};       ///< optical depth of the whole ray, in the scaled medium if there is one
    Vec3d true_tau{0, 0, 0};  ///< the same without scaling
    double half_way = 1e30;   ///< t at which the mean transmittance falls to 0.5
    uint64_t cells = 0;
    bool converged = true;

    void clear(size_t lights);
};

/// The integrators: from a ray to its result. One object a thread.
class RayIntegrator {
public:
    virtual ~RayIntegrator() = default;
    virtual void operator()(const WorldRay&, RayResult&) = 0;
};

std::unique_ptr<RayIntegrator> make_cells_integrator(const PreparedScene&, const IntegratorOptions&);
std::unique_ptr<RayIntegrator> make_romberg_integrator(const PreparedScene&, const IntegratorOptions&);
std::unique_ptr<RayIntegrator> make_steps_integrator(const PreparedScene&, const IntegratorOptions&);

}  // namespace vdbcloud
