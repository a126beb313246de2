#include "vdbcloud/scatter/expected_share.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/optics/free_path.h"
#include "vdbcloud/voxels/brick_map.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace vdbcloud {

namespace {

constexpr int batch = 64, most_collisions = 1000;
constexpr double opaque = 45, weak = 0.1, far = std::numeric_limits<double>::infinity();

/// Random numbers of one path, in order.
class PathNumbers {
public:
    explicit PathNumbers(uint64_t path) : path_(path) {}
    double operator()() { return uniform(hash_bits(1984, path_, count_++)); }

private:
    uint64_t path_, count_ = 0;
};

/// Points distributed as the trilinear interpolant of a density.
class DensityPoints {
public:
    explicit DensityPoints(const FloatGrid& density)
    {
        for (auto it = density.cbeginValueOn(); it; ++it) {
            if (!(*it > 0)) continue;
            const openvdb::CoordBBox box = it.getBoundingBox();
            boxes_.push_back(box);
            sums_.push_back((sums_.empty() ? 0 : sums_.back()) + double(*it) * double(box.volume()));
        }
    }

    bool empty() const { return boxes_.empty(); }

    /// In index space. The hat function of a voxel is the sum of two uniform numbers along each axis.
    Vec3d operator()(PathNumbers& random) const
    {
        const double at = random() * sums_.back();
        const size_t n =
            std::min(size_t(std::upper_bound(sums_.begin(), sums_.end(), at) - sums_.begin()), sums_.size() - 1);
        Vec3d p;
        for (int a = 0; a < 3; ++a) {
            const int voxels = boxes_[n].max()[a] - boxes_[n].min()[a] + 1;
            p[a] = boxes_[n].min()[a] + std::min(int(random() * voxels), voxels - 1) + random() + random() - 1;
        }
        return p;
    }

private:
    std::vector<openvdb::CoordBBox> boxes_;  // voxels and tiles of one value
    std::vector<double> sums_;               // of density, up to and with each box
};

/// What paths of one channel meet.
struct Channel {
    const BrickMap& density;
    const BrickMap* tint;
    const PhaseFunction& phase;
    int channel;
    double sigma_t, albedo;
    const std::vector<Light>& lights;
    const Sky& sky;

    double optical_depth(const WorldRay& ray, double t1) const
    {
        const IndexRay index(density.index_from_world(), ray);
        return sigma_t * depth_up_to(density, index, 0, t1, opaque / sigma_t);
    }

    double albedo_at(const Vec3d& x) const
    {
        return tint ? albedo * std::clamp(tint->sample3(tint->index_from_world().point(x))[channel], 0.0, 1.0) : albedo;
    }

    /// Where light of one of the sources comes from, drawn in proportion to its fluence at x, and the fluence of all.
    double incoming(const Vec3d& x, PathNumbers& random, Vec3d& along) const
    {
        double sum = 0;
        const auto take = [&](const Vec3d& towards, double fluence) {
            sum += fluence;
            const double u = random();
            if (u * sum < fluence) along = -towards;
        };
        for (const Light& light : lights) {
            const double u = random(), v = random();
            const Sight sight = light->sample(x, u, v);
            const double strength = light.strength()[channel] * light->irradiance(x);
            if (!(sight.distance > 0) || !std::isfinite(strength)) continue;
            take(sight.direction, strength * std::exp(-optical_depth({x, sight.direction}, sight.distance)));
        }
        if (!sky.dark()) {
            const double z = 1 - 2 * random(), turn = 2 * pi * random(), r = std::sqrt(std::max(0.0, 1 - z * z));
            const Vec3d towards(r * std::cos(turn), r * std::sin(turn), z);
            const double radiance = sky.radiance(towards)[channel];
            if (radiance > 0) take(towards, 4 * pi * radiance * std::exp(-optical_depth({x, towards}, far)));
        }
        return sum;
    }

    /// How often light is scattered that is scattered at x for the first time, that time included.
    double scatterings(Vec3d x, Vec3d along, PathNumbers& random) const
    {
        double count = 1, weight = 1;
        for (int n = 1; n < most_collisions; ++n) {
            const double u = random(), v = random();
            along = phase.sample(along, u, v);
            const IndexRay ray(density.index_from_world(), {x, along});
            const double whole = depth_up_to(density, ray, 0, far, opaque / sigma_t),
                         surely = -std::expm1(-sigma_t * whole);
            const Travel leg = travel(density, ray, 0, far, -std::log1p(-random() * surely) / sigma_t);
            if (!leg.reached) return count;
            x += leg.t * along;
            weight *= surely * albedo_at(x);
            count += weight;
            if (weight >= weak) continue;
            if (random() * weak >= weight) return count;
            weight = weak;
        }
        return count;
    }
};

/// First scatterings and all scatterings of a path.
struct Tally {
    double first = 0, all = 0;
};

ExpectedShare share_of(const Channel& channel, const DensityPoints& points, const ShareOptions& options)
{
    ExpectedShare out;
    std::vector<Tally> tallies;
    do {
        tallies.resize(tallies.size() + batch);
        tbb::parallel_for(tallies.size() - batch, tallies.size(), [&](size_t n) {
            PathNumbers random(n);
            const Vec3d x = channel.density.world_from_index().point(points(random));
            Vec3d along(0.0);
            const double first = channel.incoming(x, random, along) * channel.albedo_at(x);
            tallies[n] = {first, first > 0 ? first * channel.scatterings(x, along, random) : 0};
        });
        double first = 0, all = 0, square = 0;
        for (const Tally& tally : tallies) {
            first += tally.first;
            all += tally.all;
        }
        out.paths = int(tallies.size());
        if (!(all > 0)) continue;
        out.share = 1 - first / all;
        for (const Tally& tally : tallies) {
            const double off = tally.first - first / all * tally.all;
            square += off * off;
        }
        out.error = std::sqrt(square) / all;
        if (out.paths >= 2 * batch && out.share - 4 * out.error > options.enough) break;
    } while (out.paths < options.most_paths && (out.error > options.error || out.paths < 2 * batch));
    return out;
}

}  // namespace

ExpectedShare expected_share(const FloatGrid& density, const Vec3SGrid* tint, const Medium& medium,
                             const std::vector<Light>& lights, const Sky& sky, const ShareOptions& options)
{
    ExpectedShare most;
    const DensityPoints points(density);
    if (points.empty()) return most;
    const Period period = period_of(density, options.periodic);
    const BrickMap map(density, 0, {}, period);
    std::optional<BrickMap> colours;
    if (tint) colours.emplace(*tint, 1.0f, BrickMap::Map(), period_in(period, density.transform(), *tint));
    for (int c = 0; c < 3; ++c) {
        const double sigma_t = medium.sigma_t_per_density[c], albedo = medium.albedo[c];
        const bool same = c > 0 && !tint && sigma_t == medium.sigma_t_per_density[0] && albedo == medium.albedo[0];
        if (same || !(sigma_t > 0) || !(albedo > 0)) continue;
        const Channel channel{map, colours ? &*colours : nullptr, medium.phase, c, sigma_t, albedo, lights, sky};
        const ExpectedShare found = share_of(channel, points, options);
        if (found.share >= most.share) most = found;
    }
    return most;
}

}  // namespace vdbcloud
