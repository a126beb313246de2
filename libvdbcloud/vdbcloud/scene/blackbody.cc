#include "vdbcloud/scene/blackbody.h"

#include "vdbcloud/core/vdb.h"
#include "vdbcloud/scene/atmosphere.h"
#include "vdbcloud/scene/colour.h"

#include <algorithm>
#include <cmath>

namespace vdbcloud {

namespace {

constexpr double first_wavelength = 380, last_wavelength = 780, step = 10;  // [nm]
constexpr double bulk = 23000;     // [K]: near h c / (k lambda) of the light that matters
constexpr double table_end = 1e5;  // [K]: no table above
constexpr double nodes_an_e_fold = 400;

Vec3d in_units(const Vec3d& xyz) { return rec709_of_xyz(xyz) * (luminous_efficacy * 1e-3 / unit_of_light()); }

}  // namespace

double planck(double wavelength, double temperature)
{
    if (!(temperature > 0)) return 0;
    constexpr double h = 6.62607015e-34, c = 299792458, k = 1.380649e-23;
    const double metres = wavelength * 1e-9, x = h * c / (metres * k * temperature);
    return 2 * h * c * c / (std::pow(metres, 5) * std::expm1(x)) * 1e-9;
}

Vec3d blackbody_xyz(double temperature)
{
    Vec3d xyz(0.0);
    for (double l = first_wavelength; l <= last_wavelength; l += step)
        xyz += step * planck(l, temperature) * colour_matching(l);
    return xyz;
}

Vec3d blackbody(double temperature)
{
    return temperature >= coldest_light ? in_units(blackbody_xyz(temperature)) : Vec3d(0.0);
}

BlackbodyTable::BlackbodyTable(double hottest)
{
    const double end = std::min(std::max(hottest, 2 * coldest_light), table_end);
    const double span = std::log(end / coldest_light);
    const auto nodes = size_t(std::ceil(nodes_an_e_fold * span)) + 1;
    step_ = span / double(nodes - 1);
    for (size_t n = 0; n < nodes; ++n) {
        const double t = coldest_light * std::exp(step_ * double(n));
        const Vec3d xyz = blackbody_xyz(t);
        values_.emplace_back(Vec3d(std::log(xyz[0]), std::log(xyz[1]), std::log(xyz[2])) + Vec3d(bulk / t));
    }
}

Vec3d BlackbodyTable::operator()(double temperature) const
{
    if (!(temperature >= coldest_light)) return Vec3d(0.0);
    const double at = std::log(temperature / coldest_light) / step_;
    if (at > double(values_.size() - 1)) return blackbody(temperature);
    const size_t below = std::min(size_t(at), values_.size() - 2);
    const double share = at - double(below);
    const Vec3d v = values_[below] + share * (values_[below + 1] - values_[below]) - Vec3d(bulk / temperature);
    return in_units(Vec3d(std::exp(v[0]), std::exp(v[1]), std::exp(v[2])));
}

}  // namespace vdbcloud
