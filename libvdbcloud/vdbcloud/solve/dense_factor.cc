#include "vdbcloud/solve/dense_factor.h"

#include <cmath>

namespace vdbcloud {

DenseFactor::DenseFactor(const Graph& a) : factor_(a.size() * a.size(), 0.0), work_(a.size())
{
    const size_t n = a.size();
    for (size_t i = 0; i < n; ++i) {
        factor_[i * n + i] += a.extra[i];
        for (uint32_t k = a.begin[i]; k < a.begin[i + 1]; ++k) {
            factor_[i * n + i] += a.c[k];
            factor_[i * n + size_t(a.column[k])] -= a.c[k];
        }
    }
    for (size_t j = 0; j < n; ++j) {
        const double before = factor_[j * n + j];
        double pivot = before;
        for (size_t k = 0; k < j; ++k) pivot -= factor_[j * n + k] * factor_[j * n + k];
        pivot = pivot > 1e-13 * before ? std::sqrt(pivot) : 1e150;
        factor_[j * n + j] = pivot;
        for (size_t i = j + 1; i < n; ++i) {
            double value = factor_[i * n + j];
            for (size_t k = 0; k < j; ++k) value -= factor_[i * n + k] * factor_[j * n + k];
            factor_[i * n + j] = value / pivot;
        }
    }
}

void DenseFactor::solve(const std::vector<float>& b, std::vector<float>& x)
{
    const size_t n = work_.size();
    for (size_t i = 0; i < n; ++i) {
        double value = b[i];
        for (size_t k = 0; k < i; ++k) value -= factor_[i * n + k] * work_[k];
        work_[i] = value / factor_[i * n + i];
    }
    for (size_t i = n; i-- > 0;) {
        work_[i] /= factor_[i * n + i];
        for (size_t k = 0; k < i; ++k) work_[k] -= factor_[i * n + k] * work_[i];
        x[i] = float(work_[i]);
    }
}

}  // namespace vdbcloud
