// The environment: a sky from a picture of all directions.
#include "vdbcloud/grid/scatter_schema.h"
#include "vdbcloud/scene/sky_kinds.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/scene/light.h"
#include "vdbcloud/scene/panorama.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

/// The frame of a panorama in the world, turned about `up`.
struct Frame {
    Frame(const Vec3d& axis, double degrees) : up(axis)
    {
        int largest = 0;
        for (int a = 1; a < 3; ++a)
            if (std::abs(up[a]) > std::abs(up[largest])) largest = a;
        Vec3d next(0);
        next[(largest + 1) % 3] = 1;
        const Vec3d forward = (next - next.dot(up) * up).unit(), aside = up.cross(forward);
        const double turn = degrees * pi / 180;
        ahead = std::cos(turn) * forward + std::sin(turn) * aside;
        left = up.cross(ahead);
    }
    Vec3d of_world(const Vec3d& w) const { return {w.dot(left), w.dot(up), w.dot(ahead)}; }
    Vec3d in_world(const Vec3d& p) const { return p[0] * left + p[1] * up + p[2] * ahead; }
    Vec3d left, up, ahead;
};

class Environment : public SkyModel {
public:
    explicit Environment(const SkyDescription& sky)
        : map_(sky.map), frame_(sky.up, sky.parameters[0][0]), gain_(sky.parameters[1][0]),
          with_suns_(sky.parameters[2][0] != 0), ends_at_horizon_(sky.ends_at_horizon)
    {
        for (const Panorama::Part& part : map_->parts())
            parts_.push_back({frame_.in_world(part.direction),
                              ends_at_horizon_ && part.direction[1] < 0 ? Vec3d(0.0) : gain_ * part.radiance,
                              part.solid_angle});
    }

    Vec3d radiance(const Vec3d& w) const override
    {
        const Vec3d of = frame_.of_world(w);
        return ends_at_horizon_ && of[1] < 0 ? Vec3d(0.0) : gain_ * map_->radiance(of, with_suns_);
    }

    /// By the parts of the panorama, without its suns; relative error below 1e-3 of the largest inflow.
    Vec3d mean_inflow(const Vec3d& normal) const override
    {
        Vec3d sum(0.0);
        double weights = 0;
        for (const SkyPart& part : parts_) {
            const double cosine = part.direction.dot(normal) * part.solid_angle;
            if (!(cosine > 0)) continue;
            weights += cosine;
            sum += cosine * part.radiance;
        }
        return sum / weights;
    }

    std::vector<Vec3d> tones() const override
    {
        std::vector<Vec3d> tones = map_->tones();
        for (Vec3d& tone : tones) tone *= gain_;
        return tones;
    }

    const std::vector<SkyPart>& parts() const override { return parts_; }

private:
    std::shared_ptr<const Panorama> map_;
    Frame frame_;
    double gain_;
    bool with_suns_, ends_at_horizon_;
    std::vector<SkyPart> parts_;
};

std::shared_ptr<const SkyModel> model(const SkyDescription& sky)
{
    if (!sky.map)
        throw InputError("a sky of a panorama without the grid 'environment': expected the one that it was made with");
    return std::make_shared<Environment>(sky);
}

}  // namespace

const SkyKind environment_kind{"environment",
                               {{"turn", schema::lit_sky_turn, false, 0, -360, 360},
                                {"scale", schema::lit_sky_scale, false, 1, 0, std::numeric_limits<double>::infinity()},
                                {"suns", schema::lit_sky_suns, false, 0, 0, 1}},
                               model};

Sky environment_sky(std::shared_ptr<const Panorama> map, double turn, double gain, const Vec3d& up)
{
    return Sky(environment_kind, up, {Vec3d(turn), Vec3d(gain), Vec3d(0.0)}, std::move(map));
}

std::vector<Light> environment_suns(const Panorama& map, double turn, double gain, const Vec3d& up)
{
    const Frame frame(up.unit(), turn);
    std::vector<Light> lights;
    for (const Panorama::Sun& sun : map.suns())
        lights.push_back(make_sun(frame.in_world(sun.direction), gain * sun.irradiance, sun.diameter,
                                  "environment" + (lights.empty() ? "" : std::to_string(lights.size() + 1))));
    return lights;
}

Sky Sky::drawn() const
{
    if (kind_ != &environment_kind || description_.map->suns().empty()) return *this;
    Sky sky = *this;
    sky.description_.parameters[2] = Vec3d(1.0);
    sky.make_model();
    return sky;
}

}  // namespace vdbcloud
