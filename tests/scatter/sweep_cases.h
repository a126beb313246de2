#pragma once
// Transport sweeps that close P1 on small cases, for tests.
#include "scatter/fields.h"
#include "vdbcloud/scatter/second_moment.h"

namespace vdbcloud::test {

struct Lit {
    double w0 = 1, g = 0, sigma = 1;  // sigma_t per density
    double sky = 0, sun = 1;
    Vec3d to_sun{0, 1, 0};
};

struct Result {
    ClosureReport report;
    P1Budget budget;
    P1Budget p1_budget;
    std::vector<double> phi, phi_p1;
    std::vector<std::vector<float>> moments;
    std::vector<float> uncollided;
    double extinction = 1;
};

/// Solves P1, then sweeps. From degree 2 on the start is the degree-1 solution, plus light that is uncollided only
/// under the scaling of degree 1.
Result solve(const P1Case& c, const Lit& lit, ClosureOptions options);

/// A slab of n voxels along y, lit from +y.
struct Slab {
    Slab(double tau, int n)
        : cloud(voxel_field(Vec3i(8, n, 8), Vec3d(1.0 / n), [&](const Vec3i&) { return tau; }), {true, false, true}),
          count(n)
    {
    }
    /// A field at voxel j from the top.
    template<typename T>
    double at(const std::vector<T>& field, int j) const
    {
        return field[cloud.index.blocks().slot(Vec3i(3, count - 1 - j, 3))];
    }
    double area() const { return 64.0 / count / count; }
    P1Case cloud;
    int count;
};

ClosureOptions options(int directions, int iterations = 15, int degree = 1, double change = 1e-4);

/// A salt-and-pepper density: voids, and voxels within six decades.
double clumps(const Vec3i& p, uint64_t seed);

/// Billows with true voids in a cube of n^3 voxels and edge 1.
double billows(const Vec3i& p, int n);

}  // namespace vdbcloud::test
