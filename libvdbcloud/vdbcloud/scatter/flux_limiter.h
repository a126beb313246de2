#pragma once
// Flux-limited P1: a diffusion coefficient that depends on the solution and keeps |F| <= phi.
#include "vdbcloud/scatter/p1_problem.h"

namespace vdbcloud {

/// Ratio of the limited diffusion coefficient to P1's 1 / (3 sigma_tr): 3 lambda(R), lambda = (coth R - 1/R) / R,
/// R >= 0. The ratio is 1 - R^2/15 for small R and 3/R for large R, so that |F| = lambda R phi -> phi.
/// Source: Levermore & Pomraning 1981.
double levermore_pomraning(double r);

/// Result of the limiter's iteration in one channel.
struct LimiterReport {
    int iterations = 0;  ///< solves with a limited coefficient; 0: no limiter
    double change = 0;   ///< of phi in the last solve: relative, root mean square
    bool converged = true;
    double least = 1;  ///< smallest factor of all voxels
};

/// ||a - b|| / ||a||, sums in a fixed order; 0 where a is 0.
double relative_change(const std::vector<double>& a, const std::vector<double>& b);

/// Factors f of the diffusion coefficient D, made consistent with the solution by Picard iteration. F is the flux of
/// the solve with factors f; unlimited P1 with the same phi has the flux F / f. Hence R = 3 |F| / (f phi), for a flux
/// driven by the gradient as well as by Q1.
class FluxLimiter {
public:
    explicit FluxLimiter(const Blocks&);

    /// For P1Medium::limiter. All 1 at first. update() keeps the array's address.
    const std::vector<float>& factor() const { return factor_; }
    /// Updates the factors from the solution that factor() gave. Each new factor is the geometric mean of the old
    /// factor and levermore_pomraning(R), which damps oscillation. Voxels without positive phi keep their factor.
    void update(const std::vector<double>& phi, const std::array<std::vector<float>, 3>& flux);
    double least() const;

private:
    const Blocks& blocks_;
    std::vector<float> factor_;
};

}  // namespace vdbcloud
