// The integrator that knows the interpolant: optical depth is exact in each cell, and radiance is integrated in optical
// depth, where attenuation is an exponential whatever the density does.
//
// Over a stretch from A to B let y = tau + tau_light be a beam's depth from the light to the eye by way of a point.
// Taking y linear in tau, scattered light is  W (exp(-y_A) - exp(-y_B)) / (y_B - y_A),  W the scattering depth times E
// p: positive at any thickness, with an error of second order in the stretch. Done for a cell whole and in halves,
// whose three points are the same, the two combine (Richardson) to fourth order.
#include "vdbcloud/render/cell_rule.h"
#include "vdbcloud/render/plain_cells.h"

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

class Cells : public RayIntegrator {
public:
    Cells(const PreparedScene& scene, const IntegratorOptions& options)
        : scene_(scene), media_(scene), parts_(options.parts), channels_(scene.grey ? 1 : 3),
          pieces_(scene.volumes.size()), first_half_(scene.volumes.size()), second_half_(scene.volumes.size()),
          whole_(scene.volumes.size())
    {
        for (Node* node : {&a_, &m_, &b_}) {
            node->beam.resize(scene.lights.size() * scene.volumes.size());
            node->volume.resize(scene.volumes.size());
        }
        for (const auto& lamp : scene.lamp) has_lamps_ = has_lamps_ || lamp;
        for (const auto& v : scene.volumes) {
            has_other_sources_ = has_other_sources_ || v.emission || v.phi;
            media_count_ += v.is_medium();
        }
    }

