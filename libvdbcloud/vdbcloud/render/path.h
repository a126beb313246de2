#pragma once
// Unbiased light transport by paths from the camera: the reference for the other integrators. Private to render/.
#include "vdbcloud/optics/reflection.h"
#include "vdbcloud/render/emission_march.h"
#include "vdbcloud/render/path_end.h"
#include "vdbcloud/render/path_media.h"

namespace vdbcloud {

/// Estimates the radiance that arrives along rays in the true, unscaled medium. Each call is one sample; its mean is
/// the solution of the transport equation for the trilinear interpolant of the scene's grids. Nothing is clamped, and
/// paths have no largest length.
///
/// Method. The camera ray collides with certainty, weighted with its opacity, so that transmittance, alpha and
/// background need no sampling. At each collision a light is sampled with its transmittance marched exactly; the path
/// goes on by the phase function, with weight times the albedo, until it leaves the media, where it meets the sky, or
/// ends by Russian roulette.
///
/// Colour. A path has one hero channel, chosen in proportion to the channels' opacities on the camera ray, whose
/// extinction draws its free paths. `share` of a channel is the probability density of the path for that channel over
/// the sum of all three (balance heuristic), so weights are at most the sum of the three opacities.
/// Sources: Wilkie et al. 2014, "Hero Wavelength Spectral Sampling"; Miller et al. 2019, "A null-scattering path
/// integral formulation of light transport".
///
/// Lamps. The inverse square would give light sampled from collisions an infinite variance. Points that a lamp lights
/// are also sampled by equal angles on the camera ray, and beyond each collision on a ray that prefers the lamp's
/// direction (light_sampling.h); the balance heuristic joins both.
///
/// Emission is integrated times transmittance along whole rays (emission_march.h), not only up to their collisions: the
/// camera ray, the ray of each segment, and beyond each collision a ray towards a point that emits (emission_field.h).
/// The balance heuristic joins the two rays that leave a collision. So light behind deep matter is not left to paths
/// that get there by chance. Points that a compact body of emission lights are also sampled as those that a lamp
/// lights.
///
/// Surfaces: the ground and solids. Rays end on them. The part of the camera ray that passes the media goes on from the
/// surface as a path of its own, with the transmittance as weight. A path that reaches a surface samples each light
/// there and goes on as the surface reflects; from a mirror it goes on as the camera ray began.
///
/// Gathering. With `end`, a path has at most `vertices` - 1 collisions with media. At the last one it takes what the
/// picture without noise shows along the ray that the phase function draws (path_end.h): the last vertex as an
/// integral. The path itself is that of the true medium. Bias: the error of that picture, averaged over the directions
/// into which vertices - 1 collisions scatter.
///
/// Holds scratch memory: one object per thread.
class PathTracer {
public:
    /// `vertices` >= 2 counts with `end` alone.
    explicit PathTracer(const PathScene&, const PathEndScene* end = nullptr, int vertices = 0);

    /// One sample. Sets direct (scattered once, by light), multiple (the sky's light and all light scattered more than
    /// once), emission (not scattered), ground and solid (that left them towards the camera and was not scattered
    /// after), tau, true_tau, to_ground, hit, and cells, which counts collisions. A ray from beneath the ground sees
    /// nothing.
    void operator()(const WorldRay&, PathRandom, RayResult&);

private:
    /// Transmittance below which Russian roulette ends the march for emission: on rays that the phase function drew,
    /// and on rays that were drawn towards emission. A lower limit costs time in proportion to its logarithm on each
    /// ray.
    /// Only white mirrors that face each other show more images: the light of what lies behind these is lost.
    static constexpr int most_images = 256;
    static constexpr double dim_by_chance = 0.1, dim_on_purpose = 1e-4;

