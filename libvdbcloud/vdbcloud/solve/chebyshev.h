#pragma once
// The smoother of all levels. Private to solve/.

/// Two steps of the Chebyshev iteration of the fourth kind (Lottes 2022) for the spectrum [0, 2] of the Jacobi-scaled
/// matrix, which needs no estimate: a diagonally dominant symmetric matrix never leaves it. With r the scaled residual
/// D^-1 (b - A x),
///
///     x1 = x + first_step r(x),   x2 = x1 + keep (x1 - x) + second_step r(x1).
namespace vdbcloud::chebyshev {

constexpr float first_step = 2.0f / 3, keep = 0.2f, second_step = 1.2f;

}  // namespace vdbcloud::chebyshev
