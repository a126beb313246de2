#include "vdbcloud/solve/dense_factor.h"

#include <Eigen/Cholesky>

#include <algorithm>
#include <numeric>

namespace vdbcloud {

namespace {

constexpr double singular = 1e-13;  // extra of a part over the diagonal: below it rounding decides

/// The last unknown of each connected part on which nothing but rounding holds the level of x.
std::vector<size_t> loose_ends(const Graph& a, const Eigen::MatrixXd& matrix)
{
    std::vector<size_t> last(a.size());  // of the part, by way of other members
    std::iota(last.begin(), last.end(), size_t(0));
    const auto end_of = [&](size_t i) {
        while (last[i] != i) i = last[i] = last[last[i]];
        return i;
    };
    for (size_t i = 0; i < a.size(); ++i)
        for (uint32_t k = a.begin[i]; k < a.begin[i + 1]; ++k) {
            const size_t p = end_of(i), q = end_of(size_t(a.column[k]));
            last[std::min(p, q)] = std::max(p, q);
        }
    std::vector<double> held(a.size(), 0.0);
    for (size_t i = 0; i < a.size(); ++i) held[end_of(i)] += a.extra[i];
    std::vector<size_t> ends;
    for (size_t i = 0; i < a.size(); ++i)
        if (end_of(i) == i && !(held[i] > singular * matrix(Eigen::Index(i), Eigen::Index(i)))) ends.push_back(i);
    return ends;
}

}  // namespace

struct DenseFactor::Factor {
    std::vector<size_t> zeros;  // unknowns held at 0
    Eigen::LLT<Eigen::MatrixXd> cholesky;
};

DenseFactor::DenseFactor(const Graph& a) : factor_(new Factor)
{
    const auto n = Eigen::Index(a.size());
    Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(n, n);
    for (size_t i = 0; i < a.size(); ++i) {
        const auto row = Eigen::Index(i);
        matrix(row, row) += a.extra[i];
        for (uint32_t k = a.begin[i]; k < a.begin[i + 1]; ++k) {
            matrix(row, row) += a.c[k];
            matrix(row, a.column[k]) -= a.c[k];
        }
    }
    factor_->zeros = loose_ends(a, matrix);
    for (const size_t i : factor_->zeros) {
        const auto row = Eigen::Index(i);
        matrix.row(row).setZero();
        matrix.col(row).setZero();
        matrix(row, row) = 1;
    }
    factor_->cholesky.compute(matrix);
}

DenseFactor::~DenseFactor() = default;

void DenseFactor::solve(const std::vector<float>& b, std::vector<float>& x)
{
    const Eigen::Index n = factor_->cholesky.rows();
    Eigen::VectorXd y = Eigen::Map<const Eigen::VectorXf>(b.data(), n).cast<double>();
    for (const size_t i : factor_->zeros) y[Eigen::Index(i)] = 0;
    factor_->cholesky.solveInPlace(y);
    for (Eigen::Index i = 0; i < n; ++i) x[size_t(i)] = float(y[i]);
}

}  // namespace vdbcloud
