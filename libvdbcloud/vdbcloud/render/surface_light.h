#pragma once
// The rays of the integrators without noise, with what surfaces send along them: the ground and solids. Private to
// render/.
#include "vdbcloud/optics/reflection.h"
#include "vdbcloud/render/emission_field.h"
#include "vdbcloud/render/ground_light.h"
#include "vdbcloud/render/path_random.h"

#include <deque>

namespace vdbcloud {

/// A scene with its surfaces, shared by all threads.
struct SurfaceScene {
    /// Keeps references. Throws InputError as GroundLight.
    SurfaceScene(const Scene&, const PreparedScene&, const IntegratorOptions&);

    const PreparedScene& media;
    const IntegratorOptions& options;
    GroundLight ground;
    EmissionField emission;
    const Sky& sky;
};

/// Integrates along rays, and adds the light of the surface that ends them.
///
/// A point of a solid is lit by each light, through the true medium and past the other solids, exactly; and from all
/// directions above it by IntegratorOptions::solid_rays rays, drawn as the surface reflects, about the suns, and
/// towards points that emit (emission_field.h), of which each brings what this same integrator sees along it. Points
/// that such a ray meets draw one ray each, and Russian roulette by their colour ends the chain. So light between
/// solids, and between solids and media, is without bias against the light that the media scatter, whose accuracy is
/// that of the picture. A mirror draws one ray, to its image. Chains are cut at `longest`, which only white mirrors
/// that face each other reach. The media's light along such a ray has the whole phase function, so the beam that is
/// left is that of the true medium.
///
/// Holds scratch memory: one object per thread.
class SurfaceLight {
public:
    explicit SurfaceLight(const SurfaceScene&);

    void operator()(const WorldRay&, PathRandom, RayResult&);

private:
    static constexpr double aureole = 40;   // rays about suns have the density cos^aureole
    static constexpr size_t longest = 256;  // surfaces in a chain
    static constexpr size_t certain = 2;    // that roulette does not end

    /// The surfaces before a ray: all, and those that are no mirrors.
    struct Chain {
        size_t all = 0, spread = 0;
    };
    void march(const WorldRay&, PathRandom&, const Chain&, RayResult&);
    Vec3d shade(const WorldRay&, const SolidHit&, PathRandom&, const Chain&);
    Vec3d gathered(const Reflection&, const SolidHit&, int rays, PathRandom&, const Chain&);
    Vec3d about_sun(double u, double v) const;
    Vec3d towards_fire(const Vec3d& x, double u, double v, PathRandom&) const;
    double density_about_suns(const Vec3d&) const;
    Vec3d lit(const Reflection&, const Vec3d& x) const;
    Vec3d transmittance(const WorldRay&, double distance) const;
    Vec3d radiance(const WorldRay&, PathRandom&, const Chain&);

    const SurfaceScene& scene_;
    std::vector<Vec3d> suns_;  // about which rays are drawn
    std::unique_ptr<RayIntegrator> integrate_;
    uint64_t further_ = 0, cells_ = 0, lit_ = 0;  // of rays from solids
    std::deque<RayResult> results_;               // of each surface of a chain
};

}  // namespace vdbcloud
