#pragma once
// Solves P1 cases for tests.
#include "scatter/fields.h"
#include "vdbcloud/scatter/p1_problem.h"

namespace vdbcloud::test {

struct Solved {
    SolveResult solve;
    P1Budget budget;
    std::vector<double> phi;
    std::array<std::vector<float>, 3> flux;
};

Solved solve(const P1Operator& p1, P1Source& source, double tolerance = 1e-9, int max_iterations = 200);

/// Density of a medium of voids and of voxels within six decades.
double bumpy(const Vec3i& p, uint64_t seed);

}  // namespace vdbcloud::test
