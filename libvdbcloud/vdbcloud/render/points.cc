// The integrators that see the medium as a function of distance: a midpoint rule with a fixed step, and the paper's
// Romberg rule over the whole ray. Both evaluate extinction and source at points, independent of cells.
#include "vdbcloud/optics/optical_depth.h"
#include "vdbcloud/render/cell_rule.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vdbcloud {

namespace {

/// Extinction and source at one point of a ray, and the values that are integrated: for each output a Vec3d.
class Points : public RayIntegrator {
protected:
    Points(const PreparedScene& scene) : scene_(scene), media_(scene), outputs_(scene.lights.size() + 2) {}

    /// sigma_t at t; the sources per length go to source[0..outputs): lights, multiple, emission.
    Vec3d evaluate(double t, double width, Vec3d* source)
    {
        std::fill(source, source + outputs_, Vec3d(0));
        Vec3d sigma_t(0);
        const size_t lights = scene_.lights.size();
        for (size_t v = 0; v < scene_.volumes.size(); ++v) {
            const auto& volume = scene_.volumes[v];
            if (volume.emission) source[lights + 1] += media_.emission(v, t);
            if (!volume.is_medium()) continue;
            const double density = media_.density(v, t);
            if (!(density > 0)) continue;
            const Vec3d albedo = media_.albedo(v, t), scattering = volume.sigma_t * albedo * density;
            sigma_t += media_.extinction(v, albedo) * density;
            for (size_t l = 0; l < lights; ++l) {
                const Vec3d scattered = scattering * media_.arriving(l, v, t - width / 2, t + width / 2);
                if (scattered != Vec3d(0)) source[l] += scattered * attenuation(media_.light_depth(l, v, t));
            }
            if (volume.phi) source[lights] += volume.scaling.scattering() * scattering * media_.collided(v, t);
        }
        return sigma_t;
    }

    static Vec3d attenuation(const Vec3d& tau) { return {std::exp(-tau[0]), std::exp(-tau[1]), std::exp(-tau[2])}; }

    void store(const std::vector<Vec3d>& sum, const Vec3d& tau, RayResult& result) const
    {
        const size_t lights = scene_.lights.size();
        std::copy(sum.begin(), sum.begin() + std::ptrdiff_t(lights), result.direct.begin());
        result.multiple = sum[lights];
        result.emission = sum[lights + 1];
        result.tau = result.true_tau = tau;
        if (!scene_.scaled) return;
        result.true_tau = Vec3d(0);  // not what these rules integrate: taken from the cells
        for (const auto& v : scene_.volumes)
            result.true_tau += v.sigma_t * density_depth(v.density, media_.ray(), 0, media_.end());
    }

    const PreparedScene& scene_;
    RayMedia media_;
    size_t outputs_;
};

/// t at which the mean of exp(-tau) falls to one half, given tau at evenly spaced points; 1e30: nowhere.
double half_way(const std::vector<Vec3d>& tau, double t0, double h)
{
    for (size_t n = 1; n < tau.size(); ++n)
        if (const auto part = part_to_half(tau[n - 1], tau[n])) return t0 + h * (double(n - 1) + *part);
    return 1e30;
}

/// The shortest edge of a voxel of the scene's volumes [world unit].
double shortest_edge(const PreparedScene& scene)
{
    double edge = std::numeric_limits<double>::infinity();
    for (const auto& v : scene.volumes)
        for (int a = 0; a < 3; ++a) {
            const Vec3d unit(a == 0, a == 1, a == 2);
            edge = std::min(edge, v.density.world_from_index().vector(unit).length());
        }
    return edge;
}

class Steps : public Points {
public:
    Steps(const PreparedScene& scene, const IntegratorOptions& options)
        : Points(scene), step_(options.step * shortest_edge(scene))
    {
    }

    void operator()(const WorldRay& ray, RayResult& result) override
    {
        result.clear(scene_.lights.size());
        media_.set(ray);
        result.hit = media_.hit();
        double t0, t1;
        if (!media_.bounds(t0, t1)) return;
        // Rounding does not decide on a further step where the way is a whole number of steps.
        const auto count = size_t(std::ceil((t1 - t0) / step_ * (1 - 1e-9)));
        const double h = (t1 - t0) / double(count);
        std::vector<Vec3d> sum(outputs_, Vec3d(0)), source(outputs_);
        Vec3d tau(0);
        for (size_t n = 0; n < count; ++n, ++result.cells) {
            const Vec3d sigma_t = evaluate(t0 + (double(n) + 0.5) * h, h, source.data());
            // The source of a step is attenuated by what lies before it and by half of the step itself.
            const Vec3d transmittance = attenuation(tau + 0.5 * h * sigma_t);
            for (size_t k = 0; k < outputs_; ++k) sum[k] += h * transmittance * source[k];
            const Vec3d before = tau;
            tau += h * sigma_t;
            if (result.half_way >= 1e30)
                if (const auto part = part_to_half(before, tau)) result.half_way = t0 + h * (double(n) + *part);
        }
        store(sum, tau, result);
    }

private:
    double step_;  // [world unit]
};

/// Trapezoid sums of optical depth and of the attenuated sources on 2^k intervals have errors in even powers of the
/// spacing where the integrand is smooth; Romberg's table removes them one after the other. Optical depth inside the
/// attenuation is the trapezoid sum of the same level, so that it takes part in the extrapolation.
class Romberg : public Points {
public:
    Romberg(const PreparedScene& scene, const IntegratorOptions& options)
        : Points(scene), tolerance_(options.tolerance), edge_(shortest_edge(scene))
    {
    }

