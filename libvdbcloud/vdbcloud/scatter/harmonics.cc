#include "vdbcloud/scatter/harmonics.h"

#include "vdbcloud/core/constants.h"

#include <cmath>
#include <cstdlib>

namespace vdbcloud {

namespace {

double root(double x) { return std::sqrt(x > 0 ? x : 0.0); }

/// cos(theta) P_lm = a(l, m) P_{l+1,m} + a(l-1, m) P_{l-1,m} for normalised associated Legendre functions.
double a(int l, int m) { return root(((l + 1.0) * (l + 1.0) - m * m) / ((2 * l + 1.0) * (2 * l + 3.0))); }

/// sin(theta) P_lm = raise(l, m) P_{l+1,m+1} - raise(l-1, -m-1) P_{l-1,m+1}
///                 = -raise(l, -m) P_{l+1,m-1} + raise(l-1, m-1) P_{l-1,m-1}
double raise(int l, int m) { return root((l + m + 1.0) * (l + m + 2.0) / ((2 * l + 1.0) * (2 * l + 3.0))); }

/// One expansion of sin(theta) P_lm with order m + step, step = +-1: its terms of degree l+1 and l-1.
double above(int l, int m, int step) { return step > 0 ? raise(l, m) : -raise(l, -m); }
double below(int l, int m, int step)
{
    if (l == 0) return 0;
    return step > 0 ? -raise(l - 1, -m - 1) : raise(l - 1, m - 1);
}

/// x Y_lm or y Y_lm. Azimuths multiply by product formulas such as cos a cos b = (cos(a+b) + cos(a-b)) / 2. Every
/// target order is therefore |m| + 1 or |m| - 1, and may change from cosine (m >= 0) to sine (m < 0).
void add_transverse(int degree, int l, int m, bool is_y, std::vector<double>& matrix)
{
    const int n = harmonic_count(degree), order = std::abs(m);
    const bool sine = m < 0;
    for (int step : {+1, -1}) {
        const int to = order + step;
        if (to < 0) continue;
        // sin(phi) cos(m phi) = (sin(m+1) - sin(m-1)) / 2;  sin(phi) sin(m phi) = (cos(m-1) - cos(m+1)) / 2
        const bool to_sine = sine != is_y;
        double weight = 0.5;
        if (is_y && (sine ? step > 0 : step < 0)) weight = -0.5;
        if (to_sine && to == 0) continue;
        if (order == 0) weight = step > 0 ? 1.0 : 0.0;  // cos(0) cos(phi) is one term, not two halves
        weight *= (order > 0 ? std::sqrt(2.0) : 1.0) / (to > 0 ? std::sqrt(2.0) : 1.0);
        const int column = harmonic(l, m);
        if (l + 1 <= degree) matrix[harmonic(l + 1, to_sine ? -to : to) * n + column] += weight * above(l, order, step);
        if (l >= 1 && to <= l - 1)
            matrix[harmonic(l - 1, to_sine ? -to : to) * n + column] += weight * below(l, order, step);
    }
}

}  // namespace

std::vector<double> direction_coupling(int degree, int axis)
{
    const int n = harmonic_count(degree);
    std::vector<double> matrix(size_t(n) * n, 0.0);
    for (int l = 0; l <= degree; ++l)
        for (int m = -l; m <= l; ++m) {
            if (axis < 2) {
                add_transverse(degree, l, m, axis == 1, matrix);
                continue;
            }
            if (l + 1 <= degree) matrix[harmonic(l + 1, m) * n + harmonic(l, m)] = a(l, m);
            if (std::abs(m) <= l - 1) matrix[harmonic(l - 1, m) * n + harmonic(l, m)] = a(l - 1, m);
        }
    return matrix;
}

const P1Closure& p1_closure()
{
    static const P1Closure closure = [] {
        const int n = harmonic_count(1);
        const auto z = direction_coupling(1, 2);
        const double to_phi = std::sqrt(4 * pi), to_flux = std::sqrt(4 * pi / 3);
        return P1Closure{z[harmonic(0, 0) * n + harmonic(1, 0)] * to_phi / to_flux,
                         z[harmonic(1, 0) * n + harmonic(0, 0)] * to_flux / to_phi};
    }();
    return closure;
}

}  // namespace vdbcloud
