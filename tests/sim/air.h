#pragma once
// Helpers of the tests: small boxes of air, fields in and out, orders of convergence.
#include "vdbcloud/sim/simulation.h"

#include <cmath>
#include <functional>
#include <memory>
#include <vector>

namespace vdbcloud::sim::test {

/// A dry Boussinesq box without any effect, in double, with unlimited scalars: to be extended by a test.
inline Parameters bare(std::array<int, 3> n, std::array<double, 3> size, Side x = Side::Periodic,
                       Side y = Side::Periodic)
{
    Parameters p;
    p.lattice = {n, {size[0] / n[0], size[1] / n[1], size[2] / n[2]}, {x, y}};
    p.precision = Precision::Double;
    p.buoyancy = p.moisture = false;
    p.moist.vapour = p.moist.loading = false;
    p.scalar_scheme = ScalarScheme::Plain5;
    p.dt_max = 1e9;
    return p;
}

inline std::vector<double> all(const Simulation& s, Quantity q)
{
    const Lattice& l = s.parameters().lattice;
    const size_t plane = size_t(l.n[0]) * size_t(l.n[1]);
    std::vector<double> values(l.cells());
    for (int k = 0; k < l.n[2]; ++k) s.get_plane(q, k, &values[size_t(k) * plane]);
    return values;
}

inline std::vector<double> all_cloud(const Simulation& s)
{
    const Lattice& l = s.parameters().lattice;
    const size_t plane = size_t(l.n[0]) * size_t(l.n[1]);
    std::vector<double> values(l.cells());
    for (int k = 0; k < l.n[2]; ++k) s.get_cloud_plane(k, &values[size_t(k) * plane]);
    return values;
}

/// f(x, y, z) at the places of `q`.
inline std::vector<double> values_at(const Lattice& l, Quantity q,
                                     const std::function<double(double, double, double)>& f)
{
    std::vector<double> values;
    const double sx = q == Quantity::U ? 0 : 0.5, sy = q == Quantity::V ? 0 : 0.5, sz = q == Quantity::W ? 0 : 0.5;
    for (int k = 0; k < l.n[2]; ++k)
        for (int j = 0; j < l.n[1]; ++j)
            for (int i = 0; i < l.n[0]; ++i)
                values.push_back(f((i + sx) * l.h[0], (j + sy) * l.h[1], (k + sz) * l.h[2]));
    return values;
}

/// Root mean square of a - b.
inline double rms(const std::vector<double>& a, const std::vector<double>& b)
{
    double sum = 0;
    for (size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]) * (a[i] - b[i]);
    return std::sqrt(sum / double(a.size()));
}

inline double largest(const std::vector<double>& a)
{
    double most = 0;
    for (const double v : a) most = std::max(most, std::abs(v));
    return most;
}

inline double largest_difference(const std::vector<double>& a, const std::vector<double>& b)
{
    double most = 0;
    for (size_t i = 0; i < a.size(); ++i) most = std::max(most, std::abs(a[i] - b[i]));
    return most;
}

}  // namespace vdbcloud::sim::test
