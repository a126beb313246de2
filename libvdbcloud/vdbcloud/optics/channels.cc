#include "vdbcloud/optics/channels.h"

#include "vdbcloud/core/vdb.h"

#include <cmath>

namespace vdbcloud {

bool same_channels(const Vec3d& v) { return v[0] == v[1] && v[1] == v[2]; }

bool same_channels(const Vec3SGrid* grid)
{
    if (!grid) return true;
    for (auto v = grid->cbeginValueOn(); v; ++v)
        if ((*v)[0] != (*v)[1] || (*v)[1] != (*v)[2]) return false;
    return true;
}

std::optional<double> multiple(const std::vector<double>& a, const std::vector<double>& b)
{
    double x = -1;
    for (size_t k = 0; k < a.size(); ++k)
        if (a[k] != 0) x = b[k] / a[k];
    if (x < 0) return std::nullopt;
    for (size_t k = 0; k < a.size(); ++k)
        if (std::abs(b[k] - x * a[k]) > 1e-14 * std::abs(b[k])) return std::nullopt;
    return x;
}

bool grey_extinction(const Medium& medium, bool tinted, double delta_f)
{
    if (!medium.grey()) return false;
    return delta_f == 0 || (same_channels(medium.albedo) && !tinted);
}

}  // namespace vdbcloud
