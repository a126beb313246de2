// The integrator that knows the interpolant: optical depth is exact in each cell, and radiance is integrated in optical
// depth, where attenuation is an exponential whatever the density does.
#include "vdbcloud/render/media.h"

#include <cmath>

namespace vdbcloud {

namespace {

/// A piece of a ray inside one cell of one volume.
struct Piece {
    double t0, t1;
    Cubic density;

    /// Density integrated from a to b, t0 <= a <= b <= t1.
    double depth(double a, double b) const
    {
        const double length = t1 - t0;
        return length * (density.integral((b - t0) / length) - density.integral((a - t0) / length));
    }
};

/// The mean of exp(-x s) over s in [0, 1] times `at_0`, given at_1 = at_0 exp(-x) computed apart.
double mean_exponential(double at_0, double at_1, double x)
{
    if (std::abs(x) > 1e-2) return (at_0 - at_1) / x;
    return at_0 * (1 - x / 2 * (1 - x / 3 * (1 - x / 4 * (1 - x / 5))));
}

class Cells : public RayIntegrator {
public:
    Cells(const PreparedScene& scene, const IntegratorOptions& options)
        : scene_(scene), media_(scene), parts_(options.parts), channels_(scene.grey ? 1 : 3),
          pieces_(scene.volumes.size()), depth_(scene.volumes.size()), node_(scene.lights.size())
    {}

    void operator()(const WorldRay& ray, RayResult& result) override
    {
        constexpr double far = std::numeric_limits<double>::infinity();
        result.clear(scene_.lights.size());
        media_.set(ray);
        node_at_ = -1;
        if (scene_.volumes.size() == 1) {
            march_cells(scene_.volumes[0].density, media_.index_ray(0), 0, far,
                        [&](double a, double b, const float* corners, const Vec3i& cell) {
                            piece_of(0, a, b, corners, cell);
                            add(a, b, result);
                            return true;
                        });
            return;
        }
        for (size_t v = 0; v < scene_.volumes.size(); ++v) {
            pieces_[v].clear();
            march_cells(scene_.volumes[v].density, media_.index_ray(v), 0, far,
                        [&](double a, double b, const float* corners, const Vec3i& cell) {
                            piece_of(v, a, b, corners, cell);
                            pieces_[v].push_back(current_);
                            return true;
                        });
        }
        merge(result);
    }

private:
    void piece_of(size_t volume, double a, double b, const float* corners, const Vec3i& cell)
    {
        const IndexRay& ray = media_.index_ray(volume);
        const Vec3d p = ray.at(a) - Vec3d(cell[0], cell[1], cell[2]);
        current_ = {a, b, along(corners, p, (b - a) * ray.direction)};
    }

    /// Several volumes: every stretch between two cell walls of any of them.
    void merge(RayResult& result)
    {
        std::vector<size_t> next(pieces_.size(), 0);
        double t = 0;
        for (;;) {
            double start = std::numeric_limits<double>::infinity(), end = start;
            for (size_t v = 0; v < pieces_.size(); ++v) {
                while (next[v] < pieces_[v].size() && pieces_[v][next[v]].t1 <= t) ++next[v];
                if (next[v] == pieces_[v].size()) continue;
                start = std::min(start, std::max(t, pieces_[v][next[v]].t0));
            }
            if (start == std::numeric_limits<double>::infinity()) return;
            active_.clear();
            for (size_t v = 0; v < pieces_.size(); ++v) {
                if (next[v] == pieces_[v].size()) continue;
                const Piece& p = pieces_[v][next[v]];
                end = std::min(end, p.t0 > start ? p.t0 : p.t1);
                if (p.t0 <= start) active_.push_back({v, &p});
            }
            add(start, end, result);
            t = end;
        }
    }

    /// A stretch on which each volume's density is one cubic, in `parts_` steps.
    void add(double a, double b, RayResult& result)
    {
        ++result.cells;
        for (int n = 0; n < parts_; ++n) {
            const double t0 = a + (b - a) * n / parts_, t1 = n + 1 == parts_ ? b : a + (b - a) * (n + 1) / parts_;
            if (scene_.volumes.size() == 1) depth_[0] = current_.depth(t0, t1);
            else {
                std::fill(depth_.begin(), depth_.end(), 0.0);
                for (const auto& [v, piece] : active_) depth_[v] = piece->depth(t0, t1);
            }
            step(t0, t1, result);
        }
    }

    /// Optical depths to the lights at t, and what is left there of each light's beam on its way to the eye.
    void set_node(double t, const Vec3d& tau)
    {
        for (size_t l = 0; l < node_.size(); ++l) {
            node_[l].depth = media_.light_depth(l, t);
            for (int c = 0; c < channels_; ++c) node_[l].left[c] = std::exp(-(tau[c] + node_[l].depth[c]));
        }
        node_at_ = t;
    }

