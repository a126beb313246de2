#pragma once
// The true medium of a scene, as light paths ask for it: free paths, optical depths, coefficients at a point. Private
// to render/.
#include "vdbcloud/render/emission_field.h"
#include "vdbcloud/render/media.h"
#include "vdbcloud/render/null_collisions.h"
#include "vdbcloud/render/path_random.h"

#include <array>
#include <vector>

namespace vdbcloud {

/// exp(-tau) of each channel; one exponential where the channels are equal.
Vec3d attenuation(const Vec3d& tau);

/// A scene without light grids, collided light and delta scaling, shared by all threads.
struct PathScene {
    explicit PathScene(const Scene&);
    PathScene(const PathScene&) = delete;  // `collisions` and `emission` point into `media`
    PathScene& operator=(const PathScene&) = delete;

    PreparedScene media;                     ///< no lights, no scaling
    std::vector<NullCollisions> collisions;  ///< of each volume of media
    std::vector<Light> lights;
    std::vector<char> is_lamp;  ///< for each light: it has a source() at a finite distance
    Sky sky;                    ///< lights the media; dark: does not
    std::optional<Ground> ground;
    Material of_ground;      ///< the ground as a surface; media has the solids
    EmissionField emission;  ///< of media
    bool has_lamp = false;
};

/// A collision of a path with one of the volumes.
struct Collision {
    double t = 0;  ///< [world unit]
    size_t volume = 0;
    double density = 0;  ///< of the volume there
};

/// One ray through all volumes. Use one object per thread and call set() for each ray.
///
/// Volumes have independent free paths, and the shortest decides where the ray collides and with which volume: their
/// sum is then distributed as that of the medium of added coefficients, and no bound of the sum is needed.
class PathMedia {
public:
    explicit PathMedia(const PathScene&);

    void set(const WorldRay&);
    const WorldRay& ray() const { return ray_; }
    /// Where the ray ends on a solid, and the distance to there: infinity where it does not. Nothing below looks
    /// beyond.
    const std::optional<SolidHit>& hit() const { return hit_; }
    double stop() const { return hit_ ? hit_->t : std::numeric_limits<double>::infinity(); }

    const IndexRay& index_ray(size_t volume) const { return index_[volume]; }

    /// Optical depth of t0..t1; t1 may be infinite.
    Vec3d optical_depth(double t0, double t1) const;
    /// Where a medium that repeats is opaque in all channels, or the ray ends.
    double end() const;
    /// The part of the ray that can meet extinction; false if there is none.
    bool bounds(double& t0, double& t1) const;
    double density(size_t volume, double t) const;
    Vec3d albedo(size_t volume, double t) const;

    /// The first collision for the extinction of one channel, by null collisions; false if the ray leaves the media.
    bool collide(int channel, PathRandom&, Collision&) const;
    /// The first collision of a ray that is known to collide: collide() conditioned on true, by inversion of the
    /// optical depth. `depths`: density depth of the whole ray in each volume, from depths().
    bool collide_surely(int channel, const std::vector<double>& depths, PathRandom&, Collision&) const;
    /// Density depth of the whole ray in each volume; in a periodic medium up to where the volume is opaque.
    void depths(std::vector<double>&) const;

    /// Transmittance over the ray's first `distance`, in the mean; 0 where a solid is in the way. Where every channel
    /// is below 0.3 the march ends at random, with a probability that keeps the mean (Russian roulette).
    Vec3d transmittance(double distance, PathRandom&) const;

private:
    /// The collision with volume v at a density depth of `depth`, if that lies before t1.
    bool meet(size_t v, double depth, double t1, Collision&) const;
    /// The first collision with volume v before t1.
    bool meet(size_t v, int channel, double t1, PathRandom&, Collision&) const;

    const PathScene& scene_;
    WorldRay ray_;
    std::optional<SolidHit> hit_;
    std::vector<IndexRay> index_;  // into the density of each volume
};

}  // namespace vdbcloud
