#include "vdbcloud/scatter/ordinates.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/core/words.h"
#include "vdbcloud/solve/dense.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr auto kinds = words<OrdinateKind>(
    "quadrature", {{OrdinateKind::Product, "product"}, {OrdinateKind::LevelSymmetric, "level-symmetric"}});

constexpr int most_polar = 32;  // polar points per hemisphere of the largest product set

struct ProductSize {
    int polar, azimuths;
    int count() const { return 2 * polar * azimuths; }
    int degree() const { return std::min(polar, azimuths / 2) - 1; }
};

/// All product sets, by count; of two sets of equal count the set of higher degree comes first. A set of p points times
/// 4 p azimuths has the count and the degree of a set of 2 p points times 2 p azimuths. Layers use the second set if it
/// has at least eight azimuths.
std::vector<ProductSize> product_sizes(bool layered)
{
    std::vector<ProductSize> sizes;
    for (int p = 1; p <= most_polar; ++p)
        for (int a : {2 * p, 4 * p})
            if (a % 4 == 0)
                sizes.push_back(layered && a == 4 * p && p >= 4 ? ProductSize{2 * p, 2 * p} : ProductSize{p, a});
    std::stable_sort(sizes.begin(), sizes.end(),
                     [](const ProductSize& a, const ProductSize& b) { return a.count() < b.count(); });
    return sizes;
}

/// Cartesian direction with polar cosine mu about an index axis.
Vec3d about(int polar, double mu, double azimuth)
{
    const double across = std::sqrt((1 - mu) * (1 + mu));
    Vec3d s;
    s[polar] = mu;
    s[(polar + 1) % 3] = across * std::cos(azimuth);
    s[(polar + 2) % 3] = across * std::sin(azimuth);
    return s;
}

Ordinates product_set(const ProductSize& size, int polar)
{
    std::vector<double> node, weight;
    gauss_legendre(size.polar, node, weight);
    Ordinates set;
    set.degree = size.degree();
    // One octant is computed and mirrored, so that the set is symmetric to the last bit.
    for (int sign : {+1, -1})
        for (int p = 0; p < size.polar; ++p)
            for (int quadrant = 0; quadrant < 4; ++quadrant)
                for (int a = 0; a < size.azimuths / 4; ++a) {
                    const int mirror = size.azimuths / 4 - 1 - a;  // about the diagonal: cosine and sine exchanged
                    const double step = 2 * pi / size.azimuths;
                    Vec3d s = about(polar, (1 + node[p]) / 2, (std::min(a, mirror) + 0.5) * step);
                    double& x = s[(polar + 1) % 3];
                    double& y = s[(polar + 2) % 3];
                    if (a == mirror) x = y = std::sqrt((x * x + y * y) / 2);
                    if (a > mirror) std::swap(x, y);
                    if (quadrant & 1) x = -x;
                    if (quadrant & 2) y = -y;
                    s[polar] *= sign;
                    set.direction.push_back(s);
                    set.weight.push_back(weight[p] / 2 * step);
                }
    return set;
}

/// S_N: cosines mu_1 < ... < mu_{N/2}; a point (i, j, k) of an octant has i + j + k = N/2 + 2 and a weight by its
/// class.
struct LevelSet {
    int levels;                               // N / 2
    std::vector<std::array<int, 3>> classes;  // i <= j <= k
    explicit LevelSet(int n) : levels(n / 2)
    {
        for (int i = 1; i <= levels; ++i)
            for (int j = i; j <= levels; ++j)
                for (int k = j; k <= levels; ++k)
                    if (i + j + k == levels + 2) classes.push_back({i, j, k});
    }
    std::vector<double> cosines(double mu1) const
    {
        std::vector<double> mu(size_t(levels) + 1);
        for (int i = 1; i <= levels; ++i)
            mu[i] = std::sqrt(levels == 1 ? 1.0 / 3 : mu1 * mu1 + (i - 1) * (1 - 3 * mu1 * mu1) / (levels - 1));
        return mu;
    }
    /// Mean over the sphere of mu^power if one class had weight 1 in total.
    static double mean_power(const std::vector<double>& mu, const std::array<int, 3>& point, int power)
    {
        return (std::pow(mu[point[0]], power) + std::pow(mu[point[1]], power) + std::pow(mu[point[2]], power)) / 3;
    }
    /// Total weights of the classes that make the means of mu^0, mu^4, mu^6, ... exact, one condition a class.
    std::vector<double> weights(const std::vector<double>& mu) const
    {
        const int n = int(classes.size());
        std::vector<double> a(size_t(n) * n), b(size_t(n), 0.0);
        for (int row = 0; row < n; ++row) {
            const int power = row == 0 ? 0 : 2 * row + 2;
            for (int c = 0; c < n; ++c) a[row * n + c] = mean_power(mu, classes[c], power);
            b[row] = 1.0 / (power + 1);
        }
        return solve_dense(a, b);
    }
    /// Error of the next moment.
    double miss(double mu1) const
    {
        const auto mu = cosines(mu1);
        const auto w = weights(mu);
        const int power = 2 * int(classes.size()) + 2;
        double mean = 0;
        for (size_t c = 0; c < classes.size(); ++c) mean += w[c] * mean_power(mu, classes[c], power);
        return mean - 1.0 / (power + 1);
    }
};