    void operator()(const WorldRay& ray, RayResult& result) override
    {
        result.clear(scene_.lights.size());
        media_.set(ray);
        result.hit = media_.hit();
        double t0, t1;
        if (!media_.bounds(t0, t1)) return;
        sigma_.assign(1, Vec3d(0));
        source_.assign(outputs_, Vec3d(0));
        std::vector<std::vector<Vec3d>> before, row;  // the table's last two rows: [order][output], tau last
        for (int level = 0;; ++level) {
            refine(t0, t1, level, result);
            const auto sums = trapezoid(t1 - t0, level);
            row.assign(1, sums);
            double factor = 1;
            for (size_t k = 1; k <= before.size(); ++k) {
                factor *= 4;
                row.push_back(row[k - 1]);
                for (size_t m = 0; m < sums.size(); ++m) row[k][m] += (row[k - 1][m] - before[k - 1][m]) / (factor - 1);
            }
            const bool last = level == finest;
            // An interval is no longer than a voxel, so that a wisp between two points is not taken for none: trilinear
            // values of one voxel reach over two. Thirty-two intervals at the least.
            const bool resolved = level >= 5 && (t1 - t0) <= edge_ * double(size_t(1) << level);
            if (last || (resolved && close(row[row.size() - 1], before[before.size() - 1]))) {
                result.converged = !last;
                // Where the integrand has kinks the table's corner is no better than its first columns: take the
                // second, Simpson's, when the rule has not converged.
                auto& best = last ? row[1] : row.back();
                const Vec3d tau = best.back();
                best.pop_back();
                store(best, tau, result);
                result.half_way = half_way(tau_, t0, (t1 - t0) / double(tau_.size() - 1));
                return;
            }
            before = row;
        }
    }

private:
    static constexpr int finest = 12;

    /// Evaluates the points that level adds, and orders all by t.
    void refine(double t0, double t1, int level, RayResult& result)
    {
        const size_t count = size_t(1) << level;
        const double h = (t1 - t0) / double(count);
        std::vector<Vec3d> sigma(count + 1), source((count + 1) * outputs_);
        for (size_t n = 0; n <= count; ++n) {
            if (level > 0 && n % 2 == 0) {
                sigma[n] = sigma_[n / 2];
                std::copy_n(source_.begin() + std::ptrdiff_t(n / 2 * outputs_), outputs_,
                            source.begin() + std::ptrdiff_t(n * outputs_));
            } else {
                sigma[n] = evaluate(t0 + double(n) * h, 1e-6 * h, &source[n * outputs_]);
                ++result.cells;
            }
        }
        sigma_.swap(sigma);
        source_.swap(source);
    }

    /// The trapezoid sums of this level: each output, then tau.
    std::vector<Vec3d> trapezoid(double length, int level)
    {
        const size_t count = size_t(1) << level;
        const double h = length / double(count);
        std::vector<Vec3d> sum(outputs_ + 1, Vec3d(0));
        tau_.assign(count + 1, Vec3d(0));
        for (size_t n = 1; n <= count; ++n) tau_[n] = tau_[n - 1] + 0.5 * h * (sigma_[n - 1] + sigma_[n]);
        for (size_t n = 0; n <= count; ++n) {
            const Vec3d transmittance = attenuation(tau_[n]) * (n == 0 || n == count ? 0.5 * h : h);
            for (size_t k = 0; k < outputs_; ++k) sum[k] += transmittance * source_[n * outputs_ + k];
        }
        sum[outputs_] = tau_[count];
        return sum;
    }

    bool close(const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) const
    {
        const double scale = source_scale();
        for (size_t k = 0; k < a.size(); ++k)
            for (int c = 0; c < 3; ++c) {
                const double largest = k == outputs_ ? std::max(1.0, a[k][c]) : scale;
                if (std::abs(a[k][c] - b[k][c]) > tolerance_ * largest) return false;
            }
        return true;
    }

    /// The largest source function, source over extinction, met so far: the radiance a thick medium of it would have.
    double source_scale() const
    {
        double scale = 1e-300;
        for (size_t n = 0; n < sigma_.size(); ++n)
            for (size_t k = 0; k < outputs_; ++k)
                for (int c = 0; c < 3; ++c)
                    if (sigma_[n][c] > 0) scale = std::max(scale, source_[n * outputs_ + k][c] / sigma_[n][c]);
        return scale;
    }

    double tolerance_;
    double edge_;  // [world unit]
    std::vector<Vec3d> sigma_, source_, tau_;
};

}  // namespace

std::unique_ptr<RayIntegrator> make_romberg_integrator(const PreparedScene& scene, const IntegratorOptions& options)
{
    return std::make_unique<Romberg>(scene, options);
}

std::unique_ptr<RayIntegrator> make_steps_integrator(const PreparedScene& scene, const IntegratorOptions& options)
{
    return std::make_unique<Steps>(scene, options);
}

}  // namespace vdbcloud
