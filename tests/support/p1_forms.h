#pragma once
// Closed-form solutions of the P1 equations with Marshak boundaries: the limits of the discrete solver.
#include <cmath>

namespace vdbcloud::test {

/// A slab of optical depth `tau`, lit at depth 0 by a beam. The beam has irradiance E (perpendicular to itself) and
/// cosine mu to the inward normal. Isotropic inflow has partial currents j0 at depth 0 and j1 at depth tau.
///
/// In optical depth t:  phi'' / (3 (1 - w0 g)) = (1 - w0) phi - E (w0 + q) exp(-t/mu),  q = w0 g / (1 - w0 g),
/// F = -phi' / (3 (1 - w0 g)) + q E mu exp(-t/mu); F.n = phi/2 - 2 j on both sides.
struct P1Slab {
    double tau, w0, g, E = 0, mu = 1, j0 = 0, j1 = 0;
    double k = 0, d = 0, q = 0, p = 0, a = 0, b = 0;  // set by solve()

    P1Slab(double tau_, double w0_, double g_, double E_, double mu_, double j0_ = 0, double j1_ = 0)
        : tau(tau_), w0(w0_), g(g_), E(E_), mu(mu_), j0(j0_), j1(j1_)
    {
        d = 1 / (3 * (1 - w0 * g));
        k = std::sqrt((1 - w0) / d);
        q = w0 * g / (1 - w0 * g);
        p = E == 0 ? 0 : -E * (w0 + q) / (d / (mu * mu) - (1 - w0));
        // phi = p exp(-t/mu) + a u(t) + b v(t); at each side F.n - phi/2 = -2 j.
        const double m00 = d * u_slope(0) - u(0) / 2, m01 = d * v_slope(0) - v(0) / 2;
        const double m10 = -d * u_slope(tau) - u(tau) / 2, m11 = -d * v_slope(tau) - v(tau) / 2;
        const double e0 = 1, e1 = std::exp(-tau / mu);
        const double r0 = -2 * j0 + p * e0 / 2 + d * p * e0 / mu + q * E * mu * e0;
        const double r1 = -2 * j1 + p * e1 / 2 - d * p * e1 / mu - q * E * mu * e1;
        const double det = m00 * m11 - m01 * m10;
        a = (r0 * m11 - r1 * m01) / det;
        b = (m00 * r1 - m10 * r0) / det;
    }
    // Two homogeneous solutions, scaled to order one: exp(-k t) and exp(-k (tau - t)), or 1 and t.
    bool linear() const { return k * tau < 1e-6; }
    double u(double t) const { return linear() ? 1 : std::exp(-k * t); }
    double v(double t) const { return linear() ? t : std::exp(-k * (tau - t)); }
    double u_slope(double t) const { return linear() ? 0 : -k * u(t); }
    double v_slope(double t) const { return linear() ? 1 : k * v(t); }

    double phi(double t) const { return p * std::exp(-t / mu) + a * u(t) + b * v(t); }
    /// Collided flux in the direction of increasing t.
    double flux(double t) const
    {
        const double slope = -p / mu * std::exp(-t / mu) + a * u_slope(t) + b * v_slope(t);
        return -d * slope + q * E * mu * std::exp(-t / mu);
    }
    /// Diffuse power per area that leaves at depth 0 and at depth tau (inflow not subtracted).
    double reflected() const { return -flux(0) + j0; }
    double transmitted() const { return flux(tau) + j1; }
};

/// A sphere of radius R with constant coefficients D and sigma_a, uniform source Q and isotropic inflow of phi_sky = 4
/// J.
struct P1Sphere {
    double R, D, sigma_a, Q, phi_sky;

    double phi(double r) const
    {
        if (sigma_a == 0) return Q * (R * R - r * r) / (6 * D) + 2 * Q * R / 3 + phi_sky;
        const double k = std::sqrt(sigma_a / D);
        const auto u = [k](double x) { return x > 0 ? std::sinh(k * x) / x : k; };
        const double slope = k * std::cosh(k * R) / R - std::sinh(k * R) / (R * R);
        const double w = u(R) + 2 * D * slope;
        return Q / sigma_a * (1 - u(r) / w) + phi_sky * u(r) / w;
    }
};

}  // namespace vdbcloud::test
