#include "vdbcloud/sweep/void_pieces.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

void VoidPieces::find(const Vec3i& at, const Corner& lo, const Corner& hi, const Vec3d& step,
                      std::vector<VoidPiece>& to)
{
    origin_ = Vec3d(8.0 * at[0], 8.0 * at[1], 8.0 * at[2]);
    step_ = step;
    std::fill(traced_.begin(), traced_.end(), 0);
    split(lo, hi, to);
}

const VoidRays::Hit& VoidPieces::trace(const Corner& c)
{
    const size_t k = size_t(c[0] * 64 + c[1] * 8 + c[2]);
    if (!traced_[k]) {
        hits_[k] = rays_.trace(origin_ + Vec3d(c[0], c[1], c[2]), step_);
        traced_[k] = 1;
    }
    return hits_[k];
}

void VoidPieces::split(const Corner& lo, const Corner& hi, std::vector<VoidPiece>& to)
{
    const VoidRays::Hit first = trace(lo);
    VoidPiece piece{first.block, uint8_t(first.axes), {}, {}, {first.at[0], first.at[1], first.at[2]}};
    for (size_t a = 0; a < 3; ++a) {
        piece.lo[a] = uint8_t(lo[a]);
        piece.hi[a] = uint8_t(hi[a]);
    }
    const bool single = lo == hi, on_edge = first.block >= 0 && first.axes & (first.axes - 1);
    bool one = single || !on_edge;
    for (int n = 1; n < 8 && one && !single; ++n) {
        Corner corner = lo;
        for (int a = 0; a < 3; ++a)
            if (n >> a & 1) corner[size_t(a)] = hi[size_t(a)];
        const VoidRays::Hit& hit = trace(corner);
        one = hit.block == first.block && (hit.block < 0 || hit.axes == first.axes);
        if (!one || hit.block < 0) continue;
        std::array<double, 3> expected = piece.at;
        const int axis = piece.axes >> 1;  // 1, 2, 4: 0, 1, 2
        for (int k = 0; k < 3; ++k)
            for (int a = 0; a < 3; ++a)
                expected[size_t(a)] += void_slope(step_, axis, a, k) * (corner[size_t(k)] - lo[size_t(k)]);
        for (size_t a = 0; a < 3; ++a) one = one && std::abs(hit.at[a] - expected[a]) < 1e-3;
    }
    if (one) {
        to.push_back(piece);
        return;
    }
    size_t longest = 0;
    for (size_t a = 1; a < 3; ++a)
        if (hi[a] - lo[a] > hi[longest] - lo[longest]) longest = a;
    const int middle = (lo[longest] + hi[longest]) / 2;
    Corner lower_hi = hi, upper_lo = lo;
    lower_hi[longest] = middle;
    upper_lo[longest] = middle + 1;
    split(lo, lower_hi, to);
    split(upper_lo, hi, to);
}

}  // namespace vdbcloud
