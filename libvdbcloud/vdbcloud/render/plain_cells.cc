#include "vdbcloud/render/plain_cells.h"

#include "vdbcloud/render/cell_rule.h"

namespace vdbcloud {

namespace {

bool same(const Affine& f, const Affine& g)
{
    return f.a[0] == g.a[0] && f.a[1] == g.a[1] && f.a[2] == g.a[2] && f.b == g.b;
}

class PlainCells : public RayIntegrator {
public:
    explicit PlainCells(const PreparedScene& scene) : scene_(scene), media_(scene), sun_(scene.lights.size()) {}

    /// The same rule as Cells::step(), each quantity computed once. The tests compare the two.
    void operator()(const WorldRay& ray, RayResult& result) override
    {
        result.clear(scene_.lights.size());
        media_.set(ray);
        constexpr double far = std::numeric_limits<double>::infinity();
        const auto& volume = scene_.volumes[0];
        const IndexRay& index = media_.index_ray(0);
        const double sigma_t = volume.sigma_t[0];
        double tau = 0, previous = -1;
        Vec3i brick(0);
        bool in_brick = false;
        for (auto& s : sun_) s.sum = 0;
        march_cells(volume.density, index, 0, far, [&](double t0, double t1, const float* corners, const Vec3i& cell) {
            const double length = t1 - t0;
            const Vec3d p = index.at(t0) - Vec3d(cell[0], cell[1], cell[2]), d = length * index.direction;
            const Cubic density = along(corners, p, d);
            const double to_mid = sigma_t * length * density.integral(0.5),
                         whole = sigma_t * length * density.integral(1);
            const double tau_mid = tau + to_mid, tau_end = tau + whole;
            ++result.cells;
            if (tau < log_2 && tau_end >= log_2) result.half_way = t0 + length * (log_2 - tau) / whole;
            if (tau < opaque) {
                ++result.lit;
                const Vec3i b(cell[0] >> 3, cell[1] >> 3, cell[2] >> 3);
                if (!in_brick || b != brick) {
                    brick = b;
                    in_brick = true;
                    for (size_t l = 0; l < sun_.size(); ++l) sun_[l].brick = volume.light_depth[l]->find(b);
                }
                const int offset = (cell[0] & 7) * BrickMap::sx + (cell[1] & 7) * BrickMap::sy + (cell[2] & 7);
                for (auto& s : sun_) {
                    const Cubic depth = s.brick ? along(s.brick + offset, p, d) : Cubic{0, 0, 0, 0};
                    const double at_0 = tau + depth.c0, at_mid = tau_mid + depth.at(0.5), at_1 = tau_end + depth.at(1);
                    const double transmittance_0 = previous == t0 ? s.transmittance : std::exp(-at_0);
                    const double transmittance_mid = std::exp(-at_mid), transmittance_1 = std::exp(-at_1);
                    const double halves =
                        to_mid * mean_exponential(transmittance_0, transmittance_mid, at_mid - at_0) +
                        (whole - to_mid) * mean_exponential(transmittance_mid, transmittance_1, at_1 - at_mid);
                    const double better =
                        halves + (halves - whole * mean_exponential(transmittance_0, transmittance_1, at_1 - at_0)) / 3;
                    s.sum += better > 0 ? better : halves;
                    s.transmittance = transmittance_1;
                }
                previous = t1;
            }
            tau = tau_end;
            return true;
        });
        result.tau = result.true_tau = Vec3d(tau);
        for (size_t l = 0; l < sun_.size(); ++l)
            result.direct[l] = volume.albedo * media_.arriving(l, 0, 0, 1) * sun_[l].sum;
    }

private:
    struct Sun {
        const float* brick = nullptr;  // of the light's depth, where the ray is
        double transmittance = 0,
               sum = 0;  // exp(-depth) at the end of the last cell; scattered light over albedo, E and p
    };
    const PreparedScene& scene_;
    RayMedia media_;
    std::vector<Sun> sun_;
};

}  // namespace

bool is_plain(const PreparedScene& scene)
{
    if (scene.volumes.size() != 1 || !scene.grey || scene.shadow_rays || scene.repeats) return false;
    const auto& v = scene.volumes[0];
    if (v.colour || v.emission || v.phi || v.scaling.delta_f != 0) return false;
    for (size_t l = 0; l < scene.lights.size(); ++l)
        if (!scene.lights[l]->common_direction() || v.light_depth[l]->channels() != 1 ||
            !same(v.light_depth[l]->index_from_world(), v.density.index_from_world()))
            return false;
    return true;
}

std::unique_ptr<RayIntegrator> make_plain_cells_integrator(const PreparedScene& scene)
{
    return std::make_unique<PlainCells>(scene);
}

}  // namespace vdbcloud
