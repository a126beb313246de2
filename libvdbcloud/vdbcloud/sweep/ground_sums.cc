#include "vdbcloud/sweep/ground_sums.h"

#include "vdbcloud/core/constants.h"

#include <cmath>

namespace vdbcloud {

namespace {

int64_t wrapped(int64_t k, int64_t size) { return (k % size + size) % size; }

}  // namespace

GroundSums::GroundSums(const Blocks& blocks, SweepGround& ground)
    : box_(blocks), to_(ground), sum_(box_.cells(ground.face), 0.0), radiance_(sum_.size(), 0.0)
{
    const auto [u, v] = ActiveBox::axes(ground.face / 2);
    u_ = u;
    v_ = v;
    plane_ = ground.face % 2 ? box_.last[ground.face / 2] + 1 : box_.first[ground.face / 2] - 1;
}

void GroundSums::reflect()
{
    to_.irradiance.resize(sum_.size());
    for (size_t n = 0; n < sum_.size(); ++n) {
        const double diffuse = unit_ > 0 ? sum_[n] * pi / unit_ : 0;
        to_.irradiance[n] = float(diffuse);
        radiance_[n] = to_.albedo / pi * (diffuse + to_.direct[n]);
    }
}

double GroundSums::radiance(const Vec3d& point, const Vec3d& step) const
{
    const double back = (point[to_.face / 2] - plane_) / step[to_.face / 2];
    const double pu = point[u_] - back * step[u_] - box_.first[u_], pv = point[v_] - back * step[v_] - box_.first[v_];
    const double iu = std::floor(pu), iv = std::floor(pv), fu = pu - iu, fv = pv - iv;
    double sum = 0;
    for (int n = 0; n < 4; ++n) {
        const double weight = (n & 1 ? fu : 1 - fu) * (n & 2 ? fv : 1 - fv);
        if (weight == 0) continue;
        const int64_t x = wrapped(int64_t(iu) + (n & 1), box_.size(u_)),
                      y = wrapped(int64_t(iv) + (n >> 1), box_.size(v_));
        sum += weight * radiance_[size_t(x * box_.size(v_) + y)];
    }
    return sum;
}

}  // namespace vdbcloud
