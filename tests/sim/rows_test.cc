// Face values of the transport schemes against closed forms.
#include "vdbcloud/sim/rows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace vdbcloud::sim {
namespace {

/// Cells per axis of the small arrays; faces are read in the middle, far from the ends.
constexpr int side = 12;

/// The face value that a scalar scheme reconstructs between cells `face - 1` and `face` of a row q, at unit speed
/// towards higher (up) or lower cells. `room` is the limiter's m, drain / tau - 1. Rows run along memory stride s.
double face_value(ScalarScheme scheme, const std::vector<double>& q, int face, bool up, double room = 1e9,
                  ptrdiff_t s = 1)
{
    std::vector<double> cells(q.size() * size_t(s), 0.0), drain(cells.size(), room + 1);
    for (size_t i = 0; i < q.size(); ++i) cells[i * size_t(s)] = q[i];
    const double v = up ? 1 : -1;
    double out = 0;
    const ptrdiff_t at = face * s;
    scalar_flux(scheme, ScalarFlux<double>{&v, &cells[size_t(at)], &drain[size_t(at)], 1.0, s}, &out, 1);
    return out / v;
}

double momentum_face_value(MomentumScheme scheme, const std::vector<double>& q, int face, bool up)
{
    const double a = up ? 3 : -3, b = up ? 1 : -1;  // carrier velocity: 0.25 a + 0.75 b
    double out = 0;
    momentum_flux(scheme, MomentumFlux<double>{&a, &b, 0.25, 0.75, &q[size_t(face)], 1}, &out, 1);
    return out / (0.25 * a + 0.75 * b);
}

/// Means over cells [i, i + 1] of x^power; the face below cell i is at x = i.
std::vector<double> cell_means(int power)
{
    std::vector<double> q;
    for (int i = 0; i < side; ++i)
        q.push_back((std::pow(i + 1.0, power + 1) - std::pow(double(i), power + 1)) / (power + 1));
    return q;
}

/// Cells around a face so that the donor has value 2, the acceptor 2 + ahead, the cell behind the donor 2 - behind.
std::vector<double> triple(double ahead, double behind, bool up)
{
    std::vector<double> q(side, 0.0);
    const int face = 6, donor = up ? face - 1 : face, step = up ? 1 : -1;
    q[size_t(donor)] = 2, q[size_t(donor + step)] = 2 + ahead, q[size_t(donor - step)] = 2 - behind;
    return q;
}

TEST(UpwindScalars, FaceValueIsTheDonors)
{
    for (const bool up : {true, false})
        EXPECT_EQ(face_value(ScalarScheme::Upwind, cell_means(3), 6, up), cell_means(3)[up ? 5 : 6]);
}

TEST(Koren, FaceValueOfATripleIsDonorPlusAThirdAheadPlusASixthBehind)
{
    // Koren 1993: kappa = 1/3, donor + (1 + kappa)/4 ahead + (1 - kappa)/4 behind. Tolerance: rounding.
    for (const bool up : {true, false}) {
        EXPECT_NEAR(face_value(ScalarScheme::Koren, triple(0.6, 0.3, up), 6, up), 2 + 0.6 / 3 + 0.3 / 6, 1e-15 * 4);
        EXPECT_NEAR(face_value(ScalarScheme::Koren, triple(-0.3, -0.9, up), 6, up), 2 - 0.3 / 3 - 0.9 / 6, 1e-15 * 4);
    }
}

TEST(Koren, FaceValueOfQuadraticsIsExact)
{
    // Third order: means of 1, x and x^2 give the value on the face to rounding (of values up to 144), those of x^3
    // do not.
    for (const bool up : {true, false})
        for (const ptrdiff_t stride : {ptrdiff_t(1), ptrdiff_t(5)}) {
            for (const int power : {0, 1, 2})
                EXPECT_NEAR(face_value(ScalarScheme::Koren, cell_means(power), 6, up, 1e9, stride), std::pow(6, power),
                            1e-13);
            EXPECT_GT(std::abs(face_value(ScalarScheme::Koren, cell_means(3), 6, up, 1e9, stride) - 216), 0.1);
        }
}

TEST(Koren, FaceValueIsLimitedByDonorAcceptorAndCellBehind)
{
    for (const ScalarScheme scheme : {ScalarScheme::Koren, ScalarScheme::Limited5})
        for (const bool up : {true, false}) {
            // An extremum takes the donor's value.
            EXPECT_EQ(face_value(scheme, triple(1, -1, up), 6, up), 2);
            EXPECT_EQ(face_value(scheme, triple(-1, 1, up), 6, up), 2);
            // Room m = 0.25: not more than m (donor - behind) beyond the donor, here less than the reconstruction.
            EXPECT_NEAR(face_value(scheme, triple(1, 0.4, up), 6, up, 0.25), 2 + 0.25 * 0.4, 1e-15);
            // No room, where the outflow empties the cell within the stage: donor's value.
            EXPECT_EQ(face_value(scheme, triple(1, 0.4, up), 6, up, 0), 2);
            EXPECT_EQ(face_value(scheme, triple(1, 0.4, up), 6, up, -0.5), 2);
        }
    // m is at most 4: with the acceptor far away, 1/3 ahead + 1/6 behind is cut to 4 behind.
    EXPECT_NEAR(face_value(ScalarScheme::Koren, triple(100, 1, true), 6, true), 2 + 4.0, 1e-14);
    // Not beyond the acceptor: with a steep slope behind, 1/6 of it passes 1 ahead.
    EXPECT_NEAR(face_value(ScalarScheme::Koren, triple(0.1, 9, true), 6, true), 2 + 0.1, 1e-15 * 4);
}

TEST(FifthOrder, FaceValueOfQuarticsIsExactForScalarsAndMomentum)
{
    // Fifth order: exact up to x^4 (6^4 = 1296, rounding of sums of 20736), not for x^5. Monotone data with room: the
    // limiter changes nothing.
    for (const bool up : {true, false}) {
        for (int power = 0; power <= 4; ++power) {
            const auto q = cell_means(power);
            const double exact = std::pow(6, power);
            EXPECT_NEAR(face_value(ScalarScheme::Plain5, q, 6, up), exact, 1e-11) << power;
            EXPECT_NEAR(face_value(ScalarScheme::Limited5, q, 6, up), exact, 1e-11) << power;
            EXPECT_NEAR(momentum_face_value(MomentumScheme::Upwind5, q, 6, up), exact, 1e-11) << power;
        }
        // Upwind weights leave a sixtieth of the fifth difference, 5! of x^5, on the side of the donor.
        const double biased = 7776 - (up ? 2 : -2);
        EXPECT_NEAR(face_value(ScalarScheme::Plain5, cell_means(5), 6, up), biased, 1e-9);
        EXPECT_NEAR(momentum_face_value(MomentumScheme::Upwind5, cell_means(5), 6, up), biased, 1e-9);
        EXPECT_EQ(momentum_face_value(MomentumScheme::Upwind, cell_means(3), 6, up), cell_means(3)[up ? 5 : 6]);
    }
}

TEST(FifthOrder, PlainSchemeOvershootsAStepAndTheLimitedOneDoesNot)
{
    std::vector<double> step(side, 0.0);
    for (int i = 5; i < side; ++i) step[size_t(i)] = 1;
    double over_plain = 0, over_limited = 0;
    for (int face = 3; face <= side - 3; ++face)
        for (const bool up : {true, false}) {
            const double plain = face_value(ScalarScheme::Plain5, step, face, up),
                         limited = face_value(ScalarScheme::Limited5, step, face, up);
            over_plain = std::max({over_plain, plain - 1, -plain});
            over_limited = std::max({over_limited, limited - 1, -limited});
        }
    // Where the donor is the first cell above the step only the difference behind it is not zero.
    EXPECT_NEAR(over_plain, 11.0 / 60, 1e-12);
    EXPECT_EQ(over_limited, 0);
}

TEST(Rows, TendencyIsMinusTheDivergenceOfFluxes)
{
    const double x[] = {1, 4}, y0 = 2, y1 = 7, z0 = 3, z1 = 13;
    double out = 0;
    flux_tendency(FluxRows<double>{x, &y0, &y1, &z0, &z1, 0.5, 0.25, 2, 1}, &out, 1);
    EXPECT_DOUBLE_EQ(out, -(0.5 * (4 - 1) + 0.25 * (7 - 2) + 1.0 * 13 - 2.0 * 3));
}

TEST(Rows, DrainTimeIsTheInverseOfHalfTheFluxesAndTheRateTheSumOfFastest)
{
    const double u[] = {1, -3}, v0 = 2, v1 = 2, w0 = -4, w1 = 1;
    double drain = 0, rate = 0;
    courant(CourantRows<double>{u, &v0, &v1, &w0, &w1, 0.1, 0.2, 0.5, 0.25}, &drain, rate, 1);
    EXPECT_DOUBLE_EQ(1 / drain, 0.5 * (0.1 * 4 + 0.2 * 4 + 0.5 * 4 + 0.25 * 1));
    EXPECT_DOUBLE_EQ(rate, 0.1 * 3 + 0.2 * 2 + 0.5 * 4);
    const double bad = NAN;
    courant(CourantRows<double>{u, &bad, &v1, &w0, &w1, 0.1, 0.2, 0.5, 0.25}, &drain, rate, 1);
    EXPECT_TRUE(std::isnan(rate));
}

TEST(Rows, StageRaisesRoundingBelowTheLeastValueAndNothingElse)
{
    const double x0[] = {0, 0, 0}, tendency[] = {-1e-18, -1e-3, 1e-18};
    double out[3];
    scalar_stage({out, x0, x0, x0, tendency}, ScalarStage{0, 1, 1, 0, 1e-17}, 3);
    EXPECT_EQ(out[0], 0);
    EXPECT_EQ(out[1], -1e-3);
    EXPECT_EQ(out[2], 1e-18);
}

}  // namespace
}  // namespace vdbcloud::sim
