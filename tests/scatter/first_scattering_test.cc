// The first scattering of a sun's light on ordinates.
#include "vdbcloud/scatter/first_scattering.h"

#include "vdbcloud/core/constants.h"
#include "vdbcloud/optics/spherical_harmonics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

const Vec3d ways[] = {{0, -1, 0}, Vec3d(0.6, -0.7, 0.2).unit()};

Ordinates set_of(int degree)
{
    return ordinates(OrdinateKind::Product, degree == 1 ? 64 : degree == 3 ? 128 : 256, degree);
}

TEST(FirstScattering, HasTheMomentsOfTheExpansion)
{
    // Also along a direction of the set, where a sharp peak is seen whole: without a limit it is up to 1e10 times the
    // rest.
    const PhaseFunction phases[] = {PhaseFunction::henyey_greenstein(0.85), PhaseFunction::henyey_greenstein(-0.4),
                                    PhaseFunction::henyey_greenstein(0.99), PhaseFunction::henyey_greenstein(0.99999),
                                    PhaseFunction("hg-draine", {20})};
    for (const PhaseFunction& phase : phases)
        for (const int degree : {1, 3, 7})
            for (const Vec3d& way : {ways[0], ways[1], set_of(degree).direction[5]}) {
                const Ordinates set = set_of(degree);
                const DeltaScaling scaling = delta_scaling(phase, degree);
                const auto found = first_scattering(set, phase, scaling, way);
                const size_t terms = size_t(harmonic_count(degree));
                std::vector<double> y(terms), of_way(terms), moment(terms, 0.0);
                evaluate_harmonics(degree, way, of_way.data());
                for (size_t m = 0; m < set.count(); ++m) {
                    evaluate_harmonics(degree, set.direction[m], y.data());
                    for (size_t k = 0; k < terms; ++k) moment[k] += set.weight[m] * y[k] * found[m];
                }
                for (int l = 0, k = 0; l <= degree; ++l)
                    for (const int end = harmonic_count(l); k < end; ++k)
                        EXPECT_NEAR(moment[size_t(k)], scaling.moments[size_t(l)] * of_way[size_t(k)], 1e-9)
                            << phase.text() << ' ' << degree << ' ' << k;
            }
}

/// The root mean square over directions at more than 70 degrees from `way` of the relative difference from the phase
/// function.
double off(const Ordinates& set, const std::vector<double>& value, const PhaseFunction& phase,
           const DeltaScaling& scaling, const Vec3d& way)
{
    double sum = 0, weight = 0;
    for (size_t m = 0; m < set.count(); ++m) {
        const double cosine = set.direction[m].dot(way);
        if (cosine > std::cos(70 * pi / 180)) continue;
        const double relative = value[m] / (phase(cosine) / scaling.scattering()) - 1;
        sum += set.weight[m] * relative * relative;
        weight += set.weight[m];
    }
    return std::sqrt(sum / weight);
}

TEST(FirstScattering, IsThePhaseFunctionAtLargeAngles)
{
    // The directions nearest to the peak are 10 to 25 degrees wide and stand for it; what they cannot carry is spread.
    const PhaseFunction phase = PhaseFunction::henyey_greenstein(0.85);
    for (const auto& [degree, most, expansion] : {std::tuple(1, 0.35, 0.8), {3, 0.3, 0.8}, {7, 0.2, 0.6}})
        for (const Vec3d& way : ways) {
            const Ordinates set = set_of(degree);
            const DeltaScaling scaling = delta_scaling(phase, degree);
            EXPECT_LT(off(set, first_scattering(set, phase, scaling, way), phase, scaling, way), most) << degree;
            EXPECT_GT(off(set, expanded_scattering(set, scaling, way), phase, scaling, way), expansion) << degree;
        }
}

TEST(FirstScattering, IsTheExpansionWhereThatIsComplete)
{
    for (const auto& [phase, degree] : {std::pair(PhaseFunction(), 1), {PhaseFunction("rayleigh"), 3}})
        for (const Vec3d& way : ways) {
            const Ordinates set = set_of(degree);
            const DeltaScaling scaling = delta_scaling(phase, degree);
            const auto found = first_scattering(set, phase, scaling, way),
                       expanded = expanded_scattering(set, scaling, way);
            for (size_t m = 0; m < set.count(); ++m) {
                EXPECT_NEAR(found[m], expanded[m], 1e-12);
                EXPECT_NEAR(found[m], phase(set.direction[m].dot(way)), 1e-12);
            }
        }
}

}  // namespace
}  // namespace vdbcloud
