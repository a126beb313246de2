#pragma once
// Where conjugate gradients start.
#include "vdbcloud/solve/stencil.h"

#include <vector>

namespace vdbcloud {

/// Replaces x (0 if empty) by the combination of x and `fields` with the least error of A x = b in the energy norm.
/// Costs one product with the matrix for each of them. All are 0 at inactive slots. No change where values are beyond
/// double.
void improve_guess(const Stencil&, const std::vector<double>& b, const std::vector<const std::vector<float>*>& fields,
                   std::vector<double>& x);

}  // namespace vdbcloud
