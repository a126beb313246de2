#include "vdbcloud/core/constants.h"

#include "support/slab_exact.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace vdbcloud::test {

namespace {

/// Gauss-Legendre nodes and weights on (0, 1).
void half_range_gauss(int n, std::vector<double>& x, std::vector<double>& w)
{
    for (int i = 1; i <= n; ++i) {
        double z = std::cos(pi * (i - 0.25) / (n + 0.5)), d = 1;
        for (int k = 0; k < 50; ++k) {
            double p = 1, q = 0;
            for (int j = 1; j <= n; ++j) {
                const double r = q;
                q = p;
                p = ((2 * j - 1) * z * q - (j - 1) * r) / j;
            }
            d = n * (z * p - q) / (z * z - 1);
            z -= p / d;
        }
        x.push_back((1 - z) / 2);
        w.push_back(1 / ((1 - z * z) * d * d));
    }
}

std::vector<double> legendre(int degree, double x)
{
    std::vector<double> p{1, x};
    for (int l = 1; l < degree; ++l) p.push_back(((2 * l + 1) * x * p[l] - l * p[l - 1]) / (l + 1));
    return p;
}

/// (1 - exp(-x)) / x
double mean_of_exp(double x) { return x < 1e-12 ? 1 : -std::expm1(-x) / x; }

}  // namespace

SlabExact::SlabExact(const Options& o) : o_(o), n_(o.n), size_(o.n + 1 + int(o.view.size()))
{
    half_range_gauss(n_, mu_, w_);
    mu_.push_back(o.mu0);
    mu_.insert(mu_.end(), o.view.begin(), o.view.end());
    w_.resize(size_t(size_), 0.0);
    // The first 2 n Legendre terms of the phase function: the quadrature does not resolve more.
    const int degree = std::max(1, 2 * n_ - 1);
    forward_.resize(size_t(size_) * size_);
    backward_ = forward_;
    for (int i = 0; i < size_; ++i)
        for (int j = 0; j < size_; ++j) {
            const auto a = legendre(degree, mu_[i]), b = legendre(degree, mu_[j]);
            double same = 0, other = 0, gl = 1;
            for (int l = 0; l <= degree; ++l, gl *= o.g) {
                const double moment = o.moments.empty() ? gl : size_t(l) < o.moments.size() ? o.moments[l] : 0.0;
                const double term = (2 * l + 1) * moment * a[l] * b[l];
                same += term;
                other += l % 2 ? -term : term;
            }
            forward_[i * size_ + j] = same;
            backward_[i * size_ + j] = other;
        }
    const Layer whole = doubled_to(o.tau);
    for (int i = 0; i < size_; ++i) {
        up_top_.push_back(whole.r[i * size_ + n_] * o.mu0 / pi);
        down_bottom_.push_back(whole.t[i * size_ + n_] * o.mu0 / pi);
    }
}

SlabExact::Matrix SlabExact::product(const Matrix& a, const Matrix& b) const
{
    Matrix c(a.size(), 0.0);
    for (int i = 0; i < size_; ++i)
        for (int k = 0; k < n_; ++k) {
            const double f = 2 * a[i * size_ + k] * mu_[k] * w_[k];
            for (int j = 0; j < size_; ++j) c[i * size_ + j] += f * b[k * size_ + j];
        }
    return c;
}

SlabExact::Layer SlabExact::doubled_to(double tau) const
{
    int doublings = 0;
    double thin = tau;
    while (thin > 1e-12) {
        thin /= 2;
        ++doublings;
    }
    Layer layer{thin, Matrix(size_t(size_) * size_), Matrix(size_t(size_) * size_)};
    for (int i = 0; i < size_; ++i)
        for (int j = 0; j < size_; ++j) {
            const double in = o_.w0 * thin / (4 * mu_[i] * mu_[j]);
            layer.r[i * size_ + j] = in * backward_[i * size_ + j] * mean_of_exp(thin * (1 / mu_[i] + 1 / mu_[j]));
            layer.t[i * size_ + j] =
                in * forward_[i * size_ + j] * std::exp(-thin / mu_[j]) * mean_of_exp(thin * (1 / mu_[i] - 1 / mu_[j]));
        }
    for (int k = 0; k < doublings; ++k) layer = add(layer, layer);
    return layer;
}

SlabExact::Matrix SlabExact::reflections(const Layer& upper, const Layer& lower) const
{
    Matrix power = product(upper.r, lower.r), s = power;
    for (int k = 0; k < 64; ++k) {
        // s_2m = s_m + p^m + p^m s_m, and so on: s holds 2^k terms.
        const Matrix more = product(power, s);
        double change = 0;
        for (size_t n = 0; n < s.size(); ++n) change = std::max(change, std::abs(more[n]) / (1e-300 + std::abs(s[n])));
        for (size_t n = 0; n < s.size(); ++n) s[n] += more[n];
        if (change < 1e-15) break;
        power = product(power, power);
    }
    return s;
}