    void step(double t0, double t1, RayResult& result)
    {
        const size_t volumes = scene_.volumes.size();
        Vec3d dtau(0);
        for (size_t v = 0; v < volumes; ++v) {
            const bool tinted = scene_.volumes[v].colour != nullptr;
            const Vec3d albedo = tinted ? media_.albedo(v, (t0 + t1) / 2) : scene_.volumes[v].albedo;
            dtau += media_.extinction(v, albedo) * depth_[v];
        }
        const Vec3d tau0 = result.tau, tau1 = tau0 + dtau;
        result.tau = tau1;
        note_half_way(t0, t1, tau0, tau1, result);
        // Beyond this nothing that shines on the ray can show in a double: only the depth still counts.
        if (std::min({tau0[0], tau0[1], tau0[2]}) > 60) return;

        if (node_at_ != t0) set_node(t0, tau0);
        std::swap(node_, last_);
        node_.resize(last_.size());
        set_node(t1, tau1);
        for (size_t l = 0; l < node_.size(); ++l) {
            Vec3d weight(0), mean(0);
            for (size_t v = 0; v < volumes; ++v)
                if (depth_[v] > 0) weight += scattering(v, t0, t1) * media_.arriving(l, v, t0, t1);
            for (int c = 0; c < channels_; ++c)
                mean[c] = mean_exponential(last_[l].left[c], node_[l].left[c],
                                           dtau[c] + node_[l].depth[c] - last_[l].depth[c]);
            for (int c = channels_; c < 3; ++c) mean[c] = mean[0];
            result.direct[l] += weight * mean;
        }
        add_rest(t0, t1, tau0, tau1, result);
    }

    /// Scattering coefficient integrated over the step: kappa * albedo * density depth.
    Vec3d scattering(size_t v, double t0, double t1) const
    {
        const auto& volume = scene_.volumes[v];
        return volume.kappa * (volume.colour ? media_.albedo(v, (t0 + t1) / 2) : volume.albedo) * depth_[v];
    }

    /// Emission and light scattered more than once.
    void add_rest(double t0, double t1, const Vec3d& tau0, const Vec3d& tau1, RayResult& result)
    {
        for (size_t v = 0; v < scene_.volumes.size(); ++v) {
            const auto& volume = scene_.volumes[v];
            if (!volume.emission && !volume.phi) continue;
            Vec3d mean(0);
            for (int c = 0; c < 3; ++c)
                mean[c] = mean_exponential(std::exp(-tau0[c]), std::exp(-tau1[c]), tau1[c] - tau0[c]);
            if (volume.emission) {  // Simpson: exact for the cubic that it is within a cell
                const Vec3d sum = media_.emission(v, t0) + 4.0 * media_.emission(v, (t0 + t1) / 2) + media_.emission(v, t1);
                result.emission += sum * mean * ((t1 - t0) / 6);
            }
            if (volume.phi && depth_[v] > 0)
                result.multiple += media_.collided(v, (t0 + t1) / 2) * scattering(v, t0, t1) * (1 - volume.forward) * mean;
        }
    }

    static void note_half_way(double t0, double t1, const Vec3d& tau0, const Vec3d& tau1, RayResult& result)
    {
        if (result.half_way < 1e30) return;
        const auto mean = [](const Vec3d& tau) { return (std::exp(-tau[0]) + std::exp(-tau[1]) + std::exp(-tau[2])) / 3; };
        const double after = mean(tau1);
        if (after > 0.5) return;
        const double before = mean(tau0);  // linear in -log T within the step
        const double s = std::log(before / 0.5) / std::log(before / std::max(after, 1e-300));
        result.half_way = t0 + (t1 - t0) * std::clamp(s, 0.0, 1.0);
    }

    struct Node {
        Vec3d depth{0, 0, 0};  // optical depth from here to the light
        Vec3d left{0, 0, 0};   // exp(-(depth + tau))
    };

    const PreparedScene& scene_;
    RayMedia media_;
    int parts_, channels_;
    std::vector<std::vector<Piece>> pieces_;              // several volumes
    std::vector<std::pair<size_t, const Piece*>> active_;
    Piece current_{};                                     // one volume
    std::vector<double> depth_;                           // of the step, each volume [density x world unit]
    std::vector<Node> node_, last_;
    double node_at_ = -1;
};

}  // namespace

std::unique_ptr<RayIntegrator> make_cells_integrator(const PreparedScene& scene, const IntegratorOptions& options)
{
    return std::make_unique<Cells>(scene, options);
}

}  // namespace vdbcloud
