#include "support/monte_carlo.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/optics/optical_depth.h"

#include <algorithm>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace vdbcloud::test {

namespace {

double phase(double g, double c) { return (1 - g * g) / (4 * pi * std::pow(1 + g * g - 2 * g * c, 1.5)); }

Vec3d turned(const Vec3d& w, double g, double u, double v)
{
    double c = 2 * u - 1;
    if (std::abs(g) > 1e-6) {
        const double s = (1 - g * g) / (1 - g + 2 * g * u);
        c = (1 + g * g - s * s) / (2 * g);
    }
    const double s = std::sqrt(std::max(0.0, 1 - c * c)), a = 2 * pi * v;
    const Vec3d x = (std::abs(w[0]) < 0.8 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0)).cross(w).unit(), y = w.cross(x);
    return (c * w + s * std::cos(a) * x + s * std::sin(a) * y).unit();
}

}  // namespace

double radiance_sample(const McMedium& m, const WorldRay& ray, double length, uint64_t seed, uint64_t path)
{
    uint64_t drawn = 0;
    const auto next = [&] { return uniform(hash_bits(seed, path, drawn++)); };
    const double most = m.sigma_t * m.densest;
    WorldRay r = ray;
    double weight = 1, sum = 0, t = 0;
    for (;;) {
        t -= std::log(1 - next()) / most;
        if (t > length) return sum;
        const Vec3d x = r.at(t);
        const double share = m.density->sample(m.density->index_from_world().point(x)) / m.densest;
        if (next() >= share) continue;
        weight *= m.w0;
        const double depth = density_depth(*m.density, {x, m.to_sun}, 0, length);
        // Light scatters to -direction, towards the eye.
        sum += weight * phase(m.g, r.direction.dot(m.to_sun)) * std::exp(-m.sigma_t * depth);
        if (weight < 0.3) {
            if (next() < 0.5) return sum;
            weight *= 2;
        }
        const double u = next(), v = next();
        r = {x, turned(r.direction, m.g, u, v)};
        t = 0;
    }
}

McPower power_through(const McMedium& medium, const Vec3d& corner, const Vec3d& u, const Vec3d& v, const Vec3d& inward,
                      double length, uint64_t seed, uint64_t paths)
{
    const Vec3d x = u.unit(), y = inward.cross(x);
    std::vector<double> sample(paths);
    tbb::parallel_for(uint64_t(0), paths, [&](uint64_t k) {
        const auto number = [&](uint64_t n) { return uniform(hash_bits(seed, 77, k, n)); };
        const double sine2 = number(2), turn = 2 * pi * number(3), sine = std::sqrt(sine2);
        const Vec3d w = inward * std::sqrt(1 - sine2) + x * (sine * std::cos(turn)) + y * (sine * std::sin(turn));
        const double across = (double(k) + number(0)) / double(paths);
        sample[k] = radiance_sample(medium, {corner + across * u + number(1) * v, w}, length, seed, k);
    });
    double sum = 0, squares = 0;
    for (const double radiance : sample) {
        sum += radiance;
        squares += radiance * radiance;
    }
    const double mean = sum / double(paths), to_power = pi * u.cross(v).length();
    return {mean * to_power,
            std::sqrt(std::max(squares / double(paths) - mean * mean, 0.0) / double(paths)) * to_power};
}

}  // namespace vdbcloud::test