SlabExact::Layer SlabExact::add(const Layer& upper, const Layer& lower) const
{
    const Matrix s = reflections(upper, lower);
    const auto e = [&](double tau, int i) { return std::exp(-tau / mu_[i]); };
    Matrix d = product(s, upper.t);
    for (int i = 0; i < size_; ++i)
        for (int j = 0; j < size_; ++j) d[i * size_ + j] += upper.t[i * size_ + j] + s[i * size_ + j] * e(upper.tau, j);
    Matrix u = product(lower.r, d);
    for (int i = 0; i < size_; ++i)
        for (int j = 0; j < size_; ++j) u[i * size_ + j] += lower.r[i * size_ + j] * e(upper.tau, j);
    Layer sum{upper.tau + lower.tau, product(upper.t, u), product(lower.t, d)};
    for (int i = 0; i < size_; ++i)
        for (int j = 0; j < size_; ++j) {
            sum.r[i * size_ + j] += upper.r[i * size_ + j] + e(upper.tau, i) * u[i * size_ + j];
            sum.t[i * size_ + j] += e(lower.tau, i) * d[i * size_ + j] + lower.t[i * size_ + j] * e(upper.tau, j);
        }
    return sum;
}

double SlabExact::reflected() const
{
    double flux = 0;
    for (int i = 0; i < n_; ++i) flux += 2 * pi * mu_[i] * w_[i] * up_top_[i];
    return flux;
}

double SlabExact::transmitted() const
{
    double flux = 0;
    for (int i = 0; i < n_; ++i) flux += 2 * pi * mu_[i] * w_[i] * down_bottom_[i];
    return flux;
}

double SlabExact::transmitted_of_isotropic() const
{
    const Layer whole = doubled_to(o_.tau);
    double flux = 0;
    for (int i = 0; i < n_; ++i) {
        double radiance = std::exp(-o_.tau / mu_[i]) / pi;
        for (int j = 0; j < n_; ++j) radiance += whole.t[i * size_ + j] * 2 * mu_[j] * w_[j] / pi;
        flux += 2 * pi * mu_[i] * w_[i] * radiance;
    }
    return flux;
}

double SlabExact::reflected_of_isotropic() const
{
    const Layer whole = doubled_to(o_.tau);
    double flux = 0;
    for (int i = 0; i < n_; ++i)
        for (int j = 0; j < n_; ++j) flux += 4 * mu_[i] * w_[i] * whole.r[i * size_ + j] * mu_[j] * w_[j];
    return flux;
}

SlabExact::Inside SlabExact::at(double depth) const
{
    const int beam = n_;
    const auto moments = [&](const std::vector<double>& down, const std::vector<double>& up) {
        Inside in{0, 0};
        for (int i = 0; i < n_; ++i) {
            in.phi += 2 * pi * w_[i] * (down[i] + up[i]);
            in.flux += 2 * pi * w_[i] * mu_[i] * (down[i] - up[i]);
        }
        return in;
    };
    const std::vector<double> none(size_t(size_), 0.0);
    if (depth <= 0) return moments(none, up_top_);
    if (depth >= o_.tau) return moments(down_bottom_, none);
    const Layer upper = doubled_to(depth), lower = doubled_to(o_.tau - depth);
    // As in add(), only for the beam's column. Solves D = T + Ra U, U = Rb (D + beam) by the summed series.
    const Matrix s = reflections(upper, lower);
    const double direct = std::exp(-depth / o_.mu0);
    std::vector<double> down(none), up(none);
    for (int i = 0; i < size_; ++i) {
        down[i] = upper.t[i * size_ + beam] + s[i * size_ + beam] * direct;
        for (int k = 0; k < n_; ++k) down[i] += 2 * s[i * size_ + k] * mu_[k] * w_[k] * upper.t[k * size_ + beam];
    }
    for (int i = 0; i < size_; ++i) {
        up[i] = lower.r[i * size_ + beam] * direct;
        for (int k = 0; k < n_; ++k) up[i] += 2 * lower.r[i * size_ + k] * mu_[k] * w_[k] * down[k];
    }
    for (int i = 0; i < size_; ++i) {
        down[i] *= o_.mu0 / pi;
        up[i] *= o_.mu0 / pi;
    }
    return moments(down, up);
}

}  // namespace vdbcloud::test
