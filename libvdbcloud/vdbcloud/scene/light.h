#pragma once
// Lights: what shines from where, by one interface for all kinds, and how a light travels in a file.
//
// A new kind of light is a file of its own, as sun.cc, lamp.cc and spot.cc, a name in light_kinds.h and in the table of
// light.cc. Metadata, command lines, transmittance grids, sweeps and pictures use this interface and need no change.
#include "vdbcloud/core/affine.h"

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace vdbcloud {

struct GridFile;

/// Directions that stand for the disc of a light with an angular diameter, unless a user asks for another number.
constexpr int disc_directions = 16;

/// The way from a point to a light.
struct Sight {
    Vec3d direction;  ///< unit, towards the light [world]; the zero vector where the distance is 0
    double distance;  ///< [world unit]; infinity for a light at infinity
};

/// A point from which all light of a lamp comes.
struct PointSource {
    Vec3d position;  ///< [world]
    double power;    ///< over all directions, at strength 1
};

/// The light field of one kind of light in a void, at strength 1. All lengths and directions are in world space.
/// Immutable, so any number of threads may use it.
class LightModel {
public:
    virtual ~LightModel() = default;

    /// The way from x to the light. Light travels against Sight::direction. For a light with a disc, its centre.
    virtual Sight towards(const Vec3d& x) const = 0;

    /// Irradiance at x of a surface across the beam; infinity where x is a point source.
    virtual double irradiance(const Vec3d& x) const = 0;

    /// The mean of irradiance() over t0 <= t <= t1 on a ray, in closed form, finite for every ray.
    virtual double mean_irradiance(const WorldRay&, double t0, double t1) const = 0;

    /// Power through a parallelogram with these corners, in order around it, each pair of neighbours an edge.
    /// `normal` is normal to the parallelogram; power that travels along it counts above 0.
    virtual double power_through(const std::array<Vec3d, 4>& corner, const Vec3d& normal) const = 0;

    /// The unit vector towards the light where it is the same from everywhere; else nothing. Beams of such a light run
    /// on one lattice.
    virtual std::optional<Vec3d> common_direction() const { return std::nullopt; }

    /// The point that all light comes from, where there is one at a finite distance.
    virtual std::optional<PointSource> source() const { return std::nullopt; }

    /// The way from x to a random point of the light, for u and v uniform in [0, 1): uniform in solid angle over a
    /// disc; towards(x) for a light without extent. Each direction of a disc brings irradiance(x) across its own beam.
    virtual Sight sample(const Vec3d& x, double u, double v) const
    {
        (void)u;
        (void)v;
        return towards(x);
    }

    /// At most `count` lights without extent whose mean stands for this one, each of this one's strength; empty for a
    /// light without extent.
    virtual std::vector<std::shared_ptr<const LightModel>> parts(int count) const
    {
        (void)count;
        return {};
    }
};

enum class LightValue { Number, Colour, Direction };

/// A number, a colour or a direction that a kind of light has beside its place.
struct LightParameter {
    const char* name;    ///< in messages and reports, and in the option's name: --sun-irradiance
    const char* key;     ///< metadata (grid/schema.h)
    const char* help;    ///< meaning and unit
    LightValue type;     ///< a number is then all three components; a direction becomes unit
    Vec3d otherwise;     ///< where no value is given
    double least, most;  ///< limits, inclusive; values must also be finite
};

/// The description of a kind of light: its words, metadata and parameters, and how to make its field.
struct LightKind {
    const char* word;        ///< in metadata
    const char* name;        ///< of the first light of the kind, and the option: sun, --sun
    const char* place_name;  ///< in messages: direction, position
    const char* place_key;   ///< metadata
    const char* place_help;
    const char* preposition;                 ///< between name and place in messages: towards, at
    bool at_infinity;                        ///< the place is a direction, of any length but 0, and made unit
    std::vector<LightParameter> parameters;  ///< the first is the strength
    std::shared_ptr<const LightModel> (*model)(const Vec3d& place, const std::vector<Vec3d>& parameters);
};

/// All kinds of light.
const std::vector<const LightKind*>& light_kinds();

/// One light: a value. `light->towards(x)` evaluates its field.
class Light {
public:
    /// Parameters in the order of the kind's, defaults where there are fewer.
    /// Throws InputError naming the light and the value that is not admissible: a name that is not plain, a direction
    /// without length, a position that is not finite, a parameter outside its limits.
    Light(const LightKind&, std::string name, const Vec3d& place, std::vector<Vec3d> parameters = {});

    std::string name;  ///< letters, digits, '_'; the light's grid is transmittance_<name>

    const LightKind& kind() const { return *kind_; }
    /// Unit direction towards a light at infinity, else its position [world].
    const Vec3d& place() const { return place_; }
    /// Per colour channel, what the field is proportional to: irradiance E across the beam of a sun, intensity
    /// [power per steradian] of a lamp, and of a spot on its axis.
    const Vec3d& strength() const { return parameters_[0]; }
    const std::vector<Vec3d>& parameters() const { return parameters_; }

    /// LightModel::parts(), and the light itself where it has none.
    std::vector<std::shared_ptr<const LightModel>> parts(int count) const;

    /// Lights without extent whose sum is this one: parts(count), each with its share of the strength.
    std::vector<Light> points(int count) const;
    bool has_extent() const { return parts(2).size() > 1; }

    const LightModel* operator->() const { return model_.get(); }
    const LightModel& operator*() const { return *model_; }

private:
    const LightKind* kind_;
    Vec3d place_;
    std::vector<Vec3d> parameters_;
    std::shared_ptr<const LightModel> model_;
};

/// Light::points() of all lights.
std::vector<Light> points_of(const std::vector<Light>&, int count);

/// A light at infinity. `to_light`: towards it, any length but 0. `irradiance`: across its beam, per channel.
/// `angular_diameter` [degrees]: of its disc, whose centre is to_light; 0: a point.
Light make_sun(const Vec3d& to_light, const Vec3d& irradiance = Vec3d(1, 1, 1), double angular_diameter = 0,
               std::string name = "sun");

/// A point that shines alike in all directions. `intensity`: power per steradian, per channel: E = intensity / r^2.
Light make_lamp(const Vec3d& position, const Vec3d& intensity = Vec3d(1, 1, 1), std::string name = "lamp");

/// A point that shines into a cone about `direction`, any length but 0. `angle` [degrees]: from edge to edge. `blend`,
/// 0 to 1: the edge is soft from (1 - blend) of the half angle on. `intensity`: power per steradian on the axis.
Light make_spot(const Vec3d& position, const Vec3d& direction, double angle = 45, double blend = 0.15,
                const Vec3d& intensity = Vec3d(1, 1, 1), std::string name = "spot");

/// True if two lights have the same field up to strength, to rounding: a transmittance grid of one serves the other.
bool same_place(const Light&, const Light&);

/// True if two lights are one light, by whatever names.
bool same_light(const Light&, const Light&);

/// "sun towards 0,1,0 of 1,1,1 diameter 5; lamp at 1,2,3 of 4,4,4", with 12 digits: which lights a solution belongs to.
/// Parameters beside the strength are named where they are not 0. Lights of strength 0 are left out. Sorted: lights are
/// a set, and neither the order of options nor that of grids in a file, which other programs change, has a meaning.
std::string lights_text(const std::vector<Light>&);

/// The lights of a solution by its metadata, as lights_text() has it, where they are other lights than these; nothing
/// where they are the same, by whatever names, or the metadata names none.
std::optional<std::string> other_lights(const MetaMap& solution, const std::vector<Light>&);

/// Per channel the largest irradiance among lights at infinity; 0 without any.
Vec3d brightest_sun(const std::vector<Light>&);

/// "transmittance_<name>".
std::string transmittance_name(const Light&);

/// Metadata of the light's transmittance grid (grid/schema.h).
/// Throws InputError for a name that is not plain.
void write_light(MetaMap&, const Light&);

/// The light that a grid called `grid_name` with this metadata belongs to; nothing if the grid is no transmittance grid
/// of ours. Throws InputError as Light's constructor, or where the kind is unknown or the place is missing.
std::optional<Light> read_light(const MetaMap&, const std::string& grid_name);

/// Every light described by the transmittance grids of a file, sorted by name.
std::vector<Light> lights_of(const GridFile&);

/// A file's transmittance grid of a light: of that very light, by whatever name, else of one at its place, whose grid
/// serves too, else the grid of the light's name, which may be another light's; null if there is none.
GridBasePtr grid_of_light(const GridFile&, const Light&);

}  // namespace vdbcloud
