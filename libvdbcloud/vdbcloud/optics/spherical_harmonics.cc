#include "vdbcloud/optics/spherical_harmonics.h"

#include "vdbcloud/core/constants.h"

#include <cmath>

namespace vdbcloud {

namespace {

/// cos(theta) P_lm = a(l, m) P_{l+1,m} + a(l-1, m) P_{l-1,m} for normalised associated Legendre functions.
double a(int l, int m) { return std::sqrt(((l + 1.0) * (l + 1.0) - m * m) / ((2 * l + 1.0) * (2 * l + 3.0))); }

}  // namespace

void evaluate_harmonics(int degree, const Vec3d& s, double* y)
{
    // Normalised P_mm by recursion in m, then upwards in l; cos(m phi) sin^m(theta) as the real part of (x + i y)^m,
    // so that the poles need no special case.
    double cosine = 1, sine = 0, diagonal = std::sqrt(1 / (4 * pi));
    for (int m = 0; m <= degree; ++m) {
        if (m > 0) {
            const double c = cosine * s.x() - sine * s.y();
            sine = cosine * s.y() + sine * s.x();
            cosine = c;
            diagonal *= std::sqrt((2 * m + 1.0) / (2 * m));
        }
        double before = 0, now = diagonal;
        for (int l = m; l <= degree; ++l) {
            const double scale = m > 0 ? std::sqrt(2.0) * now : now;
            y[harmonic(l, m)] = scale * cosine;
            if (m > 0) y[harmonic(l, -m)] = scale * sine;
            const double next = (s.z() * now - (l > m ? a(l - 1, m) * before : 0.0)) / a(l, m);
            before = now;
            now = next;
        }
    }
}

}  // namespace vdbcloud
