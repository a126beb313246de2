// The error of a picture by independent noisy estimates: statistics against known distributions.
#include "render/pictures.h"
#include "support/size.h"
#include "vdbcloud/core/random.h"
#include "vdbcloud/render/block_errors.h"
#include "vdbcloud/render/certificate.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace vdbcloud {
namespace {

using namespace test;

using Noise = std::function<double(uint64_t bits)>;  // of mean 0 and variance 1

double gaussian(uint64_t bits) { return normal(bits); }

/// As light paths have it: most samples are a little too dark, few much too bright. exp(s z), centred; skewness 6.2.
double skewed(uint64_t bits)
{
    const double s2 = 1, z = normal(bits);
    return (std::exp(std::sqrt(s2) * z - s2 / 2) - 1) / std::sqrt(std::exp(s2) - 1);
}

/// Errors of 8 x 8 fine blocks: a part that is alike in coarse blocks, and one that is not.
double true_error(size_t b, double size)
{
    const double fine = normal(hash_bits(1, b)), coarse = normal(hash_bits(2, b / 8 / 4, b % 8 / 4));
    return size * (0.7 * coarse + 0.7 * fine);
}

struct Study {
    int blocks = 64;
    double error = 1, noise = 1;  // of a pass
    uint64_t passes = 32;
    Noise draw = gaussian;
};

BlockErrors measured(const Study& s, uint64_t seed)
{
    BlockErrors errors(8, s.blocks / 8, std::vector<double>(size_t(s.blocks), 64));
    for (uint64_t pass = 0; pass < s.passes; ++pass)
        for (size_t b = 0; b < size_t(s.blocks); ++b)
            errors.add(b, pass, Vec3d(true_error(b, s.error) + s.noise * s.draw(hash_bits(seed, b, pass))));
    return errors;
}

double true_square(const Study& s)
{
    double sum = 0;
    for (size_t b = 0; b < size_t(s.blocks); ++b) sum += std::pow(true_error(b, s.error), 2) / s.blocks;
    return sum;
}

TEST(BlockErrors, MeanSquareHasNoBias)
{
    // The noise of the mean over runs is known from their spread: 4.5 standard errors.
    for (const auto& [error, passes, draw] : {std::tuple(0.0, uint64_t(8), Noise(skewed)),
                                              {0.3, uint64_t(8), Noise(skewed)},
                                              {1.0, uint64_t(50), Noise(gaussian)}}) {
        Study study;
        study.error = error;
        study.passes = passes;
        study.draw = draw;
        const double truth = true_square(study);
        double sum = 0, squares = 0;
        const int runs = sized(300, 3000);
        for (int r = 0; r < runs; ++r) {
            const double x =
                mean_square_error(measured(study, uint64_t(r)).fine(passes, {}), BlockErrors::count(passes, {})).value;
            sum += x;
            squares += x * x;
        }
        const double mean = sum / runs, deviation = std::sqrt((squares / runs - mean * mean) / runs);
        EXPECT_NEAR(mean, truth, 4.5 * deviation) << error;
        EXPECT_LT(4.5 * deviation, 0.06) << error;
    }
}

TEST(BlockErrors, IntervalsHoldTheTruthAsOftenAsTheySay)
{
    // 95 %, asked: 90 % at the least where noise is skewed and where there is one block; 99.9 % at the most where the
    // noise hides the error, else the intervals would be too wide. Counts of 400 runs err by 1.1 %.
    for (const Study& study :
         {Study{64, 0, 1, 8, gaussian}, Study{64, 0.1, 1, 16, gaussian}, Study{64, 1, 1, 32, gaussian},
          Study{64, 0.3, 1, 40, skewed}, Study{16, 0.2, 1, 100, skewed}, Study{8, 1, 1, 16, gaussian},
          Study{8, 0.2, 1, 32, gaussian}}) {
        const double truth = true_square(study);
        double mean = 0;
        for (size_t b = 0; b < size_t(study.blocks); ++b) mean += true_error(b, study.error) / study.blocks;
        const int runs = sized(400, 4000);
        int square = 0, bias = 0;
        for (int r = 0; r < runs; ++r) {
            const BlockErrors errors = measured(study, uint64_t(r) + 7);
            const auto fine = errors.fine(study.passes, {});
            const Interval s = mean_square_error(fine, BlockErrors::count(study.passes, {}));
            const Interval m = mean_error(fine, BlockErrors::count(study.passes, {}));
            square += s.low <= truth && truth <= s.high;
            bias += m.low <= mean && mean <= m.high;
        }
        const std::string what = std::to_string(study.blocks) + " blocks, error " + std::to_string(study.error);
        EXPECT_GT(square, 0.90 * runs) << what;
        EXPECT_LT(square, 0.999 * runs) << what;
        EXPECT_NEAR(bias, 0.95 * runs, 0.04 * runs) << what;
    }
}

TEST(BlockErrors, ShrunkMeansAreTheBetterGuess)
{
    // Noise of a block's mean: 1. Means alone err by 1; nothing at all by the error. The best linear guess where both
    // scales are known: below.
    for (const double error : {0.0, 0.3, 1.0, 2.0, 4.0}) {
        Study study;
        study.error = error;
        study.noise = std::sqrt(32.0);
        double sum = 0;
        const int runs = sized(40, 400);
        for (int r = 0; r < runs; ++r) {
            const auto guess = measured(study, uint64_t(r)).shrunk(study.passes);
            for (size_t b = 0; b < size_t(study.blocks); ++b)
                sum += std::pow(true_error(b, error) - guess[b][0], 2) / study.blocks / runs;
        }
        EXPECT_LT(std::sqrt(sum), error > 0 ? 1.05 * error : 0.05) << error;
        EXPECT_LT(std::sqrt(sum), 1.05) << error;
        if (error >= 2) {
            EXPECT_LT(std::sqrt(sum), 0.5 * error) << error;
        }
    }
}

}  // namespace
}  // namespace vdbcloud