Ordinates level_set(int n, double guess, int degree)
{
    const LevelSet levels(n);
    double mu1 = guess, step = 1e-4;
    for (int k = 0; n > 2 && k < 60 && std::abs(step) > 1e-16; ++k) {  // Newton, slope by a central difference
        const double slope = (levels.miss(mu1 + 1e-6) - levels.miss(mu1 - 1e-6)) / 2e-6;
        step = levels.miss(mu1) / slope;
        mu1 -= step;
    }
    const auto mu = levels.cosines(mu1);
    const auto weight = levels.weights(mu);
    Ordinates set;
    set.kind = OrdinateKind::LevelSymmetric;
    set.degree = degree;
    for (size_t c = 0; c < levels.classes.size(); ++c) {
        auto point = levels.classes[c];
        std::vector<std::array<int, 3>> points;
        do points.push_back(point);
        while (std::next_permutation(point.begin(), point.end()));
        for (const auto& p : points)
            for (int signs = 0; signs < 8; ++signs) {
                set.direction.push_back(Vec3d(signs & 1 ? -mu[p[0]] : mu[p[0]], signs & 2 ? -mu[p[1]] : mu[p[1]],
                                              signs & 4 ? -mu[p[2]] : mu[p[2]]));
                set.weight.push_back(4 * pi * weight[c] / double(8 * points.size()));
            }
    }
    return set;
}

struct LevelSize {
    int n, degree;
    double first_cosine;  // initial guess of mu_1
};
constexpr LevelSize level_sizes[] = {{2, 1, 0.577},  {4, 2, 0.350},   {6, 3, 0.2666},
                                     {8, 4, 0.2182}, {10, 5, 0.1893}, {12, 5, 0.1672}};

}  // namespace

const char* name(OrdinateKind kind) { return kinds.word(kind); }

OrdinateKind ordinate_kind(const std::string& text) { return kinds.value(text); }

Ordinates ordinates(OrdinateKind kind, int count, int degree, int polar, bool layered)
{
    if (count < 1) throw InputError(std::to_string(count) + " directions: expected at least 1");
    if (degree < 0 || degree > 7) throw InputError("degree " + std::to_string(degree) + ": expected 0 to 7");
    if (polar < 0 || polar > 2) throw InputError("polar axis " + std::to_string(polar) + ": expected 0, 1 or 2");
    if (kind == OrdinateKind::Product) {
        const auto sizes = product_sizes(layered);
        for (const ProductSize& size : sizes)
            if (size.count() >= count && size.degree() >= degree) return product_set(size, polar);
        throw InputError(std::to_string(count) + " directions: expected at most " +
                         std::to_string(sizes.back().count()));
    }
    for (const LevelSize& size : level_sizes)
        if (size.n * (size.n + 2) >= count && size.degree >= degree)
            return level_set(size.n, size.first_cosine, size.degree);
    throw InputError("a level-symmetric set of " + std::to_string(count) + " directions for degree " +
                     std::to_string(degree) + ": expected at most 168 directions and degree 5; product sets have more");
}

void gauss_legendre(int n, std::vector<double>& node, std::vector<double>& weight)
{
    node.assign(size_t(n), 0.0);
    weight.assign(size_t(n), 0.0);
    for (int i = 0; i < n; ++i) {
        double x = -std::cos(pi * (i + 0.75) / (n + 0.5)), slope = 1;
        for (int k = 0; k < 100; ++k) {
            double before = 1, now = x;  // P_0, P_1
            for (int l = 1; l < n; ++l) {
                const double next = ((2 * l + 1) * x * now - l * before) / (l + 1);
                before = now;
                now = next;
            }
            slope = n * (x * now - before) / (x * x - 1);
            const double step = now / slope;
            x -= step;
            if (std::abs(step) < 1e-16) break;
        }
        node[i] = x;
        weight[i] = 2 / ((1 - x * x) * slope * slope);
    }
}

}  // namespace vdbcloud
