#include "vdbcloud/scatter/mixing.h"

#include "vdbcloud/solve/dense.h"
#include "vdbcloud/solve/parallel.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr size_t piece = 4096;     // values per partial sum
constexpr double parallel = 1e-8;  // squared sine below which a difference counts as dependent

double relative(double change, double size)  // of squares
{
    return size > 0 ? std::sqrt(change / size) : change > 0 ? 1.0 : 0.0;
}

size_t pieces(size_t length) { return (length + piece - 1) / piece; }

}  // namespace

Mixing::Mixing(size_t length, size_t arrays, int depth) : length_(length), arrays_(arrays), depth_(depth) {}

double Mixing::product(const Arrays& a, const Arrays& b) const
{
    const size_t count = pieces(length_);
    return ordered_sum(count * arrays_, [&](size_t n) {
        const float* u = a[n / count].data();
        const float* v = b[n / count].data();
        const size_t first = n % count * piece, last = std::min(first + piece, length_);
        double sum = 0;
        for (size_t k = first; k < last; ++k) sum += double(u[k]) * v[k];
        return sum;
    });
}

void Mixing::subtract(const Arrays& a, Arrays& from_b) const
{
    const size_t count = pieces(length_);
    for_ranges(count * arrays_, [&](size_t first, size_t last) {
        for (size_t n = first; n < last; ++n) {
            const float* u = a[n / count].data();
            float* v = from_b[n / count].data();
            for (size_t k = n % count * piece; k < std::min((n % count + 1) * piece, length_); ++k) v[k] = u[k] - v[k];
        }
    });
}

std::vector<double> Mixing::coefficients() const
{
    const size_t n = df_.size();
    std::vector<double> a(n * n, 0.0), b(n, 0.0), scale(n, 0.0);
    for (size_t i = 0; i < n; ++i) {
        for (size_t j = 0; j <= i; ++j) a[i * n + j] = a[j * n + i] = product(df_[i], df_[j]);
        b[i] = product(df_[i], f_);
        if (a[i * n + i] > 0) scale[i] = 1 / std::sqrt(a[i * n + i]);
    }
    for (size_t i = 0; i < n; ++i) {
        b[i] *= scale[i];
        for (size_t j = 0; j < n; ++j) a[i * n + j] *= scale[i] * scale[j];
    }
    // Least squares min || f - sum c_i d_i ||, scaled so that the diagonal of d.d is 1.
    auto c = SemidefiniteFactor(a, n, parallel).solve(b);
    for (size_t i = 0; i < n; ++i) c[i] *= scale[i];
    return c;
}

void Mixing::forget()
{
    f_ = g_ = {};
    df_ = dg_ = {};
}

void Mixing::before(const Arrays& x) { x_.assign(x.begin(), x.begin() + long(arrays_)); }

double Mixing::change(const Arrays& g) const
{
    const size_t count = pieces(length_);
    const auto square = [&](const auto& value) {
        return ordered_sum(count * arrays_, [&](size_t n) {
            double sum = 0;
            for (size_t k = n % count * piece; k < std::min((n % count + 1) * piece, length_); ++k) {
                const double v = value(n / count, k);
                sum += v * v;
            }
            return sum;
        });
    };
    const double size = square([&](size_t array, size_t k) { return g[array][k]; });
    const double change = square([&](size_t array, size_t k) { return g[array][k] - x_[array][k]; });
    return relative(change, size);
}

double Mixing::after(const Arrays& g)
{
    subtract(g, x_);  // now G(x) - x
    if (!f_.empty() && depth_ > 0) {
        subtract(x_, f_);
        subtract(g, g_);
        df_.insert(df_.begin(), std::move(f_));
        dg_.insert(dg_.begin(), std::move(g_));
        if (int(df_.size()) > depth_) {
            df_.pop_back();
            dg_.pop_back();
        }
    }
    f_ = std::move(x_);
    g_.assign(g.begin(), g.begin() + long(arrays_));
    const double size = product(g_, g_), change = product(f_, f_);
    return relative(change, size);
}

void Mixing::next(Arrays& g) const
{
    const auto c = coefficients();
    const size_t count = pieces(length_);
    for_ranges(count * arrays_, [&](size_t first, size_t last) {
        for (size_t n = first; n < last; ++n)
            for (size_t j = 0; j < c.size(); ++j) {
                const float* d = dg_[j][n / count].data();
                float* to = g[n / count].data();
                for (size_t k = n % count * piece; k < std::min((n % count + 1) * piece, length_); ++k)
                    to[k] -= float(c[j] * d[k]);
            }
    });
}

}  // namespace vdbcloud
