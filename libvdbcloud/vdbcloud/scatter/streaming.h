#pragma once
// How far light flies in the medium, as a bound of P1's diffusion where it is thin. Private to scatter/.
#include "vdbcloud/scatter/p1_problem.h"
#include "vdbcloud/scatter/second_moment.h"

namespace vdbcloud {

constexpr int streaming_directions = 16;

/// Factor of P1's D for each slot, at most 1: D = 1 / (3 sigma_tr), but not above 10/3 l, l the mean over
/// all directions of the length that light has come through the medium,
///
///     l = 1 / (4 pi) int dOmega int e^-tau(s) ds
///
/// Deep in a medium l is 1 / sigma_tr, at its surface half of that: D is P1's. In a clear duct l is a few widths of the
/// duct where 1 / sigma_tr is thousands, and P1 carries light to the duct's far end as if nothing were in the way. What
/// sweeps correct by P1's matrix (second_moment.h) must not go there: dark places would get negative fluence.
///
/// Cost: one sweep of streaming_directions.
/// Source: Larsen & Trahan 2009 take D from the same integral, as a tensor; the bound: none, measured on shields with
/// ducts.
std::vector<float> streaming_limit(const P1Cells&, const OrdinateFrame&);

}  // namespace vdbcloud
