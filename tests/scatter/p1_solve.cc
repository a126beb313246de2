#include "scatter/p1_solve.h"

#include "vdbcloud/core/random.h"

#include <cmath>

namespace vdbcloud::test {

Solved solve(const P1Operator& p1, P1Source& source, double tolerance, int max_iterations)
{
    Solved s;
    Multigrid multigrid(p1.stencil());
    SolveOptions options;
    options.tolerance = tolerance;
    options.max_iterations = max_iterations;
    s.solve = solve_p1(p1, multigrid, source, s.phi, options);
    s.budget = budget(p1, source, s.phi);
    s.flux = cell_flux(p1, source, s.phi);
    return s;
}

double bumpy(const Vec3i& p, uint64_t seed)
{
    const double r = uniform(hash_bits(seed, p.x() / 3, p.y() / 3, p.z() / 3));
    return r < 0.45 ? 0.0 : std::pow(10.0, 6 * (uniform(hash_bits(seed + 1, p.x(), p.y(), p.z())) - 0.5));
}

}  // namespace vdbcloud::test
