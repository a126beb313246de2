#pragma once
// What is behind the medium: nothing, one radiance, or a sky, by one interface for all kinds, and how a sky travels in
// a file.
//
// A new kind of sky is a file of its own, as gradient_sky.cc and preetham.cc, a name in sky_kinds.h and in the table of
// sky.cc. Metadata, digests, light and pictures use this interface and need no change.
#include "vdbcloud/core/fwd.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdbcloud {

class Light;
class Panorama;
struct GridFile;

/// Radiance from a part of the sphere: its mean over the part.
struct SkyPart {
    Vec3d direction, radiance;
    double solid_angle;
};

/// The radiance of one sky in world space, a function of direction. Directions are unit and point AWAY from the viewer:
/// a camera ray's, against the light's propagation. Immutable, so any number of threads may use it.
class SkyModel {
public:
    virtual ~SkyModel() = default;

    virtual Vec3d radiance(const Vec3d& direction) const = 0;

    /// The mean of the radiance over the half of directions with dot(w, normal) > 0, weighted with that cosine: pi
    /// times it is the irradiance of a surface that looks along `normal` (unit). Exact for a constant sky, else with a
    /// relative error that the kind's file says.
    virtual Vec3d mean_inflow(const Vec3d& normal) const = 0;

    /// Colours whose channels stand in one ratio exactly where the radiance's do, everywhere; all 0 for a black sky.
    virtual std::vector<Vec3d> tones() const = 0;

    /// The same in all directions: `up` does not matter.
    virtual bool uniform() const { return false; }

    /// Parts that cover the sphere, for a sky with detail that a few directions would miss; empty for a smooth one.
    virtual const std::vector<SkyPart>& parts() const
    {
        static const std::vector<SkyPart> none;
        return none;
    }
};

/// A number or a colour of a kind of sky.
struct SkyParameter {
    const char* name;    ///< in messages
    const char* key;     ///< metadata (grid/scatter_schema.h)
    bool vector;         ///< a colour or a direction; else one number, which is then all three components
    double otherwise;    ///< where no value is given; NaN: the first parameter
    double least, most;  ///< limits, inclusive; values must also be finite
};

/// What a model is made of. With `ends_at_horizon` it is dark below the horizon, where a ground hides the sky.
struct SkyDescription {
    Vec3d up;  ///< unit
    std::vector<Vec3d> parameters;
    bool ends_at_horizon;
    std::shared_ptr<const Panorama> map;  ///< of an environment
};

/// A kind of sky: its words, metadata and parameters, and how to make its field.
struct SkyKind {
    const char* word;  ///< in metadata
    std::vector<SkyParameter> parameters;
    std::shared_ptr<const SkyModel> (*model)(const SkyDescription&);
};

/// Radiance that changes with height alone. With s = dot(w, up):
///
///     s >= 0:  L = zenith + (horizon - zenith) (1 - s)^haze
///     s <  0:  L = ground + (horizon - ground) (1 + s)^haze
///
/// Continuous at the horizon. All three colours equal: a constant background.
struct GradientSky {
    Vec3d zenith{0, 0, 0}, horizon{0, 0, 0}, ground{0, 0, 0};
    double haze = 4;    ///< how narrow the band along the horizon is, >= 0; 4: half gone 9 degrees above it
    Vec3d up{0, 1, 0};  ///< any length

    /// A clear blue day for a sun of this irradiance perpendicular to its beam, of any height. It lights a level
    /// surface with 14.6 % of that, as much as the IESNA's clear sky does for a sun 45 degrees high; below the horizon
    /// a ground of albedo 0.2.
    static GradientSky clear_day(const Vec3d& sun_irradiance, const Vec3d& up);
};

/// A sky: a value.
class Sky {
public:
    Sky() : Sky(GradientSky{}) {}  ///< black
    Sky(const GradientSky&);
    /// Parameters in the order of the kind's. Throws InputError, naming the one that is not admissible.
    Sky(const SkyKind&, const Vec3d& up, std::vector<Vec3d> parameters, std::shared_ptr<const Panorama> map = nullptr);
    /// The same radiance everywhere.
    static Sky constant(const Vec3d& radiance) { return GradientSky{radiance, radiance, radiance}; }

    const SkyKind& kind() const { return *kind_; }
    const Vec3d& up() const { return description_.up; }  ///< unit
    const std::vector<Vec3d>& parameters() const { return description_.parameters; }
    std::optional<GradientSky> gradient() const;  ///< none: another kind
    const std::shared_ptr<const Panorama>& map() const { return description_.map; }

    Vec3d radiance(const Vec3d& direction) const { return model_->radiance(direction); }
    Vec3d mean_inflow(const Vec3d& normal) const { return model_->mean_inflow(normal); }
    std::vector<Vec3d> tones() const { return model_->tones(); }
    bool uniform() const { return model_->uniform(); }
    const std::vector<SkyPart>& parts() const { return model_->parts(); }
    bool dark() const { return dark_; }

    /// This sky, dark below the horizon. That is not stored with a grid, which tells its ground by itself.
    Sky above_horizon() const;
    /// As a viewer sees it: an environment with the suns that light by themselves (environment_suns()).
    Sky drawn() const;

    /// True for the same kind, parameters and texels.
    friend bool operator==(const Sky&, const Sky&);

private:
    void make_model();

    const SkyKind* kind_;
    SkyDescription description_;
    std::shared_ptr<const SkyModel> model_;
    bool dark_ = true;
};

/// The sky of Preetham, Shirley, Smits 1999 ("A Practical Analytic Model for Daylight") about the sun, in units in
/// which the sun has `sun_irradiance` across its beam: sky and sun keep the ratio of their luminances under that
/// atmosphere (scene/atmosphere.h). Below the horizon `ground`; without it a ground of albedo 0.2 in the light of both.
/// Throws InputError for a sun that is dark or below the horizon, and for a turbidity outside the limits.
Sky preetham_sky(const Vec3d& to_sun, const Vec3d& sun_irradiance, double turbidity, const Vec3d& up,
                 const std::optional<Vec3d>& ground = std::nullopt);

/// The sky of a panorama without its suns, times `gain`. The middle of the picture lies along the axis after `up` in
/// the order x, y, z, turned by `turn` degrees, counterclockwise as seen from above: with y up along z, with x to its
/// left, as OpenEXR has it. Throws InputError for a turn outside -360..360 and a gain that is not finite or below 0.
Sky environment_sky(std::shared_ptr<const Panorama>, double turn, double gain, const Vec3d& up);
/// Its suns as lights: environment, environment2, ...
std::vector<Light> environment_suns(const Panorama&, double turn, double gain, const Vec3d& up);

/// Writes the sky that lit a grid into its metadata (schema::lit_sky_kind ...), and reads it back: none if there is
/// none or it is black. An environment's texels lie in the file (scene/panorama.h); `file`: where they are looked for.
/// Reading throws InputError as the constructor of Sky, and for texels that are missing or other ones.
void write_sky(MetaMap&, const Sky&);
std::optional<Sky> read_sky(const MetaMap&, const GridFile* file = nullptr);

}  // namespace vdbcloud
