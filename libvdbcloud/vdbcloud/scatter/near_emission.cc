#include "vdbcloud/scatter/near_emission.h"

#include "vdbcloud/optics/spherical_harmonics.h"
#include "vdbcloud/scatter/ordinates.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr int width = NearEmission::width, middle = width / 2;
constexpr int ray_count = 128;

int node_at(const Vec3i& from_middle)
{
    return ((from_middle[0] + middle) * width + from_middle[1] + middle) * width + from_middle[2] + middle;
}

/// Integrals of e^-tau(t) and t e^-tau(t), t from 0 to 1, for extinction that is linear from `a` to `b` over `length`.
struct Weights {
    double whole, far, transmittance;

    Weights(double a, double b, double length)
    {
        const double tau = (a + b) / 2 * length, lean = (b - a) * length;
        transmittance = std::exp(-tau);
        if (tau > 0.02) {
            whole = (1 - transmittance) / tau;
            far = (whole - transmittance) / tau;
        } else {
            whole = 1 - tau / 2 * (1 - tau / 3);
            far = 0.5 - tau / 3 * (1 - 3 * tau / 8);
        }
        // First order in the lean: exact in the limits of small and of large tau.
        whole = std::max(whole + lean / (12 + tau * (6 + 2 * tau)), 0.0);
        far = std::clamp(far + lean / (24 + tau * (12 + tau * (6 + tau))), 0.0, whole);
    }
};

}  // namespace

NearEmission::NearEmission(const Vec3d& spacing, int degree) : terms_(harmonic_count(degree))
{
    const Ordinates set = ordinates(OrdinateKind::Product, ray_count, degree);
    std::vector<double> y(static_cast<size_t>(terms_));
    for (size_t m = 0; m < set.count(); ++m) {
        Vec3d step;  // [voxels], away from the middle
        for (int a = 0; a < 3; ++a) step[a] = -set.direction[m][a] / spacing[a];
        int axis = 0;
        for (int a = 1; a < 3; ++a)
            if (std::abs(step[a]) > std::abs(step[axis])) axis = a;
        Ray ray;
        ray.step = middle / (std::abs(step[axis]) * samples);
        for (int n = 0; n < samples; ++n) {
            const Vec3d at = step * (ray.step * (n + 1));
            Vec3i base;
            for (int a = 0; a < 3; ++a) base[a] = std::clamp(int(std::floor(at[a])), -middle, middle - 1);
            Sample& sample = ray.sample[size_t(n)];
            for (int k = 0; k < 8; ++k) {
                Vec3i node = base;
                double weight = 1;
                for (int a = 0; a < 3; ++a) {
                    const int up = k >> a & 1;
                    node[a] += up;
                    weight *= up ? at[a] - base[a] : 1 - (at[a] - base[a]);
                }
                sample.node[size_t(k)] = node_at(node);
                sample.weight[size_t(k)] = float(weight);
            }
        }
        rays_.push_back(ray);
        evaluate_harmonics(degree, set.direction[m], y.data());
        for (const double value : y) basis_.push_back(value * set.weight[m]);
    }
}

void NearEmission::add(const Field& emission, const Field& sigma, double* moments) const
{
    const auto value = [](const Field& field, const Sample& sample) {
        double sum = 0;
        for (size_t k = 0; k < 8; ++k) sum += double(sample.weight[k]) * field[size_t(sample.node[k])];
        return sum;
    };
    constexpr size_t own = NearEmission::nodes / 2;
    for (size_t m = 0; m < rays_.size(); ++m) {
        const Ray& ray = rays_[m];
        double j = emission[own], s = sigma[own], radiance = 0, transmittance = 1;
        for (const Sample& sample : ray.sample) {
            const double j_next = value(emission, sample), s_next = value(sigma, sample);
            const Weights step(s, s_next, ray.step);
            radiance += transmittance * (j * (step.whole - step.far) + j_next * step.far);
            transmittance *= step.transmittance;
            j = j_next;
            s = s_next;
        }
        const double* basis = basis_.data() + m * size_t(terms_);
        for (int k = 0; k < terms_; ++k) moments[k] += ray.step * radiance * basis[k];
    }
}

}  // namespace vdbcloud
