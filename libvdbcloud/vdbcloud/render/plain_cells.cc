#include "vdbcloud/render/plain_cells.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/optics/spherical_harmonics.h"
#include "vdbcloud/render/cell_rule.h"
#include "vdbcloud/render/plain_batch.h"

#include <algorithm>
#include <cstring>

namespace vdbcloud {

namespace {

bool same(const Affine& f, const Affine& g)
{
    return f.a[0] == g.a[0] && f.a[1] == g.a[1] && f.a[2] == g.a[2] && f.b == g.b;
}

/// Whether any of eight corner values is not 0; copies them.
bool copy_corners(const float* from, float* to)
{
    constexpr int rows[4] = {0, BrickMap::sy, BrickMap::sx, BrickMap::sx + BrickMap::sy};
    uint64_t any = 0;
    for (int k = 0; k < 4; ++k) {
        uint64_t two;
        std::memcpy(&two, from + rows[k], sizeof two);
        std::memcpy(to + 2 * k, &two, sizeof two);
        any |= two;
    }
    return (any & 0x7fffffff7fffffff) != 0;
}

class PlainCells : public RayIntegrator {
public:
    explicit PlainCells(const PreparedScene& scene)
        : scene_(scene), volume_(scene.volumes[0]), media_(scene), peaks_(scene.lights.size())
    {
        const Vec3d extinction = media_.extinction(0, volume_.albedo);
        ray_.sigma_t = extinction[0];
        ray_.lights = int(scene.lights.size());
        ray_.fields = volume_.fields->count();
        ray_.groups = (ray_.fields + 3) / 4;
        ray_.channels = volume_.field_channels;
        ray_.flux_limit = volume_.flux_limit;
        ray_.peak_depth_of_tau = volume_.albedo[0] / volume_.scaling.extinction(volume_.albedo[0]);
        ray_.peak.resize(scene.lights.size());
        for (int c = 0; c < ray_.channels; ++c) {
            ray_.weight[c].assign(size_t(4 * ray_.groups), 0.0);
            ray_.phi[c] = ray_.lights + c;
            ray_.flux[c] = volume_.field_flux[c];
        }
        batch_.depth.resize(scene.lights.size());
        batch_.direct.resize(scene.lights.size());
        harmonics_.resize(size_t(harmonic_count(std::max(volume_.degree, 1))));
    }

    void operator()(const WorldRay& ray, RayResult& result) override
    {
        constexpr double far = std::numeric_limits<double>::infinity();
        result.clear(scene_.lights.size());
        media_.set(ray);
        result.hit = media_.hit();
        stop_ = media_.stop();
        const IndexRay& index = media_.index_ray(0);
        double t0 = 0, t1 = far;
        if (!clip(index, volume_.density, t0, t1)) return;
        set(index);
        tau_ = 0;
        march_detail::march_roots(volume_.density, index, 0, far, [&](int32_t number, Vec3i& cell, double& t) {
            march(index, number, cell, t, result);
            return t < stop_;
        });
        flush(result);
        result.tau = Vec3d(tau_);
        const double true_over_scaled = volume_.sigma_t[0] / ray_.sigma_t;
        result.true_tau = true_over_scaled * result.tau;
        for (size_t l = 0; l < batch_.direct.size(); ++l)
            result.direct[l] = true_over_scaled * volume_.albedo * media_.arriving(l, 0, 0, 1) * batch_.direct[l];
        if (ray_.channels == 0) return;
        for (int c = 0; c < 3; ++c) result.multiple[c] = batch_.multiple[ray_.channels == 3 ? c : 0];
        result.multiple *= true_over_scaled * volume_.scaling.scattering() * volume_.albedo * volume_.channel_scale;
    }

private:
    /// What depends on the direction of the ray.
    void set(const IndexRay& index)
    {
        for (int a = 0; a < 3; ++a) {
            ray_.origin[a] = index.origin[a];
            ray_.direction[a] = index.direction[a];
        }
        batch_.count = 0;
        std::fill(batch_.direct.begin(), batch_.direct.end(), 0.0);
        std::fill_n(batch_.multiple, 3, 0.0);
        const Vec3d direction = media_.ray().direction;
        for (size_t l = 0; l < peaks_.size() && volume_.peak; ++l) {
            peaks_[l] = volume_.peak->at_angle(media_.cosine(l));
            ray_.peak[l] = peaks_[l].empty() ? nullptr : peaks_[l].data();
        }
        if (ray_.channels == 0 || (known_direction_ == direction)) return;
        known_direction_ = direction;
        if (volume_.degree > 1) evaluate_harmonics(volume_.degree, -direction, harmonics_.data());
        const int moments = harmonic_count(volume_.degree) - harmonic_count(1);
        for (int c = 0; c < ray_.channels; ++c) {
            double* weight = ray_.weight[c].data();
            weight[ray_.phi[c]] = 1 / (4 * pi);
            if (ray_.flux[c] >= 0)
                for (int a = 0; a < 3; ++a)
                    weight[ray_.flux[c] + a] = -3 * volume_.scaling.mean_cosine() * direction[a] / (4 * pi);
            double* of_moments = weight + volume_.field_moments + c * moments;
            for (int l = 2; l <= volume_.degree; ++l)
                for (int k = l * l; k < (l + 1) * (l + 1); ++k)
                    of_moments[k - 4] = volume_.scaling.moments[size_t(l)] * harmonics_[size_t(k)];
        }
    }

