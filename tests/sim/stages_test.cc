// Stages of the time schemes: order conditions, and what keeps limited scalars bounded.
#include "vdbcloud/sim/stages.h"

#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <map>

namespace vdbcloud::sim {
namespace {

/// Rates k_s of the stages in the value that a stage writes: value = q + dt sum_s a[s] k_s.
using Weights = std::vector<double>;

/// The tableau of a scheme: the weights in the input of each stage, and in the result as the last entry.
std::vector<Weights> tableau(TimeScheme scheme)
{
    const auto& list = stages(scheme);
    std::vector<Weights> arrays(4, Weights(list.size(), 0.0)), rows;
    for (size_t s = 0; s < list.size(); ++s) {
        const Stage& stage = list[s];
        rows.push_back(arrays[size_t(stage.in)]);
        Weights out(list.size(), 0.0);
        for (size_t c = 0; c < out.size(); ++c)
            out[c] = stage.alpha * arrays[size_t(stage.x1)][c] + stage.beta * arrays[size_t(stage.in)][c];
        out[s] += stage.beta * stage.tau;
        arrays[size_t(stage.out)] = out;
    }
    rows.push_back(arrays[size_t(list.back().out)]);
    return rows;
}

double sum(const Weights& w)
{
    double total = 0;
    for (const double v : w) total += v;
    return total;
}

const std::map<TimeScheme, int> orders{{TimeScheme::Euler, 1}, {TimeScheme::Rk2, 2}, {TimeScheme::Rk3, 3}};

TEST(Stages, MeetTheOrderConditions)
{
    // sum b = 1, sum b c = 1/2, sum b c^2 = 1/3, sum b a c = 1/6. Tolerance: rounding.
    for (const auto& [scheme, order] : orders) {
        const auto a = tableau(scheme);
        const Weights& b = a.back();
        double first = sum(b), second = 0, square = 0, nested = 0;
        for (size_t s = 0; s < b.size(); ++s) {
            second += b[s] * sum(a[s]), square += b[s] * std::pow(sum(a[s]), 2);
            for (size_t t = 0; t < b.size(); ++t) nested += b[s] * a[s][t] * sum(a[t]);
        }
        EXPECT_NEAR(first, 1, 1e-15);
        if (order >= 2) {
            EXPECT_NEAR(second, 1.0 / 2, 1e-15);
        }
        if (order >= 3) {
            EXPECT_NEAR(square, 1.0 / 3, 1e-15);
            EXPECT_NEAR(nested, 1.0 / 6, 1e-15);
        }
    }
}

TEST(Stages, AreConvexSumsOfEulerStepsOfTheLengthThatTheStepLimitKnows)
{
    for (const auto& [scheme, order] : orders)
        for (const Stage& s : stages(scheme)) {
            EXPECT_EQ(s.tau, longest_stage(scheme)) << order;
            EXPECT_GE(s.alpha, 0) << order;
            EXPECT_GE(s.beta, 0) << order;
            EXPECT_GE(1 - s.alpha - s.beta, -1e-15) << order;
        }
}

TEST(Stages, SayTheirTimesAndWeightsAndNeverGoBack)
{
    for (const auto& [scheme, order] : orders) {
        const auto& list = stages(scheme);
        const auto a = tableau(scheme);
        std::vector<double> times(4, 0.0);
        for (size_t s = 0; s < list.size(); ++s) {
            EXPECT_NEAR(list[s].time_in, sum(a[s]), 1e-15) << order;
            EXPECT_NEAR(list[s].time_x1, times[size_t(list[s].x1)], 1e-15) << order;
            EXPECT_NEAR(list[s].weight, a.back()[s], 1e-15) << order;
            EXPECT_GE(list[s].time_out, list[s].time_in) << order;
            times[size_t(list[s].out)] = list[s].time_out;
        }
        EXPECT_EQ(list.back().time_out, 1) << order;
    }
}

TEST(Stages, OfThirdOrderAreStableForFifthOrderFluxesUpTo1Point77Cells)
{
    // Amplification sum_m p_m z^m, where z is the symbol of the upwind flux of Wicker and Skamarock 2002 times the
    // Courant number. In three dimensions the Courant numbers of the axes add.
    const auto a = tableau(TimeScheme::Rk3);
    const auto grows = [&](double courant) {
        double most = 0;
        for (int m = 1; m <= 1000; ++m) {
            const double x = M_PI * m / 1000;
            const auto wave = [&](int cells) { return std::polar(1.0, x * cells); };
            const std::complex<double> face =
                (2.0 * wave(-2) - 13.0 * wave(-1) + 47.0 + 27.0 * wave(1) - 3.0 * wave(2)) / 60.0;
            const std::complex<double> z = -courant * (face - face * wave(-1));
            std::vector<std::complex<double>> rate;
            for (size_t s = 0; s < a.size(); ++s) {
                std::complex<double> value = 1;
                for (size_t t = 0; t < rate.size() && t < a[s].size(); ++t) value += a[s][t] * rate[t];
                rate.push_back(z * value);
                if (s + 1 == a.size()) most = std::max(most, std::abs(value));
            }
        }
        return most > 1 + 1e-9;
    };
    EXPECT_FALSE(grows(1.77));
    EXPECT_TRUE(grows(1.80));
    EXPECT_LT(0.75 / longest_stage(TimeScheme::Rk3), 1.77) << "of the largest --cfl";
}

}  // namespace
}  // namespace vdbcloud::sim
