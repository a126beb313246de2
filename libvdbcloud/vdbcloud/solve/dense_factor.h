#pragma once
// The coarsest level of the multigrid, solved directly. Private to solve/.
#include "vdbcloud/solve/graph.h"

#include <memory>

namespace vdbcloud {

/// Cholesky factors of a graph's operator, in double. If it is singular (nothing absorbs or leaves), the last unknown
/// of each connected part is held at 0.
class DenseFactor {
public:
    explicit DenseFactor(const Graph&);
    ~DenseFactor();
    /// x = A^-1 b. Values of b and x beyond the unknowns are left alone.
    void solve(const std::vector<float>& b, std::vector<float>& x);

private:
    struct Factor;
    std::unique_ptr<Factor> factor_;
};

}  // namespace vdbcloud
