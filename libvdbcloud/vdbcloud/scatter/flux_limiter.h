#pragma once
// P1 with a flux that never outruns light: a diffusion coefficient that depends on the solution.
#include "vdbcloud/scatter/p1_problem.h"

namespace vdbcloud {

/// What the limited diffusion coefficient is of P1's 1 / (3 sigma_tr): 3 lambda(R), lambda = (coth R - 1/R) / R, R >=
/// 0. It is 1 - R^2/15 where R is small, 3/R where it is large, so that |F| = lambda R phi -> phi. Source: Levermore &
/// Pomraning 1981.
double levermore_pomraning(double r);

/// What the limiter did in one channel.
struct LimiterReport {
    int iterations = 0;  ///< solves with a limited coefficient; 0: no limiter
    double change = 0;   ///< of phi by the last, relative, root mean square
    bool converged = true;
    double least = 1;  ///< least factor of any voxel
};

/// The factors of D, brought to agree with the solution by solving again and again (Picard). With the flux that factors
/// f gave, P1 of the same phi would have F / f, so R = 3 |F| / (f phi) whatever drives the flux, gradient or Q1.
class FluxLimiter {
public:
    explicit FluxLimiter(const Blocks&);

    /// For P1Medium::limiter. All 1 at first. The array stays in place.
    const std::vector<float>& factor() const { return factor_; }
    /// Takes the solution that factor() gave: new factors are the geometric mean of the old and what R asks for, which
    /// keeps the iteration from swinging. Voxels without positive phi keep theirs.
    void update(const std::vector<double>& phi, const std::array<std::vector<float>, 3>& flux);
    double least() const;

private:
    const Blocks& blocks_;
    std::vector<float> factor_;
};

}  // namespace vdbcloud