    /// Gathers the cells of one brick, as march_detail::march_brick() visits them.
    void march(const IndexRay& ray, int32_t number, Vec3i& cell, double& t, RayResult& result)
    {
        constexpr double never = std::numeric_limits<double>::infinity();
        const float* const brick = volume_.density.brick(volume_.density.slot(number));
        const float* const fields = volume_.fields->brick(number);
        const Vec3i home(cell[0] >> 3, cell[1] >> 3, cell[2] >> 3);
        constexpr int strides[3] = {BrickMap::sx, BrickMap::sy, 1};
        int forward[3], step[3], stride[3];
        double next[3];
        for (int a = 0; a < 3; ++a) {
            forward[a] = ray.direction[a] > 0;
            step[a] = forward[a] ? 1 : -1;
            stride[a] = step[a] * strides[a];
            next[a] = ray.direction[a] == 0 ? never : (double(cell[a] + forward[a]) - ray.origin[a]) * ray.inverse[a];
        }
        int at = (cell[0] & 7) * BrickMap::sx + (cell[1] & 7) * BrickMap::sy + (cell[2] & 7);
        double now = t;
        const auto visit = [&](double wall) {
            const double t_out = std::min(wall, stop_);
            if (!(t_out > now)) return;
            PlainBatch& b = batch_;
            if (b.count == PlainBatch::size) flush(result);
            const int i = b.count;
            if (copy_corners(brick + at, b.corner[i])) {
                b.t0[i] = now;
                b.t1[i] = t_out;
                for (int a = 0; a < 3; ++a) b.cell[a][i] = cell[a];
                b.field[i] = fields + at * ray_.fields;
                b.joined[i] = i > 0 && b.t1[i - 1] == now;
                b.count = i + 1;
            }
            now = t_out;
        };
        const auto advance = [&](int a) {
            cell[a] += step[a];
            at += stride[a];
            next[a] = (double(cell[a] + forward[a]) - ray.origin[a]) * ray.inverse[a];
            return (cell[a] >> 3) == home[a];
        };
        for (bool inside = true; inside;) {
            if (next[0] < next[1] && next[0] < next[2]) {
                visit(next[0]);
                inside = advance(0);
            } else if (!(next[0] < next[1]) && next[1] < next[2]) {
                visit(next[1]);
                inside = advance(1);
            } else {
                visit(next[2]);
                inside = advance(2);
            }
        }
        t = now;
    }