    /// A path up to its last collision.
    struct Path {
        int hero = 0;
        Vec3d weight{1, 1, 1};  // sum of the opacities times the albedos, over roulette's probabilities
        Vec3d share{1, 1, 1};   // of each channel's path density in the sum
        double start = 1;       // the sum of the opacities
        int collisions = 0;     // with media
        int images = 0;         // in mirrors

        Vec3d worth() const { return weight * share; }
    };

    /// The segment that a path is about to travel or has travelled, for the weights of lamps.
    struct Leg {
        double phase = 1;      // density of its direction; 1 for a camera ray
        Vec3d share{1, 1, 1};  // times the extinction and transmittance of each channel: density of a collision
        bool camera = true;
        bool image = false;             // it leaves a mirror: its direction was not drawn
        bool towards_emission = false;  // its start samples rays towards emission, too
        double seen = 1;                // the part of the emission seen along it that counts, as collide() returns it
        double near_emission = 0;       // density with which emission_on() samples its direction; 0: does not

        /// Density over the leg's points (and directions) with which a path collides.
        double density(const Vec3d& sigma_t, const Vec3d& transmittance) const
        {
            return phase * share.dot(sigma_t * transmittance);
        }
    };

    /// Whether the path's next collision is its last. Points that compact emission lights are then not sampled: the
    /// last ray shows their light.
    bool nears_end(const Path& path) const { return end_ && path.collisions + 2 == vertices_; }
    /// A point of the ground or of a solid.
    struct Surface {
        double t;
        Vec3d x, normal;
        const Material* material;
        bool solid;
    };
    std::optional<Surface> surface() const;
    void see_surface(const Surface&, const Vec3d& through, const Vec3d& direction, PathRandom&, RayResult&);
    void follow(Path, Vec3d x, Vec3d incoming, size_t v, double seen, PathRandom&, Vec3d& light, RayResult&);
    bool travel_on(Path&, const Leg&, Collision&, PathRandom&, Vec3d& light);
    bool collide_again(Path&, Leg&, Collision&, PathRandom&, Vec3d& light);
    bool meet_surface(const Surface&, Path&, Leg&, PathRandom&, Vec3d& light);
    bool see_image(const Surface&, const Vec3d& image, Path&, Leg&, PathRandom&, Vec3d& light);
    template<typename Scatter>
    Vec3d light_at(size_t light, const Vec3d& x, const Scatter&, PathRandom&);
    double density_of_lamp_sampling(size_t light, const Leg&, double t) const;
    Vec3d lamp_on(size_t light, const WorldRay&, const Leg&, double direction_density, PathRandom&);
    template<typename Scatter>
    Vec3d lamp_beyond(size_t light, const Vec3d& x, const Scatter&, const Path&, PathRandom&);
    double collide(const Collision&, const Leg&, Path&, PathRandom&, Vec3d& others, RayResult&);
    bool survives(Path&, PathRandom&) const;
    template<typename Scatter>
    Vec3d emission_beyond(const Vec3d& x, const Scatter&, const Path&, double seen, PathRandom&);
    double density_near_emission(const Vec3d& x, const Vec3d& direction) const;
    Vec3d emission_on(const WorldRay&, const Leg&, double direction_density, PathRandom&);
    Vec3d emission_at(const Vec3d& x, const Vec3d& incoming, const PreparedVolume&, PathRandom&);
    void attenuate(Path&, const Vec3d& factor) const;
    const RayResult& end_along(const WorldRay&, PathRandom&, RayResult&);
    void gather(const Path&, const Vec3d& x, const Vec3d& incoming, size_t v, PathRandom&, Vec3d& light, RayResult&);

    const PathScene& scene_;
    PathMedia media_, aside_;  // the path's ray; a ray towards a light or emission, or past a lamp
    EmissionMarch emission_;
    std::optional<PathEnd> end_;
    int vertices_ = 0;
    std::vector<double> depths_;
    std::vector<Vec3d> scattered_;  // of each volume
};

}  // namespace vdbcloud
