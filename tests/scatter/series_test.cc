// The perturbation series: its radius, its sums and its Galerkin form against direct solves of the same discrete
// problem.
#include "vdbcloud/scatter/series.h"

#include "scatter/fields.h"
#include "vdbcloud/core/error.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vdbcloud {
namespace {

/// A periodic slab of n voxels along y, of optical depth tau, lit obliquely from above.
struct Slab : test::P1Case {
    Slab(int n, double tau_)
        : P1Case(test::voxel_field(Vec3i(8, n, 8), Vec3d(1.0 / n), [](const Vec3i&) { return 1.0; }),
                 {true, false, true}),
          tau(tau_)
    {
        sources.beams.emplace_back(periodic_beam_depths(index, exposed, density, sun), 2.0);
        sources.sky.fill(0.1);
    }
    P1Medium medium(double albedo, double g, bool delta) const { return {tau, albedo, nullptr, test::hg(g), delta}; }

    std::vector<double> direct(double albedo, double g, bool delta) const
    {
        const P1Operator p1(index, density, exposed, medium(albedo, g, delta));
        P1Source source(p1);
        add_beam(p1, sources.beams[0].first, tau * p1.scaling(0).extinction, {{&source, sources.beams[0].second}});
        add_sky(p1, sources.sky, source);
        Multigrid multigrid(p1.stencil());
        std::vector<double> phi;
        SolveOptions options;
        options.tolerance = 1e-11;
        EXPECT_TRUE(solve_p1(p1, multigrid, source, phi, options).converged);
        return phi;
    }

    /// || sum c_j basis_j - direct || / || direct ||
    double error(const AlbedoSeries& series, const std::vector<double>& c, const std::vector<double>& exact) const
    {
        double difference = 0, norm = 0;
        for (size_t slot = 0; slot < index.blocks().count() * 512; ++slot) {
            if (!index.blocks().active(slot)) continue;
            double phi = 0;
            for (size_t j = 0; j < series.size(); ++j) phi += c[j] * double(series.basis[j][slot]);
            difference += (phi - exact[slot]) * (phi - exact[slot]);
            norm += exact[slot] * exact[slot];
        }
        return std::sqrt(difference / norm);
    }

    double tau;
    Light sun = make_sun(Vec3d(0.6, 0.8, 0));
    SeriesSources sources;
};

struct SeriesCase {
    double g;
    bool delta;
};
class Series : public testing::TestWithParam<SeriesCase> {};

TEST_P(Series, PartialSumsMatchTheDirectSolutionInsideTheRadius)
{
    const auto [g, delta] = GetParam();
    const Slab slab(32, 4);
    SeriesOptions options;
    const auto series =
        albedo_series(slab.index, slab.density, slab.exposed, slab.medium(1, g, delta), slab.sources, options);
    ASSERT_EQ(series.size(), 9u);
    EXPECT_TRUE(series.converged);
    const double beta = 0.2 / series.ratio(), albedo = 1 - beta;
    const auto exact = slab.direct(albedo, g, delta);
    double before = 1;
    for (size_t terms = 1; terms <= 9; ++terms) {
        AlbedoSeries part = series;
        for (size_t k = terms; k < 9; ++k)
            for (size_t j = 0; j < 9; ++j) part.map[k * 9 + j] = 0;
        const double error = slab.error(series, partial_sum(part, albedo), exact);
        EXPECT_LT(error, terms < 8 ? 0.6 * before : 1e-4) << terms;
        before = error;
    }
    EXPECT_LT(before, 3e-6);  // 0.2^9 and the basis in single precision
}

TEST_P(Series, GalerkinMatchesTheDirectSolutionWhereTheSumDiverges)
{
    const auto [g, delta] = GetParam();
    const Slab slab(128, 64);
    SeriesOptions options;
    options.galerkin = true;
    const auto series =
        albedo_series(slab.index, slab.density, slab.exposed, slab.medium(1, g, delta), slab.sources, options);
    const auto exact = slab.direct(0.99, g, delta);
    EXPECT_LT(slab.error(series, series_coefficients(series.albedo, series.table, 0.99), exact), 1e-5);
    EXPECT_GT(slab.error(series, partial_sum(series, 0.99), exact), 10);
    EXPECT_GT(0.01 * series.ratio(), 1);
}

INSTANTIATE_TEST_SUITE_P(Media, Series,
                         testing::Values(SeriesCase{0, true}, SeriesCase{0.5, false}, SeriesCase{0.5, true}));

TEST(Series, RatioOfTermsIsTheInverseRadiusOfASlab)
{
    for (double g : {0.0, 0.5}) {
        const double tau = 8;
        const Slab slab(128, tau);
        SeriesOptions options;
        options.order = 10;
        const auto series =
            albedo_series(slab.index, slab.density, slab.exposed, slab.medium(1, g, false), slab.sources, options);
        // The critical slab, w0 = 1 + r: phi = cos(B x) with D B^2 = r, D = 1 / (3 (1 - w0 g)), B tan(B tau / 2) = 1 /
        // (2 D).
        double low = 1e-6, high = 0.3;
        for (int k = 0; k < 200; ++k) {
            const double r = (low + high) / 2, d = 1 / (3 * (1 - (1 + r) * g)), b = std::sqrt(r / d);
            const bool above = b * tau / 2 >= 1.5707963 || b * std::tan(b * tau / 2) > 1 / (2 * d);
            (above ? high : low) = r;
        }
        EXPECT_NEAR(series.ratio() * low, 1, 0.01) << g;
    }
}

TEST(Series, TableInterpolatesAndRefusesAlbedosOutside)
{
    const Slab slab(32, 16);
    SeriesOptions options;
    options.galerkin = true;
    options.order = 6;
    const auto series =
        albedo_series(slab.index, slab.density, slab.exposed, slab.medium(1, 0.5, true), slab.sources, options);
    for (double albedo : {1.0, 0.9999, 0.997, 0.97, 0.9}) {
        SeriesOptions single = options;
        single.least_albedo = albedo < 1 ? albedo : 0.999;
        const auto there =
            albedo_series(slab.index, slab.density, slab.exposed, slab.medium(1, 0.5, true), slab.sources, single);
        const size_t row = albedo < 1 ? 0 : there.albedo.size() - 1;
        const auto c = series_coefficients(series.albedo, series.table, albedo);
        for (size_t j = 0; j < 7; ++j)
            EXPECT_NEAR(c[j], there.table[row * 7 + j], 1e-6 * std::abs(there.table[row * 7])) << albedo << ' ' << j;
    }
    EXPECT_THROW(series_coefficients(series.albedo, series.table, 0.7), InputError);
}

}  // namespace
}  // namespace vdbcloud
