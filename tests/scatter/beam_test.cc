// Uncollided light as a source: depths, powers and fluences of a beam against closed forms.
#include "vdbcloud/scatter/beam.h"

#include "scatter/fields.h"
#include "vdbcloud/core/error.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace vdbcloud {
namespace {

/// A case without delta-M scaling, and its bricks.
struct Body : test::P1Case {
    explicit Body(const FloatGridPtr& of, std::array<bool, 3> periodic = {false, false, false})
        : P1Case(of, periodic), bricks(*of)
    {
    }
    P1Operator p1(double sigma_t, double albedo, double g) const
    {
        return P1Operator(index, density, exposed,
                          {sigma_t, albedo, nullptr, PhaseFunction::henyey_greenstein(g), false});
    }
    size_t slot(int x, int y, int z) const { return index.blocks().slot(Vec3i(x, y, z) - index.origin()); }

    BrickMap bricks;
};

constexpr int layers = 8;

/// A layer of density 1, periodic along x and z, of `layers` voxels of edge 1 along y.
Body layer()
{
    return Body(test::voxel_field(Vec3i(8, layers, 8), Vec3d(1.0), [](const Vec3i&) { return 1.0; }),
                {true, false, true});
}

/// A sun in the x-y plane whose light meets the layer at cosine mu.
Light slanting(double mu) { return make_sun(Vec3d(std::sqrt(1 - mu * mu), mu, 0)); }

TEST(Beam, MeanFluenceOfALayerIsThatOfItsExponential)
{
    const Body body = layer();
    for (const double sigma : {0.1, 0.7, 3.0})
        for (const double mu : {1.0, 0.6}) {
            const P1Operator p1 = body.p1(sigma, 0.9, 0);
            const auto depths = periodic_beam_depths(body.index, body.exposed, body.density, slanting(mu));
            const auto fluence = mean_fluence(p1, depths, sigma);
            for (int y = 0; y < layers; ++y) {
                const double top = sigma * (layers - 1 - y) / mu, bottom = top + sigma / mu;
                const double expected = (std::exp(-top) - std::exp(-bottom)) * mu / sigma;
                EXPECT_NEAR(fluence[body.slot(3, y, 5)] / expected, 1, 1e-5) << sigma << ' ' << mu << ' ' << y;
            }
        }
}

TEST(Beam, FluenceForSweepsHasChordsOfTheExponentialsArea)
{
    // Between two centres the mean of both values is that of the exponential but for x^4 / 240 where voxels are thin:
    // the centres' own values would be x^2 / 12 = 1.3e-2 more at x = 0.4, means of voxels x^2 / 8. What is thick has
    // its mean: at weight W = x^2 / (1/4 + x^2) the value is W of it.
    const Body body = layer();
    for (const double x : {0.02, 0.1, 0.4, 8.0}) {
        const P1Operator p1 = body.p1(x, 0.9, 0);
        const Light sun = slanting(1);
        const auto depths = periodic_beam_depths(body.index, body.exposed, body.density, sun);
        const auto centre = periodic_centre_depths(body.index, body.density, sun);
        const auto fluence = beam_fluence(p1, depths, centre, x), mean = mean_fluence(p1, depths, x);
        const double weight = x * x / (0.25 + x * x);
        for (int y = 1; y < layers; ++y) {
            const double depth = x * (layers - y), exact = std::exp(-depth) * std::sinh(x / 2) / (x / 2);
            const auto chord = [&](int at) {
                const size_t slot = body.slot(3, at, 5);
                return (fluence[slot] - weight * mean[slot]) / (1 - weight);
            };
            // exact: half the sum of exp(x / 2) and exp(-x / 2) over 1 + x^2 / 12, times x / 2 over sinh(x / 2)
            const double error = std::cosh(x / 2) / (1 + x * x / 12) * (x / 2) / std::sinh(x / 2) - 1;
            if (x < 1) {
                EXPECT_NEAR((chord(y) + chord(y - 1)) / 2 / exact, 1 + error, 2e-6) << x << ' ' << y;
                EXPECT_LT(std::abs(error), std::pow(x, 4) / 100) << x;
            } else {
                EXPECT_NEAR(fluence[body.slot(3, y, 5)] / mean[body.slot(3, y, 5)], 1, 1e-2) << y;
            }
        }
    }
}

TEST(Beam, SourceOfALayerMatchesDepositAndForwardFlux)
{
    const Body body = layer();
    const double sigma = 0.8, w0 = 0.9, mu = 0.6, strength = 2.5;
    for (const double g : {0.0, 0.5}) {
        const P1Operator p1 = body.p1(sigma, w0, g);
        P1Source source(p1);
        add_beam(p1, periodic_beam_depths(body.index, body.exposed, body.density, slanting(mu)), sigma,
                 {{&source, strength}});
        // Upward power through a face of unit area at depth d: -E mu exp(-sigma d / mu). Q1 / sigma_tr is q times this
        // power.
        const auto up = [&](double d) { return -strength * mu * std::exp(-sigma * d / mu); };
        const double q = w0 * g / (1 - w0 * g);
        for (int y = 1; y < layers - 1; ++y) {
            const double lower = up(layers - y), upper = up(layers - y - 1);
            EXPECT_NEAR(source.rhs[body.slot(2, y, 2)] / ((w0 + q) * (lower - upper)), 1, 1e-5) << g << ' ' << y;
            if (g != 0) {
                EXPECT_NEAR(source.through[1][body.slot(2, y, 2)] / (q * lower), 1, 1e-5) << y;
            }
        }
        const double in = 64 * strength * mu, taken = in * (1 - std::exp(-sigma * layers / mu));
        EXPECT_NEAR(source.beam_in / in, 1, 1e-6);
        EXPECT_NEAR(source.deposited / taken, 1, 1e-6);
        EXPECT_NEAR(source.first_scatter / (w0 * taken), 1, 1e-6);
    }
}

TEST(Beam, ProfileAddsCentreToCentreMeanMinusFaceValue)
{
    const Body body = layer();
    const double w0 = 0.9, strength = 2.5;
    for (const double sigma : {0.05, 2.0})
        for (const double g : {0.0, 0.5}) {
            const P1Operator p1 = body.p1(sigma, w0, g);
            P1Source source(p1);
            add_beam_profile(p1, periodic_beam_depths(body.index, body.exposed, body.density, slanting(1)), sigma,
                             {{&source, strength}});
            // An exponential's mean over a voxel centred on a face is sinh(x) / x times its value on the face, x =
            // sigma / 2.
            const double x = sigma / 2, factor = w0 + w0 * g / (1 - w0 * g);
            const auto flux = [&](double d) {
                return -strength * factor * (std::sinh(x) / x - 1) * std::exp(-sigma * d);
            };
            for (int y = 1; y < layers - 1; ++y) {
                const double lower = flux(layers - y), upper = flux(layers - y - 1);
                // Depths are floats; 1 / (1 - sinh(x) / x) amplifies their relative error.
                const double tolerance = 1e-5 + 1e-6 / (std::sinh(x) / x - 1);
                EXPECT_NEAR(source.rhs[body.slot(2, y, 2)] / (lower - upper), 1, tolerance) << sigma << ' ' << y;
                EXPECT_NEAR(source.through[1][body.slot(2, y, 2)] / lower, 1, tolerance) << y;
            }
        }
}

/// Power that each cell takes from a beam, over the extinction.
std::vector<double> taken(const Body& body, const Light& light, double sigma, double& deposited)
{
    const P1Operator p1 = body.p1(sigma, 0.9, 0);
    P1Source source(p1);
    source.beam_absorbed.assign(body.index.blocks().slots(), 0.0);
    add_beam(p1, beam_depths(body.index, body.exposed, body.bricks, light, 4), sigma, {{&source, 1.0}});
    deposited = source.deposited / sigma;
    for (double& x : source.beam_absorbed) x /= sigma;
    return source.beam_absorbed;
}

TEST(Beam, ALossIsAsExactInAThinMediumAsInADenser)
{
    // At optical depths of 1e-5 the loss bends by 1e-5 of itself; depths are floats, whose differences from voxel to
    // voxel keep six digits. A loss that is one transmittance less another has three digits at 1e-13.
    const Body body(test::voxel_field(Vec3i(7, 8, 9), Vec3d(1.0, 0.7, 1.3), [](const Vec3i&) { return 1.0; }));
    const Light sun = make_sun(Vec3d(0.3, 1, 0.2));
    double thin = 0, denser = 0;
    const auto of_thin = taken(body, sun, 1e-14, thin), of_denser = taken(body, sun, 1e-6, denser);
    EXPECT_GT(denser, 0);
    EXPECT_NEAR(thin / denser, 1, 2e-5);
    double worst = 0;
    for (size_t slot = 0; slot < of_thin.size(); ++slot)
        if (of_denser[slot] != 0) worst = std::max(worst, std::abs(of_thin[slot] / of_denser[slot] - 1));
    EXPECT_LT(worst, 5e-5);
}

/// Density 1 below y = 8 and `thin` above, with edge 1: a voxel of the thin part beside the dense one.
Body dense_under_thin(double thin)
{
    return Body(test::voxel_field(Vec3i(9, 12, 9), Vec3d(1.0), [=](const Vec3i& p) { return p.y() < 8 ? 1.0 : thin; }));
}

TEST(Beam, FluenceOfAThinVoxelIsCappedAtItsBrightestFace)
{
    const double thin = 1e-4, sigma = 10;
    const Body body = dense_under_thin(thin);
    const P1Operator p1 = body.p1(sigma, 0.9, 0);
    // The upper face of voxel 8 is at 8.5; above lie 2.5 voxels of `thin` up to the last centre and half a voxel of
    // ramp.
    const double cap = std::exp(-sigma * thin * 3);
    const auto under_sun = mean_fluence(p1, beam_depths(body.index, body.exposed, body.bricks, slanting(1)), sigma);
    EXPECT_NEAR(under_sun[body.slot(4, 8, 4)], cap, 1e-6);
    const Light lamp = make_lamp(Vec3d(4, 30, 4));
    const auto under_lamp = mean_fluence(p1, beam_depths(body.index, body.exposed, body.bricks, lamp), sigma);
    EXPECT_NEAR(under_lamp[body.slot(4, 8, 4)] * 22 * 22, cap, 1e-6);
    // Without the cap: the dense part reaches up to 7.5 + 0.5 with a ramp of area 1/8, its power over the thin rate.
    EXPECT_GT((1 - std::exp(-sigma / 8)) / (sigma * thin), 500 * cap);
    // The dense voxel below removes the difference of the powers at 7.5 and at 6.5.
    const double above = sigma * (3.5 * thin + 0.375 * thin + 0.125),
                 through = above + sigma * (0.375 + 0.5 + 0.125 * thin);
    EXPECT_NEAR(under_sun[body.slot(4, 7, 4)], (std::exp(-above) - std::exp(-through)) / sigma, 1e-6);
}

TEST(Beam, FluenceOfALampIsInverseSquareTimesTransmittance)
{
    const double h = 0.2, sigma = 1.5;
    const Body body(test::voxel_field(Vec3i(25), Vec3d(h), [](const Vec3i&) { return 1.0; }));
    const P1Operator p1 = body.p1(sigma, 0.9, 0);
    const Vec3d at(12.1 * h, 11.9 * h, 12.05 * h);
    const auto fluence = mean_fluence(p1, beam_depths(body.index, body.exposed, body.bricks, make_lamp(at)), sigma);
    for (const Vec3i& v : {Vec3i(12, 18, 12), Vec3i(19, 13, 9), Vec3i(7, 7, 16)}) {
        // The mean over the voxel, by midpoints of 6^3 parts. The library takes the transmittance of each face's
        // centre: sigma h^2 / (12 r) more than the face's mean, and h^2 / r^2 as light spreads across the voxel.
        double mean = 0;
        for (int k = 0; k < 216; ++k) {
            const int i = k / 36, j = k / 6 % 6;
            const Vec3d part(i + 0.5, j + 0.5, k % 6 + 0.5);
            const double r = ((Vec3d(v.x(), v.y(), v.z()) - Vec3d(0.5) + part / 6.0) * h - at).length();
            mean += std::exp(-sigma * r) / (r * r) / 216;
        }
        const double r = (Vec3d(v.x(), v.y(), v.z()) * h - at).length();
        EXPECT_NEAR(fluence[body.slot(v.x(), v.y(), v.z())] / mean, 1, h * h / (r * r) + sigma * h * h / (12 * r)) << v;
    }
}

TEST(Beam, BeamInAndOutOfABoxMatchTheExponential)
{
    // Density falls to 0 half a voxel beyond each exposed face: 12 voxels along y hold a depth of 12 between these
    // ends.
    const double sigma = 0.2;
    const Body body(test::voxel_field(Vec3i(9, 12, 9), Vec3d(1.0), [](const Vec3i&) { return 1.0; }));
    const P1Operator p1 = body.p1(sigma, 0.9, 0);
    for (const double side : {1.0, -1.0}) {
        P1Source source(p1);
        const auto depths = beam_depths(body.index, body.exposed, body.bricks, make_sun(Vec3d(0, side, 0)));
        add_beam(p1, depths, sigma, {{&source, 2.0}});
        EXPECT_NEAR(source.beam_in, 2 * 81, 1e-4) << side;
        EXPECT_NEAR(source.beam_out / (2 * 81 * std::exp(-12 * sigma)), 1, 1e-5) << side;
    }
    // A distant lamp above approximates this sun. Its rays diverge: at the bottom 2e-3 of its light leaves through the
    // sides.
    P1Source source(p1);
    add_beam(p1, beam_depths(body.index, body.exposed, body.bricks, make_lamp(Vec3d(4, 1e5, 4))), sigma,
             {{&source, 1e10}});
    EXPECT_NEAR(source.beam_in / 81, 1, 1e-3);
    EXPECT_NEAR(source.beam_out / (81 * std::exp(-12 * sigma)), 1, 3e-3);
}

TEST(Beam, LampInsideABallDepositsAllButTheTransmittedPower)
{
    const double h = 0.25, sigma = 0.6;
    // A ball of 12 voxels about the lamp. The staircase's mean radius is the ball's, to (h / R)^2 and the shift of
    // exposed faces; half a voxel would be 0.6 * 0.125 / 2 = 4 % of the transmittance.
    const Vec3d centre(14, 14, 14);
    const Body body(test::voxel_field(Vec3i(29), Vec3d(h), [&](const Vec3i& p) {
        return (Vec3d(p.x(), p.y(), p.z()) - centre).length() < 12 ? 1.0 : 0.0;
    }));
    const P1Operator p1 = body.p1(sigma, 0.9, 0.5);
    P1Source source(p1);
    add_beam(p1, beam_depths(body.index, body.exposed, body.bricks, make_lamp(centre * h + Vec3d(0.01, -0.02, 0.015))),
             sigma, {{&source, 3.0}});
    EXPECT_NEAR(source.beam_in, 3 * 4 * M_PI, 1e-9);
    EXPECT_NEAR(source.beam_out / source.beam_in, std::exp(-sigma * 12 * h), 0.02 * std::exp(-sigma * 12 * h));
    EXPECT_NEAR(source.deposited, source.beam_in - source.beam_out, 1e-9);
    EXPECT_NEAR(source.first_scatter, 0.9 * source.deposited, 1e-6);
}

struct LampGrid {
    const char* name;
    double h;
    Vec3d axis[3];
};

class LampOnAFace : public testing::TestWithParam<LampGrid> {};

/// Whole numbers are voxel centres, halves lie on faces. On the first grid all numbers are exact; on the second
/// rounding puts a face to either side of the lamp.
TEST_P(LampOnAFace, EdgeOrCornerShinesOnce)
{
    const auto& [name, h, axes] = GetParam();
    const double sigma = 0.3 / h;
    const Body body(test::voxel_field(Vec3i(12), h * axes[0], h * axes[1], h * axes[2],
                                      [](const Vec3i& p) { return 1 + 0.05 * p.x(); }));
    const P1Operator p1 = body.p1(sigma, 0.9, 0);
    const auto lit = [&, h = h, &axes = axes](const Vec3d& at) {
        P1Source source(p1);
        const Vec3d place = h * (at[0] * axes[0] + at[1] * axes[1] + at[2] * axes[2]);
        add_beam(p1, beam_depths(body.index, body.exposed, body.bricks, make_lamp(place)), sigma, {{&source, 1.0}});
        EXPECT_NEAR(source.beam_in, 4 * M_PI, 1e-9) << at;
        EXPECT_NEAR(source.first_scatter / (0.9 * source.deposited), 1, 1e-6) << at;
        return source;
    };
    // The largest difference of a voxel's source, over the largest source.
    const auto apart = [](const P1Source& a, const P1Source& b) {
        double most = 0, top = 0;
        for (size_t slot = 0; slot < a.rhs.size(); ++slot) {
            most = std::max(most, std::abs(a.rhs[slot] - b.rhs[slot]));
            top = std::max(top, std::abs(a.rhs[slot]));
        }
        return most / top;
    };
    for (const Vec3d& at : {Vec3d(5.5, 6, 6), Vec3d(6, 5.5, 5.5), Vec3d(5.5, 5.5, 5.5), Vec3d(6, 6, 5.5),
                            Vec3d(5.5 - 1e-15, 6, 5.5), Vec3d(5.5 + 1e-15, 6, 6)}) {
        const P1Source on = lit(at);
        EXPECT_GE(*std::min_element(on.rhs.begin(), on.rhs.end()), -1e-12) << at << ": no voxel is a sink";
        // The lamp shines as one that is 2e-3 voxels aside, in one of the voxels that meet there: powers through faces
        // change by as many thousandths.
        double nearest = 1;
        for (int side = 0; side < 8; ++side) {
            const Vec3d aside(side & 1 ? 2e-3 : -2e-3, side & 2 ? 2e-3 : -2e-3, side & 4 ? 2e-3 : -2e-3);
            const P1Source beside = lit(at + aside);
            EXPECT_NEAR(on.deposited / beside.deposited, 1, 1e-3) << at;
            nearest = std::min(nearest, apart(on, beside));
        }
        EXPECT_LT(nearest, 1e-2) << at;
    }
}

INSTANTIATE_TEST_SUITE_P(
    Grid, LampOnAFace,
    testing::Values(LampGrid{"Exact", 0.125, {Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)}},
                    LampGrid{"Rounded", 0.1, {Vec3d(0.6, 0.8, 0), Vec3d(-0.8, 0.6, 0), Vec3d(0, 0, 1)}}),
    [](const auto& of) { return std::string(of.param.name); });