    void operator()(const WorldRay& ray, RayResult& result) override
    {
        result.clear(scene_.lights.size());
        media_.set(ray);
        result.hit = media_.hit();
        b_.t = -1;
        if (scene_.volumes.size() == 1) {
            march_cells(scene_.volumes[0].density, media_.index_ray(0), 0, media_.stop(),
                        [&](double t0, double t1, const float* corners, const Vec3i& cell) {
                            piece_of(0, t0, t1, corners, cell);
                            add(t0, t1, result);
                            return !scene_.repeats || thinnest(result.tau) <= opaque;
                        });
            return;
        }
        const double end = media_.end();
        for (size_t v = 0; v < scene_.volumes.size(); ++v) {
            pieces_[v].clear();
            march_cells(scene_.volumes[v].density, media_.index_ray(v), 0, end,
                        [&](double t0, double t1, const float* corners, const Vec3i& cell) {
                            piece_of(v, t0, t1, corners, cell);
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

    /// Values at a point of the ray.
    struct Node {
        struct Beam {
            Vec3d depth{0, 0, 0};          // optical depth from here to the light
            Vec3d transmittance{0, 0, 0};  // exp(-(depth + tau))
            bool known = false;
        };
        struct Local {
            Vec3d albedo{0, 0, 0}, collided{0, 0, 0}, emission{0, 0, 0};
        };
        double t = -1;
        Vec3d tau{0, 0, 0};            // from the eye
        Vec3d transmittance{0, 0, 0};  // exp(-tau); set where sources other than beams need it
        std::vector<Beam> beam;        // of light l for volume v: beam_number(l, v); known for volumes that are present
        std::vector<Local> volume;
    };

    static double thinnest(const Vec3d& tau) { return std::min({tau[0], tau[1], tau[2]}); }

    /// Shadow rays give one depth for all volumes.
    size_t beam_number(size_t l, size_t v) const { return l * scene_.volumes.size() + (scene_.shadow_rays ? 0 : v); }

    /// A stretch on which each volume's density is one cubic, in `parts_` steps.
    void add(double t0, double t1, RayResult& result)
    {
        ++result.cells;
        if (has_lamps_) media_.cuts_by_lamps(t0, t1, longest, cuts_);
        double from = t0;
        for (const double cut : cuts_) {
            if (!(cut > from && cut < t1)) continue;
            in_parts(from, cut, result);
            from = cut;
        }
        in_parts(from, t1, result);
    }

    void in_parts(double t0, double t1, RayResult& result)
    {
        for (int n = 0; n < parts_; ++n)
            step(n == 0 ? t0 : t0 + (t1 - t0) * n / parts_, n + 1 == parts_ ? t1 : t0 + (t1 - t0) * (n + 1) / parts_,
                 result);
    }

    /// Density depths of a stretch, each volume.
    void depths(double t0, double t1, std::vector<double>& depth) const
    {
        if (scene_.volumes.size() == 1) {
            depth[0] = current_.depth(t0, t1);
            return;
        }
        std::fill(depth.begin(), depth.end(), 0.0);
        for (const auto& [v, piece] : active_) depth[v] = piece->depth(t0, t1);
    }

    Vec3d optical(const Node& from, const Node& to, const std::vector<double>& depth) const
    {
        Vec3d tau(0);
        for (size_t v = 0; v < depth.size(); ++v)
            tau += media_.extinction(v, 0.5 * (from.volume[v].albedo + to.volume[v].albedo)) * depth[v];
        return tau;
    }

    void step(double t0, double t1, RayResult& result)
    {
        const double mid = (t0 + t1) / 2;
        depths(t0, mid, first_half_);
        depths(mid, t1, second_half_);
        if (b_.t == t0)
            std::swap(a_, b_);
        else {
            set_local(a_, t0);
            set_depth(a_, result.tau);
        }
        set_local(m_, mid);
        set_local(b_, t1);
        const Vec3d tau_mid = a_.tau + optical(a_, m_, first_half_), tau_end = tau_mid + optical(m_, b_, second_half_);
        result.tau = tau_end;
        for (size_t v = 0; v < first_half_.size(); ++v)
            result.true_tau += scene_.volumes[v].sigma_t * (first_half_[v] + second_half_[v]);
        if (result.half_way >= 1e30)
            if (const auto part = part_to_half(a_.tau, tau_end))
                result.half_way = t0 + (t1 - t0) * std::clamp(*part, 0.0, 1.0);
        // Only the depth still counts.
        if (thinnest(a_.tau) > opaque) {
            b_.t = -1;
            return;
        }
        ++result.lit;
        set_depth(m_, tau_mid);
        set_depth(b_, tau_end);
        for (size_t v = 0; v < whole_.size(); ++v) whole_[v] = first_half_[v] + second_half_[v];
        for (Node* node : {&a_, &m_, &b_}) find_beams(*node);
        for (size_t l = 0; l < scene_.lights.size(); ++l)
            result.direct[l] += extrapolate(scattered(l, a_, m_, first_half_) + scattered(l, m_, b_, second_half_),
                                            scattered(l, a_, b_, whole_));
        if (!has_other_sources_) return;
        for (size_t v = 0; v < whole_.size(); ++v) {
            if (scene_.volumes[v].emission)
                result.emission += extrapolate(emitted(v, a_, m_) + emitted(v, m_, b_), emitted(v, a_, b_));
            if (scene_.volumes[v].phi)
                result.multiple +=
                    extrapolate(rescattered(v, a_, m_, first_half_) + rescattered(v, m_, b_, second_half_),
                                rescattered(v, a_, b_, whole_));
        }
    }

    /// Fourth order from second, of halves and whole; never of another sign than the halves.
    static Vec3d extrapolate(const Vec3d& halves, const Vec3d& whole)
    {
        Vec3d better = halves + (halves - whole) / 3;
        for (int c = 0; c < 3; ++c)
            if (better[c] * halves[c] < 0) better[c] = halves[c];
        return better;
    }

    void set_local(Node& node, double t)
    {
        node.t = t;
        for (size_t v = 0; v < node.volume.size(); ++v) {
            const auto& volume = scene_.volumes[v];
            node.volume[v].albedo = volume.colour ? media_.albedo(v, t) : volume.albedo;
            if (volume.phi) node.volume[v].collided = media_.collided(v, t);
            if (volume.emission) node.volume[v].emission = media_.emission(v, t);
        }
    }

    void set_depth(Node& node, const Vec3d& tau)
    {
        node.tau = tau;
        for (auto& beam : node.beam) beam.known = false;
        if (has_other_sources_) node.transmittance = {std::exp(-tau[0]), std::exp(-tau[1]), std::exp(-tau[2])};
    }

    /// The beams of all lights for the volumes that scatter in this step.
    void find_beams(Node& node)
    {
        for (size_t v = 0; v < whole_.size(); ++v) {
            if (!(whole_[v] > 0) || !scene_.volumes[v].is_medium()) continue;
            for (size_t l = 0; l < scene_.lights.size(); ++l) {
                auto& beam = node.beam[beam_number(l, v)];
                if (beam.known) continue;
                beam.known = true;
                beam.depth = media_.light_depth(l, v, node.t);
                for (int c = 0; c < channels_; ++c) beam.transmittance[c] = std::exp(-(node.tau[c] + beam.depth[c]));
            }
        }
    }

    /// Scattering coefficient integrated over a stretch: sigma_t * albedo * density depth.
    Vec3d scattering(size_t v, const Node& from, const Node& to, const std::vector<double>& depth) const
    {
        return scene_.volumes[v].sigma_t * (0.5 * (from.volume[v].albedo + to.volume[v].albedo)) * depth[v];
    }

    /// The scattering depth x that belongs to a scaled optical depth y (forward_peak.h): albedo / (1 - f albedo) y. Of
    /// media that overlap their peaks add up, x = (sum of f albedo sigma_t) / (f of this medium x sum of sigma_t') y,
    /// taken as mixed all along the beam as they are here.
    Vec3d peak_depth(size_t v, const Node& from, const Node& to, const std::vector<double>& depth, const Vec3d& y) const
    {
        const auto albedo = [&](size_t u) { return 0.5 * (from.volume[u].albedo + to.volume[u].albedo); };
        const DeltaScaling& own = scene_.volumes[v].scaling;
        Vec3d x, peaks(0), all(0);
        for (size_t u = 0; media_count_ > 1 && u < depth.size(); ++u) {
            peaks += scene_.volumes[u].scaling.delta_f * scattering(u, from, to, depth);
            all += media_.extinction(u, albedo(u)) * depth[u];
        }
        for (int c = 0; c < 3; ++c)
            x[c] = media_count_ == 1 ? albedo(v)[c] * y[c] / own.extinction(albedo(v)[c])
                   : all[c] > 0      ? peaks[c] / (own.delta_f * all[c]) * y[c]
                                     : 0.0;
        return x;
    }

    /// A light's beam, scattered once towards the eye.
    Vec3d scattered(size_t l, const Node& from, const Node& to, const std::vector<double>& depth) const
    {
        Vec3d sum(0);
        for (size_t v = 0; v < depth.size(); ++v) {
            if (!(depth[v] > 0) || !scene_.volumes[v].is_medium()) continue;
            const auto &p = from.beam[beam_number(l, v)], &q = to.beam[beam_number(l, v)];
            Vec3d weight = scattering(v, from, to, depth) * media_.arriving(l, v, from.t, to.t), mean(0);
            if (scene_.volumes[v].peak)
                weight *= media_.peak(l, v, (from.t + to.t) / 2,
                                      peak_depth(v, from, to, depth, 0.5 * (from.tau + p.depth + to.tau + q.depth)));
            for (int c = 0; c < channels_; ++c)
                mean[c] = mean_exponential(p.transmittance[c], q.transmittance[c],
                                           to.tau[c] + q.depth[c] - from.tau[c] - p.depth[c]);
            for (int c = channels_; c < 3; ++c) mean[c] = mean[0];
            sum += weight * mean;
        }
        return sum;
    }

    static Vec3d mean_transmittance(const Node& from, const Node& to)
    {
        Vec3d mean;
        for (int c = 0; c < 3; ++c)
            mean[c] = mean_exponential(from.transmittance[c], to.transmittance[c], to.tau[c] - from.tau[c]);
        return mean;
    }

    Vec3d emitted(size_t v, const Node& from, const Node& to) const
    {
        return 0.5 * (from.volume[v].emission + to.volume[v].emission) * mean_transmittance(from, to) * (to.t - from.t);
    }

    Vec3d rescattered(size_t v, const Node& from, const Node& to, const std::vector<double>& depth) const
    {
        return 0.5 * (from.volume[v].collided + to.volume[v].collided) * scattering(v, from, to, depth) *
               scene_.volumes[v].scaling.scattering() * mean_transmittance(from, to);
    }

    const PreparedScene& scene_;
    RayMedia media_;
    static constexpr double longest = 0.5;  // step, over its distance from a lamp

    int parts_, channels_;
    bool has_lamps_ = false;
    int media_count_ = 0;
    std::vector<double> cuts_;                // of a stretch, near lamps
    bool has_other_sources_ = false;          // emission or light scattered more than once
    std::vector<std::vector<Piece>> pieces_;  // several volumes
    std::vector<std::pair<size_t, const Piece*>> active_;
    Piece current_{};                                       // one volume
    std::vector<double> first_half_, second_half_, whole_;  // depths of a step, each volume [density x world unit]
    Node a_, m_, b_;                                        // its points
};

}  // namespace

std::unique_ptr<RayIntegrator> make_cells_integrator(const PreparedScene& scene, const IntegratorOptions& options)
{
    if (scene.volumes.size() == 1 && scene.volumes[0].fields) return make_plain_cells_integrator(scene);
    return std::make_unique<Cells>(scene, options);
}

}  // namespace vdbcloud