    /// Adds the cells of the batch to the ray's sums.
    void flush(RayResult& result)
    {
        PlainBatch& b = batch_;
        if (b.count == 0) return;
        find_depths(ray_, b);
        int lit = 0;
        for (int i = 0; i < b.count; ++i) {
            b.tau[i] = tau_;
            if (tau_ < opaque) lit = i + 1;
            const double after = tau_ + b.whole[i];
            if (tau_ < log_2 && after >= log_2)
                result.half_way = b.t0[i] + (b.t1[i] - b.t0[i]) * (log_2 - tau_) / b.whole[i];
            tau_ = after;
        }
        result.cells += uint64_t(b.count);
        result.lit += uint64_t(lit);
        if (lit > 0) {
            gather(ray_, b, lit);
            add_light(ray_, b, lit);
        }
        b.count = 0;
    }

    const PreparedScene& scene_;
    const PreparedVolume& volume_;
    RayMedia media_;
    PlainRay ray_;
    PlainBatch batch_;
    double stop_ = 0;  // where the ray ends on a solid
    double tau_ = 0;   // of the cells before the batch
    std::vector<std::vector<double>> peaks_;
    std::vector<double> harmonics_;
    Vec3d known_direction_{0, 0, 0};  // of the weights in ray_
};

}  // namespace

bool is_plain(const Scene& scene, const IntegratorOptions& o)
{
    if (o.kind != Integrator::Cells || !o.plain_path || o.parts != 1 || o.shadow_rays || scene.volumes.size() != 1 ||
        scene.periodic != std::array<bool, 3>{})
        return false;
    const Volume& v = scene.volumes[0];
    const Vec3d& w = v.medium.albedo;
    const bool grey_albedo = w[0] == w[1] && w[1] == w[2];
    return v.medium.grey() && v.medium.sigma_t_per_density[0] > 0 && !v.colour && !v.emission &&
           (v.collided.scaling.delta_f == 0 || grey_albedo) &&
           std::all_of(scene.lights.begin(), scene.lights.end(),
                       [](const Light& light) { return bool(light->common_direction()); });
}

bool add_plain_fields(const Volume& volume, const BrickMap::Map& depth_of, PreparedVolume& prepared)
{
    std::vector<FieldBricks::Field> fields;
    int count = 0;
    bool fits = true;
    const auto add = [&](const GridBasePtr& grid, const BrickMap::Map& map, bool fringe) {
        const int first = count;
        fields.push_back({grid, map, fringe});
        count += grid->isType<FloatGrid>() ? 1 : 3;
        fits = fits && same(index_from_world(grid->transform(), grid->getName()), prepared.density.index_from_world());
        return first;
    };
    for (const GridBasePtr& t : volume.transmittance) {
        if (!t->isType<FloatGrid>()) return false;
        add(t, depth_of, false);
    }
    const CollidedLight& light = volume.collided;
    int channels = 0, flux[3] = {-1, -1, -1}, moments = -1;
    if (light.phi) {
        channels = light.phi->isType<FloatGrid>() ? 1 : 3;
        add(light.phi, {}, true);
        for (int c = 0; c < channels && light.scaling.mean_cosine() != 0; ++c)
            if (light.flux[size_t(c)]) flux[c] = add(light.flux[size_t(c)], {}, true);
        moments = count;
        for (int c = 0; c < channels; ++c)
            for (const FloatGridPtr& moment : light.moments[size_t(c)]) add(moment, {}, true);
    }
    if (!fits || count > most_plain_fields) return false;
    prepared.fields = std::make_unique<FieldBricks>(prepared.density, fields);
    prepared.field_channels = channels;
    std::copy_n(flux, 3, prepared.field_flux);
    prepared.field_moments = moments;
    return true;
}

std::unique_ptr<RayIntegrator> make_plain_cells_integrator(const PreparedScene& scene)
{
    return std::make_unique<PlainCells>(scene);
}

}  // namespace vdbcloud