TEST(Beam, LinesThroughAGaussianMatchTheExponentialIntegral)
{
    // tau(b) = tau0 exp(-b^2 / 2 a^2), so that the loss is 2 pi a^2 Ein(tau0). Cells of constant density add h^2 / 12
    // to a^2 and keeps the mass, except along an axis, where lines run through voxel centres. The remaining error is (h
    // / a)^4.
    const double h = 0.1, sigma = 2.4, a = 5 * h;
    const Body body(test::voxel_field(Vec3i(55), Vec3d(h), [&](const Vec3i& p) {
        const Vec3d r = (Vec3d(p.x(), p.y(), p.z()) - Vec3d(27.3, 26.8, 27.1)) * h;
        const double density = std::exp(-r.dot(r) / (2 * a * a));
        return density > 1e-6 ? density : 0.0;
    }));
    for (const Vec3d& to : {Vec3d(0, 1, 0), Vec3d(0.3, 1, 0.2), Vec3d(-1, 0.4, 0.7)}) {
        const double wide = a * a + (to[0] == 0 ? 0 : h * h / 12),
                     tau0 = sigma * std::sqrt(2 * M_PI) * a * a * a / wide;
        double ein = 0, term = 1;  // the sum of -(-tau0)^n / (n n!)
        for (int n = 1; n < 60; ++n) {
            term *= -tau0 / n;
            ein -= term / n;
        }
        const LineDepths lines = line_depths(body.index, body.density, make_sun(to));
        EXPECT_NEAR(lost_power(lines, sigma) / (2 * M_PI * wide * ein), 1, 1e-3) << to;
    }
}

