#include "vdbcloud/solve/dense.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace vdbcloud {

namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Vector = Eigen::VectorXd;

Eigen::Map<const Matrix> matrix(const std::vector<double>& a, size_t n)
{
    return {a.data(), Eigen::Index(n), Eigen::Index(n)};
}

Eigen::Map<const Vector> vector(const std::vector<double>& v) { return {v.data(), Eigen::Index(v.size())}; }

}  // namespace

struct SemidefiniteFactor::Factor {
    Eigen::LDLT<Matrix> ldlt;
    Vector inverse;  // of D, 0 for a dependent unknown
};

SemidefiniteFactor::SemidefiniteFactor(const std::vector<double>& a, size_t n, double dependent)
    : factor_(new Factor{Eigen::LDLT<Matrix>(Eigen::Index(n)), Vector::Zero(Eigen::Index(n))})
{
    if (n == 0) return;
    factor_->ldlt.compute(matrix(a, n));
    const Vector pivot = factor_->ldlt.vectorD(), diagonal = factor_->ldlt.transpositionsP() * matrix(a, n).diagonal();
    for (Eigen::Index k = 0; k < pivot.size(); ++k)
        if (pivot[k] > dependent * diagonal[k]) factor_->inverse[k] = 1 / pivot[k];
}

SemidefiniteFactor::~SemidefiniteFactor() = default;
SemidefiniteFactor::SemidefiniteFactor(SemidefiniteFactor&&) noexcept = default;

std::vector<double> SemidefiniteFactor::solve(const std::vector<double>& b) const
{
    if (b.empty()) return {};
    // LDLT::solve() divides by every pivot that is not exactly 0, so the steps are taken here.
    const auto& ldlt = factor_->ldlt;
    std::vector<double> x(b.size());
    Vector y = ldlt.transpositionsP() * vector(b);
    ldlt.matrixL().solveInPlace(y);
    y = y.cwiseProduct(factor_->inverse);
    ldlt.matrixU().solveInPlace(y);
    Eigen::Map<Vector>(x.data(), y.size()) = ldlt.transpositionsP().transpose() * y;
    return x;
}

std::vector<double> solve_dense(const std::vector<double>& a, const std::vector<double>& b)
{
    if (b.empty()) return {};
    std::vector<double> x(b.size());
    Eigen::Map<Vector>(x.data(), Eigen::Index(x.size())) = matrix(a, b.size()).partialPivLu().solve(vector(b));
    return x;
}

}  // namespace vdbcloud
