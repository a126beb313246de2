#include "vdbcloud/scatter/first_scattering.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/optics/spherical_harmonics.h"
#include "vdbcloud/solve/dense.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace vdbcloud {

namespace {

/// m_l' Y_lm(along), l <= degree of the scaling: the moments of scaled scattering.
std::vector<double> scattered_moments(const DeltaScaling& scaling, const Vec3d& along)
{
    std::vector<double> y(size_t(harmonic_count(scaling.degree)));
    evaluate_harmonics(scaling.degree, along, y.data());
    for (int l = 0, k = 0; l <= scaling.degree; ++l)
        for (const int end = harmonic_count(l); k < end; ++k) y[size_t(k)] *= scaling.moments[size_t(l)];
    return y;
}

/// Y_lm(s_m), direction by direction.
std::vector<double> harmonics_of(const Ordinates& set, int degree)
{
    const size_t terms = size_t(harmonic_count(degree));
    std::vector<double> y(set.count() * terms);
    for (size_t m = 0; m < set.count(); ++m) evaluate_harmonics(degree, set.direction[m], y.data() + m * terms);
    return y;
}

/// The greatest value that the expansion can have: where all its terms add.
double peak(const DeltaScaling& scaling)
{
    double sum = 0;
    for (int l = 0; l <= scaling.degree; ++l) sum += (2 * l + 1) / (4 * pi) * std::abs(scaling.moments[size_t(l)]);
    return sum;
}

}  // namespace

std::vector<double> expanded_scattering(const Ordinates& set, const DeltaScaling& scaling, const Vec3d& along)
{
    const std::vector<double> moments = scattered_moments(scaling, along), y = harmonics_of(set, scaling.degree);
    std::vector<double> value(set.count(), 0.0);
    for (size_t m = 0; m < set.count(); ++m)
        for (size_t k = 0; k < moments.size(); ++k) value[m] += y[m * moments.size() + k] * moments[k];
    return value;
}

std::vector<double> first_scattering(const Ordinates& set, const PhaseFunction& phase, const DeltaScaling& scaling,
                                     const Vec3d& along)
{
    std::vector<double> value(set.count());
    for (size_t m = 0; m < set.count(); ++m)
        value[m] = std::min(phase(set.direction[m].dot(along)) / scaling.scattering(), peak(scaling));
    std::vector<double> missing = scattered_moments(scaling, along);
    const std::vector<double> y = harmonics_of(set, scaling.degree);
    const size_t terms = missing.size();
    std::vector<double> normal(terms * terms, 0.0);
    const auto room = [](double target) { return target * target * target; };
    for (size_t m = 0; m < set.count(); ++m) {
        const double* of = y.data() + m * terms;
        for (size_t j = 0; j < terms; ++j) {
            missing[j] -= set.weight[m] * of[j] * value[m];
            for (size_t k = 0; k <= j; ++k) normal[j * terms + k] += set.weight[m] * of[j] * of[k] * room(value[m]);
        }
    }
    const std::vector<double> a = SemidefiniteFactor(normal, terms, 1e-13).solve(missing);
    for (size_t m = 0; m < set.count(); ++m) {
        double change = 0;
        for (size_t k = 0; k < terms; ++k) change += y[m * terms + k] * a[k];
        value[m] += room(value[m]) * change;
    }
    return value;
}

}  // namespace vdbcloud