TEST(Beam, LinesThroughALayerMatchTheExponential)
{
    const Body body = layer();
    for (const double mu : {1.0, 0.6}) {
        const LineDepths lines = periodic_line_depths(body.index, body.density, slanting(mu));
        const double expected = 64 * mu * (1 - std::exp(-0.3 * layers / mu));
        EXPECT_NEAR(lost_power(lines, 0.3) / expected, 1, 1e-6) << mu;
    }
}

TEST(Beam, PeriodicMediumRefusesHorizontalSunsAndLamps)
{
    const Body body = layer();
    for (const Light& light : {make_sun(Vec3d(1, 0, 0)), make_lamp(Vec3d(4, 30, 4))})
        EXPECT_THROW(periodic_beam_depths(body.index, body.exposed, body.density, light), InputError) << light.name;
}

TEST(Beam, PowersAreInvariantUnderRotationAndReflection)
{
    const auto density = [](const Vec3i& p) {
        const Vec3d r = Vec3d(p.x(), p.y(), p.z()) - Vec3d(9, 10, 8);
        return r.length() < 8 ? 1 + 0.5 * std::sin(1.3 * p.x() + 0.7 * p.y() * p.z()) : 0.0;
    };
    const double h = 0.2, sigma = 2;
    struct Axes {
        const char* name;
        Vec3d x, y, z;
    };
    const double c = std::cos(0.7), s = std::sin(0.7), d = std::cos(1.1), e = std::sin(1.1);
    const Axes upright{"upright", Vec3d(1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)};
    const Axes others[] = {{"turned", Vec3d(c, s * d, s * e), Vec3d(-s, c * d, c * e), Vec3d(0, -e, d)},
                           {"mirrored", Vec3d(-1, 0, 0), Vec3d(0, 1, 0), Vec3d(0, 0, 1)}};
    struct Outcome {
        std::vector<double> rhs;
        std::vector<float> fluence, flux;
        double deposited, out;
    };
    const auto lit = [&](const Axes& axes, bool lamp) {
        const auto placed = [&](const Vec3d& v) { return v[0] * axes.x + v[1] * axes.y + v[2] * axes.z; };
        const Body body(test::voxel_field(Vec3i(19), h * axes.x, h * axes.y, h * axes.z, density));
        const P1Operator p1 = body.p1(sigma, 0.9, 0.6);
        const Light light = lamp ? make_lamp(placed(Vec3d(9.3, 21, 7) * h)) : make_sun(placed(Vec3d(0.3, 1, 0.2)));
        const BeamDepths depths = beam_depths(body.index, body.exposed, body.bricks, light);
        P1Source source(p1);
        add_beam(p1, depths, sigma, {{&source, 1.0}});
        add_beam_profile(p1, depths, sigma, {{&source, 1.0}});
        const std::vector<double> dark(source.rhs.size(), 0.0);
        return Outcome{source.rhs, mean_fluence(p1, depths, sigma), cell_flux(p1, source, dark)[0], source.deposited,
                       source.beam_out};
    };
    for (const bool lamp : {false, true}) {
        const Outcome first = lit(upright, lamp);
        EXPECT_GT(first.deposited, 0.1 * first.out);
        const double top = *std::max_element(first.rhs.begin(), first.rhs.end());
        const float bright = *std::max_element(first.fluence.begin(), first.fluence.end());
        for (const Axes& axes : others) {
            const Outcome other = lit(axes, lamp);
            ASSERT_EQ(other.rhs.size(), first.rhs.size());
            EXPECT_NEAR(other.deposited / first.deposited, 1, 1e-5) << axes.name << lamp;
            // Depths are floats of some 4 [density x length]: 1e-6 of a beam's power.
            for (size_t slot = 0; slot < first.rhs.size(); ++slot) {
                ASSERT_NEAR(other.rhs[slot], first.rhs[slot], 1e-5 * top) << axes.name << lamp << ' ' << slot;
                ASSERT_NEAR(other.fluence[slot], first.fluence[slot], 1e-5 * bright) << axes.name << lamp;
                ASSERT_NEAR(other.flux[slot], first.flux[slot], 1e-5 * top) << axes.name << lamp;
            }
        }
    }
}

}  // namespace
}  // namespace vdbcloud
