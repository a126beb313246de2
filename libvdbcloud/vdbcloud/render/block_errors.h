#pragma once
// Errors of a picture over blocks of pixels, from independent unbiased estimates of the truth. Private to render/.
#include "vdbcloud/render/certificate.h"

#include <vector>

namespace vdbcloud {

/// The share `u` below which Student's distribution with `freedom` degrees lies, turned round: its quantile.
double student_quantile(double freedom, double u);

/// Estimates of the error of each block: `means` of a number of independent batches.
///
/// With x_k the estimate of batch k, K batches, mean x and v = sum (x_k - x)^2 / (K (K - 1)), the mean over all pairs
/// of x_k x_l is x^2 - v: an unbiased estimate of the square of the true error, whatever the noise.
struct BatchMean {
    double weight = 0;    ///< of the block: its pixels
    double mean = 0;      ///< x
    double variance = 0;  ///< v
};

/// The mean of the blocks' errors, and its interval of confidence.
Interval mean_error(const std::vector<BatchMean>& blocks, int batches);

/// The mean square of the blocks' errors, and its interval of confidence.
///
/// Estimate: U = sum w (x^2 - v), weights of sum 1. Blocks are independent of each other. For true squares e^2 the
/// variance of U is
///
///     sum w^2 (4 e^2 v + 2 v^2 K / (K - 1))
///
/// and the interval holds all mean squares s from which U is at most t standard deviations away, with e^2 in proportion
/// to s: as Wilson 1927 has it for shares. t: Student's quantile for the degrees of freedom by which v^2 is known
/// (Satterthwaite 1946). The lower end is 0 where the noise hides the error; the upper end is then a bound.
Interval mean_square_error(const std::vector<BatchMean>& blocks, int batches);

/// Which batches are looked at: all, or every second one from `first` on. Halves are independent of each other.
struct BatchPart {
    int first = 0, stride = 1;
};

/// Errors of blocks of `edge` x `edge` pixels by batch: sums over the samples of a block.
class BlockErrors {
public:
    static constexpr int edge = 8, coarse = 4;  ///< coarse: fine blocks along the edge of a coarse one
    static constexpr int batches = 32;          ///< at most; passes beyond are added to the first again

    /// `weights`: for each of across x down blocks, row by row, its number of pixels that count.
    BlockErrors(int across, int down, std::vector<double> weights);

    int across() const { return across_; }
    int down() const { return down_; }
    const std::vector<double>& weights() const { return weights_; }

    /// Adds one pass's estimate of block b's error. Passes count from 0; all blocks of positive weight take part in
    /// each. Different blocks may be added to from different threads.
    void add(size_t b, uint64_t pass, const Vec3d& error);

    /// Batches of a part after a number of passes.
    static int count(uint64_t passes, const BatchPart&);

    /// Luminance of the fine, or of the coarse blocks. `known`: an error of each fine block that is taken off before;
    /// empty: none. Blocks without weight are left out.
    std::vector<BatchMean> fine(uint64_t passes, const BatchPart&, const std::vector<Vec3d>& known = {}) const;
    std::vector<BatchMean> coarse_blocks(uint64_t passes, const BatchPart&, const std::vector<Vec3d>& known = {}) const;

    /// Mean and its variance for one block; colours of the mean.
    Vec3d mean(size_t b, uint64_t passes, const BatchPart& = {}) const;
    double variance(size_t b, uint64_t passes, const BatchPart& = {}) const;

    /// The best guess at each fine block's error: means shrunk by their noise (Stein 1956; Efron & Morris 1973, for
    /// unequal variances), first over coarse blocks, then what fine blocks have beside these. Positive part: where
    /// the noise may explain the spread of the means, the guess is 0; the spread counts by its lower bound, as a guess
    /// of 0, the picture as it is, is often a good one.
    std::vector<Vec3d> shrunk(uint64_t passes, const BatchPart& = {}) const;

private:
    Vec3d estimate(size_t b, int batch, uint64_t passes) const;
    size_t coarse_of(size_t b) const;
    size_t coarse_count() const;

    int across_, down_;
    std::vector<double> weights_;
    std::vector<Vec3d> sums_;  // of block b and batch k: [b batches + k]
};

}  // namespace vdbcloud
