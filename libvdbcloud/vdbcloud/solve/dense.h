#pragma once
// Small dense systems of equations, solved directly.
#include <cstddef>
#include <memory>
#include <vector>

namespace vdbcloud {

/// Factors P^T L D L^T P of a symmetric positive semidefinite matrix, with D in falling order. Where an entry of D is
/// at most `dependent` times the matrix's own diagonal entry, its unknown depends on those before it: its value is held
/// at 0. So a singular operator (nothing absorbs or leaves) loses one unknown of each connected part, and a least
/// squares problem the vectors that add nothing new.
class SemidefiniteFactor {
public:
    /// `a`: n x n values, row by row; only the lower triangle is read. n may be 0.
    SemidefiniteFactor(const std::vector<double>& a, size_t n, double dependent);
    ~SemidefiniteFactor();
    SemidefiniteFactor(SemidefiniteFactor&&) noexcept;

    /// x with a x = b; `b` has n values. Any number of threads may call it.
    std::vector<double> solve(const std::vector<double>& b) const;

private:
    struct Factor;
    std::unique_ptr<Factor> factor_;
};

/// x with a x = b for any regular matrix of b.size()^2 values, row by row, by elimination with row exchange.
std::vector<double> solve_dense(const std::vector<double>& a, const std::vector<double>& b);

}  // namespace vdbcloud
