#include "vdbcloud/scatter/world_axes.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/optics/spherical_harmonics.h"
#include "vdbcloud/scatter/ordinates.h"

#include <cmath>

namespace vdbcloud {

namespace {

/// turn[i * n + j] = int Y_i(world) Y_j(index) over the sphere, n harmonics, by a quadrature exact for these products.
std::vector<double> rotation(const VoxelIndex& index, int degree)
{
    const int n = harmonic_count(degree);
    const Ordinates set = ordinates(OrdinateKind::Product, 1, 7);
    std::vector<double> turn(size_t(n) * n, 0.0), in_world(64), in_index(64);
    for (size_t m = 0; m < set.count(); ++m) {
        const Vec3d& s = set.direction[m];
        evaluate_harmonics(degree, s, in_index.data());
        evaluate_harmonics(degree, s[0] * index.axis(0) + s[1] * index.axis(1) + s[2] * index.axis(2), in_world.data());
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) turn[i * n + j] += set.weight[m] * in_world[i] * in_index[j];
    }
    return turn;
}

std::vector<std::vector<float>> turned(const VoxelIndex& index, const std::vector<std::vector<float>>& moments,
                                       int degree, const std::vector<double>& turn)
{
    const int n = harmonic_count(degree);
    std::vector<std::vector<float>> to(static_cast<size_t>(n));
    for (int l = 1; l <= degree; ++l)
        for (int i = l * l; i < (l + 1) * (l + 1); ++i) {
            to[size_t(i)].assign(index.blocks().slots(), 0.0f);
            for (int j = l * l; j < (l + 1) * (l + 1); ++j) {
                const double factor = turn[i * n + j];
                if (std::abs(factor) < 1e-12) continue;
                const auto& from = moments[size_t(j)];
                for (size_t slot = 0; slot < from.size(); ++slot) to[size_t(i)][slot] += float(factor * from[slot]);
            }
        }
    return to;
}

}  // namespace

std::array<std::vector<float>, 3> flux_in_world(const VoxelIndex& index, std::array<std::vector<float>, 3> flux)
{
    for (size_t slot = 0; slot < index.blocks().count() * 512; ++slot) {
        Vec3d f(0, 0, 0);
        for (int a = 0; a < 3; ++a) f += double(flux[a][slot]) * index.axis(a);
        for (int a = 0; a < 3; ++a) flux[a][slot] = float(f[a]);
    }
    return flux;
}

std::vector<std::vector<float>> moments_in_world(const VoxelIndex& index,
                                                 const std::vector<std::vector<float>>& moments, int degree)
{
    return turned(index, moments, degree, rotation(index, degree));
}

std::vector<std::vector<float>> moments_in_index(const VoxelIndex& index,
                                                 const std::vector<std::vector<float>>& moments, int degree)
{
    const std::vector<double> to_world = rotation(index, degree);
    std::vector<double> back(to_world.size());
    const int n = harmonic_count(degree);
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) back[i * n + j] = to_world[j * n + i];
    return turned(index, moments, degree, back);
}

std::array<std::vector<float>, 3> flux_of(const std::vector<std::vector<float>>& moments)
{
    const int of_axis[3] = {harmonic(1, 1), harmonic(1, -1), harmonic(1, 0)};
    std::array<std::vector<float>, 3> flux;
    for (int a = 0; a < 3; ++a) {
        flux[a] = moments[size_t(of_axis[a])];
        for (float& f : flux[a]) f *= float(std::sqrt(4 * pi / 3));
    }
    return flux;
}

}  // namespace vdbcloud
